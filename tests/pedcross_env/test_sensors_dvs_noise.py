"""Noise and readout of our event camera: each against the statistics it is stated to have."""

from __future__ import annotations

import math

import numpy as np
import pytest
from dvs_movies import STEP_NS, config, f32, play, smooth_sequence

from pedcross_env.contracts import EVENT_DTYPE, EventCause
from pedcross_env.sensors.dvs import initial_state, step, step_labelled
from pedcross_env.sensors.dvs_config import DvsConfig

SECONDS = 30 * STEP_NS * 1e-9


def still(shape: tuple[int, int], log_light: float = 0.0, frames: int = 31) -> np.ndarray:
    return np.full((frames, *shape), log_light, f32)


def per_pixel(events: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    return np.bincount(events["y"].astype(int) * shape[1] + events["x"], minlength=shape[0] * shape[1])


@pytest.mark.parametrize("light", [1e-3, 1.0, 30.0])
def test_shot_noise_is_poisson_and_falls_with_the_light(light: float) -> None:
    """Rate shot_hz / (1 + light / half), both polarities alike; within four standard deviations."""
    camera, shape = config(shot_hz=20.0, shot_half_cd_m2=2.0), (100, 150)
    state, found = play(still(shape, math.log(light)), camera)
    events = np.concatenate(found)
    expected = 20.0 / (1 + light / 2.0) * shape[0] * shape[1] * SECONDS
    assert abs(events.size - expected) < 4 * expected**0.5
    assert abs(events["pol"].sum() - events.size / 2) < 4 * (events.size / 4) ** 0.5
    number = per_pixel(events, shape)
    pixels = number.size
    assert number.var() / number.mean() == pytest.approx(1.0, abs=4 * math.sqrt(2 / pixels) + 0.01)
    rows = number.reshape(shape).sum(axis=1)
    assert abs(((rows - rows.mean()) ** 2 / rows.mean()).sum() - 99) < 4 * math.sqrt(2 * 99)
    for k, part in enumerate(found):
        assert part["t"].min() >= k * STEP_NS
        assert part["t"].max() < (k + 1) * STEP_NS
    phase = np.histogram(events["t"] % STEP_NS, 10, (0, STEP_NS))[0]
    assert abs(((phase - phase.mean()) ** 2 / phase.mean()).sum() - 9) < 4 * math.sqrt(18)
    np.testing.assert_allclose(state.reference, math.log(light), rtol=1e-6)


def test_shot_noise_prefers_pixels_with_low_thresholds() -> None:
    camera, shape = config(0.2, sigma_threshold=0.04, shot_hz=40.0, shot_half_cd_m2=1e6), (100, 150)
    state, found = play(still(shape), camera)
    events = np.concatenate(found)
    for polarity, thresholds in ((True, state.positive_threshold), (False, state.negative_threshold)):
        number = per_pixel(events[events["pol"] == polarity], shape)
        expected = 20.0 * SECONDS * np.minimum(2.0, 0.2 / thresholds.astype(float))
        for chosen in (thresholds < 0.17, thresholds > 0.22):
            assert abs(number[chosen].sum() - expected[chosen].sum()) < 4 * math.sqrt(expected[chosen].sum())


def test_a_noise_event_makes_the_pixel_forget() -> None:
    """Half a threshold is lost with it: a slow ramp gives fewer signal events than without noise."""
    camera, quiet = config(0.3, shot_hz=2000.0, shot_half_cd_m2=1e6), config(0.3)
    movie = np.linspace(0, 3, 31, dtype=f32)[:, None, None] * np.ones((1, 8, 8), f32)
    state, signal = initial_state(movie[0], 0, camera, 1), 0
    for k, frame in enumerate(movie[1:], 1):
        state, _, causes = step_labelled(state, frame, k * STEP_NS, camera)
        signal += np.count_nonzero(causes == EventCause.SIGNAL)
    assert signal < 0.2 * sum(map(len, play(movie, quiet)[1]))


def test_noise_differs_between_frames_and_seeds() -> None:
    camera = config(shot_hz=20.0)
    _, (first, second) = play(still((60, 60), frames=3), camera, seed=1)
    _, (other, _) = play(still((60, 60), frames=3), camera, seed=2)
    assert first.size
    assert second["x"].tobytes() != first["x"].tobytes()
    assert other.tobytes() != first.tobytes()


def test_leak_is_steady_from_the_start_and_has_its_rate() -> None:
    camera, shape = config(0.25, leak_hz=4.0), (60, 80)
    _, found = play(still(shape, frames=61), camera)
    events = np.concatenate(found)
    assert events["pol"].all()
    assert events.size == pytest.approx(4.0 * 60 * STEP_NS * 1e-9 * 4800, rel=0.02)
    in_frame = np.array([len(part) for part in found])
    assert np.abs(in_frame - in_frame.mean()).max() < 5 * math.sqrt(in_frame.mean())
    # Each pixel fires like a clock.
    number = per_pixel(events, shape)
    assert set(number.tolist()) <= {7, 8, 9}


def test_leak_rates_differ_between_pixels_by_the_spread_asked_for() -> None:
    camera, shape = config(0.25, leak_hz=20.0, leak_spread_decades=0.2, sigma_threshold=0.03), (60, 80)
    state, found = play(still(shape, frames=91), camera)
    rates = per_pixel(np.concatenate(found), shape) / (90 * STEP_NS * 1e-9)
    decades = np.log10(state.leak_per_s / (0.25 * 20.0) * (0.25 / state.positive_threshold))
    assert decades.std() == pytest.approx(0.2, rel=0.05)
    np.testing.assert_allclose(rates, state.leak_per_s / state.positive_threshold, atol=0.5)


def test_hot_pixels_have_their_number_and_rates() -> None:
    camera, shape = config(hot_share=0.02, hot_hz=50.0), (100, 150)
    state, found = play(still(shape), camera)
    number = per_pixel(np.concatenate(found), shape)
    assert abs(state.hot_pixels.size - 300) < 4 * math.sqrt(300)
    assert not np.delete(number, state.hot_pixels).any()
    expected = state.hot_hz * SECONDS
    assert abs(number[state.hot_pixels] - expected).sum() / expected.sum() < 0.2
    assert ((number[state.hot_pixels] - expected) ** 2 / expected).mean() == pytest.approx(1.0, abs=0.35)
    share = np.mean((state.hot_hz > 25.0) & (state.hot_hz < 100.0))
    assert share == pytest.approx(0.5, abs=4 * 0.5 / math.sqrt(state.hot_pixels.size))
    assert np.median(state.hot_hz) == pytest.approx(50.0, rel=0.3)


def test_the_bus_sends_no_faster_than_it_can_loses_the_rest_and_tells_how_many() -> None:
    free = config(0.05)
    camera = config(0.05, bus_events_per_s=30_000.0, bus_queue=40)
    movie = smooth_sequence(2, shape=(30, 40))
    _, unlimited = play(movie, free)
    state, found = play(movie, camera)
    events = np.concatenate(found)
    assert (np.diff(events["t"]) >= 33_333 - 1).all()
    assert state.lost > 0
    assert events.size + state.waiting.size + state.lost == sum(map(len, unlimited))
    for k, part in enumerate(found):
        assert part["t"].min() >= k * STEP_NS
        assert part["t"].max() < (k + 1) * STEP_NS
    everything = np.concatenate(unlimited)
    # Each sent event happened, at its pixel, no more than the queue's length before.
    longest = 41 * 33_334
    for event in events[::25]:
        same = everything[
            (everything["x"] == event["x"])
            & (everything["y"] == event["y"])
            & (everything["pol"] == event["pol"])
        ]
        delay = event["t"] - same["t"]
        assert ((delay >= 0) & (delay <= longest)).any()


def test_a_bus_that_is_fast_enough_delays_and_loses_nothing() -> None:
    movie = smooth_sequence(2)
    _, unlimited = play(movie, config(0.3))
    state, found = play(movie, config(0.3, bus_events_per_s=1e9, bus_queue=10_000))
    expected, events = np.concatenate(unlimited), np.concatenate([*found, state.waiting])
    assert state.lost == 0
    assert np.abs(np.sort(events["t"]) - np.sort(expected["t"])).max() <= 5


def test_labels_tell_signal_leak_shot_noise_and_hot_pixels_apart() -> None:
    shape = (40, 60)
    camera = config(0.3, shot_hz=5.0, shot_half_cd_m2=1e6, leak_hz=1.0, hot_share=0.01, hot_hz=80.0)
    movie = still(shape, frames=41)
    movie[20:, :, 30:] += 1.0  # the right half brightens between two frames
    causes = np.full(shape, 7, np.int32)
    state, events, labels = initial_state(movie[0], 0, camera, 5), [], []
    for k, frame in enumerate(movie[1:], 1):
        state, part, causes_of_part = step_labelled(state, frame, k * STEP_NS, camera, causes)
        plain = step(initial_state(movie[0], 0, camera, 5), frame, STEP_NS, camera)[1] if k == 1 else None
        assert plain is None or plain.tobytes() == part.tobytes()
        assert causes_of_part.dtype == np.int32
        assert causes_of_part.shape == part.shape
        events.append(part)
        labels.append(causes_of_part)
    cause, event = np.concatenate(labels), np.concatenate(events)
    assert set(cause.tolist()) == {7, EventCause.LEAK, EventCause.SHOT_NOISE, EventCause.HOT_PIXEL}
    signal = event[cause == 7]
    right = signal[(signal["x"] >= 30) & (signal["t"] >= 19 * STEP_NS) & (signal["t"] < 20 * STEP_NS)]
    assert right["pol"].all()
    # 1.0 / 0.3 events; in half of the pixels the leak had done most of the first one's way.
    assert len(right) == pytest.approx(40 * 30 * (1.0 / 0.3 - 0.5), rel=0.06)
    # What light had left of a threshold, leak completes: signal where light did more of it.
    assert (signal["x"] >= 30).all()
    assert (signal["t"] >= 19 * STEP_NS).all()
    assert len(signal) - len(right) < 0.5 * 40 * 30
    seconds = 40 * STEP_NS * 1e-9
    assert np.count_nonzero(cause == EventCause.SHOT_NOISE) == pytest.approx(5.0 * seconds * 2400, rel=0.06)
    assert event[cause == EventCause.LEAK]["pol"].all()
    hot = event[cause == EventCause.HOT_PIXEL]
    assert set(zip(hot["y"].tolist(), hot["x"].tolist(), strict=True)) <= {
        divmod(int(index), 60) for index in state.hot_pixels
    }


def test_labels_wait_with_their_events_for_the_bus() -> None:
    camera = config(0.05, bus_events_per_s=30_000.0, bus_queue=2000)
    movie = smooth_sequence(2, shape=(10, 20))
    state, events, labels = initial_state(movie[0], 0, camera, 5), [], []
    ids = np.arange(200, dtype=np.int32).reshape(10, 20)
    for k, frame in enumerate(movie[1:], 1):
        state, part, causes = step_labelled(state, frame, k * STEP_NS, camera, ids)
        events.append(part)
        labels.append(causes)
    event, cause = np.concatenate(events), np.concatenate(labels)
    assert state.waiting.size == state.waiting_causes.size > 0
    np.testing.assert_array_equal(cause, ids[event["y"], event["x"]])


def test_nothing_to_label_is_an_empty_array() -> None:
    state = initial_state(still((3, 3))[0], 0, config(), 1)
    _, events, causes = step_labelled(state, still((3, 3))[0], STEP_NS, config())
    assert events.shape == causes.shape == (0,)
    assert (events.dtype, causes.dtype) == (EVENT_DTYPE, np.int32)


def test_hot_pixels_never_lose_the_order_of_time_among_shot_noise() -> None:
    camera = DvsConfig(shot_hz=3000.0, shot_half_cd_m2=1e6, hot_share=0.5, hot_hz=2000.0)
    _, found = play(still((6, 7), frames=5), camera)
    for part in found:
        assert (np.diff(part["t"]) >= 0).all()
    rate = sum(map(len, found)) / (4 * STEP_NS * 1e-9)
    assert rate > 42 * 3000
