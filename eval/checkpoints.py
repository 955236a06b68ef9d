"""Make the shipped networks: record training data, train each network on it, keep what the demo needs.

Every stage resumes: recorded videos stay, a training goes on from its last epoch, a finished one is skipped.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from eval.cameras import COMPACT_CAMERA
from pedcross_env.contracts import MODALITIES, Modality
from pedcross_env.recorder import GenerateConfig, generate
from perception.training import TrainConfig, TrainResult, train

__all__ = ["COMPACT_CAMERA", "DATA_SEED", "CheckpointsConfig", "make_checkpoints"]

DATA_SEED = 500_000
"""Of the training data: the seeds of the demo's data and episodes begin at 0 and stay far below."""


EPOCHS = {"stacked_resnet18": 8, "pt_resnet18": 5, "sps_r18t": 6}
"""Epochs, not minutes, so that a slower machine makes the same networks."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckpointsConfig:
    """Settings of ``pedcross checkpoints``; the defaults made the shipped networks."""

    out: Path = Path("out/checkpoints")
    """Where data and runs lie."""
    install: Path | None = None
    """Folder that receives the finished checkpoints; None: that of the installed package."""
    models: tuple[str, ...] = tuple(EPOCHS)
    modalities: tuple[Modality, ...] = MODALITIES
    videos: int = 80
    """Per subset."""
    width: float = 0.125
    """Of the networks: 8 to 64 channels instead of 64 to 512, 0.7 MB each."""
    train_stride: int = 6
    """Frames between training windows; the paper's 1 would take six times as long."""
    seed: int = 0


def make_checkpoints(config: CheckpointsConfig, console: Console) -> list[TrainResult]:
    """Record, train, install; returns one result per network, in the order trained.

    Raises:
        ConfigError: If ``config.out`` cannot be written or holds data with other settings.
        DataError: If the data has too few videos of either class.
    """
    from eval.progress import bar

    data = config.out / "data"
    with bar("recording training videos", console) as progress:
        generate(
            GenerateConfig(out=data, videos=config.videos, seed=DATA_SEED, camera=COMPACT_CAMERA), progress
        )
    install = config.install or Path(__file__).resolve().parents[1] / "perception" / "checkpoints"
    results = []
    for model in config.models:
        for modality in config.modalities:
            name = f"{model}-{modality}"
            console.rule(name)
            result = train(
                TrainConfig(
                    data=data,
                    out=config.out / name,
                    subsets=("default", "weather"),
                    model=model,
                    modality=modality,
                    width=config.width,
                    seed=config.seed,
                    epochs=EPOCHS.get(model),
                    train_stride=config.train_stride,
                    cache=config.out / "cache",
                ),
                command="make checkpoints",
                console=console,
            )
            target = install / name
            target.mkdir(parents=True, exist_ok=True)
            for file in ("model.safetensors", "config.json"):
                shutil.copyfile(result.checkpoint / file, target / file)
            results.append(result)
    return results
