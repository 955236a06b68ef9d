"""Lenses against OpenCV's projection, and what a resampled picture keeps of the pinhole's."""

import math

import cv2
import numpy as np
import pytest
from camera_scenes import STREET, pedestrian, renderer, snapshot, vehicle

from pedcross_env.camera import Renderer, camera_pose, project, rays
from pedcross_env.config import CameraConfig, camera_preset
from pedcross_env.errors import ConfigError
from pedcross_env.optics import distort, undistort
from pedcross_env.weather.weather import Weather

BROWN = ("brown", (-0.28, 0.07, 0.001, -0.002))
FISHEYE = ("fisheye", camera_preset("pie").distortion)


@pytest.mark.parametrize(("lens", "coefficients"), [BROWN, FISHEYE, ("brown", (-0.2, 0.05))])
def test_distortion_is_opencvs(lens, coefficients):
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-0.8, 0.8, (2, 200))
    points = np.stack([x, y, np.ones(200)], axis=1).reshape(-1, 1, 3)
    zero, eye = np.zeros(3), np.eye(3)
    k = np.array([*coefficients, 0.0, 0.0][:4])
    if lens == "brown":
        expected = cv2.projectPoints(points, zero, zero, eye, k)[0].reshape(-1, 2)
    else:
        expected = cv2.fisheye.projectPoints(points, zero, zero, eye, k)[0].reshape(-1, 2)
    np.testing.assert_allclose(np.stack(distort(lens, coefficients, x, y), axis=1), expected, atol=1e-9)


@pytest.mark.parametrize(("lens", "coefficients"), [BROWN, FISHEYE, ("pinhole", ())])
def test_rays_go_back_to_their_points(lens, coefficients):
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-0.7, 0.7, (2, 200))
    u, v = undistort(lens, coefficients, *distort(lens, coefficients, x, y))
    np.testing.assert_allclose([u, v], [x, y], atol=1e-7)


@pytest.mark.parametrize(("lens", "coefficients"), [BROWN, FISHEYE])
def test_an_actor_is_seen_where_the_lens_projects_it(lens, coefficients):
    camera = renderer(
        width_px=320, height_px=200, horizontal_fov_deg=70.0, lens=lens, distortion=coefficients
    )
    scene = snapshot(pedestrian(7, 12.3, -4.5), vehicle(8, 14.0, 1.2))
    frame = camera.render(scene)
    pose = camera_pose(camera.config, scene.ego)
    head = project(pose, np.array([[12.3, -4.5, 1.66]]))[0]
    assert frame.instance[int(head[1]), int(head[0])] == 7
    rows, columns = np.nonzero(frame.instance == 7)
    foot = project(pose, np.array([[12.3, -4.5, 0.0]]))[0]
    assert rows.max() == pytest.approx(foot[1], abs=1.5)
    assert np.abs(frame.depth[rows, columns] - 12.0).max() < 0.6
    assert abs(columns.mean() - head[0]) < 2


@pytest.mark.parametrize(("lens", "coefficients"), [BROWN, FISHEYE])
def test_depth_lies_on_the_ground_along_the_lens_rays(lens, coefficients):
    camera = renderer(
        width_px=160, height_px=100, horizontal_fov_deg=70.0, lens=lens, distortion=coefficients
    )
    frame = camera.render(snapshot())
    pose = camera_pose(camera.config, snapshot().ego)
    v, u = np.array([70, 80, 95]), np.array([80, 60, 90])
    ray = rays(pose, u + 0.5, v + 0.5)
    height = pose.origin[2] + frame.depth[v, u] * ray[:, 2]
    np.testing.assert_allclose(height, 0.0, atol=0.04)


def test_a_straight_lens_changes_little():
    camera = {"width_px": 160, "height_px": 100}
    scene = snapshot(pedestrian(7, 12.3, -1.0), vehicle(8, 14.0, 3.2))
    plain = renderer(**camera).render(scene)
    lens = renderer(**camera, lens="brown", distortion=(1e-9, 0.0)).render(scene)
    assert np.mean(plain.instance == lens.instance) > 0.99
    np.testing.assert_allclose(lens.luminance.mean(), plain.luminance.mean(), rtol=0.01)


def test_luminance_alone_is_that_of_the_colours_through_a_lens():
    camera = renderer(width_px=120, height_px=80, lens="brown", distortion=(-0.2, 0.02))
    scene = snapshot(vehicle(8, 14.0, 1.2))
    full, alone = camera.render(scene), camera.render(scene, luminance_only=True)
    np.testing.assert_allclose(alone.luminance, full.luminance, rtol=1e-4)
    mixed = np.tensordot(np.array([0.2126, 0.7152, 0.0722]), full.radiance, 1)
    np.testing.assert_allclose(full.luminance, mixed, rtol=1e-4)
    assert alone.depth is None


def test_pies_dashcam_sees_as_far_aside_as_its_data_sheet_says():
    """110 degrees across 7.14 mm; the video's 1920 columns show a little more than the sheet's nominal angle."""
    pose = camera_pose(camera_preset("pie"), snapshot().ego)
    ray = rays(pose, np.array([0.0, 1920.0]), np.array([574.05, 574.05]))
    ahead = pose.rotation[2]
    aside = [math.degrees(math.acos(float(r @ ahead) / float(np.linalg.norm(r)))) for r in ray]
    assert 108 < sum(aside) < 120


def test_a_lens_that_folds_is_refused():
    with pytest.raises(ConfigError, match="no ray"):
        Renderer(CameraConfig(lens="brown", distortion=(-0.9, 0.0), horizontal_fov_deg=120.0))
    with pytest.raises(ConfigError, match="degrees"):
        Renderer(CameraConfig(lens="fisheye", distortion=(0.0, 0.0, 0.0, 0.0), horizontal_fov_deg=100.0))


def test_visible_fraction_through_a_lens():
    camera = Renderer(CameraConfig(lens="brown", distortion=(-0.2, 0.02)))
    camera.load(STREET, Weather())
    scene = snapshot(pedestrian(7, 12.0, -1.0))
    assert camera.visible_fraction(camera.render(scene), scene, 7) == pytest.approx(1.0, abs=0.03)
