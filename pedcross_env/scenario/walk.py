"""Where a pedestrian is at any time: its legs as a closed form, piecewise quadratic in time.

Speed changes linearly over ``RAMP_S``, from standing over the leg's run-up where it has one; a leg without wait
follows the one before without stopping, and a first leg with neither wait nor run-up is already under way at time 0.
The body turns towards a new leg over ``TURN_S`` per quarter turn.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import Any

import numpy as np

from pedcross_env.scenario.scenario import Leg, PedestrianSpec

__all__ = [
    "FASTEST_TURN_RADPS",
    "KNOT_FIELDS",
    "RAMP_S",
    "TURN_S",
    "Walk",
    "cadence_hz",
    "smoothstep",
    "wrap_angle",
]

RAMP_S = 0.3
TURN_S = 0.3
FASTEST_TURN_RADPS = 1.5 * 0.5 * math.pi / TURN_S
KNOT_FIELDS = ("time", "x", "y", "ux", "uy", "speed", "acceleration", "phase", "cadence", "cadence_rate")
"""Columns of Walk.knots: start of a piece, position, unit direction, speed and its rate, gait cycles, cycles
per second and their rate."""

_TINY = 1e-9


def wrap_angle(angle_rad: float) -> float:
    """The same angle in [-pi, pi)."""
    return (angle_rad + math.pi) % (2 * math.pi) - math.pi


def smoothstep(share: Any) -> Any:
    """3 s^2 - 2 s^3 of ``share`` (a number or an array) clipped to 0..1."""
    s = np.minimum(np.maximum(share, 0.0), 1.0)  # np.clip takes several times as long for a few numbers
    return s * s * (3.0 - 2.0 * s)


def cadence_hz(speed_mps: float, height_m: float, model: str = "adult") -> float:
    """Gait cycles (two steps) per second at a speed.

    Step length over step rate is constant for free walking (the walk ratio): 0.70 m at 2.0 Hz, that is
    1.4 m/s, for a height of 1.75 m; step length grows with height. The elderly take shorter and quicker steps.
    """
    walk_ratio = 0.35 * height_m / 1.75 * (0.85 if model == "elderly" else 1.0)
    return 0.5 * math.sqrt(speed_mps / walk_ratio)


def _merged_legs(spec: PedestrianSpec) -> list[tuple[Leg, float, float]]:
    """Legs that lead somewhere with (wait, distance); waits of legs that lead nowhere go to the next.

    A leg that waits for a trigger, and all behind it, are left out.
    """
    legs: list[tuple[Leg, float, float]] = []
    x, y, wait = spec.x_m, spec.y_m, 0.0
    for leg in spec.legs:
        if leg.go is not None:
            break
        wait += leg.wait_s
        distance = math.hypot(leg.to_x_m - x, leg.to_y_m - y)
        if distance > 1e-6:
            legs.append((leg, wait, distance))
            x, y, wait = leg.to_x_m, leg.to_y_m, 0.0
    return legs


class Walk:
    """The motion of one pedestrian.

    Attributes:
        knots: (K, 10) float64, columns KNOT_FIELDS: straight pieces of constant acceleration, by time.
        turns: (M, 4) float64: start time, yaw before, angle turned, duration.
        end_s: From this time on the pedestrian stands.
        top_speed_mps: Highest speed.
        turns_at_all: Whether the body ever turns.
    """

    def __init__(self, spec: PedestrianSpec) -> None:
        self.spec = spec
        rows, departures = self._pieces(spec)
        self.knots = np.array(rows, dtype=np.float64)
        self.turns = self._turns(spec.yaw_rad, departures)
        self.end_s = float(self.knots[-1, 0])
        self.top_speed_mps = max((leg.speed_mps for leg in spec.legs), default=0.0)
        self._rows = [tuple(row) for row in self.knots.tolist()]
        self._times = [row[0] for row in self._rows]
        self.turns_at_all = len(self.turns) > 1
        self._turn_rows = [tuple(row) for row in self.turns.tolist()]
        self._turn_times = [row[0] for row in self._turn_rows]

    @staticmethod
    def _pieces(spec: PedestrianSpec) -> tuple[list[list[float]], list[tuple[float, float]]]:
        legs = _merged_legs(spec)
        x, y, time, phase = spec.x_m, spec.y_m, 0.0, (spec.seed * 0.618033988749895) % 1.0
        ux, uy = math.cos(spec.yaw_rad), math.sin(spec.yaw_rad)
        under_way = bool(legs) and legs[0][1] == 0 and legs[0][0].run_up_m is None
        speed = legs[0][0].speed_mps if under_way else 0.0
        cadence = cadence_hz(speed, spec.height_m, spec.model)
        rows: list[list[float]] = []
        departures: list[tuple[float, float]] = []

        def add(duration: float, acceleration: float, cadence_to: float) -> None:
            nonlocal x, y, time, phase, speed, cadence
            if duration <= _TINY:
                return
            rate = (cadence_to - cadence) / duration
            rows.append([time, x, y, ux, uy, speed, acceleration, phase, cadence, rate])
            travelled = speed * duration + 0.5 * acceleration * duration**2
            x, y, time = x + ux * travelled, y + uy * travelled, time + duration
            phase += 0.5 * (cadence + cadence_to) * duration
            speed, cadence = speed + acceleration * duration, cadence_to

        for index, (leg, wait, distance) in enumerate(legs):
            if wait > 0:
                speed = cadence = 0.0
                add(wait, 0.0, 0.0)
            ux, uy = (leg.to_x_m - x) / distance, (leg.to_y_m - y) / distance
            departures.append((time, math.atan2(uy, ux)))
            stops = index + 1 == len(legs) or legs[index + 1][1] > 0
            cruise = leg.speed_mps
            if speed == 0.0 and stops:  # a leg too short to reach its speed is walked more slowly
                cruise = min(cruise, 0.5 * distance / RAMP_S)
            cruise_cadence = cadence_hz(cruise, spec.height_m, spec.model)
            ramp = min(RAMP_S, 0.5 * distance / max(cruise, speed))
            ramp_in = ramp if abs(cruise - speed) > _TINY else 0.0
            ramp_out = ramp if stops else 0.0
            if speed == 0.0 and leg.run_up_m is not None:
                ramp_in = 2.0 * min(leg.run_up_m, distance - 0.5 * cruise * ramp_out) / cruise
            if speed == 0.0:
                cadence = cruise_cadence
            even = distance - 0.5 * (speed + cruise) * ramp_in - 0.5 * cruise * ramp_out
            add(ramp_in, (cruise - speed) / ramp_in if ramp_in else 0.0, cruise_cadence)
            speed, cadence = cruise, cruise_cadence
            add(even / cruise, 0.0, cruise_cadence)
            add(ramp_out, -cruise / ramp, cruise_cadence)
            x, y = leg.to_x_m, leg.to_y_m
            if stops:
                speed = cadence = 0.0
        rows.append([time, x, y, ux, uy, 0.0, 0.0, phase, 0.0, 0.0])
        return rows, departures

    @staticmethod
    def _turns(yaw_rad: float, departures: list[tuple[float, float]]) -> np.ndarray:
        turns = [(-math.inf, yaw_rad, 0.0, 1.0)]
        for time, direction in departures:
            start, before, angle, duration = turns[-1]
            share = 1.0 if start == -math.inf else (time - start) / duration
            yaw = before + angle * float(smoothstep(share))
            change = wrap_angle(direction - yaw)
            if abs(change) > 1e-6:
                turns.append((time, yaw, change, TURN_S * max(1.0, abs(change) / (0.5 * math.pi))))
        return np.array(turns, dtype=np.float64)

    def position(self, time_s: float) -> tuple[float, float]:
        """Position (x, y) at one time, metres."""
        piece = self._rows[max(0, bisect_right(self._times, time_s) - 1)]
        elapsed = max(0.0, time_s - piece[0])
        travelled = piece[5] * elapsed + 0.5 * piece[6] * elapsed * elapsed
        return piece[1] + piece[3] * travelled, piece[2] + piece[4] * travelled

    def yaw(self, time_s: float) -> float:
        """Heading of the body at one time, rad, not wrapped."""
        index = bisect_right(self._turn_times, time_s) - 1
        start, before, angle, duration = self._turn_rows[index]
        share = min(max((time_s - start) / duration, 0.0), 1.0)
        return before + angle * share * share * (3.0 - 2.0 * share)

    def yaws(self, times_s: np.ndarray) -> np.ndarray:
        """Headings at many times: (T,) -> (T,), rad, not wrapped."""
        rows = self.turns[np.searchsorted(self.turns[:, 0], times_s, side="right") - 1]
        return rows[:, 1] + rows[:, 2] * smoothstep((times_s - rows[:, 0]) / rows[:, 3])

    def positions(self, times_s: np.ndarray) -> np.ndarray:
        """Positions at many times: (T,) -> (T, 2), metres."""
        pieces = self.knots[np.maximum(0, np.searchsorted(self.knots[:, 0], times_s, side="right") - 1)]
        elapsed = np.maximum(0.0, times_s - pieces[:, 0])
        travelled = pieces[:, 5] * elapsed + 0.5 * pieces[:, 6] * elapsed**2
        return pieces[:, 1:3] + pieces[:, 3:5] * travelled[:, None]
