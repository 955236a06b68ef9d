"""Automatic emergency braking on p(crossing): hold the speed, brake, let go, drive on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from pedcross_env.config import require
from pedcross_env.errors import DataError

__all__ = ["AebConfig", "AebPolicy", "AebState"]


class AebState(StrEnum):
    """What the policy is doing; a closed set."""

    CRUISE = "cruise"  # holding the set speed
    BRAKE = "brake"
    RESUME = "resume"  # driving back up to the set speed


@dataclass(frozen=True, slots=True, kw_only=True)
class AebConfig:
    """When to brake and when to let go.

    The trigger needs ``consecutive_frames`` in a row at or above ``threshold``, so that one outlier does
    not stop the car; the release needs ``release_s`` below a lower threshold (hysteresis), so that flicker
    does not pump the brake.
    """

    threshold: float = 0.5
    consecutive_frames: int = 2
    release_threshold: float | None = None  # None: half of threshold
    release_s: float = 0.5
    braking_level: float = 1.0  # share of the strongest braking
    resume_level: float = 0.5  # share of the strongest acceleration

    def __post_init__(self) -> None:
        require(0 <= self.threshold <= 1, "threshold", self.threshold, "0 to 1")
        require(self.consecutive_frames >= 1, "consecutive_frames", self.consecutive_frames, "1 or more")
        if self.release_threshold is not None:
            release, allowed = self.release_threshold, f"0 to threshold ({self.threshold})"
            require(0 <= release <= self.threshold, "release_threshold", release, allowed)
        require(self.release_s >= 0, "release_s", self.release_s, "0 or more")
        require(0 < self.braking_level <= 1, "braking_level", self.braking_level, "above 0, at most 1")
        require(0 < self.resume_level <= 1, "resume_level", self.resume_level, "above 0, at most 1")

    @property
    def release_below(self) -> float:
        """The p under which the brake may be let go."""
        return 0.5 * self.threshold if self.release_threshold is None else self.release_threshold


class AebPolicy:
    """One braking logic for all detectors, so that only the detector differs between runs.

    The set speed is the speed at the first step after ``reset``. From ``info`` it reads ``time_s`` and
    ``speed_mps``, which a car knows of itself.
    """

    def __init__(self, config: AebConfig | None = None) -> None:
        self.config = config or AebConfig()
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget the last episode; nothing is drawn, so ``seed`` has no effect."""
        self.state = AebState.CRUISE
        self.set_speed_mps: float | None = None
        self._above = 0  # frames in a row at or above the threshold
        self._below_since_s: float | None = None

    def act(
        self, observation: Mapping[str, np.ndarray], info: Mapping[str, Any], p_crossing: float | None
    ) -> np.ndarray:
        """Advance the state by one frame; see ``Policy.act``.

        Raises:
            DataError: If p is nan or outside [0, 1]: a broken detector must not pass for a calm one.
        """
        time_s, speed_mps = float(info["time_s"]), float(info["speed_mps"])
        if self.set_speed_mps is None:
            self.set_speed_mps = speed_mps
        if p_crossing is not None:
            if not 0.0 <= p_crossing <= 1.0:
                raise DataError(f"p_crossing = {p_crossing!r} at {time_s:.2f} s: it must be in [0, 1].")
            self._observe(float(p_crossing), time_s)
        if self.state is AebState.RESUME and speed_mps >= self.set_speed_mps - 0.05:
            self.state = AebState.CRUISE
        return np.array([self._level(speed_mps)], dtype=np.float32)

    def _observe(self, p: float, time_s: float) -> None:
        self._above = self._above + 1 if p >= self.config.threshold else 0
        if p >= self.config.release_below:
            self._below_since_s = None
        elif self._below_since_s is None:
            self._below_since_s = time_s
        if self._above >= self.config.consecutive_frames:
            self.state = AebState.BRAKE
        elif self.state is AebState.BRAKE and self._below_since_s is not None:
            # A microsecond of slack: the clock is a sum of steps of 1/30 s.
            long_enough = time_s - self._below_since_s >= self.config.release_s - 1e-6
            self.state = AebState.RESUME if long_enough else AebState.BRAKE

    def _level(self, speed_mps: float) -> float:
        if self.state is AebState.BRAKE:
            return -self.config.braking_level
        if self.state is AebState.RESUME:
            set_speed_mps = self.set_speed_mps or 0.0
            # Ease off over the last metre per second: no overshoot behind the actuator's latency.
            return self.config.resume_level * min(1.0, max(0.1, set_speed_mps - speed_mps))
        return 0.0
