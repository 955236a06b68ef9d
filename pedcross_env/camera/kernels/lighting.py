"""Irradiance at a point and the radiance of a surface there, in camera coordinates.

Sun and the ego's beam keep their clamped cosine; sky, street lamps and others' beams enter as a constant and a
gradient over the normal, WRAP (1 + n.d): never negative, so that it stays linear, and smooth when things move. ``env`` is the vector of ENV_* offsets.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel

__all__ = [
    "ENV_AIR", "ENV_BEAM", "ENV_BEAM_AXES", "ENV_BEAM_POSITION", "ENV_BEAM_TINT", "ENV_BETA", "ENV_BOUNCE", "ENV_LAMP",
    "ENV_SIZE", "ENV_SKY", "ENV_SNOW", "ENV_SUN", "ENV_SUN_DIRECTION", "ENV_UP", "ENV_WET", "ENV_WINDOW", "ENV_ZENITH",
    "beam_candela", "face_radiance", "head_irradiance", "lamp_candela", "light_field", "sky_radiance",
]  # fmt: skip

ENV_SUN_DIRECTION, ENV_UP, ENV_SUN, ENV_SKY, ENV_BOUNCE = 0, 3, 6, 9, 12
ENV_AIR, ENV_ZENITH, ENV_LAMP, ENV_WINDOW, ENV_BETA, ENV_BEAM = 15, 18, 21, 24, 27, 28
ENV_BEAM_TINT, ENV_BEAM_POSITION, ENV_BEAM_AXES, ENV_WET, ENV_SNOW, ENV_SIZE = 29, 32, 35, 44, 45, 46

WRAP = 0.45
SNOW = (0.76, 0.78, 0.80)  # albedo of lying snow: camera.snow.SNOW_ALBEDO
FLAT, LEVEL = 0.25, 0.65  # upward part of a normal from which snow begins to lie, and lies whole
H0, H1, V0, V1 = -0.9, 0.9, -0.35, 0.25  # of the beam table: light.BEAM_TAN_H, BEAM_TAN_V


@entry
def beam_candela(table, tan_left, tan_up):
    """Bilinear look-up of a beam table; 0 outside."""
    rows, columns = table.shape
    p = (tan_left - H0) * ((columns - 1) / (H1 - H0))
    q = (tan_up - V0) * ((rows - 1) / (V1 - V0))
    if not (0 <= p < columns - 1 and 0 <= q < rows - 1):
        return 0.0
    s, t = q - int(q), p - int(p)
    i, j, one = (
        np.uint64(q),
        np.uint64(p),
        np.uint64(1),
    )  # unsigned: numba lets a negative index count from the end
    low = table[i, j] + t * (table[i, j + one] - table[i, j])
    high = table[i + one, j] + t * (table[i + one, j + one] - table[i + one, j])
    return low + s * (high - low)


@entry
def lamp_candela(cosine_down):
    """Return a street lamp's intensity over the cosine to the nadir: batwing, nothing above 85 degrees."""
    c = min(1.0, max(0.0, cosine_down))
    edge = min(1.0, max(0.0, (c - 0.08) / 0.25))
    return 380.0 * (1.0 + 2.2 * (1.0 - c * c)) * edge * edge * (3.0 - 2.0 * edge)


@kernel
def _beam_at(table, beam, x, y, z):
    """Illuminance at normal incidence from a beam (position, forward, left, up: 12 numbers) and the direction to it."""
    dx, dy, dz = x - beam[0], y - beam[1], z - beam[2]
    forward = dx * beam[3] + dy * beam[4] + dz * beam[5]
    if forward < 0.05:
        return 0.0
    left = dx * beam[6] + dy * beam[7] + dz * beam[8]
    up = dx * beam[9] + dy * beam[10] + dz * beam[11]
    squared = dx * dx + dy * dy + dz * dz
    return beam_candela(table, left / forward, up / forward) / max(squared, 0.25)


@kernel
def head_irradiance(point, env, table, beta):
    """Illuminance at normal incidence from the ego's own beam, dimmed by the fog on its way."""
    if env[ENV_BEAM] == 0.0:
        return 0.0
    e = _beam_at(table[0], env[ENV_BEAM_POSITION : ENV_BEAM_POSITION + 12], point[0], point[1], point[2])
    return e * math.exp(-beta * max(0.0, point[2]))


@kernel
def light_field(point, env, lamps, beams, table, field):
    """Fill (3, 4): constant and gradient (camera x, y, z) of the irradiance over the normal, per channel."""
    for c in range(3):
        sky, bounce = env[ENV_SKY + c], env[ENV_BOUNCE + c]
        field[c, 0] = 0.5 * (sky + bounce)
        for k in range(3):
            field[c, 1 + k] = 0.5 * (sky - bounce) * env[ENV_UP + k]
    for i in range(lamps.shape[0]):
        dx, dy, dz = lamps[i, 0] - point[0], lamps[i, 1] - point[1], lamps[i, 2] - point[2]
        squared = max(dx * dx + dy * dy + dz * dz, 0.25)
        if squared > 3600.0:
            continue
        r = math.sqrt(squared)
        down = (dx * env[ENV_UP] + dy * env[ENV_UP + 1] + dz * env[ENV_UP + 2]) / r
        e = lamp_candela(down) / squared
        for c in range(3):
            tint = e * env[ENV_LAMP + c]
            field[c, 0] += WRAP * tint
            field[c, 1] += WRAP * tint * dx / r
            field[c, 2] += WRAP * tint * dy / r
            field[c, 3] += WRAP * tint * dz / r
    for i in range(beams.shape[0]):
        e = beams[i, 12] * _beam_at(table[1], beams[i], point[0], point[1], point[2])
        if e <= 0.0:
            continue
        dx, dy, dz = beams[i, 0] - point[0], beams[i, 1] - point[1], beams[i, 2] - point[2]
        r = math.sqrt(max(dx * dx + dy * dy + dz * dz, 0.25))
        for c in range(3):
            tint = e * env[ENV_BEAM_TINT + c]
            field[c, 0] += WRAP * tint
            field[c, 1] += WRAP * tint * dx / r
            field[c, 2] += WRAP * tint * dy / r
            field[c, 3] += WRAP * tint * dz / r


@entry
def sky_radiance(sine, env, c):
    """Sky radiance over the sine of the elevation (0 horizon, 1 zenith)."""
    s = min(1.0, max(0.0, sine))
    w = s * (2.0 - s)
    w = w * (2.0 - w) * 0.75 + 0.25 * w
    return env[ENV_AIR + c] + (env[ENV_ZENITH + c] - env[ENV_AIR + c]) * w


@kernel
def face_radiance(point, normal, albedo, gloss, env, field, head, out):
    """Fill (3,): diffuse radiance E rho / pi and the glossy reflection of sky or ground on a flat face, snow lying on it.

    Glass (dark and glossy) is kept free of snow.
    """
    snow = 0.0
    if env[ENV_SNOW] > 0.0 and not (gloss > 0.9 and albedo[0] + albedo[1] + albedo[2] < 0.05):
        upright = normal[0] * env[ENV_UP] + normal[1] * env[ENV_UP + 1] + normal[2] * env[ENV_UP + 2]
        snow = env[ENV_SNOW] * min(1.0, max(0.0, (upright - FLAT) / (LEVEL - FLAT)))
    sun = max(0.0, normal[0] * env[0] + normal[1] * env[1] + normal[2] * env[2])
    r = math.sqrt(point[0] ** 2 + point[1] ** 2 + point[2] ** 2) + 1e-9
    towards = -(point[0] * normal[0] + point[1] * normal[1] + point[2] * normal[2]) / r
    towards = min(1.0, max(0.0, towards))
    sine = 0.0
    for k in range(3):
        sine += (point[k] / r + 2.0 * towards * normal[k]) * env[ENV_UP + k]
    upward = min(1.0, max(0.0, 0.5 + 3.0 * sine))
    fresnel = (1.0 - snow) * gloss * (0.05 + 0.95 * (1.0 - towards) ** 5)
    for c in range(3):
        e = field[c, 0] + field[c, 1] * normal[0] + field[c, 2] * normal[1] + field[c, 3] * normal[2]
        e += env[ENV_SUN + c] * sun + env[ENV_BEAM_TINT + c] * head * towards
        below = env[ENV_BOUNCE + c] / math.pi
        mirrored = below + (sky_radiance(sine, env, c) - below) * upward
        out[c] = (albedo[c] + snow * (SNOW[c] - albedo[c])) * e / math.pi + fresnel * mirrored
