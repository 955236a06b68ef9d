"""Convex polygons and polyhedra: clipping, projection, exact pixel coverage, faces with painted details.

Coverage is the area of polygon and pixel in common: it changes smoothly with any motion, and the faces of one body add up to
their hull's coverage without seams.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.rows import F0, F1, merge_row

__all__ = [
    "MAX_CORNERS",
    "NEAR_M",
    "cover_row",
    "draw_polyhedron",
    "fineness",
    "grow",
    "polyhedron_work",
    "project_clipped",
    "row_range",
]

NEAR_M = 0.1
MAX_CORNERS = 24  # of a clipped face
MAX_FACES = 64
FINE_PX_PER_M = 18.0  # fine details are gone at this resolution, whole at twice of it


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
def _deposit(x0, x1, d, out):
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
        _deposit(xa, xb, d, out)
    total = F0
    for i in range(n):
        total += out[i]
        out[i] = min(F1, abs(total))
    return a, b


@kernel
def _add_face(xs, coverage, inverse0, inverse_slope, weight, inverse):
    for i in range(xs.shape[0]):
        weight[i] += coverage[i]
        inverse[i] += coverage[i] * max(F0, inverse0 + inverse_slope * xs[i])


@kernel
def _add_colour(coverage, value, plane):
    for i in range(plane.shape[0]):
        plane[i] += coverage[i] * value


@kernel
def _divide(plane, weight):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] / max(weight[i], np.float32(1e-6))


@kernel
def _saturate(weight):
    for i in range(weight.shape[0]):
        weight[i] = min(F1, weight[i])


@kernel
def _paint(coverage, weight, strength, value, plane):
    for i in range(plane.shape[0]):
        share = strength * min(F1, coverage[i] / max(weight[i], np.float32(1e-6)))
        plane[i] += share * (value - plane[i])


@njit(cache=True)
def polyhedron_work(channels):
    """Allocate what ``draw_polyhedron`` works in."""
    return (
        np.empty((MAX_FACES, MAX_CORNERS, 2)), np.empty((MAX_FACES, 4), np.int64), np.empty((MAX_FACES, 4)),
        np.empty((MAX_FACES, channels), np.float32), np.empty((MAX_CORNERS, 3)),
    )  # fmt: skip


@inlined
def fineness(detail, focal, z):
    """Share at which a face is drawn: details of a centimetre or two fade out where a pixel is much wider."""
    return 1.0 if detail < 2 else min(1.0, max(0.0, focal / (FINE_PX_PER_M * max(z, NEAR_M)) - 1.0))


@kernel
def _collect(
    points, first, last, face_start, face_corners, details, colours, colour_base, optics, height, work
):
    """Project the faces that are seen; return their number and the rows they touch.

    Fills the work arrays: corners, (count, painted, first row, row beyond), inverse-depth planes, colours.
    """
    shapes, facts, slopes, shades, local = work
    focal, cx, cy = optics
    n, top, bottom = 0, height, 0
    for face in range(first, last):
        s = face_start[face]
        count = face_start[face + 1] - s
        for i in range(count):
            for k in range(3):
                local[i, k] = points[face_corners[s + i], k]
        nx = ny = nz = 0.0
        for i in range(count):  # Newell's normal
            j = i + 1 if i + 1 < count else 0
            nx += (local[i, 1] - local[j, 1]) * (local[i, 2] + local[j, 2])
            ny += (local[i, 2] - local[j, 2]) * (local[i, 0] + local[j, 0])
            nz += (local[i, 0] - local[j, 0]) * (local[i, 1] + local[j, 1])
        facing = nx * local[0, 0] + ny * local[0, 1] + nz * local[0, 2]
        if facing >= -1e-12 or n == MAX_FACES:
            continue
        share = fineness(details[face], focal, local[0, 2])
        if share <= 0.0:
            continue
        corners = project_clipped(local, count, focal, cx, cy, shapes[n])
        if corners < 3:
            continue
        slopes[n, 3] = share
        facts[n, 0], facts[n, 1] = corners, min(1, details[face])
        facts[n, 2], facts[n, 3] = row_range(shapes[n], corners, height)
        slopes[n, 0] = nx / focal / facing
        slopes[n, 1] = ny / focal / facing
        slopes[n, 2] = (nz - (nx * cx + ny * cy) / focal) / facing
        for c in range(colours.shape[1]):
            shades[n, c] = colours[face - colour_base, c]
        if details[face] == 0:
            top, bottom = min(top, facts[n, 2]), max(bottom, facts[n, 3])
        n += 1
    return n, top, bottom


@kernel
def draw_polyhedron(
    points,
    first,
    last,
    face_start,
    face_corners,
    details,
    colours,
    colour_base,
    optics,
    xs,
    size,
    scratch,
    buf,
    work,
    spans,
):
    """Draw one convex polyhedron into its object's scratch planes.

    Args:
        points: (V, 3) float64 corners, camera coordinates.
        first: First face of the polyhedron.
        last: Beyond its last face.
        face_start: (F + 1,) where a face's corners start in ``face_corners``.
        face_corners: Corner indices, counter-clockwise seen from outside.
        details: (F,) 1 where a face is painted on the others instead of bounding the body, 2 where it fades out with the distance.
        colours: (F, C) float32 radiance of each face from ``colour_base`` on.
        colour_base: First face that ``colours`` has.
        optics: (focal, cx, cy).
        xs: (W,) float32 pixel centres.
        size: (height, width).
        scratch: (planes (C, H, W), alpha (H, W), inverse depth (H, W)).
        buf: (24, >= W + 2) float32 work space.
        work: From ``polyhedron_work``.
        spans: What the object covers, extended by ``grow``.
    """
    height, width = size
    shapes, facts, slopes, shades = work[0], work[1], work[2], work[3]
    channels = scratch[0].shape[0]
    n, top, bottom = _collect(
        points, first, last, face_start, face_corners, details, colours, colour_base, optics, height, work
    )
    for row in range(top, bottom):
        a, b = width, 0
        for k in range(n):
            if facts[k, 1] == 0 and facts[k, 2] <= row < facts[k, 3]:
                f0, f1 = _column_range(shapes[k], facts[k, 0], row, width)
                if f1 > f0:
                    a, b = min(a, f0), max(b, f1)
        m = b - a
        if m <= 0:
            continue
        y = row + 0.5
        for k in range(1, 3 + channels):
            for i in range(m):
                buf[k, i] = F0
        for painted in range(2):
            for k in range(n):
                if facts[k, 1] != painted or not facts[k, 2] <= row < facts[k, 3]:
                    continue
                f0, f1 = cover_row(shapes[k], facts[k, 0], row, width, buf[0])
                skip = max(0, a - f0)
                f0, f1 = max(f0, a), min(f1, b)
                if f1 <= f0:
                    continue
                cover, part = buf[0, skip : skip + f1 - f0], slice(f0 - a, f1 - a)
                if painted == 0:
                    iz0, iz1 = np.float32(slopes[k, 1] * y + slopes[k, 2]), np.float32(slopes[k, 0])
                    _add_face(xs[f0:f1], cover, iz0, iz1, buf[1, part], buf[2, part])
                    for c in range(channels):
                        _add_colour(cover, shades[k, c], buf[3 + c, part])
                else:
                    for c in range(channels):
                        _paint(cover, buf[1, part], np.float32(slopes[k, 3]), shades[k, c], buf[3 + c, part])
            if painted == 0:
                for k in range(2, 3 + channels):
                    _divide(buf[k, :m], buf[1, :m])
        _saturate(buf[1, :m])
        merge_row(buf, 3, 1, 2, 0, scratch, row, a, b)
        grow(spans, row, a, b)
