"""Convex polygons: clipping, projection and exact pixel coverage.

Coverage is the area of polygon and pixel in common: it changes smoothly with any motion.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import kernel
from pedcross_env.camera.kernels.rows import F0, F1

__all__ = [
    "MAX_CORNERS",
    "NEAR_M",
    "cover_row",
    "deposit",
    "grow",
    "project_clipped",
    "row_range",
]

NEAR_M = 0.1
MAX_CORNERS = 24  # of a clipped face


@kernel
def project_clipped(points, count, focal, cx, cy, out):
    """Clip a polygon at the near plane and project it; return its number of corners.

    Args:
        points: (>= count, 3) camera coordinates.
        count: Corners.
        focal: Pixels.
        cx: Principal point.
        cy: Principal point.
        out: (MAX_CORNERS, 2) float64.
    """
    n = 0
    for i in range(count):
        j = (i + 1) % count
        zi, zj = points[i, 2], points[j, 2]
        if zi >= NEAR_M:
            out[n, 0] = cx + focal * points[i, 0] / zi
            out[n, 1] = cy + focal * points[i, 1] / zi
            n += 1
        if (zi >= NEAR_M) != (zj >= NEAR_M):
            t = (NEAR_M - zi) / (zj - zi)
            out[n, 0] = cx + focal * (points[i, 0] + t * (points[j, 0] - points[i, 0])) / NEAR_M
            out[n, 1] = cy + focal * (points[i, 1] + t * (points[j, 1] - points[i, 1])) / NEAR_M
            n += 1
    return n


@kernel
def grow(spans, row, a, b):
    """Extend what an object covers: columns a to b of a row.

    spans: (H + 1, 2) int32, the first column and the one beyond the last of each row; in the last row of the array, those of rows.
    """
    spans[row, 0], spans[row, 1] = min(spans[row, 0], a), max(spans[row, 1], b)
    rows = spans[spans.shape[0] - 1]
    rows[0], rows[1] = min(rows[0], row), max(rows[1], row + 1)


@kernel
def row_range(corners, count, height):
    """Rows that a polygon touches."""
    low, high = corners[0, 1], corners[0, 1]
    for i in range(1, count):
        low, high = min(low, corners[i, 1]), max(high, corners[i, 1])
    return max(0, int(math.floor(max(low, -1.0)))), min(height, int(math.ceil(min(high, height + 1.0))))


@kernel
def _column_range(corners, count, row, width):
    """Columns that a polygon touches in one row."""
    low, high = 1e9, -1e9
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        x0, y0, x1, y1 = corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1]
        if y0 > y1:
            x0, y0, x1, y1 = x1, y1, x0, y0
        if y1 < row or y0 > row + 1:
            continue
        slope = (x1 - x0) / (y1 - y0) if y1 - y0 > 1e-9 else 0.0
        if y0 < row:
            low, high = min(low, x0 + slope * (row - y0)), max(high, x0 + slope * (row - y0))
        else:
            low, high = min(low, x0), max(high, x0)
        if y1 > row + 1:
            low, high = min(low, x0 + slope * (row + 1 - y0)), max(high, x0 + slope * (row + 1 - y0))
        else:
            low, high = min(low, x1), max(high, x1)
    return max(0, int(math.floor(max(low, -1.0)))), min(width, int(math.ceil(min(high, width + 1.0))))


@kernel
def deposit(x0, x1, d, out):
    """Add an edge's steps of coverage: it crosses ``d`` of the row's height between columns x0 and x1 (0 to len(out) - 2)."""
    if x0 > x1:
        x0, x1 = x1, x0
    first = int(x0)
    f0 = x0 - first
    beyond = int(math.ceil(x1))
    if beyond <= first + 1:
        middle = d * (0.5 * (x0 + x1) - first)
        out[first] += np.float32(d - middle)
        out[first + 1] += np.float32(middle)
        return
    slope = 1.0 / (x1 - x0)
    begin = 0.5 * slope * (1.0 - f0) * (1.0 - f0)
    f1 = x1 - beyond + 1.0
    end = 0.5 * slope * f1 * f1
    out[first] += np.float32(d * begin)
    if beyond == first + 2:
        out[first + 1] += np.float32(d * (1.0 - begin - end))
    else:
        second = slope * (1.5 - f0)
        out[first + 1] += np.float32(d * (second - begin))
        for k in range(first + 2, beyond - 1):
            out[k] += np.float32(d * slope)
        out[beyond - 1] += np.float32(d * (1.0 - second - (beyond - first - 3) * slope - end))
    out[beyond] += np.float32(d * end)


@kernel
def cover_row(corners, count, row, width, out):
    """Exact share of each pixel of a row that a convex polygon covers.

    Every edge leaves the steps of its area; their running sum is the coverage.

    Args:
        corners: (>= count, 2) columns and rows, continuous.
        count: Corners.
        row: Which row.
        width: Of the image.
        out: (>= W + 2,) filled from 0 with the coverage of the columns returned.

    Returns:
        First column and the column beyond the last.
    """
    a, b = _column_range(corners, count, row, width)
    n = b - a
    if n <= 0:
        return 0, 0
    for i in range(n + 2):
        out[i] = F0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        x0, y0, x1, y1 = corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1]
        sign = 1.0
        if y0 > y1:
            x0, y0, x1, y1, sign = x1, y1, x0, y0, -1.0
        low, high = max(y0, row + 0.0), min(y1, row + 1.0)
        if high - low <= 1e-12:
            continue
        slope = (x1 - x0) / (y1 - y0)
        xa, xb = x0 + slope * (low - y0) - a, x0 + slope * (high - y0) - a
        d = sign * (high - low)
        if xa > xb:
            xa, xb = xb, xa
        if xa < 0.0:  # what is left of the image covers all from its first column on
            part = 1.0 if xb <= 0.0 else -xa / (xb - xa)
            out[0] += np.float32(d * part)
            d, xa = d * (1.0 - part), 0.0
            if xb <= 0.0:
                continue
        if xb > n:  # what is right of it covers nothing in it
            if xa >= n:
                continue
            part = (n - xa) / (xb - xa)
            d, xb = d * part, n + 0.0
        deposit(xa, xb, d, out)
    total = F0
    for i in range(n):
        total += out[i]
        out[i] = min(F1, abs(total))
    return a, b
