"""Cameras by name, and where a mount and its angles put the optical axis."""

import math

import numpy as np
import pytest
from camera_scenes import vehicle

from pedcross_env.camera import camera_pose, project
from pedcross_env.config import CAMERA_PRESETS, CameraConfig, EnvConfig, camera_preset, from_mapping
from pedcross_env.errors import ConfigError

EGO = vehicle(1, 5.0, -1.75, yaw=0.3, pitch=0.02)


def test_a_preset_is_reached_by_name_from_a_mapping():
    assert from_mapping(EnvConfig, {"camera": "carla"}).camera == camera_preset("carla")
    changed = from_mapping(
        EnvConfig, {"camera": {"preset": "carla", "width_px": 800, "height_px": 300}}
    ).camera
    assert (changed.width_px, changed.height_px, changed.horizontal_fov_deg) == (800, 300, 90.0)
    assert (camera_preset("carla").width_px, camera_preset("carla").height_px) == (1600, 600)
    assert camera_preset("default") == CameraConfig()


def test_the_paper_sees_as_wide_as_carla_in_fewer_pixels():
    assert camera_preset("paper").width_px == 450
    assert camera_preset("paper").horizontal_fov_deg == camera_preset("carla").horizontal_fov_deg


def test_pies_dashcam_has_the_published_matrix_at_any_size():
    camera = camera_preset("pie")
    pose = camera_pose(camera, EGO)
    assert camera.focal_px == pytest.approx(1004.6, abs=0.3)  # fx 1004.84, fy 1004.39
    assert (pose.cx, pose.cy) == pytest.approx((960.10 + 0.5, 573.55 + 0.5), abs=0.01)
    small = camera_preset("pie_small")
    quarter = camera_pose(small, EGO)
    assert (small.focal_px * 4, quarter.cx * 4, quarter.cy * 4) == pytest.approx(
        (camera.focal_px, pose.cx, pose.cy)
    )


@pytest.mark.parametrize("name", list(CAMERA_PRESETS))
def test_every_preset_can_be_changed(name):
    assert camera_preset(name, mount_y_m=0.4).mount_y_m == 0.4


def test_unknown_names_are_answered_with_the_nearest():
    with pytest.raises(ConfigError, match="carla"):
        camera_preset("crala")
    with pytest.raises(ConfigError, match="pitch_deg"):
        camera_preset("carla", pitch_dg=1.0)
    with pytest.raises(ConfigError, match="carla"):
        from_mapping(EnvConfig, {"camera": "carlas"})


@pytest.mark.parametrize(
    "wrong",
    [{"roll_deg": 90.0}, {"lens": "brown"}, {"distortion": (0.1, 0.0)}, {"principal_point": (0.5, 1.2)},
     {"lens": "fisheye", "distortion": (0.1, 0.0)}, {"lens": "brwn"}],
)  # fmt: skip
def test_settings_that_cannot_be_are_refused(wrong):
    with pytest.raises(ConfigError):
        CameraConfig(**wrong)


def test_the_pose_is_a_rotation_whatever_the_angles():
    pose = camera_pose(CameraConfig(yaw_deg=20.0, pitch_deg=-7.0, roll_deg=12.0), EGO)
    assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(3))
    assert np.linalg.det(pose.rotation) == pytest.approx(1.0)


def test_yaw_looks_left_pitch_looks_down_and_roll_drops_the_right():
    level = vehicle(1, 0.0, 0.0)
    ahead = np.array([[100.0, 0.0, 1.35]])
    u, v, _ = project(camera_pose(CameraConfig(yaw_deg=5.0, mount_x_m=0.0), level), ahead)[0]
    assert u == pytest.approx(225 + CameraConfig().focal_px * math.tan(math.radians(5.0)))
    assert v == pytest.approx(128)
    u, v, _ = project(camera_pose(CameraConfig(pitch_deg=5.0, mount_x_m=0.0), level), ahead)[0]
    assert (u, v) == pytest.approx((225, 128 - CameraConfig().focal_px * math.tan(math.radians(5.0))))
    right = np.array(
        [[100.0, -10.0, 1.35]]
    )  # where the right side drops, what is on the right appears higher
    u, v, _ = project(camera_pose(CameraConfig(roll_deg=10.0, mount_x_m=0.0), level), right)[0]
    reach = CameraConfig().focal_px * 0.1
    turned = (225 + reach * math.cos(math.radians(10)), 128 - reach * math.sin(math.radians(10)))
    assert (u, v) == pytest.approx(turned)


def test_the_mount_rides_on_the_car():
    camera = CameraConfig(mount_x_m=1.5, mount_y_m=0.4, mount_z_m=1.2)
    origin = camera_pose(camera, vehicle(1, 3.0, 2.0, yaw=math.pi / 2)).origin
    assert origin == pytest.approx([2.6, 3.5, 1.2])
    nose_down = camera_pose(camera, vehicle(1, 0.0, 0.0, pitch=0.02)).origin
    assert nose_down[2] == pytest.approx(1.2 * math.cos(0.02) - 1.5 * math.sin(0.02))
