"""Who walks in the street: types of people, and their ways to the kerb and across."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pedcross_env.scenario.scenario import Leg, PedestrianSpec
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.scenario.walk import RAMP_S, Walk

__all__ = [
    "KERB_STAND_M", "TYPES", "Approach", "Person", "PersonType", "draw_approach", "draw_person", "place",
    "visit",
]  # fmt: skip

KERB_STAND_M = 0.35  # feet of who waits, from the kerb


@dataclass(frozen=True, slots=True)
class PersonType:
    """Model, share, height (low, high), speed (mean, spread, low, high), share that runs at 2.2 m/s."""

    model: str
    share: float
    height_m: tuple[float, float]
    speed_mps: tuple[float, float, float, float]
    running_share: float


TYPES = (
    PersonType("adult", 0.6, (1.55, 1.95), (1.45, 0.2, 1.0, 2.0), 0.12),
    PersonType("child", 0.22, (1.05, 1.4), (1.3, 0.2, 0.9, 1.8), 0.2),
    PersonType("elderly", 0.18, (1.5, 1.8), (1.15, 0.2, 0.7, 1.5), 0.0),
)


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
    """Draw how somebody comes to the kerb of a street."""
    style = str(rng.choice(("stands", "pauses", "straight"), p=(0.25, 0.35, 0.4)))
    back = float(rng.uniform(0.9, street.sidewalk_width_m - 0.5))
    return Approach(style, float(rng.uniform(0.5, 2.0)), back, int(rng.choice((-1, 1))))


def visit(
    person: Person,
    approach: Approach,
    street: StreetSpec,
    x_m: float,
    side: int,
    leaves_kerb_s: float,
    *,
    crosses: bool,
) -> PedestrianSpec:
    """Somebody who is at the kerb at ``leaves_kerb_s`` and then crosses, or stays there.

    Where the time is too short for the way, it starts on its way, if need be on the carriageway.
    """
    v = person.speed_mps
    kerb_y, facing = side * (street.kerb_y_m + KERB_STAND_M), -side * 0.5 * math.pi
    beyond = Leg(to_x_m=x_m, to_y_m=-side * (street.facade_y_m - 0.6), speed_mps=v)
    behaviour = "crossing" if crosses else "waiting"
    if crosses and leaves_kerb_s <= 0:
        start = kerb_y + side * v * leaves_kerb_s
        return place(person, behaviour, (x_m, start), facing, (beyond,))
    pause = approach.pause_s if approach.style == "pauses" else 0.0
    walking_m = v * max(0.0, leaves_kerb_s - pause - (0.5 * RAMP_S if pause else 0.0))
    too_short = walking_m < 2 * RAMP_S * v  # to come to a stop in
    if approach.style == "stands" or too_short:
        legs = (replace(beyond, wait_s=leaves_kerb_s),) if crosses else ()
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
    wait = max(0.0, leaves_kerb_s - arrives_s) if pause else 0.0
    return place(person, behaviour, origin, facing, (*way, replace(beyond, wait_s=wait)))
