"""How often each layer of the scene is rendered for the event camera: as often as its own motion asks for.

Driving, the road before the bonnet moves twenty times as fast in the picture as what is far ahead, which holds most of
the detail. So what is near is rendered at every instant of a step, and what is farther away only at so many that it
moves no farther between two than the step allows (``DvsConfig.max_flow_px``, or what the cap on renders leaves); at the
others it runs straight in between, as it does for the event camera.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from pedcross_env.camera import (
    FARTHEST,
    MOST_LAYERS,
    NEAREST,
    CameraPose,
    Layer,
    Picture,
    Seen,
    Surroundings,
    camera_pose,
    picture_of,
)
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import Snapshot
from pedcross_env.flow import layer_motion_px

__all__ = ["Cadence", "Pictures", "cadences", "renders_of"]

AHEAD_M = np.array([6.0, 9.0, 12.0, 19.0, 28.0, 40.0, 60.0])  # planes at which layers may part, at the least
GRID_M = 5.0  # of the places along the street that planes keep while the camera comes nearer
# What rendering costs, in renders of the whole scene: what is nearer than each plane, and what each layer adds.
NEARER = (0.20, 0.26, 0.31, 0.41, 0.50, 0.58, 0.68)
BETWEEN, BEYOND = 0.05, 0.09  # of a layer that others lie behind, and of the farthest
LAID = 0.02  # of putting a layer more into each picture
MOST_PLANES = MOST_LAYERS - 1  # at which the scene parts
MOST_STRIDE = 8  # instants from one render of a layer to the next: more were no quicker, and less exact
YAW_RAD = 0.1  # of the camera, up to which planes across the street part what is near from what is far
ROWS = 4  # layers reach down to multiples of this: so they last while the camera pitches


def _price_list() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ways to part the scene, each at some of the planes.

    Returns:
        (W, P) bool: at which planes; (W,) what each instant costs, in renders of the whole scene; (W, P) the same of a
        render of the layer beyond each plane.
    """
    count = len(AHEAD_M)
    ways = [way for n in range(MOST_PLANES) for way in itertools.combinations(range(count), n + 1)]
    shape = len(ways), count
    parted, instant, beyond = np.zeros(shape, bool), np.zeros(len(ways)), np.zeros(shape)
    for at, way in enumerate(ways):
        parted[at, list(way)] = True
        borders = [*(NEARER[k] for k in way), 1.0 + BEYOND - BETWEEN]
        instant[at] = borders[0] + LAID * len(way)
        beyond[at, list(way)] = np.diff(borders) + BETWEEN
    return parted, instant, beyond


PARTED, PER_INSTANT, PER_RENDER = _price_list()


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
        places = GRID_M * np.ceil((poses[0].origin[0] + AHEAD_M) / GRID_M)
        motion = layer_motion_px(poses, around, before, after, places)
        every = np.clip(instants * most_px // np.maximum(motion, 1e-9), 1, min(instants, MOST_STRIDE))
        costs = instants * PER_INSTANT + (np.ceil(instants / every) * PER_RENDER).sum(axis=1)
        best = int(costs.argmin())
        if costs[best] < instants:
            planes, strides = places[PARTED[best]].tolist(), every[PARTED[best]].astype(int).tolist()
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
