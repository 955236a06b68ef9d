"""The ego's motion along its way: an actuator with latency, build-up and limited jerk, integrated without error.

The actuator's acceleration u follows the demand of ``latency_s`` ago at most at ``jerk_mps3``, builds up braking at
``strongest_braking_mps2 / build_up_s`` at most, and stays within what the road's friction bears. Between its events (a
demand takes effect, a ramp ends, the car stops) u is linear in time, so speed is quadratic and position cubic: each
piece is kept as its polynomial, and no step size enters.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from pedcross_env.config import EgoConfig, require

__all__ = ["GRAVITY_MPS2", "PITCH_PER_MPS2", "EgoMotion", "EgoState", "settle"]

GRAVITY_MPS2 = 9.81
PITCH_PER_MPS2 = 0.003  # rad of nose dive per m/s2 of braking: 1.5 degrees at full braking
_PITCH_LAG_S = 0.15
_BRAKE_LIGHT_FULL_MPS2 = 0.7  # UN R13-H: stop lamps lit from this deceleration on
_TINY = 1e-12


@dataclass(frozen=True, slots=True)
class EgoState:
    """The ego at one moment.

    Attributes:
        x_m: Of its centre, along its way.
        front_m: Of its front, along its way.
        speed_mps: Never negative.
        acceleration_mps2: Of the car; 0 at standstill.
        brake: Braking of the actuator over the strongest one, 0..1; held at standstill.
        pitch_rad: Nose down positive.
        brake_light: 0..1.
    """

    x_m: float
    front_m: float
    speed_mps: float
    acceleration_mps2: float
    brake: float
    pitch_rad: float
    brake_light: float


class _Piece(NamedTuple):
    start_s: float
    x_m: float
    speed_mps: float
    actuator_mps2: float
    jerk_mps3: float
    moving: bool
    pitch_rad: float


def settle(pitch_rad: Any, braking_mps2: Any, braking_rate: float, elapsed_s: Any) -> Any:
    """Nose dive after ``elapsed_s``: first-order lag behind a braking that changes linearly, in closed form.

    Floats or arrays of one shape.
    """
    lagged = PITCH_PER_MPS2 * (braking_mps2 - braking_rate * _PITCH_LAG_S)
    decay = (np.exp if isinstance(elapsed_s, np.ndarray) else math.exp)(-elapsed_s / _PITCH_LAG_S)
    return lagged + PITCH_PER_MPS2 * braking_rate * elapsed_s + (pitch_rad - lagged) * decay


def _time_to_stop(speed: float, acceleration: float, jerk: float) -> float:
    """First positive root of speed + acceleration t + jerk t^2 / 2, inf without one."""
    if abs(jerk) < _TINY:
        return -speed / acceleration if acceleration < 0 else math.inf
    discriminant = acceleration * acceleration - 2 * jerk * speed
    if discriminant < 0:
        return math.inf
    root = math.sqrt(discriminant)
    candidates = [t for t in ((-acceleration - root) / jerk, (-acceleration + root) / jerk) if t > _TINY]
    return min(candidates, default=math.inf)


class EgoMotion:
    """Position, speed and actuator of the ego over the present policy step.

    Args:
        config: Size and actuator.
        friction: Highest braking (and driving) acceleration over g.
        x_m: Of the centre at time 0.
        speed_mps: At time 0; it is held until the first demand takes effect.
    """

    def __init__(self, config: EgoConfig, *, friction: float, x_m: float, speed_mps: float) -> None:
        require(0.01 <= friction <= 2, "friction", friction, "0.01 to 2")
        self._config = config
        self._grip_mps2 = friction * GRAVITY_MPS2
        build_up = config.strongest_braking_mps2 / config.build_up_s if config.build_up_s > 0 else math.inf
        self._braking_jerk_mps3 = min(config.jerk_mps3, build_up)
        self._target_mps2 = 0.0
        self._pending: deque[tuple[float, float]] = deque()
        self._now_s, self._x_m, self._speed_mps, self._actuator_mps2, self._pitch_rad = (
            0.0,
            x_m,
            speed_mps,
            0.0,
            0.0,
        )
        self._pieces: list[_Piece] = [_Piece(0.0, x_m, speed_mps, 0.0, 0.0, speed_mps > 0, 0.0)]
        self._starts = [0.0]

    def begin(self, demand_mps2: float) -> None:
        """Start a policy step: forget the pieces of the last one, queue a demand."""
        limited = max(-self._config.strongest_braking_mps2, demand_mps2)
        if limited < -self._grip_mps2:  # ABS holds the wheels at the peak, else they slide
            limited = -self._grip_mps2 * (1.0 if self._config.abs else self._config.locked_share)
        limited = min(self._config.strongest_acceleration_mps2, self._grip_mps2, limited)
        self._pending.append((self._now_s + self._config.latency_s, limited))
        self._pieces, self._starts = [], []

    def advance(self, end_s: float) -> None:
        """Integrate exactly to ``end_s``, event by event."""
        while self._now_s < end_s - _TINY:
            while self._pending and self._pending[0][0] <= self._now_s + _TINY:
                self._target_mps2 = self._pending.popleft()[1]
            self._piece(end_s)

    def _piece(self, end_s: float) -> None:
        speed, actuator = self._speed_mps, self._actuator_mps2
        goal = max(0.0, self._target_mps2) if actuator > 0 else self._target_mps2  # first off the throttle
        gap = goal - actuator
        jerk = math.copysign(self._config.jerk_mps3, gap) if gap else 0.0
        if gap < 0 and actuator <= 0:
            jerk = -self._braking_jerk_mps3
        moving = speed > 0 or actuator > 0 or (actuator == 0 and jerk > 0)
        duration = end_s - self._now_s
        if self._pending:
            duration = min(duration, self._pending[0][0] - self._now_s)
        event = ""
        if jerk and gap / jerk <= duration:
            duration, event = gap / jerk, "ramped"
        if not moving and jerk > 0 and actuator < 0 and -actuator / jerk <= duration:
            duration, event = -actuator / jerk, "released"
        if moving and (stop := _time_to_stop(speed, actuator, jerk)) <= duration:
            duration, event = stop, "stopped"
        piece = _Piece(self._now_s, self._x_m, speed, actuator, jerk, moving, self._pitch_rad)
        self._pieces.append(piece)
        self._starts.append(self._now_s)
        self._now_s += duration
        self._x_m, self._speed_mps, self._pitch_rad = self._evaluate(piece, duration)
        self._actuator_mps2 = {"ramped": goal, "released": 0.0}.get(event, actuator + jerk * duration)
        if event == "stopped" or self._speed_mps < _TINY:
            self._speed_mps = 0.0

    @staticmethod
    def _evaluate(piece: _Piece, elapsed_s: float) -> tuple[float, float, float]:
        if not piece.moving:
            return piece.x_m, 0.0, settle(piece.pitch_rad, 0.0, 0.0, elapsed_s)
        u, j = piece.actuator_mps2, piece.jerk_mps3
        speed = piece.speed_mps + elapsed_s * (u + 0.5 * j * elapsed_s)
        x = piece.x_m + elapsed_s * (piece.speed_mps + elapsed_s * (0.5 * u + j * elapsed_s / 6.0))
        return x, max(0.0, speed), settle(piece.pitch_rad, -u, -j, elapsed_s)

    def _found(self, time_s: float) -> tuple[_Piece, float]:
        piece = self._pieces[max(0, bisect_right(self._starts, time_s) - 1)]
        return piece, max(0.0, min(time_s, self._now_s) - piece.start_s)

    def motion(self, time_s: float) -> tuple[float, float]:
        """Centre (m) and speed (m/s) at a time within the present step."""
        return self._evaluate(*self._found(time_s))[:2]

    def state(self, time_s: float) -> EgoState:
        """The whole state at a time within the present step."""
        if time_s >= self._now_s - _TINY:
            x, speed, pitch, actuator = self._x_m, self._speed_mps, self._pitch_rad, self._actuator_mps2
        else:
            piece, elapsed = self._found(time_s)
            x, speed, pitch = self._evaluate(piece, elapsed)
            actuator = piece.actuator_mps2 + piece.jerk_mps3 * elapsed
        return EgoState(
            x_m=x,
            front_m=x + 0.5 * self._config.length_m,
            speed_mps=speed,
            acceleration_mps2=actuator if speed > 0 or actuator > 0 else 0.0,
            brake=min(1.0, max(0.0, -actuator / self._config.strongest_braking_mps2)),
            pitch_rad=pitch,
            brake_light=min(1.0, max(0.0, -actuator / _BRAKE_LIGHT_FULL_MPS2)),
        )

    @property
    def top_speed_mps(self) -> float:
        """Upper bound of the speed over the present step."""
        rise = max([0.0, *(p.actuator_mps2 for p in self._pieces), self._actuator_mps2])
        start = self._pieces[0] if self._pieces else None
        if start is None:
            return self._speed_mps
        return max(start.speed_mps, self._speed_mps) + rise * (self._now_s - start.start_s)
