"""Spray of vehicles ahead: by speed and film, behind them, hanging where it was thrown, the same for both cameras."""

from __future__ import annotations

import numpy as np
import pytest
from camera_scenes import renderer, snapshot, vehicle

from pedcross_env.camera.spray import spray_thickness
from pedcross_env.weather import Weather

SMALL = {"width_px": 225, "height_px": 128}


def soaked(film_mm: float = 1.0, **rest: float) -> Weather:
    return Weather(cloudiness=1.0, water_film_mm=film_mm, wetness=1.0 if film_mm else 0.0, **rest)


def difference(speed: float, film_mm: float = 1.0, x: float = 20.0, **camera: float) -> np.ndarray:
    """What a car's speed alone changes in the luminance: its spray."""
    view = renderer(soaked(film_mm), **SMALL, **camera)
    still, fast = (view.render(snapshot(vehicle(5, x, -1.75, speed=v))).luminance for v in (0.0, speed))
    return np.asarray(fast - still)


def test_spray_grows_with_speed_film_and_the_vehicles_size() -> None:
    by_speed = [spray_thickness(v, 1.0) for v in (0.0, 4.0, 8.0, 14.0, 22.0)]
    assert by_speed[:2] == [0.0, 0.0]
    assert by_speed == sorted(by_speed)
    by_film = [spray_thickness(14.0, film) for film in (0.0, 0.1, 0.5, 2.0)]
    assert by_film[0] == 0.0
    assert by_film == sorted(by_film)
    assert spray_thickness(14.0, 1.0, 3.2) > 2 * spray_thickness(14.0, 1.0, 1.5)


def test_a_fast_car_on_a_wet_road_raises_spray_behind_it_and_a_slow_or_dry_one_none() -> None:
    assert not difference(3.0).any()
    assert not difference(14.0, film_mm=0.0).any()
    slow, fast = (np.abs(difference(v)).sum() for v in (8.0, 16.0))
    assert 0 < slow < fast
    rows, columns = np.nonzero(np.abs(difference(16.0)) > 5.0)
    assert rows.min() > 40  # nothing in the sky
    assert abs(columns.mean() - 112.0) < 30.0


def test_spray_pulls_towards_the_light_around_and_never_beyond() -> None:
    view = renderer(soaked(), **SMALL)
    plain, with_spray = (view.render(snapshot(vehicle(5, 20.0, -1.75, speed=v))) for v in (0.0, 20.0))
    low = np.minimum(plain.luminance, 0.9 * plain.airlight) - 1e-2
    high = np.maximum(plain.luminance, 0.9 * plain.airlight) + 1e-2
    assert ((with_spray.luminance >= low) & (with_spray.luminance <= high)).all()


def test_puffs_hang_where_they_were_thrown() -> None:
    """A centimetre of the car's way changes the spray by little: nothing jumps along."""
    view = renderer(soaked(), **SMALL)

    def spray(x: float) -> np.ndarray:
        return np.asarray(difference(14.0, x=x))

    one, near, far = spray(20.0), spray(20.01), spray(20.35)
    assert np.abs(near - one).max() < 0.12 * np.abs(one).max()
    assert np.abs(far - one).max() > np.abs(near - one).max()
    assert view is not None


def test_luminance_alone_equals_colour_and_same_bytes() -> None:
    view = renderer(soaked(), **SMALL)
    scene = snapshot(vehicle(5, 18.0, -1.75, speed=15.0))
    full, alone, again = view.render(scene), view.render(scene, luminance_only=True), view.render(scene)
    np.testing.assert_allclose(alone.luminance, full.luminance, rtol=1e-4)
    np.testing.assert_array_equal(full.luminance, again.luminance)
    assert full.radiance is not None
    weights = np.array([0.2126, 0.7152, 0.0722], np.float32)
    np.testing.assert_allclose(np.einsum("chw,c->hw", full.radiance, weights), full.luminance, rtol=1e-3)


@pytest.mark.parametrize("x", [2.0, 4.0])
def test_driving_into_spray_is_no_wall(x: float) -> None:
    out = difference(14.0, x=x)
    assert np.isfinite(out).all()
