"""How far the image moves between two moments: decides how often the event camera's scene is rendered."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera import CameraPose, camera_pose, project, rays
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import Snapshot
from pedcross_env.scenario import StreetSpec

__all__ = ["image_flow_px"]

NEAR_M = 0.5  # points nearer than this to the image plane are not followed
LOOK_AHEAD_M = 30.0  # how far ahead actors may bound the free space beside the ego


def image_flow_px(camera: CameraConfig, street: StreetSpec, before: Snapshot, after: Snapshot) -> float:
    """Largest displacement, in pixels, of what is in view: ground, the walls beside the street, actors.

    The static scene moves fastest at the image's edges, so it is followed there: the ground under the
    bottom row and the nearest vertical side (a parked car, else the facades) at the left and right columns.

    Args:
        camera: Camera and mount.
        street: Gives the distance of the facades.
        before: The scene at the first moment.
        after: The same actors in the same order at the second.
    """
    pose0, pose1 = camera_pose(camera, before.ego), camera_pose(camera, after.ego)
    static = _edge_points(pose0, street, before)
    return max(
        _displacement(pose0, pose1, static, static, camera),
        _displacement(pose0, pose1, _corners(before.actors), _corners(after.actors), camera),
    )


def _displacement(
    pose0: CameraPose, pose1: CameraPose, points0: np.ndarray, points1: np.ndarray, camera: CameraConfig
) -> float:
    if len(points0) == 0:
        return 0.0
    first, second = project(pose0, points0), project(pose1, points1)
    margin = 1.0
    seen = (
        (first[:, 2] > NEAR_M) & (second[:, 2] > NEAR_M)
        & (first[:, 0] > -margin) & (first[:, 0] < camera.width_px + margin)
        & (first[:, 1] > -margin) & (first[:, 1] < camera.height_px + margin)
    )  # fmt: skip
    if not seen.any():
        return 0.0
    return float(np.hypot(*(second[seen, :2] - first[seen, :2]).T).max())


def _edge_points(pose: CameraPose, street: StreetSpec, snapshot: Snapshot) -> np.ndarray:
    """Scene points seen at the image's edges: (N, 3) in world coordinates."""
    width, height = pose.width_px, pose.height_px
    origin = np.asarray(pose.origin)
    points = []
    for u in (0.0, width / 2, width):
        ray = _ray(pose, u, float(height))
        if ray[2] < -1e-6:
            points.append(origin - ray * (origin[2] / ray[2]))
    left, right = _free_sides_m(street, snapshot)
    for u, side_y in ((0.0, left), (float(width), right)):
        for v in (pose.cy, float(height)):
            ray = _ray(pose, u, v)
            reach = (side_y - origin[1]) / ray[1] if abs(ray[1]) > 1e-6 else -1.0
            point = origin + reach * ray
            if reach > 0 and point[2] >= 0:
                points.append(point)
    return np.array(points).reshape(-1, 3)


def _ray(pose: CameraPose, u: float, v: float) -> np.ndarray:
    return rays(pose, np.array(u), np.array(v))


def _free_sides_m(street: StreetSpec, snapshot: Snapshot) -> tuple[float, float]:
    """World y of the nearest vertical surface to the left and to the right of the ego."""
    ego, actors = snapshot.ego, snapshot.actors
    left, right = street.facade_y_m, -street.facade_y_m
    ahead = actors[(actors["x"] > ego["x"]) & (actors["x"] < ego["x"] + LOOK_AHEAD_M)]
    half = ahead["width"] / 2
    on_left, on_right = ahead["y"] > ego["y"] + 1.0, ahead["y"] < ego["y"] - 1.0
    if on_left.any():
        left = min(left, float((ahead["y"] - half)[on_left].min()))
    if on_right.any():
        right = max(right, float((ahead["y"] + half)[on_right].max()))
    return left, right


def _corners(actors: np.ndarray) -> np.ndarray:
    """Corners of the actors' boxes: (8 N, 3)."""
    cos, sin = np.cos(actors["yaw"]), np.sin(actors["yaw"])
    points = []
    for along in (-0.5, 0.5):
        for across in (-0.5, 0.5):
            dx, dy = along * actors["length"], across * actors["width"]
            x, y = actors["x"] + cos * dx - sin * dy, actors["y"] + sin * dx + cos * dy
            points += [np.stack([x, y, actors["z"] + up * actors["height"]], axis=1) for up in (0.0, 1.0)]
    return np.concatenate(points) if points else np.empty((0, 3))
