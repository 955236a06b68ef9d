"""The label, the time to crossing and the conflict, on scenes whose truth is plain."""

import math

import numpy as np
import pytest

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig, EgoConfig, LabelConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.scenario import Leg, PedestrianSpec, Scenario, StreetSpec, VehicleSpec
from pedcross_env.scenario.sizes import pedestrian_size
from pedcross_env.scenario.walk import RAMP_S
from pedcross_env.weather.weather import Weather
from pedcross_env.world import World

STREET = StreetSpec()
LANE_Y, KERB_Y = STREET.ego_lane_y_m, STREET.kerb_y_m


def build(*people: PedestrianSpec, speed: float = 0.0, fov_deg: float = 60.0, **label: float) -> World:
    scenario = Scenario(name="s", ego_speed_mps=speed, pedestrians=people, duration_s=10.0)
    return World(
        scenario, ego=EgoConfig(), world=WorldConfig(), label=LabelConfig(**label), friction=0.85,
        camera=CameraConfig(horizontal_fov_deg=fov_deg),
    )  # fmt: skip


def walker(
    *legs: Leg, x: float = 30.0, y: float = -KERB_Y - 0.5, behaviour: str = "crossing"
) -> PedestrianSpec:
    return PedestrianSpec(behaviour=behaviour, x_m=x, y_m=y, legs=legs)


def labels(world: World) -> list[tuple[float, int, float]]:
    rows = []
    while world.outcome is Outcome.RUNNING:
        facts = world.facts()
        rows.append((facts["time_s"], facts["crossing"], facts["crossing_in_s"]))
        world.step(0.0)
    return rows


def test_label_is_one_exactly_while_on_the_carriageway() -> None:
    leg = Leg(to_x_m=30.0, to_y_m=KERB_Y + 2.0, speed_mps=2.0, wait_s=1.0)
    steps_on_s = 1.0 + 0.5 * RAMP_S + 0.5 / 2.0
    leaves_s = steps_on_s + 2 * KERB_Y / 2.0
    for time, crossing, crossing_in in labels(build(walker(leg))):
        if abs(time - steps_on_s) > 1e-3 and abs(time - leaves_s) > 1e-3:
            assert crossing == int(steps_on_s < time < leaves_s)
            expected = math.nan if time > leaves_s else max(0.0, steps_on_s - time)
            assert crossing_in == pytest.approx(expected, abs=1e-6, nan_ok=True)


def test_walking_along_is_no_crossing() -> None:
    along = Leg(to_x_m=60.0, to_y_m=-KERB_Y - 0.5, speed_mps=1.4)
    on_the_road = walker(Leg(to_x_m=60.0, to_y_m=LANE_Y, speed_mps=1.4), y=LANE_Y)
    for world in (build(walker(along)), build(on_the_road)):
        rows = labels(world)
        assert all(crossing == 0 for _, crossing, _ in rows)
        assert all(math.isnan(seconds) for _, _, seconds in rows)


def test_stopping_at_the_kerb_is_no_crossing() -> None:
    rows = labels(build(walker(Leg(to_x_m=30.0, to_y_m=-KERB_Y - 0.1, speed_mps=1.0), y=-KERB_Y - 3.0)))
    assert not any(crossing for _, crossing, _ in rows)


def test_who_steps_out_and_turns_back_counts_while_on_the_carriageway() -> None:
    out = Leg(to_x_m=30.0, to_y_m=-KERB_Y + 1.5, speed_mps=1.0)
    back = Leg(to_x_m=30.0, to_y_m=-KERB_Y - 1.0, speed_mps=1.0, wait_s=0.5)
    rows = labels(build(walker(out, back)))
    positive = [time for time, crossing, _ in rows if crossing]
    assert positive[-1] - positive[0] == pytest.approx(1.5 + 1.5 + 0.5 + RAMP_S, abs=0.05)
    assert rows[-1][1] == 0


def test_only_ahead_in_range_and_in_view_counts() -> None:
    crossing = Leg(to_x_m=30.0, to_y_m=KERB_Y, speed_mps=1.0)
    on_the_way = PedestrianSpec(behaviour="crossing", x_m=30.0, y_m=-4.0, legs=(crossing,))
    assert build(on_the_way).facts()["crossing"] == 1
    assert build(on_the_way, range_m=27.0).facts()["crossing"] == 0
    to_the_side = PedestrianSpec(behaviour="crossing", x_m=12.0, y_m=-5.0, legs=(crossing,))
    bearing_deg = math.degrees(math.atan2(5.0 + LANE_Y, 12.0 - 0.3))
    assert build(to_the_side, fov_deg=2 * bearing_deg + 0.1).facts()["crossing"] == 1
    assert build(to_the_side, fov_deg=2 * bearing_deg - 0.1).facts()["crossing"] == 0
    behind = PedestrianSpec(
        behaviour="crossing", x_m=1.0, y_m=-5.0, legs=(Leg(to_x_m=1.0, to_y_m=KERB_Y, speed_mps=1.0),)
    )
    assert build(behind, fov_deg=150.0).facts()["crossing"] == 0
    assert math.isnan(build(behind).facts()["crossing_in_s"])


def test_crossing_ids_are_ordered_by_distance() -> None:
    far, near = (
        PedestrianSpec(behaviour="c", x_m=x, y_m=-2.0, legs=(Leg(to_x_m=x, to_y_m=KERB_Y, speed_mps=1.0),))
        for x in (40.0, 20.0)
    )
    world = build(far, near)
    assert world.crossing_ids() == (3, 2)
    assert world.facts()["distance_m"] == pytest.approx(20.0 - 2.25)


def test_time_to_contact_counts_down_to_the_contact() -> None:
    person = PedestrianSpec(behaviour="standing", x_m=40.0, y_m=LANE_Y)
    world = build(person, speed=10.0, conflict_margin_m=0.0)
    contact_s = (40.0 - 2.25 - 0.5 * pedestrian_size(1.75).length_m) / 10.0
    while world.outcome is Outcome.RUNNING:
        facts = world.facts()
        assert facts["ttc_s"] == pytest.approx(contact_s - world.time_s, abs=2e-3)
        assert facts["conflict"] is True
        world.step(0.0)
    assert world.outcome is Outcome.COLLISION


def test_a_miss_is_no_conflict_unless_the_margin_says_so() -> None:
    half = 0.5 * pedestrian_size(1.75).width_m
    beside = PedestrianSpec(behaviour="standing", x_m=30.0, y_m=LANE_Y - 0.9 - half - 0.2)
    assert build(beside, speed=10.0, conflict_margin_m=0.1).facts()["ttc_s"] == math.inf
    assert build(beside, speed=10.0, conflict_margin_m=0.3).facts()["conflict"] is True


def test_conflict_looks_no_farther_than_the_horizon() -> None:
    person = PedestrianSpec(behaviour="standing", x_m=60.0, y_m=LANE_Y)
    facts = build(person, speed=10.0, conflict_horizon_s=4.0).facts()
    assert facts["ttc_s"] == math.inf
    assert facts["conflict"] is False


def test_a_standing_car_ahead_is_a_conflict() -> None:
    scenario = Scenario(name="s", vehicles=(VehicleSpec(x_m=30.0, y_m=LANE_Y, parked=True, model="sedan"),))
    world = World(scenario, ego=EgoConfig(), world=WorldConfig(), label=LabelConfig(), friction=0.85)
    assert world.facts()["ttc_s"] == pytest.approx((30.0 - 2.35 - 2.25 - 0.3) / 10.0)


def seen(world: World, camera: CameraConfig) -> bool:
    """Whether the render shows any pixel of the pedestrian: the oracle of the label's geometry."""
    renderer = Renderer(camera)
    renderer.load(world.scenario.street, Weather())
    return bool((renderer.render(world.snapshot(0.0)).instance == 2).any())


@pytest.mark.parametrize(
    "changes",
    [
        {"yaw_deg": 25.0},
        {"yaw_deg": -25.0, "mount_y_m": 0.8, "mount_x_m": 1.5},
        {"principal_point": (0.3, 0.6)},
        {"lens": "brown", "distortion": (-0.25, 0.05)},
        {"lens": "fisheye", "distortion": (-0.0275, -0.007, -0.04, 0.0193), "horizontal_fov_deg": 87.4},
        {"roll_deg": 20.0, "pitch_deg": 5.0},
    ],
)
def test_in_view_is_what_the_camera_shows_whatever_its_mount_and_lens(changes: dict) -> None:
    """Along a line across the street, the label changes where the picture begins to show the body."""
    camera = CameraConfig(width_px=96, height_px=54, **changes)
    agree, shown = [], 0
    for y in np.arange(-8.5, 9.0, 0.5):
        step = math.copysign(0.5, -y)
        person = PedestrianSpec(
            behaviour="crossing", x_m=5.0, y_m=float(y),
            legs=(Leg(to_x_m=5.0, to_y_m=float(y) + 20 * step, speed_mps=0.1),),
        )  # fmt: skip
        street = StreetSpec(parking_width_m=4.0, lane_width_m=5.0)
        scenario = Scenario(name="s", street=street, ego_speed_mps=0.0, pedestrians=(person,))
        world = World(
            scenario, ego=EgoConfig(), world=WorldConfig(), label=LabelConfig(), friction=0.85, camera=camera
        )
        visible = seen(world, camera)
        shown += visible
        agree.append(world.facts()["crossing"] == int(visible))
    assert 3 <= shown <= 32
    # half a body's width of the picture's edge may be told either way
    assert sum(not a for a in agree) <= 2, agree
