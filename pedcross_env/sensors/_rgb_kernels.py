"""Kernels of the RGB camera."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import allocating, entry, kernel

__all__ = ["ADC_MAX", "BLOOM_CAP", "BLOOM_FROM", "bloom", "develop", "mean_log"]

ADC_MAX = 4095  # of a 12-bit converter

BLOOM_FROM = np.float32(2.0)  # whites a pixel holds before it spills
BLOOM_CAP = np.float32(30.0)  # more whites than these spill no more
_ZERO = np.float32(0.0)

# Four independent bytes add up to nearly a normal number: mean 510, variance 4 (256^2 - 1) / 12, excess
# kurtosis -0.3, never beyond 3.45 standard deviations.
_BYTES_MEAN = np.float32(510.0)
_BYTES_SCALE = np.float32(1.0 / math.sqrt(4 * (256**2 - 1) / 12))


@entry
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


@kernel
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


@kernel
def _clean_row(row, scale, well_e, digits):
    top = np.float32(ADC_MAX)
    to_digits = np.float32(scale * top / well_e)
    for x in range(row.size):
        digits[x] = np.int32(min(top, max(np.float32(0.0), row[x] * to_digits)) + np.float32(0.5))


@kernel
def _top_row(row, top):
    for x in range(row.size):
        top[x] = max(top[x], row[x])


@kernel
def _excess_row(row, level, cap, total):
    for x in range(row.size):
        total[x] += min(cap, max(_ZERO, row[x] - level))


@kernel
def _smooth(line, work):
    """Triangular mean over five cells in place: twice a mean over three, the ends repeated."""
    n = line.size
    for _ in range(2):
        for i in range(n):
            work[i] = line[i]
        for i in range(n):
            line[i] = (work[max(0, i - 1)] + work[i] + work[min(n - 1, i + 1)]) * np.float32(1.0 / 3.0)


@kernel
def _widen(cells, cell, out):
    """Interpolate values that belong to the middles of cells to pixels."""
    last, step = cells.size - 1, np.float32(1.0 / cell)
    offset = np.float32(0.5 - (cell / 2 - cell // 2))
    for k in range(-1, cells.size):
        a, b = cells[max(0, k)], cells[min(last, k + 1)]
        start = k * cell + cell // 2
        for x in range(max(0, start), min(out.size, start + cell)):
            out[x] = a + (b - a) * (np.float32(x - start) + offset) * step


@entry
def bloom(radiance, white, share, cell, work, cells, glow, lit):
    """Fill ``glow`` (3, rows of cells, W) with the light that saturated pixels spill around them; whether there is any.

    What exceeds BLOOM_FROM whites, BLOOM_CAP whites at most, is averaged over cells and smoothed by a triangle of five
    cells. ``lit`` (rows,) tells the rows of cells that have some; ``work`` (3, W or rows) and ``cells`` (3, rows,
    columns) are work space.
    """
    channels, height, width = radiance.shape
    rows, columns = cells.shape[1], cells.shape[2]
    level, cap = BLOOM_FROM * white, BLOOM_CAP * white
    total, line, spare = work[0], work[1, :rows], work[2]
    any_light = False
    for j in range(rows):
        lit[j] = False
    for c in range(channels):
        for j in range(rows):
            for x in range(width):
                total[x] = _ZERO
            first, last = j * cell, min(height, (j + 1) * cell)
            for y in range(first, last):
                _top_row(radiance[c, y], total[:width])
            some = False
            for x in range(width):
                some = some or total[x] > level
            for i in range(columns):
                cells[c, j, i] = _ZERO
            if not some:
                continue
            any_light = True
            lit[j] = True
            for x in range(width):
                total[x] = _ZERO
            for y in range(first, last):
                _excess_row(radiance[c, y], level, cap, total[:width])
            for i in range(columns):
                value = _ZERO
                for x in range(i * cell, min(width, (i + 1) * cell)):
                    value += total[x]
                cells[c, j, i] = value * np.float32(share / (cell * cell))
            _smooth(cells[c, j], spare)
    if not any_light:
        return False
    for c in range(channels):
        for i in range(columns):
            for j in range(rows):
                line[j] = cells[c, j, i]
            _smooth(line, spare)
            for j in range(rows):
                cells[c, j, i] = line[j]
    # The triangle reaches two cells on, the interpolation one more.
    for j in range(rows):
        spare[j] = np.float32(lit[j])
    for j in range(rows):
        for k in range(max(0, j - 3), min(rows, j + 4)):
            lit[j] = lit[j] or spare[k] > _ZERO
    for c in range(channels):
        for j in range(rows):
            if lit[j]:
                _widen(cells[c, j], cell, glow[c, j])
            else:
                for x in range(width):
                    glow[c, j, x] = _ZERO
    return True


@kernel
def _lit_row(row, low, high, part, out):
    for x in range(row.size):
        out[x] = row[x] + low[x] + part * (high[x] - low[x])


@kernel
def _code_row(table, red, green, blue, line):
    """Look up the codes of a row of converter values; ``line`` is the row's 3 W bytes."""
    for x in range(red.size):
        line[3 * x] = table[red[x]]
        line[3 * x + 1] = table[green[x]]
        line[3 * x + 2] = table[blue[x]]


@allocating
def develop(radiance, scale, well_e, read_variance, noise, first, second, table, glow, lit, cell, image):
    """Turn (3, H, W) radiance into a picture, (H, 3 W) bytes: glow, electrons, noise, 12 bits, code table.

    ``glow`` and ``lit`` as bloom fills them, in cells of ``cell`` pixels, or without rows where there is none.
    """
    channels, height, width = radiance.shape
    digits, sum_row = np.empty((channels, width), np.int32), np.empty(width, np.float32)
    red, green, blue = digits[0], digits[1], digits[2]
    rows = glow.shape[1]
    for y in range(height):
        at = (y + 0.5) / cell - 0.5
        k = math.floor(at)
        for c in range(channels):
            row = radiance[c, y]
            if rows > 0 and lit[min(rows - 1, max(0, k))]:
                low, high = glow[c, max(0, k)], glow[c, min(rows - 1, k + 1)]
                _lit_row(row, low, high, np.float32(at - k), sum_row)
                row = sum_row
            if noise:
                start = np.uint32((c * height + y) * width)
                _noisy_row(row, scale, well_e, read_variance, start, first, second, digits[c])
            else:
                _clean_row(row, scale, well_e, digits[c])
        _code_row(table, red, green, blue, image[y])
