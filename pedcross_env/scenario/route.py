"""Ways of vehicles as lines and arcs: a pose at any distance along them, exactly."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable

import numpy as np

from pedcross_env.config import require

__all__ = ["Route"]

_STRAIGHT_PER_M = 1e-9  # less curvature than this is none


class Route:
    """A smooth way of pieces of constant curvature; it goes on beyond both ends as its outermost pieces do.

    Args:
        pieces: (length in m, curvature in 1/m, positive to the left) of each piece; the last may be endless (inf).
        start: (x, y, heading) where it begins.
        start_m: The distance that is counted there.

    Raises:
        ConfigError: Without a piece, or for one that is not longer than 0.
    """

    def __init__(
        self,
        pieces: Iterable[tuple[float, float]],
        *,
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
        start_m: float = 0.0,
    ) -> None:
        self._starts: list[float] = []
        self._rows: list[tuple[float, float, float, float, float]] = []  # s, x, y, heading, curvature
        self._end = (start_m, *start)
        for length_m, curvature_per_m in pieces:
            self.extend(length_m, curvature_per_m)
        require(len(self._rows) > 0, "Route.pieces", (), "at least one (length_m, curvature_per_m)")

    def extend(self, length_m: float, curvature_per_m: float) -> None:
        """Add a piece at the end."""
        require(length_m > 0, "Route piece length_m", length_m, "positive")
        s, x, y, heading = self._end
        require(math.isfinite(s), "Route piece", (length_m, curvature_per_m), "before an endless one")
        row = (s, x, y, heading, curvature_per_m)
        self._starts.append(s)
        self._rows.append(row)
        if math.isfinite(length_m):
            self._end = (s + length_m, *_along(row, length_m))
        else:
            self._end = (math.inf, math.nan, math.nan, math.nan)

    @property
    def end_m(self) -> float:
        """Where the last piece ends; inf for an endless one."""
        return self._end[0]

    @property
    def breaks_m(self) -> tuple[float, ...]:
        """Distances at which one piece follows another."""
        return tuple(self._starts[1:])

    @property
    def straight(self) -> bool:
        """Whether it is one straight line."""
        return len(self._rows) == 1 and abs(self._rows[0][4]) < _STRAIGHT_PER_M

    def pose(self, s_m: float) -> tuple[float, float, float]:
        """(x, y, heading) at a distance along the way; the heading is not wrapped."""
        row = self._rows[max(0, bisect_right(self._starts, s_m) - 1)]
        return _along(row, s_m - row[0])

    def curvature_per_m(self, s_m: float) -> float:
        """Curvature at a distance along the way."""
        return self._rows[max(0, bisect_right(self._starts, s_m) - 1)][4]

    def sharpest_per_m(self, from_m: float, to_m: float) -> float:
        """Largest curvature, without its sign, between two distances."""
        first = max(0, bisect_right(self._starts, from_m) - 1)
        last = max(0, bisect_right(self._starts, to_m) - 1)
        return max(abs(row[4]) for row in self._rows[first : last + 1])

    def poses(self, s_m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(x, y, heading) at many distances, each of the shape of ``s_m``."""
        if self.straight:
            s0, x, y, heading, _ = self._rows[0]
            run = s_m - s0
            return x + run * math.cos(heading), y + run * math.sin(heading), np.full(np.shape(s_m), heading)
        rows = np.array(self._rows)
        found = rows[np.maximum(np.searchsorted(rows[:, 0], s_m, side="right") - 1, 0)]
        starts, xs, ys, headings, k = np.moveaxis(found, -1, 0)
        half = 0.5 * k * (s_m - starts)
        chord = (s_m - starts) * np.sinc(half / math.pi)
        return xs + chord * np.cos(headings + half), ys + chord * np.sin(headings + half), headings + 2 * half

    def project(self, x_m: float, y_m: float) -> tuple[float, float]:
        """(distance along, distance to the left) of the way's point nearest to a place."""
        best, found = math.inf, (0.0, 0.0)
        last = len(self._rows) - 1
        for index, row in enumerate(self._rows):
            s0, x0, y0, heading, k = row
            length = (self._starts[index + 1] if index < last else math.inf) - s0
            low = -math.inf if index == 0 else 0.0
            dx, dy = x_m - x0, y_m - y0
            along, left = (
                dx * math.cos(heading) + dy * math.sin(heading),
                dy * math.cos(heading) - dx * math.sin(heading),
            )
            if abs(k) < _STRAIGHT_PER_M:
                run = min(max(along, low), length)
            else:  # the angle from the start about the arc's centre, which lies 1 / k to the left
                angle = math.atan2(along * k, 1 - left * k)
                run = min(max(angle / k, max(low, -math.pi / abs(k))), length)
            px, py, at = _along(row, run)
            ex, ey = x_m - px, y_m - py
            distance = math.hypot(ex, ey)
            if distance < best - 1e-9:
                side = ey * math.cos(at) - ex * math.sin(at)
                best, found = distance, (s0 + run, math.copysign(distance, side))
        return found

    def projections(self, x_m: np.ndarray, y_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """``project`` for many places at once: (N,), (N,) -> (N,), (N,)."""
        nearest, s, d = np.full(len(x_m), np.inf), np.zeros(len(x_m)), np.zeros(len(x_m))
        last = len(self._rows) - 1
        for index, (s0, x0, y0, heading, k) in enumerate(self._rows):
            high = (self._starts[index + 1] if index < last else math.inf) - s0
            low = -math.inf if index == 0 else 0.0
            cos, sin = math.cos(heading), math.sin(heading)
            along = (x_m - x0) * cos + (y_m - y0) * sin
            left = (y_m - y0) * cos - (x_m - x0) * sin
            if abs(k) < _STRAIGHT_PER_M:
                run = np.clip(along, low, high)
                px, py, turned = run, np.zeros_like(run), np.zeros_like(run)
            else:  # the angle from the start about the arc's centre, which lies 1 / k to the left
                run = np.arctan2(along * k, 1 - left * k) / k
                run = np.clip(run, max(low, -math.pi / abs(k)), high)
                turned = k * run
                px, py = np.sin(turned) / k, 2 * np.sin(0.5 * turned) ** 2 / k
            aside = (left - py) * np.cos(turned) - (along - px) * np.sin(turned)
            distance = np.hypot(along - px, left - py)
            closer = distance < nearest - 1e-9
            nearest = np.where(closer, distance, nearest)
            s, d = (
                np.where(closer, s0 + run, s),
                np.where(closer, np.copysign(distance, aside), d),
            )
        return s, d


def _along(row: tuple[float, float, float, float, float], run_m: float) -> tuple[float, float, float]:
    _, x, y, heading, k = row
    half = 0.5 * k * run_m
    # the chord of an arc, sin(half) / half of its length, points half-way between the headings at its ends
    chord = run_m * (math.sin(half) / half if abs(half) > 1e-6 else 1.0 - half * half / 6.0)
    return x + chord * math.cos(heading + half), y + chord * math.sin(heading + half), heading + 2 * half
