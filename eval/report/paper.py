"""The paper's printed numbers, for orientation beside ours: other data, other sizes, other training.

Sakhai et al., tables "clip classification" (AUROC, F-score in per cent) and "energy usage" (mJ per clip).
Our subset "default" stands beside their normal weather, "weather" beside their bad weather.
"""

from __future__ import annotations

__all__ = ["PAPER_ENERGY_MJ", "PAPER_SCORES", "paper_energy", "paper_score"]

Score = tuple[float, float]

PAPER_SCORES: dict[tuple[str, int, str, str], Score] = {
    ("pt_resnet18", 9, "weather", "dvs"): (0.9882, 93.05),
    ("pt_resnet18", 9, "weather", "rgb"): (0.9194, 58.02),
    ("pt_resnet18", 9, "default", "dvs"): (0.9685, 83.83),
    ("pt_resnet18", 9, "default", "rgb"): (0.9516, 76.95),
    ("slow_r50", 9, "weather", "dvs"): (0.7446, 42.17),
    ("slow_r50", 9, "weather", "rgb"): (0.5126, 20.01),
    ("slow_r50", 9, "default", "dvs"): (0.9487, 72.61),
    ("slow_r50", 9, "default", "rgb"): (0.9932, 92.81),
    ("sps_r18t", 9, "weather", "dvs"): (0.9504, 57.94),
    ("sps_r18t", 9, "weather", "rgb"): (0.6771, 28.11),
    ("sps_r18t", 9, "default", "dvs"): (0.9421, 74.4),
    ("sps_r18t", 9, "default", "rgb"): (0.7995, 49.26),
    ("pt_resnet18", 30, "weather", "dvs"): (0.975, 91.94),
    ("pt_resnet18", 30, "weather", "rgb"): (0.9825, 83.56),
    ("pt_resnet18", 30, "default", "dvs"): (0.9548, 79.87),
    ("pt_resnet18", 30, "default", "rgb"): (0.9616, 80.5),
    ("slow_r50", 30, "weather", "dvs"): (0.9535, 80.31),
    ("slow_r50", 30, "weather", "rgb"): (0.9546, 84.3),
    ("slow_r50", 30, "default", "dvs"): (0.9594, 81.68),
    ("slow_r50", 30, "default", "rgb"): (0.9784, 87.68),
    ("sps_r18t", 30, "weather", "dvs"): (0.9542, 75.5),
    ("sps_r18t", 30, "weather", "rgb"): (0.6811, 45.05),
    ("sps_r18t", 30, "default", "dvs"): (0.9289, 73.43),
    ("sps_r18t", 30, "default", "rgb"): (0.8012, 54.39),
}
"""(model, frames, our subset, modality) to (AUROC, F-score in per cent)."""

PAPER_ENERGY_MJ: dict[tuple[str, int], float] = {
    ("pt_resnet18", 9): 166.33,
    ("slow_r50", 9): 505.73,
    ("sps_r18t", 9): 50.45,
    ("pt_resnet18", 30): 554.42,
    ("slow_r50", 30): 1672.8,
    ("sps_r18t", 30): 32.37,
}
"""(model, frames) to mJ as printed; the spiking rows are divided by the number of frames there."""


def paper_score(model: str, frames: int, subset: str, modality: str) -> Score | None:
    """Return the paper's (AUROC, F-score in per cent) of this network and clip length, or None."""
    return PAPER_SCORES.get((model, frames, subset, modality))


def paper_energy(model: str, frames: int) -> float | None:
    """Return the paper's mJ per clip, None where it has none."""
    return PAPER_ENERGY_MJ.get((model, frames))
