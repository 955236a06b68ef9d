"""How far road users' footprints are apart: boxes on the ground, at any heading."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

__all__ = ["box_gaps_m", "box_to_box_m", "box_to_disc_m"]


def box_to_disc_m(dx_m: float, dy_m: float, length_m: float, width_m: float, radius_m: float) -> float:
    """Separation of an axis-aligned box at the origin and a disc at (dx, dy); 0 or less in contact."""
    outside_x = max(abs(dx_m) - 0.5 * length_m, 0.0)
    outside_y = max(abs(dy_m) - 0.5 * width_m, 0.0)
    return math.hypot(outside_x, outside_y) - radius_m


def box_to_box_m(
    dx_m: float,
    dy_m: float,
    size_m: tuple[float, float],
    other_size_m: tuple[float, float],
    other_yaw_rad: float,
) -> float:
    """Separation along the best of the four face normals of two boxes (separating axis theorem).

    It never exceeds the distance and is 0 or less exactly when they touch.

    Args:
        dx_m: Centre of the other box relative to the first, along the first's length.
        dy_m: The same across it.
        size_m: (length, width) of the first box, whose yaw is 0.
        other_size_m: (length, width) of the other.
        other_yaw_rad: Yaw of the other relative to the first.
    """
    cos, sin = math.cos(other_yaw_rad), math.sin(other_yaw_rad)
    half_l, half_w = 0.5 * size_m[0], 0.5 * size_m[1]
    other_l, other_w = 0.5 * other_size_m[0], 0.5 * other_size_m[1]
    across, along = abs(cos), abs(sin)
    return max(
        abs(dx_m) - half_l - other_l * across - other_w * along,
        abs(dy_m) - half_w - other_l * along - other_w * across,
        abs(dx_m * cos + dy_m * sin) - other_l - half_l * across - half_w * along,
        abs(dy_m * cos - dx_m * sin) - other_w - half_l * along - half_w * across,
    )


def box_gaps_m(
    dx_m: Any, dy_m: Any, size_m: tuple[float, float], other_l_m: Any, other_w_m: Any, other_yaw_rad: Any
) -> np.ndarray:
    """``box_to_box_m`` for arrays that broadcast to one shape."""
    cos, sin = np.cos(other_yaw_rad), np.sin(other_yaw_rad)
    half_l, half_w, other_l, other_w = 0.5 * size_m[0], 0.5 * size_m[1], 0.5 * other_l_m, 0.5 * other_w_m
    across, along = np.abs(cos), np.abs(sin)
    gap = np.maximum(
        np.abs(dx_m) - half_l - other_l * across - other_w * along,
        np.abs(dy_m) - half_w - other_l * along - other_w * across,
    )
    gap = np.maximum(gap, np.abs(dx_m * cos + dy_m * sin) - other_l - half_l * across - half_w * along)
    return np.maximum(gap, np.abs(dy_m * cos - dx_m * sin) - other_w - half_l * along - half_w * across)
