"""When something starts: conditions on time, on the ego and on the traffic, as scenario standards have them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields

from pedcross_env.config import require

__all__ = ["Fires", "Trigger"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trigger:
    """Fires once all the conditions given hold together, then waits ``delay_s``; at least one is given.

    OpenSCENARIO 1.x has the same as SimulationTimeCondition, TimeToCollisionCondition,
    RelativeDistanceCondition (longitudinal), ReachPositionCondition and SpeedCondition in one condition
    group, and ``delay``. Distances are along the street, from the ego's front to where the actor is; once
    the ego has passed, ``distance_m`` and ``ttc_s`` no longer hold.
    """

    time_s: float | None = None  # at this time or later
    distance_m: float | None = None  # the ego is at most so far away
    ttc_s: float | None = None  # holding its speed, the ego arrives within this time
    gap_s: float | None = None  # no vehicle, nor the ego, arrives within this time: a gap somebody accepts
    ego_below_mps: float | None = None  # the ego is slower
    reached_x_m: float | None = None  # the actor itself has come to this place along the street
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        given = [f.name for f in fields(self) if f.name != "delay_s" and getattr(self, f.name) is not None]
        require(bool(given), "Trigger", "no condition", "one or more, e.g. Trigger(ttc_s=4.0)")
        for name in given:
            value = getattr(self, name)
            low = -math.inf if name == "reached_x_m" else 0.0
            require(math.isfinite(value) and value >= low, f"Trigger.{name}", value, "finite, 0 or more")
        require(0 <= self.delay_s < math.inf, "Trigger.delay_s", self.delay_s, "finite, 0 or more")


Fires = Callable[[Trigger, tuple[float, float, float], float], bool]
"""Whether a trigger's conditions hold, without its delay, for an actor at (x, y, heading), at a time."""
