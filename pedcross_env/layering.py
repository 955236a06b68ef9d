"""How often each layer of the scene is rendered for the event camera: as often as its own motion asks for.

Driving, the road before the bonnet moves twenty times as fast in the picture as what is far ahead, which holds most of
the detail. So what is near is rendered at every instant of a step, and what is farther away only at so many that it
moves by at most ``DvsConfig.max_flow_px`` between two; at the others it runs straight in between, as it does for the
event camera.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from pedcross_env.camera import (
    FARTHEST,
    NEAREST,
    CameraPose,
    Layer,
    Picture,
    Seen,
    Surroundings,
    camera_pose,
    picture_of,
    rays,
)
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ActorKind, Snapshot

__all__ = ["Cadence", "Pictures", "cadences", "layer_motion_px", "renders_of"]

PLANES_M = (12.0, 19.0, 28.0, 40.0, 60.0)  # ahead of the camera: where layers may part, at the least
GRID_M = 5.0  # of the places along the street that planes keep while the camera comes nearer
# What rendering costs, in renders of the whole scene: what is nearer than each plane, and what each layer adds.
NEARER = (0.24, 0.36, 0.47, 0.57, 0.68)
BETWEEN, BEYOND = 0.05, 0.09  # of a layer that others lie behind, and of the farthest
LAID = 0.02  # of putting a layer more into each picture
WAYS = tuple(
    itertools.chain.from_iterable(itertools.combinations(range(len(PLANES_M)), n) for n in (1, 2, 3))
)
REACH_M = 1.0  # how far limbs of trees and furniture reach out of their layer
MOST_STRIDE = 8  # instants from one render of a layer to the next: more were no quicker, and less exact
YAW_RAD = 0.1  # of the camera, up to which planes across the street part what is near from what is far
LIMBS = 2.0  # legs and arms swing up to so many times as fast, against the body, as the body walks
CARRIED_M = {ActorKind.VEHICLE: 0.3, ActorKind.PEDESTRIAN: 1.2}  # mirrors; bags, umbrellas, strollers
SOONER = 1.1  # what actors' corners move over a whole step is not all that they move in its last part
ROWS = 4  # layers reach down to multiples of this: so they last while the camera pitches

# Corners of a box: eight, then the tips of the upper ones' shadows.
_ALONG = 0.5 * np.array([-1, 1, 1, -1] * 3)
_ACROSS = 0.5 * np.array([-1, -1, 1, 1] * 3)
_UP = np.array([0] * 4 + [1] * 4 + [0] * 4)
_CAST = np.array([0] * 8 + [1] * 4)


class Cadence(NamedTuple):
    """A layer, and how many instants lie between two of its renders (1: it is rendered at each)."""

    layer: Layer
    stride: int


def cadences(
    camera: CameraConfig,
    around: Surroundings,
    before: Snapshot,
    after: Snapshot,
    instants: int,
    most_px: float,
) -> list[Cadence]:
    """Part the scene into layers for a step, at the least cost of its renders.

    Args:
        camera: A pinhole.
        around: How near the standing things come, and where shadows fall.
        before: The scene at the step's start.
        after: The same actors in the same order at its end.
        instants: How often what is nearest is rendered in the step.
        most_px: Motion allowed between two renders.

    Returns:
        The layers, the nearest first; a single one where parting gains nothing.
    """
    poses = camera_pose(camera, before.ego), camera_pose(camera, after.ego)
    planes: list[float] = []
    strides: list[int] = []
    if max(abs(_yaw(pose)) for pose in poses) <= YAW_RAD:
        places = [GRID_M * math.ceil((poses[0].origin[0] + ahead) / GRID_M) for ahead in PLANES_M]
        motion = layer_motion_px(poses, around, before, after, places)
        longest = min(instants, MOST_STRIDE)
        every = [int(min(longest, max(1.0, instants * most_px / max(px, 1e-9)))) for px in motion]
        cost, way = min((_cost(way, every, instants), way) for way in WAYS)
        if cost < instants:
            planes, strides = [places[k] for k in way], [every[k] for k in way]
    rows = [camera.height_px, *(_rows_to(poses, camera, plane) for plane in planes)]
    bounds = [NEAREST, *(around.border(plane) for plane in planes), FARTHEST]
    y, lengths = before.actors["y"], np.hypot(before.actors["length"], before.actors["width"])
    rear = before.actors["x"] - 0.5 * lengths
    return [
        Cadence(Layer(near, far, above, ground, (rear >= near.of(y)) & (rear < far.of(y))), stride)
        for near, far, above, ground, stride in zip(
            bounds[:-1], bounds[1:], rows, [*rows[1:], 0], [1, *strides], strict=True
        )
    ]


def _cost(way: tuple[int, ...], strides: Sequence[int], instants: int) -> float:
    """What a step's pictures cost if the scene is parted at some of the planes."""
    borders = [*(NEARER[k] for k in way), 1.0 + BEYOND - BETWEEN]
    renders = [-(-instants // strides[k]) for k in way]
    behind = sum(
        number * (end - start + BETWEEN)
        for number, (start, end) in zip(renders, itertools.pairwise(borders), strict=True)
    )
    return behind + instants * (borders[0] + LAID * len(way))


def layer_motion_px(
    poses: tuple[CameraPose, CameraPose],
    around: Surroundings,
    before: Snapshot,
    after: Snapshot,
    planes_m: Sequence[float],
) -> list[float]:
    """How far what is beyond a plane across the street moves in the picture from one moment to the other: a bound.

    Nothing that stands is nearer than the road, the plane and what lines the road, so their motion bounds that of all
    standing things. Actors, their limbs and their shadows are followed at their boxes' corners.

    Args:
        poses: The camera at both moments.
        around: Gives what lines the road and where shadows fall.
        before: The first moment.
        after: The same actors in the same order at the second.
        planes_m: World x of each.

    Returns:
        Pixels for each plane.
    """
    ahead = np.array(planes_m) - REACH_M - max(pose.origin[0] for pose in poses)
    standing = np.maximum(*(_standing_px(*pair, around, ahead) for pair in (poses, poses[::-1])))
    moved, nearest_x = _moved_px(poses, around, before, after)
    return [
        max(float(px), SOONER * float(moved.max(initial=0.0, where=nearest_x >= plane - REACH_M)))
        for px, plane in zip(standing, planes_m, strict=True)
    ]


def _yaw(pose: CameraPose) -> float:
    return math.atan2(pose.rotation[2, 1], pose.rotation[2, 0])


def _rows_to(poses: tuple[CameraPose, CameraPose], camera: CameraConfig, plane_m: float) -> int:
    """Rows of the picture above the foot of what is beyond a plane."""
    lowest = 0.0
    for pose in poses:
        horizon = pose.cy - pose.focal_px * pose.rotation[2, 2] / pose.rotation[1, 2]
        ahead = 0.93 * (plane_m - pose.origin[0]) - 0.5  # of the street's sides, seen askew
        lowest = max(lowest, horizon + 1.03 * pose.focal_px * pose.origin[2] / ahead + 1.0)
    return min(camera.height_px, ROWS * math.ceil(lowest / ROWS))


def _standing_px(
    pose: CameraPose, other: CameraPose, around: Surroundings, nearest_m: np.ndarray
) -> np.ndarray:
    """Motion of the nearest that can stand in any direction beyond each distance (P,), from ``pose`` to ``other``."""
    u, v = np.meshgrid(np.linspace(0, pose.width_px, 9), np.linspace(0, pose.height_px, 5))
    ray = rays(pose, u, v)
    nearness = np.maximum(0.0, -ray[..., 2] / pose.origin[2])  # 1 / m: of the road
    for side_m in (around.left_y_m, around.right_y_m):
        room = side_m - pose.origin[1]
        nearness = np.maximum(nearness, ray[..., 1] / room if room * side_m > 0 else np.inf)
    nearness = np.minimum(nearness, 1.0 / nearest_m[:, None, None])
    seen = ray @ other.rotation.T + nearness[..., None] * (other.rotation @ (pose.origin - other.origin))
    du = other.cx + other.focal_px * seen[..., 0] / seen[..., 2] - u
    dv = other.cy + other.focal_px * seen[..., 1] / seen[..., 2] - v
    return np.asarray(np.hypot(du, dv).max(axis=(1, 2)))


def _moved_px(
    poses: tuple[CameraPose, CameraPose], around: Surroundings, before: Snapshot, after: Snapshot
) -> tuple[np.ndarray, np.ndarray]:
    """Motion of those corners of actors and of their shadows that lie ahead, and how near to x = 0 they come."""
    first, second = (_corners(snapshot.actors, around) for snapshot in (before, after))
    local = [
        (corners - pose.origin) @ pose.rotation.T
        for pose, corners in zip(poses, (first, second), strict=True)
    ]
    depth = np.minimum(local[0][..., 2], local[1][..., 2])
    ahead = depth > 1.0
    one, two = (place[ahead, :2] / place[ahead, 2:] for place in local)
    walks = before.actors["speed"] * (before.actors["kind"] == ActorKind.PEDESTRIAN)
    limbs_m = np.broadcast_to(LIMBS * (after.time_s - before.time_s) * walks[:, None], depth.shape)[ahead]
    moved = poses[0].focal_px * (np.hypot(*(two - one).T) + limbs_m / depth[ahead])
    return moved, np.minimum(first[..., 0], second[..., 0])[ahead]


def _corners(actors: np.ndarray, around: Surroundings) -> np.ndarray:
    """(N, 8 or 12, 3) corners of the actors' boxes, with what they carry, and of their shadows."""
    number = 8 if around.shadow_per_m is None else 12
    shear_x, shear_y = around.shadow_per_m or (0.0, 0.0)
    carried = 2 * np.array([CARRIED_M.get(kind, 0.0) for kind in actors["kind"]])
    along = (actors["length"] + carried)[:, None] * _ALONG[:number]
    across = (actors["width"] + carried)[:, None] * _ACROSS[:number]
    cos, sin = np.cos(actors["yaw"])[:, None], np.sin(actors["yaw"])[:, None]
    cast = actors["height"][:, None] * _CAST[:number]
    points = np.empty((len(actors), number, 3))
    points[..., 0] = actors["x"][:, None] + cos * along - sin * across + shear_x * cast
    points[..., 1] = actors["y"][:, None] + sin * along + cos * across + shear_y * cast
    points[..., 2] = actors["z"][:, None] + actors["height"][:, None] * _UP[:number]
    return points


class Render(Protocol):
    """Gives layers at an instant of a step, counted from 1."""

    def __call__(self, instant: int, layers: list[Layer], *, passing: bool) -> list[Seen]:
        """Render; with ``passing``, what it gives need only last to the next call."""


class Pictures:
    """A step's pictures put together from layers, each rendered at some of its instants and straight in between.

    What is nearest is rendered when its picture is due, after what is behind it, and looked at while it is in the
    processor's cache.

    Args:
        parts: The layers, the nearest first.
        first: The layers behind the nearest one at the step's start.
        instants: Number of instants that follow; all layers are rendered at the last one.
        render: Renders.

    Attributes:
        far: The layers behind the nearest one as they were rendered last.
    """

    def __init__(
        self, parts: Sequence[Cadence], first: Sequence[Seen], instants: int, render: Render
    ) -> None:
        self._parts, self._instants, self._render = parts, instants, render
        self.far = list(first)

    def __iter__(self) -> Iterator[Picture]:
        """Give the picture at each instant, which lasts until the next one is asked for."""
        near, *behind = self._parts
        spans = [(_Look(0, seen), _Look(0, seen)) for seen in self.far]
        kept: dict[int, Seen] = {}
        for instant in range(1, self._instants + 1):
            due: dict[int, list[int]] = {}
            for k, (_, end) in enumerate(spans):
                if end.instant < instant:
                    due.setdefault(min(self._instants, end.instant + behind[k].stride), []).append(k)
            for at, places in due.items():
                layers = [behind[k].layer for k in places]
                if at in kept:
                    found = self._render(at, layers, passing=False)
                else:
                    kept[at], *found = self._render(at, [near.layer, *layers], passing=False)
                for k, seen in zip(places, found, strict=True):
                    spans[k] = spans[k][1], _Look(at, seen)
                    self.far[k] = seen
            seen = (
                kept.pop(instant) if instant in kept else self._render(instant, [near.layer], passing=True)[0]
            )
            yield picture_of([(seen, seen, 0.0), *(_at(instant, *span) for span in spans)])


class _Look(NamedTuple):
    """A render of a layer at an instant."""

    instant: int
    seen: Seen


def _at(instant: int, start: _Look, end: _Look) -> tuple[Seen, Seen, float]:
    """Two renders and where between them an instant lies."""
    if instant == end.instant:
        return end.seen, end.seen, 0.0
    return start.seen, end.seen, (instant - start.instant) / (end.instant - start.instant)


def renders_of(parts: Sequence[Cadence], instants: int) -> int:
    """Number of renders that ``Pictures`` asks for."""
    return sum(-(-instants // part.stride) for part in parts)
