"""Names of networks; listing them imports nothing heavy."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from pedcross_env.errors import ConfigError, unknown_name

if TYPE_CHECKING:
    from torch import nn

__all__ = ["NETWORKS", "create_network", "register_network"]

NETWORKS: dict[str, str] = {
    "pt_resnet18": "perception.models.resnet:pt_resnet18",
    "stacked_resnet18": "perception.models.resnet:stacked_resnet18",
    "sp_r18": "perception.models.spiking:sp_r18",
    "sps_r18": "perception.models.spiking:sps_r18",
    "sps_r18_add": "perception.models.spiking:sps_r18_add",
    "sps_r18t": "perception.models.spiking:sps_r18t",
    "sps_r18t_add": "perception.models.spiking:sps_r18t_add",
}


def register_network(name: str, target: str) -> None:
    """Add a network of your own.

    Args:
        name: A new name.
        target: "module:factory"; the factory takes in_channels, frames and width by keyword and returns a
            module that maps clips (T, N, C, H, W) to logits (N,).

    Raises:
        ConfigError: Where the name is taken or the target is not "module:factory".
    """
    if NETWORKS.get(name, target) != target:
        raise ConfigError(f"network {name!r} is already {NETWORKS[name]!r}; choose another name.")
    if target.count(":") != 1:
        raise ConfigError(f"target = {target!r} is not allowed: it must be 'module:factory'.")
    NETWORKS[name] = target


def create_network(name: str, *, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build a network with random weights from torch's current generator.

    Args:
        name: One of ``NETWORKS``.
        in_channels: Channels of one image.
        frames: T of its clips.
        width: Multiplier on all channel counts, 1.0 as published.

    Raises:
        ConfigError: For an unknown name (names the nearest), or sizes that are not allowed.
    """
    if name not in NETWORKS:
        raise unknown_name("network", name, NETWORKS)
    if frames < 1 or in_channels < 1:
        raise ConfigError(f"frames = {frames!r}, in_channels = {in_channels!r}: both must be 1 or more.")
    module, factory = NETWORKS[name].split(":")
    return getattr(importlib.import_module(module), factory)(
        in_channels=in_channels, frames=frames, width=width
    )
