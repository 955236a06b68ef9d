"""Who is in the camera's picture, by geometry alone: nothing is rendered and nothing hides anybody."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.pinhole import camera_pose
from pedcross_env.config import CameraConfig
from pedcross_env.optics import distort, undistort

__all__ = ["CameraView"]

_BODY = np.array([0.0, 0.25, 0.5, 0.75, 1.0])  # shares of the height at which a body is looked for
_SLACK = 1e-6  # of the focal length


class CameraView:
    """What the camera on the ego takes in, with its mount, angles and lens.

    Args:
        camera: As the environment's.
    """

    def __init__(self, camera: CameraConfig) -> None:
        self._camera = camera
        # Rays that the picture's edges see: a distortion may fold what lies beyond them back into it.
        w, h, f = camera.width_px, camera.height_px, camera.focal_px
        cx, cy = camera.principal_point[0] * w, camera.principal_point[1] * h
        u, v = np.linspace(0, w, 17), np.linspace(0, h, 17)
        edges = [(u, np.zeros(17)), (u, np.full(17, h)), (np.zeros(17), v), (np.full(17, w), v)]
        rays = [undistort(camera.lens, camera.distortion, (a - cx) / f, (b - cy) / f) for a, b in edges]
        x, y = (np.concatenate([ray[k] for ray in rays]) for k in (0, 1))
        self._low = np.array([np.nanmin(x), np.nanmin(y)]) - _SLACK
        self._high = np.array([np.nanmax(x), np.nanmax(y)]) + _SLACK

    def shows(self, ego: np.ndarray, x_m: np.ndarray, y_m: np.ndarray, height_m: np.ndarray) -> np.ndarray:
        """Whether any part of a body on the road is in the picture.

        Args:
            ego: ACTOR_DTYPE record that the camera is mounted on.
            x_m: (N,) where they stand.
            y_m: (N,).
            height_m: (N,).

        Returns:
            (N,) bool.
        """
        pose = camera_pose(self._camera, ego)
        z = height_m[:, None] * _BODY
        points = np.stack(
            [np.broadcast_to(x_m[:, None], z.shape), np.broadcast_to(y_m[:, None], z.shape), z], -1
        )
        local = (points.reshape(-1, 3) - pose.origin) @ pose.rotation.T
        ahead = local[:, 2] > 1e-3
        slopes = local[:, :2] / np.where(ahead, local[:, 2], 1.0)[:, None]
        kept = ahead & ((slopes >= self._low) & (slopes <= self._high)).all(axis=1)
        x, y = distort(pose.lens, pose.distortion, *slopes.T)
        u, v = pose.cx + pose.focal_px * x, pose.cy + pose.focal_px * y
        inside = (u >= 0) & (u <= self._camera.width_px) & (v >= 0) & (v <= self._camera.height_px)
        return (kept & inside).reshape(z.shape).any(axis=1)
