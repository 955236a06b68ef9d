"""Ground and sky for any rotation of the camera and any layout of the street.

Where kernels.ground takes a whole image row to lie at one place along a straight street, here every pixel is placed on the
ground by its own ray, with its footprint along the street's own axes: the running integrals are then read at both ends of it.
A footprint's two edges add as squares, which has the variance of their sheared product.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.ground import FAR_M, INV_PI, KERB, WHITE
from pedcross_env.camera.kernels.ground_light import beam_at, lamp_at
from pedcross_env.camera.kernels.jit import entry, inlined, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_AIR,
    ENV_BEAM,
    ENV_BEAM_POSITION,
    ENV_BEAM_TINT,
    ENV_BETA,
    ENV_LAMP,
    ENV_SKY,
    ENV_SUN,
    ENV_UP,
    ENV_WET,
    sky_radiance,
)  # fmt: skip
from pedcross_env.camera.kernels.rows import F0, F1, HALF, exp_minus, fill_row, free_row, settle_row
from pedcross_env.camera.kernels.street_profile import grain_of_row, ground_at, place_on_street

__all__ = ["draw_ground_and_sky_freely"]

# rows of the work space
SHARE, DEPTH, X, Y, XU, XV, YU, YV, SUN, SKY, LAMP, BEAM = range(12)
RED, COVER, MARKS, GRAIN, RADIANCE, PASSED, REST, FREE = 12, 15, 16, 17, 18, 19, 20, 22


@kernel
def _depth_row(base, slope, pixel, height, share, down, depth):
    """Depth of a row's pixels on the road: ``base + slope * column`` is how steeply their rays look down."""
    far = np.float32(FAR_M)
    for i in range(share.shape[0]):
        here = base + slope * np.float32(i)
        part = max(F0, min(F1, here / pixel + HALF))
        # on the horizon: the middle of what is below it
        here = max(np.float32(1e-7), here if here > HALF * pixel else HALF * (here + HALF * pixel))
        share[i] = part
        down[i] = here
        depth[i] = min(far, height / here)


@kernel
def _position_row(origin, base, slope, depth, out):
    for i in range(out.shape[0]):
        out[i] = origin + depth[i] * (base + slope * np.float32(i))


@kernel
def _step_row(own, up, base, slope, inv_focal, depth, down, out):
    """Change of a ground coordinate per pixel: by the ray's own turn, and by the depth's change along the ray."""
    for i in range(out.shape[0]):
        ray = base + slope * np.float32(i)
        out[i] = depth[i] * inv_focal * (own + up / down[i] * ray)


@kernel
def _place_row(rotation, camera, yn, optics, n, buf):
    """Place a row's pixels on the road's plane: share below the horizon, depth, x, y and their change per column and row."""
    focal, cx, _ = optics
    ux, uy, uz = rotation[0, 2], rotation[1, 2], rotation[2, 2]
    first, inv = (0.5 - cx) / focal, np.float32(1.0 / focal)
    depth, down = buf[DEPTH, :n], buf[REST, :n]
    _depth_row(
        np.float32(-(ux * first + uy * yn + uz)), np.float32(-ux / focal), np.float32((abs(ux) + abs(uy)) / focal),
        np.float32(camera[2]), buf[SHARE, :n], down, depth,
    )  # fmt: skip
    for k in range(2):
        base = np.float32(rotation[0, k] * first + rotation[1, k] * yn + rotation[2, k])
        slope = np.float32(rotation[0, k] / focal)
        _position_row(np.float32(camera[k]), base, slope, depth, buf[X + k, :n])
        for m in range(2):
            own, up = np.float32(rotation[m, k]), np.float32(rotation[m, 2])
            _step_row(own, up, base, slope, inv, depth, down, buf[XU + 2 * k + m, :n])


@inlined
def _smooth(cover):
    return cover * cover * (np.float32(3.0) - np.float32(2.0) * cover)


@kernel
def _polygon_shadow(shape, count, soft, strength, x, y, xu, xv, yu, yv, cover, out):
    """Darken ``out`` (share of light) under a convex polygon on the ground with soft edges."""
    fill_row(F1, cover)
    for k in range(count):
        a, b, c = shape[k, 0], shape[k, 1], shape[k, 2]
        for i in range(out.shape[0]):
            width = soft + abs(a * xu[i] + b * yu[i]) + abs(a * xv[i] + b * yv[i])
            cover[i] = min(cover[i], max(F0, min(F1, (a * x[i] + b * y[i] + c) / width + HALF)))
    for i in range(out.shape[0]):
        out[i] = min(out[i], F1 - strength * _smooth(cover[i]))


@kernel
def _capsule_shadow(shape, x, y, xu, xv, yu, yv, out):
    """Darken ``out`` under a capsule (ax, ay, bx-ax, by-ay, 1/len2, radius, soft, strength) on the ground."""
    ax, ay, ex, ey, inv, radius, soft, strength = (
        shape[0], shape[1], shape[2], shape[3], shape[4], shape[5], shape[6], shape[7],
    )  # fmt: skip
    for i in range(out.shape[0]):
        foot = HALF * (abs(xu[i]) + abs(xv[i]) + abs(yu[i]) + abs(yv[i]))
        # where a pixel is wider than the shape, its share of the pixel is what counts
        share = min(F1, np.float32(2.0) * radius / max(np.float32(1e-3), foot))
        dx, dy = x[i] - ax, y[i] - ay
        t = max(F0, min(F1, (dx * ex + dy * ey) * inv))
        px, py = dx - t * ex, dy - t * ey
        cover = max(F0, min(F1, (radius - np.sqrt(px * px + py * py)) / (soft + foot) + HALF))
        out[i] = min(out[i], F1 - share * strength * _smooth(cover))


@kernel
def _shadow_row(row, shadows, bounds, buf):
    """Apply all shadows that reach this row to the shares of sunlight and skylight."""
    polygons, info, capsules = shadows
    count = polygons.shape[0]
    for k in range(bounds.shape[0]):
        if row < bounds[k, 0] or row >= bounds[k, 1]:
            continue
        a, b = bounds[k, 2], bounds[k, 3]
        if b <= a:
            continue
        x, y, xu, xv, yu, yv = (
            buf[X, a:b],
            buf[Y, a:b],
            buf[XU, a:b],
            buf[XV, a:b],
            buf[YU, a:b],
            buf[YV, a:b],
        )
        if k < count:
            out = buf[SUN, a:b] if info[k, 7] == 0 else buf[SKY, a:b]
            _polygon_shadow(
                polygons[k],
                int(info[k, 4]),
                info[k, 5],
                info[k, 6],
                x,
                y,
                xu,
                xv,
                yu,
                yv,
                buf[REST, a:b],
                out,
            )
        else:
            s = capsules[k - count]
            out = buf[SUN, a:b] if s[8] == 0 else buf[SKY, a:b]
            _capsule_shadow(s, x, y, xu, xv, yu, yv, out)


@kernel
def _light_row(lights, env, yn, optics, xs, a, b, buf):
    """Illuminance of a row of ground from street lamps and headlights: smooth, so that every fourth pixel is computed."""
    lamp_map, lamp_frame, beams, table = lights
    focal, cx, _ = optics
    up = env[ENV_UP : ENV_UP + 3]
    own = env[ENV_BEAM_POSITION : ENV_BEAM_POSITION + 12]
    lamps_on, beams_on = env[ENV_LAMP] > 0, env[ENV_BEAM] > 0
    lamp, beam = buf[LAMP], buf[BEAM]
    i, last_lamp, last_beam = a - 1, F0, F0
    while i < b - 1:
        j = min(i + 4, b - 1) if i >= a else a
        now_lamp, light = F0, 0.0
        if lamps_on:
            now_lamp = np.float32(lamp_at(lamp_map, lamp_frame, buf[X, j], buf[Y, j]))
        if beams_on and buf[SHARE, j] > F0:
            z = buf[DEPTH, j] + 0.0
            xc = (xs[j] - cx) / focal * z
            light = math.exp(-env[ENV_BETA] * z) * beam_at(table[0], own, up, xc, yn * z, z)
            for k in range(beams.shape[0]):
                light += beams[k, 12] * beam_at(table[1], beams[k], up, xc, yn * z, z)
        now_beam = np.float32(light)
        for k in range(i + 1, j + 1):
            t = np.float32((k - i) / (j - i)) if i >= a else F1
            lamp[k] = last_lamp + (now_lamp - last_lamp) * t
            beam[k] = last_beam + (now_beam - last_beam) * t
        i, last_lamp, last_beam = j, now_lamp, now_beam


@kernel
def _radiance(albedo, marks, cover, grain, dark, sun_e, sky_e, sun, sky, lamp_e, lamp, beam_e, beam, out):
    for i in range(out.shape[0]):
        rest = max(F0, F1 - cover[i])
        white = max(F0, min(F1, marks[i])) * (np.float32(0.93) + np.float32(0.8) * grain[i])
        ground = albedo[i] * (F1 + grain[i]) * dark
        surface = ground + (WHITE * (HALF + HALF * dark) - ground) * white + rest * KERB * dark
        light = sun_e * sun[i] + sky_e * sky[i] + lamp_e * lamp[i] + beam_e * beam[i]
        out[i] = surface * light * INV_PI


@kernel
def _passed(depth, beta, out):
    for i in range(out.shape[0]):
        out[i] = exp_minus(beta * depth[i])


@kernel
def _under(radiance, passed, air, share, free, gain, plane):
    for i in range(plane.shape[0]):
        plane[i] += gain * free[i] * share[i] * (radiance[i] * passed[i] + air * (F1 - passed[i]))


@kernel
def _over_horizon(value, share, free, gain, plane):
    for i in range(plane.shape[0]):
        plane[i] += gain * free[i] * (F1 - share[i]) * value[i]


@kernel
def _own_ground(share, free, depth, weight, depth_inverse, ids):
    for i in range(ids.shape[0]):
        takes = free[i] * share[i] > weight[i]
        weight[i] = free[i] * share[i] if takes else weight[i]
        depth_inverse[i] = F1 / depth[i] if takes else depth_inverse[i]
        ids[i] = -1 if takes else ids[i]


@kernel
def _own_sky(share, free, weight, depth_inverse, ids):
    for i in range(ids.shape[0]):
        takes = free[i] * (F1 - share[i]) > weight[i]
        weight[i] = free[i] * (F1 - share[i]) if takes else weight[i]
        depth_inverse[i] = F0 if takes else depth_inverse[i]
        ids[i] = 0 if takes else ids[i]


@kernel
def _sine_row(rotation, yn, optics, xs, a, sine):
    """Sine of the rays' elevation, not below the horizon."""
    focal, cx, _ = optics
    ux, rest = rotation[0, 2], rotation[1, 2] * yn + rotation[2, 2]
    for i in range(sine.shape[0]):
        xn = (xs[a + i] - cx) / focal
        sine[i] = np.float32(max(0.0, (ux * xn + rest) / math.sqrt(1.0 + xn * xn + yn * yn)))


@kernel
def _sky_colour(sine, env, c, out):
    beta = np.float32(env[ENV_BETA] * 150.0)
    air = np.float32(env[ENV_AIR + c])
    for i in range(out.shape[0]):
        value = np.float32(sky_radiance(sine[i], env, c))
        out[i] = air + (value - air) * exp_minus(beta / max(sine[i], np.float32(0.02)))


@kernel
def _sky_row(row, yn, rotation, env, optics, xs, a, b, frame, buf):
    """Sky between columns a and b: a gradient over elevation, veiled near the horizon where there is fog."""
    out, weight, depth_inverse, ids = frame
    share, sine, colour = buf[SHARE, a:b], buf[PASSED, : b - a], buf[RADIANCE, : b - a]
    free = buf[FREE, a:b]
    _sine_row(rotation, yn, optics, xs, a, sine)
    for c in range(3):
        _sky_colour(sine, env, c, colour)
        target, gain = (c, F1) if out.shape[0] == 3 else (0, np.float32((0.2126, 0.7152, 0.0722)[c]))
        _over_horizon(colour, share, free, gain, out[target, row, a:b])
    _own_sky(share, free, weight[row, a:b], depth_inverse[row, a:b], ids[row, a:b])


@kernel
def _ground_row(
    row, yn, camera, env, layout, tables, shadows, bounds, lights, optics, xs, a, b, frame, works, buf
):
    """Ground between columns a and b of a row that ``_place_row`` has placed."""
    out, weight, depth_inverse, ids = frame
    for k in (SUN, SKY):
        fill_row(F1, buf[k])
    for k in (LAMP, BEAM):
        fill_row(F0, buf[k])
    _shadow_row(row, shadows, bounds, buf)
    if env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0:
        _light_row(lights, env, yn, optics, xs, a, b, buf)
    lower = max(0.02, 1.0 - layout[1] / camera[2])  # the kerb's plane seen from the same place
    work, street = works
    n, free = b - a, buf[FREE]
    place_on_street(buf[X : YV + 1, a:b], layout, street[:, :n])
    grain_of_row(tables[3], layout[6], street[:, :n], free[a:b], buf[GRAIN, a:b])
    for i in range(a, b):
        if free[i] > np.float32(1e-4) and buf[SHARE, i] > F0:
            ground_at(
                buf[X, i], buf[Y, i], buf[XU, i], buf[XV, i], buf[YU, i], buf[YV, i], street, i - a, camera, lower, layout,
                tables, work,
            )  # fmt: skip
            for c in range(3):
                buf[RED + c, i] = work[1 + c]
            buf[COVER, i], buf[MARKS, i] = work[0], work[4]
        else:
            for k in range(RED, GRAIN):
                buf[k, i] = F0
    sine = max(0.0, env[0] * env[ENV_UP] + env[1] * env[ENV_UP + 1] + env[2] * env[ENV_UP + 2])
    dark = np.float32(1.0 - 0.45 * env[ENV_WET])
    share, passed, radiance = buf[SHARE, a:b], buf[PASSED, a:b], buf[RADIANCE, a:b]
    _passed(buf[DEPTH, a:b], np.float32(env[ENV_BETA]), passed)
    for c in range(3):
        _radiance(
            buf[RED + c, a:b], buf[MARKS, a:b], buf[COVER, a:b], buf[GRAIN, a:b], dark, np.float32(env[ENV_SUN + c] * sine),
            np.float32(env[ENV_SKY + c]), buf[SUN, a:b], buf[SKY, a:b], np.float32(env[ENV_LAMP + c]), buf[LAMP, a:b],
            np.float32(env[ENV_BEAM_TINT + c]), buf[BEAM, a:b], radiance,
        )  # fmt: skip
        target, gain = (c, F1) if out.shape[0] == 3 else (0, np.float32((0.2126, 0.7152, 0.0722)[c]))
        _under(radiance, passed, np.float32(env[ENV_AIR + c]), share, free[a:b], gain, out[target, row, a:b])
    _own_ground(share, free[a:b], buf[DEPTH, a:b], weight[row, a:b], depth_inverse[row, a:b], ids[row, a:b])


@entry
def draw_ground_and_sky_freely(
    rotation, camera, env, layout, tables, shadows, bounds, lights, optics, xs, size, frame, works, buf
):
    """Fill what objects left over, whatever the camera's rotation.

    Args:
        rotation: (3, 3) world to camera.
        camera: (3,) its position.
        env: (ENV_SIZE,) see kernels.lighting.
        layout: See kernels.street_profile.
        tables: See kernels.street_profile.
        shadows: (polygons, polygon info, capsules) of kernels.shadows.
        bounds: From ``kernels.shadows.shadow_bounds``.
        lights: (ground lamp map, its frame, others' beams, beam table).
        optics: (focal, cx, cy).
        xs: (W,) pixel centres.
        size: (height, width).
        frame: (out (C, H, W), alpha, weight, depth inverse, ids).
        works: (WORK_SIZE,) and (STREET_ROWS, >= W) float32 of kernels.street_profile.
        buf: (24, >= W) float32.
    """
    out, alpha, weight, depth_inverse, ids = frame
    rest = (out, weight, depth_inverse, ids)
    focal, _, cy = optics
    n = xs.shape[0]
    free = buf[FREE]
    for row in range(size[0]):
        a, b = free_row(alpha[row], free)
        for c in range(out.shape[0]):
            settle_row(alpha[row, a:b], out[c, row, a:b])
        settle_row(alpha[row, a:b], weight[row, a:b])
        if b <= a:
            continue
        yn = (row + 0.5 - cy) / focal
        _place_row(rotation, camera, yn, optics, n, buf)
        most = max(buf[SHARE, 0], buf[SHARE, n - 1])  # linear along the row between its ends' clamps
        least = min(buf[SHARE, 0], buf[SHARE, n - 1])
        if most > F0:
            _ground_row(
                row,
                yn,
                camera,
                env,
                layout,
                tables,
                shadows,
                bounds,
                lights,
                optics,
                xs,
                a,
                b,
                rest,
                works,
                buf,
            )
        if least < F1:
            _sky_row(row, yn, rotation, env, optics, xs, a, b, rest, buf)
