"""What lies at a place on the ground: carriageway, kerb, sidewalk and markings of straight, bent and crossing streets.

``layout`` is the vector of L_* below. ``tables`` is (along, low, high, grain, side along, side low, paint, plain): running integrals of
``scenery`` along and across the main street, the grain's summed area table, those of the side street, rectangles of paint
(M, 6): 0 main or 1 side street, s range, d range, strength; and the colours of asphalt and gutter between the streets (2, 3).
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.rows import F0, F1

__all__ = [
    "LAYOUT_SIZE",
    "L_CROSSED",
    "L_CURVE",
    "L_HIGH",
    "L_SIDE",
    "STREET_ROWS",
    "WORK_SIZE",
    "grain_of_row",
    "ground_at",
    "place_on_street",
]

# 0 half carriageway, 1 kerb height, 2 along start, 3 along texel, 4 across low, 5 across texel, 6 grain texel;
# curve: curvature, start, length, sine and cosine of the turn; crossed: 1 if so, x, half carriageway, corner radius;
# side: along start, across low; high: across low of the table beyond the kerbs, half carriageway of the street that it is of
L_CURVE, L_CROSSED, L_SIDE, L_HIGH, LAYOUT_SIZE = 7, 12, 16, 18, 20
WORK_SIZE, STREET_ROWS = 32, 8  # work: 0 cover, 1-3 albedo, 4 marks; 8-15 and 16-23 look-ups
GUTTER_M = 0.3


@kernel
def _mean_across(table, low, texel, d, width, out):
    """Mean of all channels from d - width / 2 to d + width / 2; the table's ends go on for ever."""
    last = table.shape[0] - 2
    inv = 1.0 / texel
    middle, half = (d - low) * inv, 0.5 * max(width * inv, 0.5)
    p0, p1 = middle - half, middle + half
    i0, i1 = np.uint32(min(max(p0, 0.0), last + 0.0)), np.uint32(min(max(p1, 0.0), last + 0.0))
    f0, f1, scale = np.float32(p0 - i0), np.float32(p1 - i1), np.float32(0.5 / half)
    for k in range(8):
        low_end = table[i0, k] + f0 * (table[i0 + 1, k] - table[i0, k])
        out[k] = scale * (table[i1, k] + f1 * (table[i1 + 1, k] - table[i1, k]) - low_end)


@kernel
def _mean_along(table, start, texel, s, width, channel):
    last = table.shape[0] - 2
    width = max(width, 0.2 * texel)
    p0 = min(max((s - 0.5 * width - start) / texel, 0.0), last + 0.999)
    p1 = min(max((s + 0.5 * width - start) / texel, 0.0), last + 0.999)
    i0, i1 = int(p0), int(p1)
    high_end = table[i1, channel] + (p1 - i1) * (table[i1 + 1, channel] - table[i1, channel])
    low_end = table[i0, channel] + (p0 - i0) * (table[i0 + 1, channel] - table[i0, channel])
    return (high_end - low_end) * texel / width


@inlined
def _within(low, high, s, width):
    """Share of [s - width / 2, s + width / 2] that lies between low and high."""
    return max(0.0, min(high, s + 0.5 * width) - max(low, s - 0.5 * width)) / width


@inlined
def _bilinear(table, i, f, j, g):
    """Read a table between its nodes."""
    low = table[i, j] + g * (table[i, j + 1] - table[i, j])
    return low + f * (table[i + 1, j] + g * (table[i + 1, j + 1] - table[i + 1, j]) - low)


@kernel
def _far_tile(table, i, f, a, j, g, b):
    """Sum of the tiled grain up to a place a and b tiles beyond the first."""
    size = table.shape[0] - 1
    total = _bilinear(table, i, f, j, g)
    total += a * (table[size, j] + g * (table[size, j + 1] - table[size, j]))
    return (
        total + b * (table[i, size] + f * (table[i + 1, size] - table[i, size])) + a * b * table[size, size]
    )


@kernel
def _grain(table, texel, s, d, width_s, width_d):
    """Mean of the tiled grain over a box, at least a texel wide so that it does not flicker when near."""
    size = table.shape[0] - 1
    inv = 1.0 / texel
    wide, deep = max(1.0, width_s * inv), max(1.0, width_d * inv)
    p, q = s * inv - 0.5 * wide, d * inv - 0.5 * deep
    p, q = p - math.floor(p / size) * size, q - math.floor(q / size) * size
    i0, j0 = min(np.uint32(p), np.uint32(size - 1)), min(np.uint32(q), np.uint32(size - 1))
    f0, g0 = np.float32(p - i0), np.float32(q - j0)
    p, q = p + wide, q + deep
    scale = np.float32(1.0 / (wide * deep))
    if p < size and q < size:  # within one tile
        i1, j1 = np.uint32(p), np.uint32(q)
        f1, g1 = np.float32(p - i1), np.float32(q - j1)
        total = _bilinear(table, i1, f1, j1, g1) - _bilinear(table, i0, f0, j1, g1)
        return scale * (total + _bilinear(table, i0, f0, j0, g0) - _bilinear(table, i1, f1, j0, g0))
    a, b = math.floor(p / size), math.floor(q / size)
    p, q = p - a * size, q - b * size
    i1, j1 = min(np.uint32(p), np.uint32(size - 1)), min(np.uint32(q), np.uint32(size - 1))
    f1, g1 = np.float32(p - i1), np.float32(q - j1)
    total = _far_tile(table, i1, f1, a, j1, g1, b) - _far_tile(table, i0, f0, 0.0, j1, g1, b)
    total += _far_tile(table, i0, f0, 0.0, j0, g0, 0.0) - _far_tile(table, i1, f1, a, j0, g0, 0.0)
    return np.float32(scale * total)


@kernel
def _street_place(x, y, layout):
    """Return s, d, the street's direction there (x, y) and how much s changes per metre along it."""
    k, start, length = layout[L_CURVE], layout[L_CURVE + 1], layout[L_CURVE + 2]
    if k == 0.0 or x < start:
        return x, y, 1.0, 0.0, 1.0
    side, radius = math.copysign(1.0, k), 1.0 / abs(k)
    ahead, inward = x - start, radius - side * y
    sine, cosine = layout[L_CURVE + 3], layout[L_CURVE + 4]
    angle = math.atan2(ahead, inward)
    if angle <= abs(k) * length:
        out = max(1e-3, math.sqrt(ahead * ahead + inward * inward))
        return start + angle * radius, side * (radius - out), inward / out, side * ahead / out, radius / out
    beyond = ahead * cosine - inward * sine
    return start + length + beyond, side * (radius - ahead * sine - inward * cosine), cosine, side * sine, 1.0


@inlined
def _spread(a, b):
    return math.sqrt(a * a + b * b)


@kernel
def _beyond_kerb(s, d, layout):
    """Return how far a place lies beyond the kerb of two crossing streets, and that distance's gradient over d and s."""
    corner = layout[L_CROSSED + 3]
    off = s - layout[L_CROSSED + 1]
    a, b = corner - abs(d) + layout[0], corner - abs(off) + layout[L_CROSSED + 2]
    sign_d, sign_s = math.copysign(1.0, d), math.copysign(1.0, off)
    if a > 0.0 and b > 0.0:
        r = math.sqrt(a * a + b * b)
        return corner - r, sign_d * a / r, sign_s * b / r
    if a > b:
        return corner - a, sign_d, 0.0
    return corner - b, 0.0, sign_s


@kernel
def _add_street(weight, s, width_s, across, along, start, texel, out):
    """Add a street's carriageway and its markings."""
    for k in range(4):
        out[k] += np.float32(weight) * across[k]
    marks = across[4] + 0.0
    if across[5] > F0:
        marks += across[5] * _mean_along(along, start, texel, s, width_s, 0)
    if across[6] > F0:
        marks += across[6] * _mean_along(along, start, texel, s, width_s, 1)
    out[4] += np.float32(weight * marks)


@inlined
def _crossing_low(s, d, su, sv, du, dv, layout, tables, work):
    """Carriageways of two crossing streets: their own surfaces on the arms, plain asphalt between them."""
    along, low, _, _, side_along, side_low, paint, plain = tables
    width_s, width_d = max(1e-3, _spread(su, sv)), max(1e-3, _spread(du, dv))
    middle, half_side, corner = layout[L_CROSSED + 1], layout[L_CROSSED + 2], layout[L_CROSSED + 3]
    reach_s, reach_d = half_side + corner, layout[0] + corner
    main = 1.0 - _within(middle - reach_s, middle + reach_s, s, width_s)
    side = 1.0 - _within(-reach_d, reach_d, d, width_d)
    if main > 0.0:
        _mean_across(low, layout[4], layout[5], d, width_d, work[8:16])
        _add_street(main, s, width_s, work[8:16], along, layout[2], layout[3], work[:8])
    if side > 0.0:
        _mean_across(side_low, layout[L_SIDE + 1], layout[5], middle - s, width_s, work[8:16])
        _add_street(side, d, width_d, work[8:16], side_along, layout[L_SIDE], layout[3], work[:8])
    between = (1.0 - main) * (1.0 - side)
    if between > 0.0:
        beyond, over_d, over_s = _beyond_kerb(s, d, layout)
        width = max(1e-3, _spread(over_d * du + over_s * su, over_d * dv + over_s * sv))
        cover = _within(-1e9, 0.0, beyond, width)
        gutter = _within(-GUTTER_M, 0.0, beyond, width)
        work[0] += np.float32(between * cover)
        for c in range(3):
            work[1 + c] += np.float32(between * ((cover - gutter) * plain[0, c] + gutter * plain[1, c]))
    for k in range(paint.shape[0]):
        own, own_width, other, other_width = s, width_s, d, width_d
        if paint[k, 0] > 0:
            own, own_width, other, other_width = d, width_d, middle - s, width_s
        shade = paint[k, 5] * _within(paint[k, 1], paint[k, 2], own, own_width)
        if shade > 0.0:
            work[4] += np.float32(shade * _within(paint[k, 3], paint[k, 4], other, other_width))


@kernel
def _widths(u, v, out):
    for i in range(out.shape[0]):
        out[i] = np.sqrt(u[i] * u[i] + v[i] * v[i])


@kernel
def _copy(source, out):
    for i in range(out.shape[0]):
        out[i] = source[i]


@kernel
def place_on_street(ground, layout, street):
    """Turn a row's places and footprints on the ground to street coordinates.

    Args:
        ground: (6, n) x, y, and the change of x per column and row, of y per column and row.
        layout: See the module.
        street: (STREET_ROWS, n) filled: s, d, change of s per column and row, of d, root sum of squares of either pair.
    """
    if layout[L_CURVE] == 0.0:
        for k in range(6):
            _copy(ground[k], street[k])
    else:
        for i in range(street.shape[1]):
            s, d, tx, ty, stretch = _street_place(ground[0, i] + 0.0, ground[1, i] + 0.0, layout)
            street[0, i], street[1, i] = s, d
            for k in range(2):
                xk, yk = ground[2 + k, i], ground[4 + k, i]
                street[2 + k, i], street[4 + k, i] = (tx * xk + ty * yk) * stretch, tx * yk - ty * xk
    for k in range(2):
        _widths(street[2 + 2 * k], street[3 + 2 * k], street[6 + k])


@kernel
def grain_of_row(table, texel, street, free, out):
    """Fill the grain of a row's pixels where something is left free."""
    for i in range(out.shape[0]):
        out[i] = F0
        if free[i] > np.float32(1e-4):
            out[i] = _grain(table, texel, street[0, i], street[1, i], street[6, i], street[7, i])


@inlined
def ground_at(x, y, xu, xv, yu, yv, street, i, camera, lower, layout, tables, work):
    """Fill ``work``: 0 what share of the pixel is ground (the rest is a kerb's face), 1-3 albedo, 4 paint.

    Args:
        x: World, on the road's plane.
        y: World.
        xu: Change of x from a column to the next; xv from a row to the next; yu, yv of y.
        xv: See xu.
        yu: See xu.
        yv: See xu.
        street: From ``place_on_street``.
        i: Which of its columns.
        camera: (3,).
        lower: The same pixel's place on the kerb's plane is camera + lower * (place - camera).
        layout: See the module.
        tables: See the module.
        work: (WORK_SIZE,) float32.
    """
    along, low, high = tables[0], tables[1], tables[2]
    for k in range(5):
        work[k] = F0
    kerb, crossed = layout[0], layout[L_CROSSED] > 0.0
    s, d = street[0, i], street[1, i]
    if crossed:
        _crossing_low(s, d, street[2, i], street[3, i], street[4, i], street[5, i], layout, tables, work)
    elif abs(d) - 0.5 * street[7, i] < kerb:
        _mean_across(low, layout[4], layout[5], d, street[7, i], work[8:16])
        _add_street(1.0, s, street[6, i], work[8:16], along, layout[2], layout[3], work[:8])
    # sidewalks, on the kerb's plane
    s, d, tx, ty, stretch = _street_place(
        camera[0] + lower * (x - camera[0]), camera[1] + lower * (y - camera[1]), layout
    )
    du, dv = lower * (tx * yu - ty * xu), lower * (tx * yv - ty * xv)
    kerb = layout[L_HIGH + 1]
    if crossed:
        su, sv = lower * (tx * xu + ty * yu) * stretch, lower * (tx * xv + ty * yv) * stretch
        beyond, over_d, over_s = _beyond_kerb(s, d, layout)
        du, dv = over_d * du + over_s * su, over_d * dv + over_s * sv
        d = math.copysign(max(0.0, kerb + beyond), d)
    width_d = _spread(du, dv)
    if abs(d) + 0.5 * width_d <= kerb:
        return
    _mean_across(high, layout[L_HIGH], layout[5], d, width_d, work[16:24])
    # what is on the kerb's plane hides what is below it
    shown = max(F0, F1 - work[16]) / max(work[0], np.float32(1e-6)) if work[0] + work[16] > F1 else F1
    work[0] = min(F1, shown * work[0] + work[16])
    for c in range(3):
        work[1 + c] = shown * work[1 + c] + work[17 + c]
    work[4] = shown * work[4] + work[20]
