"""Spiking ResNet18s of the paper: plain (SP), spike-element-wise (SPS) and with TEBN (SPS...T).

SEW: Fang et al., NeurIPS 2021; TEBN: Duan et al., NeurIPS 2022. Tensors are (T, N, C, H, W).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Literal

import torch
from spikingjelly.activation_based import functional, layer, neuron
from torch import nn

from pedcross_env.errors import ConfigError, unknown_name
from perception.models.plif import PLIF
from perception.models.resnet import stem_width
from perception.models.shape import check_clips

__all__ = [
    "Connect", "SpikingResNet18", "TemporalBatchNorm", "firing_rates", "fresh_state", "sp_r18", "sps_r18",
    "sps_r18_add", "sps_r18t", "sps_r18t_add",
]  # fmt: skip

Connect = Literal["none", "iand", "add"]
Norm = Callable[[int], nn.Module]

TRUNK_SCALE, TRUNK_BIAS = 3.0, 0.5
"""Where the norms of an IAND trunk start, see ``SpikingResNet18``: currents of mean 0.5 and deviation 3
against a threshold of 1."""


@contextmanager
def fresh_state(network: nn.Module) -> Iterator[nn.Module]:
    """Reset the membranes of ``network`` before and after, so no clip leaks into the next."""
    functional.reset_net(network)
    try:
        yield network
    finally:
        functional.reset_net(network)


class TemporalBatchNorm(layer.TemporalEffectiveBatchNorm2d):
    """TEBN: one batch norm over (T, N, H, W), times a learnable scalar per time step.

    SpikingJelly's own broadcasts silently where T is 1; this one refuses any other T.
    """

    def forward(self, x_seq: torch.Tensor) -> torch.Tensor:
        """Map (T, N, C, H, W) to the same shape.

        Raises:
            ConfigError: Where T is not the one it was built for.
        """
        frames = self.scale.shape[0]
        if x_seq.dim() != 5 or x_seq.shape[0] != frames:
            raise ConfigError(
                f"a TEBN layer built for frames = {frames} got shape {tuple(x_seq.shape)}; it takes "
                f"(T, N, C, H, W) with T = {frames}, all time steps at once."
            )
        return super().forward(x_seq)


def _conv_norm(
    inputs: int, outputs: int, kernel: int, stride: int, norm: Norm
) -> tuple[nn.Module, nn.Module]:
    conv = layer.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False, step_mode="m")
    return conv, norm(outputs)


class SpikingBlock(nn.Module):
    """A residual block; ``connect`` says how the shortcut I meets the branch's spikes A.

    none: spike(branch current + I), the plain spiking ResNet; iand: (1 - A) I; add: A + I.
    """

    def __init__(self, inputs: int, outputs: int, stride: int, connect: Connect, norm: Norm) -> None:
        super().__init__()
        self.connect = connect
        self.conv1, self.bn1 = _conv_norm(inputs, outputs, 3, stride, norm)
        self.sn1 = PLIF()
        self.conv2, self.bn2 = _conv_norm(outputs, outputs, 3, 1, norm)
        self.sn2 = PLIF()
        self.downsample: nn.Module | None = None
        if stride != 1 or inputs != outputs:
            parts = [*_conv_norm(inputs, outputs, 1, stride, norm)]
            if connect != "none":
                parts.append(PLIF())
            self.downsample = nn.Sequential(*parts)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Map (T, N, C, H, W) to (T, N, outputs, H / stride, W / stride)."""
        shortcut = x if self.downsample is None else self.downsample(x)
        branch = self.bn2(self.conv2(self.sn1(self.bn1(self.conv1(x)))))
        if self.connect == "none":
            return self.sn2(branch + shortcut)
        spikes = self.sn2(branch)
        return spikes + shortcut if self.connect == "add" else (1 - spikes) * shortcut


class SpikingResNet18(nn.Module):
    """A spiking ResNet18 whose readout is the mean over T of a non-spiking linear layer.

    Args:
        in_channels: Channels of one image.
        frames: T.
        width: Multiplier on all channel counts.
        connect: See SpikingBlock.
        temporal_norm: TEBN instead of batch norm.
    """

    def __init__(
        self,
        in_channels: int,
        frames: int,
        width: float = 1.0,
        *,
        connect: Connect = "iand",
        temporal_norm: bool = True,
    ) -> None:
        super().__init__()
        if connect not in ("none", "iand", "add"):
            raise unknown_name("connect function", connect, ("none", "iand", "add"))
        self.in_channels = in_channels
        self.frames = frames

        def norm(channels: int) -> nn.Module:
            if temporal_norm:
                return TemporalBatchNorm(frames, channels)
            return layer.BatchNorm2d(channels, step_mode="m")

        stem = stem_width(width)
        self.conv1, self.bn1 = _conv_norm(in_channels, stem, 7, 2, norm)
        self.sn1 = PLIF()
        self.maxpool = layer.MaxPool2d(3, 2, 1, step_mode="m")
        inputs = stem
        for stage, stride in enumerate((1, 2, 2, 2)):
            outputs = stem * 2**stage
            blocks = (
                SpikingBlock(inputs, outputs, stride, connect, norm),
                SpikingBlock(outputs, outputs, 1, connect, norm),
            )
            self.add_module(f"layer{stage + 1}", nn.Sequential(*blocks))
            inputs = outputs
        self.avgpool = layer.AdaptiveAvgPool2d(1, step_mode="m")
        self.fc = nn.Linear(inputs, 1)
        for module in self.modules():
            if isinstance(module, nn.Conv2d):
                nn.init.kaiming_normal_(module.weight, mode="fan_out", nonlinearity="relu")
        if connect == "iand":
            self._raise_trunk()

    def _raise_trunk(self) -> None:
        """Let the trunk, conv1 and the spiking shortcuts, fire at 15-35 % instead of 3-5 %; branches stay quiet.

        IAND can only take spikes away from the trunk: at the usual scale 1 and bias 0 little is left for the
        readout, whose mean over space and time is then nearly the same for every clip. A quiet branch makes a
        block the identity, (1 - 0) I, so with a raised trunk training starts from a shallow network of four
        spiking layers that the gradient crosses easily.
        """
        shortcuts = [module.downsample for module in self.modules() if isinstance(module, SpikingBlock)]
        norms = [self.bn1, *(shortcut[1] for shortcut in shortcuts if isinstance(shortcut, nn.Sequential))]
        for norm in norms:
            for name, value in (("weight", TRUNK_SCALE), ("bias", TRUNK_BIAS)):
                nn.init.constant_(norm.get_parameter(name), value)

    def forward(self, clips: torch.Tensor) -> torch.Tensor:
        """Map clips (T, N, C, H, W) to logits (N,); the membranes carry on unless in ``fresh_state``."""
        check_clips(clips, self.frames, self.in_channels, type(self).__name__)
        x = self.maxpool(self.sn1(self.bn1(self.conv1(clips))))
        for stage in range(1, 5):
            x = getattr(self, f"layer{stage}")(x)
        return self.fc(self.avgpool(x).flatten(2)).squeeze(2).mean(0)


def firing_rates(network: nn.Module, clips: torch.Tensor) -> dict[str, float]:
    """Measure the mean spikes per neuron and time step of every spiking layer, in evaluation mode.

    Args:
        network: Any network; the result is empty where nothing in it spikes.
        clips: (T, N, C, H, W) float32.
    """
    rates: dict[str, float] = {}
    hooks = [
        module.register_forward_hook(
            lambda _module, _inputs, output, name=name: rates.__setitem__(name, float(output.mean()))
        )
        for name, module in network.named_modules()
        if isinstance(module, neuron.BaseNode)
    ]
    training = network.training
    network.eval()
    try:
        with torch.no_grad(), fresh_state(network):
            network(clips)
    finally:
        network.train(training)
        for hook in hooks:
            hook.remove()
    return rates


def sp_r18(*, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build the paper's SP R18: spiking ResNet18 with current shortcuts."""
    return SpikingResNet18(in_channels, frames, width, connect="none", temporal_norm=False)


def sps_r18(*, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build the paper's SPS R18: SEW ResNet18 with IAND."""
    return SpikingResNet18(in_channels, frames, width, connect="iand", temporal_norm=False)


def sps_r18t(*, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build the paper's SPS R18T: SEW ResNet18 with IAND and TEBN."""
    return SpikingResNet18(in_channels, frames, width, connect="iand", temporal_norm=True)


def sps_r18_add(*, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build SPS R18 with ADD instead of IAND."""
    return SpikingResNet18(in_channels, frames, width, connect="add", temporal_norm=False)


def sps_r18t_add(*, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build SPS R18T with ADD instead of IAND."""
    return SpikingResNet18(in_channels, frames, width, connect="add", temporal_norm=True)
