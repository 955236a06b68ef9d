"""Who crosses when, and whether the ego is about to touch somebody: the ground truth of label and conflict.

Pedestrians are scripted, so all of it is known ahead: stays on the carriageway are found once per episode.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pedcross_env.config import EgoConfig, LabelConfig
from pedcross_env.scenario.footprints import box_gaps_m
from pedcross_env.scenario.layout import to_side_street, to_street
from pedcross_env.scenario.route import Route
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.scenario.walk import Walk
from pedcross_env.world.pedestrians import Pedestrians

__all__ = ["ConflictFinder", "Stay", "crossing_stays", "way_stays"]

_GRID_S = 0.02
_LONGEST_WALK_S = 600.0
_LATERAL_TRAVEL_M = 0.5  # less sideways movement on the carriageway is no crossing
_PARALLEL = 0.7  # cosine between the ego's way and a street from which on it drives along it


class Stay(NamedTuple):
    """A time during which a pedestrian is inside a band of the street.

    Attributes:
        start_s: 0 where it is inside from the start.
        end_s: inf where it never leaves.
        x_low_m: Smallest x meanwhile.
        x_high_m: Largest x meanwhile.
        y_low_m: Smallest y meanwhile.
        y_high_m: Largest y meanwhile.
    """

    start_s: float
    end_s: float
    x_low_m: float
    x_high_m: float
    y_low_m: float
    y_high_m: float


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
    (x_low, y_low), (x_high, y_high) = (f(xy[first : last + 1], axis=0) for f in (np.min, np.max))
    return Stay(start, end, float(x_low), float(x_high), float(y_low), float(y_high))


def crossing_stays(walk: Walk, street: StreetSpec, route: Route) -> list[Stay]:
    """Stays on the carriageway that the ego drives on, on a path that crosses it; by their start.

    A stay counts if the pedestrian moves sideways on the carriageway, by 0.5 m or more and by at least half
    of what it moves along the street. Walking along, or standing on the carriageway all the time, is no
    crossing; stepping out and turning back is one. At an intersection the side street counts where the ego's way
    leads into it.
    """
    times = _grid(walk)
    xy = walk.positions(times)
    s, d = (xy[:, 0], xy[:, 1]) if street.straight else to_street(street, xy[:, 0], xy[:, 1])
    stays = _stays_across(times, xy, s, d, street.kerb_y_m)
    if street.intersection is not None:
        stays = [stay for stay in stays if _on_the_way(stay, street, route, along_main=True)]
        side = to_side_street(street, xy[:, 0], xy[:, 1])
        stays += [
            stay
            for stay in _stays_across(times, xy, *side, street.intersection.kerb_m)
            if _on_the_way(stay, street, route, along_main=False)
        ]
    return sorted(stays)


def _stays_across(
    times: np.ndarray, xy: np.ndarray, s: np.ndarray, d: np.ndarray, kerb_m: float
) -> list[Stay]:
    inside_by_m = kerb_m - np.abs(d)
    stays = []
    for first, last in _runs(inside_by_m):
        part = slice(max(0, first - 1), last + 2)
        along, across = np.abs(np.diff(s[part])).sum(), np.abs(np.diff(d[part])).sum()
        if across >= _LATERAL_TRAVEL_M and across >= 0.5 * along:
            stays.append(_stay(times, xy, inside_by_m, first, last))
    return stays


def _on_the_way(stay: Stay, street: StreetSpec, route: Route, *, along_main: bool) -> bool:
    """Whether the ego drives along the street crossed where it is crossed."""
    at, aside = route.project(0.5 * (stay.x_low_m + stay.x_high_m), 0.5 * (stay.y_low_m + stay.y_high_m))
    heading = route.pose(at)[2]
    return abs(aside) < 2 * street.kerb_y_m and (abs(math.cos(heading)) > _PARALLEL) is along_main


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
    return way.projections(xy[:, 0], xy[:, 1])


class ConflictFinder:
    """Time until the ego, holding its speed on its way, would touch a pedestrian on the pedestrian's true path.

    The ego's box is grown by the label's margin on all sides.

    Args:
        pedestrians: With their scripted motion.
        ego: Its size.
        label: Horizon and margin.
        duration_s: Of the episode; the horizon reaches beyond it.
    """

    def __init__(
        self, pedestrians: Pedestrians, ego: EgoConfig, label: LabelConfig, *, duration_s: float
    ) -> None:
        margin = 2 * label.conflict_margin_m
        self._size = (ego.length_m + margin, ego.width_m + margin)
        self._horizon_s = label.conflict_horizon_s
        self._times = np.arange(0.0, duration_s + label.conflict_horizon_s + 1.0 + _GRID_S, _GRID_S)
        table = pedestrians.table(self._times)
        self._x, self._y = table[:, :, 0], table[:, :, 1]
        self._yaw = pedestrians.yaw_table(self._times)
        self._footprints_m = pedestrians.footprints_m
        own = 0.5 * math.hypot(*self._size)
        self._reach_m = own + 0.5 * np.hypot(*pedestrians.footprints_m.T)[:, None]

    def time_to_contact_s(self, time_s: float, s_m: float, speed_mps: float, route: Route) -> float:
        """Time to the first contact within the horizon, inf without one.

        Args:
            time_s: Now.
            s_m: The ego's centre now, along its way.
            speed_mps: The speed it holds.
            route: The way it keeps to.
        """
        low = int(time_s / _GRID_S)
        high = low + math.ceil(self._horizon_s / _GRID_S) + 2
        ahead_s = np.maximum(self._times[low:high] - time_s, 0.0)
        ex, ey, heading = route.poses(s_m + speed_mps * ahead_s)
        dx, dy = self._x[:, low:high] - ex, self._y[:, low:high] - ey
        near = np.abs(dx) + np.abs(dy) < 1.5 * self._reach_m
        who = np.flatnonzero(near.any(axis=1))
        if who.size == 0:
            return math.inf
        dx, dy, cos, sin = dx[who], dy[who], np.cos(heading), np.sin(heading)
        length, width = self._footprints_m[who].T[:, :, None]
        gap = box_gaps_m(
            dx * cos + dy * sin, dy * cos - dx * sin, self._size, length, width,
            self._yaw[who, low:high] - heading,
        ).min(axis=0)  # fmt: skip
        touching = np.flatnonzero(gap <= 0)
        if touching.size == 0:
            return math.inf
        first = int(touching[0])
        if first == 0:
            return 0.0
        share = gap[first - 1] / (gap[first - 1] - gap[first])
        found = float(ahead_s[first - 1] + share * (ahead_s[first] - ahead_s[first - 1]))
        return found if found <= self._horizon_s else math.inf
