"""All pedestrians of a scenario at once: poses, gait and glances at any time, in few array operations."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pedcross_env.scenario.layout import carriageway_m
from pedcross_env.scenario.scenario import PedestrianSpec
from pedcross_env.scenario.sizes import contact_radius_m, pedestrian_size
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.scenario.trigger import Fires
from pedcross_env.scenario.walk import RAMP_S, Walk, smoothstep

__all__ = ["PedestrianPoses", "Pedestrians"]

_GLANCE_EASE_S = 0.3
_GLANCE_HALF_S = 0.6
_GLANCE_BACK_S = 1.5  # after looking to the near lane, to the far one
_GLANCE_BACK_SHARE = 0.8  # of the angle
_GLANCES_UNTIL_S = 600.0  # no episode is longer
_GLANCE_LIMIT_RAD = 1.2  # how far a head turns
_GLANCE_SHARE = 0.85  # so that six of ten look in the last second before they cross: 58.9 % in JAAD
_KERB_ZONE_M = 0.6  # who comes this near to the kerb from outside is about to cross, or seems to be
_KERB_RAMP_M = 0.3  # over which a foot goes down the kerb
_WATCH_HZ = 100  # how often who waits for a trigger looks: a clock of its own, whatever the policy's rate


@dataclass(frozen=True, slots=True)
class PedestrianPoses:
    """State of N pedestrians at one time, each (N,) float64, or at T, (T, N); units and meanings as in ACTOR_DTYPE."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    yaw: np.ndarray
    speed: np.ndarray
    gait_phase: np.ndarray
    gait_stride: np.ndarray
    head_yaw: np.ndarray


def _glance(walk: Walk, street: StreetSpec) -> tuple[float, float, float]:
    """(middle of the glance in s, half its length, head angle) of the first approach to a kerb.

    Who faces the street looks to the left first, where the near lane comes from in right-hand traffic. Nobody's
    glance tells whether it crosses: it depends on the way to the kerb and on the seed alone.
    """
    never = (0.0, -1.0, 0.0)
    if (walk.spec.seed * 0.754877666246693) % 1.0 >= _GLANCE_SHARE:
        return never
    times = np.arange(0.0, min(walk.end_s, _GLANCES_UNTIL_S) + 0.1, 0.05)
    inside = carriageway_m(street, *walk.positions(times).T)
    zone = np.flatnonzero((inside <= 0.05) & (inside >= -_KERB_ZONE_M))
    if zone.size == 0:
        return never
    middle = float(times[zone[0]])
    if zone[0] == 0:  # stands there from the start: glances some time later
        middle += 4.0 * ((walk.spec.seed * 0.569840290998053) % 1.0)
    return middle, _GLANCE_HALF_S, _GLANCE_LIMIT_RAD


def _look(since_s: np.ndarray, half_s: np.ndarray) -> np.ndarray:
    """Share to which a head is turned ``since_s`` after the middle of a glance that holds ``half_s`` to either side."""
    return smoothstep((half_s + _GLANCE_EASE_S - np.abs(since_s)) / _GLANCE_EASE_S) * (half_s > 0)


def _padded(tables: list[np.ndarray], columns: int) -> np.ndarray:
    """Stack tables of different lengths, (N, longest, columns); rows that do not exist start at inf."""
    stacked = np.zeros((len(tables), max((len(t) for t in tables), default=1), columns))
    stacked[:, :, 0] = np.inf
    for row, table in zip(stacked, tables, strict=True):
        row[: len(table)] = table
    return stacked


def _columns(table: np.ndarray) -> np.ndarray:
    """What lies along the last axis, first."""
    return table.transpose(-1, *range(table.ndim - 1))


class Pedestrians:
    """The pedestrians of a scenario.

    Attributes:
        walks: One per pedestrian, in the scenario's order.
        footprints_m: (N, 2) length along the heading and width of the box that stands for each in contact.
        heights_m: (N,).
        radius_m: (N,) radius of a disc as large as the footprint, for others that keep clear.
    """

    def __init__(self, specs: tuple[PedestrianSpec, ...], street: StreetSpec) -> None:
        self.walks = [Walk(spec) for spec in specs]
        self.radius_m = np.array([contact_radius_m(spec.height_m) for spec in specs], dtype=np.float64)
        sizes = [pedestrian_size(spec.height_m)[:2] for spec in specs]
        self.footprints_m = np.array(sizes, dtype=np.float64).reshape(-1, 2)
        self.heights_m = np.array([spec.height_m for spec in specs], dtype=np.float64)
        self.top_speed_mps = np.array([walk.top_speed_mps for walk in self.walks], dtype=np.float64)
        self._street = street
        glances = [_glance(walk, street) for walk in self.walks]
        self._glances = np.array(glances, dtype=np.float64).reshape(-1, 3)
        self._rows = np.arange(len(specs))
        self._tabulate()

    def _tabulate(self) -> None:
        self._knots = _padded([walk.knots for walk in self.walks], 10)
        self._turns = _padded([walk.turns for walk in self.walks], 4)

    def __len__(self) -> int:
        return len(self.walks)

    @property
    def waiting(self) -> bool:
        """Whether somebody waits, or will wait, for a trigger."""
        return any(leg.go is not None for walk in self.walks for leg in walk.spec.legs)

    def watch(self, start_s: float, end_s: float, fires: Fires) -> list[int]:
        """Let those go whose triggers fire in a time; nothing before that time changes.

        Args:
            start_s: Excluded, but for 0.
            end_s: Included.
            fires: Whether a trigger's conditions hold for an actor: (trigger, (x, y, heading), time).

        Returns:
            Indices of those whose walks have changed.
        """
        changed = []
        for index in range(len(self.walks)):
            while self._watched(index, start_s, end_s, fires):
                changed.append(index)
        if changed:
            self._tabulate()
            self.top_speed_mps = np.array([walk.top_speed_mps for walk in self.walks], dtype=np.float64)
        return changed

    def _watched(self, index: int, start_s: float, end_s: float, fires: Fires) -> bool:
        walk = self.walks[index]
        legs = walk.spec.legs
        gate = next((k for k, leg in enumerate(legs) if leg.go is not None), None)
        if gate is None:
            return False
        go, arrives_s = legs[gate].go, walk.end_s
        x, y = walk.position(arrives_s)

        slows_s = max(0.0, arrives_s - RAMP_S)
        first = math.floor(max(start_s, slows_s) * _WATCH_HZ)
        looks = [k / _WATCH_HZ for k in range(first, math.floor(end_s * _WATCH_HZ + 1e-9) + 1)]
        looks = [t for t in looks if t > start_s and t >= arrives_s]
        if (start_s < slows_s <= end_s) or slows_s == start_s == 0.0:
            looks.insert(0, slows_s)
        for time in looks:
            if go is None or not fires(go, (x, y, 0.0), time):
                continue
            wait = legs[gate].wait_s + go.delay_s + max(0.0, time - arrives_s)
            released = replace(legs[gate], go=None, wait_s=wait)
            self.walks[index] = Walk(replace(walk.spec, legs=(*legs[:gate], released, *legs[gate + 1 :])))
            return True
        return False

    def poses(self, time_s: float | np.ndarray) -> PedestrianPoses:
        """Everything about all pedestrians at one time, or at (T,) times, for little more than at one."""
        at = time_s
        if isinstance(time_s, np.ndarray):
            time_s, at = time_s[:, None], time_s[:, None, None]
        last = (self._knots[:, :, 0] <= at).sum(axis=-1) - 1
        start, x, y, ux, uy, speed, acceleration, phase, cadence, rate = _columns(
            self._knots[self._rows, np.maximum(last, 0)]
        )
        elapsed = time_s - start
        travelled = elapsed * (speed + 0.5 * acceleration * elapsed)
        y = y + uy * travelled
        speed = np.maximum(speed + acceleration * elapsed, 0.0)
        cadence_now = cadence + rate * elapsed
        walking = cadence_now > 1e-6
        turn = (self._turns[:, :, 0] <= at).sum(axis=-1) - 1
        turn_start, before, angle, duration = _columns(self._turns[self._rows, turn])
        middle, half, head = self._glances.T
        there, back = _look(time_s - middle, half), _look(time_s - middle - _GLANCE_BACK_S, 0.5 * half)
        x = x + ux * travelled
        return PedestrianPoses(
            x=x,
            y=y,
            z=self._street.kerb_height_m
            * smoothstep(0.5 - self._inside_m(x, y) / _KERB_RAMP_M),
            yaw=before + angle * smoothstep((time_s - turn_start) / duration),
            speed=speed,
            gait_phase=phase + elapsed * (cadence + 0.5 * rate * elapsed),
            gait_stride=np.where(walking, speed / np.where(walking, cadence_now, 1.0), 0.0),
            head_yaw=head * (there - _GLANCE_BACK_SHARE * back),
        )  # fmt: skip

    def _inside_m(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        if self._street.straight:
            return self._street.kerb_y_m - np.abs(y)
        return carriageway_m(self._street, x, y)

    def table(self, times_s: np.ndarray) -> np.ndarray:
        """Positions of all at many times: (T,) -> (N, T, 2)."""
        if not self.walks:
            return np.zeros((0, len(times_s), 2))
        return np.stack([walk.positions(times_s) for walk in self.walks])

    def yaw_table(self, times_s: np.ndarray) -> np.ndarray:
        """Headings of all at many times: (T,) -> (N, T), rad, not wrapped."""
        return np.array([walk.yaws(times_s) for walk in self.walks]).reshape(-1, len(times_s))
