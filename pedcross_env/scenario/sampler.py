"""Random crossings and their look-alikes, drawn from one seed.

A scene (street, zebra, meeting point, parked cars, oncoming cars, cyclists, doors) is drawn first and from a stream of
its own, so it cannot tell the class. Then one to four people, the group, come to the meeting point: with
``crossing_share`` they cross there, else they stop at the kerb, by the same ways of approach. Bystanders are drawn
alike in both classes. Three quarters of the groups that walk on or stop midway are timed to be hit by an ego that
holds its speed, at a point spread evenly over its width; the others miss it by up to 1.5 s. Off the zebra six of ten
come from between parked cars, a quarter from behind one, the rest where nothing hides them. Speeds are those of
``people.TYPES`` (Euro NCAP's 5 and 8 km/h lie within); how people cross and what else happens is set by
``BehaviourConfig``.

Shadows, rolled or open umbrellas and lightning are no part of a scenario: clothes and things to carry follow from each
person's seed, shadows and flashes from the weather, in which any crossing can be played.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pedcross_env.config import BehaviourConfig, EgoConfig, TrafficConfig
from pedcross_env.scenario.bending import bent, draw_bend
from pedcross_env.scenario.bystanders import draw_bystander
from pedcross_env.scenario.footprints import box_gaps_m
from pedcross_env.scenario.parking import Beside, parked_cars
from pedcross_env.scenario.passers import cyclists, leading_car, oncoming_cars, turning_cars, with_door
from pedcross_env.scenario.people import Approach, draw_approach, draw_over, draw_person, visit
from pedcross_env.scenario.scenario import PedestrianSpec, Scenario, VehicleSpec
from pedcross_env.scenario.sizes import contact_radius_m, pedestrian_size
from pedcross_env.scenario.street import Crosswalk, Intersection, StreetSpec
from pedcross_env.scenario.walk import RAMP_S, Walk

__all__ = ["CONTACT_SHARE", "ZEBRA_SHARE", "holds_speed_and_hits", "sample_crossing"]

CONTACT_SHARE = 0.75
ZEBRA_SHARE = 0.6
BESIDE_SHARES: dict[Beside, float] = {"between": 0.6, "behind": 0.25, "": 0.15}
BEYOND_CROSSING_M = 15.0
MISS_S = (0.2, 1.5)
TIME_TO_CONTACT_S = (3.5, 6.0)
_ATTEMPTS = 60
_PREFER_FROM_KERB = 12  # attempts in which nobody may be on the carriageway at the start
_BODY_M = 0.3  # the group walks so far behind the meeting point: half a body
_GAP_SIDE_M = (0.6, 1.0)  # free beside a path between parked cars
_GRID_S = 0.01
_MISSING = ("turns_back", "yields", "yields_midway")  # ways that an ego which holds its speed misses
_TO_CORNER_M = 26.0  # from the middle of a side street to the meeting point
_CORNER_FROM_M = 20.0  # and from the ego's start


@dataclass(frozen=True, slots=True)
class _Scene:
    """What is drawn before anybody's behaviour.

    Attributes:
        street: With its zebra.
        ego_speed_mps: Held if nobody brakes.
        meeting_x_m: Where the group comes to the street.
        meeting_s: When the ego's front would be there.
        side: +1: the group comes from the left (far side), -1: from the right (near side).
        place: "zebra", or what hides the meeting point: "between-cars", "behind-car", "open".
        beside_m: How far along the street each of the group walks behind the first.
        vehicles: All but a leading car.
    """

    street: StreetSpec
    ego_speed_mps: float
    meeting_x_m: float
    meeting_s: float
    side: int
    place: str
    beside_m: tuple[float, ...]
    vehicles: tuple[VehicleSpec, ...]


def _draw_scene(rng: np.random.Generator, traffic: TrafficConfig, ego: EgoConfig) -> _Scene:
    how = traffic.behaviour
    speed = float(rng.uniform(*traffic.ego_speed_mps))
    late = min(TIME_TO_CONTACT_S[1], 0.6 * traffic.duration_s)
    side = int(rng.choice((-1, 1)))
    early = TIME_TO_CONTACT_S[0] + (1.0 if side > 0 else 0.0)  # the way from the far side is longer
    meeting_s = float(rng.uniform(min(early, 0.75 * late), late))
    crossed = bool(rng.random() < how.intersection)
    if crossed:  # farther off, so that the side street fits in between
        later_s = max(meeting_s, (_TO_CORNER_M + _CORNER_FROM_M) / speed)
        crossed = later_s + (BEYOND_CROSSING_M + 1.0) / speed < traffic.duration_s
        meeting_s = later_s if crossed else meeting_s
    meeting_x = 0.5 * ego.length_m + speed * meeting_s
    zebra = bool(rng.random() < ZEBRA_SHARE)
    beside = tuple(BESIDE_SHARES)[int(rng.choice(3, p=list(BESIDE_SHARES.values())))]
    people = 1 + int(rng.choice(4, p=np.array(how.group_sizes) / sum(how.group_sizes)))
    steps = [float(rng.uniform(0.8, 1.3)) if zebra else 0.7 for _ in range(3)][: people - 1]
    beside_m = tuple(float(v) for v in np.cumsum([0.0, *steps]))
    zebra_x = meeting_x + (0.0 if zebra else float(rng.uniform(18.0, 35.0)))
    street = StreetSpec(
        end_x_m=max(240.0, meeting_x + 150.0),
        lane_width_m=float(rng.uniform(3.2, 3.7)),
        parking_width_m=float(rng.uniform(2.1, 2.4)),
        sidewalk_width_m=float(rng.uniform(2.5, 4.5)),
        crosswalks=(Crosswalk(x_m=zebra_x, width_m=float(rng.uniform(3.0, 5.0))),),
        seed=int(rng.integers(2**31)),
        intersection=Intersection(x_m=meeting_x - _TO_CORNER_M, crosswalk_width_m=0.0) if crossed else None,
    )
    low, high = (float(rng.uniform(*_GAP_SIDE_M)) for _ in range(2))
    path = (meeting_x + _BODY_M - low, meeting_x + _BODY_M + beside_m[-1] + high)
    parked = parked_cars(
        rng, street, traffic.parked_share, path_x_m=path, beside="" if zebra else beside, side_of_path=side
    )
    place = "zebra" if zebra else {"between": "between-cars", "behind": "behind-car", "": "open"}[beside]
    vehicles = _draw_passers(rng, street, parked, path, traffic, ego, speed, meeting_x)
    return _Scene(street, speed, meeting_x, meeting_s, side, place, beside_m, vehicles)


def _draw_passers(
    rng: np.random.Generator,
    street: StreetSpec,
    parked: tuple[VehicleSpec, ...],
    path_x_m: tuple[float, float],
    traffic: TrafficConfig,
    ego: EgoConfig,
    ego_speed_mps: float,
    meeting_x_m: float,
) -> tuple[VehicleSpec, ...]:
    how, seeds = traffic.behaviour, rng.spawn(4)  # what one of them draws shifts no other
    oncoming = oncoming_cars(seeds[1], street, traffic.max_oncoming, meeting_x_m=meeting_x_m)
    if street.intersection is not None:
        oncoming = turning_cars(seeds[3], street, first_x_m=meeting_x_m + 10.0)
    riders: tuple[VehicleSpec, ...] = ()
    if seeds[2].random() < how.cyclist:
        riders = cyclists(
            seeds[2], street, (*parked, *oncoming), ego, ego_speed_mps=ego_speed_mps, meeting_x_m=meeting_x_m
        )
    if seeds[0].random() < how.door:
        parked = with_door(seeds[0], parked, street, ego, path_x_m, riders)
    return (*parked, *oncoming, *riders)


def _reaches_s(spec: PedestrianSpec, y_m: float, side: int) -> float:
    """When a crossing pedestrian that comes from ``side`` is first at ``y_m``, or as near as it comes."""
    walk = Walk(spec)
    times = np.arange(0.0, walk.end_s + 0.02, 0.01)
    gone = np.maximum.accumulate(-side * walk.positions(times)[:, 1])
    return float(np.interp(-side * y_m, gone, times))


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
    rng: np.random.Generator, scene: _Scene, ego: EgoConfig, how: BehaviourConfig, *, hits: bool
) -> tuple[list[PedestrianSpec], list[PedestrianSpec], bool]:
    """The people who come to the meeting point: (as they cross, as they stop at the kerb instead, whether they hit).

    The first are timed to be hit or missed by an ego that holds its speed; who yields or turns back misses it.
    """
    street, side = scene.street, scene.side
    people = [draw_person(rng) for _ in range(len(scene.beside_m) + 1)]
    approach, leader = draw_approach(rng, street), people[0]
    over = draw_over(rng, street, side, leader.speed_mps, how.ways)
    hits = hits and over.way not in _MISSING
    aim = float(rng.uniform(-0.5, 0.5)) * ego.width_m
    shift = 0.0
    if not hits:
        half_way_s = (0.5 * ego.width_m + contact_radius_m(leader.height_m)) / leader.speed_mps
        early = rng.random() < 0.5
        ego_passes_s = (ego.length_m + 2 * contact_radius_m(leader.height_m)) / scene.ego_speed_mps
        shift = half_way_s + float(rng.uniform(*MISS_S)) + (0.0 if early else ego_passes_s)
        shift, aim = (-shift if early else shift), 0.0
    x = scene.meeting_x_m + _BODY_M
    timed = replace(over, way="on") if over.way in _MISSING else over
    stands = Approach("stands", 0.0, 1.0, 1)
    probe = visit(leader, stands, street, x, side, 20.0, crosses=True, over=timed)
    to_aim_s = _reaches_s(probe, street.ego_lane_y_m + aim, side) - 20.0
    if approach.style == "straight":
        to_aim_s -= 0.5 * RAMP_S
    leaves_s = scene.meeting_s + shift - to_aim_s
    members = [(leader, x, leaves_s, side)]
    for beside, person in zip(scene.beside_m[1:], people[1:-1], strict=True):
        later_s = float(rng.uniform(-0.3, 0.3))
        members.append((replace(person, speed_mps=leader.speed_mps), x + beside, leaves_s + later_s, side))
    opposite_s = leaves_s + float(rng.uniform(-1.0, 2.0))
    if rng.random() < how.both_sides:
        members.append((people[-1], x, opposite_s, -side))
    crossing, stopping = (
        [
            visit(person, approach, street, at, where, when, crosses=crosses, over=over)
            for person, at, when, where in members
        ]
        for crosses in (True, False)
    )
    return crossing, stopping, hits


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
    scene_rng, rng, bend_rng = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(3))
    scene, how = _draw_scene(scene_rng, traffic, ego), traffic.behaviour
    crosses, hits = bool(rng.random() < traffic.crossing_share), bool(rng.random() < CONTACT_SHARE)
    from_x = 8.0 if scene.street.intersection is None else scene.meeting_x_m - 8.0
    bystanders = [
        draw_bystander(rng, scene.street, how, from_x_m=from_x, meeting_x_m=scene.meeting_x_m,
                       duration_s=traffic.duration_s)
        for _ in range(int(rng.integers(traffic.max_bystanders + 1)))
    ]  # fmt: skip
    finish_x = scene.meeting_x_m + BEYOND_CROSSING_M
    until_s = min(traffic.duration_s, (finish_x - 0.5 * ego.length_m) / scene.ego_speed_mps)
    group: list[PedestrianSpec] = []
    crossing: list[PedestrianSpec] = []
    if crosses or traffic.max_bystanders > 0:
        for attempt in range(_ATTEMPTS):  # the class takes no part in the choice of ways and times
            crossing, stopping, wanted = _group(rng, scene, ego, how, hits=hits)
            group = crossing if crosses else stopping
            already_out = any(abs(spec.y_m) < scene.street.kerb_y_m for spec in crossing)
            speed = scene.ego_speed_mps
            met = holds_speed_and_hits(crossing, scene.street, ego, ego_speed_mps=speed, until_s=until_s)
            if met == wanted and (attempt >= _PREFER_FROM_KERB or not already_out):
                break
    leading: tuple[VehicleSpec, ...] = ()
    if scene_rng.random() < how.leader:
        leading = leading_car(scene_rng, scene.street, ego, ego_speed_mps=scene.ego_speed_mps, crossing=crossing,
                              others=scene.vehicles, until_s=until_s)  # fmt: skip
    side = "far" if scene.side > 0 else "near"
    scenario = Scenario(
        name=f"{'crossing' if crosses else 'non-crossing'}/{scene.place}/{side}",
        street=scene.street,
        ego_speed_mps=scene.ego_speed_mps,
        finish_x_m=finish_x,
        duration_s=traffic.duration_s,
        pedestrians=(*group, *bystanders),
        vehicles=(*scene.vehicles, *leading),
    )
    if scene.street.intersection is None and bend_rng.random() < how.curve:
        return bent(scenario, draw_bend(bend_rng, scene.meeting_x_m))
    return scenario
