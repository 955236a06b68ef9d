"""The model ``carla`` against CARLA's rule transcribed word for word."""

from __future__ import annotations

import numpy as np
import pytest
from dvs_movies import STEP_NS, config, f32, play, smooth_sequence

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import ConfigError
from pedcross_env.sensors.dvs import initial_state, step
from pedcross_env.sensors.dvs_config import DvsConfig, dvs_preset
from pedcross_env.sensors.intensity import carla_log


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
    _, found = play(movie, config(threshold, model="carla", refractory_ns=refractory_ns))
    events = np.concatenate(found)
    assert expected.size > 300
    np.testing.assert_array_equal(events, expected)


def test_unequal_thresholds_equal_carlas_rule() -> None:
    movie = smooth_sequence(5)
    _, found = play(movie, config(model="carla", positive_threshold=0.11, negative_threshold=0.23))
    np.testing.assert_array_equal(np.concatenate(found), carla_oracle(movie, 0.11, 0.23, 0))


def test_refractory_period_hides_events_but_moves_the_reference() -> None:
    movie = smooth_sequence(1)
    free = play(movie, config(0.05, model="carla"))
    held = play(movie, config(0.05, model="carla", refractory_ns=3_000_000))
    assert sum(map(len, held[1])) < sum(map(len, free[1]))
    np.testing.assert_array_equal(held[0].reference, free[0].reference)


def test_thresholds_drawn_in_every_frame_make_pixels_stick() -> None:
    """A small draw leaves the reference behind the signal for good: CARLA's quirk, kept in its model alone."""
    t = np.arange(200)
    movie = np.tile((1.5 * np.sin(t / 30))[:, None, None], (1, 10, 10)).astype(f32)
    plain = sum(map(len, play(movie, config(0.3, model="carla"))[1]))
    carla = sum(map(len, play(movie, config(0.3, sigma_threshold=0.1, model="carla"))[1]))
    ours = sum(map(len, play(movie, config(0.3, sigma_threshold=0.1))[1]))
    assert carla < 0.7 * plain < 0.9 * ours


def test_ours_without_noise_makes_carlas_events() -> None:
    """On the same frames both find the same crossings; they differ by rounding alone."""
    movie = smooth_sequence(8, frames=12)
    ours, carla = (
        np.concatenate(play(movie, config(0.2, model=model))[1]) for model in ("pedcross", "carla")
    )
    assert len(ours) == len(carla) > 500
    for events in (ours, carla):
        events.sort(order=("y", "x", "t"))
    for name in ("x", "y", "pol"):
        np.testing.assert_array_equal(ours[name], carla[name])
    apart = np.abs(ours["t"] - carla["t"])  # float32 rounding of a level, over the slope
    assert np.quantile(apart, 0.99) < 200
    assert apart.max() < 5_000


def test_carla_log_follows_the_grey_table() -> None:
    image = np.array([[[0, 0, 0], [255, 255, 255], [10, 200, 30]]], np.uint8)
    grey = [0.0, 0.9999 * 255, 0.2989 * 10 + 0.587 * 200 + 0.114 * 30]
    expected = np.log(0.001 + np.array(grey) / 255)
    np.testing.assert_allclose(carla_log(image)[0], expected, atol=1e-6)
    # From black to the next grey level is 1.594 in CARLA: the reason why its nights are noisy.
    step_up = carla_log(np.array([[0, 1]], np.uint8))[0]
    assert step_up[1] - step_up[0] == pytest.approx(1.594, abs=1e-3)


def test_linear_mode_compares_grey_levels() -> None:
    camera = DvsConfig(model="carla", positive_threshold=10.0, negative_threshold=10.0)
    state = initial_state(np.full((1, 1), 100, f32), 0, camera, 0)
    _, events = step(state, np.full((1, 1), 135, f32), STEP_NS, camera)
    assert events["t"].tolist() == pytest.approx([STEP_NS * k / 3.5 for k in (1, 2, 3)], abs=4)


def test_the_model_has_no_noise_and_says_so() -> None:
    assert dvs_preset("carla").shot_hz == 0
    with pytest.raises(ConfigError, match=r"leak_hz = 0.1 .*model = 'pedcross'"):
        dvs_preset("carla", leak_hz=0.1)
