"""The settings and the result of one training run."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from pedcross_env.contracts import MODALITIES, Modality
from pedcross_env.errors import ConfigError, unknown_name
from perception.preprocess import Preprocess, RgbInput
from perception.recipes import RECIPES
from perception.registry import NETWORKS

__all__ = ["TrainConfig", "TrainResult"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainConfig:
    """All settings of one training run.

    Attributes:
        data: Root of the frame folders.
        out: Folder of the checkpoint; the unfinished run lies in ``out/run``.
        subsets: Read together: those of ``pedcross generate``, or the paper's ("dataset", "dataset_weather").
        view: "compact" or "paper" preprocessing, at width_px x height_px.
        rows: First and last row that a compact network sees, as fractions of the height from the top; None: the
            default of ``Preprocess.compact``. "paper" takes no other than None, it sees the whole image.
        rgb_input: What a compact network sees of rgb, see ``Preprocess``; dvs and "paper" take no other
            than "image".
        train_stride: Frames between windows of training and validation (the paper: 1).
        test_stride: The same for the test; None: no overlap.
        epochs: None: the recipe's.
        max_minutes: Stop after the epoch in which this much time is spent, resumptions included.
        precision: "bf16" computes convolutions in bfloat16 (faster where the CPU has AMX or AVX512-BF16).
        stratify: See ``split_by_video``.
        on_error: "skip" leaves out damaged images and reports them.
        cache: Where small images are kept between runs.
        name: Of the detector; empty: "<model>-<modality>".
    """

    data: Path
    out: Path
    subsets: tuple[str, ...] = ("default", "weather")
    model: str = "sps_r18t"
    modality: Modality = "dvs"
    frames: int = 9
    width: float = 0.25
    width_px: int = 112
    height_px: int = 64
    view: Literal["compact", "paper"] = "compact"
    rows: tuple[float, float] | None = None
    rgb_input: RgbInput = "image"
    train_stride: int = 3
    test_stride: int | None = None
    recipe: str = "compact"
    epochs: int | None = None
    batch_size: int = 16
    seed: int = 0
    split_seed: int = 42
    stratify: bool = False
    max_minutes: float | None = None
    precision: Literal["fp32", "bf16"] = "fp32"
    on_error: Literal["raise", "skip"] = "raise"
    cache: Path | None = None
    tensorboard: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        choices = {
            "model": NETWORKS, "modality": MODALITIES, "recipe": RECIPES, "view": ("compact", "paper"),
            "precision": ("fp32", "bf16"), "on_error": ("raise", "skip"), "rgb_input": get_args(RgbInput),
        }  # fmt: skip
        for name, allowed in choices.items():
            if getattr(self, name) not in allowed:
                raise unknown_name(name, getattr(self, name), allowed)
        if self.rgb_input != "image" and (self.modality, self.view) != ("rgb", "compact"):
            raise ConfigError(
                f"rgb_input = {self.rgb_input!r} is not allowed with modality {self.modality!r} and view"
                f" {self.view!r}: it is for modality 'rgb' and view 'compact'."
            )
        if self.rows is not None and self.view != "compact":
            raise ConfigError(
                f"rows = {self.rows!r} is not allowed with view {self.view!r}: it sees the whole image; leave rows"
                " out."
            )
        if isinstance(self.subsets, str) or not self.subsets or len(set(self.subsets)) < len(self.subsets):
            raise ConfigError(f"subsets = {self.subsets!r} is not allowed: a tuple of different names.")
        for name in ("train_stride", "test_stride"):
            stride = getattr(self, name)
            if stride is not None and not 1 <= stride <= self.frames:
                raise ConfigError(
                    f"{name} = {stride!r} is not allowed: it must be 1 to frames ({self.frames})."
                )
        for name in ("frames", "batch_size", "epochs"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise ConfigError(f"{name} = {value!r} is not allowed: it must be 1 or more.")
        if self.max_minutes is not None and self.max_minutes <= 0:
            raise ConfigError(
                f"max_minutes = {self.max_minutes!r} is not allowed: it must be positive, or None."
            )

    def preprocess(self) -> Preprocess:
        """Return the preprocessing these settings mean."""
        if self.view == "paper":
            return Preprocess.paper(self.modality, self.width_px, self.height_px)
        rows = {} if self.rows is None else {"rows": self.rows}
        return Preprocess.compact(self.modality, self.width_px, self.height_px, self.rgb_input, **rows)

    def settings(self) -> dict[str, Any]:
        """Return what decides the weights, without paths and limits of this machine."""
        values = dataclasses.asdict(self)
        for name in ("data", "out", "cache", "tensorboard", "max_minutes", "name"):
            del values[name]
        return {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainResult:
    """What a run gave.

    Attributes:
        checkpoint: Folder for ``load_detector``.
        metrics: "validation_..." and "test_...": auroc, average_precision, f1, brier, clips, positives.
        threshold: Of the best F1 on the validation clips.
        history: One record per epoch.
        skipped: True where a finished run was found and nothing was done.
        stop_reason: "epochs", "patience" or "max_minutes".
    """

    checkpoint: Path
    metrics: dict[str, Any]
    threshold: float
    history: tuple[dict[str, Any], ...]
    skipped: bool
    stop_reason: str
