"""A detector's p(crossing) as an observation: for policies that learn to brake on what a detector says."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from pedcross_env.config import require
from perception.detector import Detector

__all__ = ["DetectorProbability"]

Observation = dict[str, np.ndarray]


class DetectorProbability(gymnasium.ObservationWrapper[Observation, Any, Observation]):
    """Add ``p_crossing`` (1,) float32 to the observation; the detector is reset with the episode.

    Args:
        env: Whose observation has the detector's modality.
        detector: Streaming; it must be this environment's own.
        keep_camera: Whether the detector's frames stay in the observation.

    Raises:
        ConfigError: Where the environment does not observe what the detector reads.
    """

    def __init__(
        self, env: gymnasium.Env[Observation, Any], detector: Detector, *, keep_camera: bool = False
    ) -> None:
        super().__init__(env)
        space = env.observation_space
        members: dict[str, Any] = dict(space.spaces) if isinstance(space, spaces.Dict) else {}
        require(
            detector.modality in members, "observed modalities", sorted(members),
            f"to contain {detector.modality!r}, which {detector.name!r} reads",
        )  # fmt: skip
        self.detector, self._keep_camera = detector, keep_camera
        if not keep_camera:
            del members[detector.modality]
        members["p_crossing"] = spaces.Box(0.0, 1.0, (1,), np.float32)
        self.observation_space: Any = spaces.Dict(members)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Reset the detector, then the environment."""
        self.detector.reset()
        return super().reset(seed=seed, options=options)

    def observation(self, observation: Observation) -> Observation:
        """Ask the detector about the frame."""
        seen = dict(observation)
        probability = self.detector.update(observation)
        if not self._keep_camera:
            del seen[self.detector.modality]
        seen["p_crossing"] = np.array([probability], np.float32)
        return seen
