"""What the closed loop asks of a policy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np

__all__ = ["Policy"]


@runtime_checkable
class Policy(Protocol):
    """Turns what is seen and believed into the environment's action."""

    def reset(self, seed: int) -> None:
        """Forget the last episode; ``seed`` drives whatever the policy draws."""
        ...

    def act(
        self, observation: Mapping[str, np.ndarray], info: Mapping[str, Any], p_crossing: float | None
    ) -> np.ndarray:
        """Choose the action of this step.

        Args:
            observation: The environment's observation.
            info: The step's facts. A policy that is to be compared with others reads the ego's own
                ``time_s`` and ``speed_mps`` from it and nothing else.
            p_crossing: The detector's probability in [0, 1]; None while it has none yet.

        Returns:
            (1,) float32 in [-1, 1]: -1 the strongest braking, 0 hold the speed.
        """
        ...
