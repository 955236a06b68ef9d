"""Crowns of trees are means of their leaves, at any size."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from camera_scenes import STREET, renderer, snapshot

from pedcross_env.camera import Renderer, camera_pose
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.camera.scenery.foliage import BARE, ROUND
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ACTOR_DTYPE, ActorKind, Frame, Snapshot, StaticClass
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.weather import Weather

SAMPLES = 8


def picture(samples: int, luminance_only: bool = False, x_m: float = 0.0) -> Frame:
    camera = CameraConfig(width_px=112 * samples, height_px=64 * samples)
    view = Renderer(camera)
    view.load(StreetSpec(seed=5), Weather())
    ego = np.zeros((), ACTOR_DTYPE)
    ego["id"], ego["kind"], ego["x"] = 1, ActorKind.VEHICLE, x_m
    return view.render(Snapshot(0.0, ego, np.zeros(0, ACTOR_DTYPE)), luminance_only=luminance_only)


@pytest.mark.parametrize("x_m", [0.0, 7.3])
def test_a_crown_is_the_mean_of_a_finer_picture_of_it(x_m: float) -> None:
    """At 112x64 nearly all crowns come from coarser textures than in the finer picture."""
    coarse, fine = picture(1, x_m=x_m), picture(SAMPLES, x_m=x_m)
    blocks = fine.luminance.reshape(64, SAMPLES, 112, SAMPLES).mean(axis=(1, 3))
    leaves = (fine.instance == StaticClass.VEGETATION).reshape(64, SAMPLES, 112, SAMPLES).mean(
        axis=(1, 3)
    ) > 0.5
    assert leaves.sum() > 100
    off = np.abs(np.log(coarse.luminance[leaves] / blocks[leaves]))
    assert np.median(off) < 0.03
    assert np.quantile(off, 0.9) < 0.2  # edges of what stands before them


def test_luminance_alone_is_that_of_the_colours() -> None:
    grey, colour = picture(2, luminance_only=True), picture(2)
    leaves = colour.instance == StaticClass.VEGETATION
    assert leaves.any()
    np.testing.assert_allclose(grey.luminance[leaves], colour.luminance[leaves], rtol=1e-4)


def test_lying_snow_whitens_leaves_more_than_trunks() -> None:
    cameras = [
        renderer(Weather(cloudiness=1.0, snow_cover=cover), width_px=900, height_px=512)
        for cover in (0.0, 1.0)
    ]
    scene = snapshot(x=4.0)
    bare, snowy = (camera.render(scene) for camera in cameras)
    pose = camera_pose(cameras[0].config, scene.ego)
    below = (np.arange(512)[:, None] + 0.5 - pose.cy) / pose.focal_px * bare.depth
    aside = (np.arange(900) + 0.5 - pose.cx) / pose.focal_px * bare.depth
    street = np.abs(pose.origin[1] - aside) < STREET.facade_y_m  # beyond are hedges
    height, tree = pose.origin[2] - below, street & (bare.instance == StaticClass.VEGETATION)
    gain = snowy.luminance / bare.luminance
    leaves, trunks = gain[tree & (height > 3.0)], gain[tree & (height < 2.0)]
    assert min(leaves.size, trunks.size) > 500
    assert np.median(leaves) > 1.5 * np.median(trunks)  # which get what the ground reflects


def snow_gain(texture: int) -> tuple[float, float, float]:
    """How much brighter snow makes a lone crown's upper, middle and lower third."""
    scenery = scenery_of(STREET)
    group = scenery.groups[scenery.groups[:, 7] >= 0][:1].copy()
    group[0, 1] = group[0, 0]  # no trunk
    group[0, 2:5] = group[0, 8:11] = 14.0, -1.75, 2.5
    group[0, 5], group[0, 7] = 5.0, texture
    group[0, 11:13] = 2.0, 2.0
    group[0, 13:16] = 0.1
    far = scenery.panels[:1].copy()
    far[0, 0] = -500.0
    alone = dataclasses.replace(scenery, groups=group, panels=far)
    pictures = []
    for cover in (0.0, 1.0):
        camera = CameraConfig(width_px=900, height_px=512)
        view = Renderer(camera)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("pedcross_env.camera.renderer.scenery_for", lambda street: alone)
            view.load(STREET, Weather(cloudiness=1.0, snow_cover=cover))
        pictures.append(view.render(snapshot()))
    tree = pictures[0].instance == StaticClass.VEGETATION
    rows = np.flatnonzero(tree.sum(axis=1) > 5)
    mean = [np.array([frame.luminance[row][tree[row]].mean() for row in rows]) for frame in pictures]
    gain, third = mean[1] / mean[0], len(rows) // 3
    assert third > 20
    return float(gain[:third].mean()), float(gain[third:-third].mean()), float(gain[-third:].mean())


def test_snow_lies_on_a_crowns_top_more_than_on_what_leaves_shelter() -> None:
    top, middle, foot = snow_gain(ROUND[0])
    assert top > 1.3 * middle
    assert middle > 1.02 * foot
    bare_top, _, bare_foot = snow_gain(BARE[0])
    assert bare_foot / bare_top > 1.1 * foot / top  # bare branches shelter less


@pytest.mark.parametrize("azimuth_deg", [1.0, 15.0])
def test_leaves_before_the_low_sun_have_no_colour_that_is_less_than_nothing(azimuth_deg: float) -> None:
    """What is below zero in one colour is cut off; the luminance alone would take it from the others."""
    low_sun = Weather(sun_altitude_deg=15.0, sun_azimuth_deg=azimuth_deg)
    view = renderer(low_sun, horizontal_fov_deg=90.0, pitch_deg=-10.0)
    for x in (36.0, 37.0, 38.0, 39.0):
        grey, colour = view.render(snapshot(x=x), luminance_only=True), view.render(snapshot(x=x))
        leaves = colour.instance == StaticClass.VEGETATION
        assert np.count_nonzero(leaves) > 1000
        np.testing.assert_allclose(grey.luminance[leaves], colour.luminance[leaves], rtol=2e-4)
