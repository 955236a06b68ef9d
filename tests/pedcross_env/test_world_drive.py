"""The ego on its way: bends, turns and the steering wheel, against elementary kinematics."""

import itertools
import math

import numpy as np
import pytest

from pedcross_env.config import EgoConfig, LabelConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Intersection, PedestrianSpec, Scenario, StreetSpec, VehicleSpec
from pedcross_env.scenario.layout import to_street
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.world import World

BEND = StreetSpec(curvature_per_m=1 / 60, curve_start_x_m=30.0, curve_length_m=80.0)
CROSSED = StreetSpec(intersection=Intersection(x_m=60.0), parking_width_m=0.0)


def build(scenario: Scenario, policy_hz: int = 30, friction: float = 0.85, **ego: object) -> World:
    return World(
        scenario, ego=EgoConfig(**ego), world=WorldConfig(policy_hz=policy_hz, tick_hz=4 * policy_hz),
        label=LabelConfig(), friction=friction,
    )  # fmt: skip


def poses(world: World, steer=lambda time_s: 0.0) -> np.ndarray:
    """(N, 4) x, y, yaw, speed at the ends of all steps."""
    rows = []
    while world.outcome is Outcome.RUNNING:
        ego = world.snapshot(world.time_s).ego
        rows.append([float(ego[name]) for name in ("x", "y", "yaw", "speed")])
        world.step(0.0, steer(world.time_s))
    return np.array(rows)


def test_on_a_bend_the_ego_keeps_its_distance_from_the_centre_line() -> None:
    way = poses(build(Scenario(name="s", street=BEND, ego_speed_mps=12.0)))
    s, d = to_street(BEND, way[:, 0], way[:, 1])
    np.testing.assert_allclose(d, BEND.ego_lane_y_m, atol=1e-9)
    assert way[-1, 2] == pytest.approx((s[-1] - 30.0) / 60.0)
    np.testing.assert_allclose(np.hypot(*np.diff(way[:, :2], axis=0).T), 12.0 / 30, rtol=1e-4)


@pytest.mark.parametrize(("turn", "heading"), [("left", 0.5 * math.pi), ("right", -0.5 * math.pi)])
def test_a_turn_ends_in_the_side_street(turn: str, heading: float) -> None:
    scenario = Scenario(
        name="s", street=CROSSED, ego_turn=turn, ego_speed_mps=6.0, ego_x_m=20.0, duration_s=20.0
    )
    world = build(scenario)
    way = poses(world)
    assert world.outcome is Outcome.PASSED
    assert way[-1, 2] == pytest.approx(heading)
    assert way[-1, 0] == pytest.approx(60.0 + math.copysign(1.625, heading))
    assert world.front_m == pytest.approx(100.0, abs=6 / 30)


def test_a_person_beyond_the_corner_is_a_conflict_of_who_turns_and_of_nobody_else() -> None:
    person = PedestrianSpec(behaviour="standing", x_m=60.0 - 1.625, y_m=-14.0, yaw_rad=math.pi / 2)
    for turn, hit in (("right", True), ("straight", False)):
        scenario = Scenario(
            name="s", street=CROSSED, ego_turn=turn, ego_speed_mps=5.0, ego_x_m=45.0, finish_x_m=90.0,
            duration_s=15.0, pedestrians=(person,),
        )  # fmt: skip
        world = build(scenario)
        ttc = []
        while world.outcome is Outcome.RUNNING:
            facts = world.facts()
            if 0.0 < facts["ttc_s"] < math.inf:
                ttc.append(facts["ttc_s"] + world.time_s)
            assert facts["conflict"] is (hit and facts["ttc_s"] <= 4.0)
            world.step(0.0)
        assert (world.outcome is Outcome.COLLISION) is hit
        if hit:  # said all along, but for the margin of 0.3 m at 5 m/s
            assert ttc == pytest.approx([world.contact_time_s - 0.06] * len(ttc), abs=5e-3)
            assert len(ttc) > 60


def test_full_lock_drives_the_bicycles_circle_and_nothing_faster_than_friction_allows() -> None:
    street = StreetSpec(lanes_per_direction=3, lane_width_m=5.0, parking_width_m=4.0)
    scenario = Scenario(name="s", street=street, ego_speed_mps=3.0, duration_s=8.0)
    config = EgoConfig(steering=True)
    way = poses(build(scenario, steering=True), steer=lambda t: 0.5)
    settled = way[60:]
    rate = np.diff(np.unwrap(settled[:, 2])) * 30
    np.testing.assert_allclose(
        rate, 3.0 * math.tan(0.5 * config.max_steer_rad) / config.wheelbase_m, rtol=1e-6
    )
    fast = Scenario(name="s", street=street, ego_speed_mps=20.0, duration_s=8.0)
    way = poses(build(fast, steering=True, friction=0.3), steer=lambda t: 1.0)
    assert np.max(20.0 * np.diff(np.unwrap(way[:, 2])) * 30) == pytest.approx(0.3 * 9.81, rel=1e-6)


def test_steering_depends_on_no_policy_rate() -> None:
    street = StreetSpec(lanes_per_direction=3, lane_width_m=5.0, parking_width_m=4.0)
    ends = []
    for policy_hz in (5, 10, 30, 60):
        scenario = Scenario(name="s", street=street, ego_speed_mps=8.0, duration_s=3.0)
        world = build(scenario, policy_hz, steering=True)
        while world.outcome is Outcome.RUNNING:
            world.step(
                -2.0 if world.time_s >= 1.0 - 1e-9 else 0.0, 0.4 if world.time_s < 1.0 - 1e-9 else -0.4
            )
        ego = world.snapshot(world.time_s).ego
        ends.append((float(ego["x"]), float(ego["y"]), float(ego["yaw"])))
    for a, b in itertools.pairwise(ends):
        assert a == pytest.approx(b, abs=1e-3)


def test_who_steers_off_the_carriageway_has_ended_the_episode() -> None:
    world = build(Scenario(name="s", ego_speed_mps=10.0), steering=True)
    way = poses(world, steer=lambda t: -0.3)
    assert world.outcome is Outcome.OFF_ROAD
    assert abs(way[-1, 1]) < StreetSpec().kerb_y_m


def test_steering_round_an_obstacle_avoids_it() -> None:
    car = VehicleSpec(x_m=45.0, y_m=StreetSpec().ego_lane_y_m, parked=True)
    scenario = Scenario(name="s", ego_speed_mps=10.0, vehicles=(car,), finish_x_m=70.0)
    assert poses(world := build(scenario)).size > 0
    assert world.outcome is Outcome.COLLISION

    def swerve(time_s: float) -> float:
        return 0.08 if time_s < 1.0 else (-0.08 if time_s < 2.0 else 0.0)

    poses(world := build(scenario, steering=True), swerve)
    assert world.outcome is Outcome.PASSED


@pytest.mark.parametrize("policy_hz", [5, 30])
def test_a_corner_that_swings_out_touches_first(policy_hz: int) -> None:
    """Found where a dense sampling of the turning box's outline first lies in the parked car."""
    size = vehicle_size("sedan")
    car = VehicleSpec(x_m=57.0, y_m=-8.0, yaw_rad=0.4, parked=True, model="sedan")
    scenario = Scenario(
        name="s", street=CROSSED, ego_turn="right", ego_speed_mps=6.0, ego_x_m=35.0, vehicles=(car,),
    )  # fmt: skip
    world = build(scenario, policy_hz)
    poses(world)
    assert world.outcome is Outcome.COLLISION
    drive, edge = world._drive, np.linspace(-0.5, 0.5, 400)
    outline = np.concatenate(
        [np.stack([edge, np.full(400, e)], 1) for e in (-0.5, 0.5)]
        + [np.stack([np.full(400, e), edge], 1) for e in (-0.5, 0.5)]
    )

    def depth(time_s: float) -> float:
        x, y, yaw = drive.plan.pose(35.0 + 6.0 * time_s)
        along, across = (outline * [4.5, 1.8]).T
        px, py = (
            x + along * math.cos(yaw) - across * math.sin(yaw),
            y + along * math.sin(yaw) + across * math.cos(yaw),
        )
        u = (px - 57.0) * math.cos(0.4) + (py + 8.0) * math.sin(0.4)
        v = (py + 8.0) * math.cos(0.4) - (px - 57.0) * math.sin(0.4)
        return float(np.min(np.maximum(np.abs(u) - 0.5 * size.length_m, np.abs(v) - 0.5 * size.width_m)))

    assert depth(world.contact_time_s - 0.005) > 0
    assert depth(world.contact_time_s + 0.005) < 0.002


def test_a_turn_needs_an_intersection() -> None:
    with pytest.raises(ConfigError, match=r"Intersection\(x_m=60.0\)"):
        Scenario(name="s", ego_turn="left")
    with pytest.raises(ConfigError, match="'right'"):
        Scenario(name="s", street=CROSSED, ego_turn="rigth")
