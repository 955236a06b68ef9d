"""Lying snow, and what headlights make of falling snow."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from camera_scenes import STREET, renderer, snapshot

from pedcross_env.camera import camera_pose
from pedcross_env.camera.scenery import ACROSS_TEXEL_M, scenery_of
from pedcross_env.camera.snow import SNOW_ALBEDO, snowed
from pedcross_env.contracts import StaticClass
from pedcross_env.weather import Precipitation, Weather

OVERCAST = {"cloudiness": 1.0}


def test_snow_mixes_the_grounds_albedo_with_its_own_and_hides_markings() -> None:
    scenery = scenery_of(STREET)
    low = snowed(scenery.low, scenery.across_low, ACROSS_TEXEL_M, STREET, 1.0)
    bare, white = np.diff(scenery.low, axis=0), np.diff(low, axis=0)
    y = scenery.across_low + (np.arange(len(bare)) + 0.5) * ACROSS_TEXEL_M
    middle = np.abs(np.abs(y) - 0.5 * STREET.lane_width_m) < 0.4  # between the wheel tracks
    np.testing.assert_allclose(white[middle, 1:4], np.broadcast_to(SNOW_ALBEDO, (middle.sum(), 3)), rtol=1e-2)
    assert np.abs(white[middle, 4:]).max() < 1e-2
    assert snowed(scenery.low, scenery.across_low, ACROSS_TEXEL_M, STREET, 0.0) is scenery.low


def test_more_lying_snow_is_a_brighter_ground() -> None:
    levels = []
    for cover in (0.0, 0.3, 0.6, 1.0):
        frame = renderer(Weather(**OVERCAST, snow_cover=cover)).render(snapshot())
        levels.append(frame.luminance[frame.instance == StaticClass.GROUND].mean())
    assert levels == sorted(levels)
    assert levels[-1] > 3 * levels[0]


def test_a_turned_camera_sees_the_same_snow() -> None:
    """Its ground is drawn by another kernel."""
    levels = []
    for roll in (0.0, 0.01):
        frame = renderer(Weather(**OVERCAST, snow_cover=0.8), roll_deg=roll).render(snapshot())
        levels.append(frame.luminance[frame.instance == StaticClass.GROUND].mean())
    assert levels[1] == pytest.approx(levels[0], rel=0.02)


@pytest.mark.parametrize("kind", ["snow_mm_h", "rain_mm_h"])
def test_headlights_light_what_falls_before_them(kind: str) -> None:
    weather = Weather(**{kind: 20.0}, sun_altitude_deg=-30.0, headlights=True)
    camera = renderer(weather)
    scene = snapshot(headlight=1.0)
    pose, beam = camera_pose(camera.config, scene.ego), camera.own_beam(scene)
    assert beam is not None
    plain, more = camera.render(scene), 0.0
    for second in range(8):
        lit = []
        for lights in (None, beam):
            frame = replace(plain, luminance=plain.luminance.copy(), radiance=None)
            Precipitation(weather, 3).draw(frame, pose, float(second), 0.004, 10.0, beam=lights)
            lit.append(frame.luminance)
        more = more + lit[1] - lit[0]
    assert (more >= -1e-6).all()
    assert more[140:].sum() > 10 * more[:100].sum()


def test_without_headlights_there_is_no_beam() -> None:
    assert renderer(Weather()).own_beam(snapshot()) is None
    beam = renderer(Weather()).own_beam(snapshot(headlight=2.0))
    assert beam is not None
    table, place = beam
    assert table.max() > 80_000
    assert math.hypot(*place[3:6]) == pytest.approx(1.0)
