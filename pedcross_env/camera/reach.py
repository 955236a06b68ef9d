"""Where in the picture an actor can be seen."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.pinhole import CameraPose, project

__all__ = ["reach_of"]

CARRIED_M = 1.2  # how far bags, umbrellas and strollers reach beyond a body


def reach_of(pose: CameraPose, actors: np.ndarray) -> tuple[int, int, int, int]:
    """Columns and rows (from, from, to, to) that an actor and what it carries can cover, up to a picture beyond the edges."""
    w, h = pose.width_px, pose.height_px
    bounds = np.zeros((0, 2))
    for actor in actors:
        radius = 0.5 * math.hypot(float(actor["length"]), float(actor["width"])) + CARRIED_M
        corners = [
            [float(actor["x"]) + dx * radius, float(actor["y"]) + dy * radius, float(actor["z"]) + z]
            for dx in (-1, 1) for dy in (-1, 1) for z in (-0.1, float(actor["height"]) + 0.6)
        ]  # fmt: skip
        seen = project(pose, np.array(corners))
        if (seen[:, 2] < 0.2).all():
            return 0, 0, 0, 0
        bounds = seen[:, :2] if (seen[:, 2] >= 0.2).all() else np.array([[-w, -h], [2 * w, 2 * h]])
    if len(bounds) == 0:
        return 0, 0, 0, 0
    (u0, v0), (u1, v1) = bounds.min(axis=0), bounds.max(axis=0)
    u0, u1 = (min(max(u, -w), 2 * w) for u in (u0, u1))
    v0, v1 = (min(max(v, -h), 2 * h) for v in (v0, v1))
    return math.floor(u0), math.floor(v0), math.ceil(u1), math.ceil(v1)
