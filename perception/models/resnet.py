"""ResNet18 on frames, as clip classifiers without spikes.

Layers carry torchvision's parameter names, so ImageNet weights load with ``load_state_dict``.
"""

from __future__ import annotations

import torch
from torch import nn

from pedcross_env.errors import ConfigError
from perception.models.shape import check_clips

__all__ = [
    "BasicBlock", "PseudoTemporalResNet18", "ResNet18", "StackedResNet18", "pt_resnet18", "stacked_resnet18",
    "stem_width",
]  # fmt: skip


def stem_width(width: float) -> int:
    """Return the channels of the first stage: 64 in a full-width ResNet18.

    Raises:
        ConfigError: Where 64 * width is not a whole number from 4 to 256.
    """
    channels = 64 * width
    if not (4 <= channels <= 256) or channels != int(channels):
        raise ConfigError(
            f"width = {width!r} is not allowed: 64 * width must be a whole number from 4 to 256, e.g. 0.25 or"
            " 1.0."
        )
    return int(channels)


class BasicBlock(nn.Module):
    """Two 3x3 convolutions around an identity or 1x1 shortcut."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(outputs)
        self.relu = nn.ReLU(inplace=True)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(outputs)
        self.downsample: nn.Module | None = None
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs)
            )

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Map (N, C, H, W) to (N, outputs, H / stride, W / stride)."""
        shortcut = x if self.downsample is None else self.downsample(x)
        out = self.relu(self.bn1(self.conv1(x)))
        return self.relu(self.bn2(self.conv2(out)) + shortcut)


class ResNet18(nn.Module):
    """He et al. 2016 with a width multiplier and one output logit.

    Args:
        in_channels: Channels of one image.
        width: Multiplier on all channel counts; 1.0 is the published network.
    """

    def __init__(self, in_channels: int, width: float = 1.0) -> None:
        super().__init__()
        stem = stem_width(width)
        self.conv1 = nn.Conv2d(in_channels, stem, 7, 2, 3, bias=False)
        self.bn1 = nn.BatchNorm2d(stem)
        self.relu = nn.ReLU(inplace=True)
        self.maxpool = nn.MaxPool2d(3, 2, 1)
        inputs = stem
        for stage, stride in enumerate((1, 2, 2, 2)):
            outputs = stem * 2**stage
            blocks = nn.Sequential(BasicBlock(inputs, outputs, stride), BasicBlock(outputs, outputs, 1))
            self.add_module(f"layer{stage + 1}", blocks)
            inputs = outputs
        self.avgpool = nn.AdaptiveAvgPool2d(1)
        self.fc = nn.Linear(inputs, 1)
        for module in self.modules():
            if isinstance(module, nn.Conv2d):
                nn.init.kaiming_normal_(module.weight, mode="fan_out", nonlinearity="relu")

    def frame_logits(self, images: torch.Tensor) -> torch.Tensor:
        """Map images (N, C, H, W) to logits (N,)."""
        x = self.maxpool(self.relu(self.bn1(self.conv1(images))))
        for stage in range(1, 5):
            x = getattr(self, f"layer{stage}")(x)
        return self.fc(self.avgpool(x).flatten(1)).squeeze(1)


class PseudoTemporalResNet18(ResNet18):
    """The paper's PT ResNet18: one ResNet18 on every frame, logits averaged over T.

    The average does not depend on the order of the frames: it cannot see motion.
    """

    def __init__(self, in_channels: int, frames: int, width: float = 1.0) -> None:
        super().__init__(in_channels, width)
        self.in_channels = in_channels
        self.frames = frames

    def forward(self, clips: torch.Tensor) -> torch.Tensor:
        """Map clips (T, N, C, H, W) to logits (N,)."""
        check_clips(clips, self.frames, self.in_channels, "pt_resnet18")
        return self.frame_logits(clips.flatten(0, 1)).unflatten(0, clips.shape[:2]).mean(0)


class StackedResNet18(ResNet18):
    """One ResNet18 over the T frames as channels (frame 0 first): a baseline that does see motion."""

    def __init__(self, in_channels: int, frames: int, width: float = 1.0) -> None:
        super().__init__(in_channels * frames, width)
        self.in_channels = in_channels
        self.frames = frames

    def forward(self, clips: torch.Tensor) -> torch.Tensor:
        """Map clips (T, N, C, H, W) to logits (N,)."""
        check_clips(clips, self.frames, self.in_channels, "stacked_resnet18")
        return self.frame_logits(clips.transpose(0, 1).flatten(1, 2))


def pt_resnet18(*, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build the pseudo-temporal ResNet18."""
    return PseudoTemporalResNet18(in_channels, frames, width)


def stacked_resnet18(*, in_channels: int, frames: int, width: float) -> nn.Module:
    """Build the stacked-frames ResNet18."""
    return StackedResNet18(in_channels, frames, width)
