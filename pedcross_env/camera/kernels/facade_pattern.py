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
    "upper_pattern",
]

TWO = np.float32(2.0)
MARGIN = np.float32(0.09)  # width of a window frame
LEDGE = np.float32(0.3)  # below the upper storeys
LEAST_HALF = np.float32(2e-4)  # of a pixel's extent, metres


@inlined
def _pulse(p, duty):
    whole = np.floor(p)
    return whole * duty + min(p - whole, duty)


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
    ground = (floor, low_bay, low_duty, HALF * (F1 - low_duty), np.float32(panel[22]), np.float32(panel[23]))
    return upper, ground


@kernel
def place_pixels(xs, ys, v0, v1, v2, least, most, along, up, shift_s, shift_t, inverse, s, t, ws, wt, floor):
    """Inverse depth, position on the panel and the pixel's extent there: all rational in column and row.

    A box as wide as the gradient is long has the variance of the true footprint (two boxes folded), and so its edges' width.

    Returns:
        How many pixels reach below the height ``floor``, and how many above.
    """
    s0, s1, s2 = along
    t0, t1, t2 = up
    below = above = np.int32(0)
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
        half = max(HALF * wt[i], LEAST_HALF)
        below = np.int32(below + np.int32(t[i] - half < floor))  # as wide as the rest
        above = np.int32(above + np.int32(t[i] + half > floor))
    return below, above


@kernel
def upper_pattern(s, t, ws, wt, base_z, upper, floor, stone, trim, pane, shade):
    """Band-limited pattern of a front above its ground floor.

    Args:
        s: Along the panel, metres.
        t: Up.
        ws: The pixel's extent along.
        wt: And up.
        base_z: Height of the panel's foot.
        upper: (bay, storey, window share along, up, phase along, up, cornice height).
        floor: Height of the ground floor.
        stone: Filled: cover of the ground floor's wall, none.
        trim: Of cornices and window frames.
        pane: Of glass.
        shade: Share of the light that reaches so deep into the street.
    """
    bay, storey, duty_s, duty_t, phase_s, phase_t, cornice = upper
    ms, mt = MARGIN / bay, MARGIN / storey
    thin_s, thin_t = max(F0, duty_s - TWO * ms), max(F0, duty_t - TWO * mt)
    inv_bay, inv_storey = F1 / bay, F1 / storey
    for i in range(s.shape[0]):
        half = max(HALF * ws[i], LEAST_HALF)
        scale = bay * (HALF / half)
        first, last = (s[i] - half) * inv_bay - phase_s, (s[i] + half) * inv_bay - phase_s
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m  # place within the bay, of the pixel's either border
        outer = ((m - n) * duty_s + (min(last, duty_s) - min(first, duty_s))) * scale
        inner = ((m - n) * thin_s + (_clamp(last - ms, thin_s) - _clamp(first - ms, thin_s))) * scale
        half = max(HALF * wt[i], LEAST_HALF)
        inv = HALF / half
        low, high = t[i] - half, t[i] + half
        first, last = low * inv_storey - phase_t, high * inv_storey - phase_t
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m
        above_floor, above_cornice = min(max(floor, low), high), min(max(cornice, low), high)
        zone = (above_cornice - above_floor) * inv * inv * storey
        up_outer = ((m - n) * duty_t + (min(last, duty_t) - min(first, duty_t))) * zone
        up_inner = ((m - n) * thin_t + (_clamp(last - mt, thin_t) - _clamp(first - mt, thin_t))) * zone
        glass = inner * up_inner
        frame = max(F0, outer * up_outer - glass)
        stone[i] = F0
        pane[i] = glass
        # a share of the pixel, as panes are: it takes from the wall alone
        trim[i] = min(F1 - glass, (high - above_cornice) * inv + frame)
        shade[i] = np.float32(0.72) + np.float32(0.28) * min(F1, (t[i] + base_z) * np.float32(0.2))


@kernel
def ground_pattern(s, t, ws, wt, ground, stone, trim, pane):
    """Add the ground floor's pattern: its wall, windows and ledge; arguments as ``upper_pattern``.

    ``ground`` is (height of the ground floor, its bay, window share, phase, sill, lintel).
    """
    floor, bay, duty, phase, sill, lintel = ground
    margin, inv_bay = MARGIN / bay, F1 / bay
    thin = max(F0, duty - TWO * margin)
    for i in range(s.shape[0]):
        half = max(HALF * ws[i], LEAST_HALF)
        scale = bay * (HALF / half)
        first, last = (s[i] - half) * inv_bay - phase, (s[i] + half) * inv_bay - phase
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m
        outer = ((m - n) * duty + (min(last, duty) - min(first, duty))) * scale
        inner = ((m - n) * thin + (_clamp(last - margin, thin) - _clamp(first - margin, thin))) * scale
        half = max(HALF * wt[i], LEAST_HALF)
        inv = HALF / half
        low, high = t[i] - half, t[i] + half
        glass = inner * (_interval(low, high, sill + MARGIN, lintel - MARGIN) * inv)
        frame = max(F0, outer * (_interval(low, high, sill, lintel) * inv) - glass)
        below_floor = min(max(floor, low), high)
        below_ledge = min(max(floor - LEDGE, low), high)
        stone[i] = (below_floor - low) * inv
        pane[i] += glass
        trim[i] = min(F1 - pane[i], trim[i] + (below_floor - below_ledge) * inv + frame)


@kernel
def plain_pattern(t, base_z, stone, trim, pane, shade):
    """Fill the same for a wall without windows."""
    for i in range(t.shape[0]):
        stone[i] = F0
        trim[i] = F0
        pane[i] = F0
        shade[i] = np.float32(0.72) + np.float32(0.28) * min(F1, (t[i] + base_z) * np.float32(0.2))


@kernel
def lit_windows(s, t, ws, wt, upper, ground, seed, share, out):
    """Radiance share of lit windows, by a hash per window.

    It fades to its mean before a pixel could see two windows.
    """
    bay, storey, duty_s, duty_t, phase_s, phase_t, cornice = upper
    floor, low_bay, low_duty, low_phase, sill, lintel = ground
    rise = phase_t - floor / storey
    gap_s, gap_t, low_gap = (
        bay * (F1 - duty_s),
        TWO * storey * min(rise, F1 - rise - duty_t),
        low_bay * (F1 - low_duty),
    )
    ms, mt, ml = MARGIN / bay, MARGIN / storey, MARGIN / low_bay
    thin_s, thin_t, thin_l = duty_s - TWO * ms, duty_t - TWO * mt, low_duty - TWO * ml
    for i in range(out.shape[0]):
        w, v = max(ws[i], np.float32(4e-4)), max(wt[i], np.float32(4e-4))
        low, high = t[i] - HALF * v, t[i] + HALF * v
        p, h = s[i] / bay - phase_s - ms, HALF * w / bay
        across = (_pulse(p + h, thin_s) - _pulse(p - h, thin_s)) * bay / w
        p, h = t[i] / storey - phase_t - mt, HALF * v / storey
        up = (
            (_pulse(p + h, thin_t) - _pulse(p - h, thin_t))
            * storey
            / v
            * _interval(low, high, floor, cornice)
            / v
        )
        column, level = int(math.floor(s[i] / bay)), int(math.floor((t[i] - floor) / storey))
        fade = min(F1, max(F0, TWO * max(w / gap_s, v / gap_t) - F1))
        own = F1 if hash01(column + seed * 131, level + seed) < share else F0
        light = across * up * (own + (share - own) * fade)
        p, h = s[i] / low_bay - low_phase - ml, HALF * w / low_bay
        across = (_pulse(p + h, thin_l) - _pulse(p - h, thin_l)) * low_bay / w
        fade = min(F1, max(F0, TWO * w / low_gap - F1))
        own = F1 if hash01(int(math.floor(s[i] / low_bay)) + seed * 17, seed) < share else F0
        up = _interval(low, high, sill + MARGIN, lintel - MARGIN) / v
        out[i] = light + across * up * (own + (share - own) * fade)
