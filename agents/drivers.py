"""Drivers to compare an automatic brake with: one that only holds its speed, one that reacts as late as people do."""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from agents.aeb import AebConfig, AebPolicy
from pedcross_env.config import require

__all__ = ["CruiseDriver", "HumanConfig", "HumanDriver"]

_STREAM = 0x68756D616E  # of the reaction times, apart from the world's and the other controls'


class CruiseDriver:
    """Holds the speed it has at the first step, whatever it is told; back to it after a disturbance.

    Args:
        gain_per_s: Acceleration wanted per m/s too slow, over the strongest one's 3 m/s2 or 9 m/s2.
    """

    def __init__(self, gain_per_s: float = 0.3) -> None:
        require(0 < gain_per_s <= 2, "gain_per_s", gain_per_s, "above 0, at most 2")
        self._gain = gain_per_s
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget the set speed; nothing is drawn."""
        self.set_speed_mps: float | None = None

    def act(
        self, observation: Mapping[str, np.ndarray], info: Mapping[str, Any], p_crossing: float | None
    ) -> np.ndarray:
        """Choose the action of this step; see ``Policy.act``."""
        speed = float(info["speed_mps"])
        if self.set_speed_mps is None:
            self.set_speed_mps = speed
        wanted = self._gain * (self.set_speed_mps - speed)
        return np.array([min(1.0, max(-1.0, wanted))], dtype=np.float32)


@dataclass(frozen=True, slots=True, kw_only=True)
class HumanConfig:
    """How late and how hard a person brakes.

    Reaction times are log-normal. Green (2000, Transportation Human Factors 2(3), 195-216; its abstract was read) gives
    0.70 to 0.75 s where the signal is expected, 1.25 s for unexpected but common ones such as brake lights ahead, 1.5 s
    for surprises such as something that suddenly moves into the way. Who approaches a kerb in sight is no such
    surprise, hence the default; spread and braking level are this project's choice.
    """

    median_reaction_s: float = 1.25
    spread: float = 0.25  # standard deviation of the reaction time's logarithm
    braking_level: float = 0.8  # share of the strongest braking: most people do not use all of it
    aeb: AebConfig = field(default_factory=lambda: AebConfig(consecutive_frames=1, release_s=0.8))

    def __post_init__(self) -> None:
        require(0 <= self.median_reaction_s <= 10, "median_reaction_s", self.median_reaction_s, "0 to 10")
        require(0 <= self.spread <= 1, "spread", self.spread, "0 to 1")
        require(0 < self.braking_level <= 1, "braking_level", self.braking_level, "above 0, at most 1")


class HumanDriver:
    """Sees what its source of p(crossing) sees, and acts on it a reaction time later: braking and letting go.

    Attributes:
        reaction_s: Of this episode, drawn from its seed.
    """

    def __init__(self, config: HumanConfig | None = None) -> None:
        self.config = config or HumanConfig()
        self._policy = AebPolicy(
            dataclasses.replace(self.config.aeb, braking_level=self.config.braking_level)
        )
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget the last episode and draw a reaction time."""
        draw = float(np.random.default_rng([seed, _STREAM]).standard_normal())
        self.reaction_s = self.config.median_reaction_s * math.exp(self.config.spread * draw)
        self._policy.reset(seed)
        self._seen: deque[tuple[float, float]] = deque()
        self._felt: float | None = None

    def act(
        self, observation: Mapping[str, np.ndarray], info: Mapping[str, Any], p_crossing: float | None
    ) -> np.ndarray:
        """Choose the action of this step; see ``Policy.act``."""
        time_s = float(info["time_s"])
        if p_crossing is not None:
            self._seen.append((time_s, float(p_crossing)))
        while self._seen and self._seen[0][0] <= time_s - self.reaction_s + 1e-6:
            self._felt = self._seen.popleft()[1]
        return self._policy.act(observation, info, self._felt)
