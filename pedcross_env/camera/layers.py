"""Parts of the scene by distance, rendered apart and put one before the other: far ones move little in the picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pedcross_env.camera.kernels.layers import lay_all

__all__ = [
    "FARTHEST",
    "MOST_LAYERS",
    "NEAREST",
    "WHOLE",
    "Border",
    "Layer",
    "Picture",
    "Seen",
    "compose",
    "picture_of",
    "whole_picture",
]


class Border(NamedTuple):
    """Where one layer of a straight street ends and the next begins: world x, between two houses on either side.

    Houses are not parted: a roof is drawn with its walls, and what stands before a house with the house.

    Attributes:
        right_m: Of what is on the right, y <= 0.
        left_m: Of what is on the left.
    """

    right_m: float
    left_m: float

    def of(self, y: np.ndarray) -> np.ndarray:
        """World x on the side that ``y`` is on."""
        return np.where(y > 0, self.left_m, self.right_m)


NEAREST, FARTHEST = Border(-math.inf, -math.inf), Border(math.inf, math.inf)


class Layer(NamedTuple):
    """What stands on a straight street from one border to another, and the ground about there.

    The borders and who is of the layer hold for a while, in which the camera drives on and actors move.

    Attributes:
        start: The border nearer by.
        end: The one farther away.
        rows: The picture's upper rows that the layer reaches down to.
        ground_row: From here downwards the ground is of this layer, above it of the one behind; 0: the sky is, too.
        actors: (N,) bool, the snapshot's actors that are of it; None: those between its borders, as all else.
    """

    start: Border
    end: Border
    rows: int
    ground_row: int
    actors: np.ndarray | None


WHOLE = Layer(NEAREST, FARTHEST, 1 << 30, 0, None)


class Seen(NamedTuple):
    """One render of a layer.

    Attributes:
        luminance: (rows, W) float32 cd/m2, premultiplied by the coverage.
        cover: (ground_row, W) float32, share of each pixel above the layer's ground that its objects hide.
    """

    luminance: np.ndarray
    cover: np.ndarray


Picture = tuple[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.float32], ...]
"""Layers put one before the other, as kernels.layers takes them."""

MOST_LAYERS = 4
_NOTHING = np.empty(0, np.float32)
_NO_LAYER = _NOTHING, _NOTHING, _NOTHING, _NOTHING, np.float32(0)


def picture_of(layers: Sequence[tuple[Seen, Seen, float]]) -> Picture:
    """Put layers one before the other.

    Args:
        layers: The nearest first, ``MOST_LAYERS`` at most: two renders of each and where between them the moment lies, 0 to 1.
    """
    parts = [
        (
            first.luminance.reshape(-1), first.cover.reshape(-1),
            last.luminance.reshape(-1), last.cover.reshape(-1), np.float32(share),
        )
        for first, last, share in layers
    ]  # fmt: skip
    return (*parts, *[_NO_LAYER] * (MOST_LAYERS - len(parts)))


def whole_picture(luminance: np.ndarray) -> Picture:
    """Take a picture (H, W) float32 cd/m2 that is not parted into layers."""
    seen = Seen(luminance, _NOTHING)
    return picture_of([(seen, seen, 0.0)])


def compose(layers: Sequence[tuple[Seen, Seen, float]], shape: tuple[int, int]) -> np.ndarray:
    """Put layers one before the other.

    Args:
        layers: As for ``picture_of``.
        shape: (H, W) of the picture.

    Returns:
        (H, W) float32 cd/m2.
    """
    picture = np.empty(shape, np.float32)
    lay_all(picture_of(layers), picture.reshape(-1))
    return picture
