"""The paper's neuron: SpikingJelly's parametric LIF, with the time loop of a whole clip fused.

SpikingJelly's eager loop records some ten tensors per time step for the backward pass; here the
membrane before the reset and the spikes are enough, since everything else follows from it.
"""

from __future__ import annotations

from typing import Any

import torch
from spikingjelly.activation_based import neuron
from spikingjelly.activation_based.surrogate import Sigmoid

__all__ = ["PLIF"]


def _reset(value: torch.Tensor, spikes: torch.Tensor) -> torch.Tensor:
    """value (1 - spikes) in one pass: a mask of booleans costs several."""
    return torch.addcmul(value, value, spikes, value=-1)


class _PlifSequence(torch.autograd.Function):
    """h[t] = v + s (x[t] - v), spike = h >= threshold, v = h (1 - spike), with s = sigmoid(w) = 1 / tau."""

    @staticmethod
    def forward(
        ctx: Any, x: torch.Tensor, v0: torch.Tensor, w: torch.Tensor, threshold: float, alpha: float
    ) -> tuple[torch.Tensor, torch.Tensor]:
        rate = float(torch.sigmoid(w))
        membrane = torch.empty_like(x, dtype=torch.float32)
        spikes = torch.empty_like(x)
        v = v0
        for t in range(x.shape[0]):
            h = torch.lerp(v, x[t].float(), rate, out=membrane[t])
            v = _reset(h, torch.ge(h, threshold, out=spikes[t]))
        ctx.save_for_backward(membrane, spikes, v0, w)
        ctx.threshold, ctx.alpha, ctx.dtype = threshold, alpha, x.dtype
        return spikes, v

    @staticmethod
    def backward(ctx: Any, *grads: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        grad_spikes, grad_v = grads
        membrane, spikes, v0, w = ctx.saved_tensors
        s = torch.sigmoid(w)
        rate = float(s)
        grad_x = torch.empty_like(membrane)
        grad_w = torch.zeros_like(w)
        for t in range(membrane.shape[0] - 1, -1, -1):
            h = membrane[t]
            previous = v0 if t == 0 else _reset(membrane[t - 1], spikes[t - 1])
            surrogate = torch.sub(h, ctx.threshold).mul_(ctx.alpha).sigmoid_()
            # The reset is not detached: the spike also acts through v = h (1 - spike).
            grad_spike = torch.addcmul(grad_spikes[t], grad_v, h, value=-1)
            through_spike = torch.ops.aten.sigmoid_backward(grad_spike, surrogate)
            grad_h = _reset(grad_v, spikes[t]).add_(through_spike, alpha=ctx.alpha)
            grad_w += torch.sub(h, previous).mul_(grad_h).sum() / rate
            torch.mul(grad_h, rate, out=grad_x[t])
            grad_v = grad_h.sub_(grad_x[t])
        return grad_x.to(ctx.dtype), grad_v, grad_w * s * (1 - s), None, None


class PLIF(neuron.ParametricLIFNode):
    """Parametric leaky integrate-and-fire (Fang et al. 2021) as the paper sets it.

    tau 2 at the start and learnable (one per layer), decaying input, threshold 1, hard reset to 0,
    sigmoid surrogate of slope 4, reset not detached; multi-step on (T, N, ...).
    """

    def __init__(self) -> None:
        super().__init__(
            init_tau=2.0, decay_input=True, v_threshold=1.0, v_reset=0.0,
            surrogate_function=Sigmoid(alpha=4.0), detach_reset=False, step_mode="m",
        )  # fmt: skip

    def multi_step_forward(self, x_seq: torch.Tensor) -> torch.Tensor:
        """Map currents (T, N, ...) to spikes of the same shape and dtype; the membrane stays in ``v``."""
        stored: Any = self._memories["v"]
        v0 = stored if isinstance(stored, torch.Tensor) else torch.zeros_like(x_seq[0], dtype=torch.float32)
        spikes, self.v = _PlifSequence.apply(
            x_seq, v0, self.w, self.v_threshold, self.surrogate_function.alpha
        )
        return spikes
