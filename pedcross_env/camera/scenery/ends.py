"""Houses across the ends of a straight street, as if it met another there: without them it ended in a gap of bright sky."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.scenery.buildings import fit_bays
from pedcross_env.scenario.street import StreetSpec

__all__ = ["closing_rows"]

APART_M = 14.0  # from the last houses of the street to those across its end
HOUSES = 7  # across an end; an odd number, so that one stands in the middle
WIDE_M = 13.0  # one of them
FORWARD_M = 0.4  # by which the one in the middle stands before its neighbours,
LAP_M = 1.0  # which reach behind it: walls of the two sides of a street are drawn apart, a seam would let the sky through
HIGHEST_M = 20.0  # of them: from where people cross, a sun 7 degrees high has to stand above them
EVERY = 7  # how far apart along the street the fronts are that neighbours look like


def closing_rows(panels: np.ndarray, street: StreetSpec) -> np.ndarray:
    """Return the fronts across both ends, (2 * HOUSES, PANEL_SIZE), of the same kinds as along the street.

    Args:
        panels: Of both sides of a straight street.
        street: It.
    """
    fronts = panels[(np.abs(panels[:, 3]) > 0.5) & (panels[:, 11] > 0)]
    ends = fronts[:, 0] + fronts[:, 3] * fronts[:, 6]
    models = fronts[fronts[:, 7] <= HIGHEST_M]
    models = models if len(models) else fronts[[np.argmin(fronts[:, 7])]]
    low = min(fronts[:, 0].min(), ends.min()) - APART_M
    high = max(fronts[:, 0].max(), ends.max()) + APART_M
    wide = max(WIDE_M, 1.1 * street.facade_y_m)
    rows = [
        _across(models[(EVERY * k + 3 * way) % len(models)], x, way, wide, k - HOUSES // 2)
        for x, way in ((low, 1), (high, -1))
        for k in range(HOUSES)
    ]
    return np.array(rows)


def _across(like: np.ndarray, x: float, way: int, wide: float, place: int) -> np.ndarray:
    """One front that faces ``way`` along the street, ``place`` houses to the left of its middle."""
    panel = like.copy()
    right, left = (place - 0.5) * wide, (place + 0.5) * wide
    if abs(place) == 1:
        right, left = (right - LAP_M, left) if place > 0 else (right, left + LAP_M)
    x += way * FORWARD_M * (place == 0)
    # a panel is seen from the right-hand side of its axis
    panel[:7] = x, right if way > 0 else left, 0.0, 0.0, float(way), 0.0, left - right
    fit_bays(panel)
    panel[16] += place + HOUSES
    panel[26:30] = float(place >= 0), x, 0.0, float(place >= 0)
    return panel
