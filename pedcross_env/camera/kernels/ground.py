"""Road, kerbs and sidewalks by exact box filters, shadows on them, and the sky.

The street's markings are products of a profile across and a profile along it, so their coverage of a pixel is a product of
differences of running integrals: no moire at any distance. The grain is filtered by the same means.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import kernel
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
    beam_candela,
    sky_radiance,
)  # fmt: skip
from pedcross_env.camera.kernels.rows import F0, F1, HALF, exp_minus, fill_row

__all__ = ["draw_ground_and_sky"]

INV_PI = np.float32(1 / math.pi)
WHITE = np.float32(0.62)
FAR_M = 4000.0
BEAM_RANGE_M = 90.0


@kernel
def _grain_row(integral, x0, x1, texel, line):
    """Box-filter the tiled grain from x0 to x1 and integrate the result across the street.

    integral: (T + 1, T) running sums along x; line: (T + 1,) running sums across, filled.
    """
    size = integral.shape[1]
    p0, p1 = x0 / texel, x1 / texel
    span = max(p1 - p0, 1e-3)
    t0, t1 = math.floor(p0 / size), math.floor(p1 / size)
    q0, q1 = p0 - t0 * size, p1 - t1 * size
    i0, i1 = min(int(q0), size - 1), min(int(q1), size - 1)
    f0, f1 = np.float32(q0 - i0), np.float32(q1 - i1)
    turns, scale = np.float32(t1 - t0), np.float32(1.0 / span)
    total = 0.0
    for j in range(size):
        low = integral[i0, j] + f0 * (integral[i0 + 1, j] - integral[i0, j])
        high = integral[i1, j] + f1 * (integral[i1 + 1, j] - integral[i1, j])
        line[j] = total
        total += (high - low + turns * integral[size, j]) * scale
    line[size] = total


@kernel
def _grain_columns(line, y0, dy, texel, first, out):
    """Box-filter the integrated row of grain over each pixel's extent across the street."""
    size = line.shape[0] - 1
    step = dy / texel
    p = y0 / texel + first * step
    turn = math.floor(p / size)
    q = p - turn * size
    i = min(int(q), size - 1)
    before = turn * line[size] + line[i] + (q - i) * (line[i + 1] - line[i])
    for k in range(out.shape[0]):
        p = y0 / texel + (first + k + 1) * step
        turn = math.floor(p / size)
        q = p - turn * size
        i = min(int(q), size - 1)
        after = turn * line[size] + line[i] + (q - i) * (line[i + 1] - line[i])
        out[k] = (after - before) / step
        before = after


@kernel
def _profile_columns(table, low, texel, y0, dy, first, rgb, cover, marks):
    """Add the box-filtered profile (cover, r, g, b, lines) for pixels from ``first`` on."""
    last = table.shape[0] - 2
    step, start = dy / texel, (y0 - low) / texel
    p = min(max(start + first * step, 0.0), last + 0.999)
    i = int(p)
    f = np.float32(p - i)
    b0, b1 = (
        table[i, 0] + f * (table[i + 1, 0] - table[i, 0]),
        table[i, 1] + f * (table[i + 1, 1] - table[i, 1]),
    )
    b2, b3 = (
        table[i, 2] + f * (table[i + 1, 2] - table[i, 2]),
        table[i, 3] + f * (table[i + 1, 3] - table[i, 3]),
    )
    b4 = table[i, 4] + f * (table[i + 1, 4] - table[i, 4])
    scale = np.float32(texel / dy)
    for k in range(cover.shape[0]):
        p = min(max(start + (first + k + 1) * step, 0.0), last + 0.999)
        i = int(p)
        f = np.float32(p - i)
        a0, a1 = (
            table[i, 0] + f * (table[i + 1, 0] - table[i, 0]),
            table[i, 1] + f * (table[i + 1, 1] - table[i, 1]),
        )
        a2, a3 = (
            table[i, 2] + f * (table[i + 1, 2] - table[i, 2]),
            table[i, 3] + f * (table[i + 1, 3] - table[i, 3]),
        )
        a4 = table[i, 4] + f * (table[i + 1, 4] - table[i, 4])
        cover[k] += (a0 - b0) * scale
        rgb[0, k] += (a1 - b1) * scale
        rgb[1, k] += (a2 - b2) * scale
        rgb[2, k] += (a3 - b3) * scale
        marks[k] += (a4 - b4) * scale
        b0, b1, b2, b3, b4 = a0, a1, a2, a3, a4


@kernel
def _marks_columns(table, channel, weight, low, texel, y0, dy, first, marks):
    """Add one more box-filtered marking (dashes, zebra), which cover ``weight`` of this row."""
    last = table.shape[0] - 2
    step, start = dy / texel, (y0 - low) / texel
    p = min(max(start + first * step, 0.0), last + 0.999)
    i = int(p)
    before = table[i, channel] + np.float32(p - i) * (table[i + 1, channel] - table[i, channel])
    scale = np.float32(weight * texel / dy)
    for k in range(marks.shape[0]):
        p = min(max(start + (first + k + 1) * step, 0.0), last + 0.999)
        i = int(p)
        after = table[i, channel] + np.float32(p - i) * (table[i + 1, channel] - table[i, channel])
        marks[k] += (after - before) * scale
        before = after


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


@kernel
def _polygon_shadow(shape, count, xs, x0, dx, y0, dy, foot_x, foot_y, soft, strength, out):
    """Darken ``out`` (share of light) under a convex polygon on the ground with soft edges."""
    for i in range(xs.shape[0]):
        x, y = x0 + dx * xs[i], y0 + dy * xs[i]
        cover = F1
        for k in range(count):
            a, b = shape[k, 0], shape[k, 1]
            width = soft + abs(a) * foot_x + abs(b) * foot_y
            cover = min(cover, max(F0, min(F1, (a * x + b * y + shape[k, 2]) / width + HALF)))
        out[i] = min(out[i], F1 - strength * cover * cover * (np.float32(3.0) - np.float32(2.0) * cover))


@kernel
def _capsule_shadow(shape, xs, x0, dx, y0, dy, foot_x, foot_y, strength, out):
    """Darken ``out`` under a capsule (ax, ay, bx-ax, by-ay, 1/len2, radius, soft) on the ground."""
    ax, ay, ex, ey, inv, radius = shape[0], shape[1], shape[2], shape[3], shape[4], shape[5]
    width = shape[6] + HALF * (foot_x + foot_y)
    # where a pixel is wider than the shape, its share of the pixel is what counts
    share = min(F1, np.float32(2.0) * radius / max(np.float32(1e-3), HALF * (foot_x + foot_y)))
    for i in range(xs.shape[0]):
        x, y = x0 + dx * xs[i] - ax, y0 + dy * xs[i] - ay
        t = max(F0, min(F1, (x * ex + y * ey) * inv))
        px, py = x - t * ex, y - t * ey
        cover = max(F0, min(F1, (radius - np.sqrt(px * px + py * py)) / width + HALF))
        out[i] = min(
            out[i], F1 - share * strength * cover * cover * (np.float32(3.0) - np.float32(2.0) * cover)
        )


@kernel
def _shadows(polygons, polygon_info, capsules, row_x0, row_x1, xs, x0, dx, y0, dy, foot_x, foot_y, sun, sky):
    """Apply all shadows that reach this row to the shares of sunlight and skylight."""
    inv = F1 / dy
    low, high = min(row_x0, row_x1), max(row_x0, row_x1)
    for k in range(polygons.shape[0]):
        info = polygon_info[k]
        if info[1] < low or info[0] > high:
            continue
        spread = foot_x + foot_y  # slanted edges blur sideways over a pixel's depth
        a, b = (info[2] - spread - y0) * inv, (info[3] + spread - y0) * inv
        i0 = max(0, int(math.floor(max(min(a, b), np.float32(-2.0)))) - 1)
        i1 = min(xs.shape[0], int(math.ceil(min(max(a, b), np.float32(xs.shape[0] + 2)))) + 1)
        if i1 > i0:
            target = sun if info[7] == 0 else sky
            _polygon_shadow(
                polygons[k],
                int(info[4]),
                xs[i0:i1],
                x0,
                dx,
                y0,
                dy,
                foot_x,
                foot_y,
                info[5],
                info[6],
                target[i0:i1],
            )
    for k in range(capsules.shape[0]):
        s = capsules[k]
        reach = s[5] + s[6] + foot_x + foot_y
        if max(s[0], s[0] + s[2]) + reach < low or min(s[0], s[0] + s[2]) - reach > high:
            continue
        a, b = (min(s[1], s[1] + s[3]) - reach - y0) * inv, (max(s[1], s[1] + s[3]) + reach - y0) * inv
        i0 = max(0, int(math.floor(max(min(a, b), np.float32(-2.0)))) - 1)
        i1 = min(xs.shape[0], int(math.ceil(min(max(a, b), np.float32(xs.shape[0] + 2)))) + 1)
        if i1 > i0:
            target = sun if s[8] == 0 else sky
            _capsule_shadow(s, xs[i0:i1], x0, dx, y0, dy, foot_x, foot_y, s[7], target[i0:i1])


@kernel
def _lamp_at(lamp_map, frame, x, y):
    """Bilinear look-up of the lamps' illuminance on the ground: frame = (start x, start y, step)."""
    rows, columns = lamp_map.shape
    p = min(max((x - frame[0]) / frame[2], 0.0), columns - 1.001)
    q = min(max((y - frame[1]) / frame[2], 0.0), rows - 1.001)
    a, b = int(q), int(p)
    fq, fp = q - a, p - b
    low = lamp_map[a, b] + fp * (lamp_map[a, b + 1] - lamp_map[a, b])
    high = lamp_map[a + 1, b] + fp * (lamp_map[a + 1, b + 1] - lamp_map[a + 1, b])
    return low + fq * (high - low)


@kernel
def _beam_at(table, beam, up, x, y, z):
    """Illuminance of the ground at a point in camera coordinates from one beam."""
    dx, dy, dz = x - beam[0], y - beam[1], z - beam[2]
    forward = dx * beam[3] + dy * beam[4] + dz * beam[5]
    if forward < 0.05 or forward > BEAM_RANGE_M:
        return 0.0
    left = (dx * beam[6] + dy * beam[7] + dz * beam[8]) / forward
    rise = (dx * beam[9] + dy * beam[10] + dz * beam[11]) / forward
    squared = dx * dx + dy * dy + dz * dz
    cosine = -(dx * up[0] + dy * up[1] + dz * up[2]) / math.sqrt(squared)
    fade = 1.0 - max(0.0, forward / BEAM_RANGE_M - 0.7) / 0.3
    return fade * beam_candela(table, left, rise) * max(0.0, cosine) / max(squared, 0.25)


@kernel
def _lights_row(lamp_map, lamp_frame, table, env, beams, place, z, yn, focal, cx, xs, lamp, beam):
    """Illuminance of one row of ground (depth z) from street lamps and from headlights.

    Both are smooth (the tables' steps are wider), so that every fourth pixel is computed and the rest interpolated.

    place: World (x0, dx, y0, dy) of the row, linear in the column.
    """
    n = xs.shape[0]
    up = env[ENV_UP : ENV_UP + 3]
    own = env[ENV_BEAM_POSITION : ENV_BEAM_POSITION + 12]
    fade = math.exp(-env[ENV_BETA] * z)
    lamps_on, beams_on = env[ENV_LAMP] > 0, env[ENV_BEAM] > 0
    i, last_lamp, last_beam = -4, np.float32(0), np.float32(0)
    while i < n - 1:
        j = min(i + 4, n - 1) if i >= 0 else 0
        x = xs[j]
        light = 0.0
        now_lamp = np.float32(0)
        if lamps_on:
            now_lamp = np.float32(
                _lamp_at(lamp_map, lamp_frame, place[0] + place[1] * x, place[2] + place[3] * x)
            )
        if beams_on:
            xc = (x - cx) / focal * z
            light = fade * _beam_at(table[0], own, up, xc, yn * z, z)
            for k in range(beams.shape[0]):
                light += beams[k, 12] * _beam_at(table[1], beams[k], up, xc, yn * z, z)
        now_beam = np.float32(light)
        for k in range(max(0, i + 1), j + 1):
            t = np.float32((k - i) / (j - i)) if i >= 0 else F1
            lamp[k] = last_lamp + (now_lamp - last_lamp) * t
            beam[k] = last_beam + (now_beam - last_beam) * t
        i, last_lamp, last_beam = j, now_lamp, now_beam


@kernel
def _radiance_row(
    albedo, marks, cover, grain, strength, dark, kerb, sun_e, sky_e, sun, sky, lamp_e, lamp, beam_e, beam, out
):
    for i in range(out.shape[0]):
        texture = F1 + strength * grain[i]
        rest = max(F0, F1 - cover[i])
        white = max(F0, min(F1, marks[i])) * (np.float32(0.93) + np.float32(0.8) * strength * grain[i])
        ground = albedo[i] * texture * dark
        surface = ground + (WHITE * (HALF + HALF * dark) - ground) * white + rest * kerb * dark
        light = sun_e * sun[i] + sky_e * sky[i] + lamp_e * lamp[i] + beam_e * beam[i]
        out[i] = surface * light * INV_PI


@kernel
def _under_row(radiance, passed, air, share, free, plane):
    for i in range(plane.shape[0]):
        plane[i] += free[i] * share * (radiance[i] * passed + air * (F1 - passed))


@kernel
def _luma_row(rgb):
    for i in range(rgb.shape[1]):
        rgb[0, i] = (
            np.float32(0.2126) * rgb[0, i] + np.float32(0.7152) * rgb[1, i] + np.float32(0.0722) * rgb[2, i]
        )


@kernel
def _free_row(alpha, free):
    """Share of each pixel that objects left over; return the columns where there is any."""
    n = alpha.shape[0]
    for i in range(n):
        free[i] = max(F0, F1 - alpha[i])
    a, b = 0, n
    while a < b and free[a] < np.float32(1e-4):
        a += 1
    while b > a and free[b - 1] < np.float32(1e-4):
        b -= 1
    return a, b


@kernel
def _own_rest(share, free, inverse, ident, weight, depth_inverse, ids):
    for i in range(free.shape[0]):
        takes = free[i] * share > weight[i]
        weight[i] = free[i] * share if takes else weight[i]
        depth_inverse[i] = inverse if takes else depth_inverse[i]
        ids[i] = ident if takes else ids[i]


@kernel
def _ground_row(
    row,
    y,
    share,
    rotation,
    camera,
    env,
    street,
    tables,
    shadows,
    lights,
    optics,
    xs,
    a,
    b,
    free,
    out,
    work,
    buf,
    owner,
):
    """Ground between columns a and b of one row; returns its depth on the road."""
    focal, cx, cy = optics
    kerb_y, kerb_h, along_start, along_texel, across_low, across_texel, grain_texel = street
    along_table, low_table, high_table, grain = tables
    polygons, polygon_info, capsules = shadows
    lamp_map, lamp_frame, beams, table = lights
    along, line = work
    weight, depth_inverse, ids = owner
    n = b - a
    x = xs[a:b]
    yn = (y - cy) / focal
    for k in range(16):
        fill_row(F0, buf[k, :n])
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
            _along(
                along_table, along_start, along_texel, middle_x - 0.5 * foot_x, middle_x + 0.5 * foot_x, along
            )
            _grain_row(grain, middle_x - 0.5 * foot_x, middle_x + 0.5 * foot_x, grain_texel, line)
            _grain_columns(line, y0, dy, grain_texel, a, buf[6, :n])
            fill_row(F1, buf[7, :n])
            fill_row(F1, buf[8, :n])
            ends = (x0 + dx * a, x0 + dx * b)
            _shadows(
                polygons, polygon_info, capsules, np.float32(min(ends) - foot_x), np.float32(max(ends) + foot_x), xs[:n],
                np.float32(x0 + dx * a), np.float32(dx), np.float32(y0 + dy * a), np.float32(dy), np.float32(foot_x),
                np.float32(abs(dy)), buf[7, :n], buf[8, :n],
            )  # fmt: skip
            if env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0:
                place = (x0, dx, y0, dy)
                _lights_row(
                    lamp_map,
                    lamp_frame,
                    table,
                    env,
                    beams,
                    place,
                    z,
                    yn,
                    focal,
                    cx,
                    x,
                    buf[9, :n],
                    buf[10, :n],
                )
        if abs(dy) < 1e-9:
            continue
        # columns where this level's profile is not empty
        e0, e1 = (kerb_y - y0) / dy, (-kerb_y - y0) / dy
        lo, hi = min(max(min(e0, e1), -1.0), b + 1.0), min(max(max(e0, e1), -1.0), b + 1.0)
        if level == 0:
            c0, c1 = max(a, int(math.floor(lo))), min(b, int(math.ceil(hi)))
            if c1 > c0:
                part = slice(c0 - a, c1 - a)
                _profile_columns(
                    low_table,
                    across_low,
                    across_texel,
                    y0,
                    dy,
                    c0,
                    buf[3:6, part],
                    buf[11, part],
                    buf[12, part],
                )
                for k in range(2):
                    if along[k] > 0:
                        _marks_columns(
                            low_table, 5 + k, along[k], across_low, across_texel, y0, dy, c0, buf[12, part]
                        )
        else:
            c1, c0 = min(b, max(a, int(math.ceil(lo)))), max(a, min(b, int(math.floor(hi))))
            if c1 > a:
                part = slice(0, c1 - a)
                _profile_columns(
                    high_table,
                    across_low,
                    across_texel,
                    y0,
                    dy,
                    a,
                    buf[3:6, part],
                    buf[11, part],
                    buf[12, part],
                )
            c0 = max(c0, c1)
            if b > c0:
                part = slice(c0 - a, n)
                _profile_columns(
                    high_table,
                    across_low,
                    across_texel,
                    y0,
                    dy,
                    c0,
                    buf[3:6, part],
                    buf[11, part],
                    buf[12, part],
                )
    passed = exp_minus(np.float32(env[ENV_BETA] * depth))
    sine = max(0.0, env[0] * env[ENV_UP] + env[1] * env[ENV_UP + 1] + env[2] * env[ENV_UP + 2])
    dark = np.float32(1.0 - 0.45 * env[ENV_WET])
    strength = F1
    for c in range(3):
        _radiance_row(
            buf[3 + c, :n], buf[12, :n], buf[11, :n], buf[6, :n], strength, dark, np.float32(0.26),
            np.float32(env[ENV_SUN + c] * sine), np.float32(env[ENV_SKY + c]), buf[7, :n], buf[8, :n],
            np.float32(env[ENV_LAMP + c]), buf[9, :n], np.float32(env[ENV_BEAM_TINT + c]), buf[10, :n], buf[13 + c, :n],
        )  # fmt: skip
    if out.shape[0] == 1:
        _luma_row(buf[13:16, :n])
        air = 0.2126 * env[ENV_AIR] + 0.7152 * env[ENV_AIR + 1] + 0.0722 * env[ENV_AIR + 2]
        _under_row(buf[13, :n], passed, np.float32(air), share, free[a:b], out[0, row, a:b])
    else:
        for c in range(3):
            _under_row(
                buf[13 + c, :n], passed, np.float32(env[ENV_AIR + c]), share, free[a:b], out[c, row, a:b]
            )
    _own_rest(
        share,
        free[a:b],
        np.float32(1.0 / depth),
        -1,
        weight[row, a:b],
        depth_inverse[row, a:b],
        ids[row, a:b],
    )


@kernel
def _sky_row(row, y, share, rotation, env, optics, a, b, free, out, owner):
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
    _own_rest(share, free[a:b], F0, 0, weight[row, a:b], depth_inverse[row, a:b], ids[row, a:b])


@kernel
def _fill_row(value, free, plane):
    for i in range(plane.shape[0]):
        plane[i] += free[i] * value


@kernel
def draw_ground_and_sky(
    rotation, camera, env, street, tables, shadows, lights, optics, xs, size, frame, work, buf
):
    """Fill what objects left over: ground below the horizon, sky above, both in the horizon's row.

    ``frame`` is (out (C, H, W), alpha, weight, depth inverse, ids); see ``_ground_row`` for the other tuples.
    """
    out, alpha, weight, depth_inverse, ids = frame
    focal, _, cy = optics
    height = size[0]
    horizon = cy - focal * rotation[2, 2] / rotation[1, 2]  # rows below it look down
    owner = (weight, depth_inverse, ids)
    free = buf[22]
    for row in range(height):
        a, b = _free_row(alpha[row], free)
        if b <= a:
            continue
        share = np.float32(min(1.0, max(0.0, row + 1.0 - horizon)))
        if share > 0:
            y = 0.5 * (max(horizon, row + 0.0) + row + 1.0)
            _ground_row(
                row,
                y,
                share,
                rotation,
                camera,
                env,
                street,
                tables,
                shadows,
                lights,
                optics,
                xs,
                a,
                b,
                free,
                out,
                work,
                buf,
                owner,
            )
        if share < 1:
            y = 0.5 * (min(horizon, row + 1.0) + row)
            _sky_row(row, y, F1 - share, rotation, env, optics, a, b, free, out, owner)
