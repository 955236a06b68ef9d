"""Who crosses when, and whether the ego is about to touch somebody: the ground truth of label and conflict.

Pedestrians are scripted, so all of it is known ahead: stays on the carriageway are found once per episode.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pedcross_env.config import EgoConfig, LabelConfig
from pedcross_env.scenario.route import Route
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.scenario.walk import Walk
from pedcross_env.world.pedestrians import Pedestrians

__all__ = ["ConflictFinder", "Stay", "crossing_stays", "way_stays"]

_GRID_S = 0.02
_LONGEST_WALK_S = 600.0
_LATERAL_TRAVEL_M = 0.5  # less sideways movement on the carriageway is no crossing


class Stay(NamedTuple):
    """A time during which a pedestrian is inside a band of the street.

    Attributes:
        start_s: 0 where it is inside from the start.
        end_s: inf where it never leaves.
        x_low_m: Smallest x meanwhile.
        x_high_m: Largest x meanwhile.
    """

    start_s: float
    end_s: float
    x_low_m: float
    x_high_m: float


def _grid(walk: Walk) -> np.ndarray:
    return np.arange(0.0, min(walk.end_s, _LONGEST_WALK_S) + 2 * _GRID_S, _GRID_S)


def _runs(inside_by_m: np.ndarray) -> list[tuple[int, int]]:
    """Runs of positive values as (first, last) index."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], inside_by_m > 0, [False])).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _stay(times: np.ndarray, xy: np.ndarray, inside_by_m: np.ndarray, first: int, last: int) -> Stay:
    def edge(inner: int, outer: int) -> float:
        share = inside_by_m[inner] / (inside_by_m[inner] - inside_by_m[outer])
        return float(times[inner] + share * (times[outer] - times[inner]))

    start = 0.0 if first == 0 else edge(first, first - 1)
    end = math.inf if last == len(times) - 1 else edge(last, last + 1)
    x = xy[first : last + 1, 0]
    return Stay(start, end, float(x.min()), float(x.max()))


def crossing_stays(walk: Walk, street: StreetSpec) -> list[Stay]:
    """Stays on the carriageway on a path that crosses it.

    A stay counts if the pedestrian moves sideways on the carriageway, by 0.5 m or more and by at least half
    of what it moves along the street. Walking along, or standing on the carriageway all the time, is no
    crossing; stepping out and turning back is one.
    """
    times = _grid(walk)
    xy = walk.positions(times)
    inside_by_m = street.kerb_y_m - np.abs(xy[:, 1])
    stays = []
    for first, last in _runs(inside_by_m):
        along, across = np.abs(np.diff(xy[max(0, first - 1) : last + 2], axis=0)).sum(axis=0)
        if across >= _LATERAL_TRAVEL_M and across >= 0.5 * along:
            stays.append(_stay(times, xy, inside_by_m, first, last))
    return stays


def way_stays(walk: Walk, way: Route, left_m: float, half_width_m: float) -> list[Stay]:
    """Stays within ``half_width_m`` of the line ``left_m`` to the left of a way; x is the distance along the way."""
    times = _grid(walk)
    along, left = _on_way(walk.positions(times), way)
    inside_by_m = half_width_m - np.abs(left - left_m)
    placed = np.stack([along, left], axis=1)
    return [_stay(times, placed, inside_by_m, first, last) for first, last in _runs(inside_by_m)]


def _on_way(xy: np.ndarray, way: Route) -> tuple[np.ndarray, np.ndarray]:
    if way.straight:
        x, y, heading = way.pose(0.0)
        cos, sin, dx, dy = math.cos(heading), math.sin(heading), xy[:, 0] - x, xy[:, 1] - y
        return dx * cos + dy * sin, dy * cos - dx * sin
    found = np.array([way.project(float(px), float(py)) for px, py in xy]).reshape(-1, 2)
    return found[:, 0], found[:, 1]


class ConflictFinder:
    """Time until the ego, holding its speed, would touch a pedestrian on the pedestrian's true path.

    Args:
        pedestrians: With their scripted motion.
        ego: Its size.
        label: Horizon and margin.
        lane_y_m: Lateral position of the ego.
        duration_s: Of the episode; the horizon reaches beyond it.
    """

    def __init__(
        self,
        pedestrians: Pedestrians,
        ego: EgoConfig,
        label: LabelConfig,
        *,
        lane_y_m: float,
        duration_s: float,
    ) -> None:
        self._half_length_m = 0.5 * ego.length_m + label.conflict_margin_m
        half_width_m = 0.5 * ego.width_m + label.conflict_margin_m
        self._horizon_s = label.conflict_horizon_s
        self._times = np.arange(0.0, duration_s + label.conflict_horizon_s + 1.0 + _GRID_S, _GRID_S)
        table = pedestrians.table(self._times)
        self._x = table[:, :, 0]
        self._radius_m = pedestrians.radius_m[:, None]
        self._outside_y_m = np.maximum(np.abs(table[:, :, 1] - lane_y_m) - half_width_m, 0.0)
        self._near = self._outside_y_m < self._radius_m

    def time_to_contact_s(self, time_s: float, x_m: float, speed_mps: float) -> float:
        """Time to the first contact within the horizon, inf without one.

        Args:
            time_s: Now.
            x_m: The ego's centre now.
            speed_mps: The speed it holds.
        """
        low = int(time_s / _GRID_S)
        high = low + math.ceil(self._horizon_s / _GRID_S) + 2
        who = np.flatnonzero(self._near[:, low:high].any(axis=1))
        if who.size == 0:
            return math.inf
        ahead_s = np.maximum(self._times[low:high] - time_s, 0.0)
        outside_x = np.maximum(
            np.abs(self._x[who, low:high] - (x_m + speed_mps * ahead_s)) - self._half_length_m, 0.0
        )
        gap = (np.hypot(outside_x, self._outside_y_m[who, low:high]) - self._radius_m[who]).min(axis=0)
        touching = np.flatnonzero(gap <= 0)
        if touching.size == 0:
            return math.inf
        first = int(touching[0])
        if first == 0:
            return 0.0
        share = gap[first - 1] / (gap[first - 1] - gap[first])
        found = float(ahead_s[first - 1] + share * (ahead_s[first] - ahead_s[first - 1]))
        return found if found <= self._horizon_s else math.inf
