"""First contact inside a step: separations, and a search that cannot step over one.

The search advances by separation over the highest closing speed (conservative advancement), so it never jumps
a contact, then bisects: the moment found depends on no clock rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable

__all__ = ["STANDING_MPS", "box_to_box_m", "box_to_disc_m", "first_contact"]

STANDING_MPS = 0.1
"""A slower ego stands: who walks or drives into it does not make it collide."""

_SHORTEST_STEP_S = 1e-4
_OVERLAP_STEP_S = 1e-3
_TIME_TOLERANCE_S = 1e-8


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
    cos, sin = abs(math.cos(other_yaw_rad)), abs(math.sin(other_yaw_rad))
    half_l, half_w = 0.5 * size_m[0], 0.5 * size_m[1]
    other_l, other_w = 0.5 * other_size_m[0], 0.5 * other_size_m[1]
    along = dx_m * math.cos(other_yaw_rad) + dy_m * math.sin(other_yaw_rad)
    across = dy_m * math.cos(other_yaw_rad) - dx_m * math.sin(other_yaw_rad)
    return max(
        abs(dx_m) - half_l - other_l * cos - other_w * sin,
        abs(dy_m) - half_w - other_l * sin - other_w * cos,
        abs(along) - other_l - half_l * cos - half_w * sin,
        abs(across) - other_w - half_l * sin - half_w * cos,
    )


def first_contact(
    separation_m: Callable[[float], float],
    ego_speed_mps: Callable[[float], float],
    *,
    closing_bound_mps: float,
    start_s: float,
    end_s: float,
    longest_step_s: float,
) -> float | None:
    """Time of the first contact with a moving ego in [start, end], None without one.

    Args:
        separation_m: Separation at a time.
        ego_speed_mps: The ego's speed at a time; below STANDING_MPS contact does not count.
        closing_bound_mps: No pair of points approaches faster than this in the interval.
        start_s: Start of the interval.
        end_s: Its end.
        longest_step_s: The search looks at least this often.
    """

    def touching(time_s: float) -> bool:
        return separation_m(time_s) <= 0 and ego_speed_mps(time_s) >= STANDING_MPS

    time_s, clear_s = start_s, start_s
    while True:
        gap = separation_m(time_s)
        if gap <= 0 and ego_speed_mps(time_s) >= STANDING_MPS:
            break
        clear_s = time_s
        if time_s >= end_s:
            return None
        step = max(gap / closing_bound_mps, _SHORTEST_STEP_S) if gap > 0 else _OVERLAP_STEP_S
        time_s = min(time_s + min(step, longest_step_s), end_s)
    while time_s - clear_s > _TIME_TOLERANCE_S:
        middle = 0.5 * (time_s + clear_s)
        if touching(middle):
            time_s = middle
        else:
            clear_s = middle
    return time_s
