"""What everything downstream knows of a detector."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

import numpy as np

from pedcross_env.contracts import Modality

__all__ = ["Detector"]


@runtime_checkable
class Detector(Protocol):
    """Frames in, p(crossing) out, streaming or by clip; see ``perception.contract`` for its checks.

    Attributes:
        name: For tables, e.g. "sps_r18t-dvs".
        modality: The key it reads of an observation.
        frames: T of its clips.
    """

    name: str
    modality: Modality
    frames: int

    def reset(self) -> None:
        """Forget everything seen; call at the start of an episode."""
        ...

    def update(self, observation: Mapping[str, np.ndarray]) -> float:
        """Take the next observation.

        Args:
            observation: The environment's: ``rgb`` (H, W, 3) uint8, ``dvs`` (H, W, 2) uint8 counts.

        Returns:
            p(crossing) in [0, 1] now. Before T frames were seen the window is filled by
            repeating the first one in front.
        """
        ...

    def predict(self, clips: np.ndarray) -> np.ndarray:
        """Map clips (N, T, H, W, C) uint8, encoded as observations are, to p(crossing) (N,) float64.

        Streaming state is neither used nor changed.
        """
        ...
