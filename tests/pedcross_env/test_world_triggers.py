"""Things that wait for the ego: people who step out, people who let it pass, drivers who swing out, doors."""

import math

import pytest

from pedcross_env.config import EgoConfig, LabelConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Leg, Maneuver, PedestrianSpec, Scenario, StreetSpec, Trigger, VehicleSpec
from pedcross_env.scenario.street import Intersection
from pedcross_env.world import World

EGO, STREET = EgoConfig(), StreetSpec()
LANE_Y = STREET.ego_lane_y_m


def build(policy_hz=30, **scenario):
    clock = WorldConfig(policy_hz=policy_hz, tick_hz=4 * policy_hz)
    return World(Scenario(name="s", **scenario), ego=EGO, world=clock, label=LabelConfig(), friction=0.85)


def waiting_for(go, *, x=60.0, legs=(), wait_s=0.0):
    """Somebody at the kerb who crosses once ``go`` fires."""
    cross = Leg(to_x_m=x, to_y_m=6.5, speed_mps=1.5, wait_s=wait_s, go=go)
    return PedestrianSpec(behaviour="crossing", x_m=x, y_m=-6.4, legs=(*legs, cross))


def starts_moving(world, demand=0.0, actor=-1):
    """(time, ego front, ego speed) when an actor is first seen moving."""
    while world.outcome is Outcome.RUNNING:
        world.step(demand)
        if world.snapshot(world.time_s).actors[actor]["speed"] > 0:
            return world.time_s, world.ego.front_m, world.ego.speed_mps
    return math.inf, math.nan, math.nan


@pytest.mark.parametrize(
    ("trigger", "expected_s"),
    [
        (Trigger(time_s=1.5), 1.5),
        (Trigger(distance_m=20.0), (40.0 - 0.5 * EGO.length_m) / 10.0),
        (Trigger(ttc_s=3.0), (30.0 - 0.5 * EGO.length_m) / 10.0),
        (Trigger(ttc_s=3.0, delay_s=0.5), (30.0 - 0.5 * EGO.length_m) / 10.0 + 0.5),
        (Trigger(time_s=1.0, distance_m=20.0), (40.0 - 0.5 * EGO.length_m) / 10.0),
    ],
)
def test_a_trigger_fires_where_its_conditions_say(trigger, expected_s):
    world = build(pedestrians=(waiting_for(trigger),), ego_speed_mps=10.0)
    assert starts_moving(world)[0] == pytest.approx(expected_s, abs=1 / 30 + 1e-3)


def test_the_moment_does_not_depend_on_the_policys_rate():
    places = []
    for policy_hz in (5, 30, 100):
        world = build(policy_hz, pedestrians=(waiting_for(Trigger(ttc_s=2.5)),), ego_speed_mps=9.3)
        while world.time_s < 6.0 - 1e-9 and world.outcome is Outcome.RUNNING:
            world.step(0.0)
        places.append((float(world.snapshot(world.time_s).actors[0]["y"]), world.contact_time_s))
    assert places[0] == pytest.approx(places[1], abs=1e-3, nan_ok=True)
    assert places[2] == pytest.approx(places[1], abs=1e-3, nan_ok=True)


def test_who_waits_for_a_gap_lets_the_ego_pass_and_crosses_before_one_that_stops():
    person = waiting_for(Trigger(gap_s=7.0))
    driving, standing = build(pedestrians=(person,)), build(pedestrians=(person,), ego_speed_mps=0.0)
    _, front, _ = starts_moving(driving)
    assert front - EGO.length_m > 59.0  # its tail has passed
    assert starts_moving(standing)[0] < 0.1
    braking = build(pedestrians=(person,), duration_s=20.0)
    _, front, speed = starts_moving(braking, demand=-2.0)
    assert front < 50.0
    assert speed < (60.0 - front) / 7.0 + 0.2


def test_a_gap_counts_the_other_lane_too():
    car = VehicleSpec(x_m=95.0, y_m=-LANE_Y, yaw_rad=math.pi, speed_mps=9.0)
    person = waiting_for(Trigger(gap_s=4.5))
    alone = build(pedestrians=(person,), ego_speed_mps=0.0)
    with_car = build(pedestrians=(person,), ego_speed_mps=0.0, vehicles=(car,))
    assert starts_moving(alone)[0] < 0.1
    assert 3.0 < starts_moving(with_car)[0] < 6.0


def test_who_arrives_in_a_gap_walks_on_without_stopping():
    to_kerb = Leg(to_x_m=60.0, to_y_m=-6.4, speed_mps=1.5)
    person = PedestrianSpec(
        behaviour="crossing", x_m=60.0, y_m=-9.0,
        legs=(to_kerb, Leg(to_x_m=60.0, to_y_m=6.5, speed_mps=1.5, go=Trigger(gap_s=3.0))),
    )  # fmt: skip
    for ego_speed, stops in ((0.0, False), (20.0, True)):
        world = build(pedestrians=(person,), ego_speed_mps=ego_speed, finish_x_m=200.0, ego_x_m=0.0)
        slowest = math.inf
        while world.time_s < 3.5:
            world.step(0.0)
            slowest = min(slowest, float(world.snapshot(world.time_s).actors[0]["speed"]))
        assert (slowest == 0.0) is stops


def test_the_label_knows_a_crossing_once_it_is_triggered():
    world = build(pedestrians=(waiting_for(Trigger(ttc_s=3.0)),))
    seen = []
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
        facts = world.facts()
        seen.append((world.time_s, facts["crossing"], facts["crossing_in_s"]))
    assert all(math.isnan(soon) and not label for time, label, soon in seen if time < 2.7)
    assert any(label for _, label, _ in seen)
    assert world.outcome is Outcome.COLLISION


def test_a_leader_that_swings_out_reveals_who_stands_ahead():
    street = StreetSpec(lanes_per_direction=2)
    inner = street.ego_lane_y_m + street.lane_width_m
    swing = Maneuver(when=Trigger(reached_x_m=35.0), to_y_m=inner, duration_s=2.0)
    leader = VehicleSpec(x_m=22.0, y_m=street.ego_lane_y_m, speed_mps=10.0, model="van", maneuvers=(swing,))
    person = PedestrianSpec(behaviour="standing", x_m=75.0, y_m=street.ego_lane_y_m)
    world = build(street=street, vehicles=(leader,), pedestrians=(person,), finish_x_m=150.0)
    ys, yaws = [], []
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
        record = world.snapshot(world.time_s).actors[0]
        ys.append(float(record["y"]))
        yaws.append(float(record["yaw"]))
    assert ys[0] == pytest.approx(street.ego_lane_y_m)
    assert ys[-1] == pytest.approx(inner)
    assert 0.1 < max(yaws) < 0.6
    assert world.outcome is Outcome.COLLISION  # with the person: the leader got past
    assert world.impact_speed_mps == pytest.approx(10.0, abs=0.01)


def test_a_line_that_is_taken_is_not_entered():
    street = StreetSpec(lanes_per_direction=2)
    inner = street.ego_lane_y_m + street.lane_width_m
    swing = Maneuver(when=Trigger(time_s=0.0), to_y_m=inner)
    pair = (
        VehicleSpec(x_m=40.0, y_m=street.ego_lane_y_m, speed_mps=8.0, maneuvers=(swing,)),
        VehicleSpec(x_m=40.0, y_m=inner, speed_mps=8.0),
    )
    world = build(street=street, vehicles=pair, ego_speed_mps=5.0, duration_s=4.0)
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
    assert float(world.snapshot(world.time_s).actors[0]["y"]) == pytest.approx(street.ego_lane_y_m)


def test_a_maneuver_brakes_at_its_rate_and_holds():
    stop = Maneuver(when=Trigger(time_s=1.0), speed_mps=0.0, acceleration_mps2=4.0)
    car = VehicleSpec(x_m=30.0, y_m=LANE_Y, speed_mps=8.0, maneuvers=(stop,))
    world = build(vehicles=(car,), ego_speed_mps=0.0, duration_s=6.0)
    xs = []
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
        xs.append(float(world.snapshot(world.time_s).actors[0]["x"]))
    assert xs[-1] - 30.0 == pytest.approx(8.0 * 1.0 + 8.0**2 / (2 * 4.0))
    assert xs[-1] == xs[-20]


def test_a_door_swings_into_the_lane_of_who_passes_too_near():
    car = VehicleSpec(x_m=40.0, y_m=LANE_Y - 1.95, parked=True, door=Trigger(ttc_s=1.5))
    world = build(vehicles=(car,))
    first = world.snapshot(0.0).actors[-1]
    assert abs(float(first["y"]) - car.y_m) < 0.9  # closed: inside the car's side
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
    assert world.outcome is Outcome.COLLISION
    assert world.collided_with == int(world.snapshot(world.time_s).actors[-1]["id"])
    apart = build(vehicles=(VehicleSpec(x_m=40.0, y_m=LANE_Y - 2.8, parked=True, door=Trigger(ttc_s=1.5)),))
    while apart.outcome is Outcome.RUNNING:
        apart.step(0.0)
    assert apart.outcome is Outcome.PASSED


CROSSED = StreetSpec(intersection=Intersection(x_m=70.0))


@pytest.mark.parametrize(
    ("spec", "leaves"),
    [
        (VehicleSpec(x_m=100.0, y_m=1.75, yaw_rad=math.pi, speed_mps=7.0, turn="left"), (1.0, -1.0)),
        (VehicleSpec(x_m=100.0, y_m=1.75, yaw_rad=math.pi, speed_mps=7.0, turn="right"), (-1.0, 1.0)),
        (VehicleSpec(x_m=71.625, y_m=-30.0, yaw_rad=math.pi / 2, speed_mps=7.0), (1.0, 1.0)),
        (VehicleSpec(x_m=71.625, y_m=-30.0, yaw_rad=math.pi / 2, speed_mps=7.0, turn="left"), (-1.0, 1.0)),
    ],
)
def test_cars_turn_where_they_are_told_to(spec, leaves):
    world = build(street=CROSSED, vehicles=(spec,), ego_speed_mps=0.0, duration_s=12.0)
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
    record = world.snapshot(world.time_s).actors[0]
    x, y = float(record["x"]) - 70.0, float(record["y"])
    assert abs(y) > 10.0 or abs(x) > 10.0
    if abs(y) > 10.0:
        assert math.copysign(1.0, y) == leaves[1]
        assert abs(x) == pytest.approx(1.625, abs=0.2)
        assert math.copysign(1.0, x) == math.copysign(1.0, leaves[1])  # right-hand traffic
    assert float(record["speed"]) > 3.0


def test_who_turns_left_lets_the_ego_pass_or_is_well_ahead_of_it():
    for start in range(80, 140, 5):
        spec = VehicleSpec(x_m=float(start), y_m=1.75, yaw_rad=math.pi, speed_mps=8.0, turn="left")
        world = build(street=CROSSED, vehicles=(spec,), duration_s=14.0)
        while world.outcome is Outcome.RUNNING:
            world.step(0.0)
        assert world.outcome is Outcome.PASSED


@pytest.mark.parametrize(
    "make",
    [
        lambda: Trigger(),
        lambda: Trigger(ttc_s=-1.0),
        lambda: Trigger(delay_s=math.inf, time_s=0.0),
        lambda: Maneuver(when=Trigger(time_s=0.0)),
        lambda: Maneuver(when=Trigger(time_s=0.0), speed_mps=-3.0),
        lambda: VehicleSpec(x_m=0.0, y_m=0.0, door=Trigger(time_s=0.0)),
        lambda: VehicleSpec(x_m=0.0, y_m=0.0, turn="lefft"),
        lambda: build(
            vehicles=(VehicleSpec(x_m=20.0, y_m=1.75, yaw_rad=math.pi, speed_mps=5.0, turn="left"),)
        ),
    ],
)
def test_impossible_triggers_and_maneuvers_are_refused(make):
    with pytest.raises(ConfigError):
        make()
