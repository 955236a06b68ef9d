"""Our event camera: analytic ramps, a pixel stepped densely in time, and its invariants."""

from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
from dvs_movies import STEP_NS, config, f32, play, smooth_sequence

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import ConfigError
from pedcross_env.sensors.dvs import DvsState, add_counts, initial_state, step, step_counts
from pedcross_env.sensors.dvs_config import DVS_PRESETS, DvsConfig, dvs_preset
from pedcross_env.sensors.intensity import log_image, log_luminance


@pytest.mark.parametrize("rise", [1.17, -0.87])
def test_a_ramp_fires_at_equal_intervals(rise: float) -> None:
    camera, start = config(0.1), 50_000_000
    state = initial_state(np.zeros((2, 3), f32), start, camera, 0)
    _, events = step(state, np.full((2, 3), rise, f32), start + STEP_NS, camera)
    one = events[(events["x"] == 2) & (events["y"] == 1)]
    crossings = np.arange(1, len(one) + 1)
    assert len(one) == int(abs(rise) / 0.1 + 1e-4)
    assert (one["pol"] == (rise > 0)).all()
    assert np.abs(one["t"] - (start + crossings * 0.1 / abs(rise) * STEP_NS)).max() <= 4


@pytest.mark.parametrize(("positive", "negative"), [(0.3, 0.3), (0.05, 0.2)])
def test_events_reconstruct_the_log_frame_within_a_threshold(positive: float, negative: float) -> None:
    movie = smooth_sequence(7, frames=20)
    _, found = play(movie, config(positive_threshold=positive, negative_threshold=negative))
    events = np.concatenate(found)
    rebuilt = movie[0].astype(np.float64)
    np.add.at(rebuilt, (events["y"], events["x"]), np.where(events["pol"], positive, -negative))
    assert np.abs(rebuilt - movie[-1]).max() <= max(positive, negative) + 1e-5


def test_the_frame_rate_does_not_matter_where_light_runs_straight() -> None:
    """Splitting every interval in three leaves every event where it was, also behind a filter that has settled."""
    coarse = smooth_sequence(3, frames=5)
    share = np.arange(3, dtype=f32)[:, None, None] / 3
    fine = np.concatenate([a + (b - a) * share for a, b in itertools.pairwise(coarse)] + [coarse[-1:]])
    once = np.concatenate(play(coarse, config(0.1), step_ns=3 * STEP_NS)[1])
    thrice = np.concatenate(play(fine.astype(f32), config(0.1))[1])
    assert len(once) > 500
    assert abs(len(once) - len(thrice)) <= 2  # a crossing at a frame's very end
    times = np.sort(once["t"]), np.sort(thrice["t"])
    if len(once) == len(thrice):
        assert np.abs(times[0] - times[1]).max() < 500


def dense_oracle(movie: np.ndarray, camera: DvsConfig, steps: int = 20_000) -> list[list[tuple[float, bool]]]:
    """Every pixel by itself in small steps of time, float64; per pixel (t in s, ON)."""
    dt = STEP_NS * 1e-9 / steps
    out = []
    for trace in movie.reshape(len(movie), -1).T.astype(float):
        light = np.concatenate(
            [np.linspace(a, b, steps, endpoint=False) for a, b in itertools.pairwise(trace)] + [trace[-1:]]
        )
        seen = light.copy()
        if camera.cutoff_hz:
            mean = np.repeat(0.5 * (trace[1:] + trace[:-1]), steps)
            pole = 2 * math.pi * camera.cutoff_hz / (1 + camera.cutoff_half_cd_m2 / np.exp(mean))
            for k in range(1, len(light)):
                middle = 0.5 * (light[k - 1] + light[k])
                seen[k] = middle + (seen[k - 1] - middle) * math.exp(-pole[k - 1] * dt)
            seen = np.interp(np.arange(len(light)), np.arange(0, len(light), steps), seen[::steps])
        events, reference, free = [], seen[0], 0.0
        leak = camera.leak_hz * camera.positive_threshold * dt
        held = False
        for k in range(1, len(seen)):
            t = k * dt
            if held:
                if t < free:
                    continue
                held, reference = False, seen[k]
            reference -= leak
            while not held:
                on = seen[k] - reference >= camera.positive_threshold
                if not on and reference - seen[k] < camera.negative_threshold:
                    break
                reference += camera.positive_threshold if on else -camera.negative_threshold
                events.append((t, bool(on)))
                if camera.refractory_ns:
                    held, free = True, t + camera.refractory_ns * 1e-9
        out.append(events)
    return out


DENSE = {
    "plain": {},
    "refractory": {"refractory_ns": 4_000_000},
    "long refractory": {"refractory_ns": 50_000_000},
    "slow photoreceptor": {"cutoff_hz": 8.0, "cutoff_half_cd_m2": 1.0},
    "all": {
        "refractory_ns": 4_000_000,
        "cutoff_hz": 20.0,
        "cutoff_half_cd_m2": 0.5,
        "negative_threshold": 0.25,
    },
}


@pytest.mark.parametrize("name", DENSE)
def test_events_equal_those_of_pixels_stepped_densely(name: str) -> None:
    camera = config(**({"threshold": 0.15} | DENSE[name]))
    movie = smooth_sequence(9, frames=5, shape=(3, 4))
    _, found = play(movie, camera)
    events = np.concatenate(found)
    expected = dense_oracle(movie, camera)
    assert sum(map(len, expected)) > 30
    for pixel, truth in enumerate(expected):
        ours = events[events["y"].astype(int) * 4 + events["x"] == pixel]
        assert ours["pol"].tolist() == [on for _, on in truth]
        np.testing.assert_allclose(
            ours["t"] * 1e-9, [t for t, _ in truth], rtol=0, atol=5e-5
        )  # the steps add up


CAMERAS = {
    "plain": config(0.1),
    "refractory": config(0.05, refractory_ns=3_000_000),
    "mismatch": config(0.1, sigma_threshold=0.03),
    "shot": config(0.1, shot_hz=40.0),
    "shot with mismatch, leak and hot pixels": config(
        0.1, sigma_threshold=0.03, shot_hz=40.0, leak_hz=2.0, leak_spread_decades=0.1, hot_share=0.02
    ),
    "leak": config(0.1, leak_hz=2.0),
    "bus": config(0.05, bus_events_per_s=20_000.0, bus_queue=50),
    "carla": config(0.1, model="carla", refractory_ns=3_000_000),
    "carla mismatch": config(0.1, sigma_threshold=0.03, model="carla"),
    **{name: preset for name, preset in DVS_PRESETS.items() if name != "carla"},
}


@pytest.mark.parametrize("name", CAMERAS)
def test_counting_is_stepping_without_the_times(name: str) -> None:
    camera, movie = CAMERAS[name], smooth_sequence(4, shape=(20, 31))
    state = other = initial_state(movie[0], 0, camera, 11)
    counts, added = np.zeros((20, 31, 2), np.uint8), np.zeros((20, 31, 2), np.uint8)
    for k, frame in enumerate(movie[1:], 1):
        state, events = step(state, frame, k * STEP_NS, camera)
        add_counts(added, events)
        other = step_counts(other, frame, k * STEP_NS, camera, counts)
    assert counts.any()
    np.testing.assert_array_equal(counts, added)
    for field in dataclasses.fields(DvsState):
        np.testing.assert_array_equal(getattr(state, field.name), getattr(other, field.name))


@pytest.mark.parametrize("name", CAMERAS)
def test_same_seed_same_bytes_sorted_and_no_trace_in_inputs_or_global_rng(name: str) -> None:
    camera, movie = CAMERAS[name], smooth_sequence(4)
    np.random.seed(5)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # type: ignore[index, union-attr]  # noqa: NPY002
    state = initial_state(movie[0], 0, camera, 11)
    state, _ = step(state, movie[1], STEP_NS, camera)
    arrays = [getattr(state, f.name) for f in dataclasses.fields(DvsState)]
    copies = [np.copy(array) for array in arrays]
    frame = movie[2].copy()
    _, first = step(state, frame, 2 * STEP_NS, camera)
    _, again = step(state, frame, 2 * STEP_NS, camera)
    assert first.tobytes() == again.tobytes()
    assert first.dtype == EVENT_DTYPE
    assert first["t"].min(initial=STEP_NS) >= STEP_NS
    assert camera.model == "carla" or first["t"].max(initial=STEP_NS) < 2 * STEP_NS
    in_order = first[np.lexsort((first["pol"], first["x"], first["y"], first["t"]))]
    if camera.bus_events_per_s is None:
        np.testing.assert_array_equal(first, in_order)
    else:
        assert (np.diff(first["t"]) >= 0).all()
    np.testing.assert_array_equal(frame, movie[2])
    for array, copy in zip(arrays, copies, strict=True):
        np.testing.assert_array_equal(array, copy)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # type: ignore[index]  # noqa: NPY002


def test_the_state_does_not_share_memory_with_the_frames() -> None:
    camera, frame = config(), smooth_sequence(1)[0].copy()
    state = initial_state(frame, 0, camera, 0)
    state, _ = step(state, frame, STEP_NS, camera)
    frame[:] = 99
    assert state.log_frame.max() < 10
    assert state.photoreceptor.max() < 10
    assert state.reference.max() < 10


def test_nothing_changes_nothing_fires() -> None:
    frame = smooth_sequence(1)[0]
    _, (events,) = play(np.stack([frame, frame]), config(0.01))
    assert events.shape == (0,)
    assert events.dtype == EVENT_DTYPE


def test_more_events_than_expected_are_all_kept() -> None:
    camera = config(0.01)
    state = initial_state(np.zeros((4, 5), f32), 0, camera, 0)
    _, events = step(state, np.full((4, 5), 3.0, f32), STEP_NS, camera)
    assert 20 * 298 <= events.size <= 20 * 300


def test_counts_saturate() -> None:
    camera, counts = config(0.01), np.zeros((1, 1, 2), np.uint8)
    state = initial_state(np.zeros((1, 1), f32), 0, camera, 0)
    step_counts(state, np.full((1, 1), 3.0, f32), STEP_NS, camera, counts)
    assert counts.tolist() == [[[255, 0]]]


def test_mismatch_is_fixed_and_has_the_spread_asked_for() -> None:
    camera = config(0.3, sigma_threshold=0.03)
    state = initial_state(np.zeros((150, 200), f32), 0, camera, 4)
    for thresholds in (state.positive_threshold, state.negative_threshold):
        assert thresholds.mean() == pytest.approx(0.3, abs=0.001)
        assert thresholds.std() == pytest.approx(0.03, rel=0.03)
    assert np.corrcoef(state.positive_threshold, state.negative_threshold)[0, 1] == pytest.approx(0, abs=0.03)
    later, _ = step(state, np.ones((150, 200), f32), STEP_NS, camera)
    assert later.positive_threshold is state.positive_threshold


def test_the_photoreceptor_is_slower_in_the_dark() -> None:
    """A step of light is followed to 1 - 1/e within 1 / (2 pi f), f = cutoff l / (l + half)."""
    camera = config(1 - math.exp(-1), cutoff_hz=100.0, cutoff_half_cd_m2=1.0)
    delays = []
    for light in (100.0, 0.01):
        base = f32(math.log(light))
        state = initial_state(np.full((1, 1), base, f32), 0, camera, 0)
        times_ns = np.concatenate([[1], np.arange(1, 4000) * 100_000])
        for t in times_ns:  # the step takes a nanosecond
            state, events = step(state, np.full((1, 1), base + f32(1), f32), int(t), camera)
            if len(events):
                delays.append(int(events["t"][0]) * 1e-9)
                break
    for delay, light in zip(delays, (100.0, 0.01), strict=True):
        lit = light * math.e
        assert delay == pytest.approx((1 + 1 / lit) / (2 * math.pi * 100), rel=0.02)


def test_log_luminance_is_the_natural_logarithm_to_float32_rounding() -> None:
    luminance = np.geomspace(1e-6, 1e7, 4001, dtype=f32).reshape(1, -1)
    exact = np.log((luminance + f32(0.01)).astype(np.float64))
    found = log_luminance(luminance, 0.01)
    assert found.dtype == np.float32
    assert np.abs(found - exact).max() < 2e-6
    assert (np.diff(found[0]) >= 0).all()


def test_pictures_become_the_light_they_show() -> None:
    camera = DvsConfig(white_cd_m2=500.0, log_floor_cd_m2=0.01)
    image = np.array([[0, 128, 255]], np.uint8)
    linear = np.array([0.0, ((128 / 255 + 0.055) / 1.055) ** 2.4, 1.0])
    np.testing.assert_allclose(log_image(image, camera)[0], np.log(500 * linear + 0.01), atol=1e-5)
    colour = np.repeat(image[..., None], 3, axis=2)
    np.testing.assert_allclose(log_image(colour, camera), log_image(image, camera), atol=1e-5)


def test_wrong_frames_and_times_are_refused() -> None:
    camera = config()
    state = initial_state(np.zeros((4, 5), f32), 100, camera, 0)
    with pytest.raises(ConfigError, match="log_image"):
        step(state, np.zeros((4, 5), np.uint8), 200, camera)
    with pytest.raises(ConfigError, match=r"\(4, 5\)"):
        step(state, np.zeros((5, 4), f32), 200, camera)
    with pytest.raises(ConfigError, match="later than"):
        step(state, np.zeros((4, 5), f32), 100, camera)
    with pytest.raises(ConfigError, match="C-contiguous"):
        step_counts(state, np.zeros((4, 5), f32), 200, camera, np.zeros((5, 4, 2), np.uint8))


def test_unknown_cameras_are_refused_with_the_nearest_name() -> None:
    with pytest.raises(ConfigError, match="davis346"):
        dvs_preset("davis364")
    with pytest.raises(ConfigError, match="shot_hz"):
        dvs_preset("davis346", shot_rate_hz=3.0)
    with pytest.raises(ConfigError, match="pedcross"):
        DvsConfig(model="pedcros")  # type: ignore[arg-type]


@pytest.mark.parametrize("model", ["pedcross", "carla", "v2e"])
@pytest.mark.parametrize("spoilt", [np.nan, np.inf, -np.inf, 1e30])
def test_frames_that_are_no_logarithms_are_refused(model: str, spoilt: float) -> None:
    camera, frame = DvsConfig(model=model), np.zeros((4, 5), f32)
    state, bad = initial_state(frame, 0, camera, 0), frame.copy()
    bad[2, 3] = spoilt
    with pytest.raises(ConfigError, match="finite and within"):
        initial_state(bad, 0, camera, 0)
    with pytest.raises(ConfigError, match="finite and within"):
        step(state, bad, STEP_NS, camera)
    with pytest.raises(ConfigError, match="finite and within"):
        step_counts(state, bad, STEP_NS, camera, np.zeros((4, 5, 2), np.uint8))
