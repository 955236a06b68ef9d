"""Post-encroachment times: how much time lay between the ego and a pedestrian at the same place.

The conflict area of a pedestrian's path is where its footprint lies in the corridor that the ego sweeps along its
planned way. PET = time between the one leaving this area and the other reaching it (Allen, Shin and Cooper, 1978); it
is known once the second has come. Who is in the area together has a PET of 0.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable

import numpy as np

from pedcross_env.config import EgoConfig
from pedcross_env.scenario.route import Route
from pedcross_env.scenario.walk import Walk

__all__ = ["Encounters"]

_GRID_S = 0.02
_LONGEST_WALK_S = 600.0
_TINY_S = 1e-6


class _Area:
    """One stay of one pedestrian in the corridor: when, and between which distances along the ego's way."""

    def __init__(self, enters_s: float, leaves_s: float, low_m: float, high_m: float) -> None:
        self.enters_s, self.leaves_s, self.low_m, self.high_m = enters_s, leaves_s, low_m, high_m
        self.ego_enters_s = self.ego_leaves_s = math.inf


class Encounters:
    """The smallest post-encroachment time so far.

    Args:
        route: The ego's planned way.
        ego: Its size.

    Attributes:
        pet_s: inf before anybody's way was crossed.
    """

    def __init__(self, route: Route, ego: EgoConfig) -> None:
        self._route, self._half_width_m, self._length_m = route, 0.5 * ego.width_m, ego.length_m
        self._areas: list[_Area] = []
        self._ego_times: list[float] = []
        self._ego_fronts: list[float] = []
        self.pet_s = math.inf

    def foresee(self, walks: list[Walk], footprints_m: np.ndarray) -> None:
        """Find the areas of all walks as they are known now.

        Args:
            walks: Of the pedestrians; up to now they are as before.
            footprints_m: (N, 2) their length and width.
        """
        self._areas = [
            area
            for walk, footprint in zip(walks, footprints_m, strict=True)
            for area in _areas(walk, footprint, self._route, self._half_width_m)
        ]
        for area in self._areas:
            area.ego_enters_s = self._passed_s(area.low_m)
            area.ego_leaves_s = self._passed_s(area.high_m + self._length_m)

    def _passed_s(self, place_m: float) -> float:
        """When the ego's front passed a place, between the ends of past steps; inf: not yet."""
        index = bisect_right(self._ego_fronts, place_m)
        if index == len(self._ego_fronts):
            return math.inf
        if index == 0:
            return self._ego_times[0]
        return float(
            np.interp(
                place_m, self._ego_fronts[index - 1 : index + 1], self._ego_times[index - 1 : index + 1]
            )
        )

    def advance(self, start_s: float, end_s: float, front_m: Callable[[float], float]) -> None:
        """Take a policy step into account; ``front_m`` says how far the ego's front has come at a time."""
        front, before = front_m(end_s), front_m(start_s)
        if not self._ego_times:
            self._ego_times.append(start_s)
            self._ego_fronts.append(before)
        self._ego_times.append(end_s)
        self._ego_fronts.append(max(front, self._ego_fronts[-1]))
        for area in self._areas:
            beyond = area.high_m + self._length_m
            if before <= area.low_m <= front and area.ego_enters_s == math.inf:
                area.ego_enters_s = _reached_s(front_m, area.low_m, start_s, end_s)
            if before <= beyond <= front and area.ego_leaves_s == math.inf:
                area.ego_leaves_s = _reached_s(front_m, beyond, start_s, end_s)
            self.pet_s = min(self.pet_s, self._pet_s(area, end_s))

    @staticmethod
    def _pet_s(area: _Area, now_s: float) -> float:
        if max(area.enters_s, area.ego_enters_s) > now_s:
            return math.inf
        if area.leaves_s <= area.ego_enters_s:
            return area.ego_enters_s - area.leaves_s
        if area.ego_leaves_s <= area.enters_s:
            return area.enters_s - area.ego_leaves_s
        return 0.0


def _areas(walk: Walk, footprint_m: np.ndarray, route: Route, half_width_m: float) -> list[_Area]:
    times = np.arange(0.0, min(walk.end_s, _LONGEST_WALK_S) + 2 * _GRID_S, _GRID_S)
    xy = walk.positions(times)
    s, d = route.projections(xy[:, 0], xy[:, 1])
    turned = walk.yaws(times) - route.poses(s)[2]
    cos, sin = np.abs(np.cos(turned)), np.abs(np.sin(turned))
    length, width = footprint_m
    along, across = 0.5 * (length * cos + width * sin), 0.5 * (length * sin + width * cos)
    inside = half_width_m + across - np.abs(d)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], inside > 0, [False])).astype(np.int8)))
    found = []
    for first, last in zip(edges[::2], edges[1::2] - 1, strict=True):
        enters, leaves = 0.0, math.inf
        if first > 0:
            enters = times[first] - _GRID_S * inside[first] / (inside[first] - inside[first - 1])
        if last < len(times) - 1:
            leaves = times[last] + _GRID_S * inside[last] / (inside[last] - inside[last + 1])
        part = slice(first, last + 1)
        low, high = (s - along)[part].min(), (s + along)[part].max()
        found.append(_Area(float(enters), float(leaves), float(low), float(high)))
    return found


def _reached_s(front_m: Callable[[float], float], place_m: float, low_s: float, high_s: float) -> float:
    while high_s - low_s > _TINY_S:
        middle = 0.5 * (low_s + high_s)
        low_s, high_s = (low_s, middle) if front_m(middle) >= place_m else (middle, high_s)
    return high_s
