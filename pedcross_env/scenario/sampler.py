"""Random crossings and their look-alikes, drawn from one seed.

A scene (street, zebra, meeting point, parked and oncoming cars) is drawn first and from a stream of its own,
so it cannot tell the class. Then one or two people, the group, come to the meeting point: with
``crossing_share`` they cross there, else they stop at the kerb, by the same ways of approach. Bystanders are
drawn alike in both classes. Three quarters of the groups that cross are timed to be hit by an ego that holds
its speed, at a point spread evenly over its width; the others miss it by up to 1.5 s. Speeds are those of
``people.TYPES`` (younger 1.5, older 1.3, children 1.19 m/s in the literature; Euro NCAP's 5 and 8 km/h lie
within).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pedcross_env.config import EgoConfig, TrafficConfig
from pedcross_env.scenario.footprints import box_gaps_m
from pedcross_env.scenario.parking import oncoming_cars, parked_cars
from pedcross_env.scenario.people import KERB_STAND_M, Approach, draw_approach, draw_person, place, visit
from pedcross_env.scenario.scenario import Leg, PedestrianSpec, Scenario, VehicleSpec
from pedcross_env.scenario.sizes import contact_radius_m, pedestrian_size
from pedcross_env.scenario.street import Crosswalk, StreetSpec
from pedcross_env.scenario.walk import RAMP_S, Walk

__all__ = ["CONTACT_SHARE", "ZEBRA_SHARE", "holds_speed_and_hits", "sample_crossing"]

CONTACT_SHARE = 0.75
ZEBRA_SHARE = 0.6
PAIR_SHARE = 0.3
BEYOND_CROSSING_M = 15.0
MISS_S = (0.2, 1.5)
TIME_TO_CONTACT_S = (3.5, 6.0)
_ATTEMPTS = 60
_PREFER_FROM_KERB = 12  # attempts in which nobody may be on the carriageway at the start
_BODY_M = 0.3  # the group walks so far behind the meeting point: half a body
_GAP_SIDE_M = (0.6, 1.0)  # free beside a path between parked cars
_GRID_S = 0.01


@dataclass(frozen=True, slots=True)
class _Scene:
    """What is drawn before anybody's behaviour.

    Attributes:
        street: With its zebra.
        ego_speed_mps: Held if nobody brakes.
        meeting_x_m: Where the group comes to the street.
        meeting_s: When the ego's front would be there.
        side: +1: the group comes from the left (far side), -1: from the right (near side).
        zebra: Whether the meeting point is on the zebra.
        beside_m: How far along the street the second of the group walks; 0: one person alone.
        parked: Parked cars.
    """

    street: StreetSpec
    ego_speed_mps: float
    meeting_x_m: float
    meeting_s: float
    side: int
    zebra: bool
    beside_m: float
    parked: tuple[VehicleSpec, ...]


def _draw_scene(rng: np.random.Generator, traffic: TrafficConfig, ego: EgoConfig) -> _Scene:
    speed = float(rng.uniform(*traffic.ego_speed_mps))
    late = min(TIME_TO_CONTACT_S[1], 0.6 * traffic.duration_s)
    side = int(rng.choice((-1, 1)))
    early = TIME_TO_CONTACT_S[0] + (1.0 if side > 0 else 0.0)  # the way from the far side is longer
    meeting_s = float(rng.uniform(min(early, 0.75 * late), late))
    meeting_x = 0.5 * ego.length_m + speed * meeting_s
    zebra, pair = bool(rng.random() < ZEBRA_SHARE), bool(rng.random() < PAIR_SHARE)
    beside = (float(rng.uniform(0.8, 1.3)) if zebra else 0.7) if pair else 0.0
    zebra_x = meeting_x + (0.0 if zebra else float(rng.uniform(18.0, 35.0)))
    street = StreetSpec(
        end_x_m=max(240.0, meeting_x + 150.0),
        lane_width_m=float(rng.uniform(3.2, 3.7)),
        parking_width_m=float(rng.uniform(2.1, 2.4)),
        sidewalk_width_m=float(rng.uniform(2.5, 4.5)),
        crosswalks=(Crosswalk(x_m=zebra_x, width_m=float(rng.uniform(3.0, 5.0))),),
        seed=int(rng.integers(2**31)),
    )
    low, high = (float(rng.uniform(*_GAP_SIDE_M)) for _ in range(2))
    parked = parked_cars(
        rng, street, traffic.parked_share,
        path_x_m=(meeting_x + _BODY_M - low, meeting_x + _BODY_M + beside + high), between_side=0 if zebra
        else side,
    )  # fmt: skip
    return _Scene(street, speed, meeting_x, meeting_s, side, zebra, beside, parked)


def _reaches_s(spec: PedestrianSpec, y_m: float, side: int) -> float:
    """When a crossing pedestrian that comes from ``side`` is at ``y_m``."""
    walk = Walk(spec)
    times = np.arange(0.0, walk.end_s + 0.02, 0.01)
    return float(np.interp(-side * y_m, -side * walk.positions(times)[:, 1], times))


def holds_speed_and_hits(
    specs: list[PedestrianSpec], street: StreetSpec, ego: EgoConfig, *, ego_speed_mps: float, until_s: float
) -> bool:
    """Whether an ego that starts at x = 0 and holds its speed touches a pedestrian before ``until_s``."""
    times = np.arange(0.0, until_s, _GRID_S)
    for spec in specs:
        walk, size = Walk(spec), pedestrian_size(spec.height_m)
        xy = walk.positions(times)
        gaps = box_gaps_m(
            xy[:, 0] - ego_speed_mps * times, xy[:, 1] - street.ego_lane_y_m, (ego.length_m, ego.width_m),
            size.length_m, size.width_m, walk.yaws(times),
        )  # fmt: skip
        if (gaps <= 0).any():
            return True
    return False


def _group(
    rng: np.random.Generator, scene: _Scene, ego: EgoConfig, *, hits: bool
) -> tuple[list[PedestrianSpec], list[PedestrianSpec]]:
    """The people who come to the meeting point: (as they cross, as they stop at the kerb instead).

    The first are timed to be hit or missed by an ego that holds its speed.
    """
    leader, second = draw_person(rng), draw_person(rng)
    approach = draw_approach(rng, scene.street)
    aim = float(rng.uniform(-0.5, 0.5)) * ego.width_m
    shift = 0.0
    if not hits:
        half_way_s = (0.5 * ego.width_m + contact_radius_m(leader.height_m)) / leader.speed_mps
        early = rng.random() < 0.5
        ego_passes_s = (ego.length_m + 2 * contact_radius_m(leader.height_m)) / scene.ego_speed_mps
        shift = half_way_s + float(rng.uniform(*MISS_S)) + (0.0 if early else ego_passes_s)
        shift, aim = (-shift if early else shift), 0.0
    x, side = scene.meeting_x_m + _BODY_M, scene.side
    probe = visit(leader, Approach("stands", 0.0, 1.0, 1), scene.street, x, side, 20.0, crosses=True)
    to_aim_s = _reaches_s(probe, scene.street.ego_lane_y_m + aim, side) - 20.0
    if approach.style == "straight":
        to_aim_s -= 0.5 * RAMP_S
    leaves_s = scene.meeting_s + shift - to_aim_s
    members = [(leader, x, leaves_s)]
    if scene.beside_m > 0:
        follower, later_s = replace(second, speed_mps=leader.speed_mps), float(rng.uniform(-0.3, 0.3))
        members.append((follower, x + scene.beside_m, leaves_s + later_s))
    crossing, stopping = (
        [
            visit(person, approach, scene.street, at, side, when, crosses=crosses)
            for person, at, when in members
        ]
        for crosses in (True, False)
    )
    return crossing, stopping


def _bystander(rng: np.random.Generator, scene: _Scene, duration_s: float) -> PedestrianSpec:
    """Somebody who does not cross: walks along, waits at or comes to the kerb, stands."""
    street, person = scene.street, draw_person(rng)
    behaviour = str(
        rng.choice(("walking_along", "waiting", "kerb_standing", "standing"), p=(0.4, 0.25, 0.15, 0.2))
    )
    side = int(rng.choice((-1, 1)))
    x = float(rng.uniform(8.0, scene.meeting_x_m + 30.0))
    facing = -side * 0.5 * math.pi
    back = side * (street.kerb_y_m + float(rng.uniform(1.0, street.sidewalk_width_m - 0.5)))
    if behaviour == "waiting":
        near = scene.meeting_x_m + float(rng.uniform(-6.0, 6.0))
        arrives_s = float(rng.uniform(1.0, 6.0))
        return visit(person, draw_approach(rng, street), street, near, side, arrives_s, crosses=False)
    if behaviour == "walking_along":
        ahead = int(rng.choice((-1, 1))) * person.speed_mps * (duration_s + 2.0)
        return place(
            person,
            behaviour,
            (x, back),
            facing,
            (Leg(to_x_m=x + ahead, to_y_m=back, speed_mps=person.speed_mps),),
        )
    if behaviour == "kerb_standing":
        return place(person, behaviour, (x, side * (street.kerb_y_m + KERB_STAND_M)), facing, ())
    return place(person, behaviour, (x, back), float(rng.uniform(-math.pi, math.pi)), ())


def sample_crossing(seed: int, traffic: TrafficConfig, ego: EgoConfig) -> Scenario:
    """Draw a scenario.

    Args:
        seed: Gives the scenario wholly; scene and behaviour have streams of their own.
        traffic: Shares and ranges. ``max_bystanders`` is besides the group at the meeting point;
            with 0 nobody else is there, and episodes without crossing show an empty street.
        ego: Its size, for the timing.

    Returns:
        A scenario named "crossing/..." or "non-crossing/...", followed by place and side.
    """
    scene_stream, behaviour_stream = np.random.SeedSequence(seed).spawn(2)
    scene_rng, rng = np.random.default_rng(scene_stream), np.random.default_rng(behaviour_stream)
    scene = _draw_scene(scene_rng, traffic, ego)
    crosses, hits = bool(rng.random() < traffic.crossing_share), bool(rng.random() < CONTACT_SHARE)
    bystanders = [
        _bystander(rng, scene, traffic.duration_s)
        for _ in range(int(rng.integers(traffic.max_bystanders + 1)))
    ]
    finish_x = scene.meeting_x_m + BEYOND_CROSSING_M
    until_s = min(traffic.duration_s, (finish_x - 0.5 * ego.length_m) / scene.ego_speed_mps)
    group: list[PedestrianSpec] = []
    if crosses or traffic.max_bystanders > 0:
        for attempt in range(_ATTEMPTS):  # the class takes no part in the choice of ways and times
            crossing, stopping = _group(rng, scene, ego, hits=hits)
            group = crossing if crosses else stopping
            already_out = any(abs(spec.y_m) < scene.street.kerb_y_m for spec in crossing)
            speed = scene.ego_speed_mps
            met = holds_speed_and_hits(crossing, scene.street, ego, ego_speed_mps=speed, until_s=until_s)
            if met == hits and (attempt >= _PREFER_FROM_KERB or not already_out):
                break
    where, side = ("zebra" if scene.zebra else "between-cars"), ("far" if scene.side > 0 else "near")
    return Scenario(
        name=f"{'crossing' if crosses else 'non-crossing'}/{where}/{side}",
        street=scene.street,
        ego_speed_mps=scene.ego_speed_mps,
        finish_x_m=finish_x,
        duration_s=traffic.duration_s,
        pedestrians=(*group, *bystanders),
        vehicles=(
            *scene.parked,
            *oncoming_cars(scene_rng, scene.street, traffic.max_oncoming, meeting_x_m=scene.meeting_x_m),
        ),
    )
