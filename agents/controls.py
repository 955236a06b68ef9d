"""Sources of p(crossing) without a network: what any detector's score has to be read against.

All of them feed the same ``AebPolicy`` as the detectors do. They see ``info``, i.e. the truth, and no image.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from pedcross_env.errors import unknown_name

__all__ = [
    "CONTROLS",
    "AlwaysControl",
    "ControlDetector",
    "NeverControl",
    "OracleControl",
    "RandomControl",
    "make_control",
]


class ControlDetector(Protocol):
    """A source of p(crossing) that may look at the truth.

    Attributes:
        name: For tables.
        threshold: The p at which the braking logic triggers for this source.
        note: One sentence for the report.
    """

    name: str
    threshold: float
    note: str

    def reset(self, seed: int) -> None:
        """Start an episode; ``seed`` drives whatever is drawn."""
        ...

    def update(self, info: Mapping[str, Any]) -> float:
        """Return p(crossing) in [0, 1] for this step's info."""
        ...


class NeverControl:
    """Never brakes: what happens without any system."""

    name = "never"
    threshold = 0.5
    note = "never brakes: its collisions are what a detector could avoid"

    def reset(self, seed: int) -> None:
        """Nothing is kept."""

    def update(self, info: Mapping[str, Any]) -> float:
        """Return 0."""
        return 0.0


class AlwaysControl:
    """Always brakes: no collision is easy if nobody has to arrive."""

    name = "always"
    threshold = 0.5
    note = "brakes from the first frame on: safe and useless, it bounds false braking from above"

    def reset(self, seed: int) -> None:
        """Nothing is kept."""

    def update(self, info: Mapping[str, Any]) -> float:
        """Return 1."""
        return 1.0


class OracleControl:
    """Returns the frame's label: a perfect detector of the labelled task, not a prophet.

    The label begins when the pedestrian is on the carriageway, so where somebody steps out closer
    than the car can stop, the oracle collides as well: what it leaves is left to physics and prediction.
    """

    name = "oracle"
    threshold = 0.5
    note = "p is the frame's label: a perfect detector, still bound by latency, friction and a late label"

    def reset(self, seed: int) -> None:
        """Nothing is kept."""

    def update(self, info: Mapping[str, Any]) -> float:
        """Return the label, 0 or 1."""
        return float(info["crossing"])


class RandomControl:
    """p is uniform on [0, 1), drawn anew each second; blind, but it does not brake all the time.

    With its threshold of 0.9 a second without braking begins to brake with probability 0.1. Once braking,
    with the default release at half the threshold, a second lets go with probability 0.45.
    """

    name = "random"
    threshold = 0.9
    note = "p is uniform, drawn anew each second; threshold 0.9: blindly begins to brake in one second of ten"
    hold_s = 1.0

    def __init__(self) -> None:
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Seed the stream."""
        self._rng = np.random.default_rng([seed, 0x72616E64])  # a stream of its own, apart from the world's
        self._block = -1
        self._p = 0.0

    def update(self, info: Mapping[str, Any]) -> float:
        """Return this second's p."""
        block = int(float(info["time_s"]) / self.hold_s + 1e-9)
        while self._block < block:
            self._p = float(self._rng.random())
            self._block += 1
        return self._p


CONTROLS: dict[str, type[OracleControl] | type[NeverControl] | type[AlwaysControl] | type[RandomControl]] = {
    "oracle": OracleControl,
    "never": NeverControl,
    "always": AlwaysControl,
    "random": RandomControl,
}
"""The controls by name, in the order of tables."""


def make_control(name: str) -> ControlDetector:
    """Build the control ``name``; ConfigError for an unknown one."""
    if name not in CONTROLS:
        raise unknown_name("control", name, CONTROLS)
    return CONTROLS[name]()
