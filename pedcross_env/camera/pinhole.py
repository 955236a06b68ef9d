"""The pinhole camera: where it is on the ego and how points project."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pedcross_env.config import CameraConfig
from pedcross_env.optics import distort, undistort

__all__ = ["CameraPose", "camera_pose", "project", "rays"]


Axis = tuple[float, float, float]


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
        lens: Of CameraConfig; ``project`` and ``rays`` follow it, the pose itself is the pinhole's.
        distortion: The lens's coefficients.
    """

    origin: np.ndarray
    rotation: np.ndarray
    focal_px: float
    cx: float
    cy: float
    width_px: int
    height_px: int
    lens: str = "pinhole"
    distortion: tuple[float, ...] = ()

    def turned(self, vector: Iterable[float]) -> list[float]:
        """Turn a direction of the world into camera coordinates, without BLAS, whose sums differ between machines."""
        x, y, z = vector
        return [right * x + down * y + ahead * z for right, down, ahead in self.rotation.tolist()]


def camera_pose(config: CameraConfig, ego: np.ndarray) -> CameraPose:
    """Place the camera of ``config`` on the ego.

    Args:
        config: Mount, angles and optics; see camera.lens for its distortion.
        ego: One ACTOR_DTYPE record; its pitch turns the mount about the ego's centre on the ground.

    Returns:
        The pose.
    """
    heading, body = float(ego["yaw"]), float(ego["pitch"])
    cos, sin, cos_body, sin_body = math.cos(heading), math.sin(heading), math.cos(body), math.sin(body)
    ahead, left = (cos_body * cos, cos_body * sin, -sin_body), (-sin, cos, 0.0)
    above = (sin_body * cos, sin_body * sin, cos_body)
    foot = float(ego["x"]), float(ego["y"]), float(ego["z"])
    x, y, z = config.mount_x_m, config.mount_y_m, config.mount_z_m
    origin = [foot[k] + x * ahead[k] + y * left[k] + z * above[k] for k in range(3)]
    ahead, left = _rotated(ahead, left, config.yaw_deg)
    above, ahead = _rotated(above, ahead, config.pitch_deg)
    left, above = _rotated(left, above, config.roll_deg)
    across, down = config.principal_point
    return CameraPose(
        np.array(origin), np.array([[-v for v in left], [-v for v in above], ahead]), config.focal_px,
        across * config.width_px, down * config.height_px, config.width_px, config.height_px,
        config.lens, config.distortion,
    )  # fmt: skip


def _rotated(first: Axis, second: Axis, angle_deg: float) -> tuple[Axis, Axis]:
    """Turn two axes by an angle from the first towards the second."""
    if angle_deg == 0.0:
        return first, second
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    (x, y, z), (p, q, r) = first, second
    return (c * x + s * p, c * y + s * q, c * z + s * r), (c * p - s * x, c * q - s * y, c * r - s * z)


def project(pose: CameraPose, points: np.ndarray) -> np.ndarray:
    """Project world points.

    Args:
        pose: The camera.
        points: (N, 3) metres, world.

    Returns:
        (N, 3) float64: column u, row v (continuous pixels) and depth along the optical axis in metres; u and v
        are nan for points that are not in front of the camera.
    """
    offset = np.asarray(points, dtype=np.float64).reshape(-1, 3) - pose.origin
    local = (offset[:, None, :] * pose.rotation[None]).sum(axis=2)
    depth = local[:, 2]
    safe = np.where(depth > 0, depth, np.nan)
    x, y = distort(pose.lens, pose.distortion, local[:, 0] / safe, local[:, 1] / safe)
    return np.stack([pose.cx + pose.focal_px * x, pose.cy + pose.focal_px * y, depth], axis=1)


def rays(pose: CameraPose, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Directions in the world of what is seen at places in the picture.

    Args:
        pose: The camera.
        u: Columns, continuous pixels, any shape.
        v: Rows, the same shape.

    Returns:
        (..., 3) float64, of depth 1: a point at depth z is ``pose.origin + z * ray``.
    """
    x, y = undistort(pose.lens, pose.distortion, (u - pose.cx) / pose.focal_px, (v - pose.cy) / pose.focal_px)
    right, down, ahead = pose.rotation
    return x[..., None] * right + y[..., None] * down + ahead
