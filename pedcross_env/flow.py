"""How far the image moves between two moments: decides how often the event camera's scene is rendered."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from pedcross_env._optics_kernels import LENSES, coefficients
from pedcross_env.camera import CameraPose, camera_pose, numbers_of
from pedcross_env.camera.kernels.motion import fastest_beyond, fastest_in_view
from pedcross_env.camera.surroundings import Surroundings
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ActorKind, Snapshot
from pedcross_env.optics import undistort
from pedcross_env.scenario import StreetSpec

__all__ = ["image_flow_px", "layer_motion_px"]

REACH_M = 1.0  # how far limbs of trees and furniture reach out of their layer
LIMBS = 2.0  # legs and arms swing up to so many times as fast, against the body, as the body walks
CARRIED_M = {ActorKind.VEHICLE: 0.3, ActorKind.PEDESTRIAN: 1.2}  # mirrors; bags, umbrellas, strollers
SOONER = 1.1  # what actors' corners move over a whole step is not all that they move in its last part


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
    number = len(before.actors)
    return float(
        fastest_in_view(
            *_moments(poses), _optics(poses[0]), (LENSES.index(camera.lens), coefficients(camera.distortion)),
            _edges(camera), street.facade_y_m, numbers_of(before.actors), numbers_of(after.actors), np.zeros(number),
            np.empty((2, number, 4, 2)), np.empty((10, 3)),
        )
    )  # fmt: skip


def layer_motion_px(
    poses: tuple[CameraPose, CameraPose],
    around: Surroundings,
    before: Snapshot,
    after: Snapshot,
    planes_m: np.ndarray,
) -> np.ndarray:
    """How far what is beyond a plane across the street moves in the picture from one moment to the other: a bound.

    Nothing that stands is nearer than the road, the plane and what lines the road, so their motion bounds that of all
    standing things. Actors, their limbs and their shadows are followed at their boxes' corners.

    Args:
        poses: The camera, a pinhole, at both moments.
        around: Gives what lines the road and where shadows fall.
        before: The first moment.
        after: The same actors in the same order at the second.
        planes_m: (P,) float64, world x of each.

    Returns:
        (P,) pixels.
    """
    nearest_x = planes_m - REACH_M
    ahead = nearest_x - max(float(pose.origin[0]) for pose in poses)
    actors, number = before.actors, len(before.actors)
    walks = actors["speed"] * (actors["kind"] == ActorKind.PEDESTRIAN)
    carried = np.array([CARRIED_M.get(kind, 0.0) for kind in actors["kind"].tolist()])
    standing, moving = np.zeros(len(planes_m)), np.zeros(len(planes_m))
    fastest_beyond(
        *_moments(poses), _optics(poses[0]), (around.left_y_m, around.right_y_m),
        around.shadow_per_m or (math.nan, math.nan), numbers_of(actors), numbers_of(after.actors), carried,
        LIMBS * (after.time_s - before.time_s) * walks, nearest_x, ahead, standing, moving,
        np.empty((2, number, 4, 2)), np.empty((4, 3)),
    )  # fmt: skip
    return np.asarray(np.maximum(standing, SOONER * moving))


def _moments(poses: tuple[CameraPose, CameraPose]) -> tuple[np.ndarray, np.ndarray]:
    """(2, 3, 3) and (2, 3)."""
    return np.array([pose.rotation for pose in poses]), np.array([pose.origin for pose in poses])


def _optics(pose: CameraPose) -> tuple[float, float, float, float, float]:
    return pose.focal_px, pose.cx, pose.cy, float(pose.width_px), float(pose.height_px)


@lru_cache(maxsize=16)
def _edges(camera: CameraConfig) -> np.ndarray:
    """(5, 3) rays through both lower corners, the bonnet's road and both sides; on which side their wall is."""
    w, h, f = camera.width_px, camera.height_px, camera.focal_px
    cx, cy = camera.principal_point[0] * w, camera.principal_point[1] * h
    u, v = np.array([0.0, w / 2, w, 0.0, w]), np.array([h, h, h, cy, cy])
    x, y = undistort(camera.lens, camera.distortion, (u - cx) / f, (v - cy) / f)
    return np.stack([x, y, np.array([1.0, 0.0, -1.0, 1.0, -1.0])], axis=1)
