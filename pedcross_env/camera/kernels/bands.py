"""Filling a row of ground: bands of the street's profile, its markings, and the grain of its surface."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import kernel
from pedcross_env.camera.kernels.rows import F0, fill_row

__all__ = ["add_stripes", "fill_bands", "grain_columns", "grain_row", "weigh_bands"]


@kernel
def weigh_bands(bands, weights, out):
    """Turn bands of r, g, b into bands of ``weights @ (r, g, b)``.

    Args:
        bands: (S, 9) y range, r, g, b at the low end, at the high end, lines; see camera.profiles.
        weights: (P, 3).
        out: (>= S, 3 + 2 P), filled: y range, lines, the P values at the low end, their rise to the high end.
    """
    p = weights.shape[0]
    for j in range(bands.shape[0]):
        out[j, 0], out[j, 1], out[j, 2] = bands[j, 0], bands[j, 1], bands[j, 8]
        for k in range(p):
            w0, w1, w2 = weights[k, 0], weights[k, 1], weights[k, 2]
            out[j, 3 + k] = w0 * bands[j, 2] + w1 * bands[j, 3] + w2 * bands[j, 4]
            high = w0 * bands[j, 5] + w1 * bands[j, 6] + w2 * bands[j, 7]
            out[j, 3 + p + k] = high - out[j, 3 + k]


@kernel
def _ramp(value, slope, out):
    for i in range(out.shape[0]):
        out[i] = value + slope * np.float32(np.int32(i))  # 32 bits become floats in vectors, 64 do not


@kernel
def _rise(value, out):
    for i in range(out.shape[0]):
        out[i] += value


@kernel
def _part(band, p, u0, inv_span, low, high, at, buf, first, lines):
    """Add the part of a band that lies between columns ``low`` and ``high``, both in pixel ``at``."""
    share = np.float32(high - low)
    t = np.float32((0.5 * (low + high) - u0) * inv_span)
    for k in range(p):
        buf[first + k, at] += share * (band[3 + k] + t * band[3 + p + k])
    buf[lines, at] += share * band[2]


@kernel
def fill_bands(bands, p, y0, dy, column, n, buf, first, lines):
    """Fill a row's pixels with their mean over the bands they see: exact, so that nothing is aliased at any distance.

    Args:
        bands: (S, 3 + 2 P) from ``weigh_bands``.
        p: P.
        y0: y of the row's column 0.
        dy: y per column.
        column: Of the first pixel.
        n: How many.
        buf: Work space (whole, so that its rows' slices are known to be contiguous).
        first: Its row for the first of P planes of values; 0 where no band has been yet.
        lines: Its row for the share of the pixel that lines cover, likewise.
    """
    inv = 1.0 / dy
    for j in range(bands.shape[0]):
        band = bands[j]
        u0, u1 = (band[0] - y0) * inv - column, (band[1] - y0) * inv - column
        low, high = max(0.0, min(u0, u1)), min(n + 0.0, max(u0, u1))
        if high <= low:
            continue
        inv_span = 1.0 / (u1 - u0)
        i0, i1 = int(low), int(high)
        if i0 == i1:
            _part(band, p, u0, inv_span, low, high, i0, buf, first, lines)
            continue
        if low > i0:
            _part(band, p, u0, inv_span, low, i0 + 1.0, i0, buf, first, lines)
            i0 += 1
        if high > i1:
            _part(band, p, u0, inv_span, i1 + 0.0, high, i1, buf, first, lines)
        if i1 > i0:
            t = (i0 + 0.5 - u0) * inv_span
            for k in range(p):
                rise = band[3 + p + k]
                _ramp(np.float32(band[3 + k] + t * rise), np.float32(rise * inv_span), buf[first + k, i0:i1])
            if band[2] > F0:
                fill_row(band[2], buf[lines, i0:i1])


@kernel
def add_stripes(stripes, weight, y0, dy, first, marks):
    """Add to each pixel its share between the (S, 2) ranges of y, times ``weight``: that of the row which a marking covers."""
    n = marks.shape[0]
    inv = 1.0 / dy
    value = np.float32(weight)
    for j in range(stripes.shape[0]):
        u0, u1 = (stripes[j, 0] - y0) * inv - first, (stripes[j, 1] - y0) * inv - first
        low, high = max(0.0, min(u0, u1)), min(n + 0.0, max(u0, u1))
        if high <= low:
            continue
        i0, i1 = int(low), int(high)
        if i0 == i1:
            marks[i0] += np.float32(high - low) * value
            continue
        if low > i0:
            marks[i0] += np.float32(i0 + 1.0 - low) * value
            i0 += 1
        if high > i1:
            marks[i1] += np.float32(high - i1) * value
        if i1 > i0:
            _rise(value, marks[i0:i1])


@kernel
def _between(low0, high0, low1, high1, f0, f1, period, turns, scale, mean, out):
    for j in range(out.shape[0]):
        low, high = low0[j] + f0 * (high0[j] - low0[j]), low1[j] + f1 * (high1[j] - low1[j])
        out[j] = (high - low + turns * period[j]) * scale - mean * np.float32(np.int32(j))


@kernel
def grain_row(sums, x0, x1, texel, line):
    """Box-filter the tiled grain from x0 to x1; the result is integrated across the street.

    Args:
        sums: (T + 1, T + 1) running sums along x and y.
        x0: From, metres.
        x1: To.
        texel: Metres.
        line: (T + 1,) filled with the running sums across, less the mean each, so that they are periodic.

    Returns:
        The row's mean.
    """
    size = sums.shape[1] - 1
    p0, p1 = x0 / texel, x1 / texel
    span = max(p1 - p0, 1e-3)
    t0, t1 = math.floor(p0 / size), math.floor(p1 / size)
    q0, q1 = p0 - t0 * size, p1 - t1 * size
    i0, i1 = min(int(q0), size - 1), min(int(q1), size - 1)
    f0, f1, turns, scale = (
        np.float32(q0 - i0),
        np.float32(q1 - i1),
        np.float32(t1 - t0),
        np.float32(1.0 / span),
    )
    low = sums[i0, size] + f0 * (sums[i0 + 1, size] - sums[i0, size])
    high = sums[i1, size] + f1 * (sums[i1 + 1, size] - sums[i1, size])
    mean = (high - low + turns * sums[size, size]) * scale / np.float32(size)
    _between(sums[i0], sums[i0 + 1], sums[i1], sums[i1 + 1], f0, f1, sums[size], turns, scale, mean, line)
    line[size] = F0
    return mean


@kernel
def _edges(line, start, step, out):
    mask = np.uint32(line.shape[0] - 2)  # unsigned: numba lets a negative index count from the end
    for k in range(out.shape[0]):
        p = start + step * np.float32(np.int32(k))
        whole = np.floor(p)
        i = np.uint32(np.int32(whole)) & mask
        low = line[i]
        out[k] = low + (p - whole) * (line[i + np.uint32(1)] - low)


@kernel
def _slope(low, high, mean, inv, out):
    for k in range(out.shape[0]):
        out[k] = (high[k] - low[k]) * inv + mean


@kernel
def grain_columns(line, mean, y0, dy, texel, first, edges, out):
    """Box-filter ``grain_row``'s result over each pixel's extent across the street.

    Args:
        line: (T + 1,), T a power of two.
        mean: The row's.
        y0: y of column 0.
        dy: y per column.
        texel: Metres.
        first: Column of the first pixel.
        edges: (>= n + 1,) work space.
        out: (n,) filled.
    """
    n, size = out.shape[0], line.shape[0] - 1
    step = dy / texel
    start = y0 / texel + first * step
    _edges(line, np.float32(start - size * math.floor(start / size)), np.float32(step), edges[: n + 1])
    _slope(edges[:n], edges[1 : n + 1], mean, np.float32(1.0 / step), out)
