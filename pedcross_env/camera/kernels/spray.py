"""Puffs of spray before a finished picture: soft balls of droplets, faded where they reach into things."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel
from pedcross_env.camera.kernels.lighting import ENV_BEAM_TINT, head_irradiance

__all__ = ["add_puffs"]

F0, F1, HALF = np.float32(0), np.float32(1), np.float32(0.5)


@kernel
def _opacity_row(depth, first, dy2, inverse, z, soft, thickness, opacity):
    """Share of the light that one row of a puff takes out of what lies behind it."""
    for i in range(opacity.shape[0]):
        dx = first + np.float32(i)
        inside = max(F0, F1 - (dx * dx + dy2) * inverse)
        seen = max(F0, min(F1, (depth[i] - z) * soft + HALF))
        passed = thickness * inside * inside * seen
        opacity[i] = passed / (F1 + passed)


@kernel
def _mix_row(opacity, colour, plane):
    for i in range(plane.shape[0]):
        plane[i] += opacity[i] * (colour - plane[i])


@entry
def add_puffs(out, luminance, depth, puffs, env, beams, towards_lamp, beta, optics, opacity):
    """Add puffs, farthest first.

    Args:
        out: (3, H, W) radiance, or no planes where luminance is all that is wanted.
        luminance: (H, W).
        depth: (H, W) metres.
        puffs: (N, 8): camera coordinates, radius in metres, optical depth of the middle, radiance r, g, b, to which the
            headlights' is added.
        env: See kernels.lighting.
        beams: The headlights' tables.
        towards_lamp: Radiance back to the headlights over their illuminance.
        beta: Extinction per metre.
        optics: Focal length, cx, cy.
        opacity: (W,) work space.
    """
    focal, cx, cy = optics
    channels = out.shape[0]
    height, width = luminance.shape
    for k in range(puffs.shape[0]):
        x, y, z, radius, thickness = puffs[k, 0], puffs[k, 1], puffs[k, 2], puffs[k, 3], puffs[k, 4]
        size = radius * focal / z
        u, v = cx + focal * x / z, cy + focal * y / z
        if not (-size < u < width + size and -size < v < height + size):
            continue
        lit = towards_lamp * head_irradiance(puffs[k, :3], env, beams, beta)
        for c in range(3):
            puffs[k, 5 + c] += lit * env[ENV_BEAM_TINT + c]
        luma = 0.2126 * puffs[k, 5] + 0.7152 * puffs[k, 6] + 0.0722 * puffs[k, 7]
        a, b = max(0, int(math.floor(u - size))), min(width, int(math.ceil(u + size)) + 1)
        for row in range(max(0, int(math.floor(v - size))), min(height, int(math.ceil(v + size)) + 1)):
            dy = row + 0.5 - v
            line = opacity[: b - a]
            _opacity_row(
                depth[row, a:b], np.float32(a + 0.5 - u), np.float32(dy * dy), np.float32(1.0 / (size * size)), np.float32(z),
                np.float32(1.0 / radius), np.float32(thickness), line,
            )  # fmt: skip
            _mix_row(line, np.float32(luma), luminance[row, a:b])
            for c in range(channels):
                _mix_row(line, np.float32(puffs[k, 5 + c]), out[c, row, a:b])
