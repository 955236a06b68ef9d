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
    pose0, pose1 = camera_pose(camera, before.ego), camera_pose(camera, after.ego)
    feet0, feet1 = _footprints(before.actors), _footprints(after.actors)
    scene = (street, before.actors["z"], before.actors["height"])
    return max(_speed_px(pose0, pose1, feet0, feet1, scene), _speed_px(pose1, pose0, feet1, feet0, scene))


def _speed_px(
    pose: CameraPose, other: CameraPose, feet: np.ndarray, moved_feet: np.ndarray,
    scene: tuple[StreetSpec, np.ndarray, np.ndarray],
) -> float:  # fmt: skip
    """Displacement over INSTANT of the way to the other moment, over INSTANT."""
    street, bottoms, heights = scene
    moved = replace(
        pose,
        origin=pose.origin + INSTANT * (other.origin - pose.origin),
        rotation=pose.rotation + INSTANT * (other.rotation - pose.rotation),
    )
    edge, owner = _edge_points(pose, street, feet, bottoms, heights)
    shift = np.zeros((len(edge), 3))
    carried = owner >= 0
    shift[carried, :2] = (moved_feet - feet).mean(axis=1)[owner[carried]]
    corners, ways = _corners(feet, bottoms, heights), _corners(moved_feet - feet, 0 * bottoms, 0 * heights)
    points, ways = np.concatenate([edge, corners]), np.concatenate([shift, ways])
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


def _edge_points(
    pose: CameraPose, street: StreetSpec, feet: np.ndarray, bottoms: np.ndarray, heights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What is seen at the image's edges: (N, 3) world points and (N,) index of the actor, -1 for what stands still."""
    width, height = float(pose.width_px), float(pose.height_px)
    u = np.array([0.0, width / 2, width, 0.0, width])
    v = np.array([height, height, height, pose.cy, pose.cy])
    points, owners = [], []
    for k, ray in enumerate(rays(pose, u, v)):
        reach = -pose.origin[2] / ray[2] if ray[2] < -1e-6 else np.inf
        owner = -1
        if k != 1:  # the middle of the bottom row: bonnet and road
            side_m = street.facade_y_m if u[k] == 0 else -street.facade_y_m
            wall = (side_m - pose.origin[1]) / ray[1] if abs(ray[1]) > 1e-6 else -1.0
            reach = wall if 0 < wall < reach else reach
            met, actor = _first_met(pose.origin, ray, feet, bottoms, heights)
            if met < reach:
                reach, owner = met, actor
        if np.isfinite(reach):
            points.append(pose.origin + reach * ray)
            owners.append(owner)
    return np.array(points).reshape(-1, 3), np.array(owners, dtype=np.int64)


def _first_met(
    origin: np.ndarray, ray: np.ndarray, feet: np.ndarray, bottoms: np.ndarray, heights: np.ndarray
) -> tuple[float, int]:
    """Where a ray first meets the side of a box: how many of its lengths away (inf: nowhere), and which box."""
    if len(feet) == 0:
        return np.inf, -1
    start, along = feet, np.roll(feet, -1, axis=1) - feet
    across = ray[0] * along[..., 1] - ray[1] * along[..., 0]
    offset = start - origin[:2]
    safe = np.where(np.abs(across) > 1e-9, across, np.nan)
    reach = (offset[..., 0] * along[..., 1] - offset[..., 1] * along[..., 0]) / safe
    share = (offset[..., 0] * ray[1] - offset[..., 1] * ray[0]) / safe
    above = origin[2] + reach * ray[2] - bottoms[:, None]
    hit = (reach > 0) & (share >= 0) & (share <= 1) & (above >= 0) & (above <= heights[:, None])
    reach = np.where(hit, reach, np.inf)
    nearest = int(reach.argmin())
    return float(reach.flat[nearest]), nearest // 4


def _footprints(actors: np.ndarray) -> np.ndarray:
    """Corners of the actors' boxes from above, in order around: (N, 4, 2)."""
    cos, sin = np.cos(actors["yaw"])[:, None], np.sin(actors["yaw"])[:, None]
    dx = np.array([-0.5, 0.5, 0.5, -0.5]) * actors["length"][:, None]
    dy = np.array([-0.5, -0.5, 0.5, 0.5]) * actors["width"][:, None]
    x, y = actors["x"][:, None] + cos * dx - sin * dy, actors["y"][:, None] + sin * dx + cos * dy
    return np.stack([x, y], axis=2)


def _corners(feet: np.ndarray, bottoms: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Corners of boxes: (8 N, 3)."""
    low = np.broadcast_to(bottoms[:, None, None], (*feet.shape[:2], 1))
    high = low + heights[:, None, None]
    return np.concatenate([np.concatenate([feet, z], axis=2).reshape(-1, 3) for z in (low, high)])
