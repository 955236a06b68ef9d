"""Planes are not cleared before they are drawn in: nothing of what was in the memory may be seen."""

import numpy as np
import pytest
from camera_scenes import NIGHT, pedestrian, renderer, snapshot, vehicle

from pedcross_env.camera.layers import FARTHEST, NEAREST, Border, Layer
from pedcross_env.weather.weather import Weather

SCENE = snapshot(vehicle(2, 20.0, -1.75), pedestrian(3, 12.0, 2.0))
BORDER = Border(15.0, 15.0)
# the first from some row on without ground, the second all of the picture
LAYERS = (
    Layer(NEAREST, BORDER, 256, 180, np.array([False, True])),
    Layer(BORDER, FARTHEST, 256, 0, np.array([True, False])),
)


def spoil(camera, monkeypatch, value):
    """Let all memory that pictures are drawn in hold a value."""
    empty = np.empty
    for plane in (*camera._canvas, camera._passing, *camera._sides):
        plane.fill(value)

    def spoilt(shape, dtype=float):
        made = empty(shape, dtype)
        made.fill(value if made.dtype == np.float32 else 7)
        return made

    monkeypatch.setattr(np, "empty", spoilt)


def planes(frame):
    return [p for p in (frame.luminance, frame.radiance, frame.depth, frame.instance) if p is not None]


@pytest.mark.parametrize("value", [np.nan, 1e9])
@pytest.mark.parametrize("luminance_only", [False, True])
@pytest.mark.parametrize(
    ("weather", "settings"),
    [(Weather(), {}), (NIGHT, {}), (Weather(visibility_m=80.0), {}), (Weather(), {"roll_deg": 5.0})],
    ids=["clear", "night", "fog", "rolled"],
)
def test_a_picture_shows_nothing_of_what_was_in_its_memory(
    weather, settings, luminance_only, value, monkeypatch
):
    camera = renderer(weather, **settings)
    clean = camera.render(SCENE, luminance_only=luminance_only)
    spoil(camera, monkeypatch, value)
    again = camera.render(SCENE, luminance_only=luminance_only)
    assert all(np.array_equal(a, b) for a, b in zip(planes(clean), planes(again), strict=True))


@pytest.mark.parametrize("value", [np.nan, 1e9])
@pytest.mark.parametrize("passing", [False, True])
def test_nor_does_a_layer(passing, value, monkeypatch):
    camera = renderer()
    [moment] = camera.moments([SCENE])
    clean = [[p.copy() for p in camera.layers(moment, [layer], passing=passing)[0]] for layer in LAYERS]
    spoil(camera, monkeypatch, value)
    for layer, expected in zip(LAYERS, clean, strict=True):
        seen = camera.layers(moment, [layer], passing=passing)[0]
        assert all(np.array_equal(a, b) for a, b in zip(seen, expected, strict=True))
        assert expected[0].max() > 0
