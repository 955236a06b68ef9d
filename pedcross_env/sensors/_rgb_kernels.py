"""Kernels of the RGB camera."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["ADC_MAX", "develop", "mean_log"]

ADC_MAX = 4095  # of a 12-bit converter

# Four independent bytes add up to nearly a normal number: mean 510, variance 4 (256^2 - 1) / 12, excess
# kurtosis -0.3, never beyond 3.45 standard deviations.
_BYTES_MEAN = np.float32(510.0)
_BYTES_SCALE = np.float32(1.0 / math.sqrt(4 * (256**2 - 1) / 12))


@njit(cache=True, error_model="numpy")
def mean_log(values: np.ndarray) -> float:
    """Mean natural logarithm of positive values."""
    total = 0.0
    for i in range(values.size):
        total += math.log(values[i])
    return total / values.size


@njit(cache=True, inline="always")
def _scramble(counter: np.uint32, first: np.uint32, second: np.uint32) -> np.uint32:
    """Hash a counter under a 64-bit key in 32-bit steps, which vectorise (constants: Wellons' lowbias32)."""
    h = np.uint32(counter + first)
    h = np.uint32((h ^ np.uint32(h >> np.uint32(16))) * np.uint32(0x7FEB352D))
    h = np.uint32(h ^ second)
    h = np.uint32((h ^ np.uint32(h >> np.uint32(15))) * np.uint32(0x846CA68B))
    return np.uint32(h ^ np.uint32(h >> np.uint32(16)))


@njit(cache=True, error_model="numpy")
def _noisy_row(row, scale, well_e, read_variance, start, first, second, digits):
    top = np.float32(ADC_MAX)
    to_digits = np.float32(top / well_e)
    for x in range(row.size):
        electrons = max(np.float32(0.0), row[x] * scale)
        h = _scramble(np.uint32(start + np.uint32(x)), first, second)
        total = np.int32(
            np.uint32(h & np.uint32(255))
            + np.uint32(np.uint32(h >> np.uint32(8)) & np.uint32(255))
            + np.uint32(np.uint32(h >> np.uint32(16)) & np.uint32(255))
            + np.uint32(h >> np.uint32(24))
        )
        normal = (np.float32(total) - _BYTES_MEAN) * _BYTES_SCALE
        read_out = electrons + np.sqrt(electrons + read_variance) * normal
        digits[x] = np.int32(min(top, max(np.float32(0.0), read_out * to_digits)) + np.float32(0.5))


@njit(cache=True, error_model="numpy")
def _clean_row(row, scale, well_e, digits):
    top = np.float32(ADC_MAX)
    to_digits = np.float32(scale * top / well_e)
    for x in range(row.size):
        digits[x] = np.int32(min(top, max(np.float32(0.0), row[x] * to_digits)) + np.float32(0.5))


@njit(cache=True, error_model="numpy")
def develop(radiance, scale, well_e, read_variance, noise, first, second, table, image):
    """Turn (3, H, W) radiance into an (H, W, 3) picture: electrons, noise, 12 bits, code table."""
    channels, height, width = radiance.shape
    digits = np.empty(width, np.int32)
    for y in range(height):
        for c in range(channels):
            if noise:
                start = np.uint32((c * height + y) * width)
                _noisy_row(radiance[c, y], scale, well_e, read_variance, start, first, second, digits)
            else:
                _clean_row(radiance[c, y], scale, well_e, digits)
            line = image[y, :, c]
            for x in range(width):
                line[x] = table[digits[x]]
