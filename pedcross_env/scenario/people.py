"""Who walks in the street: types of people, and their ways to the kerb and across."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from pedcross_env.scenario.scenario import Leg, PedestrianSpec
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.scenario.trigger import Trigger
from pedcross_env.scenario.walk import RAMP_S, Walk

__all__ = [
    "KERB_STAND_M", "TYPES", "WAYS", "Approach", "Over", "Person", "PersonType", "Way", "draw_approach", "draw_over",
    "draw_person", "place", "visit",
]  # fmt: skip

KERB_STAND_M = 0.35  # feet of who waits, from the kerb
_BEFORE_LANE_M = 0.15  # and of who waits midway, from the edge of the ego's lane


@dataclass(frozen=True, slots=True)
class PersonType:
    """Model, share, height (low, high), speed (mean, spread, low, high), share that runs at 2.2 m/s."""

    model: str
    share: float
    height_m: tuple[float, float]
    speed_mps: tuple[float, float, float, float]
    running_share: float


TYPES = (
    PersonType("adult", 0.6, (1.55, 1.95), (1.5, 0.24, 0.9, 2.2), 0.1),
    PersonType("child", 0.22, (1.05, 1.4), (1.19, 0.18, 0.7, 1.8), 0.2),
    PersonType("elderly", 0.18, (1.5, 1.8), (1.3, 0.32, 0.6, 2.0), 0.0),
)
"""Walking speeds of adults (15th percentile 1.25 m/s), the elderly (0.97 m/s) and children as measured at crossings."""

Way = Literal["on", "hesitates", "stops_midway", "turns_back", "yields", "yields_midway"]
WAYS: tuple[Way, ...] = get_args(Way)


@dataclass(frozen=True, slots=True)
class Person:
    """One person drawn: model, height, walking speed, seed of its looks."""

    model: str
    height_m: float
    speed_mps: float
    seed: int


def draw_person(rng: np.random.Generator) -> Person:
    """Draw a type by its share, then height and speed within the type."""
    kind = TYPES[int(rng.choice(len(TYPES), p=[t.share for t in TYPES]))]
    mean, spread, low, high = kind.speed_mps
    speed = 2.2 if rng.random() < kind.running_share else float(np.clip(rng.normal(mean, spread), low, high))
    return Person(kind.model, float(rng.uniform(*kind.height_m)), speed, int(rng.integers(2**31)))


def place(
    person: Person, behaviour: str, start: tuple[float, float], yaw: float, legs: tuple[Leg, ...]
) -> PedestrianSpec:
    """Put a person somewhere with a way to go; who is under way at the start faces it."""
    if legs and legs[0].wait_s == 0:
        yaw = math.atan2(legs[0].to_y_m - start[1], legs[0].to_x_m - start[0])
    return PedestrianSpec(
        behaviour=behaviour, x_m=start[0], y_m=start[1], yaw_rad=yaw, legs=legs,
        model=person.model, height_m=person.height_m, seed=person.seed,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Approach:
    """How somebody comes to the kerb.

    Attributes:
        style: "stands" at the kerb from the start, "pauses" there, or walks "straight" on.
        pause_s: At the kerb, if it pauses.
        back_m: From where on the sidewalk it comes, from the kerb.
        direction: From which side along the sidewalk, +-1.
    """

    style: str
    pause_s: float
    back_m: float
    direction: int


def draw_approach(rng: np.random.Generator, street: StreetSpec) -> Approach:
    """Draw how somebody comes to the kerb of a street; a third stand in the last second before (34.2 % in JAAD)."""
    style = str(rng.choice(("stands", "pauses", "straight"), p=(0.1, 0.15, 0.75)))
    back = float(rng.uniform(0.9, street.sidewalk_width_m - 0.5))
    return Approach(style, float(rng.uniform(0.5, 2.0)), back, int(rng.choice((-1, 1))))


@dataclass(frozen=True, slots=True)
class Over:
    """How somebody gets over the carriageway.

    Attributes:
        way: One of WAYS.
        reach_m: From the kerb to where it stops, or turns back.
        pause_s: There.
        gap_s: Smallest gap that is accepted there, for who yields.
    """

    way: Way = "on"
    reach_m: float = 0.0
    pause_s: float = 0.0
    gap_s: float = 0.0


STRAIGHT_OVER = Over()


def draw_over(
    rng: np.random.Generator,
    street: StreetSpec,
    side: int,
    speed_mps: float,
    shares: tuple[float, float, float, float, float],
) -> Over:
    """Draw how somebody crosses a street that it enters from ``side``.

    Who yields accepts no gap in which it would not be out of the ego's lane a second before the ego comes. Midway is
    the edge of the ego's lane: beside the parked cars, or the middle of the street for who comes from the left.

    Args:
        rng: Of the behaviour.
        street: Which.
        side: +1: from the left.
        speed_mps: Of the walk over.
        shares: Of who hesitates, stops midway, turns back, yields at the kerb, yields midway; the rest walks on.
    """
    way = WAYS[int(rng.choice(len(WAYS), p=[max(0.0, 1.0 - sum(shares)), *shares]))]
    to_ego_lane = abs(side * street.kerb_y_m - street.ego_lane_y_m)
    # accepted gaps: half of them above 4 s, 15 % above 7 s, within the 5.3 to 9.4 s that studies give for those 15 %
    drawn_s = float(np.clip(4.0 * math.exp(0.54 * rng.standard_normal()), 2.0, 12.0))
    edge = max(0.0, to_ego_lane - 0.5 * street.lane_width_m - _BEFORE_LANE_M)
    from_m = edge if way == "yields_midway" else -KERB_STAND_M
    gap_s = max(drawn_s, (to_ego_lane + 0.5 * street.lane_width_m - from_m) / speed_mps + 1.0)
    share, pause = float(rng.uniform()), float(rng.uniform())
    reach, pause_s = {
        "on": (0.0, 0.0),
        "yields": (0.0, 0.0),
        "yields_midway": (edge, 0.0),
        "hesitates": (0.5 + 0.7 * share, 0.4 + 1.1 * pause),
        "stops_midway": (1.5 + share * (2 * street.kerb_y_m - 3.0), 0.8 + 1.7 * pause),
        "turns_back": (0.8 + share * (to_ego_lane - 0.8), 0.2 + 0.6 * pause),
    }[way]
    return Over(way, reach, pause_s, gap_s)


def _over_legs(x_m: float, side: int, street: StreetSpec, speed: float, over: Over) -> tuple[Leg, ...]:
    beyond = Leg(to_x_m=x_m, to_y_m=-side * (street.facade_y_m - 0.6), speed_mps=speed)
    if over.way in ("on", "yields"):
        return (beyond,)
    stop_y = side * (street.kerb_y_m - over.reach_m)
    there = Leg(to_x_m=x_m, to_y_m=stop_y, speed_mps=speed)
    if over.way == "turns_back":
        kerb = Leg(to_x_m=x_m, to_y_m=side * (street.kerb_y_m + 0.8), speed_mps=speed, wait_s=over.pause_s)
        return there, kerb
    if over.way == "yields_midway":
        return there, replace(beyond, go=Trigger(gap_s=over.gap_s))
    return there, replace(beyond, wait_s=over.pause_s)


def visit(
    person: Person,
    approach: Approach,
    street: StreetSpec,
    x_m: float,
    side: int,
    leaves_kerb_s: float,
    *,
    crosses: bool,
    over: Over = STRAIGHT_OVER,
) -> PedestrianSpec:
    """Somebody who is at the kerb at ``leaves_kerb_s`` and then crosses, or stays there.

    Where the time is too short for the way, it starts on its way, if need be on the carriageway.
    """
    v = person.speed_mps
    kerb_y, facing = side * (street.kerb_y_m + KERB_STAND_M), -side * 0.5 * math.pi
    first, *rest = _over_legs(x_m, side, street, v, over)
    behaviour = "crossing" if crosses else "waiting"
    if crosses and leaves_kerb_s <= 0 and over.way == "on":
        start = kerb_y + side * v * leaves_kerb_s
        return place(person, behaviour, (x_m, start), facing, (first,))
    leaves_kerb_s = max(0.0, leaves_kerb_s)
    if over.way == "yields":
        first = replace(first, go=Trigger(gap_s=over.gap_s, time_s=leaves_kerb_s))
    pause = approach.pause_s if approach.style == "pauses" else 0.0
    walking_m = v * max(0.0, leaves_kerb_s - pause - (0.5 * RAMP_S if pause else 0.0))
    too_short = walking_m < 2 * RAMP_S * v  # to come to a stop in
    if approach.style == "stands" or too_short:
        wait = 0.0 if over.way == "yields" else leaves_kerb_s
        legs = (replace(first, wait_s=wait), *rest) if crosses else ()
        return place(person, behaviour, (x_m, kerb_y), facing, legs)
    back_m = min(approach.back_m, walking_m)
    back_y, along = kerb_y + side * back_m, walking_m - back_m
    to_kerb = Leg(to_x_m=x_m, to_y_m=kerb_y, speed_mps=v)
    origin = (x_m, back_y)
    way: tuple[Leg, ...] = (to_kerb,)
    if along > 0.02:
        origin = (x_m + approach.direction * along, back_y)
        way = (Leg(to_x_m=x_m, to_y_m=back_y, speed_mps=v), to_kerb)
    if not crosses:
        return place(person, behaviour, origin, facing, way)
    arrives_s = Walk(place(person, behaviour, origin, facing, way)).end_s
    wait = max(0.0, leaves_kerb_s - arrives_s) if pause and over.way != "yields" else 0.0
    return place(person, behaviour, origin, facing, (*way, replace(first, wait_s=wait), *rest))
