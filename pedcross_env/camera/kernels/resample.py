"""Resampling a picture at given places: the mean of linear interpolations over each pixel's footprint."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import kernel

__all__ = ["resample"]


@kernel
def resample(source, places, samples, out):
    """Fill ``out`` with the means of ``source`` over the pixels' footprints.

    Args:
        source: (C, h, w) float32.
        places: (6, H, W) float32: column, row, their change along a pixel's width (2) and height (2), see lens.Lens.
        samples: (2, H, W) uint8 samples along the width and the height.
        out: (C, H, W) float32.
    """
    channels, height, width = source.shape
    for row in range(out.shape[1]):
        for i in range(out.shape[2]):
            across, down = int(samples[0, row, i]), int(samples[1, row, i])
            share = np.float32(1.0 / (across * down))
            for c in range(channels):
                out[c, row, i] = np.float32(0)
            for m in range(down):
                b = (m + 0.5) / down - 0.5
                for n in range(across):
                    a = (n + 0.5) / across - 0.5
                    u = places[0, row, i] + a * places[2, row, i] + b * places[4, row, i] - 0.5
                    v = places[1, row, i] + a * places[3, row, i] + b * places[5, row, i] - 0.5
                    u, v = min(max(u, 0.0), width - 1.001), min(max(v, 0.0), height - 1.001)
                    x, y = int(math.floor(u)), int(math.floor(v))
                    fx, fy = np.float32(u - x), np.float32(v - y)
                    for c in range(channels):
                        low = source[c, y, x] + fx * (source[c, y, x + 1] - source[c, y, x])
                        high = source[c, y + 1, x] + fx * (source[c, y + 1, x + 1] - source[c, y + 1, x])
                        out[c, row, i] += share * (low + fy * (high - low))
