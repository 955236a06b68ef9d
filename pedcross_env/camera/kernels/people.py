"""Drawing a pedestrian: capsules that hang on the frames of its posed body."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.capsules import draw_capsule
from pedcross_env.camera.kernels.jit import INT, allocating_kernel, entry, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM_POSITION,
    ENV_BEAM_TINT,
    ENV_BETA,
    ENV_SUN,
    ENV_SUN_DIRECTION,
    head_irradiance,
    light_field,
)
from pedcross_env.camera.kernels.pose import FRAMES, pose_body

__all__ = ["MAX_BODY", "PART_SIZE", "draw_pedestrian", "people_work", "retro_coefficient"]

MAX_BODY = 80  # capsules of one person with all that it wears and carries
# a part: frame, x, y, z of either end, radius at either end (shares of the height), albedo r, g, b, cd/(lx m2) of retro-reflection at
# 0.2 degrees, pixels per body height below which it is left out
P_RADIUS, P_ALBEDO, P_RETRO, P_FINE, PART_SIZE = 8, 10, 13, 14, 15
LUMA_R, LUMA_G, LUMA_B = 0.2126, 0.7152, 0.0722
FEET_Z, HEAD_Z = 0.1, 0.9


@allocating_kernel
def people_work():
    """Allocate what ``draw_pedestrian`` works in."""
    return (
        np.empty((FRAMES, 4, 3)), np.empty((FRAMES, 4, 3)), (np.empty(3), np.empty(3)), np.empty((2, 3, 4)),
    )  # fmt: skip


@entry
def retro_coefficient(at_small, angle):
    """Coefficient of retro-reflection at an observation angle (rad), cd/(lx m2).

    Falls as the minimum for separate retro-reflective material in ISO 20471 (table 5, 5 degrees entrance): 330 at 12',
    250 at 20', 25 at 1 degree, 10 at 1.5 degrees; straight lines in logarithms between and beyond.

    Args:
        at_small: Value up to 12'.
        angle: Between the lamp and the eye, seen from the material, rad.
    """
    minutes = max(12.0, angle * (180.0 * 60.0 / math.pi))
    if minutes < 20.0:
        return at_small * (minutes / 12.0) ** -0.5435
    if minutes < 60.0:
        return at_small * 0.75758 * (minutes / 20.0) ** -2.0959
    return at_small * 0.075758 * (minutes / 60.0) ** -2.2598


@kernel
def _observation_angle(point, env):
    """Angle between the ego's lamp and the camera (the origin), seen from a point."""
    dot = lamp2 = eye2 = 0.0
    for k in range(3):
        to_lamp = env[ENV_BEAM_POSITION + k] - point[k]
        dot -= to_lamp * point[k]
        lamp2 += to_lamp * to_lamp
        eye2 += point[k] * point[k]
    return math.acos(min(1.0, max(-1.0, dot / math.sqrt(lamp2 * eye2 + 1e-12))))


@kernel
def _into_camera(actor, frames, rotation, camera, out):
    """Turn the body's frames into camera coordinates, their axes as long as the body is tall."""
    c, s, height = math.cos(actor[3]), math.sin(actor[3]), actor[8]
    for f in range(FRAMES):
        for a in range(4):
            x, y, z = frames[f, a, 0] * height, frames[f, a, 1] * height, frames[f, a, 2] * height
            wx, wy, wz = c * x - s * y, s * x + c * y, z
            if a == 0:
                wx, wy, wz = wx + actor[0] - camera[0], wy + actor[1] - camera[1], wz + actor[2] - camera[2]
            for k in range(3):
                out[f, a, k] = rotation[k, 0] * wx + rotation[k, 1] * wy + rotation[k, 2] * wz


@kernel
def _at(frame, part, first, out):
    for k in range(3):
        out[k] = (
            frame[0, k]
            + part[first] * frame[1, k]
            + part[first + 1] * frame[2, k]
            + part[first + 2] * frame[3, k]
        )


@kernel
def _light_part(part, p0, p1, share, env, fields, table, work):
    """Fill the radiance coefficients of one capsule; see capsules.draw_capsule."""
    middle, light, heads, head = work[0], work[2], work[3], work[5]
    channels = light.shape[0]
    beta = env[ENV_BETA]
    head0, head1 = head_irradiance(p0, env, table, beta), head_irradiance(p1, env, table, beta)
    retro = 0.0
    away = 1e-9
    for k in range(3):
        middle[k] = 0.5 * (p0[k] + p1[k])
        away += (env[ENV_BEAM_POSITION + k] - middle[k]) ** 2
    if part[P_RETRO] > 0.0 and head0 + head1 > 0.0:
        retro = 0.5 * (head0 + head1) * retro_coefficient(part[P_RETRO], _observation_angle(middle, env))
    for c in range(channels):
        for k in range(6):
            light[c, k] = 0
        heads[c, 0] = heads[c, 1] = 0
    for c in range(3):
        weight = 1.0 if channels == 3 else (LUMA_R, LUMA_G, LUMA_B)[c]
        rho = weight * part[P_ALBEDO + c] / math.pi
        o = c if channels == 3 else 0
        for k in range(4):
            light[o, k] += rho * (fields[0, c, k] + share * (fields[1, c, k] - fields[0, c, k]))
        light[o, 4] += rho * env[ENV_SUN + c]
        light[o, 5] += weight * retro * env[ENV_BEAM_TINT + c]
        heads[o, 0] += rho * head0 * env[ENV_BEAM_TINT + c]
        heads[o, 1] += rho * (head1 - head0) * env[ENV_BEAM_TINT + c]
    for k in range(3):
        head[k] = (env[ENV_BEAM_POSITION + k] - middle[k]) / math.sqrt(away)


@kernel
def draw_pedestrian(
    actor,
    build,
    body,
    rotation,
    camera,
    env,
    lamps,
    beams,
    table,
    optics,
    size,
    scratch,
    free,
    work,
    people,
    spans,
):
    """Draw one pedestrian into its object's scratch planes.

    Args:
        actor: (14,) as kernels.scene.
        build: (BUILD_SIZE,) as kernels.pose.
        body: (MAX_BODY, PART_SIZE) parts, up to the first without radius.
        rotation: (3, 3) world to camera.
        camera: (3,) its position.
        env: (ENV_SIZE,) see kernels.lighting.
        lamps: (L, 3) camera coordinates.
        beams: (B, 13) others' low beams.
        table: Candela of the ego's and of others' beams.
        optics: (focal, cx, cy).
        size: (height, width).
        scratch: (planes (C, H, W), alpha, inverse depth).
        free: (H, W) twice, work space, see ``draw_capsule``.
        work: Work space of a capsule, see kernels.scene.
        people: From ``people_work``.
        spans: What the object covers, extended.
    """
    frames, seen, ends, fields = people
    height = actor[8]
    pose_body(actor[9], actor[10], actor[11], height, build, frames)
    _into_camera(actor, frames, rotation, camera, seen)
    middle = work[0]
    # street lamps change little over a body: lit at two heights, between them in proportion
    for level in range(2):
        for k in range(3):
            middle[k] = seen[3, 0, k] + (HEAD_Z if level else FEET_Z) * seen[3, 3, k]
        light_field(middle, env, lamps, beams, table, fields[level])
    tall_px = optics[0] * height / max(0.1, middle[2])
    for k in range(3):
        work[4][k] = env[ENV_SUN_DIRECTION + k]
    p0, p1 = ends
    # always in the same order: a change of order could be seen where three parts meet
    for m in range(body.shape[0]):
        if body[m, P_RADIUS] <= 0.0:
            break
        if tall_px <= body[m, P_FINE]:
            continue
        _at(seen[int(body[m, 0])], body[m], INT(1), p0)
        _at(seen[int(body[m, 4])], body[m], INT(5), p1)
        part = body[m]
        grown = height
        if part[P_FINE] > 0.0:  # fine parts grow out of the body as it comes near
            grown *= min(1.0, tall_px / part[P_FINE] - 1.0)
        high = 0.0
        for k in range(3):
            high += (0.5 * (p0[k] + p1[k]) - seen[3, 0, k]) * seen[3, 3, k]
        share = min(1.0, max(0.0, (high / (height * height) - FEET_Z) / (HEAD_Z - FEET_Z)))
        _light_part(part, p0, p1, share, env, fields, table, work)
        draw_capsule(
            p0, p1, part[P_RADIUS] * grown, part[P_RADIUS + 1] * grown, work[2], work[3], work[4], work[5], optics, size,
            scratch, free, work[6], spans,
        )  # fmt: skip
