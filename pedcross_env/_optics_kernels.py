"""Where a lens shows a ray, for kernels: the formulas of pedcross_env.optics."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

__all__ = ["LENSES", "bend", "coefficients"]

LENSES = ("pinhole", "brown", "fisheye")  # by their number in ``bend``


def coefficients(distortion: tuple[float, ...]) -> np.ndarray:
    """Return CameraConfig.distortion as ``bend`` takes it: (4,) float64."""
    k = np.zeros(4)
    k[: len(distortion)] = distortion
    return k


@njit(cache=True, error_model="numpy")
def bend(lens: int, k: np.ndarray, x: float, y: float) -> tuple[float, float, float]:
    """Where a lens shows the ray (x, y, 1), in focal lengths, and how it magnifies across the radius; 0: not at all.

    ``lens``: 0 a pinhole, 1 Brown, 2 a fisheye, with the coefficients ``k``.
    """
    if lens == 0:
        return x, y, 1.0
    r2 = x * x + y * y
    if lens == 1:
        radial = 1.0 + r2 * (k[0] + r2 * k[1])
        if 1.0 + r2 * (3.0 * k[0] + 5.0 * r2 * k[1]) <= 0.05:  # beyond where the lens folds
            return x, y, 0.0
        bent_x = x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x)
        return bent_x, y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y, radial
    r = math.sqrt(r2)
    if r < 1e-9:
        return x, y, 1.0
    theta = math.atan(r)
    t = theta * theta
    scale = theta * (1.0 + t * (k[0] + t * (k[1] + t * (k[2] + t * k[3])))) / r
    rising = 1.0 + t * (3.0 * k[0] + t * (5.0 * k[1] + t * (7.0 * k[2] + t * 9.0 * k[3])))
    return x * scale, y * scale, scale if rising > 0.05 else 0.0
