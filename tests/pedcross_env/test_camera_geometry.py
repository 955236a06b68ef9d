"""The camera's geometry against pinhole arithmetic, and what images keep whatever is in front of it."""

import dataclasses
import math

import numpy as np
import pytest
from camera_scenes import NIGHT, STREET, pedestrian, renderer, snapshot, vehicle

from pedcross_env.camera import Renderer, camera_pose, project
from pedcross_env.camera.layout import scenery_for
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import StaticClass
from pedcross_env.errors import ConfigError
from pedcross_env.weather import WEATHERS
from pedcross_env.weather.weather import Weather


@pytest.mark.parametrize(("height_m", "distance_m"), [(1.75, 8.0), (1.75, 20.0), (1.2, 12.0), (1.9, 40.0)])
def test_a_standing_pedestrian_is_as_tall_as_the_pinhole_says(height_m, distance_m):
    camera = renderer()
    scene = snapshot(pedestrian(7, 0.3 + distance_m, -1.75, height=height_m))
    rows = np.flatnonzero((camera.render(scene).instance == 7).any(axis=1))
    expected = camera.config.focal_px * height_m / distance_m
    # the feet are nearer than the middle: their toes reach a little below the point under the body
    assert rows[-1] - rows[0] + 1 == pytest.approx(expected, abs=1 + 0.02 * expected)
    pose = camera_pose(camera.config, scene.ego)
    top = project(pose, np.array([[0.3 + distance_m, -1.75, height_m]]))[0, 1]
    assert rows[0] == pytest.approx(top, abs=1.01)


def test_projection_agrees_with_the_optical_axis_and_the_horizon():
    config = CameraConfig(width_px=200, height_px=100)
    level, nose_down = (camera_pose(config, snapshot(pitch=p).ego) for p in (0.0, 0.05))
    u, v, depth = project(level, level.origin[None] + np.array([[10.0, 0.0, 0.0]]))[0]
    assert (u, v, depth) == pytest.approx((100.0, 50.0, 10.0))
    assert project(nose_down, nose_down.origin[None] + np.array([[1e6, 0.0, 0.0]]))[0, 1] == pytest.approx(
        50 - config.focal_px * math.tan(0.05)
    )
    left = project(level, level.origin[None] + np.array([[10.0, 2.0, 0.0]]))[0, 0]
    assert left < 100.0


def test_depth_of_the_ground_is_that_of_its_plane():
    camera = renderer()
    frame = camera.render(snapshot())
    column = camera.config.width_px // 2
    for row in range(150, 256, 15):
        assert frame.instance[row, column] == StaticClass.GROUND
        expected = camera.config.focal_px * camera.config.mount_z_m / (row + 0.5 - 128)
        assert frame.depth[row, column] == pytest.approx(expected, rel=1e-3)


def test_the_nearest_actor_owns_the_pixel_whatever_the_order():
    camera = renderer()
    near, far = vehicle(5, 12.0, -1.75), vehicle(6, 25.0, -1.75, height=1.5)
    for actors in ((near, far), (far, near)):
        frame = camera.render(snapshot(*actors))
        u, v, _ = project(camera_pose(camera.config, snapshot().ego), np.array([[9.8, -1.75, 0.7]]))[0]
        assert frame.instance[int(v), int(u)] == 5
        assert 9.0 < frame.depth[int(v), int(u)] < 10.5
    only_far = camera.render(snapshot(far)).instance == 6
    assert (camera.render(snapshot(near, far)).instance == 6).sum() < 0.7 * only_far.sum()


@pytest.mark.parametrize("x", [6.0, 8.0, 10.0])
def test_a_lamp_post_stands_on_its_foot(x):
    camera, found = renderer(width_px=1800, height_px=1024), 0
    scene = snapshot(x=x)
    pose, picture = camera_pose(camera.config, scene.ego), camera.render(scene).instance
    scenery = scenery_of(STREET)
    for post in scenery.capsules[
        scenery.groups[scenery.groups[:, 6] == StaticClass.FURNITURE, 0].astype(int)
    ]:
        u, v, ahead = project(pose, post[None, :3])[0]
        if 7.0 < ahead < 16.0 and 20.0 < u < 1780.0:
            radius = pose.focal_px * post[6] / ahead
            columns = picture[:, int(u - 0.5 * radius) : int(u + 0.5 * radius) + 1]
            lowest = np.flatnonzero((columns == StaticClass.FURNITURE).any(axis=1)).max() + 1
            assert lowest == pytest.approx(v, abs=0.1 * radius + 1.0)
            found += 1
    assert found > 0


def test_a_house_hides_what_stands_behind_it():
    camera = renderer()
    behind = pedestrian(9, 40.0, STREET.facade_y_m + 6.0)
    frame = camera.render(snapshot(behind))
    assert not (frame.instance == 9).any()
    assert (frame.instance == StaticClass.BUILDING).any()


def test_depth_of_ids_is_within_the_actors_extent():
    camera = renderer()
    frame = camera.render(
        snapshot(
            pedestrian(7, 15.0, 0.5, gait_stride=1.4, gait_phase=0.2), vehicle(8, 30.0, 1.75, yaw=math.pi)
        )
    )
    assert np.abs(frame.depth[frame.instance == 7] - 14.7).max() < 1.0
    assert np.abs(frame.depth[frame.instance == 8] - 29.7).max() < 2.6
    assert np.isinf(frame.depth[frame.instance == StaticClass.SKY]).all()
    assert np.isfinite(frame.depth[frame.instance != StaticClass.SKY]).all()


@pytest.mark.parametrize("weather", [Weather(), NIGHT], ids=["day", "night"])
def test_nothing_is_nan_when_actors_cross_the_near_plane(weather):
    camera = renderer(weather, width_px=160, height_px=90)
    for gap in (-1.0, -0.2, 0.0, 0.1, 0.3, 0.7, 1.5):
        scene = snapshot(
            vehicle(4, 0.3 + gap, -1.2, headlight=1.0),
            vehicle(3, 0.3 + gap, -3.4, yaw=1.0),
            pedestrian(5, 0.3 + gap, -1.9, gait_stride=1.3),
            headlight=1.0,
        )
        frame = camera.render(scene)
        assert np.isfinite(frame.luminance).all()
        assert (frame.luminance >= 0).all()
        assert not np.isnan(frame.depth).any()


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_car_beside_the_camera_reaches_the_edge_of_the_image(side):
    """Its side runs from behind the camera to 3.4 m ahead."""
    frame = renderer().render(snapshot(vehicle(4, 1.5, 0.3 if side == "left" else -3.8)))
    seen = frame.instance[205:235, :65] if side == "left" else frame.instance[205:235, -65:]
    assert (seen == 4).all()


@pytest.mark.parametrize(("width", "height"), [(32, 32), (1600, 600), (33, 47)])
def test_all_sizes_and_no_actors_at_all(width, height):
    frame = renderer(width_px=width, height_px=height).render(snapshot())
    assert frame.luminance.shape == (height, width)
    assert frame.radiance.shape == (3, height, width)
    assert np.isfinite(frame.radiance).all()
    assert frame.luminance.min() > 0


def test_yawed_and_pitched_cameras_see_a_whole_image():
    for yaw, pitch in ((0.4, 0.0), (-2.5, 0.05), (math.pi / 2, -0.04)):
        frame = renderer(width_px=96, height_px=64).render(snapshot(yaw=yaw, pitch=pitch))
        assert np.isfinite(frame.luminance).all()
        assert frame.luminance.min() > 0


def test_rendering_before_loading_says_what_to_do():
    with pytest.raises(ConfigError, match="load"):
        Renderer(CameraConfig()).render(snapshot())


@pytest.mark.parametrize("seed", range(3))
def test_a_straight_street_ends_in_houses(seed):
    """Ahead, at the height of a first floor, there is no sky: from afar, near the end and at any place across."""
    for x, y in ((0.0, -1.75), (120.0, 0.0), (220.0, 2.5)):
        camera = renderer()
        camera.load(dataclasses.replace(STREET, seed=seed), Weather())
        scene = snapshot(x=x)
        scene.ego["y"] = y
        frame, pose = camera.render(scene), camera_pose(camera.config, scene.ego)
        middle, horizon = round(pose.cx), round(pose.cy)
        ahead = frame.instance[horizon - 3 : horizon, middle - 3 : middle + 4]
        assert (ahead == StaticClass.BUILDING).all()
        houses = STREET.end_x_m + 40.0
        assert (frame.depth[horizon - 2, middle - 2 : middle + 3] > houses - x).all()
        assert (frame.depth[horizon - 2, middle - 2 : middle + 3] < houses + 60.0 - x).all()


@pytest.mark.parametrize("seed", range(8))
def test_a_low_sun_ahead_stands_above_the_end_of_the_street(seed):
    """Seen from where people cross at the latest."""
    street = dataclasses.replace(STREET, seed=seed)
    panels = scenery_for(street).panels
    fronts = panels[(panels[:, 11] > 0) & (panels[:, 43] == 0)]
    across = fronts[(np.abs(fronts[:, 4]) > 0.5) & (fronts[:, 0] > street.end_x_m)]
    assert len(across) >= 3
    assert (np.diff(np.sort(across[:, 7])) > 0).any()
    crossing = street.end_x_m - 150.0
    rise = (across[:, 7] - 1.35) / (across[:, 0] - crossing)
    assert np.degrees(np.arctan(rise)).max() < WEATHERS["low_sun"].sun_altitude_deg - 0.5
