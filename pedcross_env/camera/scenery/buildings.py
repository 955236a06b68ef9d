"""Rows of houses as panels: ground floor, storeys, cornice, side walls."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.facade import PANEL_SIZE
from pedcross_env.scenario.street import StreetSpec

__all__ = ["building_panels"]

WALLS = np.array(
    [[0.42, 0.38, 0.31], [0.36, 0.20, 0.15], [0.48, 0.46, 0.42], [0.30, 0.29, 0.29], [0.44, 0.33, 0.21], [0.28, 0.17, 0.12],
     [0.40, 0.36, 0.36], [0.33, 0.36, 0.37], [0.50, 0.42, 0.30]]
)  # fmt: skip

House = tuple[int, float, float, float, float, np.ndarray]  # side, x range, front y, height, wall


def _panel(
    x: float, y: float, z: float, ax: float, ay: float, length: float, height: float, wall: np.ndarray
) -> np.ndarray:
    """Return a plain wall; see kernels.facade for what the numbers are."""
    panel = np.zeros(PANEL_SIZE)
    panel[:8] = x, y, z, ax, ay, 0.0, length, height
    panel[8:11] = wall
    panel[12], panel[17], panel[18], panel[24] = 3.0, z, 1.25, 1.0
    panel[26:30] = float(y > 0), x, ax, float(y > 0)
    return panel


def _side_wall(
    side: int, x: float, facing: float, front: float, height: float, wall: np.ndarray, neighbour: House | None
) -> list[np.ndarray]:
    """Return the visible parts of a side wall: above the neighbour, and in front of it."""
    deep = 12.0

    def strip(near: float, far: float, base: float, top: float) -> np.ndarray:
        start = near if (facing > 0) == (side > 0) else far
        return _panel(x, start, base, 0.0, facing, abs(far - near), top - base, 0.92 * wall)

    if neighbour is None:
        return [strip(front, front + side * deep, 0.0, height)]
    parts = []
    next_front, next_height = neighbour[3], neighbour[4]
    if height > next_height:
        parts.append(strip(front, front + side * deep, next_height, height))
    if side * (next_front - front) > 0.01:
        parts.append(strip(front, next_front, 0.0, min(height, next_height)))
    return parts


def building_panels(street: StreetSpec, rng: np.random.Generator) -> np.ndarray:
    """Rows of houses on both sides: ground floor, storeys, cornice, and side walls."""
    panels: list[np.ndarray] = []
    houses: list[House] = []
    for side in (-1, 1):
        x = street.start_x_m - 20.0
        while x < street.end_x_m + 40.0:
            length, storeys = rng.uniform(9, 24), int(rng.integers(2, 6))
            storey, ground = rng.uniform(2.9, 3.4), rng.uniform(3.4, 4.2)
            wall = WALLS[rng.integers(len(WALLS))] * rng.uniform(0.8, 1.15)
            front = side * (street.facade_y_m + (rng.uniform(0.2, 1.0) if rng.random() < 0.4 else 0.0))
            seed = int(rng.integers(1, 30_000))
            bays = max(2, round(length / rng.uniform(2.4, 3.4)))
            # the outward normal is axis x up: it points at the street on either side
            along = float(side)
            start = x if along > 0 else x + length
            height = ground + storeys * storey
            share = (rng.uniform(0.36, 0.55), rng.uniform(0.45, 0.6))
            shop = (rng.uniform(0.5, 0.85), rng.uniform(0.5, 0.68))
            panel = _panel(start, front, 0.0, along, 0.0, length, height + 0.5, wall)
            panel[11:17] = length / bays, storey, *share, 0.25, seed
            panel[19:22] = ground, length / max(1, bays // 2), shop[0]
            panel[22:26] = 0.12 * ground, (0.12 + shop[1]) * ground, rng.uniform(0.6, 1.0), height
            panels.append(panel)
            houses.append((side, x, x + length, front, height + 0.4, wall))
            x += length + (rng.uniform(2, 5) if rng.random() < 0.12 else 0.0)
    for i, (side, x0, x1, front, height, wall) in enumerate(houses):
        before = houses[i - 1] if i > 0 and houses[i - 1][0] == side else None
        after = houses[i + 1] if i + 1 < len(houses) and houses[i + 1][0] == side else None
        panels += _side_wall(
            side, x0, -1.0, front, height, wall, before if before and x0 - before[2] < 0.5 else None
        )
        panels += _side_wall(
            side, x1, 1.0, front, height, wall, after if after and after[1] - x1 < 0.5 else None
        )
    return np.array(panels)
