"""The shade of houses: where geometry says it lies, on the ground and on whoever stands in it."""

import dataclasses
import math

import numpy as np
import pytest
from camera_scenes import STREET, pedestrian, renderer, snapshot

from pedcross_env.camera import camera_pose, project
from pedcross_env.camera.kernels.facade import PANEL_SIZE
from pedcross_env.camera.kernels.scene import LEVELS, NODES
from pedcross_env.camera.light import light_of
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.camera.shade import Shade
from pedcross_env.weather.weather import Weather

HEIGHT_M, FRONT_M = 10.0, 9.0
ACROSS = Weather(sun_altitude_deg=45.0, sun_azimuth_deg=90.0, cloudiness=0.0)
LUMA = np.array([0.2126, 0.7152, 0.0722])


@pytest.fixture(scope="module")
def one_house():
    """Scenery with nothing but a house 10 m high on the left from x = 0 to 60, its front at y = 9."""
    panel = np.zeros((1, PANEL_SIZE))
    panel[0, :2], panel[0, 3], panel[0, 6], panel[0, 7] = (0.0, FRONT_M), 1.0, 60.0, HEIGHT_M
    panel[0, 8:11], panel[0, 12], panel[0, 18], panel[0, 24] = 0.3, 3.0, 1.0, 1.0
    scenery = scenery_of(STREET)
    props = dataclasses.replace(
        scenery.props, numbers=scenery.props.numbers[:0], idents=scenery.props.idents[:0], looks=scenery.props.looks[:0]
    )  # fmt: skip
    return dataclasses.replace(scenery, panels=panel, groups=scenery.groups[:0], props=props)


def share_at(shade, x, y, height):
    numbers = np.zeros((1, 14))
    numbers[0, [0, 1, 6, 7, 8]] = x, y, 0.5, 0.5, height
    return float(shade.on_actors(numbers)[0])


def test_a_wall_shades_as_high_as_its_top_less_the_way_times_the_tangent(one_house):
    shade = Shade(one_house, light_of(ACROSS))
    # 6 m from a wall of 10 m under 45 degrees: dark up to 4 m
    assert share_at(shade, 30.0, FRONT_M - 6.0, 5.0) == pytest.approx(1 / 5)
    assert share_at(shade, 30.0, FRONT_M - 6.0, 1.8) == 0.0
    assert share_at(shade, 30.0, FRONT_M - 10.5, 1.8) == 1.0
    assert share_at(shade, 70.0, FRONT_M - 6.0, 1.8) == 1.0
    flat = Shade(one_house, light_of(dataclasses.replace(ACROSS, sun_altitude_deg=30.0)))
    assert share_at(flat, 30.0, FRONT_M - 6.0, 8.0) == pytest.approx(
        1 - (HEIGHT_M - 6 * math.tan(math.pi / 6)) / 8
    )


def test_light_on_a_walker_changes_steadily_on_the_way_out_of_the_shade(one_house):
    shade = Shade(one_house, light_of(ACROSS))
    across = [share_at(shade, 30.0, y, 1.8) for y in np.arange(3.0, -3.0, -0.01)]
    along = [share_at(shade, x, 3.0, 1.8) for x in np.arange(58.0, 64.0, 0.01)]
    for shares in (across, along):
        steps = np.diff(shares)
        assert (shares[0], shares[-1]) == (0.0, 1.0)
        assert steps.min() >= 0
        assert steps.max() < 0.05


def test_without_a_sun_nothing_is_shaded(one_house):
    for weather in (Weather(sun_altitude_deg=-10.0), Weather(cloudiness=1.0)):
        shade = Shade(one_house, light_of(weather))
        assert share_at(shade, 30.0, FRONT_M - 1.0, 1.8) == 1.0
        assert len(shade.near(np.zeros(2), 20.0)[0]) == 0


@pytest.mark.parametrize("free", [False, True], ids=["by rows", "general"])
def test_the_edge_of_the_shade_on_the_road_is_where_the_sun_puts_it(one_house, monkeypatch, free):
    monkeypatch.setattr("pedcross_env.camera.renderer.scenery_for", lambda street: one_house)
    drawn = renderer(ACROSS)
    drawn.load(STREET, ACROSS, free_heading=free)
    moment = snapshot(x=10.0)
    luminance = drawn.render(moment).luminance
    light = light_of(ACROSS)
    sun, sky = ((lx * LUMA).sum() for lx in (light.sun_lx * light.sun_direction[2], light.sky_lx))
    edge_m = FRONT_M - HEIGHT_M
    places = np.array([[28.0, edge_m + 0.5, 0.0], [28.0, edge_m - 0.5, 0.0]])
    pixels = project(camera_pose(drawn.config, moment.ego), places)
    dark, lit = (luminance[int(v), int(u) - 2 : int(u) + 3].mean() for u, v, _ in pixels)
    assert dark / lit == pytest.approx(
        sky / (sun + sky), rel=0.12
    )  # the road's grain differs between the two


def test_whoever_stands_in_the_shade_is_as_dark_as_the_road_there(one_house, monkeypatch):
    monkeypatch.setattr("pedcross_env.camera.renderer.scenery_for", lambda street: one_house)
    drawn = renderer(ACROSS)

    def brightness(y):
        frame = drawn.render(snapshot(pedestrian(20, 24.0, y), x=10.0))
        return frame.luminance[frame.instance == 20].mean()

    assert brightness(FRONT_M - 7.0) < 0.5 * brightness(FRONT_M - 13.0)


def opposite(one_house, height_m, length_m=40.0):
    """The house, so high, and a blank front opposite it."""
    panels = np.concatenate([one_house.panels, one_house.panels])
    panels[0, 6], panels[0, 7] = length_m, height_m
    panels[1, :2], panels[1, 3], panels[1, 7] = (60.0, -FRONT_M), -1.0, 12.0
    return dataclasses.replace(one_house, panels=panels)


@pytest.mark.parametrize("altitude_deg", [15.0, 20.0, 26.0])
@pytest.mark.parametrize("luminance_only", [True, False])
def test_the_edge_of_the_shade_on_the_front_opposite_is_where_the_sun_puts_it(
    one_house, monkeypatch, altitude_deg, luminance_only
):
    low_sun = dataclasses.replace(ACROSS, sun_altitude_deg=altitude_deg)
    moment = snapshot(x=10.0)

    def drawn(height_m):
        scenery = opposite(one_house, height_m)
        monkeypatch.setattr("pedcross_env.camera.renderer.scenery_for", lambda street: scenery)
        camera = renderer(low_sun)
        return camera.config, camera.render(moment, luminance_only=luminance_only).luminance

    config, seen = drawn(HEIGHT_M)
    lit, dark = drawn(0.01)[1], drawn(80.0)[1]
    edge_m = HEIGHT_M - 2 * FRONT_M * math.tan(math.radians(altitude_deg))
    pose = camera_pose(config, moment.ego)
    for x in (30.0, 34.0, 38.0):
        heights = np.arange(0.5, 8.0, 0.5)
        places = np.stack([np.full(heights.shape, x), np.full(heights.shape, -FRONT_M), heights], axis=1)
        column, row = project(pose, places)[:, :2].astype(int).T
        assert (lit[row, column] > 1.5 * dark[row, column]).all()
        share = (seen - dark)[row, column] / (lit - dark)[row, column]
        np.testing.assert_allclose(share[heights > edge_m + 0.25], 1.0, atol=1e-3)
        np.testing.assert_allclose(share[heights < edge_m - 0.25], 0.0, atol=1e-3)
        edge = project(pose, np.array([[x, -FRONT_M, edge_m]]))[0]
        at = (seen - dark)[int(edge[1]), int(edge[0])] / (lit - dark)[int(edge[1]), int(edge[0])]
        assert 0.1 < at < 0.9  # within half a pixel
    beyond = project(pose, np.array([[44.0, -FRONT_M, 1.0]]))[0]  # the house ends at 40 m
    assert seen[int(beyond[1]), int(beyond[0])] == pytest.approx(
        lit[int(beyond[1]), int(beyond[0])], rel=1e-3
    )


def test_shares_on_a_front_come_of_its_edges_of_shade(one_house):
    low_sun = light_of(dataclasses.replace(ACROSS, sun_altitude_deg=20.0))
    shade = Shade(opposite(one_house, HEIGHT_M), low_sun)
    edge_m = HEIGHT_M - 2 * FRONT_M * math.tan(math.radians(20.0))
    x, heights, profile = np.linspace(60.0, 0.0, NODES), shade.edges[1, :NODES], shade.edges[1, NODES:]
    np.testing.assert_allclose(heights[x < 40.0], edge_m, atol=0.03)  # 5 cm before the front
    assert (heights[x > 40.5] < 0).all()
    up = np.linspace(0.0, 12.0, LEVELS)
    np.testing.assert_allclose(
        profile[np.abs(up - edge_m) > 0.5],
        np.where(up < edge_m, 1 / 3, 1.0)[np.abs(up - edge_m) > 0.5],
        atol=0.02,
    )
    assert shade.panels[1] == pytest.approx(1 - 2 / 3 * edge_m / 12.0, abs=0.01)
    assert Shade(opposite(one_house, 0.01), low_sun).panels[1] == 1.0
    assert Shade(opposite(one_house, 80.0, 60.0), low_sun).panels[1] == 0.0
