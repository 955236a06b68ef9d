"""Ground and sky for cameras that turn or roll and for streets that bend: the general kernels' work space."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.ground_tables import GroundTables
from pedcross_env.camera.kernels.ground_free import draw_ground_and_sky_freely
from pedcross_env.camera.kernels.shadows import shadow_bounds
from pedcross_env.camera.kernels.street_profile import STREET_ROWS, WORK_SIZE
from pedcross_env.camera.pinhole import CameraPose

__all__ = ["draw_ground_freely", "horizon_line"]


def horizon_line(pose: CameraPose) -> tuple[float, float]:
    """Return the horizon's row at the image's left edge and by how much it descends per column.

    The road's plane vanishes where up . ray = 0.
    """
    up = pose.rotation[:, 2]
    tilt = -up[0] / up[1]
    return float(pose.cy - pose.focal_px * up[2] / up[1] - tilt * pose.cx), float(tilt)


def draw_ground_freely(
    pose: CameraPose,
    env: np.ndarray,
    ground: GroundTables,
    shadows: tuple[np.ndarray, np.ndarray, np.ndarray],
    lights: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    xs: np.ndarray,
    frame: tuple[np.ndarray, ...],
    buf: np.ndarray,
) -> None:
    """Fill what objects left over; see ``kernels.ground_free``."""
    size = (pose.height_px, pose.width_px)
    optics = (pose.focal_px, pose.cx, pose.cy)
    bounds = np.zeros((len(shadows[0]) + len(shadows[2]), 4), np.int64)
    shadow_bounds(shadows[1], shadows[2], pose.rotation, pose.origin, optics, size, bounds)
    works = (np.zeros(WORK_SIZE, np.float32), np.empty((STREET_ROWS, pose.width_px), np.float32))
    draw_ground_and_sky_freely(
        pose.rotation, pose.origin, env, ground.layout, ground.tables, shadows, bounds, lights, optics, xs, size, frame,
        works, buf,
    )  # fmt: skip
