"""The ego's lateral motion where actions steer: a kinematic bicycle whose way is laid as it drives.

The front wheels' angle follows the demand of ``steer_latency_s`` ago at ``steer_rate_radps``; the way's curvature is
tan(angle) / wheelbase, at most what the road's friction bears, mu g / v^2 (beyond it the car understeers). Over
1/240 s, counted from time 0, the curvature is constant: the way is made of arcs, and poses are exact upon it.
The car's centre follows the way and its body is tangent to it there: no slip angle.
"""

from __future__ import annotations

import math
from collections import deque

from pedcross_env.config import EgoConfig
from pedcross_env.scenario.route import Route
from pedcross_env.world.ego import GRAVITY_MPS2, EgoMotion

__all__ = ["Steering"]

_HZ = 240
_TINY_S = 1e-9
_TINY_M = 1e-9


class Steering:
    """Extends the ego's way by what it steers.

    Args:
        config: Wheelbase, limits and latency.
        friction: Highest lateral acceleration over g.
        motion: Along the way.
        start: (x, y, heading) at time 0.

    Attributes:
        route: Driven so far; beyond its end it goes on as the wheels stand.
    """

    def __init__(
        self, config: EgoConfig, *, friction: float, motion: EgoMotion, start: tuple[float, float, float]
    ) -> None:
        self._config, self._grip_mps2, self._motion = config, friction * GRAVITY_MPS2, motion
        self._now_s, self._angle_rad, self._target_rad = 0.0, 0.0, 0.0
        self._pending: deque[tuple[float, float]] = deque()
        # a first piece of no importance, behind the start: a way needs one
        back = (start[0] - math.cos(start[2]), start[1] - math.sin(start[2]), start[2])
        self.route = Route([(1.0, 0.0)], start=back, start_m=motion.motion(0.0)[0] - 1.0)

    @property
    def curvature_per_m(self) -> float:
        """Of the way as the wheels stand now, to the left positive."""
        return math.tan(self._angle_rad) / self._config.wheelbase_m

    def begin(self, angle_rad: float) -> None:
        """Queue a demand at the start of a policy step."""
        limit = self._config.max_steer_rad
        self._pending.append((self._now_s + self._config.steer_latency_s, max(-limit, min(limit, angle_rad))))

    def advance(self, end_s: float) -> None:
        """Lay the way to ``end_s``, up to which the motion along it is known."""
        while self._now_s < end_s - _TINY_S:
            while self._pending and self._pending[0][0] <= self._now_s + _TINY_S:
                self._target_rad = self._pending.popleft()[1]
            until = (math.floor(self._now_s * _HZ + 1e-6) + 1) / _HZ
            if self._pending:
                until = min(until, self._pending[0][0])
            self._lay(min(until, end_s))

    def _lay(self, until_s: float) -> None:
        most = self._config.steer_rate_radps * (until_s - self._now_s)
        change = max(-most, min(most, self._target_rad - self._angle_rad))
        before_m = self._motion.motion(self._now_s)[0]
        middle_mps = self._motion.motion(0.5 * (self._now_s + until_s))[1]
        length = self._motion.motion(until_s)[0] - before_m
        if length > _TINY_M:
            curvature = math.tan(self._angle_rad + 0.5 * change) / self._config.wheelbase_m
            limit = self._grip_mps2 / max(middle_mps, 1e-3) ** 2
            self.route.extend(length, max(-limit, min(limit, curvature)))
        self._angle_rad += change
        self._now_s = until_s
