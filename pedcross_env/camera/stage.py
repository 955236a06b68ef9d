"""What a picture shows besides houses and trees: actors and the furniture near by, and the shadows on the ground around."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pedcross_env.camera.actor_tables import ActorTables, Cast
from pedcross_env.camera.kernels.shadows import CAPSULES_PER_ACTOR, MAX_EDGES, POLYGONS_PER_ACTOR
from pedcross_env.camera.kernels.stage import set_stage
from pedcross_env.camera.light import Light
from pedcross_env.camera.scenery import Scenery, sun_shear, tree_shadow_capsules
from pedcross_env.camera.shade import Shade
from pedcross_env.contracts import ACTOR_DTYPE, Snapshot, StaticClass

__all__ = ["Stage", "Staged"]

CELL_M = 20.0  # of the street, for each of which what is near is picked once
FURNITURE_RANGE_M, FURNITURE_FADE_M = 85.0, 30.0
TREE_SHADOW_RANGE_M = 90.0


class Staged(NamedTuple):
    """One moment's tables for the kernels; arrays are reused by the next.

    Attributes:
        cast: Actors, then furniture and roofs.
        sunlit: (N,) share of each that the sun reaches.
        shadows: On the ground: polygons, their facts and capsules, see kernels.ground_light.
    """

    cast: Cast
    sunlit: np.ndarray
    shadows: tuple[np.ndarray, np.ndarray, np.ndarray]

    def copy(self) -> Staged:
        """Return the same in memory of its own, but for what stays from moment to moment."""
        polygons, info, capsules = self.shadows
        cast = self.cast._replace(numbers=self.cast.numbers.copy())
        return Staged(cast, self.sunlit.copy(), (polygons.copy(), info.copy(), capsules.copy()))


class _Near(NamedTuple):
    """What is near one cell of the street, and who is shown with it, in tables that ``set_stage`` takes."""

    shown: np.ndarray
    cast: Cast
    sunlit: np.ndarray
    furniture: np.ndarray
    fading: tuple[np.ndarray, float, float]
    everyone: tuple[np.ndarray, np.ndarray, np.ndarray]
    shadows: tuple[np.ndarray, np.ndarray, int, np.ndarray, int]


class Stage:
    """Sets the stage of one street under one light.

    Args:
        scenery: The street's standing things.
        shade: Of its houses.
        light: Gives the sun.
        actors: Makes tables of actors.
    """

    def __init__(self, scenery: Scenery, shade: Shade, light: Light, actors: ActorTables) -> None:
        self._props, self._shade, self._actors = scenery.props, shade, actors
        sunny = bool(light.sun_lx[1] > 0)
        shear = sun_shear(light.sun_direction) if sunny else (0.0, 0.0)
        self._sunlight = (*shade.walls, shear, sunny)
        self._trees = tree_shadow_capsules(scenery.tree_shadows, light.sun_direction)
        if light.sun_lx.sum() <= 0:
            self._trees = self._trees[:0]
        self._known: dict[tuple[int, int], _Near] = {}

    def at(self, snapshot: Snapshot, camera: np.ndarray) -> Staged:
        """Return the tables of one moment.

        Args:
            snapshot: Ego and actors.
            camera: (3,) its place.
        """
        # the ego is not seen from its own camera, but its shadow is
        # a fortieth of the time numpy takes to join records, and can be written to, which kernels are called quicker for
        records = np.frombuffer(bytearray(snapshot.actors.tobytes() + snapshot.ego.tobytes()), np.uint8)
        cell = int(camera[0] // CELL_M), int(camera[1] // CELL_M)
        near = self._known.get(cell)
        counts = (-1, -1) if near is None else self._set(records, near, camera)
        if near is None or counts[0] < 0:
            everyone = self._actors.of(records.view(ACTOR_DTYPE))
            near = self._known[cell] = self._near(everyone, records, cell)
            counts = self._set(records, near, camera)
        polygons, info, _, capsules, _ = near.shadows
        return Staged(
            near.cast, near.sunlit, (polygons[: counts[0]], info[: counts[0]], capsules[: counts[1]])
        )

    def _set(self, records: np.ndarray, near: _Near, camera: np.ndarray) -> tuple[int, int]:
        polygons, capsules = set_stage(
            records, near.shown, near.furniture, near.fading, camera, self._sunlight, near.everyone,
            (near.cast.numbers, near.sunlit), near.shadows,
        )  # fmt: skip
        return polygons, capsules

    def _near(self, everyone: Cast, records: np.ndarray, cell: tuple[int, int]) -> _Near:
        props, n = self._props, len(everyone.idents) - 1
        low = np.array(cell) * CELL_M
        beyond = np.maximum(0.0, np.maximum(low - props.numbers[:, :2], props.numbers[:, :2] - low - CELL_M))
        lasting = props.idents[:, 0] == StaticClass.BUILDING
        seen = lasting | (np.hypot(beyond[:, 0], beyond[:, 1]) < FURNITURE_RANGE_M)
        numbers = props.numbers[seen]
        cast = Cast(
            np.empty((n + len(numbers), props.numbers.shape[1])), np.concatenate([everyone.idents[:n], props.idents[seen]]),
            np.concatenate([everyone.looks[:n], props.looks[seen]]), everyone.builds[:n], everyone.bodies[:n],
        )  # fmt: skip
        away = np.maximum(low[0] - self._trees[:, 0], self._trees[:, 0] - low[0] - CELL_M)
        trees = self._trees[away < TREE_SHADOW_RANGE_M]
        houses, house_info = self._shade.near(low, CELL_M)
        most = len(houses) + POLYGONS_PER_ACTOR * (n + 1)
        polygons, info = np.zeros((most, MAX_EDGES, 3), np.float32), np.zeros((most, 8), np.float32)
        polygons[: len(houses)], info[: len(houses)] = houses, house_info
        capsules = np.zeros((CAPSULES_PER_ACTOR * (n + 1) + len(trees), 9), np.float32)
        capsules[: len(trees)] = trees
        sunlit = np.concatenate([np.ones(n), self._shade.props[seen]])
        return _Near(
            records, cast, sunlit, numbers, (lasting[seen].astype(np.float64), FURNITURE_RANGE_M, FURNITURE_FADE_M),
            (everyone.numbers, everyone.idents[:, 1].copy(), everyone.builds),
            (polygons, info, len(houses), capsules, len(trees)),
        )  # fmt: skip
