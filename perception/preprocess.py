"""From an observation to a network's input: the same for data sets and for streaming.

``shrink`` crops, encodes and resizes to 8 bits (compact enough to hold a data set in memory);
``normalise`` makes float32 planes of any stack of such images.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import cv2
import numpy as np

from pedcross_env.contracts import MODALITIES, Modality
from pedcross_env.errors import ConfigError, unknown_name
from pedcross_env.sensors.events import grey_frame

__all__ = ["IMAGENET_MEAN", "IMAGENET_STD", "Preprocess", "Resize", "RgbInput"]

Resize = Literal["nearest", "area", "max"]
RgbInput = Literal["image", "changes", "both"]
IMAGENET_MEAN = (0.485, 0.456, 0.406)
IMAGENET_STD = (0.229, 0.224, 0.225)
_INPUT_CHANNELS = {"rgb": 3, "dvs": 2}
_DVS_CHANNELS = (1, 2)
_RGB_CHANNELS: dict[RgbInput, int] = {"image": 3, "changes": 1, "both": 4}
_DARK_LEVEL = 16.0
"""Grey levels added before the logarithm, so that quantisation and noise in the dark do not dominate it."""
_CHANGE_SCALE = 0.1
"""A change by this much of the logarithm (10 % of contrast) is 1 to the network."""
_LOG_LEVEL = (np.log(np.arange(256) + _DARK_LEVEL) / _CHANGE_SCALE).astype(np.float32)


def _block_maximum(image: np.ndarray, height: int, width: int) -> np.ndarray:
    rows = np.arange(height) * image.shape[0] // height
    columns = np.arange(width) * image.shape[1] // width
    return np.maximum.reduceat(np.maximum.reduceat(image, rows, axis=0), columns, axis=1)


def _changes(luminance: np.ndarray) -> np.ndarray:
    """Map (T, ...) uint8 to float32 differences of the logarithm to the frame before, 0 in the first."""
    level = _LOG_LEVEL[luminance]
    return np.diff(level, axis=0, prepend=level[:1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Preprocess:
    """Crop a band of rows, encode, resize, normalise.

    Attributes:
        modality: "rgb" reads (H, W, 3) uint8; "dvs" reads (H, W, 2) uint8 counts, ON and OFF.
        channels: rgb: 3 for "image", 1 for "changes", 4 for "both". dvs: 1 = the paper's grey event frame,
            2 = counts of ON and OFF.
        width_px, height_px: What the network sees.
        resize: "nearest", "area" (block mean) or "max" (block maximum).
        crop_top, crop_bottom: First and last row kept, as fractions of the height from the top.
        count_clip: With 2 channels, counts from this on are full scale (1.0).
        mean, std: Per channel, of values in [0, 1]; of a change in units of 10 % contrast.
        rgb_input: What a network sees of rgb: the "image"; its "changes", the difference of the logarithm of
            luminance to the frame before, 0 in the first frame of a clip; "both", changes last.
            A moving pedestrian of a few pixels is lost in the image but stands out in its changes, which are
            also what an event camera measures.
    """

    modality: Modality
    channels: int
    width_px: int = 112
    height_px: int = 64
    resize: Resize = "area"
    crop_top: float = 0.3
    crop_bottom: float = 0.8
    count_clip: int = 4
    mean: tuple[float, ...] = ()
    std: tuple[float, ...] = ()
    rgb_input: RgbInput = "image"

    def __post_init__(self) -> None:
        if self.modality not in MODALITIES:
            raise unknown_name("modality", self.modality, MODALITIES)
        if self.rgb_input not in get_args(RgbInput):
            raise unknown_name("rgb_input", self.rgb_input, get_args(RgbInput))
        if self.modality == "dvs" and self.rgb_input != "image":
            raise ConfigError(
                f"rgb_input = {self.rgb_input!r} is not allowed for dvs: events are changes already; leave it out."
            )
        allowed = (_RGB_CHANNELS[self.rgb_input],) if self.modality == "rgb" else _DVS_CHANNELS
        if self.channels not in allowed:
            kind = self.modality if self.modality == "dvs" else f"rgb_input {self.rgb_input!r}"
            raise ConfigError(f"channels = {self.channels!r} is not allowed for {kind}: one of {allowed}.")
        if self.resize not in get_args(Resize):
            raise unknown_name("resize", self.resize, get_args(Resize))
        if not (8 <= self.width_px <= 4096 and 8 <= self.height_px <= 4096):
            raise ConfigError(
                f"width_px, height_px = {self.width_px}, {self.height_px}: both must be 8 to 4096."
            )
        if not 0 <= self.crop_top < self.crop_bottom <= 1:
            raise ConfigError(
                f"crop_top, crop_bottom = {self.crop_top}, {self.crop_bottom}: must be 0 <= top < bottom"
                " <= 1."
            )
        if not 1 <= self.count_clip <= 255:
            raise ConfigError(f"count_clip = {self.count_clip!r} is not allowed: it must be 1 to 255.")
        for name, default in (("mean", 0.0), ("std", 1.0)):
            values = tuple(getattr(self, name)) or (default,) * self.channels
            if len(values) != self.channels or (name == "std" and min(values) <= 0):
                raise ConfigError(f"{name} = {values!r} is not allowed: {self.channels} values, std above 0.")
            object.__setattr__(self, name, values)

    @classmethod
    def compact(
        cls,
        modality: Modality,
        width_px: int = 112,
        height_px: int = 64,
        rgb_input: RgbInput = "image",
        rows: tuple[float, float] = (0.3, 0.8),
    ) -> Preprocess:
        """Return the default of this package: a band of ``rows`` around the horizon, block means, counts for dvs."""
        size: dict[str, Any] = {
            "width_px": width_px,
            "height_px": height_px,
            "crop_top": rows[0],
            "crop_bottom": rows[1],
        }
        if modality == "rgb":
            mean = {"image": IMAGENET_MEAN, "changes": (), "both": (*IMAGENET_MEAN, 0.0)}
            std = {"image": IMAGENET_STD, "changes": (), "both": (*IMAGENET_STD, 1.0)}
            if rgb_input not in mean:
                raise unknown_name("rgb_input", rgb_input, mean)
            return cls(
                modality="rgb",
                channels=_RGB_CHANNELS[rgb_input],
                mean=mean[rgb_input],
                std=std[rgb_input],
                rgb_input=rgb_input,
                **size,
            )
        return cls(modality=modality, channels=2, **size)

    @classmethod
    def paper(cls, modality: Modality, width_px: int = 450, height_px: int = 256) -> Preprocess:
        """Return the paper's: the whole image at 450x256; dvs as one grey channel by nearest neighbour."""
        size: dict[str, Any] = {
            "width_px": width_px,
            "height_px": height_px,
            "crop_top": 0.0,
            "crop_bottom": 1.0,
        }
        if modality == "rgb":
            return cls(
                modality="rgb", channels=3, resize="area", mean=IMAGENET_MEAN, std=IMAGENET_STD, **size
            )
        return cls(modality=modality, channels=1, resize="nearest", **size)

    @property
    def sees_changes(self) -> bool:
        """Whether a frame's planes depend on the frame before it."""
        return self.rgb_input != "image"

    def shrink(self, image: np.ndarray) -> np.ndarray:
        """Crop, encode and resize one image.

        Args:
            image: (H, W, 3) uint8 RGB or (H, W, 2) uint8 counts.

        Returns:
            (height_px, width_px, channels) uint8.

        Raises:
            ConfigError: For another shape or dtype.
        """
        inputs = _INPUT_CHANNELS[self.modality]
        if image.ndim != 3 or image.shape[2] != inputs or image.dtype != np.uint8 or image.size == 0:
            raise ConfigError(
                f"{self.modality} image has shape {image.shape} and dtype {image.dtype}; "
                f"expected (H, W, {inputs}) uint8."
            )
        height = image.shape[0]
        top = min(round(self.crop_top * height), height - 1)
        image = image[top : max(round(self.crop_bottom * height), top + 1)]
        if self.modality == "dvs":
            image = grey_frame(image)[..., None] if self.channels == 1 else self._encode_counts(image)
        elif self.sees_changes:
            grey = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2GRAY)[..., None]
            image = grey if self.rgb_input == "changes" else np.concatenate([image, grey], axis=2)
        return self._resize(image)

    def _encode_counts(self, counts: np.ndarray) -> np.ndarray:
        levels = np.minimum(np.arange(256), self.count_clip) * (255.0 / self.count_clip)
        return np.round(levels).astype(np.uint8)[counts]

    def _resize(self, image: np.ndarray) -> np.ndarray:
        if image.shape[:2] == (self.height_px, self.width_px):
            return np.ascontiguousarray(image)
        if self.resize == "max":
            return _block_maximum(image, self.height_px, self.width_px)
        method = cv2.INTER_AREA if self.resize == "area" else cv2.INTER_NEAREST_EXACT
        small = cv2.resize(np.ascontiguousarray(image), (self.width_px, self.height_px), interpolation=method)
        return small.reshape(self.height_px, self.width_px, self.channels)

    def normalise(self, small: np.ndarray) -> np.ndarray:
        """Map (T, ..., h, w, C) uint8 from ``shrink`` to (T, ..., C, h, w) float32: (value / 255 - mean) / std.

        Changes are taken along the first axis. The result is a view with channels last in memory, which
        convolutions on CPUs like.
        """
        scale = 1 / (255 * np.asarray(self.std))
        offset = np.asarray(self.mean) / np.asarray(self.std)
        planes = small * scale.astype(np.float32) - offset.astype(np.float32)
        if self.sees_changes:
            planes[..., -1] = (_changes(small[..., -1]) - self.mean[-1]) / self.std[-1]
        return np.moveaxis(planes, -1, -3)

    def __call__(self, image: np.ndarray) -> np.ndarray:
        """Map one observation image, alone and so without a change, to the network's (C, h, w) float32."""
        return self.normalise(self.shrink(image)[None])[0]

    def of_observation(self, observation: Mapping[str, np.ndarray]) -> np.ndarray:
        """Shrink this modality's image of an environment's observation.

        Raises:
            ConfigError: Where the observation lacks the modality.
        """
        if self.modality not in observation:
            raise ConfigError(
                f"the observation has {', '.join(observation) or 'no keys'} but this detector reads"
                f" {self.modality!r}; add {self.modality!r} to the environment's modalities."
            )
        return self.shrink(np.asarray(observation[self.modality]))

    def to_dict(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {k: list(v) if isinstance(v, tuple) else v for k, v in dataclasses.asdict(self).items()}
