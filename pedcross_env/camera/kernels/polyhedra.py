"""Convex polyhedra with painted details: the faces of one body add up to its hull's exact coverage, without seams."""

from __future__ import annotations

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.polygons import (
    MAX_CORNERS,
    NEAR_M,
    edge_steps,
    grow,
    project_clipped,
    row_range,
    slanted_edges,
)
from pedcross_env.camera.kernels.rows import F0, F1, TINY, add_row, fill_row, merge_row

__all__ = ["draw_polyhedron", "fineness", "polyhedron_work"]

MAX_FACES = 64
FINE_PX_PER_M = 18.0  # fine details are gone at this resolution, whole at twice of it
STEPS, COVER, INVERSE, COLOUR, SLOPE = 0, 1, 2, 3, 6  # rows of the work space


@njit(cache=True)
def polyhedron_work(channels, width):
    """Allocate what ``draw_polyhedron`` works in."""
    return (
        np.empty((MAX_CORNERS, 2)), np.empty((MAX_FACES, MAX_CORNERS, 5)), np.empty((MAX_FACES, 4), np.int64),
        np.empty((MAX_FACES, 4)), np.empty((MAX_FACES, channels), np.float32), np.empty((MAX_CORNERS, 3)),
        np.zeros((SLOPE + 1, width + 2), np.float32),
    )  # fmt: skip


@inlined
def fineness(detail, focal, z):
    """Share at which a face is drawn: details of a centimetre or two fade out where a pixel is much wider."""
    return 1.0 if detail < 2 else min(1.0, max(0.0, focal / (FINE_PX_PER_M * max(z, NEAR_M)) - 1.0))


@kernel
def _collect(
    points, first, last, face_start, face_corners, details, planes, colours, base, optics, height, work
):
    """Project the faces that are seen; return their number and the rows they touch.

    Fills the work arrays: edges, (their number, painted, first row, row beyond), inverse-depth planes and strength, colours.
    """
    corners, edges, facts, slopes, shades, local, _ = work
    focal, cx, cy = optics
    n, top, bottom = 0, height, 0
    for face in range(first, last):
        plane = planes[face - base]
        if plane[3] >= -1e-12 or n == MAX_FACES:
            continue
        s = face_start[face]
        count = face_start[face + 1] - s
        for i in range(count):
            for k in range(3):
                local[i, k] = points[face_corners[s + i], k]
        clipped = project_clipped(local, count, focal, cx, cy, corners)
        if clipped < 3:
            continue
        slopes[n, 3] = fineness(details[face], focal, local[0, 2])
        facts[n, 0], facts[n, 1] = slanted_edges(corners, clipped, edges[n]), min(1, details[face])
        facts[n, 2], facts[n, 3] = row_range(corners, clipped, height)
        slopes[n, 0] = plane[0] / focal / plane[3]
        slopes[n, 1] = plane[1] / focal / plane[3]
        slopes[n, 2] = (plane[2] - (plane[0] * cx + plane[1] * cy) / focal) / plane[3]
        for c in range(colours.shape[1]):
            shades[n, c] = colours[face - base, c]
        if details[face] == 0:
            top, bottom = min(top, facts[n, 2]), max(bottom, facts[n, 3])
        n += 1
    return n, top, bottom


@kernel
def _body_row(n, row, width, work, channels):
    """Add up the steps of all bounding faces, weighted by 1, inverse depth and colour; return the columns they touch."""
    _, edges, facts, slopes, shades, _, sums = work
    a, b = width, -1
    steps = sums[STEPS]
    for k in range(n):
        if facts[k, 1] != 0 or not facts[k, 2] <= row < facts[k, 3]:
            continue
        constant, slope = np.float32(slopes[k, 1] * (row + 0.5) + slopes[k, 2]), np.float32(slopes[k, 0])
        for e in range(facts[k, 0]):
            first, last = edge_steps(edges[k, e], row, width, steps)
            for i in range(first, last + 1):
                d = steps[i]
                steps[i] = F0
                sums[COVER, i] += d
                sums[INVERSE, i] += d * constant
                sums[SLOPE, i] += d * slope
                for c in range(channels):
                    sums[COLOUR + c, i] += d * shades[k, c]
            a, b = min(a, first), max(b, last)
    return a, b


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
def _paint_row(k, row, a, b, width, work, channels):
    """Paint one face over the body in columns a to b."""
    _, edges, facts, slopes, shades, _, sums = work
    steps = sums[STEPS]
    first, last = width, -1
    for e in range(facts[k, 0]):
        f, g = edge_steps(edges[k, e], row, width, steps)
        first, last = min(first, f), max(last, g)
    total = F0
    for i in range(first, last + 1):
        total += steps[i]
        steps[i] = total
    f, g = max(first, a), min(last + 1, b)
    if g > f:
        for c in range(channels):
            _paint(
                sums[STEPS, f:g],
                sums[COVER, f:g],
                np.float32(slopes[k, 3]),
                shades[k, c],
                sums[COLOUR + c, f:g],
            )
    if last >= first:
        fill_row(F0, sums[STEPS, first : last + 1])


@kernel
def draw_polyhedron(
    points, first, last, face_start, face_corners, details, planes, colours, base, optics, xs, size, scratch, work, spans,
    behind,
):  # fmt: skip
    """Draw one convex polyhedron into its object's scratch planes.

    Args:
        points: (V, 3) float64 corners, camera coordinates.
        first: First face of the polyhedron.
        last: Beyond its last face.
        face_start: (F + 1,) where a face's corners start in ``face_corners``.
        face_corners: Corner indices, counter-clockwise seen from outside.
        details: (F,) 1 where a face is painted on the others instead of bounding the body, 2 where it fades out with the distance.
        planes: Of each face from ``base`` on the (3,) normal and what it gives at the face: 0 where it is not to be drawn.
        colours: (C,) float32 radiance of each of them.
        base: First face that ``planes`` and ``colours`` have.
        optics: (focal, cx, cy).
        xs: (W,) float32 pixel centres.
        size: (height, width).
        scratch: (planes (C, H, W), alpha (H, W), inverse depth (H, W)).
        work: From ``polyhedron_work``.
        spans: What the object covers, extended by ``grow``.
        behind: Whether it stands behind all that its object has already (see ``rows.add_row``), not among it by depth.
    """
    height, width = size
    facts, sums = work[2], work[6]
    channels = scratch[0].shape[0]
    n, top, bottom = _collect(
        points, first, last, face_start, face_corners, details, planes, colours, base, optics, height, work
    )
    if bottom <= top:
        return
    for row in range(top, bottom):
        a, beyond = _body_row(n, row, width, work, channels)
        b = min(width, beyond)  # at the last step the sum is back at zero
        if b > a:
            cover = sums[COVER, a:b]
            _running_sums(cover, sums[INVERSE, a:b], sums[SLOPE, a:b], sums[COLOUR, a:b])
            if channels == 3:
                _running_sums_of_two(sums[COLOUR + 1, a:b], sums[COLOUR + 2, a:b])
            _mean_depth(xs[a:b], cover, sums[SLOPE, a:b], sums[INVERSE, a:b])
            for c in range(channels):
                _mean(cover, sums[COLOUR + c, a:b])
            _unsigned(cover)
            for k in range(n):
                if facts[k, 1] == 1 and facts[k, 2] <= row < facts[k, 3]:
                    _paint_row(k, row, a, b, width, work, channels)
            if behind:
                add_row(sums, COLOUR, COVER, INVERSE, a, scratch, row, a, b)
            else:
                merge_row(sums, COLOUR, COVER, INVERSE, a, scratch, row, a, b)
            grow(spans, row, a, b)
        if beyond >= a:
            for k in range(COVER, SLOPE + 1):
                fill_row(F0, sums[k, a : beyond + 1])
