"""The state of an unfinished training run on disk, so that it continues where it was cut off."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import safetensors
import torch
from safetensors.torch import load_file, save_file
from torch import nn

from pedcross_env.errors import DataError

__all__ = ["RunState", "load_best", "load_run", "peek", "save_run"]

_STATE = "state.json"


@dataclass(slots=True, kw_only=True)
class RunState:
    """Where a run stands.

    Attributes:
        identity: Hash of the settings and the data; another one must not be continued.
        epoch: Epochs done.
        best_epoch, best_value: Of the watched validation metric; epoch 0: none yet.
        stale: Epochs since it improved.
        elapsed_s: Wall-clock time, resumptions included.
        history: One record per epoch.
        finished: The checkpoint is written.
        stop_reason: Why it ended.
    """

    identity: str
    epoch: int = 0
    best_epoch: int = 0
    best_value: float = 0.0
    stale: int = 0
    elapsed_s: float = 0.0
    history: list[dict[str, Any]] = field(default_factory=list)
    finished: bool = False
    stop_reason: str = ""


def peek(folder: Path) -> RunState | None:
    """Read the state of a run, None where there is none.

    Raises:
        DataError: Where the file is damaged.
    """
    file = folder / _STATE
    if not file.exists():
        return None
    try:
        return RunState(**json.loads(file.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise DataError(
            f"{file}: damaged ({error}); delete {str(folder)!r} to train from the start."
        ) from error


def save_run(
    folder: Path,
    state: RunState,
    network: nn.Module,
    optimizer: torch.optim.Optimizer,
    *,
    write_tensors: bool = True,
) -> None:
    """Write tensors first and the state last, so a cut leaves the state of an epoch that is whole."""
    folder.mkdir(parents=True, exist_ok=True)
    if write_tensors:
        tensors = {f"model.{name}": value.contiguous() for name, value in network.state_dict().items()}
        for name, parameter in network.named_parameters():
            for key, value in optimizer.state.get(parameter, {}).items():
                tensors[f"optimizer.{name}|{key}"] = torch.as_tensor(value).contiguous()
        save_file(tensors, folder / f"epoch-{state.epoch}.safetensors")
    partial = folder / f".{_STATE}"
    partial.write_text(json.dumps(dataclasses.asdict(state), indent=1), encoding="utf-8")
    partial.replace(folder / _STATE)
    keep = {f"epoch-{state.epoch}.safetensors", f"epoch-{state.best_epoch}.safetensors"}
    for old in folder.glob("epoch-*.safetensors"):
        if old.name not in keep:
            old.unlink()


def _read(folder: Path, epoch: int) -> dict[str, torch.Tensor]:
    file = folder / f"epoch-{epoch}.safetensors"
    try:
        return load_file(file)
    except (safetensors.SafetensorError, OSError) as error:
        raise DataError(
            f"{file}: missing or damaged; delete {str(folder)!r} to train from the start."
        ) from error


def _model_part(tensors: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    return {name.removeprefix("model."): t for name, t in tensors.items() if name.startswith("model.")}


def load_run(folder: Path, state: RunState, network: nn.Module, optimizer: torch.optim.Optimizer) -> None:
    """Put network and optimiser where the run's last epoch left them."""
    tensors = _read(folder, state.epoch)
    network.load_state_dict(_model_part(tensors))
    parameters = dict(network.named_parameters())
    for name, value in tensors.items():
        if name.startswith("optimizer."):
            parameter, key = name.removeprefix("optimizer.").split("|")
            optimizer.state[parameters[parameter]][key] = value


def load_best(folder: Path, state: RunState, network: nn.Module) -> None:
    """Put the weights of the best epoch into the network."""
    network.load_state_dict(_model_part(_read(folder, state.best_epoch)))
