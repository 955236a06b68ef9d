"""The event camera against CARLA's rule word for word, v2e's recorded counts, and its invariants."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from pedcross_env.config import DvsConfig
from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import ConfigError
from pedcross_env.sensors.dvs import (
    DvsState,
    add_counts,
    carla_log,
    initial_state,
    log_luminance,
    step,
    step_counts,
)

V2E = Path(__file__).parents[2].parent / "shared/realdata/v2e"
STEP_NS = 33_333_333
f32 = np.float32


def config(threshold: float = 0.3, **changes: object) -> DvsConfig:
    values = {"positive_threshold": threshold, "negative_threshold": threshold, "background_rate_hz": 0.0}
    return DvsConfig(**(values | changes))  # type: ignore[arg-type]


def smooth_sequence(seed: int, frames: int = 8, shape: tuple[int, int] = (12, 17)) -> np.ndarray:
    """Smooth random log-luminance movie, float32."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: shape[0], : shape[1]]
    movie = np.zeros((frames, *shape))
    for _ in range(12):
        a, b, c, d = rng.normal(0, 0.4), rng.normal(0, 0.4), rng.uniform(0, 6.3), rng.normal(0, 1.2)
        movie += 0.4 * np.sin(a * x + b * y + c + d * np.arange(frames)[:, None, None])
    return movie.astype(f32)


def play(movie: np.ndarray, camera: DvsConfig, seed: int = 3) -> tuple[DvsState, list[np.ndarray]]:
    state, found = initial_state(movie[0], 0, camera, seed), []
    for k, frame in enumerate(movie[1:], 1):
        state, events = step(state, frame, k * STEP_NS, camera)
        found.append(events)
    return state, found


def carla_oracle(movie: np.ndarray, positive: float, negative: float, refractory_ns: int) -> np.ndarray:
    """CARLA's loop, word for word: scalars, float32, no shortcut."""
    rows, columns = movie.shape[1:]
    reference, previous = movie[0].copy(), movie[0].copy()
    last = np.zeros((rows, columns), np.float64)
    t0, out = 0, []
    for k in range(1, len(movie)):
        t1 = k * STEP_NS
        dt, frame_events = t1 - t0, []
        for y in range(rows):
            for x in range(columns):
                start, end = previous[y, x], movie[k, y, x]
                if not abs(f32(start - end)) > f32(1e-6):
                    continue
                pol = 1 if end >= start else -1
                threshold = f32(positive) if pol > 0 else f32(negative)
                crossing = reference[y, x]
                while True:
                    crossing = f32(crossing + f32(f32(pol) * threshold))
                    if not ((pol > 0 and start < crossing <= end) or (pol < 0 and end <= crossing < start)):
                        break
                    elapsed = f32(f32(f32(crossing - start) * f32(dt)) / f32(end - start))
                    t = t0 + int(elapsed)
                    last_ns = int(last[y, x] * 1e9)
                    if t >= last_ns:
                        if last[y, x] == 0 or t - last_ns >= refractory_ns:
                            frame_events.append((x, y, t, pol > 0))
                            last[y, x] = t / 1e9
                        reference[y, x] = crossing
        previous, t0 = movie[k].copy(), t1
        out += sorted(frame_events, key=lambda e: (e[2], e[1], e[0], e[3]))
    return np.array(out, EVENT_DTYPE)


@pytest.mark.parametrize("threshold", [0.3, 0.05])
@pytest.mark.parametrize("refractory_ns", [0, 3_000_000])
@pytest.mark.parametrize("seed", [1, 2])
def test_events_equal_carlas_rule_transcribed_literally(
    threshold: float, refractory_ns: int, seed: int
) -> None:
    movie = smooth_sequence(seed)
    expected = carla_oracle(movie, threshold, threshold, refractory_ns)
    _, found = play(movie, config(threshold, refractory_ns=refractory_ns))
    events = np.concatenate(found)
    assert expected.size > 300
    np.testing.assert_array_equal(events, expected)


def test_unequal_thresholds_equal_carlas_rule() -> None:
    movie = smooth_sequence(5)
    _, found = play(movie, config(positive_threshold=0.11, negative_threshold=0.23))
    np.testing.assert_array_equal(np.concatenate(found), carla_oracle(movie, 0.11, 0.23, 0))


def test_refractory_period_hides_events_but_moves_the_reference() -> None:
    movie = smooth_sequence(1)
    free, held = play(movie, config(0.05)), play(movie, config(0.05, refractory_ns=3_000_000))
    assert sum(map(len, held[1])) < sum(map(len, free[1]))
    np.testing.assert_array_equal(held[0].reference, free[0].reference)


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


@pytest.mark.skipif(not V2E.is_dir(), reason="v2e's recorded counts (../shared/realdata/v2e) are not here")
@pytest.mark.parametrize("name", ["c05_05", "c20_20", "c30_18"])
def test_counts_equal_those_of_v2e_for_every_pixel_polarity_and_frame(name: str) -> None:
    """Both rules count how many thresholds fit between the reference and the frame; their times differ."""
    recorded = np.load(V2E / f"{name}.npz")
    movie = recorded["log_frames"]
    camera = config(
        positive_threshold=float(recorded["theta_on"]), negative_threshold=float(recorded["theta_off"])
    )
    state = initial_state(movie[0], 0, camera, 0)
    assert not recorded["counts"][0].any()
    for k in range(1, len(movie)):
        counts = np.zeros((*movie.shape[1:], 2), np.uint8)
        state = step_counts(state, movie[k], round(k * 1e9 / float(recorded["fps"])), camera, counts)
        np.testing.assert_array_equal(counts[..., 1], recorded["counts"][k, 0], f"OFF, frame {k}")
        np.testing.assert_array_equal(counts[..., 0], recorded["counts"][k, 1], f"ON, frame {k}")


CAMERAS = {
    "plain": config(0.1),
    "refractory": config(0.05, refractory_ns=3_000_000),
    "pixel mismatch": config(0.1, sigma_threshold=0.03),
    "carla mismatch": config(0.1, sigma_threshold=0.03, mismatch="carla"),
    "background": config(0.1, background_rate_hz=40.0),
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
    arrays = [getattr(state, f.name) for f in dataclasses.fields(DvsState)]
    copies = [np.copy(array) for array in arrays]
    frame = movie[1].copy()
    _, first = step(state, frame, STEP_NS, camera)
    _, again = step(state, frame, STEP_NS, camera)
    assert first.tobytes() == again.tobytes()
    assert first.dtype == EVENT_DTYPE
    np.testing.assert_array_equal(
        first, first[np.lexsort((first["pol"], first["x"], first["y"], first["t"]))]
    )
    np.testing.assert_array_equal(frame, movie[1])
    for array, copy in zip(arrays, copies, strict=True):
        np.testing.assert_array_equal(array, copy)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # type: ignore[index]  # noqa: NPY002


def test_the_state_does_not_share_memory_with_the_frames() -> None:
    camera, frame = config(), smooth_sequence(1)[0].copy()
    state = initial_state(frame, 0, camera, 0)
    state, _ = step(state, frame, STEP_NS, camera)
    frame[:] = 99
    assert state.log_frame.max() < 10
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


def test_background_events_are_poisson_and_leave_the_reference_alone() -> None:
    rate_hz, camera = 20.0, config(background_rate_hz=20.0)
    frame = np.zeros((100, 150), f32)
    state, found = play(np.stack([frame] * 31), camera)
    events = np.concatenate(found)
    expected = rate_hz * frame.size * 30 * STEP_NS * 1e-9
    assert abs(events.size - expected) < 5 * expected**0.5
    assert abs(events["pol"].sum() - expected / 2) < 5 * (expected / 4) ** 0.5
    per_pixel = np.bincount(events["y"].astype(int) * 150 + events["x"], minlength=frame.size)
    assert per_pixel.var() == pytest.approx(per_pixel.mean(), rel=0.1)
    for k, part in enumerate(found):
        assert part["t"].min() >= k * STEP_NS
        assert part["t"].max() < (k + 1) * STEP_NS
    np.testing.assert_array_equal(state.reference, frame)


def test_background_differs_between_frames_and_seeds() -> None:
    camera, still = config(background_rate_hz=20.0), np.zeros((3, 60, 60), f32)
    _, (first, second) = play(still, camera, seed=1)
    _, (other, _) = play(still, camera, seed=2)
    assert first.size
    assert second["x"].tobytes() != first["x"].tobytes()
    assert other.tobytes() != first.tobytes()


def test_pixel_mismatch_is_fixed_and_has_the_spread_asked_for() -> None:
    camera = config(0.3, sigma_threshold=0.03)
    state = initial_state(np.zeros((150, 200), f32), 0, camera, 4)
    for thresholds in (state.positive_threshold, state.negative_threshold):
        assert thresholds.mean() == pytest.approx(0.3, abs=0.001)
        assert thresholds.std() == pytest.approx(0.03, rel=0.03)
    assert np.corrcoef(state.positive_threshold, state.negative_threshold)[0, 1] == pytest.approx(0, abs=0.03)
    later, _ = step(state, np.ones((150, 200), f32), STEP_NS, camera)
    assert later.positive_threshold is state.positive_threshold


def test_carlas_mismatch_makes_pixels_stick() -> None:
    """A small draw leaves the reference behind the signal for good: CARLA's quirk, kept under its name."""
    t = np.arange(200)
    movie = np.tile((1.5 * np.sin(t / 30))[:, None, None], (1, 10, 10)).astype(f32)
    plain = sum(map(len, play(movie, config(0.3))[1]))
    carla = sum(map(len, play(movie, config(0.3, sigma_threshold=0.1, mismatch="carla"))[1]))
    pixel = sum(map(len, play(movie, config(0.3, sigma_threshold=0.1))[1]))
    assert carla < 0.7 * plain < 0.9 * pixel


def test_log_luminance_is_the_natural_logarithm_to_float32_rounding() -> None:
    luminance = np.geomspace(1e-6, 1e7, 4001, dtype=f32).reshape(1, -1)
    exact = np.log((luminance + f32(0.01)).astype(np.float64))
    found = log_luminance(luminance, 0.01)
    assert found.dtype == np.float32
    assert np.abs(found - exact).max() < 2e-6
    assert (np.diff(found[0]) >= 0).all()


def test_carla_log_follows_the_grey_table() -> None:
    image = np.array([[[0, 0, 0], [255, 255, 255], [10, 200, 30]]], np.uint8)
    grey = [0.0, 0.9999 * 255, 0.2989 * 10 + 0.587 * 200 + 0.114 * 30]
    expected = np.log(0.001 + np.array(grey) / 255)
    np.testing.assert_allclose(carla_log(image)[0], expected, atol=1e-6)
    # From black to the next grey level is 1.594 in CARLA: the reason why its nights are noisy.
    step_up = carla_log(np.array([[[0, 0, 0], [1, 1, 1]]], np.uint8))[0]
    assert step_up[1] - step_up[0] == pytest.approx(1.594, abs=1e-3)


def test_wrong_frames_and_times_are_refused() -> None:
    camera = config()
    state = initial_state(np.zeros((4, 5), f32), 100, camera, 0)
    with pytest.raises(ConfigError, match="float32"):
        step(state, np.zeros((4, 5)), 200, camera)
    with pytest.raises(ConfigError, match=r"\(4, 5\)"):
        step(state, np.zeros((5, 4), f32), 200, camera)
    with pytest.raises(ConfigError, match="later than"):
        step(state, np.zeros((4, 5), f32), 100, camera)
    with pytest.raises(ConfigError, match="C-contiguous"):
        step_counts(state, np.zeros((4, 5), f32), 200, camera, np.zeros((5, 4, 2), np.uint8))
