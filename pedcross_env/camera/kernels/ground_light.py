"""Light on a row of ground: shadows that fall on it, street lamps and headlights that shine on it."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import INT, LANES, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM,
    ENV_BEAM_POSITION,
    ENV_BETA,
    ENV_LAMP,
    ENV_UP,
    beam_candela,
)
from pedcross_env.camera.kernels.rows import F0, F1, HALF, fill_row
from pedcross_env.camera.kernels.shadows import MAX_EDGES

__all__ = ["beam_at", "lamp_at", "lights_row", "shadow_row"]

LEVEL = np.float32(1e-9)  # change per pixel of the distance to an edge that is none
BEAM_RANGE_M = 90.0
BEAM_STEP = 0.01  # of the tangent to the side, in the beams' table
RAMPS, EIGHT = 2 * MAX_EDGES, 8  # numbers of all ramps along a row that a shadow's edges have, and of four


@kernel
def _edge_width(edge, eye, ahead_x, foot_x, foot_y, soft):
    """How wide a straight edge looks where a row crosses it, ``ahead_x`` before the eye: the spread of its footprint and of the penumbra.

    The footprint reaches ``foot_x`` along the line of sight, not along x: an edge that runs towards the eye stays sharp. Along
    that line, per metre ahead, an edge comes nearer by its distance from the eye over that of the row.
    """
    ahead = (edge[0] * eye[0] + edge[1] * eye[1] + edge[2]) / ahead_x * foot_x
    beside = edge[1] * foot_y
    return np.sqrt(ahead * ahead + beside * beside + soft * soft)


@kernel
def _below_four(ramps, xs, cover):
    """Lower ``cover`` to the least of four ramps (slope, constant each)."""
    a0, b0, a1, b1 = ramps[0], ramps[1], ramps[2], ramps[3]
    a2, b2, a3, b3 = ramps[4], ramps[5], ramps[6], ramps[7]
    for i in range(cover.shape[0]):
        x = xs[i]
        cover[i] = min(cover[i], min(min(a0 * x + b0, a1 * x + b1), min(a2 * x + b2, a3 * x + b3)))


@kernel
def _darken(strength, cover, out):
    for i in range(out.shape[0]):
        out[i] = min(out[i], F1 - strength * max(F0, cover[i]))


@kernel
def _polygon_shadow(
    shape, count, xs, x0, dx, y0, dy, eye, ahead_x, foot_x, foot_y, soft, strength, work, out
):
    """Darken ``out`` (share of light) under a convex polygon on the ground with soft edges.

    Along a row the distance to an edge is linear, so that where the row enters and leaves the edges' soft borders is known:
    pixels between are dark as a whole, and only the borders are computed. A border is as wide as where the row crosses its edge's
    middle, whichever part of the row is drawn.
    """
    ramps = work[:RAMPS]
    n = xs.shape[0]
    left, right = xs[0], xs[n - 1]
    enters, leaves = left, right  # of the polygon's outer border, as columns' middles
    inner, outer = left, right  # and of its inner border
    used = INT(0)
    for k in range(count):
        a, b = shape[k, 0], shape[k, 1]
        start, slope = a * x0 + b * y0 + shape[k, 2], a * dx + b * dy
        width = _edge_width(shape[k], eye, ahead_x, foot_x, foot_y, soft)
        half = HALF * width
        if abs(slope) < LEVEL:
            start, slope = start + slope * left, F0
            if start <= -half:
                return
            if start < half:
                inner, outer = right, left
        elif slope > F0:
            inv = F1 / slope
            enters, inner = max(enters, (-half - start) * inv), max(inner, (half - start) * inv)
        else:
            inv = F1 / slope
            leaves, outer = min(leaves, (-half - start) * inv), min(outer, (half - start) * inv)
        sharp = F1 / width
        ramps[used], ramps[used + 1] = slope * sharp, start * sharp + HALF
        used += 2
    if enters > leaves:
        return
    first, last = int(np.floor(enters - left)), min(n, int(np.ceil(leaves - left)) + 1)
    full0, full1 = int(np.ceil(inner - left)) + 1, int(np.floor(outer - left))
    if full0 >= full1:
        full0 = full1 = last
    dark = F1 - strength
    for i in range(full0, full1):
        out[i] = min(out[i], dark)
    while used % EIGHT != 0:  # ramps that lower nothing, for whole fours
        ramps[used], ramps[used + 1] = F0, F1
        used += 2
    for part in range(2):
        i0, i1 = (first, full0) if part == 0 else (full1, last)
        if i1 <= i0:
            continue
        # whole vectors: what the ramps give holds beside the border, too
        wide = (i1 - i0 + LANES - 1) // LANES * LANES
        i0 = max(0, min(i0, n - wide))
        i1 = min(n, i0 + wide)
        cover = work[RAMPS : RAMPS + i1 - i0]
        fill_row(F1, cover)
        for k in range(0, used, EIGHT):
            _below_four(ramps[k : k + EIGHT], xs[i0:i1], cover)
        _darken(strength, cover, out[i0:i1])


@kernel
def _capsule_shadow(shape, xs, x0, dx, y0, dy, foot_x, foot_y, strength, out):
    """Darken ``out`` under a capsule (ax, ay, bx-ax, by-ay, 1/len2, radius, soft) on the ground."""
    ax, ay, ex, ey, inv, radius = shape[0], shape[1], shape[2], shape[3], shape[4], shape[5]
    width = shape[6] + HALF * (foot_x + foot_y)
    # where a pixel is wider than the shape, its share of the pixel is what counts
    share = min(F1, np.float32(2.0) * radius / max(np.float32(1e-3), HALF * (foot_x + foot_y)))
    for i in range(xs.shape[0]):
        x, y = x0 + dx * xs[i] - ax, y0 + dy * xs[i] - ay
        t = max(F0, min(F1, (x * ex + y * ey) * inv))
        px, py = x - t * ex, y - t * ey
        cover = max(F0, min(F1, (radius - np.sqrt(px * px + py * py)) / width + HALF))
        out[i] = min(
            out[i], F1 - share * strength * cover * cover * (np.float32(3.0) - np.float32(2.0) * cover)
        )


@kernel
def shadow_row(
    polygons, polygon_info, capsules, row_x0, row_x1, xs, x0, dx, y0, dy, eye, ahead_x, foot_x, foot_y, sun, sky, work
):  # fmt: skip
    """Apply all shadows that reach this row to the shares of sunlight and skylight; ``work`` (>= RAMPS + n,) is overwritten.

    ``ahead_x`` is how far before the eye the row lies in the middle of the picture, metres along x.
    """
    inv = F1 / dy
    low, high = min(row_x0, row_x1), max(row_x0, row_x1)
    for k in range(polygons.shape[0]):
        info = polygon_info[k]
        if info[1] < low or info[0] > high:
            continue
        spread = foot_x + foot_y  # slanted edges blur sideways over a pixel's depth
        a, b = (info[2] - spread - y0) * inv, (info[3] + spread - y0) * inv
        i0 = max(0, int(np.floor(max(min(a, b), np.float32(-2.0)))) - 1)
        i1 = min(xs.shape[0], int(np.ceil(min(max(a, b), np.float32(xs.shape[0] + 2)))) + 1)
        if i1 > i0:
            target = sun if info[7] == 0 else sky
            _polygon_shadow(
                polygons[k],
                int(info[4]),
                xs[i0:i1],
                x0,
                dx,
                y0,
                dy,
                eye,
                ahead_x,
                foot_x,
                foot_y,
                info[5],
                info[6],
                work,
                target[i0:i1],
            )
    for k in range(capsules.shape[0]):
        s = capsules[k]
        reach = s[5] + s[6] + foot_x + foot_y
        if max(s[0], s[0] + s[2]) + reach < low or min(s[0], s[0] + s[2]) - reach > high:
            continue
        a, b = (min(s[1], s[1] + s[3]) - reach - y0) * inv, (max(s[1], s[1] + s[3]) + reach - y0) * inv
        i0 = max(0, int(np.floor(max(min(a, b), np.float32(-2.0)))) - 1)
        i1 = min(xs.shape[0], int(np.ceil(min(max(a, b), np.float32(xs.shape[0] + 2)))) + 1)
        if i1 > i0:
            target = sun if s[8] == 0 else sky
            _capsule_shadow(s, xs[i0:i1], x0, dx, y0, dy, foot_x, foot_y, s[7], target[i0:i1])


@kernel
def lamp_at(lamp_map, frame, x, y):
    """Bilinear look-up of the lamps' illuminance on the ground: frame = (start x, start y, step)."""
    rows, columns = lamp_map.shape
    p = min(max((x - frame[0]) / frame[2], 0.0), columns - 1.001)
    q = min(max((y - frame[1]) / frame[2], 0.0), rows - 1.001)
    a, b = int(q), int(p)
    fq, fp = q - a, p - b
    low = lamp_map[a, b] + fp * (lamp_map[a, b + 1] - lamp_map[a, b])
    high = lamp_map[a + 1, b] + fp * (lamp_map[a + 1, b + 1] - lamp_map[a + 1, b])
    return low + fq * (high - low)


@kernel
def beam_at(table, beam, up, x, y, z):
    """Illuminance of the ground at a point in camera coordinates from one beam."""
    dx, dy, dz = x - beam[0], y - beam[1], z - beam[2]
    forward = dx * beam[3] + dy * beam[4] + dz * beam[5]
    if forward < 0.05 or forward > BEAM_RANGE_M:
        return 0.0
    left = (dx * beam[6] + dy * beam[7] + dz * beam[8]) / forward
    rise = (dx * beam[9] + dy * beam[10] + dz * beam[11]) / forward
    squared = dx * dx + dy * dy + dz * dz
    cosine = -(dx * up[0] + dy * up[1] + dz * up[2]) / math.sqrt(squared)
    fade = 1.0 - max(0.0, forward / BEAM_RANGE_M - 0.7) / 0.3
    return fade * beam_candela(table, left, rise) * max(0.0, cosine) / max(squared, 0.25)


@kernel
def _between_nodes(row, step):
    """Fill in a row that is known at every ``step``-th pixel and at its last."""
    n, left = row.shape[0], 0
    while left < n - 1:
        right = min(left + step, n - 1)
        value = row[left]
        slope = (row[right] - value) / np.float32(right - left)
        piece = row[left:right]
        for i in range(piece.shape[0]):
            piece[i] = value + slope * np.float32(np.int32(i))
        left = right


@kernel
def _add_beam(table, beam, strength, up, yn, z, first, across, step, row):
    """Add one beam's illuminance of the ground at a row's nodes; ``first`` and ``across``: x in camera coordinates, per pixel.

    What a node needs is linear in its x: along the beam's axes, and up, which is the lamp's height anywhere on the ground.
    """
    dy, dz = yn * z - beam[1], z - beam[2]
    n = row.shape[0]
    forward = (first - beam[0]) * beam[3] + dy * beam[4] + dz * beam[5]
    left = (first - beam[0]) * beam[6] + dy * beam[7] + dz * beam[8]
    rise = (first - beam[0]) * beam[9] + dy * beam[10] + dz * beam[11]
    above = -((first - beam[0]) * up[0] + dy * up[1] + dz * up[2])
    most = max(forward, forward + across * beam[3] * n)
    least = min(forward, forward + across * beam[3] * n)
    if most < 0.05 or least > BEAM_RANGE_M:
        return
    i = 0
    while i < n:
        x = across * i
        ahead = forward + x * beam[3]
        if 0.05 < ahead < BEAM_RANGE_M:
            inverse = 1.0 / ahead
            dx = first + x - beam[0]
            squared = dx * dx + dy * dy + dz * dz
            candela = beam_candela(table, (left + x * beam[6]) * inverse, (rise + x * beam[9]) * inverse)
            fade = strength * (1.0 - max(0.0, ahead / BEAM_RANGE_M - 0.7) / 0.3)
            cosine = max(0.0, above - x * up[0]) / math.sqrt(squared)
            row[i] += np.float32(fade * candela * cosine / max(squared, 0.25))
        i = i + step if i == n - 1 or i + step < n else n - 1


@kernel
def lights_row(lamp_map, lamp_frame, table, env, beams, place, z, yn, focal, cx, xs, lamp, beam):
    """Illuminance of one row of ground (depth z) from street lamps and from headlights.

    Both are smooth: they are computed at nodes, as far apart as half a step of the lamps' map and two of the beams' table, and
    interpolated between.

    place: World (x0, dx, y0, dy) of the row, linear in the column.
    """
    n = xs.shape[0]
    if n == 0:
        return
    if env[ENV_LAMP] > 0:
        along = math.sqrt(place[1] * place[1] + place[3] * place[3])  # metres per pixel
        step = min(32, max(4, int(0.5 * lamp_frame[2] / along)))
        i = 0
        while i < n:
            x = xs[i]
            lamp[i] = np.float32(
                lamp_at(lamp_map, lamp_frame, place[0] + place[1] * x, place[2] + place[3] * x)
            )
            i = i + step if i == n - 1 or i + step < n else n - 1
        _between_nodes(lamp, step)
    else:
        for i in range(n):
            lamp[i] = F0
    for i in range(n):
        beam[i] = F0
    if env[ENV_BEAM] == 0.0:
        return
    up = env[ENV_UP : ENV_UP + 3]
    own = env[ENV_BEAM_POSITION : ENV_BEAM_POSITION + 12]
    step = min(32, max(4, int(2.0 * BEAM_STEP * focal)))
    first, across = (xs[0] - cx) / focal * z, z / focal
    _add_beam(table[0], own, math.exp(-env[ENV_BETA] * z), up, yn, z, first, across, step, beam)
    for k in range(beams.shape[0]):
        _add_beam(table[1], beams[k], beams[k, 12], up, yn, z, first, across, step, beam)
    _between_nodes(beam, step)
