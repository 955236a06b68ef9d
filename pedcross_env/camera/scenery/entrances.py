"""Doors and signs of houses, drawn by the house's own seed."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

__all__ = ["ENTRANCES", "Entrance", "add_entrance"]

Entrance = Literal["door", "glass", "shop"]
ENTRANCES: tuple[str, ...] = get_args(Entrance)
LEAVES = (
    (0.055, 0.030, 0.018), (0.11, 0.06, 0.03), (0.022, 0.055, 0.035), (0.025, 0.035, 0.075), (0.10, 0.018, 0.018), (0.045, 0.045, 0.05),
    (0.33, 0.33, 0.31), (0.05, 0.09, 0.10),
)  # fmt: skip
BOARDS = (
    (0.30, 0.025, 0.02), (0.02, 0.07, 0.22), (0.02, 0.13, 0.06), (0.03, 0.03, 0.035), (0.42, 0.22, 0.02), (0.02, 0.14, 0.17),
    (0.14, 0.03, 0.09), (0.10, 0.06, 0.035),
)  # fmt: skip
STEEL = ((0.05, 0.05, 0.055), (0.20, 0.20, 0.20))
GLAZED = {"door": 0.0, "glass": 0.8, "shop": 0.75}  # share of a leaf
LEAST_TOP_M, GLASS_TOP_M = 2.3, 2.75
SIGN_M, BELOW_LEDGE_M = 0.62, 0.36  # height of a board, and its top below the ground floor's
# after dark some signs are boxes of light, of some the letters alone shine. How many, how bright (cd/m2) and how much less a painted
# face lets through are our estimates: below the 400 cd/m2 that CIE 150 (obtrusive light) allows a small sign in its zone E2, small towns
BOXES, LETTERS_ALONE = 0.35, 0.25
SIGN_CD_M2, FACE = (50.0, 200.0), 0.25


def add_entrance(panel: np.ndarray, entrance: Entrance) -> None:
    """Put doors, and signs over shops, on a front; see kernels.facade for its numbers.

    Args:
        panel: (PANEL_SIZE,) with its ground floor; changed.
        entrance: What kind.
    """
    rng = np.random.default_rng([int(panel[16]), 0xD0])
    bay, duty, floor, lintel = panel[20], panel[21], panel[19], panel[23]
    bays = max(1, round(panel[6] / bay))
    shops = [n for n in (1, 2) if bays % n == 0] if entrance == "shop" else [bays]
    unit = int(rng.choice(shops)) if bays * bay > 9.0 else bays
    colours = {"door": LEAVES, "glass": STEEL, "shop": BOARDS}[entrance]
    panel[30:33] = np.array(colours[rng.integers(len(colours))]) * rng.uniform(0.8, 1.25)
    panel[33], panel[34] = unit, rng.integers(unit)
    if entrance == "door":  # where a window would be
        panel[35], panel[36], panel[37] = max(1.2, duty * bay), max(LEAST_TOP_M, lintel), 0.5
    else:  # at the end of a window
        wide = min(duty * bay, 1.25 if entrance == "shop" else 2.2)
        top = min(GLASS_TOP_M, lintel)
        panel[35], panel[36], panel[37] = wide, top, 0.5 + 0.5 * duty - 0.5 * wide / bay
    panel[38] = GLAZED[entrance]
    if entrance == "shop":
        top = floor - BELOW_LEDGE_M
        panel[39:41] = max(top - SIGN_M, lintel + 0.02), top
        panel[41:43] = _sign_light(int(panel[16]))


def _sign_light(seed: int) -> tuple[float, float]:
    """Luminance after dark of a shop's letters and of its board, were that white; by a stream of its own."""
    rng = np.random.default_rng([seed, 0x516])
    kind, luminance = rng.random(), float(rng.uniform(*SIGN_CD_M2))
    if kind < BOXES:
        return luminance, FACE * luminance
    return (luminance, 0.0) if kind < BOXES + LETTERS_ALONE else (0.0, 0.0)
