"""Play one episode with a source of p(crossing) and a policy, and boil it down to one row."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import gymnasium
import numpy as np

from agents import ControlDetector, Policy
from pedcross_env.contracts import Outcome

__all__ = ["ControlSource", "DetectorSource", "Source", "Trace", "play", "summarise_trace"]

FALSE_BRAKING_MPS2 = 0.25 * 9.81
"""Automatic deceleration from which on braking without a reason counts as false (FMVSS 127: 0.25 g)."""

EXCUSE_S = 1.0
"""Braking this long after a crossing label, or this long before somebody steps out, is not false."""

STANDSTILL_MPS = 0.1


class Source(Protocol):
    """Where the closed loop has p(crossing) from."""

    def reset(self, seed: int) -> None:
        """Start an episode."""
        ...

    def estimate(self, observation: Mapping[str, np.ndarray], info: Mapping[str, Any]) -> float | None:
        """Return p(crossing) in [0, 1], or None while there is none yet."""
        ...


class DetectorSource:
    """A detector: sees the observation and nothing of ``info``.

    Its p counts from the moment its window is full: before, it judges copies of the first frame, a standing
    world that no drive shows, and would be blamed for what only the start of an episode does.
    """

    def __init__(self, detector: Any) -> None:
        self._detector = detector

    def reset(self, seed: int) -> None:
        """Forget the last episode's frames; a detector draws nothing."""
        self._detector.reset()
        self._seen = 0

    def estimate(self, observation: Mapping[str, np.ndarray], info: Mapping[str, Any]) -> float | None:
        """Return the detector's p, None before it has seen T frames."""
        p = float(self._detector.update(observation))
        self._seen += 1
        return p if self._seen >= self._detector.frames else None


class ControlSource:
    """A control: sees ``info`` and no image."""

    def __init__(self, control: ControlDetector) -> None:
        self._control = control

    def reset(self, seed: int) -> None:
        """Seed the control."""
        self._control.reset(seed)

    def estimate(self, observation: Mapping[str, np.ndarray], info: Mapping[str, Any]) -> float | None:
        """Return the control's p."""
        return self._control.update(info)


@dataclass(slots=True)
class Trace:
    """What happened, step by step; entry 0 is the reset.

    Attributes:
        infos: N+1 infos.
        actions: N actions, each decided on the info of the same index.
        probabilities: N values of p, nan where the source had none yet.
        source_s: N durations of the source's estimate.
        wall_s: Duration of the whole episode, reset included.
    """

    infos: list[Mapping[str, Any]] = field(default_factory=list)
    actions: list[float] = field(default_factory=list)
    probabilities: list[float] = field(default_factory=list)
    source_s: list[float] = field(default_factory=list)
    wall_s: float = 0.0


def play(
    env: gymnasium.Env[Any, Any],
    source: Source,
    policy: Policy,
    *,
    seed: int,
    weather: str,
    cell: str = "",
    watch: Callable[[Trace, Mapping[str, np.ndarray]], None] | None = None,
) -> Trace:
    """Play the episode of ``seed`` in ``weather`` to its end.

    Args:
        env: Reset here.
        source: Of p(crossing).
        policy: Decides on it.
        seed: Of the episode.
        weather: A preset's name.
        cell: Of a suite, whose weather it then is: ``weather`` is not used.
        watch: Called with the trace so far and the observation, after the reset and after every step.
    """
    begin_s = time.perf_counter()
    trace = Trace()
    options = {"cell": cell} if cell else {"weather": weather}
    observation, info = env.reset(seed=seed, options=options)
    source.reset(seed)
    policy.reset(seed)
    trace.infos.append(info)
    if watch is not None:
        watch(trace, observation)
    ended = False
    while not ended:
        before_s = time.perf_counter()
        p = source.estimate(observation, info)
        trace.source_s.append(time.perf_counter() - before_s)
        action = policy.act(observation, info, p)
        observation, _, terminated, truncated, info = env.step(action)
        trace.actions.append(float(action[0]))
        trace.probabilities.append(math.nan if p is None else p)
        trace.infos.append(info)
        if watch is not None:
            watch(trace, observation)
        ended = bool(terminated or truncated)
    trace.wall_s = time.perf_counter() - begin_s
    return trace


def summarise_trace(trace: Trace) -> dict[str, Any]:
    """One row of facts about an episode; times in s since reset, nan where there is nothing to measure."""
    first, last = trace.infos[0], trace.infos[-1]
    time_s = _column(trace, "time_s")
    label = _column(trace, "crossing") > 0
    speed = _column(trace, "speed_mps")
    reason = label | (_column(trace, "conflict") > 0)
    false = false_braking_steps(
        time_s, _column(trace, "acceleration_mps2"), reason, _column(trace, "crossing_in_s")
    )  # fmt: skip
    distance = _column(trace, "distance_m")
    collided = str(last["outcome"]) == Outcome.COLLISION
    first_label = int(np.argmax(label)) if label.any() else None
    braking = np.array(trace.actions) < 0
    source_ms = 1e3 * np.array(trace.source_s)
    return {
        "scenario": str(first["scenario"]),
        "is_crossing": bool(math.isfinite(float(first["crossing_in_s"])) or label.any()),
        "outcome": str(last["outcome"]),
        "collision": collided,
        "impact_speed_mps": float(last["impact_speed_mps"]) if collided else math.nan,
        "initial_speed_mps": float(first["speed_mps"]),
        "final_speed_mps": float(last["speed_mps"]),
        "stopped": bool((speed < STANDSTILL_MPS).any()),
        "min_ttc_s": float(_column(trace, "ttc_s").min()),
        "first_label_s": math.nan if first_label is None else float(time_s[first_label]),
        "label_distance_m": math.nan if first_label is None else float(distance[first_label]),
        "first_brake_s": float(time_s[:-1][braking][0]) if braking.any() else math.nan,
        "brake_ttc_s": float(_column(trace, "ttc_s")[:-1][braking][0]) if braking.any() else math.nan,
        "min_pet_s": float(last["pet_s"]),
        "peak_drac_mps2": float(_column(trace, "drac_mps2").max()),
        "brake_delay_s": _brake_delay_s(time_s[:-1], braking, first_label),
        "peak_deceleration_mps2": float(max(0.0, -_column(trace, "acceleration_mps2").min())),
        "peak_demand_mps2": float(max(0.0, -_column(trace, "demand_mps2").min())),
        "false_braking": bool(false.any()),
        "false_brake_events": int(np.sum(false & ~np.append(False, false[:-1]))),
        "distance_km": float(last["position_m"] - first["position_m"]) / 1000,
        "duration_s": float(time_s[-1] - time_s[0]),
        "steps": len(trace.actions),
        "wall_s": trace.wall_s,
        "detector_ms_mean": float(source_ms.mean()),
        "detector_ms_p95": float(np.quantile(source_ms, 0.95)),
    }


def false_braking_steps(
    time_s: np.ndarray, acceleration_mps2: np.ndarray, reason: np.ndarray, crossing_in_s: np.ndarray
) -> np.ndarray:
    """Steps at which the car brakes by 0.25 g or more for nobody.

    Nobody: there is no reason now nor was one in the last second, and nobody steps out within the next. A reason is a
    labelled crossing, or a conflict: who stands in the lane or walks along it, a car ahead.

    Args:
        time_s: (N,) ascending.
        acceleration_mps2: (N,) actual acceleration.
        reason: (N,) bool.
        crossing_in_s: (N,) time until somebody steps onto the carriageway; inf: never.

    Returns:
        (N,) bool.
    """
    last_reason_s = np.maximum.accumulate(np.where(reason, time_s, -np.inf))
    recent = time_s - last_reason_s <= EXCUSE_S + 1e-6
    soon = crossing_in_s <= EXCUSE_S
    return (acceleration_mps2 <= -FALSE_BRAKING_MPS2) & ~recent & ~soon


def _brake_delay_s(time_s: np.ndarray, braking: np.ndarray, first_label: int | None) -> float:
    """Start of the braking that answers the label, relative to the label; negative: braked before it."""
    if first_label is None or first_label >= time_s.size:
        return math.nan
    answers = np.flatnonzero(braking & (time_s >= time_s[first_label] - EXCUSE_S))
    if not answers.size:
        return math.nan
    start = int(answers[0])
    while start > 0 and braking[start - 1]:
        start -= 1
    return float(time_s[start] - time_s[first_label])


def _column(trace: Trace, key: str) -> np.ndarray:
    return np.array([float(info[key]) for info in trace.infos])
