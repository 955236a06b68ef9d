"""People who do not cross, some of whom look as if they would."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.config import BehaviourConfig
from pedcross_env.scenario.people import KERB_STAND_M, draw_approach, draw_person, place, visit
from pedcross_env.scenario.scenario import Leg, PedestrianSpec
from pedcross_env.scenario.street import StreetSpec

__all__ = ["draw_bystander"]

_KINDS = ("walking_along", "along_kerb", "walks_up", "kerb_standing", "standing")
_BESIDE_KERB_M = (0.35, 0.7)  # how near to the kerb somebody walks along it
_AT_STREET_M = 6.0  # of the meeting point, within which others come to the kerb too


def draw_bystander(
    rng: np.random.Generator,
    street: StreetSpec,
    weights: BehaviourConfig,
    *,
    from_x_m: float,
    meeting_x_m: float,
    duration_s: float,
) -> PedestrianSpec:
    """Draw somebody who stays off the carriageway.

    Args:
        rng: Of the behaviour.
        street: Where.
        weights: Of the kinds.
        from_x_m: Nobody stands or starts before it.
        meeting_x_m: Where the group comes to the street.
        duration_s: Who walks along walks on for so long.
    """
    person = draw_person(rng)
    shares = np.array(weights.bystanders) / sum(weights.bystanders)
    kind = _KINDS[int(rng.choice(len(_KINDS), p=shares))]
    side = int(rng.choice((-1, 1)))
    x = float(rng.uniform(from_x_m, meeting_x_m + 30.0))
    facing = -side * 0.5 * math.pi
    deep = float(rng.uniform(1.0, street.sidewalk_width_m - 0.5))
    beside = float(rng.uniform(*_BESIDE_KERB_M))
    ahead = int(rng.choice((-1, 1))) * person.speed_mps * (duration_s + 2.0)
    if kind == "walks_up":
        near = meeting_x_m + float(rng.uniform(-_AT_STREET_M, _AT_STREET_M))
        arrives_s = float(rng.uniform(1.0, 6.0))
        return visit(person, draw_approach(rng, street), street, near, side, arrives_s, crosses=False)
    if kind == "kerb_standing":
        return place(person, kind, (x, side * (street.kerb_y_m + KERB_STAND_M)), facing, ())
    if kind == "standing":
        back = side * (street.kerb_y_m + deep)
        return place(person, kind, (x, back), float(rng.uniform(-math.pi, math.pi)), ())
    line = side * (street.kerb_y_m + (beside if kind == "along_kerb" else deep))
    walk = Leg(to_x_m=x + ahead, to_y_m=line, speed_mps=person.speed_mps)
    return place(person, kind, (x, line), facing, (walk,))
