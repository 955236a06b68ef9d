"""Convex polyhedra with painted details: the faces of one body add up to its hull's exact coverage, without seams.

Where two faces meet that are both seen, coverage does not change, and depth and colour change by their difference: such an edge is
followed once. An edge is followed down many rows at a time; running sums along the rows then give the pixels.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import INT, allocating_kernel, inlined, kernel
from pedcross_env.camera.kernels.polygons import (
    MAX_CORNERS,
    NEAR_M,
    grow,
    project_clipped,
    step_shares,
)
from pedcross_env.camera.kernels.rows import F0, F1, TINY, add_row, merge_row

__all__ = ["PLACED", "draw_polyhedron", "fineness", "polyhedron_work"]

MAX_FACES = 96
MAX_ROWS, AREA_PX = 256, 4096  # worked on at a time: fits the caches
NOWHERE = 1 << 30
FINE_PX_PER_M = 18.0  # fine details are gone at this resolution, whole at twice of it
PLACED = 5  # a corner: x, y, z in camera coordinates, column and row where it is not nearer than NEAR_M
STEPS, COVER, INVERSE, SLOPE, COLOUR = 0, 1, 2, 3, 4  # planes of the work space
# an edge: row of its upper and of its lower end, column of its upper end, columns per row, and what begins right of it: coverage,
# inverse depth (per column, per row, constant), colours
TOP, BOTTOM, AT, LEAN, COVERS, PLANE, COLOURS = 0, 1, 2, 3, 4, 5, 8


@allocating_kernel
def polyhedron_work(channels, width):
    """Allocate what ``draw_polyhedron`` works in."""
    return (
        np.empty((MAX_FACES * MAX_CORNERS, COLOURS + channels)), np.empty((MAX_FACES, 3), np.int64),
        np.empty((MAX_CORNERS, 3)), np.empty((MAX_CORNERS, 2)),
        np.zeros((COLOUR + channels, max(AREA_PX, width + 2)), np.float32), np.empty(width + 3, np.float32),
        np.empty((2, MAX_ROWS, 2), np.int64),
    )  # fmt: skip


@inlined
def fineness(detail, focal, z):
    """Share at which a face is drawn: details of a centimetre or two fade out where a pixel is much wider."""
    return 1.0 if detail < 2 else min(1.0, max(0.0, focal / (FINE_PX_PER_M * max(z, NEAR_M)) - 1.0))


@inlined
def _line(x0, y0, x1, y1, edge):
    """Fill where an edge runs; return its sense: 1 down, -1 up, 0 level."""
    sense = 0.0 if abs(y1 - y0) < 1e-9 else (1.0 if y0 < y1 else -1.0)
    edge[TOP], edge[BOTTOM] = min(y0, y1), max(y0, y1)
    edge[AT] = x0 if y0 < y1 else x1
    edge[LEAN] = (x1 - x0) / (y1 - y0)
    return sense


@kernel
def _begin(edge, sense, face, other, facing, colours):
    """Fill what begins right of an edge of a face; ``other`` is the face that ends there, -1 for none."""
    edge[COVERS] = sense if other < 0 else 0.0
    for k in range(3):
        edge[PLANE + k] = sense * (facing[face, k] - (facing[other, k] if other >= 0 else 0.0))
    for c in range(colours.shape[1]):
        edge[COLOURS + c] = sense * (colours[face, c] - (colours[other, c] if other >= 0 else F0))


@kernel
def _add_edges(face, n, base, whole, mesh, placed, facing, colours, optics, work):
    """Append a face's edges, but those that a face before it has in common with it; return the number of edges."""
    face_start, face_corners, _, beyond = mesh
    edges, _, near, corners, _, _, _ = work
    s, e = face_start[base + face], face_start[base + face + 1]
    if whole:
        for k in range(s, e):
            other = beyond[k] - base
            if other >= 0 and facing[other, 3] > 0.0:
                if other < face:
                    continue
            else:
                other = -1
            p, q = placed[face_corners[k]], placed[face_corners[k + 1 if k + 1 < e else s]]
            sense = _line(p[3], p[4], q[3], q[4], edges[n])
            if sense != 0.0:
                _begin(edges[n], sense, face, other, facing, colours)
                n += 1
        return n
    for k in range(s, e):
        for j in range(3):
            near[k - s, j] = placed[face_corners[k], j]
    count = project_clipped(near, e - s, optics[0], optics[1], optics[2], corners)
    for i in range(count if count >= 3 else 0):
        j = i + 1 if i + 1 < count else 0
        sense = _line(corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1], edges[n])
        if sense != 0.0:
            _begin(edges[n], sense, face, -1, facing, colours)
            n += 1
    return n


@kernel
def _collect(first, last, base, whole, mesh, placed, facing, colours, optics, work):
    """Gather the edges of the faces that are seen: those that bound the body, then those of each face painted on it.

    Returns:
        The number of edges that bound the body, and of painted faces, filled in: face, first edge, edge beyond the last.
    """
    details, painted = mesh[2], work[1]
    n = INT(0)
    for face in range(first - base, last - base):
        if facing[face, 3] > 0.0 and details[base + face] == 0:
            n = _add_edges(face, n, base, whole, mesh, placed, facing, colours, optics, work)
    bounding, paints = n, INT(0)
    for face in range(first - base, last - base):
        if facing[face, 3] > 0.0 and details[base + face] != 0:
            painted[paints, 0], painted[paints, 1] = face, n
            n = _add_edges(face, n, base, whole, mesh, placed, facing, colours, optics, work)
            painted[paints, 2] = n
            paints += 1 if n > painted[paints, 1] else 0
    return bounding, paints


@kernel
def _box(edges, count, size):
    """Return the rows (from, beyond) and columns (from, beyond) of the image that edges enclose."""
    top, bottom, left, right = 1e9, -1e9, 1e9, -1e9
    for e in range(count):
        edge = edges[e]
        below = edge[AT] + edge[LEAN] * (edge[BOTTOM] - edge[TOP])
        top, bottom = min(top, edge[TOP]), max(bottom, edge[BOTTOM])
        left, right = min(left, edge[AT], below), max(right, edge[AT], below)
    height, width = size
    top, bottom = max(top, 0.0), min(bottom, height + 0.0)
    left, right = max(left, 0.0), min(right, width + 0.0)
    if top >= bottom or left >= right:
        return 0, 0, 0, 0
    return int(top), int(math.ceil(bottom)), int(left), int(math.ceil(right))


@kernel
def _forget(touched, rows):
    for r in range(rows):
        touched[r, 0], touched[r, 1] = NOWHERE, 0


@kernel
def _step_body(edges, count, area, sums, shares, touched):
    """Add the steps of coverage, inverse depth (counted from the area's first column: less is lost to rounding) and colour at the
    edges that bound a body.

    ``area`` is (first row, row beyond the last, first column, columns); ``touched`` has the columns of each row's first and last step.
    """
    top, bottom, left, columns = area
    colourful = sums.shape[0] > COLOUR + 1
    for e in range(count):
        edge = edges[e]
        y0, y1, at, lean = edge[TOP], edge[BOTTOM], edge[AT] - left, edge[LEAN]
        cover, slope, colour = np.float32(edge[COVERS]), np.float32(edge[PLANE]), np.float32(edge[COLOURS])
        for row in range(max(top, int(math.floor(y0))), min(bottom, int(math.ceil(y1)))):
            low, high = max(y0, row + 0.0), min(y1, row + 1.0)
            first, n = step_shares(
                at + lean * (low - y0), at + lean * (high - y0), high - low, columns, shares
            )
            r = row - top
            k = r * (columns + 2) + first
            inverse = np.float32(edge[PLANE] * left + edge[PLANE + 1] * (row + 0.5) + edge[PLANE + 2])
            for i in range(n):
                share = shares[i]
                sums[COVER, k + i] += share * cover
                sums[INVERSE, k + i] += share * inverse
                sums[SLOPE, k + i] += share * slope
                sums[COLOUR, k + i] += share * colour
            if colourful:
                green, blue = np.float32(edge[COLOURS + 1]), np.float32(edge[COLOURS + 2])
                for i in range(n):
                    sums[COLOUR + 1, k + i] += shares[i] * green
                    sums[COLOUR + 2, k + i] += shares[i] * blue
            touched[r, 0], touched[r, 1] = min(touched[r, 0], first), max(touched[r, 1], first + n - 1)


@kernel
def _depth_range(first, last, base, whole, mesh, placed, facing):
    """Least and greatest inverse depth of the faces that are seen and bound the body."""
    face_start, face_corners, details, _ = mesh
    near, far = (1e9, NEAR_M) if whole else (NEAR_M, NEAR_M)
    for face in range(first, last):
        if facing[face - base, 3] > 0.0 and details[face] == 0:
            for k in range(face_start[face], face_start[face + 1]):
                z = placed[face_corners[k], 2]
                near, far = min(near, z), max(far, z)
    return np.float32(1.0 / far), np.float32(1.0 / max(near, NEAR_M))


@kernel
def _sum_up(area, xs, least, most, sums, touched):
    """Turn steps into coverage, inverse depth and colours by running sums along the rows.

    A face's plane is read at a pixel's middle, which the face need not reach: seen nearly edge-on, that is far beyond it. What is
    seen of it in the pixel lies between its corners' depths.
    """
    top, bottom, _, columns = area
    colourful = sums.shape[0] > COLOUR + 1
    for r in range(bottom - top):
        a, b = touched[r, 0], min(columns, touched[r, 1])
        at = r * (columns + 2)
        cover = inverse = slope = red = green = blue = F0
        for i in range(a, b):
            cover += sums[COVER, at + i]
            inverse += sums[INVERSE, at + i]
            slope += sums[SLOPE, at + i]
            red += sums[COLOUR, at + i]
            share = F1 / cover if abs(cover) > TINY else F0
            sums[COVER, at + i] = min(F1, abs(cover))
            sums[INVERSE, at + i] = min(most, max(least, (inverse + slope * xs[i]) * share))
            sums[COLOUR, at + i] = red * share
            if colourful:
                green += sums[COLOUR + 1, at + i]
                blue += sums[COLOUR + 2, at + i]
                sums[COLOUR + 1, at + i] = green * share
                sums[COLOUR + 2, at + i] = blue * share


@kernel
def _step_paint(edges, first, last, area, steps, shares, touched):
    """Add the steps of coverage at the edges of one face; see ``_step_body``."""
    top, bottom, left, columns = area
    for e in range(first, last):
        edge = edges[e]
        y0, y1, at, lean, sense = edge[TOP], edge[BOTTOM], edge[AT] - left, edge[LEAN], edge[COVERS]
        for row in range(max(top, int(math.floor(y0))), min(bottom, int(math.ceil(y1)))):
            low, high = max(y0, row + 0.0), min(y1, row + 1.0)
            f, n = step_shares(
                at + lean * (low - y0), at + lean * (high - y0), sense * (high - low), columns, shares
            )
            r = row - top
            k = r * (columns + 2) + f
            for i in range(n):
                steps[k + i] += shares[i]
            touched[r, 0], touched[r, 1] = min(touched[r, 0], f), max(touched[r, 1], f + n - 1)


@kernel
def _paint(strength, colour, area, sums, body, touched):
    """Paint one face over the body's colours, where the body has pixels; clear its steps."""
    top, bottom, _, columns = area
    for r in range(bottom - top):
        total = F0
        at = r * (columns + 2)
        for i in range(touched[r, 0], touched[r, 1]):
            total += sums[STEPS, at + i]
            sums[STEPS, at + i] = F0
            if body[r, 0] <= i < body[r, 1]:
                share = strength * min(F1, abs(total) / max(sums[COVER, at + i], TINY))
                for c in range(colour.shape[0]):
                    sums[COLOUR + c, at + i] += share * (colour[c] - sums[COLOUR + c, at + i])
        sums[STEPS, at + touched[r, 1]] = F0


@kernel
def _unite(area, sums, touched, scratch, spans, behind):
    """Unite the pixels with their object's and clear the work space."""
    top, bottom, left, columns = area
    for r in range(bottom - top):
        a, b = touched[r, 0], min(columns, touched[r, 1])
        if b > a:
            at = r * (columns + 2) + a
            if behind:
                add_row(sums, COLOUR, COVER, INVERSE, at, scratch, top + r, left + a, left + b)
            else:
                merge_row(sums, COLOUR, COVER, INVERSE, at, scratch, top + r, left + a, left + b)
            grow(spans, top + r, left + a, left + b)
    for k in range(COVER, sums.shape[0]):
        for i in range((bottom - top) * (columns + 2)):
            sums[k, i] = F0


@kernel
def draw_polyhedron(
    first, last, base, whole, mesh, placed, facing, colours, optics, xs, size, scratch, work, spans, behind
):
    """Draw one convex polyhedron into its object's scratch planes.

    Args:
        first: First face of the polyhedron.
        last: Beyond its last face.
        base: First face that ``facing`` and ``colours`` have.
        whole: Whether nothing of it is nearer than NEAR_M.
        mesh: (where a face's corners start, the corners' numbers, 0 for a face that bounds the body and more for one that is painted
            on it, the face beyond each edge) as camera.model_table.ModelTable.
        placed: (V, PLACED) float64 corners.
        facing: Of each face from ``base`` on its inverse depth per column, per row and constant, and how strongly it is painted:
            0 where it is not to be drawn.
        colours: (C,) float32 radiance of each of them.
        optics: (focal, cx, cy).
        xs: (W,) float32 pixel centres.
        size: (height, width).
        scratch: (planes (C, H, W), alpha (H, W), inverse depth (H, W)).
        work: From ``polyhedron_work``.
        spans: What the object covers, extended by ``grow``.
        behind: Whether it stands behind all that its object has already (see ``rows.add_row``), not among it by depth.
    """
    edges, painted, _, _, sums, shares, touched = work
    count, paints = _collect(first, last, base, whole, mesh, placed, facing, colours, optics, work)
    least, most = _depth_range(first, last, base, whole, mesh, placed, facing)
    top, bottom, left, right = _box(edges, count, size)
    columns = right - left
    step = min(MAX_ROWS, sums.shape[1] // (columns + 2))
    for row in range(top, bottom, step):
        area = (row, min(bottom, row + step), left, columns)
        _forget(touched[0], area[1] - row)
        _step_body(edges, count, area, sums, shares, touched[0])
        _sum_up(area, xs, least, most, sums, touched[0])
        for p in range(paints):
            face = painted[p, 0]
            _forget(touched[1], area[1] - row)
            _step_paint(edges, painted[p, 1], painted[p, 2], area, sums[STEPS], shares, touched[1])
            _paint(np.float32(facing[face, 3]), colours[face], area, sums, touched[0], touched[1])
        _unite(area, sums, touched[0], scratch, spans, behind)
