"""Clouds: as many as asked for, of the sky's mean light, fixed to directions; and snow on what faces up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from camera_scenes import renderer, snapshot, vehicle

from pedcross_env.camera import camera_pose
from pedcross_env.camera.clouds import CLOUD_COLUMNS, CLOUD_ROWS, cloud_texture, directions
from pedcross_env.camera.kernels.lighting import SNOW, sky_radiance
from pedcross_env.camera.light import LUMA, light_of
from pedcross_env.camera.sky import Sky
from pedcross_env.camera.snow import SNOW_ALBEDO
from pedcross_env.contracts import StaticClass
from pedcross_env.weather import Weather

SOME = (0.05, 0.3, 0.6, 0.9, 1.0)


@pytest.mark.parametrize("cloudiness", SOME)
def test_clouds_keep_the_skys_mean_light_and_cover_what_is_asked(cloudiness: float) -> None:
    for seed in range(3):
        factor, more = cloud_texture(cloudiness, seed)
        assert float(factor.mean()) == pytest.approx(1.0, abs=1e-4)
        assert factor.min() > 0
        assert float((more[CLOUD_ROWS // 4 :] > 0.5 - cloudiness).mean()) == pytest.approx(
            cloudiness, abs=0.16
        )


def test_fair_weather_clouds_are_bright_on_top_and_darker_below() -> None:
    """Low in the sky, where they are seen from the side: the highest and lowest nodes of runs of covered rows."""
    difference = []
    for seed in range(4):
        factor, more = cloud_texture(0.05, seed)
        covered = more[20:90] > 0.5
        above, below = np.roll(covered, -1, axis=0), np.roll(covered, 1, axis=0)
        inside = covered & above & below
        tops, bases = inside & ~np.roll(above, -1, axis=0), inside & ~np.roll(below, 1, axis=0)
        assert tops.sum() > 100
        difference.append(factor[20:90][tops].mean() - factor[20:90][bases].mean())
        assert factor[20:90][bases].mean() > 1.2
    assert min(difference) > 0.1


def test_what_is_known_of_clouds_grows_with_what_is_free_of_them() -> None:
    """Columns that come free one after the other get what they get all at once."""
    camera = renderer(Weather(cloudiness=0.5))
    pose, env = camera_pose(camera.config, snapshot().ego), np.zeros(64)
    env[18:24] = 100.0
    pictures = []
    for spans in ([(0, 450)], [(200, 230), (300, 310), (20, 40), (0, 450)]):
        sky, light = Sky(camera.config), light_of(Weather(cloudiness=0.5))
        sky.load(Weather(cloudiness=0.5), light, 1)
        for first, last in spans:
            out, alpha = np.zeros((1, 256, 450), np.float32), np.ones((256, 450), np.float32)
            alpha[:, first:last] = 0.0
            sky.add_clouds(out, alpha, pose, env, light)
            assert not out[:, :, :first].any()
            assert not out[:, :, last:].any()
        pictures.append(out)
    assert pictures[0].std() > 1.0
    np.testing.assert_array_equal(*pictures)


def test_an_empty_sky_is_even_and_a_closed_one_nearly_so() -> None:
    assert (cloud_texture(0.0, 1)[0] == 1.0).all()
    spread = [float(cloud_texture(cloudiness, 1)[0].std()) for cloudiness in (0.5, 1.0)]
    assert 0.02 < spread[1] < spread[0]


def test_directions_are_unit_vectors_all_round() -> None:
    x, y, z = directions()
    np.testing.assert_allclose(x * x + y * y + z * z, 1.0, rtol=1e-12)
    angles = np.unwrap(np.arctan2(y[0], x[0]))
    assert (np.diff(angles) > 0).all()
    assert angles[-1] - angles[0] == pytest.approx(2 * np.pi * (1 - 1 / CLOUD_COLUMNS), rel=1e-2)


def sky_of(weather: Weather, **ego: float) -> tuple[np.ndarray, np.ndarray]:
    frame = renderer(weather).render(snapshot(**ego))
    return frame.luminance, frame.instance == StaticClass.SKY


def test_clouds_belong_to_directions() -> None:
    """Driving on, in minutes or metres, leaves them where they are; a turn of the car moves them all alike."""
    weather = Weather(cloudiness=0.5)
    (first, sky), (later, still) = sky_of(weather, x=0.0), sky_of(weather, x=3.0)
    both = sky & still & np.roll(sky & still, 3, axis=1) & np.roll(sky & still, -3, axis=1)  # clear of edges
    both &= np.roll(both, 3, axis=0) & np.roll(both, -3, axis=0)
    assert both.sum() > 1500
    assert (
        np.isclose(later[both], first[both], rtol=1e-3).mean() > 0.97
    )  # the rest: twigs too thin to own a pixel
    assert first[both].std() > 0.05 * first[both].mean()


def test_a_static_view_of_clouds_makes_no_events() -> None:
    camera = renderer(Weather(cloudiness=0.5))
    first, second = (camera.render(snapshot(), luminance_only=True).luminance for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_all_round_the_view_the_sky_is_as_bright_as_without_clouds() -> None:
    """Mean over yaws of the middle columns' sky against the gradient that the light prescribes."""
    weather = Weather(cloudiness=0.6)
    camera = renderer(weather, width_px=96, height_px=64, pitch_deg=-20.0, horizontal_fov_deg=60.0)
    shares = []
    for k in range(12):
        scene = snapshot(x=500.0, yaw=2 * np.pi * k / 12)  # beyond the street's houses
        with_clouds = camera.render(scene)
        plain_camera = renderer(
            Weather(), width_px=96, height_px=64, pitch_deg=-20.0, horizontal_fov_deg=60.0
        )
        plain_camera.load(camera._street, weather)
        plain_camera._sky.load(Weather(cloudiness=0.0), light_of(Weather()), 0)
        plain = plain_camera.render(scene)
        sky = (plain.instance == StaticClass.SKY) & (plain.depth > 1e6)
        shares.append(with_clouds.luminance[sky].mean() / plain.luminance[sky].mean())
    assert float(np.mean(shares)) == pytest.approx(1.0, abs=0.12)
    assert np.std(shares) > 0.01


def test_colour_and_luminance_have_the_same_clouds() -> None:
    camera = renderer(Weather(cloudiness=0.4))
    full, alone = camera.render(snapshot()), camera.render(snapshot(), luminance_only=True)
    np.testing.assert_allclose(alone.luminance, full.luminance, rtol=1e-4)


def test_snow_whitens_what_faces_up() -> None:
    """A car's roof sends the snow's albedo of the sky's light, as white as its paint may be; its glass stays dark."""
    weather = Weather(cloudiness=1.0, snow_cover=1.0)
    assert tuple(SNOW_ALBEDO) == SNOW
    white = float((light_of(weather).sky_lx * SNOW_ALBEDO * LUMA).sum()) / np.pi
    shares = []
    for cover in (0.0, 1.0):
        camera = renderer(replace(weather, snow_cover=cover), pitch_deg=25.0, mount_z_m=3.5)
        frame = camera.render(snapshot(vehicle(5, 11.0, -1.75, seed=3)))
        car = frame.luminance[frame.instance == 5]
        shares.append(float(np.isclose(car, white, rtol=0.08).mean()))
        assert (car < 0.3 * white).mean() > 0.1
    assert shares[1] > 0.1 > 5 * shares[0]


def test_nodes_follow_the_focal_length_and_the_sky_needs_no_clouds() -> None:
    camera = renderer(Weather())
    sky = Sky(camera.config)
    out = np.ones((1, 256, 450), np.float32)
    sky.load(Weather(cloudiness=0.0), light_of(Weather()), 1)
    sky.add_clouds(out, out[0], None, None, None)  # nothing is asked of them
    assert (out == 1.0).all()
    env = np.zeros(46)
    env[18:21] = 5.0
    assert sky_radiance(1.0, env, 1) == 5.0
