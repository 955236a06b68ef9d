"""How far the image moves between two moments: decides how often the event camera's scene is rendered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pedcross_env.camera import CameraPose, camera_pose, project, rays
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import Snapshot
from pedcross_env.scenario import StreetSpec

__all__ = ["image_flow_px"]

NEAR_M = 0.5  # points nearer than this to the image plane are not followed
INSTANT = (
    1 / 32
)  # of the interval: flow is that of a moment, since what leaves the picture is not followed beyond
_MARGIN_PX = 1.0
# corners of a box from above
_AROUND, _ACROSS = np.array([-0.5, 0.5, 0.5, -0.5]), np.array([-0.5, -0.5, 0.5, 0.5])
_NEXT = [1, 2, 3, 0]


def image_flow_px(camera: CameraConfig, street: StreetSpec, before: Snapshot, after: Snapshot) -> float:
    """How far what is in view moves, in pixels, at the fastest: ground, the walls beside the street, actors.

    The static scene moves fastest at the image's edges, so it is followed there: the ground under the bottom row and
    what the rays through the left and right columns meet, be it an actor's side or the facades. Actors are followed at
    their corners. The speeds at both moments are taken, times the interval, and the larger one counts.

    Args:
        camera: Camera and mount.
        street: Gives the distance of the facades.
        before: The scene at the first moment.
        after: The same actors in the same order at the second.
    """
    poses = camera_pose(camera, before.ego), camera_pose(camera, after.ego)
    boxes = _Boxes(before.actors, before.actors), _Boxes(after.actors, before.actors)
    return max(_speed_px(*poses, *boxes, street), _speed_px(*poses[::-1], *boxes[::-1], street))


class _Boxes:
    """The actors' boxes at a moment, as high as at the first one.

    Attributes:
        feet: Corners from above, in order around: (N, 4, 2).
        low, high: (N,) metres.
        corners: (8 N, 3).
    """

    def __init__(self, actors: np.ndarray, first: np.ndarray) -> None:
        cos, sin = np.cos(actors["yaw"])[:, None], np.sin(actors["yaw"])[:, None]
        dx, dy = _AROUND * actors["length"][:, None], _ACROSS * actors["width"][:, None]
        number = len(actors)
        self.feet = np.empty((number, 4, 2))
        self.feet[..., 0] = actors["x"][:, None] + cos * dx - sin * dy
        self.feet[..., 1] = actors["y"][:, None] + sin * dx + cos * dy
        self.low = first["z"]
        self.high = self.low + first["height"]
        corners = np.empty((2, number, 4, 3))
        corners[..., :2] = self.feet
        corners[0, ..., 2], corners[1, ..., 2] = self.low[:, None], self.high[:, None]
        self.corners = corners.reshape(-1, 3)


def _speed_px(
    pose: CameraPose, other: CameraPose, boxes: _Boxes, moved_boxes: _Boxes, street: StreetSpec
) -> float:
    """Displacement over INSTANT of the way to the other moment, over INSTANT."""
    moved = replace(
        pose,
        origin=pose.origin + INSTANT * (other.origin - pose.origin),
        rotation=pose.rotation + INSTANT * (other.rotation - pose.rotation),
    )
    edge, owner = _edge_points(pose, street, boxes)
    shift = np.zeros((len(edge), 3))
    carried = owner >= 0
    if carried.any():
        shift[carried, :2] = (moved_boxes.feet - boxes.feet).mean(axis=1)[owner[carried]]
    points = np.concatenate([edge, boxes.corners])
    ways = np.concatenate([shift, moved_boxes.corners - boxes.corners])
    return _displacement(pose, moved, points, points + INSTANT * ways) / INSTANT


def _displacement(pose0: CameraPose, pose1: CameraPose, points0: np.ndarray, points1: np.ndarray) -> float:
    first, second = project(pose0, points0), project(pose1, points1)
    seen = (
        (first[:, 2] > NEAR_M) & (second[:, 2] > NEAR_M)
        & (first[:, 0] > -_MARGIN_PX) & (first[:, 0] < pose0.width_px + _MARGIN_PX)
        & (first[:, 1] > -_MARGIN_PX) & (first[:, 1] < pose0.height_px + _MARGIN_PX)
    )  # fmt: skip
    if not seen.any():
        return 0.0
    return float(np.hypot(*(second[seen, :2] - first[seen, :2]).T).max())


def _edge_points(pose: CameraPose, street: StreetSpec, boxes: _Boxes) -> tuple[np.ndarray, np.ndarray]:
    """What is seen at the image's edges: (N, 3) world points and (N,) index of the actor, -1 for what stands still."""
    width, height = float(pose.width_px), float(pose.height_px)
    ray = rays(
        pose,
        np.array([0.0, width / 2, width, 0.0, width]),
        np.array([height, height, height, pose.cy, pose.cy]),
    )
    side_m = np.array([1.0, np.nan, -1.0, 1.0, -1.0]) * street.facade_y_m  # the middle: bonnet and road
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        reach = np.where(ray[:, 2] < -1e-6, -pose.origin[2] / ray[:, 2], np.inf)
        wall = np.where(np.abs(ray[:, 1]) > 1e-6, (side_m - pose.origin[1]) / ray[:, 1], -1.0)
    reach = np.where((wall > 0) & (wall < reach), wall, reach)
    met, actor = _first_met(pose.origin, ray, boxes)
    hides = (met < reach) & ~np.isnan(side_m)
    reach, owner = np.where(hides, met, reach), np.where(hides, actor, -1)
    found = np.isfinite(reach)
    return pose.origin + reach[found, None] * ray[found], owner[found]


def _first_met(origin: np.ndarray, ray: np.ndarray, boxes: _Boxes) -> tuple[np.ndarray, np.ndarray]:
    """Where rays (R, 3) first meet the side of a box: (R,) how many of their lengths away (inf: nowhere), which box."""
    feet = boxes.feet
    if len(feet) == 0:
        return np.full(len(ray), np.inf), np.full(len(ray), -1)
    along = feet[:, _NEXT] - feet
    offset = feet - origin[:2]
    x, y, z = ray.T[:, :, None, None]
    across = x * along[..., 1] - y * along[..., 0]
    safe = np.where(np.abs(across) > 1e-9, across, np.nan)
    reach = (offset[..., 0] * along[..., 1] - offset[..., 1] * along[..., 0]) / safe
    share = (offset[..., 0] * y - offset[..., 1] * x) / safe
    above = origin[2] + reach * z
    hit = (reach > 0) & (share >= 0) & (share <= 1)
    hit &= (above >= boxes.low[:, None]) & (above <= boxes.high[:, None])
    reach = np.where(hit, reach, np.inf).reshape(len(ray), -1)
    nearest = reach.argmin(axis=1)
    return reach[np.arange(len(ray)), nearest], nearest // 4
