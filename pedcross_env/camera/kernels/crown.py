"""Crowns of trees and bushes: textures of leaves that face the camera.

A crown is far finer than a pixel nearly everywhere. It is drawn from a texture made once (see scenery.foliage) by its exact mean
over each pixel, by running sums down and along it. So a picture is the mean of any finer one. For the same reason the light on its leaves
is linear in what the texture holds: the light on the mean leaf is the mean of the light on the leaves.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import LANES, entry, inlined, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM_POSITION,
    ENV_BEAM_TINT,
    ENV_BETA,
    ENV_SNOW,
    ENV_SUN,
    ENV_SUN_DIRECTION,
    ENV_UP,
    SNOW,
    head_irradiance,
    light_field,
)  # fmt: skip
from pedcross_env.camera.kernels.polygons import grow
from pedcross_env.camera.kernels.rows import F0, F1

__all__ = ["BORDER", "TEXTURE_CHANNELS", "draw_crown", "splat_leaves"]

TEXTURE_CHANNELS = 5  # cover, tone, and times the tone: the normal to the right, downwards and away
BORDER = 2  # nodes of the running sums before the texture's edge
# leaves are translucent: light passes round them (the best line through the clamped cosine over leaves of every tilt)
SUN_ROUND, SUN_FACING = 0.36, 0.50
# share of a leaf that faces up which lying snow hides at the crown's top; below, leaves shelter each other. Our estimate
SNOW_LIES = 0.9
SNOW_DEPTH = 1.6  # how far below its top, in half heights of a dense crown, the snow ends
EMPTY = np.float32(1e-4)  # more than what rounding leaves where there is nothing
FINE = 4.0  # texels per column from which the next coarser texture does: it blurs by a quarter of a pixel at most
MANY = 2.0  # texels per column and per row from which each has little to do with what is seen
LUMA = (0.2126, 0.7152, 0.0722)


@entry
def splat_leaves(leaves, image):
    """Paint leaves over each other, in their order.

    Args:
        leaves: (N, 8) column, row, half length, half width (texels), angle, tone, normal to the right, normal downwards.
        image: (S, S, TEXTURE_CHANNELS) float32, changed; leaves show the side that faces the camera.
    """
    size = image.shape[0]
    for k in range(leaves.shape[0]):
        leaf = leaves[k]
        tone, right, down = np.float32(leaf[5]), np.float32(leaf[6]), np.float32(leaf[7])
        away = -np.sqrt(max(F0, F1 - right * right - down * down))
        reach = max(leaf[2], leaf[3]) + 1.0
        c, s = math.cos(leaf[4]), math.sin(leaf[4])
        for row in range(max(0, int(leaf[1] - reach)), min(size, int(leaf[1] + reach) + 2)):
            for column in range(max(0, int(leaf[0] - reach)), min(size, int(leaf[0] + reach) + 2)):
                x, y = column + 0.5 - leaf[0], row + 0.5 - leaf[1]
                p, q = (c * x + s * y) / leaf[2], (c * y - s * x) / leaf[3]
                d = math.sqrt(p * p + q * q)
                a = np.float32(min(1.0, max(0.0, (1.0 - d) * min(leaf[2], leaf[3]) + 0.5)))
                if a <= F0:
                    continue
                texel = image[row, column]
                texel[0] += a * (F1 - texel[0])
                texel[1] += a * (tone - texel[1])
                texel[2] += a * (tone * right - texel[2])
                texel[3] += a * (tone * down - texel[3])
                texel[4] += a * (tone * away - texel[4])


@kernel
def _light_crown(centre, albedo, snow, env, lamps, beams, table, work):
    """Fill ``light`` (C, 4), constant and gradient over the normal, and ``heads`` (C, 2), for the crown's middle.

    ``snow`` is the share of what faces up that lying snow hides.

    No leaf has less than no light, whichever way it faces: where the line through the sun's light would fall below zero, it is
    flatter.
    """
    field, light, heads, _, head = work[1:6]
    channels = light.shape[0]
    light_field(centre, env, lamps, beams, table, field)
    beam = head_irradiance(centre, env, table, env[ENV_BETA])
    away = 1e-9
    for k in range(3):
        away += (env[ENV_BEAM_POSITION + k] - centre[k]) ** 2
    for k in range(3):
        head[k] = (env[ENV_BEAM_POSITION + k] - centre[k]) / math.sqrt(away)
    for c in range(channels):
        for k in range(4):
            light[c, k] = 0
        heads[c, 0] = 0
    for c in range(3):
        weight = 1.0 if channels == 3 else LUMA[c]
        rho, o = weight * albedo[c] / math.pi, c if channels == 3 else 0
        field[c, 0] += SUN_ROUND * env[ENV_SUN + c]
        # snow lies on leaves the more, the more they face up
        white = weight * 0.5 * SNOW_LIES * snow * (SNOW[c] - albedo[c]) / math.pi
        rho += white
        squared = 1e-30
        for k in range(3):
            field[c, 1 + k] += SUN_FACING * env[ENV_SUN + c] * env[ENV_SUN_DIRECTION + k]
            field[c, 1 + k] += white / rho * env[ENV_UP + k] * field[c, 0]
            squared += field[c, 1 + k] * field[c, 1 + k]
        flatter = min(1.0, field[c, 0] / math.sqrt(squared))
        light[o, 0] += rho * field[c, 0]
        for k in range(3):
            light[o, 1 + k] += rho * flatter * field[c, 1 + k]
        heads[o, 0] += rho * beam * env[ENV_BEAM_TINT + c]


@kernel
def _edges_of_columns(start, step, size, nodes, weights):
    """Fill where each edge between columns lies in a row of the sums: its middle node of three, the weights of the three.

    Their weighted sum is the mean of the running sums' line over one texel, so that a magnified texture is interpolated and a
    minified one is averaged, by one formula.

    Args:
        start: Texels, the first edge.
        step: Texels per column.
        size: Texels along a row.
        nodes: (E,) uint64, filled; unsigned, since numba lets a negative index count from the end.
        weights: (3, >= E) float32, filled.
    """
    for i in range(nodes.shape[0]):
        x = min(max(start + step * i, -0.5), size + 0.5) + (BORDER + 0.5)
        node = int(x)
        f = x - node
        left, right = 0.5 * (1.0 - f) * (1.0 - f), 0.5 * f * f
        nodes[i] = np.uint64(node)
        weights[0, i], weights[1, i], weights[2, i] = (
            np.float32(left),
            np.float32(1.0 - left - right),
            np.float32(right),
        )


@inlined
def _place(row, across):
    """Where an edge of a row of pixels (texels from the texture's edge) lies in its rows, a BORDER and a half added."""
    return min(max(row, -0.5), across - 2 * BORDER - 0.5) + (BORDER + 0.5)


@kernel
def _between(top0, top1, top2, bottom0, bottom1, bottom2, above, below, above2, below2, added):
    """Fill the difference between two lines across the sums; see ``_sums_row``.

    Each line's sums are those at its middle node and small steps from there: the large numbers are whole ones, whose difference is
    exact.
    """
    for k in range(added.shape[0]):
        start = below * (top2[k] - top1[k]) - above * (top1[k] - top0[k])
        end = below2 * (bottom2[k] - bottom1[k]) - above2 * (bottom1[k] - bottom0[k])
        added[k] = (bottom1[k] - top1[k]) + (end - start)


@kernel
def _between_many(top0, top1, bottom0, bottom1, part, part2, added):
    """Fill the same with either line's sums on the straight line between its two nodes."""
    for k in range(added.shape[0]):
        start, end = part * (top1[k] - top0[k]), part2 * (bottom1[k] - bottom0[k])
        added[k] = (bottom0[k] - top0[k]) + (end - start)


@kernel
def _sums_row(sums, top, bottom, low, high, many, added):
    """Fill the sums along a row of pixels, which reaches from ``top`` to ``bottom`` (see ``_place``), at nodes ``low`` to ``high``.

    Either line's sums are the mean over one texel, as in ``_edges_of_columns``; or, where a pixel has ``many`` texels and none
    is seen by itself, those on the line, for two thirds of the fetches.
    """
    across = sums.shape[1] // TEXTURE_CHANNELS
    if many:
        top, bottom = top - 0.5, bottom - 0.5
        t, b = int(top), int(bottom)
        for channel in range(TEXTURE_CHANNELS):
            i, j = channel * across + low, channel * across + high
            _between_many(
                sums[t, i:j], sums[t + 1, i:j], sums[b, i:j], sums[b + 1, i:j], np.float32(top - t), np.float32(bottom - b), added[i:j]
            )  # fmt: skip
        return
    t, b = int(top), int(bottom)
    above, below = np.float32(0.5 * (1.0 - top + t) ** 2), np.float32(0.5 * (top - t) ** 2)
    above2, below2 = np.float32(0.5 * (1.0 - bottom + b) ** 2), np.float32(0.5 * (bottom - b) ** 2)
    for channel in range(TEXTURE_CHANNELS):
        i, j = channel * across + low, channel * across + high
        _between(
            sums[t - 1, i:j], sums[t, i:j], sums[t + 1, i:j], sums[b - 1, i:j], sums[b, i:j], sums[b + 1, i:j], above, below,
            above2, below2, added[i:j],
        )  # fmt: skip


@kernel
def _reached(bounds, top, bottom, start, step, n):
    """Columns (of n) in which rows of texels have leaves."""
    low, high = bounds.shape[0] + 0.0, 0.0
    for row in range(int(top), int(bottom) + 2):
        low, high = min(low, bounds[row, 0]), max(high, bounds[row, 1])
    if high <= low:
        return 0, 0
    left, right = (low - BORDER - 1.0 - start) / step, (high - BORDER + 1.0 - start) / step
    if step < 0.0:
        left, right = right, left
    return max(0, int(math.floor(max(left, -1.0)))), min(n, int(math.ceil(min(right, n + 1.0))))


@kernel
def _lit(light, tone, right, down, away, out):
    l0, l1, l2, l3 = np.float32(light[0]), np.float32(light[1]), np.float32(light[2]), np.float32(light[3])
    for k in range(out.shape[0]):
        out[k] = l0 * tone[k] + l1 * right[k] + l2 * down[k] + l3 * away[k]


@kernel
def _columns(line, nodes, left, middle, right, share, out):
    """Fill what of a row's ``line`` lies between the edges of each column, times ``share``."""
    one = np.uint64(1)
    k = nodes[0]
    last = left[0] * line[k - one] + middle[0] * line[k] + right[0] * line[k + one]
    for i in range(out.shape[0]):
        e = i + 1
        k = nodes[e]
        now = left[e] * line[k - one] + middle[e] * line[k] + right[e] * line[k + one]
        out[i] = share * (now - last)
        last = now


@kernel
def _settle_cover(cover, depth_inverse, inverse):
    for i in range(cover.shape[0]):
        covered = cover[i] > EMPTY
        inverse[i] = depth_inverse if covered else F0
        cover[i] = min(F1, cover[i]) if covered else F0


@kernel
def _settle(cover, plane):
    for i in range(cover.shape[0]):
        plane[i] = max(F0, plane[i]) if cover[i] > F0 else F0


@kernel
def _crown_light(light, heads, head, flip, out):
    """Fill (C, 4): radiance per tone, and per tone times the normal's three directions."""
    for c in range(out.shape[0]):
        out[c, 0] = light[c, 0]
        for k in range(3):
            out[c, 1 + k] = light[c, 1 + k] + heads[c, 0] * head[k]
        out[c, 1] *= flip


@inlined
def _sheltered(down):
    """How much less snow lies at a height in the crown than at its top: 0 there, 1 where the leaves above keep all of it.

    ``down`` is counted from the top in half heights.
    """
    part = min(1.0, max(0.0, down / SNOW_DEPTH))
    return part * part * (3.0 - 2.0 * part)


@kernel
def draw_crown(crown, centre, textures, env, lamps, beams, table, optics, size, scratch, work, spans):
    """Draw a crown into its object's scratch planes, which hold nothing yet.

    Args:
        crown: (9,) texture, centre (world), half width (negative: mirrored), half height (metres), albedo r, g, b.
        centre: (3,) camera coordinates.
        textures: Those of scenery.foliage.CrownTextures; work space: (5 M,) float32 of a row of pixels and as much of its light; columns'
            edges, (>= W + 1,) uint64 and (3, >= W + 1) float32; (3, 3, 4).
        env: See kernels.lighting.
        lamps: (L, 3) camera coordinates.
        beams: (B, 13).
        table: Low-beam candela.
        optics: (focal, cx, cy).
        size: (height, width).
        scratch: (planes (C, H, W), coverage, inverse depth).
        work: From scene._capsule_work.
        spans: What the object covers, see ``polygons.grow``.
    """
    focal, cx, cy = optics
    height, width = size
    planes, alpha, inverse = scratch
    levels, units, bounds, gaps, added, lit, nodes, weights, radiance = textures
    half_w, half_h = abs(crown[4]), crown[5]
    z = centre[2]
    # beside the camera a flat crown would turn into a wall: it thins out before
    fade = min(1.0, max(0.0, z / half_w - 0.4))
    if fade <= 0.0:
        return
    rx, ry = focal * half_w / z, focal * half_h / z
    u0, v0 = cx + focal * centre[0] / z, cy + focal * centre[1] / z
    level, finer = 0, 0.5 * (levels[0].shape[1] - 2 * BORDER - 1) / rx
    while finer >= 2.0 * FINE and level < len(levels) - 1:
        level, finer = level + 1, 0.5 * finer
    leaves, reach = levels[level][int(crown[0])], bounds[level][int(crown[0])]
    across, stride = leaves.shape[0], leaves.shape[1] // TEXTURE_CHANNELS
    texels = across - 2 * BORDER - 1
    row0, row1 = (
        max(0, int(math.floor(max(v0 - ry, -1.0)))),
        min(height, int(math.ceil(min(v0 + ry, height + 1.0)))),
    )
    a, b = max(0, int(math.floor(max(u0 - rx, -1.0)))), min(width, int(math.ceil(min(u0 + rx, width + 1.0))))
    if row1 <= row0 or b <= a:
        return
    flip = 1.0 if crown[4] > 0 else -1.0
    channels = planes.shape[0]
    light, top_light, foot_light = radiance[0, :channels], radiance[1, :channels], radiance[2, :channels]
    _light_crown(centre, crown[6:9], env[ENV_SNOW], env, lamps, beams, table, work)
    _crown_light(work[2], work[3], work[5], flip, light)
    snowy = env[ENV_SNOW] > 0.0
    if snowy:  # less lies below: through a crown's gaps alone
        _crown_light(work[2], work[3], work[5], flip, top_light)
        _light_crown(centre, crown[6:9], gaps[int(crown[0])] * env[ENV_SNOW], env, lamps, beams, table, work)
        _crown_light(work[2], work[3], work[5], flip, foot_light)
    depth_inverse = np.float32(1.0 / max(z - 0.35 * half_w, 0.5 * z))
    step, fall = flip * 0.5 * texels / rx, 0.5 * texels / ry  # texels per column, per row
    start, top = 0.5 * texels + step * (a - u0), 0.5 * texels + fall * (row0 - v0)
    share = np.float32(fade * units[level] / (step * fall))
    many = min(abs(step), fall) > MANY
    n = b - a
    nodes = nodes[: n + 1]
    _edges_of_columns(start, step, texels, nodes, weights)
    for row in range(row0, row1):
        above, below = (
            _place(top + fall * (row - row0), across),
            _place(top + fall * (row + 1 - row0), across),
        )
        c0, c1 = _reached(reach, above, below, start, step, n)
        if c1 <= c0:
            continue
        edges = nodes[c0 : c1 + 1]
        left, middle, right = weights[0, c0 : c1 + 1], weights[1, c0 : c1 + 1], weights[2, c0 : c1 + 1]
        ends = int(edges[0]), int(edges[c1 - c0])
        low, high = (min(ends) - 1) // LANES * LANES, (max(ends) + 1 + LANES) // LANES * LANES
        _sums_row(leaves, above, below, low, high, many, added)
        cover = alpha[row, a + c0 : a + c1]
        _columns(added[:stride], edges, left, middle, right, share, cover)
        _settle_cover(cover, depth_inverse, inverse[row, a + c0 : a + c1])
        first, beyond = 0, c1 - c0
        while first < beyond and cover[first] <= F0:
            first += 1
        while beyond > first and cover[beyond - 1] <= F0:
            beyond -= 1
        if beyond == first:
            continue
        grow(spans, row, a + c0 + first, a + c0 + beyond)
        if snowy:
            less = _sheltered((row + 0.5 - v0) / ry + 1.0)
            for c in range(channels):
                for k in range(4):
                    light[c, k] = top_light[c, k] + less * (foot_light[c, k] - top_light[c, k])
        for c in range(channels):
            _lit(
                light[c], added[stride + low : stride + high], added[2 * stride + low : 2 * stride + high],
                added[3 * stride + low : 3 * stride + high], added[4 * stride + low : 4 * stride + high], lit[low:high],
            )  # fmt: skip
            plane = planes[c, row, a + c0 : a + c1]
            _columns(lit, edges, left, middle, right, share, plane)
            _settle(cover, plane)
