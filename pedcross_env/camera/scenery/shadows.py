"""Shadows of what stands still, cast on the ground by the sun."""

from __future__ import annotations

import math

import numpy as np

__all__ = ["sun_shear", "tree_shadow_capsules"]


def sun_shear(direction: np.ndarray) -> tuple[float, float]:
    """Return how far a shadow falls per metre of height, along x and y; bounded for a low sun."""
    rise = max(0.08, float(direction[2]))
    return -float(direction[0]) / rise, -float(direction[1]) / rise


def tree_shadow_capsules(crowns: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Cast crowns on the ground.

    Args:
        crowns: (S, 7) centre, half width, half height (m), strength, softness (m).
        direction: (3,) towards the sun.

    Returns:
        (S, 9) capsules of kernels.ground.
    """
    shear_x, shear_y = sun_shear(direction)
    out = np.zeros((len(crowns), 9))
    for k, (x, y, z, half_width, half_height, strength, soft) in enumerate(crowns):
        half = 0.6 * half_height
        out[k, 0], out[k, 1] = x + shear_x * (z - half), y + shear_y * (z - half)
        out[k, 2], out[k, 3] = 2 * shear_x * half, 2 * shear_y * half
        out[k, 4] = 1 / max(1e-6, math.hypot(out[k, 2], out[k, 3]) ** 2)
        out[k, 5:9] = 0.8 * half_width, soft, strength, 0
    return out
