"""Doors and shop signs on a front's ground floor, filtered by the pixel's extent as its windows are."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.rows import F0, F1, HALF, hash01

__all__ = [
    "entrances_of",
    "hang_signs",
    "light_accent",
    "light_accent_by_lamps",
    "light_signs",
    "part_accent",
]

# a sign's board and letters, metres: the board's gap to the shop's end, the letters' pitch, width and strokes
ASIDE, PITCH, LETTER, STROKE = np.float32(0.35), np.float32(0.42), np.float32(0.30), np.float32(0.075)
MARGIN_UP, LETTERS_MEAN = (
    np.float32(0.25),
    np.float32(0.12),
)  # above and below letters; cover of a board by them
MOST_LETTERS = 9
# letters by their strokes: 1 an upright on the left (all have it), 2 on the right, 4 a bar below, 8 in the middle, 16 above
LETTERS = (29, 25, 5, 21, 11, 27, 23, 7)
BLANK = np.float32(0.12)  # share of a sign's places without a letter
LEAST_HALF = np.float32(2e-4)  # of a pixel's extent, metres
NONE, TWICE = np.float32(1e-4), np.float32(2.0)
INV_PI = np.float32(1 / math.pi)


@inlined
def _overlap(low, high, start, end):
    """Length that two intervals share."""
    return max(F0, min(high, end) - max(low, start))


@kernel
def entrances_of(panel):
    """Return a front's entrances: distance between doors, where the first starts, width, top, glass share; its sign's foot and top."""
    bay = max(HALF, np.float32(panel[20]))
    width = np.float32(panel[35])
    start = (np.float32(panel[34]) + np.float32(panel[37])) * bay - HALF * width
    return (
        bay * max(F1, np.float32(panel[33])), start, width, np.float32(panel[36]), np.float32(panel[38]), np.float32(panel[39]),
        np.float32(panel[40]),
    )  # fmt: skip


@inlined
def _letter(left, right, low, high, column, seed):
    """Share of a pixel that a letter's strokes cover: two uprights and three bars, some of them; metres within its place."""
    if hash01(column, seed) < BLANK:
        return F0
    shape = LETTERS[int(hash01(column, seed + 7) * np.float32(7.99))]
    inv = F1 / max((right - left) * (high - low), NONE * NONE)
    tall = _overlap(low, high, F0, F1)
    upright = _overlap(left, right, F0, STROKE)
    if shape & 2:
        upright += _overlap(left, right, LETTER - STROKE, LETTER)
    bars = F0
    for k in range(3):
        if shape & (4 << k):
            foot = HALF * np.float32(k) * (F1 - np.float32(0.16))
            bars += _overlap(low, high, foot, foot + np.float32(0.16))
    between = max(F0, _overlap(left, right, F0, LETTER) - upright)
    return (upright * tall + between * bars) * inv


@kernel
def hang_signs(s, t, ws, wt, entrances, seed, trim, pane, accent, letters_seen, board_seen):
    """Hang a board with letters over the doors: letters are as bright as the trim, the board has the house's second colour.

    Letters fade to their mean before a pixel could see two of them.

    Args:
        s: Along the panel, metres.
        t: Up.
        ws: The pixel's extent along.
        wt: And up.
        entrances: Of ``entrances_of``.
        seed: Of the letters.
        trim: Cover of frames; changed.
        pane: Of glass; changed.
        accent: Of what is painted in the house's second colour, a part of the trim as well; changed.
        letters_seen: Of letters; filled.
        board_seen: Of the board beside them; filled.
    """
    unit, _, _, _, _, foot, top = entrances
    inv_unit = F1 / unit
    begin, wide = ASIDE * inv_unit, F1 - (ASIDE + ASIDE) * inv_unit
    letters_foot, letters_up = foot + MARGIN_UP * (top - foot), (F1 - MARGIN_UP - MARGIN_UP) * (top - foot)
    inv_up = F1 / letters_up
    letters = min(MOST_LETTERS, int((unit - ASIDE - ASIDE) / PITCH) - 1)
    written_from = HALF * (unit - np.float32(letters) * PITCH)
    for i in range(s.shape[0]):
        half_t = max(HALF * wt[i], LEAST_HALF)
        low, high = t[i] - half_t, t[i] + half_t
        up = _overlap(low, high, foot, top) / (half_t + half_t)
        letters_seen[i] = F0
        board_seen[i] = F0
        if up <= F0:
            continue
        half = max(HALF * ws[i], LEAST_HALF)
        first, last = (s[i] - half) * inv_unit - begin, (s[i] + half) * inv_unit - begin
        n, m = np.floor(first), np.floor(last)
        board = up * ((m - n) * wide + (min(last - m, wide) - min(first - n, wide))) * unit / (half + half)
        coarse = min(F1, max(F0, (TWICE * half + half) / PITCH + HALF * half_t / letters_up - HALF))
        ink = F0
        if coarse < F1:  # a pixel reaches into two places at most
            shop = np.floor(s[i] * inv_unit)
            x = s[i] - shop * unit - written_from
            left, right = int(np.floor((x - half) / PITCH)), int(np.floor((x + half) / PITCH))
            foot_up, top_up = (low - letters_foot) * inv_up, (high - letters_foot) * inv_up
            for column in range(max(0, left), min(letters, right + 1)):
                own = x - np.float32(column) * PITCH
                ink += _letter(own - half, own + half, foot_up, top_up, column, seed + 97 * int(shop))
        mean = LETTERS_MEAN * board
        ink = min(board, ink + coarse * (mean - ink))
        rest = F1 - min(F1, board)
        pane[i] *= rest
        accent[i] = accent[i] * rest + (board - ink)
        trim[i] = min(F1 - pane[i], trim[i] * rest + board)
        letters_seen[i] = ink
        board_seen[i] = board - ink


@kernel
def part_accent(shade, trim, accent):
    """Take the accent's share out of the trim, of which it was a part, and shade it alike."""
    for i in range(accent.shape[0]):
        painted = min(trim[i], accent[i] * shade[i])
        accent[i] = painted
        trim[i] -= painted


@kernel
def light_accent(albedo, light, accent, out):
    """Add one plane of the accent under a uniform light (radiance of a white surface)."""
    colour = albedo * light
    for i in range(out.shape[0]):
        out[i] += colour * accent[i]


@kernel
def light_accent_by_sun(radiance, accent, share, out):
    """Add to one plane what the sun, which reaches shares of the pixels, adds to the accent."""
    for i in range(out.shape[0]):
        out[i] += radiance * accent[i] * share[i]


@kernel
def light_accent_by_lamps(albedo, light, tint, accent, lamp, head, out):
    """Add one plane of the accent under a uniform light, street lamps and the ego's beam."""
    for i in range(out.shape[0]):
        out[i] += albedo * accent[i] * (light + (lamp[i] * tint + head[i]) * INV_PI)


@kernel
def light_signs(letters, board, letters_seen, board_seen, out):
    """Add one plane of what a lit sign sends out: radiances of its letters and of its board."""
    for i in range(out.shape[0]):
        out[i] += letters * letters_seen[i] + board * board_seen[i]
