"""Convex polyhedra with painted details: the faces of one body add up to its hull's exact coverage, without seams."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.polygons import (
    MAX_CORNERS,
    NEAR_M,
    deposit,
    grow,
    project_clipped,
    row_range,
)
from pedcross_env.camera.kernels.rows import F0, F1, TINY, fill_row, merge_row

__all__ = ["draw_polyhedron", "fineness", "polyhedron_work"]

MAX_FACES = 64
FINE_PX_PER_M = 18.0  # fine details are gone at this resolution, whole at twice of it
STEPS, COVER, INVERSE, COLOUR, SLOPE = 0, 1, 2, 3, 6  # rows of the work space


@njit(cache=True)
def polyhedron_work(channels):
    """Allocate what ``draw_polyhedron`` works in."""
    return (
        np.empty((MAX_CORNERS, 2)), np.empty((MAX_FACES, MAX_CORNERS, 5)), np.empty((MAX_FACES, 4), np.int64),
        np.empty((MAX_FACES, 4)), np.empty((MAX_FACES, channels), np.float32), np.empty((MAX_CORNERS, 3)),
    )  # fmt: skip


@inlined
def fineness(detail, focal, z):
    """Share at which a face is drawn: details of a centimetre or two fade out where a pixel is much wider."""
    return 1.0 if detail < 2 else min(1.0, max(0.0, focal / (FINE_PX_PER_M * max(z, NEAR_M)) - 1.0))


@kernel
def _edges(corners, count, out):
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
def _collect(
    points, first, last, face_start, face_corners, details, colours, colour_base, optics, height, work
):
    """Project the faces that are seen; return their number and the rows they touch.

    Fills the work arrays: edges, (their number, painted, first row, row beyond), inverse-depth planes and strength, colours.
    """
    corners, edges, facts, slopes, shades, local = work
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
        clipped = project_clipped(local, count, focal, cx, cy, corners)
        if clipped < 3:
            continue
        slopes[n, 3] = share
        facts[n, 0], facts[n, 1] = _edges(corners, clipped, edges[n]), min(1, details[face])
        facts[n, 2], facts[n, 3] = row_range(corners, clipped, height)
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
def _step(edge, row, width, out):
    """Leave an edge's steps of coverage in ``out``; return the columns of the first and the last, none as (width, -1).

    What an edge beyond the image's right border would end reaches on to that border.
    """
    low, high = max(edge[0], row + 0.0), min(edge[1], row + 1.0)
    if high - low <= 1e-12:
        return width, -1
    x0 = edge[2] + edge[3] * (low - edge[0])
    x1 = x0 + edge[3] * (high - low)
    if x0 > x1:
        x0, x1 = x1, x0
    d = edge[4] * (high - low)
    if x0 >= width:
        return width, width
    first = int(x0) if x0 > 0.0 else 0
    if x0 < 0.0:  # what is left of the image covers all from its first column on
        part = 1.0 if x1 <= 0.0 else -x0 / (x1 - x0)
        out[0] += np.float32(d * part)
        if x1 <= 0.0:
            return 0, 0
        d, x0 = d * (1.0 - part), 0.0
    if x1 > width:  # what is right of it covers nothing in it
        part = (width - x0) / (x1 - x0)
        d, x1 = d * part, width + 0.0
    deposit(x0, x1, d, out)
    return first, max(first + 1, int(math.ceil(x1)))


@kernel
def _body_row(n, row, width, work, buf, channels):
    """Add up the steps of all bounding faces, weighted by 1, inverse depth and colour; return the columns they touch."""
    _, edges, facts, slopes, shades, _ = work
    a, b = width, -1
    steps = buf[STEPS]
    for k in range(n):
        if facts[k, 1] != 0 or not facts[k, 2] <= row < facts[k, 3]:
            continue
        constant, slope = np.float32(slopes[k, 1] * (row + 0.5) + slopes[k, 2]), np.float32(slopes[k, 0])
        for e in range(facts[k, 0]):
            first, last = _step(edges[k, e], row, width, steps)
            for i in range(first, last + 1):
                d = steps[i]
                steps[i] = F0
                buf[COVER, i] += d
                buf[INVERSE, i] += d * constant
                buf[SLOPE, i] += d * slope
                for c in range(channels):
                    buf[COLOUR + c, i] += d * shades[k, c]
            a, b = min(a, first), max(b, last)
    return a, min(width, b + 1)


@kernel
def _running_sums(cover, inverse, slope, colour):
    a = b = c = d = F0
    for i in range(cover.shape[0]):
        a += cover[i]
        b += inverse[i]
        c += slope[i]
        d += colour[i]
        cover[i] = a
        inverse[i] = b
        slope[i] = c
        colour[i] = d


@kernel
def _running_sums_of_two(first, second):
    a = b = F0
    for i in range(first.shape[0]):
        a += first[i]
        b += second[i]
        first[i] = a
        second[i] = b


@kernel
def _mean_depth(xs, cover, slope, inverse):
    for i in range(xs.shape[0]):
        share = F1 / cover[i] if abs(cover[i]) > TINY else F0
        inverse[i] = max(F0, (inverse[i] + slope[i] * xs[i]) * share)


@kernel
def _mean(cover, plane):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] / cover[i] if abs(cover[i]) > TINY else F0


@kernel
def _unsigned(cover):
    for i in range(cover.shape[0]):
        cover[i] = min(F1, abs(cover[i]))


@kernel
def _paint(steps, cover, strength, value, plane):
    for i in range(plane.shape[0]):
        share = strength * min(F1, abs(steps[i]) / max(cover[i], TINY))
        plane[i] += share * (value - plane[i])


@kernel
def _paint_row(k, row, a, b, width, work, buf, channels):
    """Paint one face over the body in columns a to b."""
    _, edges, facts, slopes, shades, _ = work
    steps = buf[STEPS]
    first, last = width, -1
    for e in range(facts[k, 0]):
        f, g = _step(edges[k, e], row, width, steps)
        first, last = min(first, f), max(last, g)
    total = F0
    for i in range(first, last + 1):
        total += steps[i]
        steps[i] = total
    f, g = max(first, a), min(last + 1, b)
    if g > f:
        for c in range(channels):
            _paint(
                buf[STEPS, f:g], buf[COVER, f:g], np.float32(slopes[k, 3]), shades[k, c], buf[COLOUR + c, f:g]
            )
    if last >= first:
        fill_row(F0, buf[STEPS, first : last + 1])


@kernel
def draw_polyhedron(
    points, first, last, face_start, face_corners, details, colours, colour_base, optics, xs, size, scratch, buf, work, spans
):  # fmt: skip
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
    facts = work[2]
    channels = scratch[0].shape[0]
    n, top, bottom = _collect(
        points, first, last, face_start, face_corners, details, colours, colour_base, optics, height, work
    )
    if bottom <= top:
        return
    for k in range(SLOPE + 1):
        for i in range(width + 2):
            buf[k, i] = F0
    for row in range(top, bottom):
        a, b = _body_row(n, row, width, work, buf, channels)
        if b > a:
            cover = buf[COVER, a:b]
            _running_sums(cover, buf[INVERSE, a:b], buf[SLOPE, a:b], buf[COLOUR, a:b])
            if channels == 3:
                _running_sums_of_two(buf[COLOUR + 1, a:b], buf[COLOUR + 2, a:b])
            _mean_depth(xs[a:b], cover, buf[SLOPE, a:b], buf[INVERSE, a:b])
            for c in range(channels):
                _mean(cover, buf[COLOUR + c, a:b])
            _unsigned(cover)
            for k in range(n):
                if facts[k, 1] == 1 and facts[k, 2] <= row < facts[k, 3]:
                    _paint_row(k, row, a, b, width, work, buf, channels)
            merge_row(buf, COLOUR, COVER, INVERSE, a, scratch, row, a, b)
            grow(spans, row, a, b)
            for k in range(COVER, SLOPE + 1):
                fill_row(F0, buf[k, a : b + 1])
