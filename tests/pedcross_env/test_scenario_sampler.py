"""Random crossings: the shares that are promised, and classes that only the crossing tells apart."""

import dataclasses
import hashlib
import itertools
import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pedcross_env.config import BehaviourConfig, EgoConfig, LabelConfig, TrafficConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.scenario import Scenario
from pedcross_env.scenario.layout import carriageway_m, facade_m
from pedcross_env.scenario.sampler import sample_crossing
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.walk import Walk
from pedcross_env.world import World

EGO, TRAFFIC = EgoConfig(), TrafficConfig()
CROSSING, STOPPING = TrafficConfig(crossing_share=1.0), TrafficConfig(crossing_share=0.0)


def build(scenario: Scenario) -> World:
    return World(scenario, ego=EGO, world=WorldConfig(), label=LabelConfig(), friction=0.85)


def play(scenario: Scenario) -> tuple[World, int]:
    """(world at its end, positive frames) without braking."""
    world, positive = build(scenario), 0
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
        positive += world.facts()["crossing"]
    return world, positive


def trajectory_digest(seed: int) -> str:
    world, digest = build(sample_crossing(seed, TRAFFIC, EGO)), hashlib.sha256()
    for _ in range(45):
        world.step(-1.0)
        digest.update(world.snapshot(world.time_s).actors.tobytes())
    return digest.hexdigest()


def test_the_same_seed_gives_the_same_scenario_and_trajectory() -> None:
    assert sample_crossing(11, TRAFFIC, EGO) == sample_crossing(11, TRAFFIC, EGO)
    assert sample_crossing(11, TRAFFIC, EGO) != sample_crossing(12, TRAFFIC, EGO)
    code = f"from test_scenario_sampler import trajectory_digest; print(trajectory_digest({11}))"
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": ":".join([*sys.path, __file__.rpartition("/")[0]])}
    other = subprocess.run(
        [sys.executable, "-c", code], check=True, env=environment, capture_output=True, text=True
    )
    assert other.stdout.strip() == trajectory_digest(11)


def test_three_quarters_of_crossings_hit_who_never_brakes() -> None:
    hits = [play(sample_crossing(seed, CROSSING, EGO))[0].outcome is Outcome.COLLISION for seed in range(100)]
    assert 0.62 <= np.mean(hits) <= 0.87


def test_every_crossing_has_positive_frames() -> None:
    for seed in range(20):
        assert play(sample_crossing(seed, CROSSING, EGO))[1] > 5


def test_without_crossing_nobody_is_labelled_or_hit() -> None:
    for seed in range(40):
        world, positive = play(sample_crossing(seed, STOPPING, EGO))
        assert positive == 0
        assert world.outcome is Outcome.PASSED


def test_the_classes_differ_in_the_crossing_alone() -> None:
    for seed in range(30):
        crossing, stopping = sample_crossing(seed, CROSSING, EGO), sample_crossing(seed, STOPPING, EGO)
        assert crossing.street == stopping.street
        assert crossing.vehicles == stopping.vehicles
        assert crossing.ego_speed_mps == stopping.ego_speed_mps
        kerb = crossing.street.kerb_y_m
        for one, other in zip(crossing.pedestrians, stopping.pedestrians, strict=True):
            assert (one.model, one.height_m, one.seed) == (other.model, other.height_m, other.seed)
            times = np.arange(0.0, 10.0, 0.1)
            a, b = Walk(one).positions(times), Walk(other).positions(times)
            outside = np.abs(a[:, 1]) > kerb + 0.7  # who stops has begun to slow down nearer than that
            before_kerb = np.cumprod(outside).astype(bool)
            np.testing.assert_allclose(a[before_kerb], b[before_kerb], atol=1e-6)


def test_shares_of_place_and_side() -> None:
    names = [sample_crossing(seed, TRAFFIC, EGO).name.split("/") for seed in range(400)]
    assert 0.43 < np.mean([n[0] == "crossing" for n in names]) < 0.57
    assert 0.53 < np.mean([n[1] == "zebra" for n in names]) < 0.67
    assert {n[1] for n in names} == {"zebra", "between-cars", "behind-car", "open"}
    assert 0.43 < np.mean([n[2] == "near" for n in names]) < 0.57


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_nobody_crosses_through_a_parked_car_and_zebras_stay_clear(share: float) -> None:
    between = 0
    for seed in range(60):
        scenario = sample_crossing(seed, TrafficConfig(crossing_share=1.0, parked_share=share), EGO)
        parked = [car for car in scenario.vehicles if car.parked]
        edges = [
            (c.x_m - vehicle_size(c.model).length_m / 2, c.x_m + vehicle_size(c.model).length_m / 2, c.y_m)
            for c in parked
        ]
        for zebra in scenario.street.crosswalks:
            reach = zebra.width_m / 2 + 5.0
            assert all(high <= zebra.x_m - reach or low >= zebra.x_m + reach for low, high, _ in edges)
        for person in scenario.pedestrians:
            if person.behaviour == "crossing":
                x = person.legs[-1].to_x_m
                assert all(high <= x - 0.59 or low >= x + 0.59 for low, high, _ in edges)
                beside = [
                    1
                    for low, high, y in edges
                    if y * person.y_m > 0 and min(abs(high - x), abs(low - x)) < 1.8
                ]
                between += len(beside) >= 2
        for side in (-1, 1):
            spans = sorted((low, high) for low, high, y in edges if y * side > 0)
            assert all(a[1] < b[0] for a, b in itertools.pairwise(spans))
    assert between > 10


def test_one_to_five_people_cross() -> None:
    counts = [
        sum(p.behaviour == "crossing" for p in sample_crossing(seed, CROSSING, EGO).pedestrians)
        for seed in range(80)
    ]
    assert set(counts) <= {1, 2, 3, 4, 5}
    assert 0.5 < np.mean([count == 1 for count in counts]) < 0.85


def sampled(**shares: float) -> list[Scenario]:
    """Thirty crossings with all of the behaviours asked for and no others."""
    off = {
        "hesitates": 0.0,
        "stops_midway": 0.0,
        "turns_back": 0.0,
        "both_sides": 0.0,
        "door": 0.0,
        "cyclist": 0.0,
    }
    traffic = TrafficConfig(crossing_share=1.0, behaviour=BehaviourConfig(**{**off, **shares}))
    return [sample_crossing(seed, traffic, EGO) for seed in range(30)]


def crossers(scenario: Scenario) -> list[Walk]:
    return [Walk(p) for p in scenario.pedestrians if p.behaviour == "crossing"]


def test_who_hesitates_or_stops_midway_stands_on_the_carriageway_and_then_goes_over() -> None:
    for share, longest_s in (("hesitates", 1.6), ("stops_midway", 2.6)):
        for scenario in sampled(**{share: 1.0}):
            kerb = scenario.street.kerb_y_m
            for walk in crossers(scenario):
                times = np.arange(0.0, walk.end_s, 0.05)
                xy = walk.positions(times)
                steps = np.hypot(*np.diff(xy, axis=0).T)
                stands = (steps < 1e-9) & (np.abs(xy[1:, 1]) < kerb)
                assert 0.2 < 0.05 * stands.sum() < longest_s
                assert abs(xy[-1, 1]) > kerb
                assert np.sign(xy[-1, 1]) == -np.sign(xy[0, 1])


def test_who_turns_back_comes_to_the_ego_s_lane_at_most_and_is_not_hit() -> None:
    for scenario in sampled(turns_back=1.0, both_sides=0.0):
        assert play(scenario)[0].outcome is Outcome.PASSED
        for walk in crossers(scenario):
            y = walk.positions(np.arange(0.0, walk.end_s + 1.0, 0.05))[:, 1]
            assert np.sign(y[-1]) == np.sign(y[0])
            assert abs(y[-1]) > scenario.street.kerb_y_m
            assert np.abs(y).min() < scenario.street.kerb_y_m - 0.7


def test_who_yields_lets_an_ego_pass_that_does_not_slow_down_in_time() -> None:
    for scenario in sampled(yields=1.0):
        assert all(any(leg.go for leg in walk.spec.legs) for walk in crossers(scenario))
        assert play(scenario)[0].outcome is Outcome.PASSED


def test_who_yields_midway_waits_beside_the_ego_s_lane_and_goes_on_once_the_ego_has_stopped() -> None:
    waited = 0
    for scenario in sampled(yields_midway=1.0):
        assert play(scenario)[0].outcome is Outcome.PASSED
        street, world = scenario.street, build(scenario)
        lane, half = street.ego_lane_y_m, 0.5 * street.lane_width_m
        names = [p.behaviour for p in scenario.pedestrians]
        who = len(scenario.vehicles) + names.index("crossing")
        states = []
        while world.outcome is Outcome.RUNNING:
            world.step(-9.0)
            person = world.snapshot(world.time_s).actors[who]
            inside = street.kerb_y_m - abs(float(person["y"]))
            if person["speed"] < 1e-9 and inside > 0.2:
                states.append(abs(float(person["y"]) - lane) - half)
        crossed = np.sign(person["y"]) != np.sign(scenario.pedestrians[who - len(scenario.vehicles)].y_m)
        assert all(beside == pytest.approx(0.15) for beside in states)  # it never stands in the lane
        waited += bool(states) and bool(crossed)
    assert waited > 3


def test_a_bend_moves_nobody_in_time() -> None:
    curved = dataclasses.replace(CROSSING, behaviour=BehaviourConfig(curve=1.0))
    bends, hits = [], 0
    for seed in range(40):
        straight, bent = sample_crossing(seed, CROSSING, EGO), sample_crossing(seed, curved, EGO)
        assert bent.name == straight.name
        bends.append(bent.street.curvature_per_m)
        one, other = play(straight)[0], play(bent)[0]
        assert one.outcome is other.outcome
        if one.outcome is Outcome.COLLISION:
            hits += 1
            assert other.contact_time_s == pytest.approx(one.contact_time_s, abs=0.01)
            assert other.impact_speed_mps == pytest.approx(one.impact_speed_mps)
        for a, b in zip(straight.pedestrians, bent.pedestrians, strict=True):
            assert Walk(b).end_s == pytest.approx(Walk(a).end_s, abs=0.02)
    assert hits > 15
    assert min(bends) < -1 / 300 < 1 / 300 < max(bends)
    assert all(1 / 300 <= abs(bend) <= 1 / 100 for bend in bends)


def test_nobody_walks_off_the_sidewalk_in_a_bend() -> None:
    curved = dataclasses.replace(STOPPING, behaviour=BehaviourConfig(curve=1.0))
    for seed in range(40):
        room = []
        for scenario in (sample_crossing(seed, traffic, EGO) for traffic in (STOPPING, curved)):
            walks = [Walk(person) for person in scenario.pedestrians]
            ways = [walk.positions(np.arange(0.0, walk.end_s + 0.1, 0.1)).T for walk in walks]
            assert all(carriageway_m(scenario.street, *way).max() < 0.0 for way in ways)
            room.append([float(facade_m(scenario.street, *way).min()) for way in ways])
        np.testing.assert_allclose(*room, atol=0.03)  # a chord of 3 m leaves an arc of 100 m by 1 cm


def test_hard_negatives_leave_the_way_of_who_holds_its_speed_free() -> None:
    shares = {"cyclist": 1.0, "door": 1.0, "intersection": 1.0, "leader": 1.0}
    found: set[str] = set()
    for seed in range(40):
        traffic = TrafficConfig(crossing_share=0.0, behaviour=BehaviourConfig(**shares))
        scenario = sample_crossing(seed, traffic, EGO)
        vehicles = scenario.vehicles
        found |= (
            {"door" for v in vehicles if v.door} | {v.model for v in vehicles} | {v.turn for v in vehicles}
        )
        found |= {"leader" for v in vehicles if not v.yields}
        world, positive = play(scenario)
        assert world.outcome is Outcome.PASSED
        assert positive == 0
    assert {"door", "cyclist", "left", "right", "leader"} <= found


def test_a_leader_is_past_the_meeting_point_before_somebody_is_hit_there() -> None:
    hits = [play(scenario)[0] for scenario in sampled(leader=1.0)]
    struck = [world for world in hits if world.outcome is Outcome.COLLISION]
    assert len(struck) > 10
    for world in struck:
        record = world.snapshot(world.time_s).actors
        assert record["kind"][record["id"] == world.collided_with] == 2


def test_children_are_small() -> None:
    for seed in range(60):
        for person in sample_crossing(seed, TRAFFIC, EGO).pedestrians:
            assert (person.height_m <= 1.4) == (person.model == "child")


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), demand=st.sampled_from([-9.0, -2.0, 0.0, 3.0]))
def test_any_seed_plays_to_an_outcome_without_nan(seed: int, demand: float) -> None:
    scenario = sample_crossing(seed, TRAFFIC, EGO)
    world = build(scenario)
    while world.outcome is Outcome.RUNNING:
        world.step(demand if world.time_s > 1 else 0.0)
        shot, facts = world.snapshot(world.time_s), world.facts()
        for field in ("x", "y", "z", "yaw", "pitch", "speed", "gait_phase", "gait_stride", "head_yaw"):
            assert np.isfinite(shot.actors[field]).all()
        assert not any(math.isnan(facts[k]) for k in ("ttc_s", "distance_m", "speed_mps", "position_m"))
        assert facts["crossing"] == int(len(world.crossing_ids()) > 0)
    assert world.time_s <= scenario.duration_s + 1e-9


def test_odd_settings_still_give_scenarios() -> None:
    for changes in (
        {"duration_s": 1.0},
        {"max_bystanders": 0},
        {"ego_speed_mps": (30.0, 40.0)},
        {"parked_share": 0.0},
    ):
        traffic = dataclasses.replace(TRAFFIC, **changes)
        for seed in range(5):
            assert play(sample_crossing(seed, traffic, EGO))[0].outcome is not Outcome.RUNNING
