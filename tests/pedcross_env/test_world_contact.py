"""Contact: found at its moment, whatever the clocks."""

import math

import numpy as np
import pytest

from pedcross_env.config import EgoConfig, LabelConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError, PedcrossError
from pedcross_env.scenario import Leg, PedestrianSpec, Scenario, StreetSpec, VehicleSpec
from pedcross_env.scenario.footprints import box_to_box_m
from pedcross_env.scenario.sizes import pedestrian_size, vehicle_size
from pedcross_env.world import World

STREET = StreetSpec()
LANE_Y = STREET.ego_lane_y_m


def build(scenario: Scenario, policy_hz: int = 30, tick_hz: int = 120, friction: float = 0.85) -> World:
    clock = WorldConfig(policy_hz=policy_hz, tick_hz=tick_hz)
    return World(scenario, ego=EgoConfig(), world=clock, label=LabelConfig(), friction=friction)


def play(world: World, brakes_from_s: float = math.inf) -> World:
    while world.outcome is Outcome.RUNNING:
        world.step(-9.0 if world.time_s >= brakes_from_s - 1e-9 else 0.0)
    return world


def crosser(x: float, wait_s: float, speed: float = 1.4, side: int = -1) -> PedestrianSpec:
    leg = Leg(to_x_m=x, to_y_m=-side * 8.0, speed_mps=speed, wait_s=wait_s)
    return PedestrianSpec(behaviour="crossing", x_m=x, y_m=side * 6.3, legs=(leg,))


SCENES = {
    "from the right": Scenario(name="s", pedestrians=(crosser(40.0, 0.9),)),
    "from the left, running": Scenario(name="s", pedestrians=(crosser(40.0, 0.9, 2.2, side=1),)),
    "standing car": Scenario(
        name="s", vehicles=(VehicleSpec(x_m=45.0, y_m=LANE_Y, yaw_rad=0.2, parked=True),)
    ),
    "slow car ahead": Scenario(name="s", vehicles=(VehicleSpec(x_m=20.0, y_m=LANE_Y, speed_mps=3.0),)),
}


@pytest.mark.parametrize("brakes_from_s", [math.inf, 2.6, 3.0])
@pytest.mark.parametrize("scene", SCENES)
def test_impact_depends_on_no_clock_rate(scene: str, brakes_from_s: float) -> None:
    results = []
    for policy_hz in (5, 10, 15, 30, 60):
        for tick_hz in (60, 120, 240, 480):
            world = play(build(SCENES[scene], policy_hz, tick_hz), brakes_from_s)
            results.append((world.outcome, world.contact_time_s, world.impact_speed_mps))
    outcomes, times, speeds = zip(*results, strict=True)
    assert len(set(outcomes)) == 1
    if brakes_from_s == math.inf:
        assert outcomes[0] is Outcome.COLLISION
    if outcomes[0] is Outcome.COLLISION:
        assert np.ptp(times) < 1e-3
        assert np.ptp(speeds) < 0.05


def test_contact_with_a_standing_person_is_at_the_analytic_moment() -> None:
    person = PedestrianSpec(behaviour="standing", x_m=30.0, y_m=LANE_Y, height_m=1.8)
    world = play(
        build(Scenario(name="s", ego_speed_mps=10.0, pedestrians=(person,)), policy_hz=5, tick_hz=60)
    )
    assert world.contact_time_s == pytest.approx((30.0 - 0.3 - 2.25) / 10.0, abs=1e-6)
    assert world.impact_speed_mps == pytest.approx(10.0)
    assert world.collided_with == 2


def test_braking_impact_speed_follows_from_the_distance() -> None:
    config = EgoConfig(latency_s=0.0, jerk_mps3=1e6, build_up_s=0.0)
    person = PedestrianSpec(behaviour="standing", x_m=8.0, y_m=LANE_Y, height_m=1.8)
    scenario = Scenario(name="s", ego_speed_mps=12.0, pedestrians=(person,))
    world = World(scenario, ego=config, world=WorldConfig(), label=LabelConfig(), friction=0.5)
    play(world, brakes_from_s=0.0)
    distance = 8.0 - 0.3 - 2.25
    assert world.impact_speed_mps == pytest.approx(math.sqrt(144 - 2 * 0.5 * 9.81 * distance), abs=1e-3)


def test_who_walks_into_a_standing_ego_is_no_collision() -> None:
    person = PedestrianSpec(
        behaviour="crossing", x_m=0.5, y_m=-6.0, legs=(Leg(to_x_m=0.5, to_y_m=6.0, speed_mps=2.0),)
    )
    world = build(Scenario(name="s", ego_speed_mps=0.0, pedestrians=(person,), duration_s=4.0))
    assert play(world).outcome is Outcome.TIMEOUT


def test_driving_off_with_a_person_at_the_bumper_is_a_collision() -> None:
    person = PedestrianSpec(
        behaviour="crossing", x_m=2.3, y_m=-6.0, legs=(Leg(to_x_m=2.3, to_y_m=LANE_Y, speed_mps=2.0),)
    )
    world = build(Scenario(name="s", ego_speed_mps=0.0, pedestrians=(person,), duration_s=6.0))
    while world.outcome is Outcome.RUNNING:
        world.step(3.0 if world.time_s > 4.0 else 0.0)
    assert world.outcome is Outcome.COLLISION
    assert world.impact_speed_mps == pytest.approx(0.1, abs=1e-3)


def test_stepping_after_the_end_is_an_error() -> None:
    world = play(build(SCENES["from the right"]))
    with pytest.raises(PedcrossError, match="ended \\(collision\\)"):
        world.step(0.0)


def test_a_demand_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ConfigError, match="demand_mps2 = nan"):
        build(SCENES["standing car"]).step(math.nan)


def test_poses_stay_as_they_were_at_contact() -> None:
    world = play(build(SCENES["from the right"], policy_hz=5))
    end, contact = world.snapshot(world.time_s), world.snapshot(world.contact_time_s)
    assert end.ego.tobytes() == contact.ego.tobytes()
    assert end.actors.tobytes() == contact.actors.tobytes()
    person, ego = end.actors[0], end.ego
    gap = box_to_box_m(
        float(person["x"] - ego["x"]), float(person["y"] - ego["y"]), (4.5, 1.8), pedestrian_size(1.75)[:2],
        float(person["yaw"]),
    )  # fmt: skip
    assert abs(gap) < 1e-6


def test_an_ego_that_passes_has_passed() -> None:
    world = play(build(Scenario(name="s", ego_speed_mps=10.0, finish_x_m=50.0)))
    assert world.outcome is Outcome.PASSED
    assert world.time_s == pytest.approx((50.0 - 2.25) / 10.0, abs=1 / 30)


def test_box_separation_agrees_with_dense_sampling() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        dx, dy, yaw = rng.uniform(-5, 5), rng.uniform(-4, 4), rng.uniform(-4, 4)
        length, width = vehicle_size("suv")[:2]
        u, v = np.meshgrid(np.linspace(-0.5, 0.5, 60) * length, np.linspace(-0.5, 0.5, 60) * width)
        px = dx + u * math.cos(yaw) - v * math.sin(yaw)
        py = dy + u * math.sin(yaw) + v * math.cos(yaw)
        outside = np.hypot(np.maximum(abs(px) - 2.25, 0), np.maximum(abs(py) - 0.9, 0)).min()
        gap = box_to_box_m(dx, dy, (4.5, 1.8), (length, width), yaw)
        assert gap <= outside + 1e-9
        if gap > 0.05:
            assert outside > 0
        if gap < -0.1:
            assert outside == 0
