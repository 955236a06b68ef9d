"""Road, kerbs and sidewalks by exact box filters, shadows on them, and the sky.

The street's markings are products of a profile across and a profile along it, so their coverage of a pixel is a product of
exact means: no moire at any distance. The grain is filtered by running sums.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.bands import add_stripes, fill_bands, grain_columns, grain_row, weigh_bands
from pedcross_env.camera.kernels.clouds import cloud_row, cloudy_rows
from pedcross_env.camera.kernels.finish import finish_row
from pedcross_env.camera.kernels.ground_light import lights_row, shadow_row
from pedcross_env.camera.kernels.jit import INT, entry, inlined, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_AIR,
    ENV_BEAM,
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

__all__ = ["FAR_M", "INV_PI", "KERB", "WHITE", "draw_ground_and_sky"]

INV_PI = np.float32(1 / math.pi)
WHITE = np.float32(0.62)
KERB = np.float32(0.26)  # albedo of the kerb's upright face
LUMA_R, LUMA_G, LUMA_B = np.float32(0.2126), np.float32(0.7152), np.float32(0.0722)
SUN, SKY, LAMP, BEAM, GRAIN, COVER, MARKS, PLANES = 3, 4, 5, 6, 7, 8, 9, 10  # rows of the work space
FREE = 22  # one more: the share of each pixel that objects left over
FAR_M = 4000.0


@kernel
def _along(table, start, texel, x0, x1, out):
    """Box-filter the profiles along the street between x0 and x1."""
    last = table.shape[0] - 2
    span = max(x1 - x0, 1e-3)
    for k in range(out.shape[0]):
        value = 0.0
        for e in range(2):
            p = min(max(((x1 if e == 0 else x0) - start) / texel, 0.0), last + 0.999)
            i = int(p)
            v = table[i, k] + (p - i) * (table[i + 1, k] - table[i, k])
            value += v if e == 0 else -v
        out[k] = value * texel / span


@inlined
def _white(marks, grain):
    """Share of a pixel that is white paint, worn where the grain is dark."""
    return max(F0, min(F1, marks)) * (np.float32(0.93) + np.float32(0.8) * grain)


@kernel
def _shade_day(red, green, blue, marks, cover, grain, sun, sky, free, facts, plane0, plane1, plane2):
    """Put a row of ground under the frame's planes; ``facts`` see ``_row_facts``."""
    dark, passed, white_albedo = facts[0], facts[1], facts[2]
    sun0, sun1, sun2, sky0, sky1, sky2 = facts[3], facts[4], facts[5], facts[6], facts[7], facts[8]
    haze0, haze1, haze2 = facts[15], facts[16], facts[17]
    for i in range(free.shape[0]):
        white = _white(marks[i], grain[i])
        kerb, bare = max(F0, F1 - cover[i]) * KERB * dark, (F1 + grain[i]) * dark * (F1 - white)
        paint = white_albedo * white + kerb
        lit, shaded, share = sun[i] * passed, sky[i] * passed, free[i]
        plane0[i] += share * ((red[i] * bare + paint) * (sun0 * lit + sky0 * shaded) + haze0)
        plane1[i] += share * ((green[i] * bare + paint) * (sun1 * lit + sky1 * shaded) + haze1)
        plane2[i] += share * ((blue[i] * bare + paint) * (sun2 * lit + sky2 * shaded) + haze2)


@kernel
def _shade_lamps(red, green, blue, marks, cover, grain, lamp, beam, free, facts, plane0, plane1, plane2):
    """Add the light of street lamps and headlights to what ``_shade_day`` left."""
    dark, passed, white_albedo = facts[0], facts[1], facts[2]
    lamp0, lamp1, lamp2, beam0, beam1, beam2 = facts[9], facts[10], facts[11], facts[12], facts[13], facts[14]
    for i in range(free.shape[0]):
        white = _white(marks[i], grain[i])
        kerb, bare = max(F0, F1 - cover[i]) * KERB * dark, (F1 + grain[i]) * dark * (F1 - white)
        paint = white_albedo * white + kerb
        street, own, share = lamp[i] * passed, beam[i] * passed, free[i]
        plane0[i] += share * (red[i] * bare + paint) * (lamp0 * street + beam0 * own)
        plane1[i] += share * (green[i] * bare + paint) * (lamp1 * street + beam1 * own)
        plane2[i] += share * (blue[i] * bare + paint) * (lamp2 * street + beam2 * own)


@kernel
def _shade_grey(albedo, marks, cover, grain, light, white_radiance, dark, white_albedo, passed, free, plane):
    """Add the luminance under one light; ``albedo`` is weighted by its colour, ``white_radiance`` that of a white surface."""
    for i in range(free.shape[0]):
        white = _white(marks[i], grain[i])
        kerb, bare = max(F0, F1 - cover[i]) * KERB * dark, (F1 + grain[i]) * dark * (F1 - white)
        surface = albedo[i] * bare + (white_albedo * white + kerb) * white_radiance
        plane[i] += free[i] * surface * light[i] * passed


@kernel
def _haze_row(value, free, plane):
    for i in range(plane.shape[0]):
        plane[i] += free[i] * value


@kernel
def _own_rest(share, free, inverse, ident, weight, depth_inverse, ids):
    for i in range(free.shape[0]):
        takes = free[i] * share > weight[i]
        weight[i] = free[i] * share if takes else weight[i]
        depth_inverse[i] = inverse if takes else depth_inverse[i]
        ids[i] = ident if takes else ids[i]


@kernel
def _profile(level, y0, dy, stripes, stripe_weights, weighed, covered, count, a, n, buf):
    """Fill the albedo planes, cover and marks of the road (level 0) or of what lies above the kerb."""
    cover, marks = buf[COVER, :n], buf[MARKS, :n]
    fill_bands(weighed[level], count, y0, dy, a, n, buf, PLANES, MARKS)
    add_stripes(covered[level], 1.0, y0, dy, a, cover)
    if level == 0:
        for k in range(2):
            if stripe_weights[k] > 0:
                add_stripes(stripes[k], stripe_weights[k], y0, dy, a, marks)


@kernel
def _row_facts(env, depth, share, facts):
    """Fill (18,): darkening by wetness, transmission times share, albedo of paint; radiance of a white surface under sun, sky, lamps,
    beams (r, g, b each); the air's own radiance."""
    passed = exp_minus(np.float32(env[ENV_BETA] * depth))
    sine = max(0.0, env[0] * env[ENV_UP] + env[1] * env[ENV_UP + 1] + env[2] * env[ENV_UP + 2])
    dark = np.float32(1.0 - 0.45 * env[ENV_WET])
    facts[0], facts[1], facts[2] = dark, passed * share, WHITE * (HALF + HALF * dark)
    for c in range(3):
        facts[3 + c] = np.float32(env[ENV_SUN + c] * sine) * INV_PI
        facts[6 + c] = np.float32(env[ENV_SKY + c]) * INV_PI
        facts[9 + c] = np.float32(env[ENV_LAMP + c]) * INV_PI
        facts[12 + c] = np.float32(env[ENV_BEAM_TINT + c]) * INV_PI
        facts[15 + c] = np.float32(env[ENV_AIR + c]) * (F1 - passed) * share


@kernel
def _shade_row(row, a, b, n, count, facts, lights_on, kinds, weights, out, buf):
    """Light the row's albedo and put it under the frame."""
    marks, cover, grain, left = buf[MARKS, :n], buf[COVER, :n], buf[GRAIN, :n], buf[FREE, a:b]
    if out.shape[0] == 1:
        for k in range(count):
            white = F0
            for c in range(3):
                white += weights[k, c]
            _shade_grey(
                buf[PLANES + k, :n], marks, cover, grain, buf[SUN + kinds[k], :n], white, facts[0], facts[2], facts[1], left,
                out[0, row, a:b],
            )  # fmt: skip
        air = LUMA_R * facts[15] + LUMA_G * facts[16] + LUMA_B * facts[17]
        if air > F0:
            _haze_row(air, left, out[0, row, a:b])
        return
    red, green, blue = buf[PLANES, :n], buf[PLANES + 1, :n], buf[PLANES + 2, :n]
    out0, out1, out2 = out[0, row, a:b], out[1, row, a:b], out[2, row, a:b]
    _shade_day(
        red, green, blue, marks, cover, grain, buf[SUN, :n], buf[SKY, :n], left, facts, out0, out1, out2
    )
    if lights_on:
        lamp, beam = buf[LAMP, :n], buf[BEAM, :n]
        _shade_lamps(red, green, blue, marks, cover, grain, lamp, beam, left, facts, out0, out1, out2)


@kernel
def _ground_row(
    row, y, share, rotation, camera, env, street, tables, weighed, albedo, shadows, lights, optics, xs, a, b, out, owners, work, buf,
    owner,
):  # fmt: skip
    """Ground between columns a and b of one row."""
    focal, cx, cy = optics
    kerb_h, along_start, along_texel, grain_texel = street
    along_table, stripes, grain = tables
    count, covered, kinds, weights = albedo
    polygons, polygon_info, capsules = shadows
    lamp_map, lamp_frame, beams, table = lights
    along, line, facts = work
    n = b - a
    yn = (y - cy) / focal
    for k in range(PLANES, PLANES + count):
        fill_row(F0, buf[k, :n])
    fill_row(F0, buf[COVER, :n])
    fill_row(F0, buf[MARKS, :n])
    lights_on = env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0
    depth = FAR_M
    for level in range(2):
        height = camera[2] - (kerb_h if level == 1 else 0.0)
        z = min(FAR_M, height / max(1e-9, -(rotation[1, 2] * yn + rotation[2, 2])))
        fx, fy = rotation[1, 0] * yn + rotation[2, 0], rotation[1, 1] * yn + rotation[2, 1]
        dx, dy = z * rotation[0, 0] / focal, z * rotation[0, 1] / focal
        x0, y0 = camera[0] + z * fx - cx * dx, camera[1] + z * fy - cx * dy
        if level == 0:
            depth = z
            down = -(rotation[1, 2] * (yn + 0.5 / focal) + rotation[2, 2])
            rise = -(rotation[1, 2] * (yn - 0.5 / focal) + rotation[2, 2])
            ahead = rotation[2, 0] * rotation[2, 0] + rotation[2, 1] * rotation[2, 1]
            near_z = min(FAR_M, height / max(1e-9, down))
            far_z = min(FAR_M, height / max(1e-9, rise)) if rise > 1e-9 else FAR_M
            middle_x = x0 + dx * 0.5 * xs.shape[0]
            foot_x = (far_z - near_z) * math.sqrt(ahead)
            low_x, high_x = middle_x - 0.5 * foot_x, middle_x + 0.5 * foot_x
            _along(along_table, along_start, along_texel, low_x, high_x, along)
            mean = grain_row(grain, low_x, high_x, grain_texel, line)
            grain_columns(line, mean, y0, dy, grain_texel, a, buf[LAMP], buf[GRAIN, :n])
            fill_row(F1, buf[SUN, :n])
            fill_row(F1, buf[SKY, :n])
            ends = (x0 + dx * a, x0 + dx * b)
            shadow_row(
                polygons, polygon_info, capsules, np.float32(min(ends) - foot_x), np.float32(max(ends) + foot_x), xs[:n],
                np.float32(x0 + dx * a), np.float32(dx), np.float32(y0 + dy * a), np.float32(dy),
                (np.float32(camera[0]), np.float32(camera[1])), np.float32(max(0.1, middle_x - camera[0])), np.float32(foot_x),
                np.float32(abs(dy)), buf[SUN, :n], buf[SKY, :n], buf[LAMP],
            )  # fmt: skip
            if lights_on:
                place = (x0, dx, y0, dy)
                lights_row(
                    lamp_map, lamp_frame, table, env, beams, place, z, yn, focal, cx, xs[a:b], buf[LAMP, :n], buf[BEAM, :n],
                )  # fmt: skip
        if abs(dy) > 1e-9:
            _profile(level, y0, dy, stripes, along, weighed, covered, count, a, n, buf)
    _row_facts(env, depth, share, facts)
    _shade_row(row, a, b, n, count, facts, lights_on, kinds, weights, out, buf)
    if owners:
        weight, depth_inverse, ids = owner
        _own_rest(
            share,
            buf[FREE, a:b],
            np.float32(1.0 / depth),
            INT(-1),
            weight[row, a:b],
            depth_inverse[row, a:b],
            ids[row, a:b],
        )


@kernel
def _active_lights(env, kinds, weights):
    """List the lights that shine (0 sun, 1 sky, 2 lamps, 3 beams) with their weight in luminance per channel; return their number."""
    sine = max(0.0, env[0] * env[ENV_UP] + env[1] * env[ENV_UP + 1] + env[2] * env[ENV_UP + 2])
    count = 0
    for kind in range(4):
        at = (ENV_SUN, ENV_SKY, ENV_LAMP, ENV_BEAM_TINT)[kind]
        scale = (sine, 1.0, 1.0, 1.0 if env[ENV_BEAM] > 0 else 0.0)[kind]
        if scale * (env[at] + env[at + 1] + env[at + 2]) <= 0:
            continue
        kinds[count] = kind
        for c in range(3):
            weights[count, c] = np.float32((LUMA_R, LUMA_G, LUMA_B)[c] * scale * env[at + c]) * INV_PI
        count += 1
    return count


@kernel
def _sky_row(row, y, share, rotation, env, optics, a, b, free, out, owners, owner):
    """Sky between columns a and b: a gradient over elevation, veiled near the horizon where there is fog."""
    focal, _, cy = optics
    weight, depth_inverse, ids = owner
    yn = (y - cy) / focal
    sine = (rotation[1, 2] * yn + rotation[2, 2]) / math.sqrt(1.0 + yn * yn)
    sine = max(sine, 0.0)
    veil = 1.0 - math.exp(-env[ENV_BETA] * 150.0 / max(sine, 0.02))
    total = 0.0
    for c in range(3):
        value = sky_radiance(sine, env, c)
        value = value + (env[ENV_AIR + c] - value) * veil
        if out.shape[0] == 1:
            total += (0.2126, 0.7152, 0.0722)[c] * value
        else:
            _fill_row(np.float32(value * share), free[a:b], out[c, row, a:b])
    if out.shape[0] == 1:
        _fill_row(np.float32(total * share), free[a:b], out[0, row, a:b])
    if owners:
        _own_rest(share, free[a:b], F0, INT(0), weight[row, a:b], depth_inverse[row, a:b], ids[row, a:b])


@kernel
def _fill_row(value, free, plane):
    for i in range(plane.shape[0]):
        plane[i] += free[i] * value


@entry
def draw_ground_and_sky(
    rotation,
    camera,
    env,
    street,
    tables,
    bands,
    shadows,
    lights,
    clouds,
    optics,
    xs,
    rows,
    frame,
    owners,
    luminance,
    work,
    buf,
):
    """Fill what objects left over: ground below the horizon, sky above, both in the horizon's row.

    Args:
        rotation: (3, 3) world to camera.
        camera: (3,) its position.
        env: (ENV_SIZE,) see kernels.lighting.
        street: (kerb height, start of the profiles along, their texel, the grain's texel), metres.
        tables: (profiles along (N, 3), stripes across by kind, grain's running sums).
        bands: (bands of the road, those above the kerb, work for either, what either cover), see kernels.bands.
        shadows: (polygons, their facts, capsules).
        lights: (lamp map, its frame, others' beams, low-beam candela).
        clouds: See kernels.clouds.add_clouds; with a texture without rows there are none.
        optics: (focal, cx, cy).
        xs: (W,) pixel centres.
        rows: (from, to) that are filled; above them objects are left alone.
        frame: (out (C, H, W), alpha, weight, depth inverse, ids) from ``draw_scene``.
        owners: Whether to fill the last three.
        luminance: (H, W) to finish depth and luminance row by row, while they are in the cache; without rows: not yet.
        work: ((3,), (T + 1,) and (18,) floats; (4,) int64 kinds and (4, 3) weights of lights).
        buf: (24, >= W + 2).
    """
    out, alpha, weight, depth_inverse, ids = frame
    low, high, weighed_low, weighed_high, covered = bands
    along, line, facts, kinds, weights = work
    focal, _, cy = optics
    horizon = cy - focal * rotation[2, 2] / rotation[1, 2]  # rows below it look down
    owner = (weight, depth_inverse, ids)
    free = buf[FREE]
    count = 3
    if out.shape[0] == 1:
        count = _active_lights(env, kinds, weights)
    else:
        for k in range(3):
            for c in range(3):
                weights[k, c] = F1 if k == c else F0
    weigh_bands(low, weights[:count], weighed_low)
    weigh_bands(high, weights[:count], weighed_high)
    weighed = weighed_low[: low.shape[0]], weighed_high[: high.shape[0]]
    albedo = count, covered, kinds, weights
    cloudy = INT(0)
    if clouds[0].shape[1] > 0:
        cloudy = cloudy_rows(rotation, optics, out.shape[1], out.shape[2])
    for row in range(rows[0]):
        for c in range(out.shape[0]):
            settle_row(alpha[row], out[c, row])
    for row in range(rows[0], rows[1]):
        a, b = free_row(alpha[row], free)
        for c in range(out.shape[0]):
            settle_row(alpha[row, a:b], out[c, row, a:b])
        if owners:
            settle_row(alpha[row, a:b], weight[row, a:b])
        share = np.float32(min(1.0, max(0.0, row + 1.0 - horizon)))
        if b > a and share > 0:
            y = 0.5 * (max(horizon, row + 0.0) + row + 1.0)
            _ground_row(
                row, y, share, rotation, camera, env, street, tables, weighed, albedo, shadows, lights, optics, xs, a, b, out, owners,
                (along, line, facts), buf, owner,
            )  # fmt: skip
        if b > a and share < 1:
            y = 0.5 * (min(horizon, row + 1.0) + row)
            _sky_row(row, y, F1 - share, rotation, env, optics, a, b, free, out, owners, owner)
        if b > a and row < cloudy:
            cloud_row(row, a, b, free, rotation, env, optics, clouds, out)
        if luminance.shape[0] > 0:
            finish_row(row, out, depth_inverse, luminance)
