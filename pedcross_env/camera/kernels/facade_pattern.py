"""The pattern of a front, filtered by the pixel's extent: windows and their frames, ground floor, ledge and cornice."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.rows import F0, F1, HALF, hash01

__all__ = [
    "ground_pattern",
    "lit_windows",
    "pattern_of",
    "place_pixels",
    "plain_pattern",
    "split_at_floor",
    "upper_pattern",
    "weigh_surfaces",
]

TWO = np.float32(2.0)
MARGIN = np.float32(0.09)  # width of a window frame
BAR = np.float32(0.06)  # of the bar in a window's middle
# a window's curtains hide up to half of it, in half of the windows; steps of a low-discrepancy sequence choose
NO_CURTAIN, CURTAIN_MEAN, CURTAIN_MIX = np.float32(0.5), np.float32(0.125), np.float32(61.7)
CURTAIN_STEPS = (np.float32(0.6180340), np.float32(0.7548777))
BAND_M, ALIKE = np.float32(0.3), np.float32(1e9)
GLASS_MIRRORS = np.float32(0.08)  # of the light, seen straight on: two panes
PLINTH_M, PLINTH_TONE = (
    np.float32(0.75),
    np.float32(0.24),
)  # its top above the road, how much darker it is than the wall above
DOOR_FRAME = np.float32(0.08)
STEP_M = np.float32(0.30)  # top of the step before a door, above the road
LEAF_M = np.float32(2.15)  # top of a door's leaf; above it a window, where there is room
LEDGE = np.float32(0.3)  # below the upper storeys
LEAST_HALF = np.float32(2e-4)  # of a pixel's extent, metres


@inlined
def _clamp(p, most):
    return max(F0, min(p, most))


@inlined
def _interval(low_end, high_end, low, high):
    """Length of the overlap of two intervals."""
    return max(F0, min(high_end, high) - max(low_end, low))


@kernel
def pattern_of(panel):
    """Return the patterns of the upper storeys and of the ground floor, as ``upper_pattern`` and ``ground_pattern`` take them."""
    bay, storey = np.float32(max(panel[11], 0.5)), np.float32(max(panel[12], 0.5))
    floor, low_bay, low_duty = np.float32(panel[19]), np.float32(max(panel[20], 0.5)), np.float32(panel[21])
    duty_s, duty_t = np.float32(panel[13]), np.float32(panel[14])
    upper = (
        bay, storey, duty_s, duty_t, HALF * (F1 - duty_s), np.float32(panel[15]) + floor / storey, np.float32(panel[25]),
    )  # fmt: skip
    tone = F1 - np.float32(panel[24])
    ground = (
        floor,
        low_bay,
        low_duty,
        HALF * (F1 - low_duty),
        np.float32(panel[22]),
        np.float32(panel[23]),
        tone,
    )
    return upper, ground


@kernel
def place_pixels(xs, ys, v0, v1, v2, least, most, along, up, shift_s, shift_t, inverse, s, t, ws, wt):
    """Inverse depth, position on the panel and the pixel's extent there: all rational in column and row.

    A box as wide as the gradient is long has the variance of the true footprint (two boxes folded), and so its edges' width.
    """
    s0, s1, s2 = along
    t0, t1, t2 = up
    for i in range(xs.shape[0]):
        x, y = xs[i], ys[i]
        inv = min(most, max(least, v0 + v1 * x + v2 * y))  # a pixel's middle may lie beyond the panel's edge
        z = F1 / inv
        a, b = s0 + s1 * x + s2 * y, t0 + t1 * x + t2 * y
        z2 = z * z
        inverse[i] = inv
        s[i] = a * z - shift_s
        t[i] = b * z - shift_t
        across, down = s1 * inv - a * v1, s2 * inv - a * v2
        ws[i] = np.sqrt(across * across + down * down) * z2
        across, down = t1 * inv - b * v1, t2 * inv - b * v2
        wt[i] = np.sqrt(across * across + down * down) * z2


@kernel
def split_at_floor(listed, entries, t, wt, floor):
    """Where the pixels begin that reach below a height, and where those end that reach above it, in whole rows.

    Along a row height and extent only grow or only fall.
    """
    start, end, at = t.shape[0], 0, 0
    for r in range(entries):
        beyond = at + listed[r, 2] - listed[r, 1]
        half = max(max(wt[at], wt[beyond - 1]), LEAST_HALF + LEAST_HALF)  # twice what is needed
        if start > at and min(t[at], t[beyond - 1]) - half < floor:
            start = at
        if max(t[at], t[beyond - 1]) + half > floor:
            end = beyond
        at = beyond
    return start, end


@kernel
def upper_pattern(s, t, ws, wt, base_z, upper, floor, seed, stone, trim, pane, shade):
    """Band-limited pattern of a front above its ground floor.

    Args:
        s: Along the panel, metres.
        t: Up.
        ws: The pixel's extent along.
        wt: And up.
        base_z: Height of the panel's foot.
        upper: (bay, storey, window share along, up, phase along, up, cornice height).
        floor: Height of the ground floor.
        seed: Of the curtains, 0 to 1.
        stone: Filled: how much darker the wall is than the house's own, not at all.
        trim: Of cornices, window frames and curtains.
        pane: Of glass.
        shade: Share of the light that reaches so deep into the street.
    """
    bay, storey, duty_s, duty_t, phase_s, phase_t, cornice = upper
    ms, mt = MARGIN / bay, MARGIN / storey
    thin_s, thin_t = max(F0, duty_s - TWO * ms), max(F0, duty_t - TWO * mt)
    inv_bay, inv_storey = F1 / bay, F1 / storey
    bar = min(BAR / bay, thin_s)  # none where there is no glass
    bar_from = ms + HALF * (thin_s - bar)
    step_s, step_t = CURTAIN_STEPS
    wall = bay - bay * duty_s
    # bands of glass, between whose panes is no more than frames, look alike throughout: from afar they are seen as one
    lone = TWO / min(wall, storey - storey * duty_t) if wall > BAND_M else ALIKE
    for i in range(s.shape[0]):
        half, half_up = max(HALF * ws[i], LEAST_HALF), max(HALF * wt[i], LEAST_HALF)
        both = HALF / (half * half_up)  # one division where two would be as many pixels' time again
        scale, inv = bay * both * half_up, both * half
        first, last = (s[i] - half) * inv_bay - phase_s, (s[i] + half) * inv_bay - phase_s
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m  # place within the bay, of the pixel's either border
        outer = ((m - n) * duty_s + (min(last, duty_s) - min(first, duty_s))) * scale
        inner = (m - n) * (thin_s - bar) + (_clamp(last - ms, thin_s) - _clamp(first - ms, thin_s))
        inner = (inner - (_clamp(last - bar_from, bar) - _clamp(first - bar_from, bar))) * scale
        low, high = t[i] - half_up, t[i] + half_up
        curtain = m * step_s + seed
        first, last = low * inv_storey - phase_t, high * inv_storey - phase_t
        n2, m2 = np.floor(first), np.floor(last)
        first, last = first - n2, last - m2
        above_floor, above_cornice = min(max(floor, low), high), min(max(cornice, low), high)
        zone = (above_cornice - above_floor) * inv * inv * storey
        up_outer = ((m2 - n2) * duty_t + (min(last, duty_t) - min(first, duty_t))) * zone
        up_inner = ((m2 - n2) * thin_t + (_clamp(last - mt, thin_t) - _clamp(first - mt, thin_t))) * zone
        glass = inner * up_inner
        frame = max(F0, outer * up_outer - glass)
        curtain += m2 * step_t
        curtain = (curtain - np.floor(curtain)) * CURTAIN_MIX
        # a pixel that could see two windows has their mean
        own = min(F1, max(F0, TWO - ws[i] * lone))
        hidden = CURTAIN_MEAN + own * (max(F0, curtain - np.floor(curtain) - NO_CURTAIN) - CURTAIN_MEAN)
        stone[i] = F0
        pane[i] = glass * (F1 - hidden)
        # a share of the pixel, as panes are: it takes from the wall alone
        trim[i] = min(F1 - pane[i], (high - above_cornice) * inv + frame + glass * hidden)
        shade[i] = np.float32(0.72) + np.float32(0.28) * min(F1, (t[i] + base_z) * np.float32(0.2))


@kernel
def ground_pattern(s, t, ws, wt, ground, entrances, stone, trim, pane, accent):
    """Add the ground floor's pattern: its wall and plinth, windows, ledge and doors; arguments as ``upper_pattern``.

    ``ground`` is (height of the ground floor, its bay, window share, phase, sill, lintel, how much darker its wall is),
    ``entrances`` from ``entrances_of``; ``accent``, the leaves of doors, is filled and is a part of the trim as well.
    """
    floor, bay, duty, phase, sill, lintel, tone = ground
    unit, start, width, top, glazed, _, _ = entrances
    inv_unit = F1 / unit
    begin, wide, side = start * inv_unit, width * inv_unit, DOOR_FRAME * inv_unit
    leaf_wide, leaf_top, per_bay = max(F0, wide - side - side), min(LEAF_M, top - DOOR_FRAME), unit / bay
    plinth = min(PLINTH_M, sill - MARGIN)
    soiled = PLINTH_TONE * (F1 - tone)
    margin, inv_bay = MARGIN / bay, F1 / bay
    thin = max(F0, duty - TWO * margin)
    bar = min(BAR * inv_bay, thin)
    bar_from = margin + HALF * (thin - bar)
    for i in range(s.shape[0]):
        half, half_up = max(HALF * ws[i], LEAST_HALF), max(HALF * wt[i], LEAST_HALF)
        both = HALF / (half * half_up)
        scale, inv = bay * both * half_up, both * half
        first, last = (s[i] - half) * inv_bay - phase, (s[i] + half) * inv_bay - phase
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m
        outer = ((m - n) * duty + (min(last, duty) - min(first, duty))) * scale
        inner = (m - n) * (thin - bar) + (_clamp(last - margin, thin) - _clamp(first - margin, thin))
        inner = (inner - (_clamp(last - bar_from, bar) - _clamp(first - bar_from, bar))) * scale
        scale *= per_bay
        first, last = (s[i] - half) * inv_unit - begin, (s[i] + half) * inv_unit - begin
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m
        door = ((m - n) * wide + (min(last, wide) - min(first, wide))) * scale
        within = (m - n) * leaf_wide + (_clamp(last - side, leaf_wide) - _clamp(first - side, leaf_wide))
        low, high = t[i] - half_up, t[i] + half_up
        glass = inner * (_interval(low, high, sill + MARGIN, lintel - MARGIN) * inv)
        frame = max(F0, outer * (_interval(low, high, sill, lintel) * inv) - glass)
        below_floor = min(max(floor, low), high)
        below_ledge = min(max(floor - LEDGE, low), high)
        stone[i] = ((below_floor - low) * tone + (min(max(plinth, low), high) - low) * soiled) * inv
        scale *= inv
        door *= _interval(low, high, F0, top) * inv
        leaf = within * (_interval(low, high, STEP_M, leaf_top) * scale)
        light = (
            within * (_interval(low, high, leaf_top + DOOR_FRAME, top - DOOR_FRAME) * scale) + glazed * leaf
        )
        rest = F1 - min(F1, door)
        pane[i] = (pane[i] + glass) * rest + light
        accent[i] = leaf - glazed * leaf
        frames = (trim[i] + (below_floor - below_ledge) * inv + frame) * rest + max(F0, door - light)
        trim[i] = min(F1 - pane[i], frames)


@kernel
def plain_pattern(t, base_z, stone, trim, pane, shade):
    """Fill the same for a wall without windows."""
    for i in range(t.shape[0]):
        stone[i] = F0
        trim[i] = F0
        pane[i] = F0
        shade[i] = np.float32(0.72) + np.float32(0.28) * min(F1, (t[i] + base_z) * np.float32(0.2))


@kernel
def weigh_surfaces(inverse, distance, stone, trim, pane, shade, shine):
    """Turn covers into what is multiplied by light: of the wall (in ``stone``), of trim, and of what glass mirrors.

    Glass mirrors the more, the flatter it is seen (Schlick's formula); the rest of the light is lost in the room behind.

    Args:
        inverse: Inverse depth.
        distance: Of the camera from the wall's plane, metres; times the inverse depth the cosine of a ray near the optical axis.
        stone: How much darker the wall is than the house's own; changed.
        trim: Cover of cornices and frames; changed.
        pane: Cover of glass.
        shade: Share of the light that reaches so deep into the street.
        shine: Filled.
    """
    for i in range(shine.shape[0]):
        flat = F1 - min(F1, distance * inverse[i])
        twice = flat * flat
        shine[i] = pane[i] * (GLASS_MIRRORS + (F1 - GLASS_MIRRORS) * (twice * twice * flat))
        stone[i] = (F1 - stone[i]) * ((F1 - pane[i] - trim[i]) * shade[i])
        trim[i] *= shade[i]


@kernel
def lit_windows(s, t, ws, wt, upper, ground, seed, share, pane, out):
    """Cover of lit glass, by a hash per window.

    It fades to its mean before a pixel could see two windows.
    """
    bay, storey, duty_s, duty_t, _, phase_t, _ = upper
    floor, low_bay, low_duty, _, _, _, _ = ground
    rise = phase_t - floor / storey
    gap_s, gap_t, low_gap = (
        bay * (F1 - duty_s),
        TWO * storey * min(rise, F1 - rise - duty_t),
        low_bay * (F1 - low_duty),
    )
    for i in range(out.shape[0]):
        w, v = max(ws[i], np.float32(4e-4)), max(wt[i], np.float32(4e-4))
        if t[i] > floor:
            column, level = int(math.floor(s[i] / bay)), int(math.floor((t[i] - floor) / storey))
            fade = TWO * max(w / gap_s, v / gap_t) - F1
            drawn = hash01(column + seed * 131, level + seed)
        else:
            fade = TWO * w / low_gap - F1
            drawn = hash01(int(math.floor(s[i] / low_bay)) + seed * 17, seed)
        own = F1 if drawn < share else F0
        out[i] = pane[i] * (own + (share - own) * min(F1, max(F0, fade)))
