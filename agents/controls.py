"""Sources of p(crossing) without a network: what any detector's score has to be read against.

They see ``info``, i.e. the truth, and no image. All of them feed the same ``AebPolicy`` as the detectors do, but for
"human", behind whom a ``HumanDriver`` brakes: ``braking_policy`` says which.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from agents.aeb import AebConfig, AebPolicy
from agents.drivers import HumanDriver
from agents.policy import Policy
from pedcross_env.errors import unknown_name

__all__ = [
    "CONTROLS",
    "AlwaysControl",
    "ControlDetector",
    "HumanControl",
    "NeverControl",
    "OracleControl",
    "RandomControl",
    "braking_policy",
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


class HumanControl(OracleControl):
    """Sees what the oracle sees; a person acts on it, a reaction time later and with less than all of the brake.

    It looks through parked cars as the oracle does, and is never distracted: a good driver, no average one.
    """

    name = "human"
    note = "an attentive driver: sees the frame's label, brakes by 80 % a reaction time later (median 1.25 s)"


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
    "human": HumanControl,
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


def braking_policy(source: str, aeb: AebConfig) -> Policy:
    """Return what brakes on a source's p: a ``HumanDriver`` for the control "human", else the shared ``AebPolicy``.

    Args:
        source: Name of a control or of a detector.
        aeb: Of the shared policy; a person keeps to ``HumanConfig``.
    """
    return HumanDriver() if source == HumanControl.name else AebPolicy(aeb)
