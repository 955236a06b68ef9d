"""Crowns of trees and bushes: textures of leaves that face the camera.

A crown is far finer than a pixel nearly everywhere. It is drawn from a texture made once (see scenery.foliage), through levels
of detail that are blended, so that it changes smoothly at any distance; its leaves are lit with their own normals.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
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

__all__ = ["TEXTURE_CHANNELS", "draw_crown", "splat_leaves"]

TEXTURE_CHANNELS = 4  # cover, tone, normal to the right, normal downwards; the last three times the cover
THROUGH = np.float32(0.35)  # how far light passes round a leaf: leaves are translucent
LUMA = (0.2126, 0.7152, 0.0722)


@kernel
def splat_leaves(leaves, image):
    """Paint leaves over each other, in their order.

    Args:
        leaves: (N, 8) column, row, half length, half width (texels), angle, tone, normal to the right, normal downwards.
        image: (S, S, 4) float32, changed.
    """
    size = image.shape[0]
    for k in range(leaves.shape[0]):
        leaf = leaves[k]
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
                for m in range(3):
                    image[row, column, 1 + m] += a * (np.float32(leaf[5 + m]) - image[row, column, 1 + m])
                image[row, column, 0] += a * (F1 - image[row, column, 0])


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
def _mix(texels, at, below, f, g, k):
    """Bilinear value of channel ``k`` between texels ``at`` and its right neighbour, and the two below them."""
    upper = texels[at, k] + f * (texels[at + 1, k] - texels[at, k])
    lower = texels[below, k] + f * (texels[below + 1, k] - texels[below, k])
    return upper + g * (lower - upper)


@kernel
def draw_crown(crown, centre, textures, env, lamps, beams, table, optics, size, scratch, work, spans):
    """Draw a crown into its object's scratch planes, which hold nothing yet.

    Args:
        crown: (9,) texture, centre (world), half width (negative: mirrored), half height (metres), albedo r, g, b.
        centre: (3,) camera coordinates.
        textures: (texels (S, T, 4) float32, levels (L, 2) offset and size, the finest first; each has a border of one empty texel).
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
    texels, levels = textures
    texels = texels[int(crown[0])]
    half_w, half_h = abs(crown[4]), crown[5]
    z = centre[2]
    # beside the camera a flat crown would turn into a wall: it thins out before
    fade = np.float32(min(1.0, max(0.0, z / half_w - 0.4)))
    if fade <= F0:
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
    light, heads, sun, head = work[2], work[3], work[4], work[5]
    channels = planes.shape[0]
    rate = max(1.0, max(0.5 * levels[0, 1] / rx, 0.5 * levels[0, 1] / ry))  # texels per pixel
    detail = min(math.log2(rate), levels.shape[0] - 1.001)
    fine = int(detail)
    blend = np.float32(detail - fine)
    offset0, size0 = levels[fine, 0], levels[fine, 1]
    offset1, size1 = levels[fine + 1, 0], levels[fine + 1, 1]
    depth_inverse = np.float32(1.0 / max(z - 0.35 * half_w, 0.5 * z))
    step = (1.0 if crown[4] > 0 else -1.0) * 0.5 / rx
    flip = np.float32(1.0 if crown[4] > 0 else -1.0)
    for row in range(row0, row1):
        q = min(1.0, max(0.0, 0.5 + 0.5 * (row + 0.5 - v0) / ry))
        y0, y1 = q * size0 + 0.5, q * size1 + 0.5  # the border is one texel wide
        j0, j1 = int(y0), int(y1)
        g0, g1 = np.float32(y0 - j0), np.float32(y1 - j1)
        line0, line1 = offset0 + j0 * (size0 + 2), offset1 + j1 * (size1 + 2)
        first, beyond = b, a
        for i in range(a, b):
            p = min(1.0, max(0.0, 0.5 + step * (i + 0.5 - u0)))
            x1 = p * size1 + 0.5
            i1 = int(x1)
            f1, at1 = np.float32(x1 - i1), line1 + i1
            coarse = _mix(texels, at1, at1 + size1 + 2, f1, g1, 0)
            if coarse <= F0:
                continue
            x0 = p * size0 + 0.5
            i0 = int(x0)
            f0, at0 = np.float32(x0 - i0), line0 + i0
            under0, under1 = at0 + size0 + 2, at1 + size1 + 2
            cover = _mix(texels, at0, under0, f0, g0, 0)
            cover += blend * (coarse - cover)
            if cover <= F0:
                continue
            tone, nx, ny = (
                _mix(texels, at0, under0, f0, g0, 1), _mix(texels, at0, under0, f0, g0, 2), _mix(texels, at0, under0, f0, g0, 3),
            )  # fmt: skip
            scale = F1 / cover
            tone = (tone + blend * (_mix(texels, at1, under1, f1, g1, 1) - tone)) * scale
            nx = (nx + blend * (_mix(texels, at1, under1, f1, g1, 2) - nx)) * scale * flip
            ny = (ny + blend * (_mix(texels, at1, under1, f1, g1, 3) - ny)) * scale
            nz = -np.sqrt(max(F0, F1 - nx * nx - ny * ny))
            cos_sun = max(F0, sun[0] * nx + sun[1] * ny + sun[2] * nz + THROUGH) / (F1 + THROUGH)
            cos_head = max(F0, head[0] * nx + head[1] * ny + head[2] * nz)
            cover *= fade
            alpha[row, i] = cover
            inverse[row, i] = depth_inverse
            first, beyond = min(first, i), i + 1
            for c in range(channels):
                value = light[c, 0] + light[c, 1] * nx + light[c, 2] * ny + light[c, 3] * nz
                value += light[c, 4] * cos_sun + heads[c, 0] * cos_head
                planes[c, row, i] = cover * tone * value
        if beyond > first:
            grow(spans, row, first, beyond)
