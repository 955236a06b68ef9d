"""Other drivers: they follow, stop, never reverse, and drive through nobody."""

import math
import subprocess
import sys

import numpy as np
import pytest

from pedcross_env.config import EgoConfig, LabelConfig, TrafficConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Leg, PedestrianSpec, Scenario, StreetSpec, VehicleSpec
from pedcross_env.scenario.footprints import box_to_disc_m
from pedcross_env.scenario.layout import to_street, to_world
from pedcross_env.scenario.sampler import sample_crossing
from pedcross_env.scenario.sizes import contact_radius_m
from pedcross_env.world import World

LANE_Y = StreetSpec().ego_lane_y_m


def build(scenario: Scenario) -> World:
    return World(scenario, ego=EgoConfig(), world=WorldConfig(), label=LabelConfig(), friction=0.85)


def smallest_gap_m(world: World, demand: float) -> float:
    """Between any moving car and any person until the end, and checks that no car reverses."""
    smallest, people = math.inf, world.scenario.pedestrians
    while world.outcome is Outcome.RUNNING:
        world.step(demand)
        actors = world.snapshot(world.time_s).actors
        cars = actors[(actors["kind"] == 1) & (actors["speed"] > 0.05)]
        assert (actors["speed"] >= 0).all()
        for car in cars:
            for person, spec in zip(actors[actors["kind"] == 2], people, strict=True):
                dx, dy = float(person["x"] - car["x"]), float(person["y"] - car["y"])
                gap = box_to_disc_m(
                    dx, dy, float(car["length"]), float(car["width"]), contact_radius_m(spec.height_m)
                )
                smallest = min(smallest, gap)
    return smallest


def test_no_car_drives_through_a_person() -> None:
    gaps = []
    for seed in range(25):
        scenario = sample_crossing(seed, TrafficConfig(crossing_share=1.0, max_oncoming=3), EgoConfig())
        gaps.append(smallest_gap_m(build(scenario), demand=-2.0 if seed % 2 else 0.0))
    assert min(gaps) > 0.2


def test_an_oncoming_car_stops_for_who_crosses_and_then_drives_on() -> None:
    person = PedestrianSpec(
        behaviour="crossing", x_m=40.0, y_m=6.0, legs=(Leg(to_x_m=40.0, to_y_m=-7.0, speed_mps=1.0),)
    )
    car = VehicleSpec(x_m=85.0, y_m=-LANE_Y, yaw_rad=math.pi, speed_mps=12.0)
    world = build(
        Scenario(name="s", ego_speed_mps=0.0, pedestrians=(person,), vehicles=(car,), duration_s=16.0)
    )
    xs, speeds = [], []
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
        record = world.snapshot(world.time_s).actors[0]
        xs.append(float(record["x"]))
        speeds.append(float(record["speed"]))
    assert min(speeds) < 2.0
    assert xs[-1] < 38.0
    assert speeds[-1] > 3.0


def test_a_car_behind_stops_behind_the_standing_ego() -> None:
    car = VehicleSpec(x_m=-45.0, y_m=LANE_Y, speed_mps=12.0)
    world = build(Scenario(name="s", ego_speed_mps=10.0, vehicles=(car,), duration_s=15.0))
    while world.outcome is Outcome.RUNNING:
        world.step(-9.0)
    assert world.outcome is Outcome.TIMEOUT
    record = world.snapshot(world.time_s).actors[0]
    assert float(record["x"]) + 0.5 * float(record["length"]) < world.ego.x_m - 2.25
    assert float(record["speed"]) < 0.3
    assert float(record["x"]) > -20.0


def test_a_car_outside_the_lanes_of_its_direction_is_refused() -> None:
    with pytest.raises(ConfigError, match="drives outside the lanes"):
        build(
            Scenario(name="s", vehicles=(VehicleSpec(x_m=50.0, y_m=LANE_Y, yaw_rad=math.pi, speed_mps=8.0),))
        )


def test_the_global_generator_is_untouched() -> None:
    np.random.seed(5)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # type: ignore[index]  # noqa: NPY002
    world = build(sample_crossing(3, TrafficConfig(max_oncoming=2), EgoConfig()))
    for _ in range(30):
        world.step(0.0)
    assert (np.random.get_state()[1] == before).all()  # type: ignore[index]  # noqa: NPY002


def test_importing_the_world_opens_no_display() -> None:
    code = (
        "import os, pedcross_env.world, pygame; "
        "assert 'SDL_VIDEODRIVER' not in os.environ; assert not pygame.display.get_init()"
    )
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": ":".join(sys.path)}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


@pytest.mark.parametrize("curvature", [1 / 60, -1 / 45])
def test_cars_follow_the_bend_in_their_lane_at_their_speed(curvature):
    street = StreetSpec(curvature_per_m=curvature, curve_start_x_m=20.0, curve_length_m=50.0)
    x, y, heading = (float(v) for v in to_world(street, 95.0, 1.75))
    cars = (
        VehicleSpec(x_m=10.0, y_m=-1.75, speed_mps=8.0),
        VehicleSpec(x_m=x, y_m=y, yaw_rad=heading + math.pi, speed_mps=8.0),
    )
    world = build(Scenario(name="bend", street=street, vehicles=cars, ego_speed_mps=0.0, ego_x_m=-40.0))
    before = world.snapshot(0.0).actors
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
        now = world.snapshot(world.time_s).actors
        s, d = to_street(street, now["x"], now["y"])
        np.testing.assert_allclose(d, [-1.75, 1.75], atol=1e-6)
        turned = now["yaw"] - to_world(street, s)[2] - [0.0, math.pi]
        np.testing.assert_allclose(np.sin(turned), 0.0, atol=1e-6)
        driven = np.hypot(now["x"] - before["x"], now["y"] - before["y"])
        np.testing.assert_allclose(driven * 30, 0.5 * (now["speed"] + before["speed"]), rtol=1e-3)
        before = now
    assert to_street(street, now["x"], now["y"])[0] @ [1.0, -1.0] > 50.0  # both are through
