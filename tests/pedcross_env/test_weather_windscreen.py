"""Drops on the windscreen: as many as strike it, wiped by the blade, the same for both cameras, and an option."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pedcross_env.camera import CameraPose
from pedcross_env.config import CameraConfig, EnvConfig, WindscreenConfig
from pedcross_env.contracts import Frame
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.weather import Weather, Windscreen
from pedcross_env.weather._windscreen_kernels import wiped_s
from pedcross_env.weather.precipitation import drop_density_per_m3_mm, fall_speed_mps
from pedcross_env.weather.windscreen import drops_per_m2_s, wiper_period_s

WIDTH, HEIGHT, FOCAL = 225, 128, 195.0
SMALL = {"width_px": 64, "height_px": 36}
DROPS = WindscreenConfig(drops=True)


POSE = CameraPose(np.zeros(3), np.eye(3), FOCAL, 0.5 * WIDTH, 0.5 * HEIGHT, WIDTH, HEIGHT)


def scene() -> Frame:
    """Bright above, dark below."""
    luminance = np.repeat(np.linspace(900.0, 100.0, HEIGHT, dtype=np.float32)[:, None], WIDTH, axis=1)
    return Frame(luminance.copy(), np.stack([luminance] * 3), None, None, 1000.0)


def glass(
    rain_mm_h: float = 12.0, speed_mps: float = 10.0, until_s: float = 8.0, wiper: str = "auto"
) -> Windscreen:
    config = WindscreenConfig(drops=True, wiper=wiper)  # type: ignore[arg-type]
    screen = Windscreen(Weather(rain_mm_h=rain_mm_h), config, 5)
    for k in range(round(until_s * 30) + 1):
        screen.drive(k / 30, speed_mps)
    return screen


def changed(screen: Windscreen, time_s: float) -> np.ndarray:
    frame, plain = scene(), scene()
    screen.draw(frame, POSE, time_s)
    return np.asarray(np.abs(frame.luminance / plain.luminance - 1.0) > 0.02)


def test_the_rate_of_drops_is_marshall_and_palmers_flux() -> None:
    """Standing: number times fall speed over all sizes; the closed form takes one speed for all."""
    sizes = np.linspace(0.8, 8.0, 4001)
    number = np.array([drop_density_per_m3_mm(float(d), 12.0) for d in sizes])
    slope = math.cos(math.radians(35.0))
    falling = np.trapezoid(number * [fall_speed_mps(float(d)) for d in sizes], sizes) * slope
    assert drops_per_m2_s(12.0, 0.0) == pytest.approx(falling, rel=0.1)
    driven = np.trapezoid(number, sizes) * 10.0 * math.sin(math.radians(35.0))
    assert drops_per_m2_s(12.0, 10.0) - drops_per_m2_s(12.0, 0.0) == pytest.approx(driven, rel=0.01)


def test_more_rain_and_speed_make_more_drops_and_wiping_leaves_fewer() -> None:
    def mean(screen: Windscreen) -> float:
        return float(np.mean([screen.draw(scene(), POSE, t) for t in np.arange(2.0, 8.0, 0.37)]))

    counts = [mean(glass(rate, wiper="off")) for rate in (1.0, 5.0, 20.0)]
    assert 0 < counts[0] < counts[1] < counts[2]
    assert mean(glass(5.0, speed_mps=20.0, wiper="off")) > 1.2 * counts[1]
    assert mean(glass(20.0)) < 0.4 * counts[2]
    area_m2 = WIDTH * HEIGHT / (FOCAL / 0.10) ** 2
    assert counts[1] == pytest.approx(
        drops_per_m2_s(5.0, 10.0) * area_m2 * 6.0, rel=0.35
    )  # 6 s; some half in view


def test_the_blade_clears_what_it_passes() -> None:
    """Right behind the blade the glass is bare; the blade itself is dark."""
    screen = glass(30.0)
    times = np.arange(4.0, 6.0, 0.005)
    angles = [screen.blade_angle(float(t)) for t in times]
    passing = [k for k, a in enumerate(angles) if a is not None and abs(a) < 0.6]
    sweep = next(k for k in passing if k + 1 not in passing)  # the end of the first pass that is seen
    assert changed(screen, float(times[sweep + 4])).mean() < 0.01
    drops = max(changed(screen, float(t)).mean() for t, a in zip(times, angles, strict=True) if a is None)
    assert drops > 0.03
    seen = scene()
    over = min(range(len(times)), key=lambda k: 9.0 if angles[k] is None else abs(angles[k] - 0.43))
    screen.draw(seen, POSE, float(times[over]))
    assert (seen.luminance < 0.2 * scene().luminance).mean() > 0.03


def test_a_place_is_wiped_when_the_blade_is_there() -> None:
    screen = glass()
    wiper = screen._wiper
    for angle in (-0.7, -0.1, 0.4):
        for now in np.arange(3.0, 6.0, 0.13):
            when = wiped_s(float(now), angle, wiper)
            assert now - wiper[0] - 1e-9 <= when <= now
            assert screen.blade_angle(when) == pytest.approx(angle, abs=1e-6)
    assert wiped_s(5.0, 1.2, wiper) < 0  # beyond the blade's reach
    assert [wiper_period_s(rate) for rate in (0.5, 3.0, 8.0, 50.0)] == [8.0, 4.0, 2.0, 1.0]


def test_luminance_and_radiance_and_a_second_glass_of_the_seed_get_the_same_drops() -> None:
    screen, twin = glass(20.0), glass(20.0)
    for time_s in (3.3, 4.1, 6.02):
        frame, again = scene(), scene()
        assert screen.draw(frame, POSE, time_s) == twin.draw(again, POSE, time_s)
        np.testing.assert_array_equal(frame.luminance, again.luminance)
        assert frame.radiance is not None
        np.testing.assert_allclose(frame.radiance[1], frame.luminance, rtol=1e-5)


def test_a_drop_stays_where_it_is_between_sub_frames() -> None:
    """Within 2 ms nothing moves or pops but the blade: the picture changes by little while the blade rests."""
    screen = glass(20.0)
    quiet = [t for t in np.arange(4.0, 6.0, 0.1) if screen.blade_angle(float(t)) is None]
    for t in quiet[:8]:
        first, second = changed(screen, float(t)), changed(screen, float(t) + 0.002)
        assert (first != second).mean() < 0.01


def pictures(weather: str, windscreen: WindscreenConfig, steps: int = 6) -> list[np.ndarray]:
    env = CrossingEnv(EnvConfig(camera=CameraConfig(**SMALL), weather=(weather,), windscreen=windscreen))
    env.reset(seed=4)
    taken = []
    for _ in range(steps):
        observation, *_ = env.step(np.zeros(1, np.float32))
        taken += [observation["rgb"], observation["dvs"]]
    return taken


def test_they_are_an_option_that_changes_nothing_unless_it_rains() -> None:
    assert not EnvConfig().windscreen.drops
    for weather, same in (("clear", True), ("storm", False)):
        plain, dropped, again = (pictures(weather, screen) for screen in (WindscreenConfig(), DROPS, DROPS))
        assert all(np.array_equal(a, b) for a, b in zip(plain, dropped, strict=True)) == same
        assert all(np.array_equal(a, b) for a, b in zip(dropped, again, strict=True))


def test_a_moment_that_was_kept_goes_on_with_the_same_drops() -> None:
    env = CrossingEnv({"weather": ["storm"], "camera": SMALL, "windscreen": {"drops": True}})
    env.reset(seed=4)
    for _ in range(4):
        env.step(np.zeros(1, np.float32))
    kept = env.save_state()
    first = [env.step(np.zeros(1, np.float32))[0] for _ in range(3)]
    env.load_state(kept)
    second = [env.step(np.zeros(1, np.float32))[0] for _ in range(3)]
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a["rgb"], b["rgb"])
        np.testing.assert_array_equal(a["dvs"], b["dvs"])


def test_an_unknown_wiper_is_refused() -> None:
    with pytest.raises(ConfigError, match="auto"):
        WindscreenConfig(wiper="aut")  # type: ignore[arg-type]
