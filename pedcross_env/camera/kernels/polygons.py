"""Convex polygons: clipping, projection and exact pixel coverage.

Coverage is the area of polygon and pixel in common: it changes smoothly with any motion.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.rows import F0, F1

__all__ = [
    "MAX_CORNERS",
    "NEAR_M",
    "cover_between",
    "cover_row",
    "grow",
    "project_clipped",
    "row_range",
    "slanted_edges",
    "step_shares",
    "upright_borders",
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


@inlined
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
def cover_row(edges, count, row, width, shares, steps, out):
    """Exact share of each pixel of a row that a convex polygon covers.

    Args:
        edges: (E, 5) from ``slanted_edges``.
        count: E.
        row: Which row.
        width: Of the image.
        shares: (>= W + 2,) work space.
        steps: (>= W + 2,) zeroed; zeroed again on return.
        out: Filled from 0 with the coverage of the columns returned.

    Returns:
        First column and the column beyond the last.
    """
    a, last = width, 0
    for e in range(count):
        y0, y1 = max(edges[e, 0], row + 0.0), min(edges[e, 1], row + 1.0)
        if y1 <= y0:
            continue
        x0, x1 = (
            edges[e, 2] + edges[e, 3] * (y0 - edges[e, 0]),
            edges[e, 2] + edges[e, 3] * (y1 - edges[e, 0]),
        )
        first, n = step_shares(x0, x1, edges[e, 4] * (y1 - y0), width, shares)
        for i in range(n):
            steps[first + i] += shares[i]
        a, last = min(a, first), max(last, first + n - 1)
    total = F0
    for i in range(last - a):
        total += steps[a + i]
        steps[a + i] = F0
        out[i] = min(F1, abs(total))
    steps[last] = F0
    return a, min(last, width)


@inlined
def upright_borders(edges, count, row):
    """Return the two edges that alone bound a row and the rows after it, and the row where that ends: at once if there are more."""
    first = second = -1
    end = 1e9
    for e in range(count):
        if edges[e, 0] < row + 1.0 and edges[e, 1] > row:
            end = row if second >= 0 or edges[e, 0] > row else min(end, edges[e, 1])
            first, second = e, first
    until = int(end) if second >= 0 else row
    return first, second, until


@inlined
def left_of(x0, x1, column):
    """Share of a pixel left of a line that crosses its row evenly between columns x0 and x1."""
    p, q = min(max(x0, column), column + 1.0), min(max(x1, column), column + 1.0)
    if x0 >= column and x1 <= column + 1.0:
        share = 0.5 * (x0 + x1) - column
    else:
        share = (q - column) - (q - p) * (0.5 * (p + q) - x0) / (x1 - x0)
    return np.float32(share)


@inlined
def cover_between(first, second, row, width, out):
    """Exact coverage of a row between two edges of a polygon that cross it from top to bottom; see ``cover_row``."""
    x0, y0 = first[2] + first[3] * (row - first[0]), first[2] + first[3] * (row + 1.0 - first[0])
    x1, y1 = second[2] + second[3] * (row - second[0]), second[2] + second[3] * (row + 1.0 - second[0])
    if x0 + y0 > x1 + y1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    x0, y0, x1, y1 = min(x0, y0), max(x0, y0), min(x1, y1), max(x1, y1)
    a, b = int(min(max(x0, 0.0), width)), int(math.ceil(min(max(y1, 0.0), width)))
    for i in range(b - a):
        out[i] = F1
    for i in range(min(b, int(math.ceil(y0))) - a):
        out[i] -= left_of(x0, y0, a + i)
    for i in range(max(0, int(min(x1, b + 0.0)) - a), b - a):
        out[i] = max(F0, out[i] - (F1 - left_of(x1, y1, a + i)))
    return a, b
