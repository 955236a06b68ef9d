"""Make the shipped networks: record training data, train each network on it, keep what the demo needs.

Every stage resumes: recorded videos stay, a training goes on from its last epoch, a finished one is skipped.
"""

from __future__ import annotations

import multiprocessing
import os
import shutil
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from eval.cameras import COMPACT_CAMERA
from eval.progress import bar
from pedcross_env.contracts import MODALITIES, Modality
from pedcross_env.recorder import GenerateConfig, generate
from perception.preprocess import RgbInput

if TYPE_CHECKING:
    from perception.training import TrainResult

__all__ = ["DATA_SEED", "CheckpointsConfig", "make_checkpoints"]

DATA_SEED = 500_000
"""Of the training data: the seeds of the demo's data and episodes begin at 0 and stay far below."""


EPOCHS: dict[str, dict[Modality, int]] = {
    "sps_r18t": {"rgb": 9, "dvs": 9},
    "sps_r18t_add": {"rgb": 6, "dvs": 6},
    "pt_resnet18": {"rgb": 5, "dvs": 5},
    "stacked_resnet18": {"rgb": 8, "dvs": 12},
}
"""Epochs, not minutes, so that a slower machine makes the same networks; the longest come first, for the pool.

On events the stacked frames' validation AUROC still rises after eight.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckpointsConfig:
    """Settings of ``pedcross checkpoints``; the defaults made the shipped networks."""

    out: Path = Path("out/checkpoints")
    """Where data and runs lie."""
    install: Path | None = None
    """Folder that receives the finished checkpoints; None: that of the installed package."""
    models: tuple[str, ...] = tuple(EPOCHS)
    modalities: tuple[Modality, ...] = MODALITIES
    videos: int = 70
    """Per subset; these networks are short of scenes, not of epochs."""
    width: float = 0.125
    """Of the networks: 8 to 64 channels instead of 64 to 512, 0.7 MB each."""
    train_stride: int = 6
    """Frames between training windows; the paper's 1 would take six times as long."""
    rgb_input: RgbInput = "changes"
    """Of the networks that read rgb: from images this few they learn the scenes and stay near chance on others."""
    seed: int = 0
    workers: int = 0
    """Processes; 0: one per core."""


def make_checkpoints(config: CheckpointsConfig, console: Console) -> list[TrainResult]:
    """Record, train, install; returns one result per network.

    Networks as small as these gain nothing from a second thread, so each is trained by a process of its own.

    Raises:
        ConfigError: If ``config.out`` cannot be written or holds data with other settings.
        DataError: If the data has too few videos of either class.
    """
    data = config.out / "data"
    with bar("recording training videos", console) as progress:
        generate(
            GenerateConfig(out=data, videos=config.videos, seed=DATA_SEED, camera=COMPACT_CAMERA), progress
        )
    runs = [(model, modality) for model in config.models for modality in config.modalities]
    workers = min(config.workers or os.cpu_count() or 1, len(runs))
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        results = list(pool.map(_train_one, [config] * len(runs), *zip(*runs, strict=True)))
    install = config.install or Path(__file__).resolve().parents[1] / "perception" / "checkpoints"
    for result in results:
        target = install / result.checkpoint.name
        target.mkdir(parents=True, exist_ok=True)
        for file in ("model.safetensors", "config.json"):
            shutil.copyfile(result.checkpoint / file, target / file)
    return results


def _train_one(config: CheckpointsConfig, model: str, modality: Modality) -> TrainResult:
    import torch

    from perception.training import TrainConfig, train

    torch.set_num_threads(1)
    name = f"{model}-{modality}"
    settings = TrainConfig(
        data=config.out / "data",
        out=config.out / name,
        subsets=("default", "weather"),
        model=model,
        modality=modality,
        width=config.width,
        seed=config.seed,
        recipe="compact-spiking" if model.startswith("sp") else "compact",
        rgb_input=config.rgb_input if modality == "rgb" else "image",
        epochs=EPOCHS.get(model, {}).get(modality),
        train_stride=config.train_stride,
        cache=config.out / "cache",
    )
    return train(settings, command="make checkpoints", console=_LabelledConsole(name))


class _LabelledConsole(Console):
    """A console whose lines say which network they are about."""

    def __init__(self, label: str) -> None:
        super().__init__(width=150)
        self._label = label

    def print(self, *objects: Any, **options: Any) -> None:
        super().print(f"{self._label:22s}", *objects, **options)
