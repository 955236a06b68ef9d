"""Side walls of houses: the ground floor and the cornice go round the corner, and there are a few windows."""

from __future__ import annotations

import numpy as np

__all__ = ["finish_side_wall"]

PIERCED = 0.85  # share of side walls with windows: of those from the ground up,
PIERCED_ABOVE = 0.6  # and of what is seen of them above a neighbour
COLUMNS = (1, 4)  # of windows, least and beyond the most
WINDOW_M = (0.8, 1.2)  # width of one
LEAST_M = 4.0  # length of a wall with windows
BANDS = 0.9  # share of the bay from which windows are bands of glass, which go round the house
SILL = 0.25  # of the storey
CLEAR = 0.05  # of the storey, least, from a window to the neighbour's roof
FRAME_M = 0.09


def finish_side_wall(wall: np.ndarray, front: np.ndarray) -> None:
    """Give a plain side wall what its house has in front; drawn by the house's own seed.

    Args:
        wall: (PANEL_SIZE,) see kernels.facade; changed. It may start above a neighbour's roof.
        front: (PANEL_SIZE,) of its house.
    """
    base, length, storey = wall[2], wall[6], front[12]
    rng = np.random.default_rng([int(front[16]), 0x51DE])
    pierced, columns = rng.random() < (PIERCED_ABOVE if base > 0 else PIERCED), int(rng.integers(*COLUMNS))
    wide = float(rng.uniform(*WINDOW_M))
    bands = front[13] > BANDS
    if bands:
        columns = max(1, round(length / front[11]))
    bay = length / columns
    share = front[13] if bands else min(0.5, wide / bay)
    if length < LEAST_M or not (pierced or bands):
        share = 0.0
    tall = front[14] if share > 0 else 0.0
    wall[11:17] = bay, storey, share, tall, SILL, front[16]
    wall[18], wall[20], wall[21] = front[18], bay, share
    wall[25], wall[43] = front[25] - base, 1.0
    if base > 0:  # no ground floor; no window is cut by the neighbour's roof
        rise = ((front[19] - base) / storey + SILL) % 1.0
        wall[15] = min(max(rise, CLEAR), 1.0 - tall - CLEAR)
        wall[19], wall[21], wall[22:25] = 0.0, 0.0, (FRAME_M, FRAME_M, 1.0)
    else:
        wall[19], wall[22:25] = front[19], front[22:25]
