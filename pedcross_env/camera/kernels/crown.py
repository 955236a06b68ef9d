"""Crowns of trees and bushes: textures of leaves that face the camera.

A crown is far finer than a pixel nearly everywhere. It is drawn from a texture made once (see scenery.foliage) by its exact mean
over each pixel, from running sums, so that a picture is the mean of any finer one. For the same reason the light on its leaves
is linear in what the texture holds: the light on the mean leaf is the mean of the light on the leaves.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, inlined, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM_POSITION,
    ENV_BEAM_TINT,
    ENV_BETA,
    ENV_SUN,
    ENV_SUN_DIRECTION,
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
EMPTY = np.float32(1e-7)  # what rounding leaves where there is nothing
SPARSE = 6.0  # texels per column from which a whole line of texels costs more than those at the columns
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
def _light_crown(centre, albedo, env, lamps, beams, table, work):
    """Fill ``light`` (C, 5): constant, gradient and sun, and ``heads`` (C, 2), for the crown's middle."""
    field, light, heads, sun, head = work[1:6]
    channels = light.shape[0]
    light_field(centre, env, lamps, beams, table, field)
    beam = head_irradiance(centre, env, table, env[ENV_BETA])
    away = 1e-9
    for k in range(3):
        sun[k] = env[ENV_SUN_DIRECTION + k]
        away += (env[ENV_BEAM_POSITION + k] - centre[k]) ** 2
    for k in range(3):
        head[k] = (env[ENV_BEAM_POSITION + k] - centre[k]) / math.sqrt(away)
    for c in range(channels):
        for k in range(5):
            light[c, k] = 0
        heads[c, 0] = 0
    for c in range(3):
        weight = 1.0 if channels == 3 else LUMA[c]
        rho, o = weight * albedo[c] / math.pi, c if channels == 3 else 0
        for k in range(4):
            light[o, k] += rho * field[c, k]
        light[o, 4] += rho * env[ENV_SUN + c]
        heads[o, 0] += rho * beam * env[ENV_BEAM_TINT + c]


@inlined
def _node(x, size):
    """Middle node of three around ``x`` (texels) and the weights of the first and the last: the mean of the running sums' line
    over one texel, so that a magnified texture is interpolated and a minified one is averaged, by one formula."""
    x = min(max(x, -0.5), size + 0.5) + (BORDER + 0.5)
    node = int(x)
    f = x - node
    return node, 0.5 * (1.0 - f) * (1.0 - f), 0.5 * f * f


@kernel
def _mix_lines(above, here, below, top, bottom, out):
    between = 1.0 - top - bottom
    for m in range(out.shape[0]):
        out[m] = top * above[m] + between * here[m] + bottom * below[m]


@kernel
def _sums_line(sums, row, columns, step, start, mixed, line):
    """Fill (columns + 1, TEXTURE_CHANNELS) running sums up to texture row ``row`` and to each column's edges.

    Args:
        sums: (N, N * TEXTURE_CHANNELS) of this crown.
        row: Texels.
        columns: How many.
        step: Texels per column.
        start: Texels, the first edge.
        mixed: (>= N * TEXTURE_CHANNELS,) work space.
        line: Filled.
    """
    size = sums.shape[0] - 2 * BORDER - 1
    j, top, bottom = _node(row, size)
    k0, k1 = _node(start, size)[0], _node(start + step * columns, size)[0]
    if abs(step) < SPARSE:
        low, high = (min(k0, k1) - 1) * TEXTURE_CHANNELS, (max(k0, k1) + 2) * TEXTURE_CHANNELS
        _mix_lines(
            sums[j - 1, low:high], sums[j, low:high], sums[j + 1, low:high], top, bottom, mixed[low:high]
        )
    for i in range(columns + 1):
        k, left, right = _node(start + step * i, size)
        middle = 1.0 - left - right
        at = (k - 1) * TEXTURE_CHANNELS
        if abs(step) >= SPARSE:  # only the texels that count
            low, high = at, at + 3 * TEXTURE_CHANNELS
            _mix_lines(
                sums[j - 1, low:high], sums[j, low:high], sums[j + 1, low:high], top, bottom, mixed[low:high]
            )
        for c in range(TEXTURE_CHANNELS):
            line[i, c] = (
                left * mixed[at + c]
                + middle * mixed[at + TEXTURE_CHANNELS + c]
                + right * mixed[at + 2 * TEXTURE_CHANNELS + c]
            )


@kernel
def _crown_light(light, heads, sun, head, flip, out):
    """Fill (C, 4): radiance per tone, and per tone times the normal's three directions."""
    for c in range(out.shape[0]):
        out[c, 0] = light[c, 0] + light[c, 4] * SUN_ROUND
        for k in range(3):
            out[c, 1 + k] = light[c, 1 + k] + light[c, 4] * SUN_FACING * sun[k] + heads[c, 0] * head[k]
        out[c, 1] *= flip


@kernel
def draw_crown(crown, centre, textures, env, lamps, beams, table, optics, size, scratch, work, spans):
    """Draw a crown into its object's scratch planes, which hold nothing yet.

    Args:
        crown: (9,) texture, centre (world), half width (negative: mirrored), half height (metres), albedo r, g, b.
        centre: (3,) camera coordinates.
        textures: (running sums, see scenery.foliage; (2, >= W + 1, TEXTURE_CHANNELS), (N * TEXTURE_CHANNELS,) and (3, 4) work space).
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
    sums, lines, mixed, radiance = textures
    sums = sums[int(crown[0])]
    texels = sums.shape[0] - 2 * BORDER - 1
    half_w, half_h = abs(crown[4]), crown[5]
    z = centre[2]
    # beside the camera a flat crown would turn into a wall: it thins out before
    fade = min(1.0, max(0.0, z / half_w - 0.4))
    if fade <= 0.0:
        return
    rx, ry = focal * half_w / z, focal * half_h / z
    u0, v0 = cx + focal * centre[0] / z, cy + focal * centre[1] / z
    row0, row1 = (
        max(0, int(math.floor(max(v0 - ry, -1.0)))),
        min(height, int(math.ceil(min(v0 + ry, height + 1.0)))),
    )
    a, b = max(0, int(math.floor(max(u0 - rx, -1.0)))), min(width, int(math.ceil(min(u0 + rx, width + 1.0))))
    if row1 <= row0 or b <= a:
        return
    _light_crown(centre, crown[6:9], env, lamps, beams, table, work)
    flip = 1.0 if crown[4] > 0 else -1.0
    channels = planes.shape[0]
    light = radiance[:channels]
    _crown_light(work[2], work[3], work[4], work[5], flip, light)
    depth_inverse = np.float32(1.0 / max(z - 0.35 * half_w, 0.5 * z))
    step, fall = flip * 0.5 * texels / rx, 0.5 * texels / ry  # texels per column, per row
    start, top = 0.5 * texels + step * (a - u0), 0.5 * texels + fall * (row0 - v0)
    share = flip * fade / (step * flip * fall)
    _sums_line(sums, top, b - a, step, start, mixed, lines[row0 & 1])
    for row in range(row0, row1):
        upper, lower = lines[row & 1], lines[(row + 1) & 1]
        _sums_line(sums, top + fall * (row + 1 - row0), b - a, step, start, mixed, lower)
        first, beyond = b, a
        for i in range(a, b):
            p = i - a
            cover = np.float32(share * ((lower[p + 1, 0] - lower[p, 0]) - (upper[p + 1, 0] - upper[p, 0])))
            if cover <= EMPTY:
                continue
            tone, right, down, away = (
                share * ((lower[p + 1, 1] - lower[p, 1]) - (upper[p + 1, 1] - upper[p, 1])),
                share * ((lower[p + 1, 2] - lower[p, 2]) - (upper[p + 1, 2] - upper[p, 2])),
                share * ((lower[p + 1, 3] - lower[p, 3]) - (upper[p + 1, 3] - upper[p, 3])),
                share * ((lower[p + 1, 4] - lower[p, 4]) - (upper[p + 1, 4] - upper[p, 4])),
            )
            alpha[row, i] = min(F1, cover)
            inverse[row, i] = depth_inverse
            first, beyond = min(first, i), i + 1
            for c in range(channels):
                value = light[c, 0] * tone + light[c, 1] * right + light[c, 2] * down + light[c, 3] * away
                planes[c, row, i] = np.float32(max(0.0, value))
        if beyond > first:
            grow(spans, row, first, beyond)
