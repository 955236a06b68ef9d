"""A detector on disk: a folder with ``model.safetensors`` and ``config.json``; never pickle."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import safetensors
import torch
from safetensors.torch import load_file, save
from torch import nn

from pedcross_env.contracts import MODALITIES, Modality
from pedcross_env.errors import ConfigError, DataError, nearest
from perception.preprocess import Preprocess
from perception.registry import create_network
from perception.streaming import NetworkDetector

__all__ = [
    "FORMAT_VERSION", "CheckpointConfig", "list_shipped", "load_detector", "load_network", "read_config",
    "save_checkpoint",
]  # fmt: skip

FORMAT_VERSION = 1
_WEIGHTS, _CONFIG = "model.safetensors", "config.json"


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckpointConfig:
    """Everything about a trained detector besides its weights.

    Attributes:
        name: Of the detector, e.g. "sps_r18t-dvs".
        model: A name in ``perception.registry``.
        modality, task, frames, width, preprocess: What it reads and how; task is "detection".
        threshold: p(crossing) of the best F1 on the validation clips: what F-scores use.
        braking_threshold: p(crossing) with at most 1 % false alarms on them: what brakes use; 1 at most.
        fingerprint: Hash of the training data, ``perception.data.fingerprint``.
        recipe, seed, command: How it was trained.
        training: All other training settings.
        splits: Part to "<subset>/<video>" names, so a test never reuses a training video.
        metrics: E.g. "test_auroc"; None where undefined.
        versions: Of the libraries.
        format_version: Of this file.
    """

    name: str
    model: str
    modality: Modality
    frames: int
    width: float
    preprocess: Preprocess
    threshold: float
    braking_threshold: float
    task: str = "detection"
    fingerprint: str = ""
    recipe: str = ""
    seed: int = 0
    command: str = ""
    training: dict[str, Any] = field(default_factory=dict)
    splits: dict[str, Any] = field(default_factory=dict)
    metrics: dict[str, Any] = field(default_factory=dict)
    versions: dict[str, Any] = field(default_factory=dict)
    format_version: int = FORMAT_VERSION

    def __post_init__(self) -> None:
        if self.format_version != FORMAT_VERSION:
            raise ConfigError(
                f"format_version = {self.format_version!r}: this version reads {FORMAT_VERSION} only."
            )
        if self.modality not in MODALITIES or self.modality != self.preprocess.modality:
            raise ConfigError(
                f"modality = {self.modality!r} but the preprocessing is for {self.preprocess.modality!r}."
            )
        if self.frames < 1:
            raise ConfigError(f"frames = {self.frames!r} is not allowed: it must be 1 or more.")
        for name in ("threshold", "braking_threshold"):
            if not 0 <= getattr(self, name) <= 1:
                raise ConfigError(f"{name} = {getattr(self, name)!r} is not allowed: it must be 0 to 1.")


def _plain(value: Any) -> Any:
    """Make ``value`` legal JSON: undefined numbers become null."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _strict(cls: type, values: Any, where: Path) -> Any:
    """Build a dataclass from JSON values, refusing unknown, missing and mistyped keys."""
    if not isinstance(values, dict):
        raise DataError(f"{where}: expected an object for {cls.__name__}, found {type(values).__name__}.")
    hints = typing.get_type_hints(cls)
    fields = {f.name: f for f in dataclasses.fields(cls)}
    for key in values:
        if key not in fields:
            match = nearest(key, fields)
            raise DataError(f"{where}: unknown key {key!r}." + (f" Did you mean {match!r}?" if match else ""))
    required = [n for n, f in fields.items() if f.default is f.default_factory is dataclasses.MISSING]
    lacking = [name for name in required if name not in values]
    if lacking:
        raise DataError(f"{where}: lacks {', '.join(lacking)}.")
    arguments = {}
    for key, value in values.items():
        kinds: dict[Any, Any] = {int: int, float: (int, float), str: str}
        plain = kinds.get(hints[key])
        if plain is not None and (not isinstance(value, plain) or isinstance(value, bool)):
            raise DataError(f"{where}: {key} = {value!r} is not allowed: it must be {hints[key].__name__}.")
        nested = hints[key] is Preprocess
        arguments[key] = _strict(Preprocess, value, where) if nested else _tuple_of(value)
    try:
        return cls(**arguments)
    except (ConfigError, TypeError) as error:
        raise DataError(f"{where}: {error}") from error


def _tuple_of(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _replace(path: Path, data: bytes) -> None:
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    partial.write_bytes(data)
    partial.replace(path)


def save_checkpoint(path: str | Path, network: nn.Module, config: CheckpointConfig) -> Path:
    """Write a checkpoint folder; an interrupted write leaves the old files or none."""
    folder = Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    values = {f.name: getattr(config, f.name) for f in dataclasses.fields(config)}
    values["preprocess"] = config.preprocess.to_dict()
    tensors = {name: tensor.detach().contiguous() for name, tensor in network.state_dict().items()}
    _replace(folder / _WEIGHTS, save(tensors))
    text = json.dumps(_plain(values), indent=1, allow_nan=False)
    _replace(folder / _CONFIG, (text + "\n").encode())
    return folder


def list_shipped() -> dict[str, Path]:
    """Return the checkpoints that come with this package, by name."""
    root = Path(__file__).parent / "checkpoints"
    return {p.parent.name: p.parent for p in sorted(root.glob(f"*/{_CONFIG}"))}


def _folder(path: str | Path) -> Path:
    folder = Path(path)
    if folder.is_dir():
        return folder
    shipped = list_shipped()
    if str(path) in shipped:
        return shipped[str(path)]
    match = nearest(str(path), shipped)
    raise DataError(
        f"no checkpoint {str(path)!r}: neither a folder nor one that is shipped"
        f" ({', '.join(shipped) or 'none'})." + (f" Did you mean {match!r}?" if match else "")
    )


def read_config(path: str | Path) -> CheckpointConfig:
    """Read the config of a checkpoint folder or of a shipped name.

    Raises:
        DataError: Where it is missing, no JSON, or holds unknown, missing or mistyped keys.
    """
    file = _folder(path) / _CONFIG
    try:
        values = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(f"{file}: missing; a checkpoint holds {_WEIGHTS} and {_CONFIG}.") from error
    except ValueError as error:
        raise DataError(f"{file}: truncated or no JSON ({error}).") from error
    return _strict(CheckpointConfig, values, file)


def load_network(path: str | Path) -> tuple[nn.Module, CheckpointConfig]:
    """Build the network of a checkpoint and load its weights.

    Raises:
        DataError: Where a file is missing or damaged, or the weights do not fit the config.
    """
    config = read_config(path)
    file = _folder(path) / _WEIGHTS
    try:
        with torch.random.fork_rng(devices=[]):
            network = create_network(
                config.model, in_channels=config.preprocess.channels, frames=config.frames, width=config.width
            )
    except ConfigError as error:
        raise DataError(f"{file.with_name(_CONFIG)}: {error}") from error
    if not file.is_file():
        raise DataError(f"{file}: missing; a checkpoint holds {_WEIGHTS} and {_CONFIG}.")
    try:
        tensors = load_file(file)
    except (safetensors.SafetensorError, OSError) as error:
        raise DataError(f"{file}: truncated or no safetensors file ({error}).") from error
    try:
        network.load_state_dict(tensors)
    except RuntimeError as error:
        raise DataError(
            f"{file}: does not fit {config.model} as its config.json describes it: {error}"
        ) from error
    if not all(bool(torch.isfinite(t).all()) for t in tensors.values()):
        raise DataError(f"{file}: holds weights that are not finite; train again.")
    return network, config


def load_detector(
    path: str | Path, *, expect_modality: Modality | None = None, expect_frames: int | None = None
) -> NetworkDetector:
    """Load a detector.

    Args:
        path: A checkpoint folder, or the name of one that is shipped.
        expect_modality, expect_frames: Refuse another modality or T.

    Raises:
        DataError: As ``load_network``, or where an expectation fails.
    """
    network, config = load_network(path)
    if expect_modality is not None and config.modality != expect_modality:
        raise DataError(
            f"{config.name} ({path}) reads {config.modality!r}, but {expect_modality!r} is given."
        )
    if expect_frames is not None and config.frames != expect_frames:
        raise DataError(
            f"{config.name} ({path}) takes {config.frames} frames, but clips have {expect_frames}."
        )
    return NetworkDetector(
        network, config.preprocess, name=config.name, frames=config.frames, threshold=config.threshold
    )
