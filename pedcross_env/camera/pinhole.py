"""The pinhole camera: where it is on the ego and how points project."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pedcross_env.config import CameraConfig

__all__ = ["CameraPose", "camera_pose", "project"]


@dataclass(frozen=True, slots=True)
class CameraPose:
    """A camera in the world.

    Attributes:
        origin: (3,) float64, metres, world.
        rotation: (3, 3) float64, world to camera; the camera's axes are x right, y down, z forward.
        focal_px: Focal length, square pixels.
        cx: Principal point, continuous pixels; column i covers [i, i + 1).
        cy: Principal point, continuous pixels; row j covers [j, j + 1).
        width_px: Columns.
        height_px: Rows.
    """

    origin: np.ndarray
    rotation: np.ndarray
    focal_px: float
    cx: float
    cy: float
    width_px: int
    height_px: int


def camera_pose(config: CameraConfig, ego: np.ndarray) -> CameraPose:
    """Place the camera of ``config`` on the ego.

    Args:
        config: Mount and optics.
        ego: One ACTOR_DTYPE record; its pitch turns the mount about the ego's centre on the ground.

    Returns:
        The pose; the camera has no roll.
    """
    yaw, body = float(ego["yaw"]), float(ego["pitch"])
    nose_down = body + math.radians(config.pitch_deg)
    heading = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    ahead = config.mount_x_m * math.cos(body) + config.mount_z_m * math.sin(body)
    above = config.mount_z_m * math.cos(body) - config.mount_x_m * math.sin(body)
    origin = np.array([float(ego["x"]), float(ego["y"]), float(ego["z"])]) + ahead * heading + above * up
    forward = math.cos(nose_down) * heading - math.sin(nose_down) * up
    down = -math.sin(nose_down) * heading - math.cos(nose_down) * up
    right = np.array([math.sin(yaw), -math.cos(yaw), 0.0])
    return CameraPose(
        origin, np.stack([right, down, forward]), config.focal_px,
        config.width_px / 2, config.height_px / 2, config.width_px, config.height_px,
    )  # fmt: skip


def project(pose: CameraPose, points: np.ndarray) -> np.ndarray:
    """Project world points.

    Args:
        pose: The camera.
        points: (N, 3) metres, world.

    Returns:
        (N, 3) float64: column u, row v (continuous pixels) and depth along the optical axis in metres; u and v
        are nan for points that are not in front of the camera.
    """
    local = (np.asarray(points, dtype=np.float64).reshape(-1, 3) - pose.origin) @ pose.rotation.T
    depth = local[:, 2]
    safe = np.where(depth > 0, depth, np.nan)
    return np.stack(
        [pose.cx + pose.focal_px * local[:, 0] / safe, pose.cy + pose.focal_px * local[:, 1] / safe, depth],
        axis=1,
    )
