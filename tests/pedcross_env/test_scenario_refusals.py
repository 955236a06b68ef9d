"""Scenarios that cannot be are refused with the value, the rule and what would do."""

import dataclasses
import math

import pytest

from pedcross_env.config import EgoConfig, WorldConfig
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import (
    Intersection,
    Leg,
    Maneuver,
    PedestrianSpec,
    Scenario,
    StreetSpec,
    Trigger,
    VehicleSpec,
)
from pedcross_env.world.lanes import route_of

CROSSED = StreetSpec(intersection=Intersection(x_m=60.0))


def person(x: float, y: float, *ways: tuple[float, float]) -> PedestrianSpec:
    legs = tuple(Leg(to_x_m=a, to_y_m=b, speed_mps=1.4) for a, b in ways)
    return PedestrianSpec(behaviour="crossing", x_m=x, y_m=y, legs=legs)


@pytest.mark.parametrize(
    ("walker", "place"),
    [
        (person(30.0, 9.5), r"\(30.0, 9.5\)"),
        (person(30.0, 6.0, (30.0, -12.0)), r"\(30.0, -12.0\)"),
    ],
)
def test_nobody_stands_in_or_walks_into_a_house(walker: PedestrianSpec, place: str) -> None:
    with pytest.raises(ConfigError, match=place):
        Scenario(name="s", pedestrians=(walker,))


def test_an_intersection_opens_the_fronts_and_its_corners_stay() -> None:
    Scenario(name="s", street=CROSSED, pedestrians=(person(60.0, 20.0, (60.0, -30.0)),))
    with pytest.raises(ConfigError, match="house fronts"):  # straight across the corner house
        Scenario(name="s", street=CROSSED, pedestrians=(person(30.0, 8.0, (57.0, 40.0)),))


def test_nobody_walks_through_a_parked_car() -> None:
    car = VehicleSpec(x_m=30.0, y_m=-4.6, parked=True)
    with pytest.raises(ConfigError, match=r"vehicles\[0\] \(hatchback.*e.g. cross at x_m = 32.5"):
        Scenario(name="s", vehicles=(car,), pedestrians=(person(30.0, -6.5, (30.0, 6.0)),))
    Scenario(name="s", vehicles=(car,), pedestrians=(person(32.6, -6.5, (32.6, 6.0)),))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Leg(to_x_m=0.0, to_y_m=0.0, speed_mps=-1.0), r"speed_mps = -1.0 .*above 0"),
        (lambda: Leg(to_x_m=0.0, to_y_m=0.0, speed_mps=1.0, wait_s=-0.1), "wait_s = -0.1"),
        (lambda: Leg(to_x_m=0.0, to_y_m=0.0, speed_mps=1.0, run_up_m=0.0), "run_up_m = 0.0"),
        (lambda: VehicleSpec(x_m=0.0, y_m=0.0, speed_mps=-3.0), "speed_mps = -3.0"),
        (lambda: Scenario(name="s", ego_speed_mps=-5.0), "ego_speed_mps = -5.0"),
        (lambda: Scenario(name="s", duration_s=math.inf), "duration_s = inf"),
        (lambda: Scenario(name="s", finish_x_m=-1.0), "finish_x_m = -1.0"),
        (
            lambda: WorldConfig(policy_hz=50, tick_hz=120),
            r"tick_hz = 120 .*multiple of policy_hz \(50\), at most 10000, e.g. 200",
        ),
        (lambda: EgoConfig(build_up_s=-1.0), "build_up_s = -1.0"),
        (lambda: EgoConfig(jerk_mps3=math.inf), "jerk_mps3 = inf"),
        (lambda: EgoConfig(wheelbase_m=6.0), "wheelbase_m = 6.0"),
    ],
)
def test_impossible_values_are_named(make, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        make()


@pytest.mark.parametrize("turn", ["left", "straight"])
def test_who_does_not_drive_along_the_street_goes_over_to_no_line_of_it(turn: str) -> None:
    to_line = Maneuver(when=Trigger(time_s=0.0), to_y_m=0.0)
    car = VehicleSpec(x_m=0.0, y_m=-1.75, speed_mps=10.0, turn=turn, maneuvers=(to_line,))
    with pytest.raises(ConfigError, match=rf"to_y_m = 0 .*turn = '{turn}'.*leave to_y_m out"):
        route_of(car, CROSSED)
    along = dataclasses.replace(car, turn="")
    assert math.isfinite(route_of(along, CROSSED)[2])
