"""Where a lens shows a ray: OpenCV's formulas, for the camera and for what weather puts before it.

calib3d (Brown-Conrady k1, k2, p1, p2) and its fisheye module (theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8)).
"""

from __future__ import annotations

import numpy as np

__all__ = ["distort", "undistort"]

_STEPS = 30  # of Newton's method


def _brown(k: tuple[float, ...], x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    p1, p2 = k[2:4] if len(k) == 4 else (0.0, 0.0)
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k[0] + r2 * k[1])
    return (
        x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
        y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
    )


def _bent(k: tuple[float, ...], theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The fisheye's theta_d and its derivative."""
    t = theta * theta
    value = theta * (1 + t * (k[0] + t * (k[1] + t * (k[2] + t * k[3]))))
    return value, 1 + t * (3 * k[0] + t * (5 * k[1] + t * (7 * k[2] + t * 9 * k[3])))


def distort(
    lens: str, coefficients: tuple[float, ...], x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where the ray (x, y, 1) is seen, in units of the focal length.

    Args:
        lens: "pinhole", "brown" or "fisheye".
        coefficients: CameraConfig.distortion.
        x: To the right over depth, any shape.
        y: Down over depth, the same shape.
    """
    if lens == "pinhole":
        return x, y
    if lens == "brown":
        return _brown(coefficients, x, y)
    r = np.sqrt(x * x + y * y)
    scale = np.where(r > 1e-9, _bent(coefficients, np.arctan(r))[0] / np.maximum(r, 1e-9), 1.0)
    return x * scale, y * scale


def undistort(
    lens: str, coefficients: tuple[float, ...], x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The ray that is seen at (x, y), the inverse of ``distort`` by Newton's method; nan where there is none."""
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    if lens == "pinhole":
        return x, y
    if lens == "fisheye":
        reach = np.sqrt(x * x + y * y)
        theta = np.minimum(reach, 1.2)
        for _ in range(_STEPS):
            value, slope = _bent(coefficients, theta)
            theta = np.clip(theta - (value - reach) / np.where(slope > 0.05, slope, 0.05), 0.0, 1.5)
        value, slope = _bent(coefficients, theta)
        found = (np.abs(value - reach) < 1e-9) & (slope > 0) & (theta < 1.5)
        scale = np.where(found, np.where(reach > 1e-9, np.tan(theta) / np.maximum(reach, 1e-9), 1.0), np.nan)
        return x * scale, y * scale
    u, v, h = x.copy(), y.copy(), 1e-6
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            fx, fy = _brown(coefficients, u, v)
            ax, ay = _brown(coefficients, u + h, v)
            bx, by = _brown(coefficients, u, v + h)
            a, b, c, d = (ax - fx) / h, (bx - fx) / h, (ay - fy) / h, (by - fy) / h
            turn = a * d - b * c
            turn = np.where(turn > 1e-3, turn, np.nan)  # folded: no ray is seen there
            ex, ey = x - fx, y - fy
            u, v = u + (d * ex - b * ey) / turn, v + (a * ey - c * ex) / turn
        fx, fy = _brown(coefficients, u, v)
        found = np.abs(fx - x) + np.abs(fy - y) < 1e-9
    return np.where(found, u, np.nan), np.where(found, v, np.nan)
