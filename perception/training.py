"""Train a network on frame folders and write a checkpoint: same settings, same data, same weights."""

from __future__ import annotations

import hashlib
import json
import time
import warnings
from importlib.metadata import version
from pathlib import Path
from typing import Any, get_args

import numpy as np
import torch
from rich.console import Console
from torch import nn

from pedcross_env.errors import ConfigError, DataError, PedcrossError
from perception.checkpoint import CheckpointConfig, read_config, save_checkpoint
from perception.data import ClipDataset, FrameFolder, fingerprint, split_by_video
from perception.data.windows import Part
from perception.models.spiking import firing_rates, fresh_state
from perception.preprocess import Preprocess
from perception.recipes import RECIPES, Recipe, augment, learning_rate, make_optimizer
from perception.registry import create_network
from perception.run_state import RunState, load_best, load_run, peek, save_run
from perception.scores import best_f1_threshold, braking_threshold, score
from perception.streaming import clip_tensor
from perception.train_config import TrainConfig, TrainResult

__all__ = ["MIN_FIRING_RATE", "TrainConfig", "TrainResult", "train"]

MIN_FIRING_RATE = 0.001


def train(config: TrainConfig, *, command: str = "", console: Console | None = None) -> TrainResult:
    """Train, or continue, or do nothing where ``config.out`` holds this very run finished.

    Random draws come from ``config.seed`` alone; torch's generator is left as it was.

    Args:
        config: All settings.
        command: Stored in the checkpoint, for who wants to repeat it.
        console: Where progress goes; None: a console of its own. ``Console(quiet=True)`` for silence.

    Raises:
        DataError: For unreadable data, or where a part of the split has one class only.
        ConfigError: Where ``out`` holds a run of other settings or data.
        PedcrossError: Where the loss is not finite, or a spiking network falls silent.
    """
    console = console or Console()
    folders = [FrameFolder.open(config.data, subset, config.modality) for subset in config.subsets]
    print_of_data = fingerprint(folders)
    identity = hashlib.sha256(
        json.dumps([config.settings(), print_of_data], sort_keys=True).encode()
    ).hexdigest()
    run = config.out / "run"
    state = peek(run) or RunState(identity=identity)
    if state.identity != identity:
        raise ConfigError(
            f"{str(config.out)!r} holds a run with other settings or data; choose another out folder or"
            " delete it."
        )
    if state.finished and not _may_go_on(config, state):
        stored = read_config(config.out)
        console.print(f"{config.out}: finished before ({state.stop_reason}), nothing to do")
        return TrainResult(
            checkpoint=config.out, metrics=stored.metrics, threshold=stored.threshold,
            history=tuple(state.history), skipped=True, stop_reason=state.stop_reason,
        )  # fmt: skip
    state.finished, state.stop_reason = False, ""
    trainer = _Trainer(config, folders, state, console)
    trainer.fit(run)
    return trainer.finish(run, print_of_data, command)


def _may_go_on(config: TrainConfig, state: RunState) -> bool:
    limit = float("inf") if config.max_minutes is None else config.max_minutes * 60
    return state.stop_reason == "max_minutes" and state.elapsed_s < limit


class _Trainer:
    """One run, from its start or from where it was stopped."""

    def __init__(
        self, config: TrainConfig, folders: list[FrameFolder], state: RunState, console: Console
    ) -> None:
        self.config, self.state, self.console = config, state, console
        self.recipe: Recipe = RECIPES[config.recipe]
        self.epochs = config.epochs or self.recipe.epochs
        self.preprocess = config.preprocess()
        self.parts = _load_parts(config, folders, self.preprocess, console)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(config.seed)
            self.network: nn.Module = create_network(
                config.model, in_channels=self.preprocess.channels, frames=config.frames, width=config.width
            )
        self.optimizer = make_optimizer(self.network, self.recipe)
        labels = self.parts["train"].labels
        self.loss = nn.BCEWithLogitsLoss(pos_weight=torch.tensor(float((labels == 0).sum() / labels.sum())))

    def fit(self, run: Path) -> None:
        """Run epochs until the recipe, the patience or the clock ends them."""
        state = self.state
        if state.epoch:
            load_run(run, state, self.network, self.optimizer)
            self.console.print(f"continuing after epoch {state.epoch}")
        while not (reason := self._stop_reason()):
            started = time.monotonic()
            record = self._train_epoch(state.epoch) | self._validate(state.epoch)
            state.epoch += 1
            self._note_best(record)
            record |= {"epoch": state.epoch, "seconds": time.monotonic() - started}
            state.elapsed_s += record["seconds"]
            state.history.append(record)
            save_run(run, state, self.network, self.optimizer)
            self._report(record, run)
        state.stop_reason = reason

    def _stop_reason(self) -> str:
        if self.state.epoch >= self.epochs:
            return "epochs"
        if self.state.stale >= self.recipe.patience:
            return "patience"
        limit = self.config.max_minutes
        return (
            "max_minutes"
            if limit is not None and self.state.epoch and self.state.elapsed_s >= limit * 60
            else ""
        )

    def _forward(self, clips: np.ndarray) -> torch.Tensor:
        with torch.autocast("cpu", torch.bfloat16, enabled=self.config.precision == "bf16"):
            return self.network(clip_tensor(clips, self.preprocess)).float()

    def _train_epoch(self, epoch: int) -> dict[str, Any]:
        data, size = self.parts["train"], self.config.batch_size
        # A generator per epoch: a run that was cut off draws what the uninterrupted one does.
        rng = np.random.default_rng([self.config.seed, epoch])
        order = rng.permutation(len(data))
        batches = [order[i : i + size] for i in range(0, len(order), size)]
        if len(batches) > 1 and len(batches[-1]) == 1:
            batches.pop()  # batch norm has no statistics of one clip
        self.network.train()
        losses = []
        for i, batch in enumerate(batches):
            for group in self.optimizer.param_groups:
                group["lr"] = learning_rate(self.recipe, epoch * len(batches) + i, self.epochs * len(batches))
            clips = data.clips(batch)
            if self.recipe.augment:
                clips = augment(clips, rng)
            with fresh_state(self.network):
                loss = self.loss(
                    self._forward(clips), torch.from_numpy(data.labels[batch].astype(np.float32))
                )
                self.optimizer.zero_grad(set_to_none=True)
                loss.backward()
            self.optimizer.step()
            losses.append(float(loss.detach()))
        mean = float(np.mean(losses))
        if not np.isfinite(mean):
            raise PedcrossError(
                f"epoch {epoch + 1}: the training loss is {mean}; try precision='fp32' or another seed."
            )
        return {"train_loss": mean}

    @torch.no_grad()
    def _logits(self, part: Part) -> torch.Tensor:
        self.network.eval()
        data, size = self.parts[part], max(self.config.batch_size, 32)
        logits = []
        for i in range(0, len(data), size):
            with fresh_state(self.network):
                logits.append(self._forward(data.clips(np.arange(i, min(i + size, len(data))))))
        return torch.cat(logits)

    def _validate(self, epoch: int) -> dict[str, Any]:
        logits, labels = self._logits("validation"), self.parts["validation"].labels
        probabilities = torch.sigmoid(logits.double()).numpy()
        return {
            "validation_loss": float(self.loss(logits, torch.from_numpy(labels.astype(np.float32)))),
            "validation_auroc": score(labels, probabilities, 0.5, "v")["v_auroc"],
            **self._check_firing(epoch),
        }

    def _check_firing(self, epoch: int) -> dict[str, Any]:
        data = self.parts["validation"]
        chosen = np.linspace(0, len(data) - 1, min(16, len(data))).astype(int)
        rates = firing_rates(self.network, clip_tensor(data.clips(chosen), self.preprocess))
        if not rates:
            return {}
        mean = float(np.mean(list(rates.values())))
        if mean < MIN_FIRING_RATE:
            raise PedcrossError(
                f"epoch {epoch + 1}: the network fires {mean:.2%} of the time, below {MIN_FIRING_RATE:.1%}:"
                " it says nothing about its input. Use event frames or counts, a larger width, or another"
                " recipe."
            )
        silent = [name for name, rate in rates.items() if rate < MIN_FIRING_RATE]
        if silent and epoch == 0:
            warnings.warn(
                f"{len(silent)} of {len(rates)} layers fire below {MIN_FIRING_RATE:.1%}: {', '.join(silent)}",
                stacklevel=2,
            )
        return {"mean_firing_rate": mean, "firing_rates": rates}

    def _note_best(self, record: dict[str, Any]) -> None:
        state, recipe = self.state, self.recipe
        value = -record["validation_loss"] if recipe.watch == "loss" else record["validation_auroc"]
        if state.best_epoch == 0 or value > state.best_value + recipe.min_delta:
            state.best_epoch, state.best_value, state.stale = state.epoch, value, 0
        else:
            state.stale += 1

    def _report(self, record: dict[str, Any], run: Path) -> None:
        firing = f"  firing {record['mean_firing_rate']:.1%}" if "mean_firing_rate" in record else ""
        self.console.print(
            f"epoch {record['epoch']:3d}/{self.epochs}  loss {record['train_loss']:.4f}  validation"
            f" {record['validation_loss']:.4f}  AUROC {record['validation_auroc']:.4f}{firing} "
            f" {record['seconds']:.1f} s" + ("  *" if self.state.best_epoch == record["epoch"] else "")
        )
        if self.config.tensorboard:
            from torch.utils.tensorboard import SummaryWriter

            with SummaryWriter(str(run / "tensorboard")) as writer:
                for key, value in record.items():
                    if isinstance(value, float):
                        writer.add_scalar(key, value, record["epoch"])

    def finish(self, run: Path, print_of_data: str, command: str) -> TrainResult:
        """Score the best epoch's weights, write the checkpoint, mark the run as finished."""
        config, state = self.config, self.state
        load_best(run, state, self.network)
        parts: tuple[Part, ...] = ("validation", "test")
        p = {part: torch.sigmoid(self._logits(part).double()).numpy() for part in parts}
        threshold = best_f1_threshold(self.parts["validation"].labels, p["validation"])
        braking = min(braking_threshold(self.parts["validation"].labels, p["validation"]), 1.0)
        metrics: dict[str, Any] = {"best_epoch": state.best_epoch, "epochs": state.epoch}
        for part in parts:
            metrics |= score(self.parts[part].labels, p[part], threshold, part)
        stored = CheckpointConfig(
            name=config.name or f"{config.model}-{config.modality}",
            model=config.model, modality=config.modality,
            frames=config.frames, width=config.width, preprocess=self.preprocess, threshold=threshold,
            braking_threshold=braking,
            fingerprint=print_of_data, recipe=config.recipe, seed=config.seed, command=command,
            training=config.settings() | {"stop_reason": state.stop_reason},
            splits={part: list(data.video_names) for part, data in self.parts.items()}, metrics=metrics,
            versions={name: version(name) for name in ("torch", "spikingjelly", "numpy")},
        )  # fmt: skip
        save_checkpoint(config.out, self.network, stored)
        state.finished = True
        save_run(run, state, self.network, self.optimizer, write_tensors=False)
        self.console.print(
            f"{config.out}: test AUROC {metrics['test_auroc']:.4f}, F1 {metrics['test_f1']:.4f} at threshold "
            f"{threshold:.3f} ({metrics['test_positives']} of {metrics['test_clips']} clips positive)"
        )
        return TrainResult(
            checkpoint=config.out, metrics=metrics, threshold=threshold,
            history=tuple(state.history), skipped=False, stop_reason=state.stop_reason,
        )  # fmt: skip


def _load_parts(
    config: TrainConfig, folders: list[FrameFolder], preprocess: Preprocess, console: Console
) -> dict[Part, ClipDataset]:
    videos = [video for folder in folders for video in folder.videos]
    split = split_by_video(videos, seed=config.split_seed, stratify=config.stratify)
    parts: dict[Part, ClipDataset] = {}
    for part in get_args(Part):
        stride = (config.test_stride or config.frames) if part == "test" else config.train_stride
        data = ClipDataset.from_videos(
            split[part], preprocess, frames=config.frames, overlap=config.frames - stride,
            cache_dir=config.cache, on_error=config.on_error,
        )  # fmt: skip
        positives = int(data.labels.sum())
        console.print(
            f"{part}: {len(data.video_names)} videos, {len(data)} clips, {positives} positive; "
            f"{len(data.too_short)} videos too short, {len(data.errors)} images left out"
        )
        if not 0 < positives < len(data):
            raise DataError(
                f"the {part} part has {positives} positive of {len(data)} clips ({len(data.video_names)}"
                " videos): both classes are needed. Record more videos, set stratify=True, or choose another"
                " split_seed."
            )
        parts[part] = data
    skipped, empty = sum(len(f.skipped) for f in folders), sum(len(f.empty) for f in folders)
    if skipped or empty:
        console.print(f"left out: {skipped} files that are no images, {empty} empty folders")
    return parts
