"""Smaller event frames that keep events: pooling, and nearest neighbours. NumPy alone, every function pure.

Interpolation (bilinear, area, bicubic) averages an event with the silence around it: the result is neither event nor
silence. Pooling gives each source pixel exactly one target pixel, so that sums are kept (``sum``) or every event
leaves a full trace (``max``).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from pedcross_env.config import require
from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError, unknown_name
from pedcross_env.sensors.events import pixel_index

__all__ = ["nearest", "pool", "rescale_events"]

Shape = tuple[int, int]
Pooling = Literal["max", "sum"]
_ROWS_COLUMNS = (-2, -1)


def _first_of_cell(source: int, target: int) -> np.ndarray:
    """First source index of each target cell, (target,): source k belongs to target floor(k target / source)."""
    return -(-np.arange(target) * source // target)


def _check_target(shape: Shape) -> None:
    require(len(shape) == 2 and min(shape) >= 1, "shape", shape, "(height, width), both 1 or more")


def pool(image: np.ndarray, shape: Shape, how: Pooling, axes: tuple[int, int] = _ROWS_COLUMNS) -> np.ndarray:
    """Shrink by pooling; cells differ by a pixel in size where the sizes do not divide.

    Args:
        image: Any array with rows and columns on ``axes``; for "max" of signed data (voxel grids) the value farthest
            from zero stays, sign and all.
        shape: (height, width) wanted, at most the image's.
        how: "max" keeps the strongest value of a cell, "sum" adds (8- and 16-bit counts come back as int64).
        axes: Of rows and columns; (0, 1) for (H, W, C).

    Raises:
        ConfigError: For an unknown ``how``, or a target larger than the image.
    """
    if how not in ("max", "sum"):
        raise unknown_name("pooling", how, ("max", "sum"))
    _check_target(shape)
    sizes = image.shape[axes[0]], image.shape[axes[1]]
    require(shape[0] <= sizes[0] and shape[1] <= sizes[1], "shape", shape,
            f"at most the image's {sizes}: pooling only shrinks; use nearest() to enlarge")  # fmt: skip
    out = image
    for axis, source, target in zip(axes, sizes, shape, strict=True):
        cells = _first_of_cell(source, target)
        if how == "sum":
            dtype = np.int64 if image.dtype.kind in "iub" else image.dtype
            out = np.add.reduceat(out, cells, axis=axis, dtype=dtype)
        elif image.dtype.kind in "ub":
            out = np.maximum.reduceat(out, cells, axis=axis)
        else:
            high, low = np.maximum.reduceat(out, cells, axis=axis), np.minimum.reduceat(out, cells, axis=axis)
            out = np.where(high >= -low, high, low)
    return out


def nearest(image: np.ndarray, shape: Shape, axes: tuple[int, int] = _ROWS_COLUMNS) -> np.ndarray:
    """Resize by taking, for each target pixel, the source pixel under its centre: the paper's choice.

    Values stay what they were, but every source pixel under no centre is lost.

    Args:
        image: Any array with rows and columns on ``axes``.
        shape: (height, width) wanted, smaller or larger.
        axes: Of rows and columns; (0, 1) for (H, W, C).
    """
    _check_target(shape)
    out = image
    for axis, target in zip(axes, shape, strict=True):
        source = image.shape[axis]
        out = np.take(out, (2 * np.arange(target) + 1) * source // (2 * target), axis=axis)
    return out


def rescale_events(events: np.ndarray, source: Shape, target: Shape) -> np.ndarray:
    """Give events the addresses of a coarser sensor; no event is lost, none is made.

    Counting what comes back equals sum-pooling the counts of what went in.

    Args:
        events: (N,) EVENT_DTYPE.
        source: (height, width) that they were recorded with.
        target: (height, width) wanted, at most the source's.

    Returns:
        (N,) EVENT_DTYPE, a copy, in the same order.

    Raises:
        ConfigError: For a target larger than the source.
        DataError: For another dtype, or an event outside ``source``.
    """
    _check_target(target)
    require(
        target[0] <= source[0] and target[1] <= source[1], "target", target, f"at most the source's {source}"
    )
    if events.dtype != EVENT_DTYPE:
        raise DataError(f"events are {events.dtype}, expected contracts.EVENT_DTYPE.")
    pixel_index(events, source)
    out = events.copy()
    out["y"] = events["y"].astype(np.int64) * target[0] // source[0]
    out["x"] = events["x"].astype(np.int64) * target[1] // source[1]
    return out
