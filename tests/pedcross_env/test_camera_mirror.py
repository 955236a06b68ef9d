"""What a wet road mirrors: how much of it, where, and how its slopes smear it."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from camera_scenes import pedestrian, renderer, snapshot

from pedcross_env.camera.kernels.mirror import FILM, GRID_PLANES, mirror_in_road
from pedcross_env.weather import Weather
from pedcross_env.weather.road import film_slope

HEIGHT, WIDTH, FOCAL, CAMERA_M = 128, 96, 200.0, 1.4
HORIZON = 64.0
THING = 7


def picture(sky: float, road: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Radiance, inverse depth and ids of an empty plain under an even sky."""
    rows = np.arange(HEIGHT) + 0.5
    ground = (rows > HORIZON)[:, None] & np.ones((1, WIDTH), bool)
    out = np.where(ground, road, sky).astype(np.float32)[None].copy()
    inverse = np.where(ground, np.maximum(rows - HORIZON, 0.0)[:, None] / (FOCAL * CAMERA_M), 0.0)
    return out, inverse.astype(np.float32), np.where(ground, -1, 0).astype(np.int32)


def mirrored(
    scene: tuple[np.ndarray, ...], slope: float = 0.02, tilt: float = 0.0, unknown: float = 0.0
) -> np.ndarray:
    out, inverse, ids = (plane.copy() for plane in scene)
    grid, work = (
        np.zeros((GRID_PLANES, HEIGHT // 2, WIDTH // 2), np.float32),
        np.zeros((2, WIDTH), np.float32),
    )
    mirror_in_road(
        out, inverse, ids, (ids == THING).astype(np.float32), HORIZON - tilt * WIDTH / 2, tilt, FOCAL, CAMERA_M,
        (1.0, slope), np.full(1, unknown, np.float32), grid, work,
    )  # fmt: skip
    return out[0].astype(np.float64)


def fresnel(row: float, slope: float) -> float:
    """Schlick's factor for water at the mean angle of the slopes that are seen."""
    sine = math.sin(math.atan((row + 0.5 - HORIZON) / FOCAL))
    return 0.02 + 0.98 * (1.0 - math.hypot(sine, slope)) ** 5


def stand(scene: tuple[np.ndarray, ...], depth_m: float, columns: slice, rows: slice, light: float) -> None:
    """Put an upright thing that shines into a picture."""
    out, inverse, ids = scene
    out[0, rows, columns], inverse[rows, columns], ids[rows, columns] = light, 1.0 / depth_m, THING


@pytest.mark.parametrize("tilt", [0.0, 0.1])
@pytest.mark.parametrize("slope", [0.01, 0.1])
def test_light_is_conserved_where_all_is_equally_bright(slope: float, tilt: float) -> None:
    """F of the light is mirrored and 1 - F comes from the road: of one radiance that makes the same radiance."""
    scene = picture(5.0, 5.0)
    stand(scene, 20.0, slice(30, 50), slice(40, 78), 5.0)
    np.testing.assert_allclose(mirrored(scene, slope, tilt, unknown=5.0), 5.0, rtol=1e-4)


@pytest.mark.parametrize("slope", [0.01, 0.05])
def test_an_even_sky_is_mirrored_by_schlicks_share(slope: float) -> None:
    out = mirrored(picture(3.0, 0.0), slope, unknown=3.0)
    for row in range(66, HEIGHT):
        np.testing.assert_allclose(out[row], 3.0 * FILM * fresnel(row, slope), rtol=2e-3)


def lamp(height_row: int) -> tuple[np.ndarray, ...]:
    """A lamp of 4x4 pixels high up at 20 m on a black plain under a black sky."""
    scene = picture(0.0, 0.0)
    stand(scene, 20.0, slice(46, 50), slice(height_row, height_row + 4), 100.0)
    return scene


def spot(scene: tuple[np.ndarray, ...], slope: float) -> tuple[float, float, float, float]:
    """Light, mean row, and spread along rows and columns of what is mirrored, Fresnel's factor taken out."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    gain = np.array([FILM * fresnel(row, slope) for row in range(HEIGHT)])[:, None]
    light = mirrored(scene, slope) / gain
    light[: int(HORIZON) + 1] = 0.0
    total = light.sum()
    mean_row, mean_column = (light * rows).sum() / total, (light * columns).sum() / total
    down, across = (
        (light * (axis - mean) ** 2).sum() / total
        for axis, mean in ((rows, mean_row), (columns, mean_column))
    )
    return float(total), float(mean_row), math.sqrt(down), math.sqrt(across)


def test_a_lamp_is_mirrored_as_far_below_the_roads_row_as_it_stands_above() -> None:
    _, row, _, _ = spot(lamp(40), 1e-4)
    foot = HORIZON + FOCAL * CAMERA_M / 20.0
    assert row + 0.5 == pytest.approx(2 * foot - 42.0, abs=1.0)


def test_rougher_water_stretches_a_lamp_keeps_its_light_and_stretches_it_more_along_than_across() -> None:
    source = 16 * 100.0
    smooth, rough, rougher = (spot(lamp(40), slope) for slope in (1e-4, 0.02, 0.04))
    assert smooth[0] == pytest.approx(source, rel=0.03)
    for light, *_ in (rough, rougher):
        assert 0.6 * source < light < 1.2 * source  # the picture's end cuts the tail off
    assert smooth[2] < rough[2] < rougher[2]
    assert smooth[3] < rough[3] < rougher[3]
    assert rougher[2] > 2 * rougher[3]


def test_no_hard_edge_is_left_in_a_mirrored_lamp() -> None:
    light = mirrored(lamp(40), 0.05)
    peak = light[66:].max()
    assert np.abs(np.diff(light[66:], axis=0)).max() < 0.25 * peak
    assert np.abs(np.diff(light[66:], axis=1)).max() < 0.35 * peak


def test_what_stands_on_the_road_is_smeared_less_at_its_foot() -> None:
    """The mirror image of a wall begins at its foot, sharply, while its upper end fades over many rows."""
    scene = picture(0.0, 0.0)
    foot = HORIZON + FOCAL * CAMERA_M / 14.0
    stand(scene, 14.0, slice(0, WIDTH), slice(int(foot) - 30, int(foot)), 10.0)
    slope = 0.04
    light = mirrored(scene, slope)[:, 40] / [FILM * fresnel(row, slope) for row in range(HEIGHT)]
    assert light[int(foot) + 3] > 6.0
    end = int(foot) + 30
    assert 1.0 < light[end] < 9.0
    assert light[end + 8] > 0.5


def test_a_centimetre_of_way_changes_the_mirror_image_a_little() -> None:
    """Mirrored edges must not jump from row to row: an event camera would see that."""
    wet = Weather(cloudiness=1.0, wetness=1.0, water_film_mm=1.0)
    camera = renderer(wet, width_px=150, height_px=86)
    dry = renderer(Weather(cloudiness=1.0), width_px=150, height_px=86)
    steps = []
    for view in (camera, dry):
        pictures = [
            view.render(snapshot(pedestrian(5, 16.0, -2.0), x=x)).luminance[46:]
            for x in np.arange(2.0, 2.4, 0.01)
        ]
        steps.append([np.abs(np.log(b / a)).max() for a, b in itertools.pairwise(pictures)])
    assert max(steps[0]) < max(steps[1]) + 0.1


def test_film_slopes_fall_with_water_and_rise_with_rain() -> None:
    slopes = [film_slope(film, 0.0) for film in (0.0, 0.1, 0.5, 1.0, 3.0)]
    assert slopes == sorted(slopes, reverse=True)
    assert film_slope(0.0, 0.0) == pytest.approx(0.10)
    assert film_slope(1.0, 50.0) > film_slope(1.0, 5.0) > film_slope(1.0, 0.0)
