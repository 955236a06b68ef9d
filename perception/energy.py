"""Energy of a network for one clip, counted in operations of 45 nm CMOS (Horowitz 2014).

4.6 pJ per multiply-accumulate (MAC), 0.9 pJ per accumulate (AC): a layer whose input is spikes only adds
weights, and only where a spike arrives.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any, Literal

import torch
from spikingjelly.activation_based import neuron
from torch import nn

from pedcross_env.errors import ConfigError
from perception.models.spiking import fresh_state

__all__ = ["AC_PJ", "MAC_PJ", "Energy", "count_energy"]

MAC_PJ = 4.6
AC_PJ = 0.9


@dataclass(frozen=True, slots=True)
class Energy:
    """Operations of one clip (all T frames, one sample).

    Attributes:
        macs: Multiply-accumulates.
        acs: Accumulates, at the spikes that were measured.
        synapses: Accumulates if every neuron fired at every step; acs / synapses is the effective rate.
        layers: Layer to (macs, acs).
    """

    macs: float
    acs: float
    synapses: float
    layers: dict[str, tuple[float, float]]

    @property
    def millijoules(self) -> float:
        """Energy of the clip in mJ."""
        return (self.macs * MAC_PJ + self.acs * AC_PJ) * 1e-9


def _fan_out_operations(module: nn.Conv2d | nn.Linear, output: torch.Tensor) -> int:
    if isinstance(module, nn.Linear):
        return output.numel() * module.in_features
    kernel = module.kernel_size[0] * module.kernel_size[1]
    return output.numel() * kernel * module.in_channels // module.groups


class _Counter:
    """Forward hooks of one pass."""

    def __init__(self, network: nn.Module, convention: str) -> None:
        self.spiking = any(isinstance(m, neuron.BaseNode) for m in network.modules())
        self.convention = convention
        self.layers: dict[str, tuple[float, float]] = {}
        self.synapses = 0.0
        self.seen_conv = False
        self.hooks = [
            m.register_forward_hook(lambda m, i, o, name=n: self.count(name, m, i[0], o))
            for n, m in network.named_modules()
        ]

    def count(self, name: str, module: nn.Module, x: torch.Tensor, y: torch.Tensor) -> None:
        """Add one layer's operations; a layer used twice counts twice."""
        macs, acs = 0.0, 0.0
        if isinstance(module, (nn.Conv2d, nn.Linear)):
            operations = _fan_out_operations(module, y)
            first = isinstance(module, nn.Conv2d) and not self.seen_conv
            self.seen_conv |= isinstance(module, nn.Conv2d)
            if self.convention == "paper" and first:
                return
            # The first layer sees the sensor, the last one pooled rates: both multiply.
            if self.spiking and isinstance(module, nn.Conv2d) and not first:
                self.synapses += operations
                acs = operations * float((x == 1).float().mean())
                macs = operations * float(((x != 0) & (x != 1)).float().mean())
            else:
                macs = operations
        elif self.convention == "paper":
            macs = self._paper_extras(name, module, x, y)
        else:
            return
        before = self.layers.get(name, (0.0, 0.0))
        self.layers[name] = (before[0] + macs, before[1] + acs)

    def _paper_extras(self, name: str, module: nn.Module, x: torch.Tensor, y: torch.Tensor) -> float:
        if isinstance(module, nn.BatchNorm2d):
            return 0.0 if name == "bn1" else 2.0 * y.numel()
        if isinstance(module, nn.ReLU):
            return float(y.numel())
        return float(x.numel()) if isinstance(module, (nn.MaxPool2d, nn.AdaptiveAvgPool2d)) else 0.0


def count_energy(
    network: nn.Module, clip: torch.Tensor, *, convention: Literal["clip", "paper"] = "clip"
) -> Energy:
    """Count the operations of one clip.

    "clip" (default): convolutions and the linear layer of all T frames, batch norm folded into
    them. In a spiking network a convolution behind spikes costs one AC per synapse whose input is
    1; inputs above 1 (sums of ADD shortcuts) cost MACs; the first convolution and the readout
    always cost MACs.
    "paper": the `syops` count behind the paper's energy table for networks without spikes: batch
    norm 2 and ReLU 1 per element, pooling 1 per input element, and without the first convolution
    and norm, which an all-zero input made vanish. Its spiking row is divided by T and cannot be
    had from one clip.

    Args:
        network: Of ``perception.registry``; not changed. Without spikes nothing is computed but shapes.
        clip: (T, 1, C, H, W) float32; for spiking networks a representative one, its spikes are measured.
        convention: As above.

    Raises:
        ConfigError: For more than one clip, an unknown convention, or "paper" on a spiking network.
    """
    if convention not in ("clip", "paper"):
        raise ConfigError(f"convention = {convention!r} is not allowed: 'clip' or 'paper'.")
    if clip.dim() != 5 or clip.shape[1] != 1:
        raise ConfigError(f"clip has shape {tuple(clip.shape)}; expected one clip (T, 1, C, H, W).")
    spiking = any(isinstance(m, neuron.BaseNode) for m in network.modules())
    if spiking and convention == "paper":
        raise ConfigError("convention = 'paper' counts networks without spikes only; use 'clip'.")
    twin: Any = copy.deepcopy(network).eval()
    if not spiking:
        twin, clip = twin.to("meta"), clip.to("meta")
    counter = _Counter(twin, convention)
    with torch.no_grad(), fresh_state(twin):
        twin(clip)
    macs = sum(m for m, _ in counter.layers.values())
    acs = sum(a for _, a in counter.layers.values())
    return Energy(macs, acs, counter.synapses, counter.layers)
