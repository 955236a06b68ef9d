"""Shadows of actors on the ground: hulls of boxes and capsules, cast by the sun, and contact shadows under them."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.pose import BODY_JOINTS, pose_body
from pedcross_env.camera.light import Light
from pedcross_env.camera.scenery import sun_shear
from pedcross_env.contracts import ActorKind

__all__ = ["actor_shadows"]

MAX_EDGES = 12
SUN, SKY = 0.0, 1.0
# limbs that cast: joint, joint, radius as a share of the height (joints of kernels.pose)
LIMBS = ((8, 9, 0.045), (9, 10, 0.032), (15, 16, 0.045), (16, 17, 0.032), (0, 1, 0.095), (1, 2, 0.085), (3, 4, 0.05), (5, 7, 0.025), (12, 14, 0.025))


def _hull(points: np.ndarray) -> np.ndarray:
    """Convex hull, counter-clockwise (monotone chain)."""
    ordered = sorted(map(tuple, points.tolist()))

    def chain(sequence: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
        out: list[tuple[float, ...]] = []
        for p in sequence:
            while len(out) >= 2 and (out[-1][0] - out[-2][0]) * (p[1] - out[-2][1]) - (out[-1][1] - out[-2][1]) * (p[0] - out[-2][0]) <= 1e-9:
                out.pop()
            out.append(p)
        return out[:-1]

    return np.array(chain(ordered) + chain(ordered[::-1]))


def _polygon(points: np.ndarray, soft: float, strength: float, target: float) -> tuple[np.ndarray, np.ndarray]:
    """Edges (positive inside) and info (x range, y range, edges, softness, strength, target) of a polygon."""
    ring = _hull(points)[:MAX_EDGES]
    edges = np.zeros((MAX_EDGES, 3))
    step = np.roll(ring, -1, axis=0) - ring
    norm = np.hypot(step[:, 0], step[:, 1])
    edges[: len(ring), 0], edges[: len(ring), 1] = -step[:, 1] / norm, step[:, 0] / norm
    edges[: len(ring), 2] = -(edges[: len(ring), 0] * ring[:, 0] + edges[: len(ring), 1] * ring[:, 1])
    low, high = ring.min(axis=0) - soft, ring.max(axis=0) + soft
    return edges, np.array([low[0], high[0], low[1], high[1], len(ring), soft, strength, target])


def _vehicle(actor: np.ndarray, shear: tuple[float, float] | None) -> list[tuple[np.ndarray, np.ndarray]]:
    yaw = float(actor["yaw"])
    c, s = math.cos(yaw), math.sin(yaw)
    half_l, half_w, height = 0.5 * float(actor["length"]), 0.5 * float(actor["width"]), float(actor["height"])
    box = np.array([[c * x - s * y, s * x + c * y] for x in (-half_l, half_l) for y in (-half_w, half_w)])
    centre = np.array([float(actor["x"]), float(actor["y"])])
    shapes = [_polygon(centre + 0.98 * box, 0.35, 0.85, SKY), _polygon(centre + 1.2 * box, 1.4, 0.45, SKY)]
    if shear is not None:
        offset = np.array(shear)
        casting = np.concatenate([box * 0.97 + 0.25 * offset, box * 0.96 + 0.62 * height * offset, box * np.array([0.72, 0.72]) + 0.97 * height * offset])
        shapes.append(_polygon(centre + casting, 0.12, 0.96, SUN))
        shapes.append(_polygon(centre + 0.95 * box, 0.2, 0.96, SUN))
    return shapes


def _pedestrian(actor: np.ndarray, shear: tuple[float, float] | None, builds: np.ndarray) -> list[list[float]]:
    height, yaw = float(actor["height"]), float(actor["yaw"])
    x, y = float(actor["x"]), float(actor["y"])
    joints = np.empty((BODY_JOINTS, 3))
    pose_body(float(actor["gait_phase"]), float(actor["gait_stride"]), float(actor["head_yaw"]), height, builds[int(actor["model"])], joints)
    c, s = math.cos(yaw), math.sin(yaw)
    out = [[x - 0.05 * c, y - 0.05 * s, 0.1 * c, 0.1 * s, 100.0, 0.20 * height / 1.75, 0.45, 0.55, SKY]]
    if shear is not None:
        for a, b, radius in LIMBS:
            ends = []
            for k in (a, b):
                jx, jy, jz = joints[k] * height
                ends.append((x + c * jx - s * jy + shear[0] * jz, y + s * jx + c * jy + shear[1] * jz))
            ex, ey = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
            out.append([*ends[0], ex, ey, 1 / max(1e-6, ex * ex + ey * ey), radius * height, 0.05 + 0.01 * height, 0.96, SUN])
    return out


def actor_shadows(actors: np.ndarray, ego: np.ndarray, light: Light, static: np.ndarray, builds: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Collect all shadows near the ground.

    Returns:
        Polygons (P, MAX_EDGES, 3), their info (P, 8) and capsules (K, 9), float32, as kernels.ground reads them.
    """
    shear = sun_shear(light.sun_direction) if light.sun_lx.sum() > 0 else None
    shapes: list[tuple[np.ndarray, np.ndarray]] = []
    capsules: list[list[float]] = []
    for actor in [*actors, ego]:
        if actor["kind"] == ActorKind.VEHICLE:
            shapes += _vehicle(actor, shear)
        else:
            capsules += _pedestrian(actor, shear, builds)
    polygons = np.array([s[0] for s in shapes], np.float32).reshape(-1, MAX_EDGES, 3)
    info = np.array([s[1] for s in shapes], np.float32).reshape(-1, 8)
    return polygons, info, np.concatenate([np.array(capsules).reshape(-1, 9), static]).astype(np.float32)
