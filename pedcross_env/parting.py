"""How often each layer of the scene is rendered for the event camera: as often as its own motion asks for.

Driving, the road before the bonnet moves twenty times as fast in the picture as what is far ahead, which holds most of
the detail. So what is near is rendered at every instant of a step, and what is farther away only at so many that it
moves no farther between two than the step allows (``DvsConfig.max_flow_px``, or what the cap on renders leaves); at the
others it runs straight in between, as it does for the event camera.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pedcross_env.camera import (
    FARTHEST,
    MOST_LAYERS,
    NEAREST,
    Border,
    CameraPose,
    Layer,
    Surroundings,
    camera_pose,
)
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import Snapshot
from pedcross_env.flow import layer_motion_px
from pedcross_env.layering import Cadence

__all__ = ["WHOLE_SCENE", "Parting", "Planes"]

# Planes at which layers may part, so far ahead of the camera at the least. What rendering all that is nearer costs, and
# the whole scene as a layer, is in renders of the whole scene: means of twelve streets.
AHEAD_M = np.array([6.0, 9.0, 12.0, 19.0, 28.0, 40.0, 60.0])
NEARER, ALL_OF_IT = np.array([0.10, 0.17, 0.225, 0.315, 0.395, 0.465, 0.55]), 0.85
BETWEEN, BEYOND = 0.045, 0.06  # what a layer adds that others lie behind, and the farthest
LAID = 0.02  # of putting a layer more into each picture
GRID_M = 5.0  # of the places along the street where planes are looked for
MOST_PLANES = MOST_LAYERS - 1
YAW_RAD = 0.1  # of the camera, up to which planes across the street part what is near from what is far
LASTING = 0.65  # of its distance, to which a plane may come nearer before its layers reach too far up
LEAST_AHEAD_M = 4.0  # of a plane that is kept
SWITCH = 0.2  # of the renders that other planes ask for at once, to be saved within a step
ROWS = 4  # layers reach down to multiples of this: so they last while the camera pitches


class Planes(NamedTuple):
    """Where a scene is parted.

    Attributes:
        places_m: World x, the nearest first.
        rows: The picture's upper rows that what is beyond each reaches down to.
    """

    places_m: tuple[float, ...]
    rows: tuple[int, ...]


WHOLE_SCENE = Planes((), ())


class _Ways(NamedTuple):
    """Choices of planes out of (P,).

    Attributes:
        chosen: (W, P) bool.
        first: (W,) index of the nearest plane.
        following: (W, P) index of the next plane after each chosen one; P: there is none.
        number: (W,) of planes.
    """

    chosen: np.ndarray
    first: np.ndarray
    following: np.ndarray
    number: np.ndarray


def _ways(choices: Sequence[tuple[int, ...]], count: int) -> _Ways:
    chosen, following = np.zeros((len(choices), count), bool), np.full((len(choices), count), count)
    for at, choice in enumerate(choices):
        chosen[at, list(choice)] = True
        following[at, list(choice[:-1])] = choice[1:]
    return _Ways(chosen, np.array([choice[0] for choice in choices]), following, chosen.sum(axis=1))


ANY = _ways(
    [way for n in range(MOST_PLANES) for way in itertools.combinations(range(len(AHEAD_M)), n + 1)],
    len(AHEAD_M),
)
ALL = [_ways([tuple(range(n + 1))], n + 1) for n in range(MOST_PLANES)]


class Parting:
    """Parts an episode's scene step by step.

    It keeps to its planes while others save little: a layer that was not rendered in the step before has to be rendered
    at the step's start, too.

    Args:
        camera: A pinhole.
        around: How near the standing things come, and where shadows fall.
        planes: Of another one, which it continues.

    Attributes:
        planes: Those of the last step.
    """

    def __init__(self, camera: CameraConfig, around: Surroundings, planes: Planes = WHOLE_SCENE) -> None:
        self._camera, self._around, self.planes = camera, around, planes
        self._borders: dict[float, Border] = {}

    def cadences(self, before: Snapshot, after: Snapshot, instants: int, most_px: float) -> list[Cadence]:
        """Part the scene into layers for a step, at the least cost of its renders.

        Args:
            before: The scene at the step's start.
            after: The same actors in the same order at its end.
            instants: How often what is nearest is rendered in the step.
            most_px: Motion allowed between two renders.

        Returns:
            The layers, the nearest first; a single one where parting gains nothing.
        """
        poses = camera_pose(self._camera, before.ego), camera_pose(self._camera, after.ego)
        strides: list[int] = []
        if max(abs(_yaw(pose)) for pose in poses) > YAW_RAD:
            self.planes = WHOLE_SCENE
        else:
            self.planes, strides = self._chosen(poses, before, after, instants, most_px)
        rows = [self._camera.height_px, *self.planes.rows]
        bounds = [NEAREST, *(self._border(place) for place in self.planes.places_m), FARTHEST]
        y, lengths = before.actors["y"], np.hypot(before.actors["length"], before.actors["width"])
        rear = before.actors["x"] - 0.5 * lengths
        return [
            Cadence(Layer(near, far, above, ground, (rear >= near.of(y)) & (rear < far.of(y))), stride)
            for near, far, above, ground, stride in zip(
                bounds[:-1], bounds[1:], rows, [*rows[1:], 0], [1, *strides], strict=True
            )
        ]

    def _chosen(
        self,
        poses: tuple[CameraPose, CameraPose],
        before: Snapshot,
        after: Snapshot,
        instants: int,
        most_px: float,
    ) -> tuple[Planes, list[int]]:
        """The planes for a step, and the strides of the layers beyond them."""
        x, grid = float(poses[0].origin[0]), len(AHEAD_M)
        kept = self.planes if self._lasts(poses) else WHOLE_SCENE
        grid_m = GRID_M * np.ceil((x + AHEAD_M) / GRID_M)
        places = np.array([*(min(self._border(place)) for place in grid_m.tolist()), *kept.places_m])
        motion = layer_motion_px(poses, self._around, before, after, places)
        longest = np.clip(instants * most_px // np.maximum(motion, 1e-9), 1, instants)
        strides = np.ceil(instants / np.ceil(instants / longest))  # as few renders, evenly spread
        near = np.interp(places - x, AHEAD_M, NEARER)
        costs, anew = _costs(ANY, near[:grid], strides[:grid], instants)
        best = int((costs + SWITCH * anew).argmin())
        chosen, cost = WHOLE_SCENE, float(instants)
        if kept.places_m:
            chosen = kept
            cost = float(_costs(ALL[len(kept.places_m) - 1], near[grid:], strides[grid:], instants)[0][0])
        if costs[best] + SWITCH * anew[best] < cost:
            way = np.flatnonzero(ANY.chosen[best])
            planes = places[way].tolist()
            rows = tuple(self._rows_to(poses, x + LASTING * (plane - x)) for plane in planes)
            return Planes(tuple(planes), rows), strides[way].astype(int).tolist()
        if cost >= instants:
            return WHOLE_SCENE, []
        return chosen, strides[grid:].astype(int).tolist()

    def _lasts(self, poses: tuple[CameraPose, CameraPose]) -> bool:
        """Whether the planes of the step before will do for another."""
        places, rows = self.planes
        nearest = max(float(pose.origin[0]) for pose in poses) + LEAST_AHEAD_M
        return all(
            nearest <= place and self._rows_to(poses, place) <= row
            for place, row in zip(places, rows, strict=True)
        )

    def _rows_to(self, poses: tuple[CameraPose, CameraPose], plane_m: float) -> int:
        """Rows of the picture above the foot of what is beyond a plane."""
        lowest = 0.0
        for pose in poses:
            horizon = pose.cy - pose.focal_px * pose.rotation[2, 2] / pose.rotation[1, 2]
            ahead = 0.93 * (plane_m - pose.origin[0]) - 0.5  # of the street's sides, seen askew
            lowest = max(lowest, horizon + 1.03 * pose.focal_px * pose.origin[2] / ahead + 1.0)
        return min(self._camera.height_px, ROWS * math.ceil(lowest / ROWS))

    def _border(self, place: float) -> Border:
        if place not in self._borders:
            self._borders[place] = self._around.border(place)
        return self._borders[place]


def _costs(
    ways: _Ways, near: np.ndarray, strides: np.ndarray, instants: int
) -> tuple[np.ndarray, np.ndarray]:
    """What a step's pictures cost, and what one render of each layer beyond planes does; in renders of the whole scene.

    Args:
        ways: (W,) choices of planes.
        near: (P,) cost of what is nearer than each plane.
        strides: (P,) instants between two renders of what is beyond it.
        instants: Of the step.
    """
    ends = np.append(near, ALL_OF_IT + BEYOND - BETWEEN)[ways.following]
    each = np.where(ways.chosen, ends - near + BETWEEN, 0.0)
    costs = instants * (near[ways.first] + LAID * ways.number) + (np.ceil(instants / strides) * each).sum(
        axis=1
    )
    return costs, each.sum(axis=1)


def _yaw(pose: CameraPose) -> float:
    return math.atan2(pose.rotation[2, 1], pose.rotation[2, 0])
