"""Glare: veils of the sun and of lamps, alike for every sensor behind the lens."""

from __future__ import annotations

import math

import numpy as np
import pytest
from camera_scenes import NIGHT, renderer, snapshot, vehicle

from pedcross_env.camera import camera_pose
from pedcross_env.camera.glare import BRIGHTER, GLARE_LX_DEG2, Glare
from pedcross_env.camera.light import LUMA, light_of
from pedcross_env.config import CameraConfig
from pedcross_env.weather import WEATHERS, Weather

WIDTH, HEIGHT = 450, 256
POSE = camera_pose(CameraConfig(), snapshot().ego)
LOW = Weather(sun_altitude_deg=7.0, sun_azimuth_deg=0.0)
SUN_ROW = POSE.cy - POSE.focal_px * math.tan(math.radians(7.0))


def glared(weather, picture=None, alpha=0.0, channels=3):
    luminance = np.zeros((HEIGHT, WIDTH), np.float32) if picture is None else picture.astype(np.float32)
    out = np.stack([luminance] * channels)
    cover = np.full((HEIGHT, WIDTH), alpha, np.float32)
    luminance = luminance.copy()
    glare = Glare(WIDTH, HEIGHT)
    glare.load(light_of(weather))
    glare.add(out, luminance, cover, POSE)
    return out, luminance


def test_the_veil_of_the_sun_falls_with_the_square_of_the_angle():
    _, luminance = glared(LOW)
    sun_lx = float((light_of(LOW).sun_lx * LUMA).sum())
    for degrees in (5.0, 10.0, 16.0):
        row = round(SUN_ROW + POSE.focal_px * math.tan(math.radians(degrees)) - 0.5)
        distance_px = math.hypot(row + 0.5 - SUN_ROW, 0.5)
        expected = GLARE_LX_DEG2 * sun_lx / math.degrees(distance_px / POSE.focal_px) ** 2
        assert luminance[row, 225] == pytest.approx(expected, rel=0.1)


def test_about_three_per_cent_of_the_light_is_scattered():
    share = GLARE_LX_DEG2 * math.radians(1) ** 2 * 2 * math.pi * math.log(60 / 0.5)
    assert 0.02 < share < 0.04


def test_the_suns_disc_has_the_suns_light():
    _, luminance = glared(LOW)
    rows, columns = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    near = np.hypot(rows - SUN_ROW, columns - POSE.cx) < 4
    lux = luminance[near].sum() / POSE.focal_px**2
    assert lux == pytest.approx(float((light_of(LOW).sun_lx * LUMA).sum()), rel=0.05)


@pytest.mark.parametrize(
    "weather",
    [
        Weather(),
        Weather(sun_altitude_deg=7.0, sun_azimuth_deg=180.0),
        WEATHERS["sunset"],
        Weather(cloudiness=1.0),
    ],
    ids=["noon", "from behind", "behind houses", "overcast"],
)
def test_without_a_sun_before_the_lens_pictures_keep_their_bytes(weather):
    picture = np.full((HEIGHT, WIDTH), 3000.0)
    out, luminance = glared(weather, picture, alpha=1.0)
    assert (out == 3000.0).all()
    assert (luminance == 3000.0).all()


def test_whoever_hides_the_sun_takes_its_veil_away():
    veils = [float(glared(LOW, alpha=a)[1][200].mean()) for a in (0.0, 0.5, 1.0)]
    assert veils[2] == 0.0
    assert veils[1] == pytest.approx(0.5 * veils[0], rel=1e-3)


def night_with_lamp(x: float, level: float = 5000.0) -> np.ndarray:
    """A lamp of 3 by 3 pixels whose left side is at ``x``, drawn by exact areas."""
    columns = np.arange(WIDTH)
    cover = np.clip(np.minimum(columns + 1, x + 3) - np.maximum(columns, x), 0, 1)
    picture = np.full((HEIGHT, WIDTH), 0.2)
    picture[100:103] += level * cover
    return picture


def test_a_lamp_veils_as_its_light_at_the_lens_says():
    _, luminance = glared(NIGHT, night_with_lamp(220.0))
    lux = 9 * 5000.0 / POSE.focal_px**2
    degrees = math.degrees(60.0 / POSE.focal_px)
    assert luminance[161, 221] - 0.2 == pytest.approx(GLARE_LX_DEG2 * lux / degrees**2, rel=0.1)


def test_the_veil_of_a_moving_lamp_changes_smoothly():
    veils = [glared(NIGHT, night_with_lamp(float(x)))[1] for x in np.arange(220.0, 240.0, 0.25)]
    away = np.s_[120:250, 150:300]
    logs = np.log(np.array([veil[away] for veil in veils]))
    assert np.abs(np.diff(logs, axis=0)).max() < 0.03
    leaving = [glared(NIGHT, night_with_lamp(float(x)))[1][110:140, 380:].mean() for x in np.arange(380, 452)]
    assert np.abs(np.diff(np.log(leaving))).max() < 0.15
    assert leaving[-1] == pytest.approx(0.2)


def test_luminance_alone_gets_the_luminance_of_the_coloured_veil():
    for weather in (WEATHERS["low_sun"], NIGHT):
        camera = renderer(weather)
        scene = snapshot(vehicle(13, 40.0, 1.75, yaw=math.pi, seed=4, headlight=1.0), headlight=1.0)
        full, alone = camera.render(scene), camera.render(scene, luminance_only=True)
        np.testing.assert_allclose(full.luminance, np.tensordot(LUMA, full.radiance, 1), rtol=2e-5)
        np.testing.assert_allclose(alone.luminance, full.luminance, rtol=1e-4)


def test_ordinary_brightness_has_no_veil_of_its_own():
    white = 0.5 * BRIGHTER * 15.0 / math.pi
    out, _ = glared(NIGHT, np.full((HEIGHT, WIDTH), white))
    assert (out == np.float32(white)).all()
