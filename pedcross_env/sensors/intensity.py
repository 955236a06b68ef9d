"""From light or pictures to what event cameras compare: logarithms, each model's own."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.errors import require
from pedcross_env.sensors import _dvs_maths as kernels
from pedcross_env.sensors.dvs_config import DvsConfig

__all__ = ["carla_log", "lin_log", "log_image", "log_luminance", "srgb_luminance"]

_GREY = (0.2989, 0.587, 0.114)  # CARLA's weights
_REC601 = (0.299, 0.587, 0.114)  # OpenCV's, by which v2e reads colour
_REC709 = (0.2126, 0.7152, 0.0722)


def _require_picture(image: np.ndarray) -> None:
    shape = image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)
    require(image.dtype == np.uint8 and shape and image.size > 0, "image", (image.dtype, image.shape),
            "a non-empty (H, W, 3) uint8, RGB, or (H, W) uint8, grey")  # fmt: skip


def _weighted(image: np.ndarray, weights: tuple[float, float, float]) -> np.ndarray:
    if image.ndim == 2:
        return image.astype(np.float64)
    red, green, blue = (weight * image[..., k].astype(np.float64) for k, weight in enumerate(weights))
    return red + green + blue


def _decoding_table() -> np.ndarray:
    """Linear light of each 8-bit sRGB code (IEC 61966-2-1)."""
    code = np.arange(256) / 255
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


_DECODED = _decoding_table()


def log_luminance(luminance: np.ndarray, floor: float) -> np.ndarray:
    """Natural logarithm of luminance plus a floor (dark current), exact to float32 rounding.

    Its own series instead of the library's logarithm: the same bits on every processor.

    Args:
        luminance: (H, W) float32, cd/m2, 0 or more.
        floor: cd/m2, positive (DvsConfig.log_floor_cd_m2).

    Returns:
        (H, W) float32.
    """
    require(floor > 0, "floor", floor, "positive")
    out = np.empty(luminance.shape, np.float32)
    light = np.ascontiguousarray(luminance, np.float32)
    kernels.log_above(light.reshape(-1), np.float32(floor), out.reshape(-1))
    return out


def srgb_luminance(image: np.ndarray, white_cd_m2: float) -> np.ndarray:
    """Luminance that a picture shows, white being ``white_cd_m2``.

    Args:
        image: (H, W, 3) uint8, sRGB, or (H, W) uint8, grey with sRGB's curve.
        white_cd_m2: Positive.

    Returns:
        (H, W) float32, cd/m2.
    """
    _require_picture(image)
    require(white_cd_m2 > 0, "white_cd_m2", white_cd_m2, "positive")
    table = (_DECODED * white_cd_m2).astype(np.float32)
    if image.ndim == 2:
        return table[image]
    red, green, blue = (np.float32(weight) * table[image[..., k]] for k, weight in enumerate(_REC709))
    return red + green + blue


def carla_log(image: np.ndarray, eps: float = 0.001) -> np.ndarray:
    """CARLA's logarithm of an 8-bit picture: ln(eps + grey / 255).

    Args:
        image: (H, W, 3) uint8, RGB, or (H, W) uint8, grey.
        eps: CARLA's ``log_eps``.

    Returns:
        (H, W) float32.
    """
    _require_picture(image)
    require(eps > 0, "eps", eps, "positive")
    grey = _weighted(image, _GREY).astype(np.float32)
    return np.log(np.float64(np.float32(eps)) + grey.astype(np.float64) / 255.0).astype(np.float32)


def lin_log(image: np.ndarray) -> np.ndarray:
    """v2e's mapping of grey levels: I ln(20) / 20 up to I = 20, ln I above.

    Args:
        image: (H, W, 3) uint8, RGB, or (H, W) uint8, grey.

    Returns:
        (H, W) float32, 0 to ln 255, rounded to 8 decimals as in v2e.
    """
    _require_picture(image)
    grey = np.rint(_weighted(image, _REC601))
    logarithm = np.where(grey <= 20, grey * (math.log(20) / 20), np.log(np.maximum(grey, 1.0)))
    return np.round(logarithm, 8).astype(np.float32)


def log_image(image: np.ndarray, config: DvsConfig) -> np.ndarray:
    """What ``config``'s model makes of an 8-bit frame, ready for ``initial_state`` and ``step``.

    Args:
        image: (H, W, 3) uint8, RGB, or (H, W) uint8, grey.
        config: pedcross: logarithm of the light the picture shows, in cd/m2; carla: ``carla_log``; v2e: ``lin_log``.

    Returns:
        (H, W) float32.
    """
    if config.model == "carla":
        return carla_log(image, config.log_eps)
    if config.model == "v2e":
        return lin_log(image)
    return log_luminance(srgb_luminance(image, config.white_cd_m2), config.log_floor_cd_m2)
