"""Shadows of actors on the ground: hulls of boxes and capsules, cast by the sun, contact shadows under them, and where each is seen."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import INT, allocating_kernel, entry, kernel
from pedcross_env.camera.kernels.pose import FRAMES, pose_body

__all__ = ["CAPSULES_PER_ACTOR", "MAX_EDGES", "POLYGONS_PER_ACTOR", "cast_shadows", "shadow_bounds"]

MAX_EDGES, POLYGONS_PER_ACTOR, CAPSULES_PER_ACTOR = 12, 4, 10
SUN, SKY = 0.0, 1.0
# limbs that cast: frame at whose origin either end is, radius as a share of the height (frames of kernels.pose)
LIMBS = np.array(
    [[5, 6, 0.045], [6, 7, 0.032], [12, 13, 0.045], [13, 14, 0.032], [0, 1, 0.088], [1, 2, 0.050], [2, 2, 0.055], [9, 11, 0.028],
     [16, 18, 0.028]]
)  # fmt: skip
# a vehicle's shadows: rows of (scale of the footprint, height share) pairs whose hull is cast; then softness, strength, target
CASTS = np.array(
    [
        [0.98, 0.0, 0.98, 0.0, 0.98, 0.0, 0.35, 0.85, SKY],
        [1.20, 0.0, 1.20, 0.0, 1.20, 0.0, 1.40, 0.45, SKY],
        [0.97, 0.12, 0.96, 0.62, 0.72, 0.97, 0.12, 0.96, SUN],
        [0.95, 0.0, 0.95, 0.0, 0.95, 0.0, 0.20, 0.96, SUN],
    ]
)


@kernel
def _cross(ox, oy, ax, ay, bx, by):
    return (ax - ox) * (by - oy) - (ay - oy) * (bx - ox)


@kernel
def hull_2d(points, count, order, out):
    """Convex hull of 2-D points (monotone chain); return its number of corners."""
    for i in range(count):
        order[i] = i
    for i in range(1, count):  # insertion sort: few points
        k = order[i]
        j = i - 1
        while j >= 0 and (
            points[order[j], 0] > points[k, 0]
            or (points[order[j], 0] == points[k, 0] and points[order[j], 1] > points[k, 1])
        ):
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = k
    n = 0
    for i in range(count):
        x, y = points[order[i], 0], points[order[i], 1]
        while n >= 2 and _cross(out[n - 2, 0], out[n - 2, 1], out[n - 1, 0], out[n - 1, 1], x, y) <= 0:
            n -= 1
        out[n, 0], out[n, 1] = x, y
        n += 1
    lower = n + 1
    for i in range(count - 2, -1, -1):
        x, y = points[order[i], 0], points[order[i], 1]
        while n >= lower and _cross(out[n - 2, 0], out[n - 2, 1], out[n - 1, 0], out[n - 1, 1], x, y) <= 0:
            n -= 1
        out[n, 0], out[n, 1] = x, y
        n += 1
    return n - 1


@allocating_kernel
def _vehicle(actor, shear, sunny, polygons, info, at):
    c, s = math.cos(actor[3]), math.sin(actor[3])
    points, ring, order = np.empty((12, 2)), np.empty((26, 2)), np.empty(12, np.int64)
    for k in range(CASTS.shape[0]):
        cast = CASTS[k]
        if cast[8] == SUN and not sunny:
            continue
        n = INT(0)
        for level in range(3):
            scale, rise = 0.5 * cast[2 * level], cast[2 * level + 1] * actor[8]
            for corner in range(4):
                x = actor[6] * scale * (1.0 if corner < 2 else -1.0)
                y = actor[7] * scale * (1.0 if corner % 2 == 0 else -1.0)
                points[n, 0] = actor[0] + c * x - s * y + shear[0] * rise
                points[n, 1] = actor[1] + s * x + c * y + shear[1] * rise
                n += 1
        m = min(hull_2d(points, n, order, ring), MAX_EDGES)
        soft = cast[6]
        box = info[at]
        box[0], box[1], box[2], box[3] = 1e9, -1e9, 1e9, -1e9
        for i in range(m):
            j = (i + 1) % m
            ex, ey = ring[j, 0] - ring[i, 0], ring[j, 1] - ring[i, 1]
            norm = math.sqrt(ex * ex + ey * ey) + 1e-12
            polygons[at, i, 0], polygons[at, i, 1] = -ey / norm, ex / norm
            polygons[at, i, 2] = (ey * ring[i, 0] - ex * ring[i, 1]) / norm
            box[0], box[1] = min(box[0], ring[i, 0] - soft), max(box[1], ring[i, 0] + soft)
            box[2], box[3] = min(box[2], ring[i, 1] - soft), max(box[3], ring[i, 1] + soft)
        box[4], box[5], box[6], box[7] = m, soft, cast[7], cast[8]
        at += 1
    return at


@allocating_kernel
def _pedestrian(actor, build, shear, sunny, capsules, at):
    c, s = math.cos(actor[3]), math.sin(actor[3])
    h = actor[8]
    contact = capsules[at]
    contact[0], contact[1] = actor[0] - 0.05 * c, actor[1] - 0.05 * s
    contact[2], contact[3], contact[4] = 0.1 * c, 0.1 * s, 100.0
    contact[5], contact[6], contact[7], contact[8] = 0.115 * h, 0.45, 0.55, SKY
    at += 1
    if not sunny:
        return at
    frames = np.empty((FRAMES, 4, 3))
    pose_body(actor[9], actor[10], actor[11], h, build, frames)
    for k in range(LIMBS.shape[0]):
        out = capsules[at]
        for e in range(2):
            j = frames[int(LIMBS[k, e]), 0]
            x = actor[0] + (c * j[0] - s * j[1] + shear[0] * j[2]) * h
            y = actor[1] + (s * j[0] + c * j[1] + shear[1] * j[2]) * h
            out[2 * e], out[2 * e + 1] = x - (out[0] if e else 0.0), y - (out[1] if e else 0.0)
        out[4] = 1 / max(1e-6, out[2] ** 2 + out[3] ** 2)
        out[5], out[6], out[7], out[8] = LIMBS[k, 2] * h, 0.05 + 0.01 * h, 0.96, SUN
        at += 1
    return at


@allocating_kernel
def cast_shadows(actors, kinds, builds, shear, sunny, polygons, info, count, capsules, capsule_count):
    """Fill the shadow tables that kernels.ground reads; return the numbers of polygons and capsules.

    Args:
        actors: (N, 14) as kernels.scene.
        kinds: (N,) ActorKind.
        builds: (N, BUILD_SIZE) as kernels.pose.
        shear: How far a shadow falls per metre of height, along x and y.
        sunny: Whether the sun casts shadows.
        polygons: (>= count + 4 N, MAX_EDGES, 3) float32, filled.
        info: (>= count + 4 N, 8) x range, y range, edges, softness, strength, target (0 sun, 1 sky).
        count: How many of ``polygons`` are filled already.
        capsules: (>= 10 N, 9) start, extent, 1 / length^2, radius, softness, strength, target; some may be filled.
        capsule_count: How many of ``capsules`` are filled already.
    """
    for i in range(actors.shape[0]):
        if kinds[i] == 1:
            count = _vehicle(actors[i], shear, sunny, polygons, info, count)
        else:
            capsule_count = _pedestrian(actors[i], builds[i], shear, sunny, capsules, capsule_count)
    return count, capsule_count


@entry
def shadow_bounds(polygon_info, capsules, rotation, camera, optics, size, out):
    """Fill (polygons + capsules, 4) int64: first and beyond-last row and column that each shadow can reach."""
    focal, cx, cy = optics
    count = polygon_info.shape[0]
    for k in range(out.shape[0]):
        if k < count:
            x0, x1, y0, y1 = polygon_info[k, 0], polygon_info[k, 1], polygon_info[k, 2], polygon_info[k, 3]
        else:
            s = capsules[k - count]
            reach = s[5] + s[6]
            x0, x1 = min(s[0], s[0] + s[2]) - reach, max(s[0], s[0] + s[2]) + reach
            y0, y1 = min(s[1], s[1] + s[3]) - reach, max(s[1], s[1] + s[3]) + reach
        u0, u1, v0, v1 = 1e9, -1e9, 1e9, -1e9
        for corner in range(4):
            here, there = corner, (corner + 1) % 4
            ax, ay = (x1 if here in (1, 2) else x0) - camera[0], (y1 if here >= 2 else y0) - camera[1]
            bx, by = (x1 if there in (1, 2) else x0) - camera[0], (y1 if there >= 2 else y0) - camera[1]
            az = rotation[2, 0] * ax + rotation[2, 1] * ay - rotation[2, 2] * camera[2]
            bz = rotation[2, 0] * bx + rotation[2, 1] * by - rotation[2, 2] * camera[2]
            near = 0.1
            for end in range(2):  # this corner, and where the edge passes the near plane
                px, py = ax, ay
                if end == 0:
                    if az < near:
                        continue
                elif (az < near) == (bz < near):
                    continue
                else:
                    t = (near - az) / (bz - az)
                    px, py = ax + t * (bx - ax), ay + t * (by - ay)
                z = max(near, rotation[2, 0] * px + rotation[2, 1] * py - rotation[2, 2] * camera[2])
                u = cx + focal * (rotation[0, 0] * px + rotation[0, 1] * py - rotation[0, 2] * camera[2]) / z
                v = cy + focal * (rotation[1, 0] * px + rotation[1, 1] * py - rotation[1, 2] * camera[2]) / z
                u0, u1, v0, v1 = min(u0, u), max(u1, u), min(v0, v), max(v1, v)
        # a pixel's footprint blurs by a pixel
        out[k, 0], out[k, 1] = max(0, int(max(v0, -9.0)) - 2), min(size[0], int(min(v1, size[0] + 9.0)) + 3)
        out[k, 2], out[k, 3] = max(0, int(max(u0, -9.0)) - 2), min(size[1], int(min(u1, size[1] + 9.0)) + 3)
