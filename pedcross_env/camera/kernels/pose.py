"""Posing a walking or running body: one frame of axes per segment, from the phase and the length of its stride.

The feet lead and the legs follow by inverse kinematics, so that a foot on the ground stays where it is: in stance it moves
back under the body by exactly the way that the body goes. All lengths are shares of the body's height; the body's axes are x
ahead, y left, z up, with the origin on the ground.
"""

from __future__ import annotations

import math

from pedcross_env.camera.kernels.jit import INT, entry, kernel

__all__ = [
    "ANKLE_Z", "BUILD_SIZE", "B_RIDES", "CHEST", "CRANK", "CRANK_LENGTH", "PEDAL_Y", "FOREARM", "FRAMES", "GROUND", "HAND", "HEAD", "HELD", "LEG_STANDING", "NECK_Z", "PELVIS",
    "SHANK", "THIGH", "TOES", "FOOT", "UPPER_ARM", "duty_factor", "pose_body", "running_share",
]  # fmt: skip

# frames; a limb's frame starts at its upper joint and points up along it, the right limb's follows at + RIGHT
PELVIS, CHEST, HEAD, GROUND, HELD = 0, 1, 2, 3, 4
THIGH, SHANK, FOOT, TOES, UPPER_ARM, FOREARM, HAND = 5, 6, 7, 8, 9, 10, 11
# a bicycle's, in metres from the ground under its middle: hips over the saddle, the crank's axle and length, the pedals' distance
RIDING_HIP, CRANK, CRANK_LENGTH, PEDAL_Y = (-0.20, 0.99), (-0.08, 0.30), 0.165, 0.11
RIDING_LEAN = 0.62  # rad, of the trunk
RIGHT, FRAMES = 7, 19
# build: shares of the height (stoop and arm angles in rad)
(B_SHOULDER, B_HIP, B_HEAD, B_STOOP, B_THIGH, B_SHANK, B_SPREAD, B_VIGOUR, B_HOLD_L, B_UP_L, B_FLEX_L, B_HOLD_R, B_UP_R,
 B_FLEX_R, B_RIDES) = range(15)  # fmt: skip
BUILD_SIZE = 15

ANKLE_Z, HEEL_X, BALL_X = (
    0.039,
    0.035,
    0.075,
)  # ankle over the sole, behind it the heel, ahead the ball of the foot
TOE_OUT = 0.10  # rad
HEEL_UP = 0.72  # rad, at toe-off
UPPER_ARM_LENGTH, FOREARM_LENGTH = 0.180, 0.146  # Drillis and Contini
NECK_Z = 0.118  # from the crown down to the base of the neck, times the head's scale
HEAD_Z = 0.066  # from the crown down to the head's centre, times its scale
LEG_STANDING = 0.997  # of the stretched leg


@kernel
def _smooth(share):
    s = min(1.0, max(0.0, share))
    return s * s * (3.0 - 2.0 * s)


@kernel
def running_share(stride, height_m):
    """Return 0 walking, 1 running: by the Froude number v^2 / (g leg), where people change at about .5.

    With the walk ratio of ``scenario.walk.cadence_hz`` the speed is (stride height)^2 / (0.8 height).

    Args:
        stride: Length of a cycle as a share of the height.
        height_m: Body height.
    """
    froude = stride**4 * height_m / 3.33
    return _smooth((froude - 0.33) / 0.37)


@entry
def duty_factor(stride, height_m):
    """Return the share of the cycle that a foot is on the ground: .62 walking, below .5 (flight) running."""
    run = running_share(stride, height_m)
    return 0.62 - 0.25 * run - 0.08 * run * _smooth((stride - 1.1) / 0.6)


@kernel
def _axes(frames, k, x, y, z, pitch, yaw):
    """Set a frame: turned by ``yaw`` about its own upward axis, which leans ahead by ``pitch``."""
    c, s, cy, sy = math.cos(pitch), math.sin(pitch), math.cos(yaw), math.sin(yaw)
    f = frames[k]
    f[0, 0], f[0, 1], f[0, 2] = x, y, z
    f[1, 0], f[1, 1], f[1, 2] = c * cy, sy, -s * cy
    f[2, 0], f[2, 1], f[2, 2] = -c * sy, cy, s * sy
    f[3, 0], f[3, 1], f[3, 2] = s, 0.0, c


@kernel
def _bone(frames, k, x, y, z, dx, dy, dz):
    """Set a limb's frame that points down along (dx, dy, dz)."""
    norm = math.sqrt(dx * dx + dy * dy + dz * dz) + 1e-12
    f = frames[k]
    f[0, 0], f[0, 1], f[0, 2] = x, y, z
    zx, zy, zz = -dx / norm, -dy / norm, -dz / norm
    flat = math.sqrt(zx * zx + zz * zz) + 1e-12
    f[1, 0], f[1, 1], f[1, 2] = zz / flat, 0.0, -zx / flat  # level with the body's left axis
    f[2, 0], f[2, 1], f[2, 2] = -zy * zx / flat, flat, -zy * zz / flat
    f[3, 0], f[3, 1], f[3, 2] = zx, zy, zz


@kernel
def _foot(frames, first, side, u, duty, stride, centre, amount, run, vigour, foot_y):
    """Place a foot ``u`` cycles after the middle of its stance: ankle, foot and toes."""
    v = (u + 0.5 * duty) / duty  # 0 strike, 1 toe-off
    w = (u - 0.5 * duty) / (1.0 - duty) if u >= 0 else (u + 1.0 - 0.5 * duty) / (1.0 - duty)
    lift = heel_up = toe_up = follow = 0.0
    if 0.0 <= v <= 1.0:
        x = -stride * u
        heel_up, toe_up = _smooth((v - 0.42) / 0.58), 1.0 - _smooth(v / 0.22)
    else:  # swing: leaves and meets the ground moving back
        reach, slope = 0.5 * stride * duty, -stride * (1.0 - duty) * (0.7 - 0.35 * run)
        x = reach * (2.0 * w * w * (3.0 - 2.0 * w) - 1.0) + slope * w * (1.0 - w) * (1.0 - 2.0 * w)
        heel_up, toe_up = 1.0 - _smooth(w / 0.55), _smooth((w - 0.5) / 0.45)
        follow = _smooth(w / 0.3)
        lift = 28.94 * w * w * (1.0 - w) ** 3 * vigour
    heel = amount * vigour * (HEEL_UP + 0.35 * run) * heel_up
    toe = amount * vigour * 0.34 * (1.0 - 0.6 * run) * toe_up
    ch, sh, ct, st = math.cos(heel), math.sin(heel), math.cos(toe), math.sin(toe)
    out = side * TOE_OUT
    ball, back = BALL_X * math.cos(out), HEEL_X * math.cos(out)  # the ankle turns about the one or the other
    ax = centre + x + ball * (1.0 - ch) + ANKLE_Z * sh - back * (1.0 - ct) - ANKLE_Z * st
    az = ANKLE_Z + ball * sh - ANKLE_Z * (1.0 - ch) + back * st - ANKLE_Z * (1.0 - ct)
    az += lift * (0.022 * amount + 0.15 * run)
    _axes(frames, first + FOOT - THIGH, ax, foot_y, az, heel - toe, out)
    f = frames[first + FOOT - THIGH]
    bx, bz = BALL_X, -ANKLE_Z
    _axes(
        frames, first + TOES - THIGH, ax + bx * f[1, 0] + bz * f[3, 0], foot_y + bx * f[1, 1] + bz * f[3, 1],
        az + bx * f[1, 2] + bz * f[3, 2], heel * follow - toe, out,
    )  # fmt: skip


@kernel
def _leg(frames, first, hip_x, hip_y, hip_z, thigh, shank):
    """Bend hip and knee so that the leg ends at its foot."""
    f = frames[first + FOOT - THIGH]
    dx, dz = f[0, 0] - hip_x, f[0, 2] - hip_z
    d = min(math.sqrt(dx * dx + dz * dz), (thigh + shank) * 0.9999)
    inner = (thigh * thigh + d * d - shank * shank) / (2.0 * thigh * d)
    angle = math.atan2(dx, -dz) + math.acos(min(1.0, max(-1.0, inner)))
    kx, kz = hip_x + thigh * math.sin(angle), hip_z - thigh * math.cos(angle)
    ky = hip_y + (f[0, 1] - hip_y) * 0.5
    _bone(frames, first, hip_x, hip_y, hip_z, kx - hip_x, ky - hip_y, kz - hip_z)
    _bone(frames, first + SHANK - THIGH, kx, ky, kz, f[0, 0] - kx, f[0, 1] - ky, f[0, 2] - kz)


@kernel
def _arm(frames, first, x, y, z, side, angle, flex, spread):
    """Hang an arm from its shoulder: upper arm ``angle`` ahead of down, elbow bent by ``flex``."""
    dx, dy, dz = math.sin(angle), side * math.sin(spread), -math.cos(angle)
    _bone(frames, first, x, y, z, dx, dy, dz)
    f = frames[first]
    ex = f[0, 0] - UPPER_ARM_LENGTH * f[3, 0]
    ey, ez = f[0, 1] - UPPER_ARM_LENGTH * f[3, 1], f[0, 2] - UPPER_ARM_LENGTH * f[3, 2]
    fore = angle + flex
    dx, dy, dz = math.sin(fore), -side * 0.10 * math.sin(flex), -math.cos(fore)
    _bone(frames, first + 1, ex, ey, ez, dx, dy, dz)
    f = frames[first + 1]
    wx = f[0, 0] - FOREARM_LENGTH * f[3, 0]
    wy, wz = f[0, 1] - FOREARM_LENGTH * f[3, 1], f[0, 2] - FOREARM_LENGTH * f[3, 2]
    _bone(frames, first + 2, wx, wy, wz, math.sin(fore + 0.08), 0.3 * dy, -math.cos(fore + 0.08))


@kernel
def _hip_height(stride, turn, run, duty, centre, amount, vigour, leg):
    """Height of the hips that lets both feet reach the ground: up in mid-stance walking, down in mid-stance running."""
    strike = 0.5 * stride * duty + centre - 0.012 + 0.016 * run
    long = (0.994 - 0.012 * run) * leg
    ahead = math.sqrt(max(0.02, long * long - strike * strike)) + ANKLE_Z + 0.006
    heel = amount * vigour * (HEEL_UP + 0.35 * run)
    c, s = math.cos(heel), math.sin(heel)
    leave = 0.5 * stride * duty - centre - BALL_X * (1.0 - c) - ANKLE_Z * s
    behind = math.sqrt(max(0.02, long * long - leave * leave)) + ANKLE_Z * c + BALL_X * s
    reach = min(ahead, behind) - 0.006 * amount
    high = ANKLE_Z + leg * (LEG_STANDING - 0.008 * min(1.0, 2.0 * stride))
    dip = max(0.0, high - reach) / 0.88
    bounce = 0.018
    walking = high - 0.5 * dip + 0.5 * dip * math.cos(2.0 * turn)
    sprung = min(reach, high - 0.01) - 0.6 * bounce - bounce * math.cos(2.0 * turn)
    return walking + (sprung - walking) * run


@entry
def pose_body(phase, stride_m, head_yaw, height_m, build, frames):
    """Fill the frames of all segments.

    Args:
        phase: Walking cycles; the left foot is in the middle of its stance at a half, the right one at whole numbers.
            Turns of the crank for who rides a bicycle; the left pedal is up at whole numbers.
        stride_m: Length of one cycle, 0 standing.
        head_yaw: Relative to the body, rad.
        height_m: Body height.
        build: (BUILD_SIZE,) proportions, see the B_* columns.
        frames: (FRAMES, 4, 3) origin, x, y and z axis of each segment, filled.
    """
    if build[B_RIDES] > 0.0:
        _ride(phase, head_yaw, height_m, build, frames)
        return
    stride = stride_m / height_m
    run, duty = running_share(stride, height_m), duty_factor(stride, height_m)
    amount = _smooth(stride / 0.6)
    turn = 2.0 * math.pi * phase
    swing = math.sin(turn)
    leg, vigour = build[B_THIGH] + build[B_SHANK], build[B_VIGOUR]
    standing = ANKLE_Z + LEG_STANDING * leg
    centre = -0.05 * amount
    hip_z = _hip_height(stride, turn, run, duty, centre, amount, vigour, leg)
    sway = -0.012 * amount * math.cos(turn)
    foot_y = build[B_HIP] * (1.0 - 0.35 * amount - 0.25 * run)
    turned = 0.10 * amount * swing  # the pelvis brings the leading hip forward, the shoulders go against it
    _axes(frames, INT(GROUND), 0.0, 0.0, 0.0, 0.0, 0.0)
    lean = build[B_STOOP] + 0.03 * amount + 0.13 * run
    _axes(frames, INT(PELVIS), 0.0, sway, hip_z, 0.5 * lean, -turned)
    for k in range(2):
        side, first = 1.0 - 2.0 * k, THIGH + RIGHT * k
        u = phase + 0.5 * k
        u -= math.floor(u) + 0.5
        _foot(frames, first, side, u, duty, stride, centre, amount, run, vigour, side * foot_y)
        hip_x, hip_y = side * turned * build[B_HIP], sway + side * build[B_HIP]
        _leg(frames, first, hip_x, hip_y, hip_z, build[B_THIGH], build[B_SHANK])
    _trunk(frames, swing, run, amount, head_yaw, build, standing, hip_z, sway, lean)


@kernel
def _ride(phase, head_yaw, height_m, build, frames):
    """Sit on a bicycle: hips on the saddle, feet on the pedals, arms reaching ahead."""
    hip_x, hip_z = RIDING_HIP[0] / height_m, RIDING_HIP[1] / height_m
    _axes(frames, GROUND, 0.0, 0.0, 0.0, 0.0, 0.0)
    _axes(frames, PELVIS, 0.0, 0.0, hip_z, 0.5 * RIDING_LEAN, 0.0)
    for k in range(2):
        side, first = 1.0 - 2.0 * k, THIGH + RIGHT * k
        turn = 2.0 * math.pi * (phase + 0.5 * k)
        # the ball of the foot is on the pedal, its heel lower on the way down
        px = (CRANK[0] + CRANK_LENGTH * math.sin(turn)) / height_m - hip_x
        pz = (CRANK[1] + CRANK_LENGTH * math.cos(turn) + 0.02) / height_m
        pitch = 0.20 - 0.20 * math.sin(turn)
        c, s, y = math.cos(pitch), math.sin(pitch), side * PEDAL_Y / height_m
        ax, az = px - BALL_X * c + ANKLE_Z * s, pz + BALL_X * s + ANKLE_Z * c
        _axes(frames, first + FOOT - THIGH, ax, y, az, pitch, 0.0)
        _axes(frames, first + TOES - THIGH, px, y, pz, pitch, 0.0)
        _leg(frames, first, 0.0, side * build[B_HIP], hip_z, build[B_THIGH], build[B_SHANK])
    standing = ANKLE_Z + LEG_STANDING * (build[B_THIGH] + build[B_SHANK])
    _trunk(frames, 0.0, 0.0, 0.0, head_yaw, build, standing, hip_z, 0.0, RIDING_LEAN)
    for f in range(FRAMES):
        if f != GROUND:
            frames[f, 0, 0] += hip_x


@kernel
def _trunk(frames, swing, run, amount, head_yaw, build, standing, hip_z, sway, lean):
    """Place chest, head and arms over the hips."""
    head, stoop = build[B_HEAD], build[B_STOOP]
    spine = (1.0 - NECK_Z * head - standing) / math.cos(0.75 * stoop)
    bend = 0.75 * lean
    neck_x, neck_z = spine * math.sin(bend), hip_z + spine * math.cos(bend)
    twist = -(0.12 + 0.14 * run) * amount * swing
    _axes(frames, INT(CHEST), neck_x, 0.8 * sway, neck_z, lean, -twist)
    rise = (NECK_Z - HEAD_Z) * head
    _axes(
        frames, INT(HEAD), neck_x + 0.014 + 0.5 * rise * math.sin(lean), 0.7 * sway, neck_z + rise, 0.15 * lean, head_yaw
    )  # fmt: skip
    chest = frames[CHEST]
    for k in range(2):
        side, first = 1.0 - 2.0 * k, UPPER_ARM + RIGHT * k
        hold, up, bent = build[B_HOLD_L + 3 * k], build[B_UP_L + 3 * k], build[B_FLEX_L + 3 * k]
        ahead = -side * swing
        angle = 0.04 + amount * (0.36 + 0.30 * run) * ahead - 0.12 * run
        flex = 0.16 + 0.14 * amount + 1.25 * run + amount * (0.16 + 0.15 * run) * ahead
        angle, flex = angle + hold * (up - angle), flex + hold * (bent - flex)
        out = side * build[B_SHOULDER]
        x = chest[0, 0] + out * chest[2, 0] - 0.040 * chest[3, 0]
        y = chest[0, 1] + out * chest[2, 1] - 0.040 * chest[3, 1]
        z = chest[0, 2] + out * chest[2, 2] - 0.040 * chest[3, 2]
        _arm(frames, first, x, y, z, side, angle, flex, build[B_SPREAD])
    hand = frames[HAND]
    palm = 0.045
    _axes(
        frames, INT(HELD), hand[0, 0] - palm * hand[3, 0], hand[0, 1] - palm * hand[3, 1], hand[0, 2] - palm * hand[3, 2],
        0.10, 0.0,
    )  # fmt: skip
