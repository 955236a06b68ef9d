"""Convex polyhedra: clipping, projection, faces that share a hull, painted details."""

from __future__ import annotations

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import kernel

from pedcross_env.camera.kernels.rows import F0, F1, add_face, coverage_row, lerp_row, merge_row

__all__ = [
    "MAX_CORNERS",
    "NEAR_M",
    "draw_polyhedron",
    "grow",
    "hull_2d",
    "polygon_edges",
    "polyhedron_work",
    "project_clipped",
]

NEAR_M = 0.1
MAX_CORNERS = 24  # of a clipped face
MAX_FACES = 40
TRACE = np.float32(1e-3)


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
def polygon_edges(corners, count, edges):
    """Fill L1-normalised edges of a convex polygon, positive inside; return their number."""
    area = 0.0
    for i in range(count):
        j = (i + 1) % count
        area += corners[i, 0] * corners[j, 1] - corners[j, 0] * corners[i, 1]
    sign = 1.0 if area > 0 else -1.0
    n = 0
    for i in range(count):
        j = (i + 1) % count
        a = -sign * (corners[j, 1] - corners[i, 1])
        b = sign * (corners[j, 0] - corners[i, 0])
        norm = abs(a) + abs(b)
        if norm > 1e-9:
            edges[n, 0] = a / norm
            edges[n, 1] = b / norm
            edges[n, 2] = -(a * corners[i, 0] + b * corners[i, 1]) / norm
            n += 1
    return n


@kernel
def _row_range(corners, count, height):
    low, high = corners[0, 1], corners[0, 1]
    for i in range(1, count):
        low, high = min(low, corners[i, 1]), max(high, corners[i, 1])
    low, high = max(-1.0, low), min(height + 1.0, high)
    return max(0, int(np.floor(low - 0.5))), min(height, int(np.ceil(high + 0.5)))


@kernel
def _column_range(corners, count, row, width):
    """Columns that a convex polygon can touch within one row (with the half-pixel ramp)."""
    low, high = 1e9, -1e9
    top, bottom = row - 0.5, row + 1.5
    for i in range(count):
        j = (i + 1) % count
        x0, y0, x1, y1 = corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1]
        if max(y0, y1) < top or min(y0, y1) > bottom:
            continue
        if abs(y1 - y0) > 1e-9:
            s0 = min(1.0, max(0.0, (top - y0) / (y1 - y0)))
            s1 = min(1.0, max(0.0, (bottom - y0) / (y1 - y0)))
            xa, xb = x0 + s0 * (x1 - x0), x0 + s1 * (x1 - x0)
        else:
            xa, xb = x0, x1
        low, high = min(low, min(xa, xb)), max(high, max(xa, xb))
    low, high = max(-2.0, low), min(width + 2.0, high)
    return max(0, int(np.floor(low - 1.0))), min(width, int(np.ceil(high + 1.0)))


@kernel
def _cross(ox, oy, ax, ay, bx, by):
    return (ax - ox) * (by - oy) - (ay - oy) * (bx - ox)


@kernel
def hull_2d(points, count, order, out):
    """Convex hull of 2-D points (monotone chain); return its number of corners."""
    for i in range(count):
        order[i] = i
    for i in range(1, count):  # insertion sort: few points
        k = order[i]
        j = i - 1
        while j >= 0 and (
            points[order[j], 0] > points[k, 0]
            or (points[order[j], 0] == points[k, 0] and points[order[j], 1] > points[k, 1])
        ):
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = k
    n = 0
    for i in range(count):
        x, y = points[order[i], 0], points[order[i], 1]
        while n >= 2 and _cross(out[n - 2, 0], out[n - 2, 1], out[n - 1, 0], out[n - 1, 1], x, y) <= 0:
            n -= 1
        out[n, 0], out[n, 1] = x, y
        n += 1
    lower = n + 1
    for i in range(count - 2, -1, -1):
        x, y = points[order[i], 0], points[order[i], 1]
        while n >= lower and _cross(out[n - 2, 0], out[n - 2, 1], out[n - 1, 0], out[n - 1, 1], x, y) <= 0:
            n -= 1
        out[n, 0], out[n, 1] = x, y
        n += 1
    return n - 1


@kernel
def grow(box, u0, u1, v0, v1):
    """Extend an object's bounding box (u0, u1, v0, v1)."""
    box[0], box[1] = min(box[0], u0), max(box[1], u1)
    box[2], box[3] = min(box[2], v0), max(box[3], v1)


@kernel
def _row_of_faces(
    n_faces,
    faces,
    counts,
    shapes,
    sizes,
    planes_iz,
    colours,
    y,
    row,
    a,
    b,
    xs,
    hull,
    hull_count,
    buf,
    draw_details,
):
    """Sum the faces of one row into buf: 0 hull coverage, 1 weight, 2 inverse depth, 3 coverage, 4.. colours."""
    width = b - a
    for k in range(n_faces):
        if draw_details[k]:
            continue
        f0, f1 = _column_range(shapes[k], sizes[k], row, xs.shape[0])
        f0, f1 = max(f0, a), min(f1, b)
        if f1 <= f0:
            continue
        coverage_row(faces[k], counts[k], y, xs[f0:f1], buf[12:16, f0 - a : f1 - a], buf[3, f0 - a : f1 - a])
        part = slice(f0 - a, f1 - a)
        add_face(
            xs[f0:f1], buf[3, part], np.float32(planes_iz[k, 1] * y + planes_iz[k, 2]), np.float32(planes_iz[k, 0]),
            buf[1, part], buf[2, part],
        )  # fmt: skip
        for c in range(colours.shape[1]):
            _accumulate(buf[3, part], colours[k, c], buf[4 + c, part])
    coverage_row(hull, hull_count, y, xs[a:b], buf[12:16, :width], buf[0, :width])
    for c in range(colours.shape[1]):
        _divide(buf[4 + c, :width], buf[1, :width])
    _divide(buf[2, :width], buf[1, :width])


@kernel
def _accumulate(coverage, value, plane):
    for i in range(plane.shape[0]):
        plane[i] += coverage[i] * value


@kernel
def _divide(plane, weight):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] / max(weight[i], np.float32(1e-6))


@kernel
def _largest(shapes, sizes, painted, count):
    """Index of the largest projected face that bounds the hull."""
    best, largest = 0, -1.0
    for k in range(count):
        if painted[k]:
            continue
        area = 0.0
        for i in range(sizes[k]):
            j = (i + 1) % sizes[k]
            area += shapes[k, i, 0] * shapes[k, j, 1] - shapes[k, j, 0] * shapes[k, i, 1]
        if abs(area) > largest:
            best, largest = k, abs(area)
    return best


@kernel
def _start_row(xs, inverse0, inverse_slope, shade, buf):
    """Start a row's sums with a trace of the largest face, which is what the hull shows where no face has coverage."""
    for i in range(xs.shape[0]):
        buf[1, i] = TRACE
        buf[2, i] = TRACE * max(F0, inverse0 + inverse_slope * xs[i])
    for c in range(shade.shape[0]):
        for i in range(xs.shape[0]):
            buf[4 + c, i] = TRACE * shade[c]


@njit(cache=True)
def polyhedron_work(channels):
    """Allocate what ``draw_polyhedron`` works in."""
    return (
        np.empty((MAX_FACES, MAX_CORNERS, 2)), np.empty(MAX_FACES, np.int64), np.empty((MAX_FACES, MAX_CORNERS, 3), np.float32),
        np.empty(MAX_FACES, np.int64), np.empty((MAX_FACES, 3)), np.empty((MAX_FACES, channels), np.float32),
        np.empty(MAX_FACES, np.bool_), np.empty((MAX_FACES, 2), np.int64), np.empty((MAX_FACES * MAX_CORNERS, 2)),
        np.empty((MAX_CORNERS, 3)), np.empty(MAX_FACES * MAX_CORNERS, np.int64), np.empty((2 * MAX_FACES * MAX_CORNERS + 2, 2)),
        np.empty((MAX_FACES * MAX_CORNERS, 3), np.float32),
    )  # fmt: skip


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
    box,
):
    """Draw one convex polyhedron into its object's scratch planes.

    Args:
        points: (V, 3) float64 corners, camera coordinates.
        first: First face of the polyhedron.
        last: Beyond its last face.
        face_start: (F + 1,) where a face's corners start in ``face_corners``.
        face_corners: Corner indices, counter-clockwise seen from outside.
        details: (F,) 1 where a face is painted on the hull instead of bounding it.
        colours: (F, C) float32 radiance of each face from ``colour_base`` on.
        colour_base: First face that ``colours`` has.
        optics: (focal, cx, cy).
        xs: (W,) float32 pixel centres.
        size: (height, width).
        scratch: (planes (C, H, W), alpha (H, W), inverse depth (H, W)).
        buf: (24, >= W) float32 work space.
        work: From ``polyhedron_work``.
        box: (4,) int64 bounding box to extend.
    """
    focal, cx, cy = optics
    height, width = size
    planes, alpha, inverse = scratch
    shapes, sizes, edges, counts, slopes, shades, painted, rows, outline, local, order, ring, ring_edges = (
        work
    )
    n, total, top, bottom = 0, 0, height, 0
    for face in range(first, last):
        s, e = face_start[face], face_start[face + 1]
        count = e - s
        for i in range(count):
            for k in range(3):
                local[i, k] = points[face_corners[s + i], k]
        nx = ny = nz = 0.0
        for i in range(count):  # Newell's normal
            j = (i + 1) % count
            nx += (local[i, 1] - local[j, 1]) * (local[i, 2] + local[j, 2])
            ny += (local[i, 2] - local[j, 2]) * (local[i, 0] + local[j, 0])
            nz += (local[i, 0] - local[j, 0]) * (local[i, 1] + local[j, 1])
        facing = nx * local[0, 0] + ny * local[0, 1] + nz * local[0, 2]
        if facing >= -1e-12:
            continue
        sizes[n] = project_clipped(local, count, focal, cx, cy, shapes[n])
        if sizes[n] < 3:
            continue
        rows[n, 0], rows[n, 1] = _row_range(shapes[n], sizes[n], height)
        counts[n] = polygon_edges(shapes[n], sizes[n], edges[n])
        slopes[n, 0] = nx / focal / facing
        slopes[n, 1] = ny / focal / facing
        slopes[n, 2] = (nz - (nx * cx + ny * cy) / focal) / facing
        painted[n] = details[face] != 0
        for c in range(colours.shape[1]):
            shades[n, c] = colours[face - colour_base, c]
        if not painted[n]:
            for i in range(sizes[n]):
                outline[total, 0], outline[total, 1] = shapes[n, i, 0], shapes[n, i, 1]
                total += 1
            top, bottom = min(top, rows[n, 0]), max(bottom, rows[n, 1])
        n += 1
    if total < 3 or bottom <= top:
        return
    main = _largest(shapes, sizes, painted, n)
    ring_count = hull_2d(outline, total, order, ring)
    if ring_count < 3:
        return
    ring_edge_count = polygon_edges(ring, ring_count, ring_edges)
    for row in range(top, bottom):
        a, b = _column_range(ring, ring_count, row, width)
        if b <= a:
            continue
        y = np.float32(row + 0.5)
        _start_row(
            xs[a:b],
            np.float32(slopes[main, 1] * y + slopes[main, 2]),
            np.float32(slopes[main, 0]),
            shades[main],
            buf[:, : b - a],
        )
        _row_of_faces(
            n, edges, counts, shapes, sizes, slopes, shades, y, row, a, b, xs, ring_edges, ring_edge_count, buf, painted,
        )  # fmt: skip
        for k in range(n):
            if painted[k] and rows[k, 0] <= row < rows[k, 1]:
                f0, f1 = _column_range(shapes[k], sizes[k], row, width)
                f0, f1 = max(f0, a), min(f1, b)
                if f1 > f0:
                    part = slice(f0 - a, f1 - a)
                    coverage_row(edges[k], counts[k], y, xs[f0:f1], buf[12:16, part], buf[3, part])
                    for c in range(colours.shape[1]):
                        lerp_row(buf[3, part], shades[k, c], buf[4 + c, part])
        merge_row(
            buf[4 : 4 + planes.shape[0], : b - a], buf[0, : b - a], buf[2, : b - a],
            planes[:, row, a:b], alpha[row, a:b], inverse[row, a:b], buf[12:14, : b - a],
        )  # fmt: skip
        grow(box, a, b, row, row + 1)
