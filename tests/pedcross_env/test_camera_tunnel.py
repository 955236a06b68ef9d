"""A tunnel's end: dark within, unchanged beyond, and its walls where geometry says."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from camera_scenes import STREET, pedestrian, renderer, snapshot

from pedcross_env.camera import Renderer, camera_pose
from pedcross_env.camera.kernels.tunnel import CEILING, PORTAL_ALBEDO, ROAD, WALL, daylight_share
from pedcross_env.camera.light import LUMA, light_of
from pedcross_env.camera.tunnel import HEIGHT_M, INSET_M, TUNNEL_LX
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import StaticClass
from pedcross_env.errors import ConfigError
from pedcross_env.scenario.street import Intersection
from pedcross_env.weather import WEATHERS, Weather

DAY = Weather()
TUNNEL = Weather(tunnel_exit_m=20.0)
WALL_M = STREET.facade_y_m - INSET_M


def portal(camera, scene, margin_px=1.5):
    """Pixels well inside the portal's outline and pixels well outside of it, by projecting its corners."""
    pose = camera_pose(camera.config, scene.ego)
    ahead = 20.0 - pose.origin[0]
    left, right = (pose.cx - pose.focal_px * (y - pose.origin[1]) / ahead for y in (WALL_M, -WALL_M))
    top = pose.cy - pose.focal_px * (HEIGHT_M - pose.origin[2]) / ahead
    rows, columns = np.mgrid[: camera.config.height_px, : camera.config.width_px] + 0.5
    inside = (columns > left + margin_px) & (columns < right - margin_px) & (rows > top + margin_px)
    outside = (columns < left - margin_px) | (columns > right + margin_px) | (rows < top - margin_px)
    return inside, outside


def test_what_is_seen_through_the_portal_is_as_it_was() -> None:
    scene = snapshot(pedestrian(5, 40.0, -1.75))
    plain, camera = renderer(DAY).render(scene), renderer(TUNNEL)
    frame = camera.render(scene)
    inside, _ = portal(camera, scene)
    beyond = (
        inside & (plain.depth > 24.0) & (frame.depth > 24.0)
    )  # well beyond the exit at 19.7 m from the lens
    assert beyond.sum() > 3000
    same = np.isclose(frame.luminance, plain.luminance, rtol=1e-5)[beyond].mean()
    assert same > 0.95  # lampposts that would stand inside are gone
    assert (frame.instance == 5).sum() == (plain.instance == 5).sum() > 20


def test_within_it_is_dark_and_there_is_no_sky() -> None:
    scene = snapshot()
    grey = Weather(cloudiness=1.0)  # without shadows of trees, which go with the trees
    plain = renderer(grey).render(scene)
    camera = renderer(dataclasses.replace(grey, tunnel_exit_m=20.0))
    frame = camera.render(scene)
    _, outside = portal(camera, scene)
    assert not (frame.instance[outside] == StaticClass.SKY).any()
    near = (frame.instance == StaticClass.GROUND) & (frame.depth < 15.0)
    x = camera_pose(camera.config, scene.ego).origin[0] + frame.depth[near]
    light = light_of(grey)
    outside_lx = float((light.sky_lx * LUMA).sum())
    expected = TUNNEL_LX / outside_lx + np.array(
        [daylight_share(float(20.0 - d), WALL_M, HEIGHT_M, ROAD) for d in x]
    )
    ratio = frame.luminance[near] / plain.luminance[near]
    assert np.isclose(ratio, expected, rtol=0.01).mean() > 0.97


def test_walls_and_ceiling_are_as_far_as_they_stand() -> None:
    scene = snapshot()
    camera = renderer(TUNNEL)
    frame, pose = camera.render(scene), camera_pose(camera.config, scene.ego)
    row, column = 100, 10
    sideways = (pose.cx - (column + 0.5)) / pose.focal_px  # to the left, per metre of depth
    assert frame.depth[row, column] == pytest.approx((WALL_M - pose.origin[1]) / sideways, rel=1e-4)
    upwards = (pose.cy - 10.5) / pose.focal_px
    assert frame.depth[10, 225] == pytest.approx((HEIGHT_M - pose.origin[2]) / upwards, rel=1e-4)
    assert frame.instance[10, 225] == frame.instance[row, column] == StaticClass.BUILDING


def test_past_the_exit_nothing_is_left_of_it() -> None:
    scene = snapshot(x=40.0)
    plain, frame = (renderer(weather).render(scene) for weather in (DAY, TUNNEL))
    ahead = plain.depth < 1e3
    np.testing.assert_array_equal(frame.depth[ahead], plain.depth[ahead])
    assert (
        np.isclose(frame.luminance, plain.luminance, rtol=1e-4).mean() > 0.97
    )  # shadows of trees that are gone


@pytest.mark.parametrize("surface", [ROAD, WALL, CEILING])
def test_daylight_fades_into_the_tunnel_as_the_portal_is_seen(surface: int) -> None:
    """The view factor of the portal by adding up its small areas: cos cos / (pi r^2) each."""
    half, height = 9.0, 5.2
    y, z = np.meshgrid(*((np.arange(400) + 0.5) / 400 * size for size in (2 * half, height)), indexing="ij")
    area = (2 * half / 400) * (height / 400)
    for inside in (8.0, 15.0, 40.0):
        if surface == WALL:  # stands at y = 0, half the portal's height up
            towards, away2 = y, inside**2 + y**2 + (z - height / 2) ** 2
        else:  # lies at z = 0 before the middle; the ceiling is its mirror image
            towards, away2 = z, inside**2 + (y - half) ** 2 + z**2
        factor = (towards * inside / (np.pi * away2**2)).sum() * area
        share = daylight_share(inside, half, height, surface)
        assert share == pytest.approx(PORTAL_ALBEDO * factor, rel=2e-3)


def test_daylight_falls_with_the_cube_of_the_distance_and_the_road_has_no_edge_at_the_portal() -> None:
    for surface in (ROAD, WALL, CEILING):
        shares = [daylight_share(float(d), 9.0, 5.2, surface) for d in range(0, 400, 5)]
        assert shares == sorted(shares, reverse=True)
        assert shares[60] / shares[30] == pytest.approx(1 / 8, rel=0.03)
    assert daylight_share(0.0, 9.0, 5.2, ROAD) == 1.0
    assert daylight_share(-1.0, 9.0, 5.2, ROAD) == 1.0


def test_luminance_alone_equals_colour_and_a_millimetre_changes_little() -> None:
    camera = renderer(WEATHERS["tunnel_exit"])
    scene = snapshot(pedestrian(5, 12.0, -1.75), x=2.0, headlight=1.0)
    full, alone = camera.render(scene), camera.render(scene, luminance_only=True)
    np.testing.assert_allclose(alone.luminance, full.luminance, rtol=1e-4)
    before, after = (
        camera.render(snapshot(x=x, headlight=1.0), luminance_only=True).luminance.astype(float)
        for x in (2.0, 2.001)
    )
    around = np.stack([np.roll(before, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    contrast = around.max(axis=0) - around.min(axis=0)
    allowed = 1.5 * 0.001 * 225 / 3.5 * contrast + 0.01 * before + 0.003
    assert (np.abs(after - before) <= allowed).mean() > 0.9995
    assert math.isfinite(float(after.sum()))


def test_a_tunnel_around_a_street_that_bends_is_refused_with_the_remedy() -> None:
    camera = Renderer(CameraConfig(width_px=64, height_px=36))
    bent = dataclasses.replace(STREET, intersection=Intersection(x_m=60.0))
    with pytest.raises(ConfigError, match="tunnel_exit_m = -inf"):
        camera.load(bent, TUNNEL)
    camera.load(bent, DAY)
