"""Posing a walking body: joints from the phase and the length of its stride."""

from __future__ import annotations

import math

from pedcross_env.camera.kernels.jit import kernel

__all__ = ["BODY_JOINTS", "pose_body"]

BODY_JOINTS = 28
THIGH, SHANK, ANKLE = 0.245, 0.246, 0.039  # shares of the height (Drillis and Contini)


@kernel
def _set(joints, k, x, y, z):
    joints[k, 0], joints[k, 1], joints[k, 2] = x, y, z


@kernel
def _leg(joints, first, side, hip_y, lift, angle, knee):
    """Hip, knee, ankle, toe from the hip angle (forward positive) and the knee's flexion."""
    kx, kz = THIGH * math.sin(angle), lift - THIGH * math.cos(angle)
    shin = angle - knee
    ax, az = kx + SHANK * math.sin(shin), kz - SHANK * math.cos(shin)
    foot = shin * 0.55  # the foot follows the shin partly
    _set(joints, first, 0.0, side * hip_y, lift)
    _set(joints, first + 1, kx, side * hip_y, kz)
    _set(joints, first + 2, ax - 0.012, side * hip_y, az - 0.012)
    _set(
        joints,
        first + 3,
        ax + 0.088 * math.cos(foot),
        side * hip_y * 1.15,
        az - 0.019 + 0.088 * math.sin(foot),
    )


@kernel
def pose_body(phase, stride_m, head_yaw, height_m, build, joints):
    """Fill the joints in body axes (x ahead, y left, z up), in shares of the height.

    The hip swings as sin(2 pi phase) with the amplitude that the stride needs; the knee bends in swing; the pelvis is as
    high as the longer leg allows, so that a foot is always on the ground.

    Args:
        phase: Walking cycles.
        stride_m: Length of one cycle, 0 standing.
        head_yaw: Relative to the body, rad.
        height_m: Body height.
        build: (shoulder half width, hip half width, head scale, stoop), shares of the height; stoop in rad.
        joints: (BODY_JOINTS, 3), filled.
    """
    leg = (THIGH + SHANK) * height_m
    swing = math.asin(min(0.62, 0.25 * stride_m / leg)) * 1.08
    turn = 2 * math.pi * phase
    bend = min(1.0, swing / 0.35)
    left, right = swing * math.sin(turn), -swing * math.sin(turn)
    rise_l, rise_r = max(0.0, math.cos(turn)), max(0.0, -math.cos(turn))
    knee_l, knee_r = 0.06 * bend + 1.0 * bend * rise_l * rise_l, 0.06 * bend + 1.0 * bend * rise_r * rise_r
    reach_l = THIGH * math.cos(left) + SHANK * math.cos(left - knee_l)
    reach_r = THIGH * math.cos(right) + SHANK * math.cos(right - knee_r)
    hip = max(reach_l, reach_r) + ANKLE
    shoulder, hip_y, head_size, stoop = build
    _leg(joints, 8, 1.0, hip_y, hip, left + 0.03 * bend, knee_l)
    _leg(joints, 15, -1.0, hip_y, hip, right + 0.03 * bend, knee_r)
    lean = stoop + 0.10 * swing
    c, s = math.cos(lean), math.sin(lean)
    twist = 0.22 * swing * math.sin(turn)  # shoulders against the hips
    _set(joints, 0, 0.0, 0.0, hip + 0.02)
    _set(joints, 1, 0.20 * s, 0.0, hip + 0.20 * c)
    neck_x, neck_z = 0.305 * s, hip + 0.305 * c
    _set(joints, 2, neck_x, 0.0, neck_z)
    top = hip + 0.47 * c - 0.0485  # crown of the hair is at the full height when standing upright
    head_x = neck_x + 0.03 * s
    hc, hs = math.cos(head_yaw), math.sin(head_yaw)
    chin = top - 0.048 * head_size
    _set(joints, 3, head_x + 0.018 * hc, 0.018 * hs, chin)
    _set(joints, 4, head_x + 0.004 * hc, 0.004 * hs, top - 0.004)
    joints[4, 2] = top
    _set(joints, 23, head_x - 0.016 * hc, -0.016 * hs, top - 0.032)
    for side in (1.0, -1.0):
        base = 5 if side > 0 else 12
        arm = -0.85 * (left if side > 0 else right)
        sx, sz = 0.285 * s - side * 0.5 * twist * shoulder, hip + 0.283 * c
        _set(joints, base, sx, side * (shoulder - 0.012), sz)
        ex, ez = sx + 0.18 * math.sin(arm), sz - 0.18 * math.cos(arm)
        _set(joints, base + 1, ex, side * (shoulder + 0.012), ez)
        fore = arm + 0.25 + 0.45 * max(0.0, arm) + 0.15 * bend
        wx, wz = ex + 0.145 * math.sin(fore), ez - 0.145 * math.cos(fore)
        _set(joints, base + 2, wx, side * (shoulder + 0.008), wz)
        _set(
            joints,
            24 if side > 0 else 25,
            wx + 0.05 * math.sin(fore),
            side * shoulder,
            wz - 0.05 * math.cos(fore),
        )
        _set(joints, 19 if side > 0 else 20, 0.01, side * 0.038, hip + 0.03)
        _set(joints, 21 if side > 0 else 22, 0.23 * s, side * 0.052, hip + 0.225 * c)
    _set(joints, 26, 0.10 * s - 0.085, 0.0, hip + 0.11 * c)
    _set(joints, 27, 0.23 * s - 0.085, 0.0, hip + 0.23 * c)
