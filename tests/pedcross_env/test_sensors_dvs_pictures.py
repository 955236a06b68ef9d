"""Counting events of pictures in layers is counting those of the frames put together, bit for bit."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pedcross_env.camera import Picture, Seen, compose, picture_of, whole_picture
from pedcross_env.sensors import DvsConfig, dvs_preset, initial_state, log_luminance, step_counts
from pedcross_env.sensors.dvs_pictures import count_pictures, log_picture

SHAPE = (23, 61)  # neither is a multiple of what kernels work on at a time
ROWS = (23, 17, 11)
STEP_NS = 2_000_000
CAMERAS = {
    "default": DvsConfig(),
    "noise": DvsConfig(shot_hz=400.0, hot_share=0.05, hot_hz=300.0, shot_half_cd_m2=100.0),
    "pixels differ": dvs_preset("clean", positive_threshold=0.05, negative_threshold=0.08, shot_hz=300.0),
    "leak": dvs_preset("noisy"),
    "refractory": DvsConfig(refractory_ns=1_000_000, positive_threshold=0.1, negative_threshold=0.1),
    "bus": dvs_preset("davis346", bus_events_per_s=1e5),
    "carla": DvsConfig(model="carla"),
    "v2e": DvsConfig(model="v2e"),
}


def seen(rng: np.random.Generator, rows: int) -> Seen:
    cover = np.clip(rng.normal(0.5, 1.0, (rows, SHAPE[1])), 0.0, 1.0).astype(np.float32)
    return Seen(cover * rng.lognormal(2.0, 0.6, cover.shape).astype(np.float32), cover)


def pictures(number: int, layers: int) -> list[list[tuple[Seen, Seen, float]]]:
    """The nearest layer as it is, the others between two renders."""
    rng, found = np.random.default_rng(number + layers), []
    for _ in range(number):
        near = seen(rng, ROWS[0])
        behind = [(seen(rng, rows), seen(rng, rows), float(rng.random())) for rows in ROWS[1:layers]]
        found.append([(near, near, 0.0), *behind])
    return found


def put_together(layers: list[tuple[Seen, Seen, float]]) -> np.ndarray:
    """In float64, row by row from behind; the farthest layer has nothing behind it."""
    whole = np.zeros(SHAPE)
    for place, (first, last, share) in enumerate(reversed(layers)):
        light = first.luminance + share * (last.luminance.astype(np.float64) - first.luminance)
        hides = first.cover + share * (last.cover.astype(np.float64) - first.cover)
        rows = len(light)
        whole[:rows] = light + (0.0 if place == 0 else (1.0 - hides) * whole[:rows])
    return whole


@pytest.mark.parametrize("layers", [1, 2, 3])
def test_layers_are_put_together_by_their_cover(layers: int) -> None:
    for parts in pictures(3, layers):
        expected = put_together(parts)
        np.testing.assert_allclose(compose(parts, SHAPE), expected, rtol=1e-5)
        found = log_picture(picture_of(parts), SHAPE, 0.01)
        assert found.tobytes() == log_luminance(compose(parts, SHAPE), 0.01).tobytes()
        np.testing.assert_allclose(found, np.log(expected + 0.01), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize("layers", [1, 3])
@pytest.mark.parametrize("name", CAMERAS)
def test_counts_and_state_are_those_of_frames(name: str, layers: int, kind: type) -> None:
    config = CAMERAS[name]
    first, *others = pictures(9, layers)
    begin = initial_state(log_luminance(compose(first, SHAPE), config.log_floor_cd_m2), 0, config, seed=3)
    kept = begin.reference.copy(), begin.log_frame.copy()
    expected, found = np.full((*SHAPE, 2), 250, kind), np.full((*SHAPE, 2), 250, kind)
    frames = begin
    timed: list[tuple[Picture, int]] = []
    for k, parts in enumerate(others, 1):
        log_frame = log_luminance(compose(parts, SHAPE), config.log_floor_cd_m2)
        frames = step_counts(frames, log_frame, k * STEP_NS, config, expected)
        timed.append((picture_of(parts), k * STEP_NS))
    end = count_pictures(begin, timed, config, found)
    assert found.tobytes() == expected.tobytes()
    assert found.max() > 250
    for field in dataclasses.fields(end):
        assert np.array_equal(getattr(end, field.name), getattr(frames, field.name)), field.name
    assert np.array_equal(begin.reference, kept[0])
    assert np.array_equal(begin.log_frame, kept[1])


def test_a_whole_picture_is_one_layer() -> None:
    light = np.random.default_rng(1).lognormal(2.0, 0.5, SHAPE).astype(np.float32)
    assert log_picture(whole_picture(light), SHAPE, 0.02).tobytes() == log_luminance(light, 0.02).tobytes()


def test_no_pictures_leave_the_state_as_it_is() -> None:
    config = DvsConfig()
    state = initial_state(np.zeros(SHAPE, np.float32), 0, config, seed=1)
    counts = np.zeros((*SHAPE, 2), np.uint8)
    after = count_pictures(state, [], config, counts)
    assert (after.time_ns, after.frame, counts.any()) == (0, 0, False)
