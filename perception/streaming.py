"""A network as a detector: a ring of the last T preprocessed frames."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

import numpy as np
import torch
from torch import nn

from pedcross_env.contracts import Modality
from pedcross_env.errors import ConfigError
from perception.models.resnet import PseudoTemporalResNet18
from perception.models.spiking import fresh_state
from perception.preprocess import Preprocess

__all__ = ["NetworkDetector", "clip_tensor"]


def clip_tensor(small: np.ndarray, preprocess: Preprocess) -> torch.Tensor:
    """Map clips (N, T, h, w, C) uint8 from ``Preprocess.shrink`` to a network's (T, N, C, h, w) float32."""
    return torch.from_numpy(preprocess.normalise(np.ascontiguousarray(small.swapaxes(0, 1))))


class NetworkDetector:
    """Implements ``perception.detector.Detector`` over any network of ``perception.registry``.

    Every update runs the whole window from a fresh state, so streaming equals ``predict`` on the same
    frames; the pseudo-temporal network's logits are kept per frame, which is the same with less work where a
    frame's planes are its own.

    Args:
        network: Maps (T, N, C, h, w) to logits (N,); set to evaluation mode here.
        preprocess: As in training.
        name: For tables.
        frames: T.
        threshold: p(crossing) from which on a clip counts as positive; chosen on validation data.
        batch_size: Clips that ``predict`` runs at once.
    """

    def __init__(
        self, network: nn.Module, preprocess: Preprocess, *, name: str, frames: int, threshold: float = 0.5,
        batch_size: int = 16,
    ) -> None:  # fmt: skip
        self.network = network.eval()
        self.preprocess = preprocess
        self.name = name
        self.modality: Modality = preprocess.modality
        self.frames = frames
        self.threshold = threshold
        self.batch_size = batch_size
        self._window: deque[np.ndarray] = deque(maxlen=frames)
        self._logits: deque[float] = deque(maxlen=frames)

    def reset(self) -> None:
        """Forget the window."""
        self._window.clear()
        self._logits.clear()

    @torch.inference_mode()
    def update(self, observation: Mapping[str, np.ndarray]) -> float:
        """Take the next observation and return p(crossing); see ``Detector.update``.

        Raises:
            ConfigError: Where the observation lacks the modality, or its image has another shape.
        """
        small = self.preprocess.of_observation(observation)
        if isinstance(self.network, PseudoTemporalResNet18) and not self.preprocess.sees_changes:
            image = clip_tensor(small[None, None], self.preprocess)[0]
            logit = float(self.network.frame_logits(image))
            self._logits.extend([logit] * (1 if self._logits else self.frames))
            return _sigmoid(sum(self._logits) / self.frames)
        self._window.extend([small] * (1 if self._window else self.frames))
        return float(self._probabilities(np.stack(self._window)[None])[0])

    @torch.inference_mode()
    def predict(self, clips: np.ndarray) -> np.ndarray:
        """Map clips (N, T, H, W, C) uint8 to p(crossing) (N,) float64; see ``Detector.predict``.

        Raises:
            ConfigError: Where the clips have another T or shape.
        """
        if clips.ndim != 5 or clips.shape[1] != self.frames:
            raise ConfigError(
                f"{self.name} takes clips (N, {self.frames}, H, W, C), got shape {clips.shape}; "
                f"cut windows of {self.frames} frames."
            )
        parts = [np.zeros(0)]
        for start in range(0, len(clips), self.batch_size):
            batch = clips[start : start + self.batch_size]
            small = np.stack([[self.preprocess.shrink(image) for image in clip] for clip in batch])
            parts.append(self._probabilities(small))
        return np.concatenate(parts)

    def _probabilities(self, small: np.ndarray) -> np.ndarray:
        with fresh_state(self.network):
            logits = self.network(clip_tensor(small, self.preprocess))
        return torch.sigmoid(logits.double()).numpy()


def _sigmoid(logit: float) -> float:
    return 1 / (1 + math.exp(-logit)) if logit >= 0 else math.exp(logit) / (1 + math.exp(logit))
