"""What a wet road mirrors when the camera is rolled: kernels.finish with a horizon that slopes.

Things are thrown across the slanted horizon, at right angles to it; single pixels that the slant leaves open are closed from beside.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.finish import FILM
from pedcross_env.camera.kernels.jit import kernel
from pedcross_env.camera.kernels.rows import F0, F1

__all__ = ["mirror_in_road_tilted"]


@kernel
def _throw(source, inverse, ids, scale, horizon, tilt, mirror, mirror_inverse):
    """Fill the mirror image below the horizon; ``scale``: rows below it per inverse metre of depth."""
    height, width = inverse.shape
    channels = source.shape[0]
    down = 1.0 / (1.0 + tilt * tilt)  # of a way across the horizon, per row of difference: rows and columns
    side = -tilt * down
    for row in range(height):
        for i in range(width):
            below = row + 0.5 - horizon - tilt * (i + 0.5)
            mirror_inverse[row, i] = F0
            if below <= 0.0:
                continue
            u, v = i - 2.0 * below * side, row - 2.0 * below * down
            a, b = min(max(int(v), 0), height - 1), min(max(int(u), 0), width - 1)
            for c in range(channels):
                mirror[c, row, i] = source[c, a, b]
    for row in range(height):
        for i in range(width):
            inv = inverse[row, i]
            if ids[row, i] == -1 or inv <= F0:
                continue
            away = 2.0 * (scale * inv - (row + 0.5 - horizon - tilt * (i + 0.5)))
            if away < 0.0:
                continue
            target, column = int(np.floor(row + 0.5 + away * down)), int(np.floor(i + 0.5 + away * side))
            if target >= height or column < 0 or column >= width:
                continue
            if inv >= mirror_inverse[target, column]:
                mirror_inverse[target, column] = inv
                for c in range(channels):
                    mirror[c, target, column] = source[c, row, i]


@kernel
def _close(mirror, mirror_inverse):
    """Close holes of one pixel between pixels that something was thrown to."""
    height, width = mirror_inverse.shape
    for row in range(height):
        for i in range(1, width - 1):
            if (
                mirror_inverse[row, i] == F0
                and mirror_inverse[row, i - 1] > F0
                and mirror_inverse[row, i + 1] > F0
            ):
                for c in range(mirror.shape[0]):
                    mirror[c, row, i] = mirror[c, row, i - 1]


@kernel
def mirror_in_road_tilted(
    out,
    inverse,
    ids,
    horizon,
    tilt,
    focal,
    height_m,
    wetness,
    beta,
    share,
    mirror,
    mirror_inverse,
    blurred,
    sums,
):
    """Add what the wet ground mirrors; see ``kernels.finish.mirror_in_road``.

    Args:
        out: See there.
        inverse: See there.
        ids: See there.
        horizon: Row of the horizon at the image's left edge, continuous.
        tilt: Rows by which it descends per column.
        focal: Pixels, over the cosine of the pitch.
        height_m: Of the camera.
        wetness: 0 to 1.
        beta: Extinction per metre.
        share: See there.
        mirror: See there.
        mirror_inverse: See there.
        blurred: Not used.
        sums: See there.
    """
    height, width = inverse.shape
    upright = 1.0 / np.sqrt(1.0 + tilt * tilt)
    _throw(out, inverse, ids, focal * height_m / upright, horizon, tilt, mirror, mirror_inverse)
    _close(mirror, mirror_inverse)
    for c in range(out.shape[0]):
        for i in range(width):
            sums[0, i] = 0.0
        for row in range(height):
            for i in range(width):
                sums[row + 1, i] = sums[row, i] + mirror[c, row, i]
        for row in range(height):
            for i in range(width):
                if ids[row, i] != -1:
                    continue
                line = horizon + tilt * (i + 0.5)
                below = max(row + 0.5 - line, 1e-3)
                half = 2.0 + 0.16 * below
                low, high = max(0.0, line + 1.0, row + 0.5 - half), min(height - 1e-6, row + 0.5 + half)
                a, b = int(low), int(high)
                upper = sums[a, i] + (low - a) * (sums[a + 1, i] - sums[a, i])
                lower = sums[b, i] + (high - b) * (sums[b + 1, i] - sums[b, i])
                slope = below * upright / focal
                cosine = slope / np.sqrt(1.0 + slope * slope)
                fresnel = 0.02 + 0.98 * (1.0 - cosine) ** 5
                through = np.exp(-beta * height_m / max(slope, 1e-4))
                gain = np.float32(
                    FILM * wetness * fresnel * through * (lower - upper) / max(high - low, 1e-3)
                )
                out[c, row, i] += min(F1, share[row, i]) * gain
