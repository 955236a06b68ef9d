"""What is made of events: counts, CARLA's image, a lossless picture, the paper's grey frame. NumPy alone.

Channels of counts: 0 = ON, 1 = OFF. Events are EVENT_DTYPE arrays sorted by time; empty ones are legal.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError

__all__ = ["carla_image", "counts_to_png", "event_counts", "grey_frame", "pixel_index", "png_to_counts"]

_CODE_OFFSET = 127  # a count of 1 is written as 128: visible, and told from damage (1..127 never occur)
_GREY_ON = 29  # CARLA's blue (0, 0, 255) in Rec. 601 grey
_GREY_OFF = 76  # CARLA's red (255, 0, 0)


def pixel_index(events: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Row-major pixel index of each event.

    Args:
        events: (N,) EVENT_DTYPE.
        shape: (height, width) of the sensor.

    Returns:
        (N,) int64.

    Raises:
        DataError: For another dtype, or an event outside ``shape``.
    """
    if events.dtype != EVENT_DTYPE or events.ndim != 1:
        raise DataError(
            f"events are {events.dtype} of shape {events.shape}, expected a one-dimensional array of "
            f"contracts.EVENT_DTYPE; convert them field by field."
        )
    height, width = shape
    x, y = events["x"].astype(np.int64), events["y"].astype(np.int64)
    if events.size and (x.max() >= width or y.max() >= height):
        raise DataError(
            f"events reach x = {x.max()}, y = {y.max()}, outside the shape (height, width) = {shape}; "
            f"is the shape given as (width, height)?"
        )
    return y * width + x


def _check_counts(counts: np.ndarray) -> None:
    if counts.dtype != np.uint8 or counts.ndim != 3 or counts.shape[2] != 2:
        raise DataError(f"counts are {counts.dtype} of shape {counts.shape}, expected (H, W, 2) uint8.")


def event_counts(events: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Count events per pixel and polarity.

    Args:
        events: (N,) EVENT_DTYPE.
        shape: (height, width) of the sensor.

    Returns:
        (H, W, 2) uint8, ON and OFF; 255 stands for 255 or more.

    Raises:
        DataError: For another dtype, or an event outside ``shape``.
    """
    index = 2 * pixel_index(events, shape) + ~events["pol"]
    counts = np.bincount(index, minlength=2 * shape[0] * shape[1])
    return np.minimum(counts, 255).astype(np.uint8).reshape(*shape, 2)


def carla_image(events: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Paint events as CARLA does: black, ON blue, OFF red; the last event of a pixel wins.

    Args:
        events: (N,) EVENT_DTYPE in order of time.
        shape: (height, width) of the sensor.

    Returns:
        (H, W, 3) uint8, RGB.
    """
    index = pixel_index(events, shape)
    last = np.full(shape[0] * shape[1], -1, np.int64)
    # Fancy assignment leaves open which of several events at a pixel stays; a maximum does not.
    np.maximum.at(last, index, np.arange(index.size))
    hit = np.flatnonzero(last >= 0)
    image = np.zeros((shape[0] * shape[1], 3), np.uint8)
    image[hit, np.where(events["pol"][last[hit]], 2, 0)] = 255
    return image.reshape(*shape, 3)


def counts_to_png(counts: np.ndarray) -> np.ndarray:
    """Code counts as a picture that can be looked at and read back: red = OFF, blue = ON, green 0.

    A count n is written as 0 for n = 0, else as min(255, 127 + n): exact up to 128, more is cut to 128.

    Args:
        counts: (H, W, 2) uint8, ON and OFF.

    Returns:
        (H, W, 3) uint8, RGB. Save it losslessly.
    """
    _check_counts(counts)
    code = np.where(counts > 0, np.minimum(counts, 128) + np.uint8(_CODE_OFFSET), 0).astype(np.uint8)
    image = np.zeros((*counts.shape[:2], 3), np.uint8)
    image[..., 2] = code[..., 0]
    image[..., 0] = code[..., 1]
    return image


def png_to_counts(image: np.ndarray) -> np.ndarray:
    """Read counts back from counts_to_png's picture.

    Args:
        image: (H, W, 3) uint8, RGB.

    Returns:
        (H, W, 2) uint8, ON and OFF.

    Raises:
        DataError: Where the picture holds values that counts_to_png never writes.
    """
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise DataError(f"the image is {image.dtype} of shape {image.shape}, expected (H, W, 3) uint8, RGB.")
    code = image[..., [2, 0]]
    if image[..., 1].any() or ((code > 0) & (code <= _CODE_OFFSET)).any():
        raise DataError(
            "the image is no picture of event counts: green must be 0, red and blue 0 or 128..255; "
            "it may have been resized or saved with losses."
        )
    return np.where(code > 0, code - np.uint8(_CODE_OFFSET), 0).astype(np.uint8)


def grey_frame(counts: np.ndarray) -> np.ndarray:
    """Reduce counts to the paper's one-channel frame.

    Args:
        counts: (H, W, 2) uint8, ON and OFF.

    Returns:
        (H, W) uint8: 0 without events, 29 where ON prevails or is level, 76 where OFF prevails (CARLA's
        blue and red in Rec. 601 grey).
    """
    _check_counts(counts)
    on, off = counts[..., 0], counts[..., 1]
    return np.where(off > on, _GREY_OFF, np.where(on > 0, _GREY_ON, 0)).astype(np.uint8)
