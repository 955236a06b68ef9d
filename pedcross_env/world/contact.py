"""First contact inside a step: a search that cannot step over one.

The search advances by separation over the highest closing speed (conservative advancement), so it never jumps
a contact, then bisects: the moment found depends on no clock rate.
"""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["STANDING_MPS", "first_contact"]

STANDING_MPS = 0.1
"""A slower ego stands: who walks or drives into it does not make it collide."""

_SHORTEST_STEP_S = 1e-4
_OVERLAP_STEP_S = 1e-3
_TIME_TOLERANCE_S = 1e-8


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
