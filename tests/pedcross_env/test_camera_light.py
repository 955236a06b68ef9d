"""Radiance: fog's law, the light's sources, smoothness, and one truth for colour and luminance."""

import dataclasses
import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from camera_scenes import NIGHT, STREET, pedestrian, renderer, snapshot, vehicle

from pedcross_env.camera import camera_pose, rays
from pedcross_env.camera.kernels.lighting import beam_candela, lamp_candela
from pedcross_env.camera.light import (
    flashed,
    high_beam_table,
    light_of,
    low_beam_table,
    sky_illuminance_lx,
    sun_illuminance_lx,
)  # fmt: skip
from pedcross_env.camera.people import person_of
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.contracts import StaticClass
from pedcross_env.weather.weather import Weather

FOG = Weather(visibility_m=60.0, cloudiness=1.0)
LUMA = np.array([0.2126, 0.7152, 0.0722])


def crowd():
    return [
        vehicle(10, 14.0, -4.6, seed=3), vehicle(13, 40.0, 1.75, yaw=math.pi, seed=4, headlight=1.0, model=1),
        vehicle(14, 33.0, -1.75, brake_light=1.0, headlight=1.0, model=3, length=5.2, width=2.0, height=2.2),
        pedestrian(20, 18.0, -0.5, gait_stride=1.4, gait_phase=0.1),
        pedestrian(21, 19.0, 2.4, model=1, height=1.2, seed=2),
    ]  # fmt: skip


def test_contrast_of_black_cloth_in_fog_follows_koschmieder(monkeypatch):
    someone = person_of(0, 0, 1.75)
    body = someone.body.copy()
    body[:, 10:14] = 0.0
    black = replace(someone, body=body)
    monkeypatch.setattr("pedcross_env.camera.actor_tables.person_of", lambda *looks: black)
    camera = renderer(FOG, width_px=900, height_px=512)
    beta, air = FOG.extinction_per_m, light_of(FOG).airlight
    for distance in (6.0, 15.0, 30.0):
        frame = camera.render(snapshot(pedestrian(5, distance, -1.75)))
        inside = frame.instance == 5
        core = cv2.erode(inside.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        contrast = (frame.luminance[core] - air) / air
        assert core.sum() >= 10
        np.testing.assert_allclose(-contrast, np.exp(-beta * frame.depth[core]), rtol=0.02)


def test_more_fog_less_contrast():
    spreads = []
    for visibility in (math.inf, 200.0, 80.0, 40.0, 20.0):
        frame = renderer(Weather(visibility_m=visibility, cloudiness=1.0)).render(snapshot(*crowd()))
        spreads.append(np.std(frame.luminance) / np.mean(frame.luminance))
    assert spreads == sorted(spreads, reverse=True)


@pytest.mark.parametrize(
    "weather",
    [Weather(), FOG, NIGHT, Weather(wetness=1.0, rain_mm_h=20.0)],
    ids=["clear", "fog", "night", "wet"],
)
def test_luminance_alone_equals_the_luminance_of_the_colours(weather):
    camera, scene = renderer(weather), snapshot(*crowd(), headlight=float(weather.headlights))
    full, alone = camera.render(scene), camera.render(scene, luminance_only=True)
    np.testing.assert_allclose(full.luminance, np.tensordot(LUMA, full.radiance, 1), rtol=1e-5)
    np.testing.assert_allclose(alone.luminance, full.luminance, rtol=1e-4)
    assert alone.radiance is None
    assert alone.depth is None
    assert alone.instance is None


@pytest.mark.parametrize("weather", [Weather(), NIGHT], ids=["day", "night"])
def test_same_inputs_same_bytes(weather):
    scene = snapshot(*crowd(), headlight=1.0)
    first, other = renderer(weather), renderer(weather)
    frame = first.render(scene)
    first.render(snapshot(*crowd(), x=3.0))
    for again in (first.render(scene), other.render(scene)):
        for name in ("luminance", "radiance", "depth", "instance"):
            assert getattr(frame, name).tobytes() == getattr(again, name).tobytes()


DRY_NIGHT = dataclasses.replace(NIGHT, wetness=0.0)


@pytest.mark.parametrize("weather", [Weather(), FOG, DRY_NIGHT], ids=["clear", "fog", "night"])
def test_a_millimetre_changes_every_pixel_by_little(weather):
    """Specks would be false events: a change is bounded by the image's motion times the contrast around the pixel."""
    camera = renderer(weather)
    before, after = (
        camera.render(snapshot(*crowd(), x=x, headlight=1.0), luminance_only=True).luminance.astype(float)
        for x in (2.0, 2.001)
    )
    uncovered = camera.render(
        snapshot(*crowd()[:3], x=2.0, headlight=1.0), luminance_only=True
    ).luminance.astype(float)
    images = (before, uncovered)  # a lamp that a body hides to the last hundredth of a pixel is contrast too
    around = np.stack([np.roll(b, (i, j), (0, 1)) for b in images for i in (-1, 0, 1) for j in (-1, 0, 1)])
    contrast = around.max(axis=0) - around.min(axis=0)
    flow_px = 0.001 * 225 / 3.5  # the image's edge, where the nearest surfaces are 3.5 m away
    step = np.abs(after - before)
    assert (step <= 1.5 * flow_px * contrast + 0.01 * before + 0.003).all()
    assert np.mean(step > 0.02 * before) < 0.02


def test_frames_do_not_share_memory():
    camera = renderer()
    first = camera.render(snapshot())
    copy = first.luminance.copy()
    camera.render(snapshot(*crowd(), x=5.0))
    assert np.array_equal(first.luminance, copy)


def test_daylight_is_as_bright_as_the_handbook_says():
    assert (
        90_000
        < sun_illuminance_lx(60, 0.0) * math.sin(math.radians(60)) + sky_illuminance_lx(60, 0.0)
        < 120_000
    )
    assert 10_000 < sky_illuminance_lx(45, 1.0) < 25_000
    assert sun_illuminance_lx(45, 1.0) == 0
    assert sky_illuminance_lx(-30, 0.0) < 1
    assert sky_illuminance_lx(-0.001, 0.5) == pytest.approx(sky_illuminance_lx(0.001, 0.5), rel=0.1)


def test_street_lamps_light_the_road_with_2_to_15_lux():
    camera = renderer(Weather(sun_altitude_deg=-30.0, street_lamps=True))
    ground = camera._scenery.ground_lamp_map
    start_x, start_y, step = camera._scenery.ground_frame
    y = start_y + step * np.arange(ground.shape[0])
    x = start_x + step * np.arange(ground.shape[1])
    road = ground[np.abs(y) < 3.5][:, (x > 0) & (x < 150)]
    assert 2 < road.mean() < 15
    assert road.max() < 30


def test_headlights_light_a_pedestrian_at_night_less_the_farther_it_is():
    weather = Weather(sun_altitude_deg=-30.0, headlights=True)
    camera = renderer(weather)
    levels = []
    for distance in (12.0, 24.0, 48.0):
        frame = camera.render(snapshot(pedestrian(5, distance, -1.75, seed=4), headlight=1.0))
        levels.append(frame.luminance[frame.instance == 5].mean())
    assert levels[0] > 1.6 * levels[1] > 1.6 * levels[2]
    dark = renderer(Weather(sun_altitude_deg=-30.0)).render(snapshot(pedestrian(5, 12.0, -1.75, seed=4)))
    assert levels[0] > 10 * dark.luminance[dark.instance == 5].mean()


def test_a_wet_road_is_darker_from_above_and_mirrors_far_off():
    cover = {"cloudiness": 1.0}
    dry, wet = (
        renderer(Weather(**cover, wetness=w), pitch_deg=45.0).render(snapshot()).luminance for w in (0.0, 1.0)
    )
    ahead = np.s_[:32, 150:300]  # nearer, the ego shades the road but not what it mirrors
    assert wet[ahead].mean() < 0.85 * dry[ahead].mean()
    dry, wet = (renderer(Weather(**cover, wetness=w)).render(snapshot()) for w in (0.0, 1.0))
    far = np.s_[131:134, 215:235]
    assert wet.luminance[far].mean() > dry.luminance[far].mean()
    off_ground = wet.instance != StaticClass.GROUND
    np.testing.assert_allclose(
        wet.luminance[off_ground & (wet.depth < 1e3)].mean(),
        dry.luminance[off_ground & (wet.depth < 1e3)].mean(),
        rtol=0.02,
    )


def test_brake_lights_shine():
    camera = renderer()
    on, off = (camera.render(snapshot(vehicle(5, 12.0, -1.75, brake_light=b))).luminance for b in (1.0, 0.0))
    changed = np.abs(on - off) > 100
    assert 4 < changed.sum() < 2000
    assert (on[changed] > off[changed]).all()


def test_the_street_has_looks_of_its_seed():
    camera = renderer()
    first = camera.render(snapshot()).luminance
    camera.load(dataclasses.replace(STREET, seed=6), Weather())
    assert not np.array_equal(first, camera.render(snapshot()).luminance)


def candela(table, up_deg, right_deg):
    """Of one lamp: the tables hold both."""
    return 0.5 * beam_candela(
        table,
        -math.tan(math.radians(right_deg)),
        math.tan(math.radians(up_deg)) / math.cos(math.radians(right_deg)),
    )


# UN R112, class B, right-hand traffic: (degrees up, degrees right, least, most candela) of one lamp.
LOW_BEAM_POINTS = {
    "B50L": (0.57, -3.43, 0, 350), "75R": (-0.57, 1.15, 10_100, 1e9), "75L": (-0.57, -3.43, 0, 10_600),
    "50L": (-0.86, -3.43, 0, 13_200), "50R": (-0.86, 1.72, 10_100, 1e9), "50V": (-0.86, 0.0, 5_100, 1e9),
    "25L": (-1.72, -9.0, 1_700, 1e9), "25R": (-1.72, 9.0, 1_700, 1e9), "zone III": (2.0, -6.0, 0, 625),
}  # fmt: skip


@pytest.mark.parametrize("point", LOW_BEAM_POINTS)
def test_low_beams_pass_their_type_approval(point):
    up, right, least, most = LOW_BEAM_POINTS[point]
    assert least <= candela(low_beam_table(), up, right) <= most


def test_high_beams_pass_their_type_approval():
    table = high_beam_table()
    brightest = 0.5 * float(table.max())
    assert 40_500 <= brightest <= 215_000
    assert candela(table, 0.0, 0.0) >= 0.8 * brightest
    for side in (-1, 1):  # as the table's docstring says: from memory
        assert candela(table, 0.0, 2.6 * side) >= 20_250
        assert candela(table, 0.0, 5.2 * side) >= 5_100


def test_high_beams_light_what_low_beams_leave_dark():
    camera = renderer(Weather(sun_altitude_deg=-30.0, headlights=True))
    far = [pedestrian(5, 70.0, -1.0, seed=4)]
    low, high = (camera.render(snapshot(*far, headlight=level)) for level in (1.0, 2.0))
    seen = low.instance == 5
    assert high.luminance[seen].mean() > 3 * low.luminance[seen].mean()


def test_a_flash_adds_its_light_to_sky_and_ground_alike():
    light = light_of(NIGHT)
    struck = flashed(light, 1000.0)
    assert flashed(light, 0.0) is light
    assert float((struck.sky_lx * LUMA).sum() - (light.sky_lx * LUMA).sum()) == pytest.approx(1000.0)
    camera = renderer(NIGHT)
    dark, lit = camera.render(snapshot()), camera.render(snapshot(), flash_lx=1000.0)
    sky = dark.instance == StaticClass.SKY
    whole = np.median(
        (lit.luminance - dark.luminance)[sky]
    )  # some pixels hold a twig besides, and clouds shade it
    assert whole == pytest.approx(1000.0 / math.pi, rel=0.1)
    assert (lit.luminance > dark.luminance).mean() > 0.99


def test_the_road_under_lamps_is_as_bright_as_their_candela_table_says():
    """Lamps against skylight on the same asphalt: its albedo cancels.

    The camera looks down, so that the lamps' glare stays out of the picture, and beyond what the ego shades.
    """
    dark = Weather(sun_altitude_deg=-30.0)
    camera = renderer(dark, pitch_deg=20.0)
    scene = snapshot(x=6.0)
    unlit = camera.render(scene)
    camera.load(STREET, replace(dark, street_lamps=True))
    lit = camera.render(scene)
    sky_lx = float((light_of(dark).sky_lx * LUMA).sum())
    lamps = scenery_of(STREET).lamps
    pose = camera_pose(camera.config, scene.ego)
    for row, column in ((20, 225), (50, 140), (80, 300), (110, 225)):
        x, y, _ = pose.origin + unlit.depth[row, column] * rays(
            pose, np.array(column + 0.5), np.array(row + 0.5)
        )
        away = np.sqrt((lamps[:, 0] - x) ** 2 + (lamps[:, 1] - y) ** 2 + lamps[:, 2] ** 2)
        down = lamps[:, 2] / away
        expected_lx = sum(lamp_candela(c) * c / r**2 for c, r in zip(down, away, strict=True))
        patch = (slice(row - 2, row + 3), slice(column - 4, column + 5))
        gain = (lit.luminance[patch] - unlit.luminance[patch]).mean() / unlit.luminance[patch].mean()
        assert gain * sky_lx == pytest.approx(expected_lx, rel=0.05)
