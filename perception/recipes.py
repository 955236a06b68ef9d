"""How networks are trained: the paper's recipe, and compact ones for few cores and little data."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import torch
from torch import nn

__all__ = ["RECIPES", "Recipe", "augment", "learning_rate", "make_optimizer"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """Optimiser, schedule and early stopping; the loss is BCE weighted by negatives / positives in all."""

    rate: float
    weight_decay: float
    decay_all: bool  # also biases, norms, tau and TEBN's scale
    one_cycle: bool
    watch: Literal["loss", "auroc"]
    patience: int
    min_delta: float
    augment: bool
    epochs: int


_COMPACT = Recipe(
    rate=2e-3, weight_decay=0.01, decay_all=False, one_cycle=True, watch="auroc", patience=6,
    min_delta=0.0, augment=True, epochs=15,
)  # fmt: skip

RECIPES: dict[str, Recipe] = {
    "paper": Recipe(
        rate=1e-3, weight_decay=0.1, decay_all=True, one_cycle=False, watch="loss", patience=8,
        min_delta=1e-3, augment=False, epochs=100,
    ),
    "compact": _COMPACT,
    # The surrogate's gradient is small wherever a membrane is far from its threshold.
    "compact-spiking": dataclasses.replace(_COMPACT, rate=4e-3),
}  # fmt: skip


def make_optimizer(network: nn.Module, recipe: Recipe) -> torch.optim.AdamW:
    """Return AdamW; without ``decay_all`` only weights of two or more dimensions decay."""
    parameters = list(network.parameters())
    decayed = [p for p in parameters if recipe.decay_all or p.dim() >= 2]
    plain = [p for p in parameters if not recipe.decay_all and p.dim() < 2]
    groups = [{"params": decayed, "weight_decay": recipe.weight_decay}]
    if plain:
        groups.append({"params": plain, "weight_decay": 0.0})
    return torch.optim.AdamW(groups, lr=recipe.rate)


def learning_rate(recipe: Recipe, step: int, steps: int) -> float:
    """Return the rate of step 0..steps-1: constant, or one cycle (cosine over 30 % up, then down)."""
    if not recipe.one_cycle:
        return recipe.rate
    peak = max(0.3 * steps, 1.0)
    if step < peak:
        return _cosine(recipe.rate / 25, recipe.rate, step / peak)
    return _cosine(recipe.rate, recipe.rate / 1e4, (step - peak) / max(steps - peak, 1.0))


def _cosine(start: float, end: float, share: float) -> float:
    return end + (start - end) * (1 + math.cos(math.pi * share)) / 2


def _translate(clip: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    height, width = clip.shape[1:3]
    dy, dx = rng.integers(-height // 12, height // 12 + 1), rng.integers(-width // 12, width // 12 + 1)
    moved = np.zeros_like(clip)
    moved[:, max(dy, 0) : height + min(dy, 0), max(dx, 0) : width + min(dx, 0)] = clip[
        :, max(-dy, 0) : height + min(-dy, 0), max(-dx, 0) : width + min(-dx, 0)
    ]
    return moved


def _cutout(clip: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    height, width = clip.shape[1:3]
    h, w = int(rng.integers(1, height // 5 + 2)), int(rng.integers(1, width // 5 + 2))
    y, x = int(rng.integers(0, height - h + 1)), int(rng.integers(0, width - w + 1))
    cut = clip.copy()
    cut[:, y : y + h, x : x + w] = 0
    return cut


_TRANSFORMS: tuple[Callable[[np.ndarray, np.random.Generator], np.ndarray] | None, ...] = (
    None,
    _translate,
    _cutout,
)


def augment(clips: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Flip half of the clips left-right, then move, cut or leave each; the same for all its frames.

    Time is never reversed: a pedestrian walking backwards would be a new class.

    Args:
        clips: (B, T, h, w, C) uint8; not changed.
        rng: Source of all draws.
    """
    out = np.empty_like(clips)
    for i, clip in enumerate(clips):
        flipped = clip[:, :, ::-1] if rng.random() < 0.5 else clip
        transform = _TRANSFORMS[rng.integers(len(_TRANSFORMS))]
        out[i] = flipped if transform is None else transform(flipped, rng)
    return out
