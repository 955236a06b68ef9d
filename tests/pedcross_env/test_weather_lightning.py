"""Lightning: functions of seed and time, alike for every camera."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Scenario
from pedcross_env.weather import Lightning, Weather, make_weather

STORM = Weather(lightning_per_min=30.0)


def curve(lightning: Lightning, start_s: float, end_s: float, step_s: float = 1e-4) -> np.ndarray:
    return np.array([lightning.light_lx(float(t)) for t in np.arange(start_s, end_s, step_s)])


def flash_times(lightning: Lightning, end_s: float) -> list[float]:
    """Begins of what is lit after half a second of darkness or more, to 10 ms."""
    grid = np.arange(0.0, end_s, 0.01)
    lit = np.array([not lightning.dark(float(t), float(t) + 0.01) for t in grid])
    starts = np.flatnonzero(lit & ~np.concatenate([[True], lit[:-1]]))
    return [float(grid[k]) for k in starts]


def test_the_mean_over_an_exposure_is_the_mean_of_the_moments() -> None:
    lightning = Lightning(STORM, 3)
    begin = flash_times(lightning, 60.0)[0]
    for start, end in ((begin, begin + 0.05), (begin + 0.02, begin + 0.15)):
        moments = curve(lightning, start, end, 2e-5).mean()
        assert lightning.mean_lx(start, end) == pytest.approx(moments, rel=0.02)
        assert moments > 0
    assert lightning.mean_lx(begin + 0.01, begin + 0.01) == lightning.light_lx(begin + 0.01)


def test_flashes_come_at_their_rate_in_a_range_of_brightness_and_shine_briefly() -> None:
    lightning = Lightning(Weather(lightning_per_min=6.0), 5)
    times = flash_times(lightning, 1800.0)
    # A Poisson number of mean 180, a few of which merge.
    assert 130 < len(times) < 220
    peaks = [curve(lightning, t, t + 0.02).max() for t in times[:40]]
    assert min(peaks) < 300 < 1000 < max(peaks) < 8000
    for t in times[:10]:
        assert lightning.dark(t + 3.9, t + 3.95) or any(t < other < t + 3.95 for other in times)


def test_light_rises_within_a_millisecond_and_returns_in_strokes() -> None:
    lightning = Lightning(STORM, 1)
    strokes = []
    for begin in flash_times(lightning, 40.0):
        light = curve(lightning, begin, begin + 0.5)
        rises = np.flatnonzero((light[1:-1] > light[:-2]) & (light[1:-1] >= light[2:]))
        strokes.append(len(rises))
        first = rises[0] + 1
        assert light[max(0, first - 20)] < 0.05 * light[first]
    assert 2 < np.mean(strokes) < 7


def test_same_seed_same_flashes_in_any_order_of_asking() -> None:
    one, again, other = Lightning(STORM, 4), Lightning(STORM, 4), Lightning(STORM, 5)
    times = np.linspace(0, 30, 700)
    forwards = [one.light_lx(float(t)) for t in times]
    backwards = [again.light_lx(float(t)) for t in times[::-1]]
    assert forwards == backwards[::-1]
    assert forwards != [other.light_lx(float(t)) for t in times]


def test_without_lightning_it_is_dark_and_bad_exposures_are_refused() -> None:
    calm = Lightning(Weather(), 1)
    assert calm.dark(0.0, 100.0)
    assert calm.mean_lx(0.0, 1.0) == calm.light_lx(0.5) == 0.0
    with pytest.raises(ConfigError, match="start_s"):
        Lightning(STORM, 1).mean_lx(1.0, 0.5)


def test_a_flash_forces_sub_frames_and_both_cameras_see_it() -> None:
    weather = make_weather(
        sun_altitude_deg=-30.0, street_lamps=True, headlights=True, lightning_per_min=40.0, cloudiness=1.0
    )
    env = CrossingEnv({"weather": (weather,), "camera": {"width_px": 48, "height_px": 32}})
    env.reset(seed=2, options={"scenario": Scenario(name="still", ego_speed_mps=0.0)})
    lightning = env._vision._view.lightning  # type: ignore[union-attr]
    quiet, struck = [], []
    for _ in range(150):
        start = env.world.time_s
        observation, *_, info = env.step(np.zeros(1, np.float32))
        if lightning.dark(start, env.world.time_s):
            quiet.append((info["subframes"], int(observation["dvs"].sum())))
        elif max(curve(lightning, start, env.world.time_s)) > 30.0 + 20 * lightning.light_lx(start):
            frame = env.sight.frame  # type: ignore[union-attr]
            struck.append((info["subframes"], int(observation["dvs"].sum()), frame.airlight))
    assert quiet
    assert struck
    assert max(n for n, _ in quiet) == 1
    assert min(n for n, *_ in struck) > 3
    assert min(events for _, events, _ in struck) > 48 * 32 > max(events for _, events in quiet)
    assert max(air for *_, air in struck) > 3 / math.pi
