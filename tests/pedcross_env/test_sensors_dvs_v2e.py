"""The model ``v2e`` against v2e's recorded answers, its rule in plain NumPy, and the stated statistics of its noise."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from dvs_movies import STEP_NS, config, f32, play, smooth_sequence

from pedcross_env.sensors.dvs import initial_state, step_counts
from pedcross_env.sensors.intensity import lin_log

V2E = Path(__file__).parents[2].parent / "shared/realdata/v2e"


@pytest.mark.skipif(not V2E.is_dir(), reason="v2e's recorded counts (../shared/realdata/v2e) are not here")
@pytest.mark.parametrize("model", ["v2e", "pedcross", "carla"])
@pytest.mark.parametrize("name", ["c05_05", "c20_20", "c30_18"])
def test_counts_equal_those_of_v2e_for_every_pixel_polarity_and_frame(name: str, model: str) -> None:
    """All rules count how many thresholds fit between the reference and the frame; their times differ."""
    recorded = np.load(V2E / f"{name}.npz")
    movie = recorded["log_frames"]
    camera = config(
        model=model,
        positive_threshold=float(recorded["theta_on"]),
        negative_threshold=float(recorded["theta_off"]),
    )
    state = initial_state(movie[0], 0, camera, 0)
    assert not recorded["counts"][0].any()
    for k in range(1, len(movie)):
        counts = np.zeros((*movie.shape[1:], 2), np.uint8)
        state = step_counts(state, movie[k], round(k * 1e9 / float(recorded["fps"])), camera, counts)
        np.testing.assert_array_equal(counts[..., 1], recorded["counts"][k, 0], f"OFF, frame {k}")
        np.testing.assert_array_equal(counts[..., 0], recorded["counts"][k, 1], f"ON, frame {k}")


def grey_level(log_frame: np.ndarray) -> np.ndarray:
    return np.where(log_frame <= math.log(20), log_frame * 20 / math.log(20), np.exp(log_frame))


def v2e_oracle(
    movie: np.ndarray, theta: float, cutoff_hz: float, refractory_s: float
) -> list[tuple[int, int, float, bool]]:
    """v2e's rule in float64: filter, whole thresholds, evenly spread times, refractory period; (x, y, t in s, ON)."""
    dt = STEP_NS * 1e-9
    followed = base = movie[0].astype(float)
    last = np.zeros(base.shape)
    out = []
    for frame in range(1, len(movie)):
        light = (grey_level(movie[frame].astype(float)) + 20) / 275
        eps = np.minimum(1, light * dt * 2 * math.pi * cutoff_hz) if cutoff_hz else 1.0
        followed = (1 - eps) * followed + eps * movie[frame]
        away = followed - base
        number = np.floor(np.abs(away) / theta).astype(int)
        most = max(1, number.max())
        base = base.copy()
        for k in range(1, most + 1):
            t = ((frame - 1) + k / most) * dt
            for y, x in np.argwhere(number >= k):
                if refractory_s <= dt / most or t - last[y, x] > refractory_s:
                    last[y, x] = t
                    out.append((int(x), int(y), t, bool(away[y, x] > 0)))
                    base[y, x] += theta * np.sign(away[y, x])
    return out


@pytest.mark.parametrize(
    ("cutoff_hz", "refractory_ns"), [(0.0, 0), (12.0, 0), (0.0, 5_000_000), (40.0, 9_000_000)]
)
def test_events_equal_v2es_rule(cutoff_hz: float, refractory_ns: int) -> None:
    movie = (smooth_sequence(6, frames=10) + 3.5).astype(f32)
    camera = config(0.15, model="v2e", cutoff_hz=cutoff_hz, refractory_ns=refractory_ns)
    found = np.concatenate(play(movie, camera)[1])
    expected = v2e_oracle(movie, float(f32(0.15)), cutoff_hz, refractory_ns * 1e-9)
    assert len(found) == len(expected) > 300
    ours = sorted((int(e["y"]), int(e["x"]), round(int(e["t"]) / 1e4), bool(e["pol"])) for e in found)
    theirs = sorted((y, x, round(t * 1e5), on) for x, y, t, on in expected)
    wrong = [
        a for a, b in zip(ours, theirs, strict=True) if (a[:2], a[3]) != (b[:2], b[3]) or abs(a[2] - b[2]) > 1
    ]
    assert wrong == []


def test_leak_has_its_rate() -> None:
    camera = config(0.2, model="v2e", leak_hz=3.0)
    still = np.zeros((61, 60, 80), f32)
    events = np.concatenate(play(still, camera)[1])
    assert events["pol"].all()
    assert events.size == pytest.approx(3.0 * 60 * STEP_NS * 1e-9 * 4800, rel=0.05)


@pytest.mark.parametrize("grey", [10, 200])
def test_shot_noise_has_its_rate_by_light_and_polarity(grey: int) -> None:
    """p = R / 2 dt (1 - .75 (DN + 20) / 275) per polarity and frame; counts within four standard deviations."""
    camera = config(0.2, model="v2e", shot_hz=6.0)
    frame = lin_log(np.full((90, 120), grey, np.uint8))
    events = np.concatenate(play(np.stack([frame] * 31), camera)[1])
    chance = 3.0 * STEP_NS * 1e-9 * (1 - 0.75 * (grey + 20) / 275)
    draws = 30 * frame.size
    for polarity in (False, True):
        number = np.count_nonzero(events["pol"] == polarity)
        assert abs(number - draws * chance) < 4 * math.sqrt(draws * chance * (1 - chance))


def test_noisier_with_lower_thresholds() -> None:
    camera = config(0.2, model="v2e", shot_hz=20.0, sigma_threshold=0.05)
    frame = np.zeros((90, 120), f32)
    state, found = play(np.stack([frame] * 31), camera)
    events = np.concatenate(found)
    on = events[events["pol"]]
    per_pixel = np.bincount(on["y"].astype(int) * 120 + on["x"], minlength=frame.size)
    expected = 10.0 * (1 - 0.75 * 20 / 275) * 30 * STEP_NS * 1e-9 * (0.2 / state.positive_threshold)
    low = state.positive_threshold < 0.15
    for pixels in (low, ~low):
        assert abs(per_pixel[pixels].sum() - expected[pixels].sum()) < 4 * math.sqrt(expected[pixels].sum())


def test_lin_log_is_linear_to_twenty_and_logarithmic_above() -> None:
    grey = np.arange(256, dtype=np.uint8)[None]
    found = lin_log(grey)[0]
    np.testing.assert_allclose(found[:21], np.arange(21) * math.log(20) / 20, atol=1e-6)
    np.testing.assert_allclose(found[21:], np.log(np.arange(21, 256)), atol=1e-6)
    np.testing.assert_allclose(grey_level(found), grey[0], atol=1e-3)
    np.testing.assert_array_equal(lin_log(np.repeat(grey[..., None], 3, axis=2)), lin_log(grey))
