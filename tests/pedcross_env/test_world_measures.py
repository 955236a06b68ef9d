"""Measures per step on cases whose answer is plain: PET, DRAC, distance."""

import math

import pytest

from pedcross_env.config import EgoConfig, LabelConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.scenario import Leg, PedestrianSpec, Scenario, StreetSpec, VehicleSpec
from pedcross_env.world import World
from pedcross_env.world.world import MOST_DRAC_MPS2

LANE_Y = StreetSpec().ego_lane_y_m
HALF_WAY = 0.9 + 0.3  # half the ego's width, half the length of who crosses
EGO = EgoConfig()


def build(*people: PedestrianSpec, speed: float = 10.0, margin: float = 0.0, **scenario: object) -> World:
    return World(
        Scenario(name="s", ego_speed_mps=speed, pedestrians=people, **scenario), ego=EGO, world=WorldConfig(),
        label=LabelConfig(conflict_margin_m=margin), friction=0.85,
    )  # fmt: skip


def crosser(x_m: float, at_lane_s: float, speed: float = 2.0) -> PedestrianSpec:
    """Walks at even speed from the right and is at the middle of the ego's lane at ``at_lane_s``."""
    y = LANE_Y - speed * at_lane_s
    leg = Leg(to_x_m=x_m, to_y_m=8.0, speed_mps=speed)
    return PedestrianSpec(
        behaviour="crossing", x_m=x_m, y_m=y, yaw_rad=math.pi / 2, height_m=1.8, legs=(leg,)
    )


def smallest_pet(world: World) -> float:
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
    return world.facts()["pet_s"]


@pytest.mark.parametrize("gap_s", [0.2, 0.7, 1.5])
def test_pet_is_the_time_between_the_pedestrian_leaving_and_the_ego_coming(gap_s: float) -> None:
    leaves_s = 1.5 + HALF_WAY / 2.0
    x = 10.0 * (leaves_s + gap_s) + 2.25 + 0.25  # the ego's front then reaches the pedestrian's near side
    assert smallest_pet(build(crosser(x, 1.5))) == pytest.approx(gap_s, abs=1e-3)


@pytest.mark.parametrize("gap_s", [0.1, 0.8])
def test_pet_is_the_time_between_the_ego_leaving_and_the_pedestrian_coming(gap_s: float) -> None:
    comes_s = 3.0 - HALF_WAY / 2.0
    x = 10.0 * (comes_s - gap_s) - 2.25 - 0.25
    assert smallest_pet(build(crosser(x, 3.0))) == pytest.approx(gap_s, abs=1e-3)


def test_pet_is_unknown_before_both_have_come_and_zero_at_a_collision() -> None:
    world = build(crosser(30.0, 2.8))
    assert world.facts()["pet_s"] == math.inf
    while world.outcome is Outcome.RUNNING:
        assert world.facts()["pet_s"] == math.inf
        world.step(0.0)
    assert world.outcome is Outcome.COLLISION
    assert world.facts()["pet_s"] == 0.0


def test_drac_just_stops_the_ego_before_who_stands_in_its_lane() -> None:
    person = PedestrianSpec(behaviour="standing", x_m=40.0, y_m=LANE_Y, height_m=1.8)
    world = build(person)
    gap = 40.0 - 0.3 - 2.25
    assert world.facts()["drac_mps2"] == pytest.approx(100.0 / (2 * gap), rel=1e-4)
    # an actuator without delay that brakes by just that stops at the person
    ideal = EgoConfig(latency_s=0.0, jerk_mps3=1e6, build_up_s=0.0)
    for factor, outcome in ((1.01, Outcome.TIMEOUT), (0.99, Outcome.COLLISION)):
        twin = World(world.scenario, ego=ideal, world=WorldConfig(), label=LabelConfig(), friction=0.85)
        demand = -factor * world.facts()["drac_mps2"]
        while twin.outcome is Outcome.RUNNING:
            twin.step(demand)
        assert twin.outcome is outcome


def test_drac_of_a_slower_car_is_that_of_the_closing_speed() -> None:
    car = VehicleSpec(x_m=30.0, y_m=LANE_Y, speed_mps=4.0, model="sedan")
    facts = build(vehicles=(car,)).facts()
    gap = 30.0 - 2.35 - 2.25
    assert facts["ttc_s"] == math.inf  # 4.2 s: beyond the horizon
    assert facts["drac_mps2"] == 0.0
    facts = build(vehicles=(car,), speed=12.0).facts()
    assert facts["ttc_s"] == pytest.approx(gap / 8.0)
    assert facts["drac_mps2"] == pytest.approx(64.0 / (2 * gap))


def test_drac_stays_finite_at_contact_and_is_zero_without_conflict() -> None:
    assert build().facts()["drac_mps2"] == 0.0
    touching = PedestrianSpec(behaviour="standing", x_m=2.6, y_m=LANE_Y)
    assert build(touching, margin=0.3).facts()["drac_mps2"] == MOST_DRAC_MPS2
