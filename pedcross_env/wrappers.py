"""Wrappers for learners: stacked frames and a limit in seconds; ``agents.wrappers`` adds a detector's probability."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs

from pedcross_env.config import require
from pedcross_env.errors import unknown_name

__all__ = ["SecondsLimit", "StackFrames"]

Observation = dict[str, np.ndarray]


class StackFrames(gymnasium.ObservationWrapper[Observation, Any, Observation], RecordConstructorArgs):
    """Give the last frames of some keys instead of the last one: (T, ...) in the order of time.

    After a reset the first frame fills the stack.

    Args:
        env: With a Dict observation.
        frames: T.
        keys: Which; default: the cameras' among them.

    Raises:
        ConfigError: For fewer than 1 frame, or a key that is not observed.
    """

    def __init__(
        self, env: gymnasium.Env[Observation, Any], frames: int, keys: Sequence[str] | None = None
    ) -> None:
        RecordConstructorArgs.__init__(self, frames=frames, keys=keys)
        super().__init__(env)
        require(frames >= 1, "frames", frames, "1 or more")
        space = env.observation_space
        require(isinstance(space, spaces.Dict), "observation space", space, "a Dict")
        known: dict[str, Any] = dict(space.spaces)  # type: ignore[attr-defined]
        self._keys = tuple(k for k in ("rgb", "dvs") if k in known) if keys is None else tuple(keys)
        for key in self._keys:
            if key not in known:
                raise unknown_name("observation key", key, known)
            box = known[key]
            low, high = (np.repeat(bound[None], frames, axis=0) for bound in (box.low, box.high))
            known[key] = spaces.Box(low, high, dtype=box.dtype)
        self.observation_space: Any = spaces.Dict(known)
        self._frames = {key: deque[np.ndarray](maxlen=frames) for key in self._keys}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Forget the frames, then reset."""
        for seen in self._frames.values():
            seen.clear()
        return super().reset(seed=seed, options=options)

    def observation(self, observation: Observation) -> Observation:
        """Add the frame to the stack and return the stack in its place."""
        stacked = dict(observation)
        for key, seen in self._frames.items():
            for _ in range((seen.maxlen or 1) if not seen else 1):
                seen.append(observation[key])
            stacked[key] = np.stack(seen)
        return stacked


class SecondsLimit(gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Truncate an episode after a time of the world, whatever the policy's rate.

    Args:
        env: Whose info has ``time_s``.
        seconds: The limit.

    Raises:
        ConfigError: For a limit that is not positive.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], seconds: float) -> None:
        RecordConstructorArgs.__init__(self, seconds=seconds)
        super().__init__(env)
        require(seconds > 0, "seconds", seconds, "positive")
        self._seconds = seconds

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step, truncated where the time is over and the episode has not ended by itself."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        over = info["time_s"] >= self._seconds - 1e-9
        return observation, reward, terminated, truncated or (over and not terminated), info
