"""Resampling a picture at given places: the mean of linear interpolations over each pixel's footprint."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import entry
from pedcross_env.camera.kernels.rows import F0, F1, HALF

__all__ = ["resample"]

LAST = np.float32(1.01)  # keeps the right and lower neighbour inside the picture


@entry
def resample(source, places, samples, out):
    """Fill ``out`` with the means of ``source`` over the pixels' footprints.

    Args:
        source: (C, h, w) float32, C 1 or 3.
        places: (6, H, W) float32: column, row, their change along a pixel's width (2) and height (2), see lens.Lens.
        samples: (2, H, W) uint8 samples along the width and the height.
        out: (C, H, W) float32.
    """
    channels, height, width = source.shape
    right, bottom = np.float32(width) - LAST, np.float32(height) - LAST
    last = channels - 1
    for row in range(out.shape[1]):
        for i in range(out.shape[2]):
            across, down = int(samples[0, row, i]), int(samples[1, row, i])
            step_a, step_b = F1 / np.float32(across), F1 / np.float32(down)
            red = green = blue = F0
            for m in range(down):
                b = (np.float32(m) + HALF) * step_b - HALF
                for n in range(across):
                    a = (np.float32(n) + HALF) * step_a - HALF
                    u = places[0, row, i] + a * places[2, row, i] + b * places[4, row, i] - HALF
                    v = places[1, row, i] + a * places[3, row, i] + b * places[5, row, i] - HALF
                    u, v = min(max(u, F0), right), min(max(v, F0), bottom)
                    x, y = int(u), int(v)
                    fx, fy = u - np.float32(x), v - np.float32(y)
                    w0, w1, w2, w3 = (F1 - fx) * (F1 - fy), fx * (F1 - fy), (F1 - fx) * fy, fx * fy
                    red += (
                        w0 * source[0, y, x]
                        + w1 * source[0, y, x + 1]
                        + w2 * source[0, y + 1, x]
                        + w3 * source[0, y + 1, x + 1]
                    )
                    if last > 0:
                        green += (
                            w0 * source[1, y, x]
                            + w1 * source[1, y, x + 1]
                            + w2 * source[1, y + 1, x]
                            + w3 * source[1, y + 1, x + 1]
                        )
                        blue += (
                            w0 * source[2, y, x]
                            + w1 * source[2, y, x + 1]
                            + w2 * source[2, y + 1, x]
                            + w3 * source[2, y + 1, x + 1]
                        )
            share = step_a * step_b
            out[0, row, i] = red * share
            if last > 0:
                out[1, row, i] = green * share
                out[2, row, i] = blue * share
