"""The one input check of all networks."""

from __future__ import annotations

import torch

from pedcross_env.errors import ConfigError

__all__ = ["check_clips"]


def check_clips(clips: torch.Tensor, frames: int, in_channels: int, network: str) -> None:
    """Refuse clips a network was not built for, before anything can broadcast.

    Args:
        clips: What should be (T, N, C, H, W).
        frames: T the network was built for.
        in_channels: C the network was built for.
        network: Its name, for the message.

    Raises:
        ConfigError: Where the rank, T or C differ.
    """
    shape = tuple(clips.shape)
    if len(shape) != 5:
        raise ConfigError(f"{network} got clips of shape {shape}; it takes (T, N, C, H, W).")
    if shape[0] != frames:
        raise ConfigError(
            f"{network} was built for frames = {frames} but got clips of {shape[0]} frames (shape {shape}, "
            f"(T, N, C, H, W)); cut windows of {frames} frames or train one with frames = {shape[0]}."
        )
    if shape[2] != in_channels:
        raise ConfigError(
            f"{network} was built for {in_channels} input channels but got {shape[2]} (shape {shape}, "
            "(T, N, C, H, W)); use the preprocessing of its checkpoint."
        )
