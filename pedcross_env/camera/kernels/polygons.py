"""Convex polygons: clipping, projection and exact pixel coverage.

Coverage is the area of polygon and pixel in common: it changes smoothly with any motion.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.rows import F0, F1, HALF

__all__ = [
    "MAX_CORNERS",
    "NEAR_M",
    "cover_row",
    "grow",
    "project_clipped",
    "row_range",
    "slanted_edges",
    "step_shares",
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


@inlined
def step_shares(x0, x1, share, columns, out):
    """Fill the steps of coverage, column by column, of an edge that crosses ``share`` of a row's height between x0 and x1.

    The running sum over all edges of a polygon is the area that it has in common with each pixel of the row. What is left of the
    columns begins with the first of them; an edge right of them leaves nothing in the two columns beyond the last.

    Returns:
        The first column and the number of columns, at least two.
    """
    x0, x1 = min(x0, x1), max(x0, x1)
    outside = 0.0
    if x0 < 0.0:
        outside = share if x1 <= 0.0 else share * x0 / (x0 - x1)
        share -= outside
        x0, x1 = 0.0, max(x1, 0.0)
    if x1 > columns:
        share *= (columns - x0) / (x1 - x0) if x0 < columns else 0.0
        x0, x1 = min(x0, columns + 0.0), columns + 0.0
    first = int(x0)
    n = max(2, int(math.ceil(x1)) - first + 1)
    if n == 2:
        middle = share * (0.5 * (x0 + x1) - first)
        out[0] = share - middle + outside
        out[1] = middle
    else:
        slope = share / (x1 - x0)
        f0, f1 = first + 1.0 - x0, x1 - (first + n - 2)
        begin, end = 0.5 * slope * f0 * f0, 0.5 * slope * f1 * f1
        out[0] = begin + outside
        if n == 3:
            out[1] = share - begin - end
        else:
            second = slope * (f0 + 0.5)
            out[1] = second - begin
            for k in range(2, n - 2):
                out[k] = slope
            out[n - 2] = share - second - (n - 4) * slope - end
        out[n - 1] = end
    return first, n


@kernel
def slanted_edges(corners, count, out):
    """Fill the (E, 5) slanted edges of a polygon (upper and lower end, column at the upper, columns per row, sense); return E."""
    n = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        x0, y0, x1, y1 = corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1]
        if abs(y1 - y0) < 1e-9:
            continue
        sense = 1.0
        if y0 > y1:
            x0, y0, x1, y1, sense = x1, y1, x0, y0, -1.0
        out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = y0, y1, x0, (x1 - x0) / (y1 - y0), sense
        n += 1
    return n


@kernel
def _add_constant(value, out):
    for i in range(out.shape[0]):
        out[i] += value


@kernel
def _add_slanted(x0, x1, d, out):
    """Add what lies right of a line that crosses ``d`` of the row's height evenly between columns x0 and x1."""
    inv = F1 / (x1 - x0)
    for i in range(out.shape[0]):
        left = np.float32(np.int32(i))  # 32 bits: twice as many at a time
        right = left + F1
        p, q = min(max(left, x0), x1), min(max(right, x0), x1)
        out[i] += d * ((right - q) + (q - p) * (HALF * (p + q) - x0) * inv)


@kernel
def _unsigned(out):
    for i in range(out.shape[0]):
        out[i] = min(F1, abs(out[i]))


@kernel
def cover_row(edges, count, row, width, out):
    """Exact share of each pixel of a row that a convex polygon covers: what lies right of its edges, with their senses.

    Args:
        edges: (E, 5) from ``slanted_edges``.
        count: E.
        row: Which row.
        width: Of the image.
        out: Filled from 0 with the coverage of the columns returned.

    Returns:
        First column and the column beyond the last.
    """
    low, high = width + 0.0, 0.0
    for e in range(count):
        y0, y1 = max(edges[e, 0], row + 0.0), min(edges[e, 1], row + 1.0)
        if y1 - y0 > 1e-12:
            x0 = edges[e, 2] + edges[e, 3] * (y0 - edges[e, 0])
            x1 = x0 + edges[e, 3] * (y1 - y0)
            low, high = min(low, x0, x1), max(high, x0, x1)
    a, b = int(max(low, 0.0)), int(math.ceil(min(high, width + 0.0)))
    if b <= a:
        return 0, 0
    for i in range(b - a):
        out[i] = F0
    for e in range(count):
        y0, y1 = max(edges[e, 0], row + 0.0), min(edges[e, 1], row + 1.0)
        if y1 - y0 <= 1e-12:
            continue
        x0 = edges[e, 2] + edges[e, 3] * (y0 - edges[e, 0]) - a
        x1 = x0 + edges[e, 3] * (y1 - y0)
        if x0 > x1:
            x0, x1 = x1, x0
        if x1 - x0 < 1e-3:  # as good as upright
            x0, x1 = 0.5 * (x0 + x1) - 5e-4, 0.5 * (x0 + x1) + 5e-4
        first, last = int(min(max(x0, 0.0), b - a)), int(math.ceil(min(max(x1, 0.0), b - a)))
        d = np.float32(edges[e, 4] * (y1 - y0))
        if last > first:
            _add_slanted(np.float32(x0 - first), np.float32(x1 - first), d, out[first:last])
        if b - a > last:
            _add_constant(d, out[last : b - a])
    _unsigned(out[: b - a])
    return a, b
