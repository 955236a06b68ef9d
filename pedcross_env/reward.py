"""The reward, term by term: a weighted sum of what a passenger, a pedestrian and a clock would say of a step."""

from __future__ import annotations

from typing import Any

from pedcross_env.config import RewardConfig
from pedcross_env.contracts import Outcome
from pedcross_env.world import World

__all__ = ["TERMS", "reward_terms"]

TERMS = (
    "progress",
    "passed",
    "collision",
    "off_road",
    "discomfort",
    "jerk",
    "false_braking",
    "proximity",
    "time",
)
"""Names of the terms, in the order of ``reward_terms``."""


def reward_terms(
    weights: RewardConfig, world: World, facts: dict[str, Any], *, driven_m: float, acceleration_before_mps2: float,
    step_s: float,
) -> dict[str, float]:  # fmt: skip
    """Return each term of the step that just ended; their sum is its reward.

    Args:
        weights: See RewardConfig; all are 0 or more, penalties come out negative.
        world: After the step.
        facts: Of the world, after the step.
        driven_m: Along the planned way, in this step.
        acceleration_before_mps2: Of the ego, before it.
        step_s: Its length.

    Returns:
        progress: progress_per_m for each metre along the planned way.
        passed: passed, once, for driving through without contact.
        collision: -(collision + collision_per_mps * impact speed), once.
        off_road: -off_road, once, for leaving the carriageway.
        discomfort: -discomfort_per_mps2 * |acceleration|.
        jerk: -jerk_per_mps3 * |change of acceleration over the step| / step.
        false_braking: -false_braking_per_mps2 * deceleration while nobody crosses and nothing is in conflict.
        proximity: -proximity * (1 - time to contact / proximity_s) while that is positive.
        time: -time_per_s * step.
    """
    acceleration, outcome = world.ego.acceleration_mps2, world.outcome
    danger = bool(facts["conflict"]) or facts["crossing"] == 1
    impact = weights.collision + weights.collision_per_mps * world.impact_speed_mps
    nearness = max(0.0, 1.0 - facts["ttc_s"] / weights.proximity_s)
    return {
        "progress": weights.progress_per_m * driven_m,
        "passed": weights.passed if outcome is Outcome.PASSED else 0.0,
        "collision": -impact if outcome is Outcome.COLLISION else 0.0,
        "off_road": -weights.off_road if outcome is Outcome.OFF_ROAD else 0.0,
        "discomfort": -weights.discomfort_per_mps2 * abs(acceleration),
        "jerk": -weights.jerk_per_mps3 * abs(acceleration - acceleration_before_mps2) / step_s,
        "false_braking": 0.0 if danger else -weights.false_braking_per_mps2 * max(0.0, -acceleration),
        "proximity": -weights.proximity * nearness,
        "time": -weights.time_per_s * step_s,
    }
