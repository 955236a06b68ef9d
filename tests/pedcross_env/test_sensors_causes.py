"""What events are put down to: the rule on scenes drawn by hand, and in the environment on scenes with one cause."""

from __future__ import annotations

import numpy as np
import pytest

from pedcross_env.contracts import EventCause, Frame, StaticClass
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Leg, PedestrianSpec, Scenario
from pedcross_env.sensors.causes import blame, edge_owner, is_noise
from pedcross_env.sensors.dvs import initial_state, step_labelled
from pedcross_env.sensors.dvs_config import DvsConfig
from pedcross_env.weather import Weather

f32 = np.float32
SHAPE = (40, 60)
HOLD = np.zeros(1, f32)


def discs(
    *things: tuple[int, float, float, float, float, float], around: int = -2, wall_m: float = 50.0
) -> Frame:
    """Discs (id, x, y, radius, depth, brightness) before a wall of 100 cd/m2, exact by 8x8 samples a pixel."""
    y, x = ((np.arange(8 * n) + 0.5) / 8 for n in SHAPE)
    light, depth, ids = (
        np.full((8 * SHAPE[0], 8 * SHAPE[1]), value) for value in (100.0, wall_m, float(around))
    )
    for name, u, v, radius, away, brightness in sorted(things, key=lambda thing: -thing[4]):
        inside = (x[None] - u) ** 2 + (y[:, None] - v) ** 2 < radius**2
        light[inside], depth[inside], ids[inside] = brightness, away, name
    blocks = light.reshape(SHAPE[0], 8, SHAPE[1], 8).mean(axis=(1, 3)).astype(f32)
    middle = np.s_[4::8, 4::8]
    return Frame(blocks, None, depth[middle].astype(f32), ids[middle].astype(np.int32), 0.0)


def labelled(frames: list[Frame], camera: DvsConfig) -> tuple[np.ndarray, np.ndarray]:
    logs = [np.log(frame.luminance) for frame in frames]
    state, events, causes = initial_state(logs[0], 0, camera, 1), [], []
    nothing = np.zeros(SHAPE, f32)
    for k in range(1, len(frames)):
        change = logs[k] - logs[k - 1]
        owner = edge_owner(frames[k - 1], frames[k])
        cause = blame(owner, scene=change, precipitation=nothing, lightning=nothing)
        state, part, label = step_labelled(state, logs[k], k * 1_000_000, camera, cause)
        events.append(part)
        causes.append(label)
    return np.concatenate(events), np.concatenate(causes)


QUIET = DvsConfig(positive_threshold=0.1, negative_threshold=0.1, shot_hz=0.0)


@pytest.mark.parametrize("around", [StaticClass.BUILDING, StaticClass.GROUND, StaticClass.SKY])
def test_all_events_of_a_disc_before_an_even_wall_are_the_discs(around: int) -> None:
    """Before the ground too, be the ground nearer than the disc, as it is at the feet of a pedestrian."""
    frames = [
        discs((7, 20 + 0.7 * k, 20.0, 8.3, 20.0, 10.0), around=around, wall_m=15.0 if around == -1 else 50.0)
        for k in range(12)
    ]
    events, causes = labelled(frames, QUIET)
    assert len(events) > 500
    assert set(causes.tolist()) == {7}


def test_an_edge_between_two_things_is_the_nearer_ones() -> None:
    """Something passes behind a thing that stands: where they meet, events are the nearer one's, whoever moves."""
    frames = [
        discs((5, 20 + 0.8 * k, 20.0, 12.0, 30.0, 30.0), (9, 32.0, 20.0, 6.0, 10.0, 5.0)) for k in range(15)
    ]
    events, causes = labelled(frames, QUIET)
    away = np.hypot(events["x"] + 0.5 - 32.0, events["y"] + 0.5 - 20.0)
    assert set(causes.tolist()) == {5, 9}
    assert (causes[away < 5.0] == 9).all()
    assert (causes[away > 8.0] == 5).all()


def test_the_largest_part_with_the_sign_of_the_whole_is_the_cause() -> None:
    owner = np.array([[4, 4, 4, 4, 4]], np.int32)
    scene = np.array([[0.5, -0.5, 0.1, 0.2, 0.0]], f32)
    precipitation = np.array([[0.1, 0.9, 0.3, -0.1, 0.0]], f32)
    lightning = np.array([[0.2, 0.2, 0.4, -0.3, 0.0]], f32)
    found = blame(owner, scene=scene, precipitation=precipitation, lightning=lightning)
    assert found.tolist() == [[4, EventCause.PRECIPITATION, EventCause.LIGHTNING, EventCause.LIGHTNING, 4]]


def test_noise_is_told_from_signal() -> None:
    signal = [1, 900, StaticClass.SKY, StaticClass.FURNITURE, EventCause.SIGNAL, EventCause.LIGHTNING]
    noise = [EventCause.LEAK, EventCause.SHOT_NOISE, EventCause.HOT_PIXEL]
    assert is_noise(np.array(signal + noise, np.int32)).tolist() == [False] * 6 + [True] * 3
    assert is_noise(np.empty(0, np.int32)).shape == (0,)


def test_frames_without_ids_are_refused() -> None:
    frame = discs()
    with pytest.raises(ConfigError, match="render the full frame"):
        edge_owner(frame, Frame(frame.luminance, None, None, None, 0.0))


STILL = Scenario(name="still", ego_speed_mps=0.0)
WALKER = Scenario(
    name="walker", ego_speed_mps=0.0,
    pedestrians=(
        PedestrianSpec(behaviour="crossing", x_m=16.0, y_m=2.0, legs=(Leg(to_x_m=16.0, to_y_m=-6.0, speed_mps=1.5),)),
    ),
)  # fmt: skip


def sense(
    scenario: Scenario, weather: object, steps: int, **settings: object
) -> tuple[np.ndarray, np.ndarray, CrossingEnv]:
    env = CrossingEnv(
        {
            "camera": {"width_px": 112, "height_px": 64}, "return_events": True, "label_events": True,
            "dvs": {"shot_hz": 0.0, "positive_threshold": 0.2, "negative_threshold": 0.2},
        } | settings
    )  # fmt: skip
    env.reset(seed=3, options={"scenario": scenario, "weather": weather})
    infos = [env.step(HOLD)[-1] for _ in range(steps)]
    for info in infos:
        assert info["event_causes"].shape == info["events"].shape
    return *(np.concatenate([info[key] for info in infos]) for key in ("events", "event_causes")), env


def test_who_walks_before_a_camera_at_rest_makes_the_events() -> None:
    events, causes, env = sense(WALKER, "clear", 12)
    (person,) = env.truth().pedestrians
    shadow = causes == StaticClass.GROUND
    assert len(events) > 200
    assert set(causes[~shadow].tolist()) == {person.actor_id}
    assert shadow.mean() < 0.3
    left, top, right, bottom = person.amodal_box
    last = (events["t"] > events["t"].max() - 30_000_000) & ~shadow
    inside = (
        (events["x"] > left - 3)
        & (events["x"] < right + 3)
        & (events["y"] > top - 3)
        & (events["y"] < bottom + 3)
    )
    assert inside[last].all()


def test_labels_leave_the_events_as_they_are() -> None:
    scenario, rain = Scenario(name="drive", ego_speed_mps=8.0), Weather(rain_mm_h=100.0, wetness=0.5)
    settings = {"dvs": {"positive_threshold": 0.05, "negative_threshold": 0.05}}
    events, causes, _ = sense(scenario, rain, 3, **settings)
    env = CrossingEnv({"return_events": True, "camera": {"width_px": 112, "height_px": 64}} | settings)
    env.reset(seed=3, options={"scenario": scenario, "weather": rain})
    infos = [env.step(HOLD)[-1] for _ in range(3)]
    assert "event_causes" not in infos[0]
    np.testing.assert_array_equal(np.concatenate([info["events"] for info in infos]), events)
    assert {StaticClass.BUILDING, StaticClass.GROUND, EventCause.PRECIPITATION} <= set(causes.tolist())


def test_rain_before_a_camera_at_rest_makes_the_events() -> None:
    dvs = {"shot_hz": 0.0, "positive_threshold": 0.02, "negative_threshold": 0.02}
    events, causes, _ = sense(STILL, Weather(rain_mm_h=50.0), 4, dvs=dvs)
    assert len(events) > 100
    assert (causes == EventCause.PRECIPITATION).mean() > 0.95


def test_lightning_before_a_camera_at_rest_makes_the_events() -> None:
    weather = Weather(sun_altitude_deg=-10.0, lightning_per_min=60.0)
    events, causes, _ = sense(STILL, weather, 40)
    assert len(events) > 1000
    assert (causes == EventCause.LIGHTNING).mean() > 0.98
