"""Facades: upright rectangles with a band-limited pattern of windows."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import INT, inlined, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM,
    ENV_BETA,
    ENV_BOUNCE,
    ENV_LAMP,
    ENV_SKY,
    ENV_SUN,
    ENV_WINDOW,
    head_irradiance,
    sky_radiance,
)  # fmt: skip
from pedcross_env.camera.kernels.polygons import NEAR_M, cover_row, grow, row_range
from pedcross_env.camera.kernels.rows import F0, F1, HALF, add_row, hash01

__all__ = ["PANEL_SIZE", "draw_panel", "panel_work"]

# a panel: 0-2 origin, 3-5 axis along it, 6 length, 7 height, 8-10 wall albedo, 11 bay, 12 storey, 13 window share of the
# bay, 14 of the storey, 15 sill height share, 16 seed, 17 base height above the ground, 18 trim albedo factor,
# 19 height of the ground floor, 20 its bay, 21 its windows' share of the bay, 22-23 their sill and lintel, 24 its albedo factor,
# 25 where the cornice starts, 26 which map of lamp light, 27 where on it the panel starts, 28 how it runs along it per metre,
# 29 which row of houses it unites with, 0 or 1;
# a bay of 0: a plain wall
PANEL_SIZE = 30
CHUNK = 480  # pixels worked on at a time: fits the first-level caches
LIT_SHARE = np.float32(0.22)  # of windows at night
INV_PI = np.float32(1 / math.pi)
TWO = np.float32(2.0)
MARGIN = np.float32(0.09)  # width of a window frame
LUMA = (0.2126, 0.7152, 0.0722)


@inlined
def _pulse(p, duty):
    whole = np.floor(p)
    return whole * duty + min(p - whole, duty)


@inlined
def _interval(low_end, high_end, low, high):
    """Length of the overlap of two intervals."""
    return max(F0, min(high_end, high) - max(low_end, low))


@kernel
def _place(xs, ys, v0, v1, v2, least, most, along, up, shift_s, shift_t, inverse, s, t, ws, wt):
    """Inverse depth, position on the panel and the pixel's extent there: all rational in column and row.

    A box as wide as the gradient is long has the variance of the true footprint (two boxes folded), and so its edges' width.
    """
    s0, s1, s2 = along
    t0, t1, t2 = up
    for i in range(xs.shape[0]):
        x, y = xs[i], ys[i]
        inv = min(most, max(least, v0 + v1 * x + v2 * y))  # a pixel's middle may lie beyond the panel's edge
        z = F1 / inv
        a, b = s0 + s1 * x + s2 * y, t0 + t1 * x + t2 * y
        z2 = z * z
        inverse[i] = inv
        s[i] = a * z - shift_s
        t[i] = b * z - shift_t
        across, down = s1 * inv - a * v1, s2 * inv - a * v2
        ws[i] = np.sqrt(across * across + down * down) * z2
        across, down = t1 * inv - b * v1, t2 * inv - b * v2
        wt[i] = np.sqrt(across * across + down * down) * z2


@kernel
def _pattern(s, t, ws, wt, base_z, upper, ground, stone, trim, pane, shade):
    """Band-limited pattern of a front.

    Args:
        s: Along the panel, metres.
        t: Up.
        ws: The pixel's extent along.
        wt: And up.
        base_z: Height of the panel's foot.
        upper: (bay, storey, window share along, up, phase along, up, cornice height).
        ground: (height of the ground floor, its bay, window share, phase, sill, lintel).
        stone: Filled: cover of the ground floor's wall.
        trim: Of cornices and window frames.
        pane: Of glass.
        shade: Share of the light that reaches so deep into the street.
    """
    bay, storey, duty_s, duty_t, phase_s, phase_t, cornice = upper
    floor, low_bay, low_duty, low_phase, sill, lintel = ground
    ms, mt, ml = MARGIN / bay, MARGIN / storey, MARGIN / low_bay
    thin_s, thin_t, thin_l = duty_s - TWO * ms, duty_t - TWO * mt, low_duty - TWO * ml
    inv_bay, inv_storey, inv_low = F1 / bay, F1 / storey, F1 / low_bay
    for i in range(s.shape[0]):
        w = max(ws[i], np.float32(4e-4))
        half = HALF * w
        p, h = s[i] * inv_bay - phase_s, half * inv_bay
        rate = bay / w
        outer = (_pulse(p + h, duty_s) - _pulse(p - h, duty_s)) * rate
        inner = (_pulse(p + h - ms, thin_s) - _pulse(p - h - ms, thin_s)) * rate
        p, h = s[i] * inv_low - low_phase, half * inv_low
        rate = low_bay / w
        low_outer = (_pulse(p + h, low_duty) - _pulse(p - h, low_duty)) * rate
        low_inner = (_pulse(p + h - ml, thin_l) - _pulse(p - h - ml, thin_l)) * rate
        w = max(wt[i], np.float32(4e-4))
        half, inv = HALF * w, F1 / w
        low, high = t[i] - half, t[i] + half
        zone = _interval(low, high, floor, cornice) * inv * inv * storey
        p, h = t[i] * inv_storey - phase_t, half * inv_storey
        up_outer = (_pulse(p + h, duty_t) - _pulse(p - h, duty_t)) * zone
        up_inner = (_pulse(p + h - mt, thin_t) - _pulse(p - h - mt, thin_t)) * zone
        door_outer = _interval(low, high, sill, lintel) * inv
        door_inner = _interval(low, high, sill + MARGIN, lintel - MARGIN) * inv
        glass, low_glass = inner * up_inner, low_inner * door_inner
        frame = max(F0, outer * up_outer - glass) + max(F0, low_outer * door_outer - low_glass)
        ledge = _interval(low, high, floor - np.float32(0.3), floor)
        band = (ledge + _interval(low, high, cornice, np.float32(1e3))) * inv
        stone[i] = _interval(low, high, np.float32(-1e3), floor) * inv
        pane[i] = glass + low_glass
        trim[i] = min(
            F1 - pane[i], band + frame
        )  # a share of the pixel, as panes are: it takes from the wall alone
        shade[i] = np.float32(0.72) + np.float32(0.28) * min(F1, (t[i] + base_z) * np.float32(0.2))


@kernel
def _plain(t, base_z, stone, trim, pane, shade):
    """Fill the same for a wall without windows."""
    for i in range(t.shape[0]):
        stone[i] = F0
        trim[i] = F0
        pane[i] = F0
        shade[i] = np.float32(0.72) + np.float32(0.28) * min(F1, (t[i] + base_z) * np.float32(0.2))


@kernel
def _lit(s, t, ws, wt, upper, ground, seed, share, out):
    """Radiance share of lit windows, by a hash per window.

    It fades to its mean before a pixel could see two windows.
    """
    bay, storey, duty_s, duty_t, phase_s, phase_t, cornice = upper
    floor, low_bay, low_duty, low_phase, sill, lintel = ground
    rise = phase_t - floor / storey
    gap_s, gap_t, low_gap = (
        bay * (F1 - duty_s),
        TWO * storey * min(rise, F1 - rise - duty_t),
        low_bay * (F1 - low_duty),
    )
    ms, mt, ml = MARGIN / bay, MARGIN / storey, MARGIN / low_bay
    thin_s, thin_t, thin_l = duty_s - TWO * ms, duty_t - TWO * mt, low_duty - TWO * ml
    for i in range(out.shape[0]):
        w, v = max(ws[i], np.float32(4e-4)), max(wt[i], np.float32(4e-4))
        low, high = t[i] - HALF * v, t[i] + HALF * v
        p, h = s[i] / bay - phase_s - ms, HALF * w / bay
        across = (_pulse(p + h, thin_s) - _pulse(p - h, thin_s)) * bay / w
        p, h = t[i] / storey - phase_t - mt, HALF * v / storey
        up = (
            (_pulse(p + h, thin_t) - _pulse(p - h, thin_t))
            * storey
            / v
            * _interval(low, high, floor, cornice)
            / v
        )
        column, level = int(math.floor(s[i] / bay)), int(math.floor((t[i] - floor) / storey))
        fade = min(F1, max(F0, TWO * max(w / gap_s, v / gap_t) - F1))
        own = F1 if hash01(column + seed * 131, level + seed) < share else F0
        light = across * up * (own + (share - own) * fade)
        p, h = s[i] / low_bay - low_phase - ml, HALF * w / low_bay
        across = (_pulse(p + h, thin_l) - _pulse(p - h, thin_l)) * low_bay / w
        fade = min(F1, max(F0, TWO * w / low_gap - F1))
        own = F1 if hash01(int(math.floor(s[i] / low_bay)) + seed * 17, seed) < share else F0
        up = _interval(low, high, sill + MARGIN, lintel - MARGIN) / v
        out[i] = light + across * up * (own + (share - own) * fade)


@kernel
def _shine(lit, radiance, out):
    for i in range(out.shape[0]):
        out[i] += lit[i] * radiance


@kernel
def _colour(wall, masonry, frame, glass, light, stone, trim, pane, shade, out):
    """Fill one plane under a uniform light (radiance of a white surface)."""
    for i in range(out.shape[0]):
        surface = wall + wall * (masonry - F1) * stone[i]
        surface = surface * (F1 - pane[i] - trim[i]) + frame * trim[i]
        out[i] = surface * shade[i] * light + pane[i] * glass


@kernel
def _colour_by_lamps(wall, masonry, frame, glass, light, tint, stone, trim, pane, shade, lamp, head, out):
    for i in range(out.shape[0]):
        surface = wall + wall * (masonry - F1) * stone[i]
        surface = surface * (F1 - pane[i] - trim[i]) + frame * trim[i]
        total = light + (lamp[i] * tint + head[i]) * INV_PI
        out[i] = surface * shade[i] * total + pane[i] * glass


@kernel
def _lamp_light(s, t, base, origin_x, axis_x, lamp_map, map_start, map_step, out):
    """Bilinear look-up of the lamps' illuminance on this side's fronts: rows height, columns along the street."""
    rows, columns = lamp_map.shape
    for i in range(out.shape[0]):
        p = min(max((origin_x + axis_x * s[i] - map_start) / map_step, 0.0), columns - 1.001)
        q = min(max((t[i] + base) / map_step, 0.0), rows - 1.001)
        a, b = int(q), int(p)
        fq, fp = q - a, p - b
        low = lamp_map[a, b] + fp * (lamp_map[a, b + 1] - lamp_map[a, b])
        high = lamp_map[a + 1, b] + fp * (lamp_map[a + 1, b + 1] - lamp_map[a + 1, b])
        out[i] = low + fq * (high - low)


@kernel
def _head_at(x, y, inverse, normal, env, table, optics, point):
    focal, cx, cy = optics
    z = 1.0 / max(inverse, np.float32(1e-6))
    point[0], point[1], point[2] = (x - cx) * z / focal, (y - cy) * z / focal, z
    cosine = -(point[0] * normal[0] + point[1] * normal[1] + z * normal[2])
    if cosine <= 0.0:
        return np.float32(0)
    r = math.sqrt(point[0] ** 2 + point[1] ** 2 + z * z)
    return np.float32(head_irradiance(point, env, table, env[ENV_BETA]) * cosine / r)


@kernel
def _head_row(xs, ys, inverse, normal, env, table, optics, point, out):
    """Illuminance from the ego's beam; its table is smooth, so that every eighth pixel of a row is enough."""
    n = out.shape[0]
    before = _head_at(xs[0], ys[0], inverse[0], normal, env, table, optics, point)
    out[0] = before
    i = 0
    while i < n - 1:
        j = i + 1
        while j < n - 1 and j < i + 8 and ys[j + 1] == ys[i]:
            j += 1
        after = _head_at(xs[j], ys[j], inverse[j], normal, env, table, optics, point)
        for k in range(i + 1, j + 1):
            out[k] = before + (after - before) * np.float32((k - i) / (j - i))
        i, before = j, after


@kernel
def _layout(panel):
    """Return the patterns of the upper storeys and of the ground floor, as ``_pattern`` takes them."""
    bay, storey = np.float32(max(panel[11], 0.5)), np.float32(max(panel[12], 0.5))
    floor, low_bay, low_duty = np.float32(panel[19]), np.float32(max(panel[20], 0.5)), np.float32(panel[21])
    duty_s, duty_t = np.float32(panel[13]), np.float32(panel[14])
    upper = (
        bay, storey, duty_s, duty_t, HALF * (F1 - duty_s), np.float32(panel[15]) + floor / storey, np.float32(panel[25]),
    )  # fmt: skip
    ground = (floor, low_bay, low_duty, HALF * (F1 - low_duty), np.float32(panel[22]), np.float32(panel[23]))
    return upper, ground


@kernel
def _paint(panel, env, sun, c):
    """Return one channel's albedo of the wall and of frames, radiance of glass and of a white wall."""
    light = 0.5 * (env[ENV_SKY + c] + env[ENV_BOUNCE + c]) + env[ENV_SUN + c] * sun
    wall = np.float32(panel[8 + c])
    frame = min(np.float32(0.75), wall * np.float32(panel[18]) + np.float32(0.06))
    glass = 0.10 * sky_radiance(0.35, env, c) + 0.02 * light / math.pi
    return wall, frame, np.float32(glass), np.float32(light / math.pi)


@kernel
def _slopes(direction, optics):
    """Return a ray's component along ``direction`` as constant, per column and per row."""
    focal, cx, cy = optics
    per_column, per_row = direction[0] / focal, direction[1] / focal
    constant = direction[2] - per_column * cx - per_row * cy
    return np.float32(constant), np.float32(per_column), np.float32(per_row)


@njit(cache=True)
def panel_work():
    """Allocate what ``draw_panel`` works in."""
    return (
        np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((4097, 3), np.int64),
    )  # fmt: skip


@kernel
def _list_pixels(corners, counts, parts, place, height, width, xs, listed, buf):
    """List pixels from part ``place[0]``, row ``place[1]`` on: their coverage, column and row; few long loops, not many short ones.

    Returns:
        The number of pixels and of the entries (row, first column, column beyond the last) in ``listed``.
    """
    part, row = place[0], place[1]
    n = entries = 0
    top = bottom = 0
    if part < parts:
        top, bottom = row_range(corners[part], counts[part], height)
    row = max(row, top)
    while part < parts and n < CHUNK:
        if row < bottom:
            a, b = cover_row(corners[part], counts[part], row, width, buf[0, n:])
            if b > a:
                listed[entries, 0], listed[entries, 1], listed[entries, 2] = row, a, b
                entries += 1
                for i in range(b - a):
                    buf[21, n + i] = xs[a + i]
                    buf[22, n + i] = np.float32(row + 0.5)
                n += b - a
            row += 1
        else:
            part += 1
            if part < parts:
                row, bottom = row_range(corners[part], counts[part], height)
    place[0], place[1] = part, row
    return n, entries


@kernel
def draw_panel(
    panel,
    seen,
    rotation,
    camera,
    env,
    table,
    lamp_maps,
    map_frame,
    optics,
    xs,
    size,
    scratch,
    buf,
    work,
    spans,
):
    """Draw what is seen of one panel into the buildings' scratch planes.

    ``seen`` is (corners, their numbers, parts) from ``visible.visible_parts``; ``work`` is from ``panel_work``; ``lamp_maps`` is
    (maps, rows, columns) lx, right and left fronts first, ``map_frame`` (start x, step).
    """
    focal, cx, cy = optics
    height, width = size
    planes = scratch[0]
    part_corners, part_counts, parts = seen
    nx, ny = panel[4], -panel[3]
    axis, normal, up, origin, point, listed = work
    for k in range(3):
        axis[k] = rotation[k, 0] * panel[3] + rotation[k, 1] * panel[4]
        normal[k] = rotation[k, 0] * nx + rotation[k, 1] * ny
        up[k] = rotation[k, 2]
        origin[k] = (
            rotation[k, 0] * (panel[0] - camera[0]) + rotation[k, 1] * (panel[1] - camera[1])
            + rotation[k, 2] * (panel[2] - camera[2])
        )  # fmt: skip
    across, rise = axis[2] * panel[6], up[2] * panel[7]
    nearest = max(NEAR_M, origin[2] + min(0.0, across) + min(0.0, rise))
    farthest = max(NEAR_M, origin[2] + max(0.0, across) + max(0.0, rise))
    distance = normal[0] * origin[0] + normal[1] * origin[1] + normal[2] * origin[2]
    shift_s = axis[0] * origin[0] + axis[1] * origin[1] + axis[2] * origin[2]
    shift_t = up[0] * origin[0] + up[1] * origin[1] + up[2] * origin[2]
    sun = max(0.0, normal[0] * env[0] + normal[1] * env[1] + normal[2] * env[2])
    night = env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0
    base_z = np.float32(panel[17])
    upper, ground = _layout(panel)
    v1, v2 = normal[0] / focal / distance, normal[1] / focal / distance
    v0 = normal[2] / distance - v1 * cx - v2 * cy
    inverse, s, t, ws, wt, stone, trim, pane, shade, lit, lamp, head = (
        2,
        7,
        8,
        9,
        10,
        11,
        12,
        13,
        14,
        15,
        16,
        17,
    )
    place = listed[4096]
    place[0] = place[1] = 0
    while place[0] < parts:
        n, entries = _list_pixels(part_corners, part_counts, parts, place, height, width, xs, listed, buf)
        if n == 0:
            continue
        x, y = buf[21, :n], buf[22, :n]
        _place(
            x, y, np.float32(v0), np.float32(v1), np.float32(v2), np.float32(1.0 / farthest), np.float32(1.0 / nearest), _slopes(axis, optics), _slopes(up, optics), np.float32(shift_s),
            np.float32(shift_t), buf[inverse, :n], buf[s, :n], buf[t, :n], buf[ws, :n], buf[wt, :n],
        )  # fmt: skip
        if panel[11] > 0:
            _pattern(
                buf[s, :n], buf[t, :n], buf[ws, :n], buf[wt, :n], base_z, upper, ground, buf[stone, :n], buf[trim, :n],
                buf[pane, :n], buf[shade, :n],
            )  # fmt: skip
        else:
            _plain(buf[t, :n], base_z, buf[stone, :n], buf[trim, :n], buf[pane, :n], buf[shade, :n])
        if night:
            _lamp_light(
                buf[s, :n], buf[t, :n], panel[17], panel[27], panel[28], lamp_maps[int(panel[26])], map_frame[0], map_frame[1], buf[lamp, :n],
            )  # fmt: skip
            _head_row(x, y, buf[inverse, :n], normal, env, table, optics, point, buf[head, :n])
            for c in range(3):
                wall, frame, glass, light = _paint(panel, env, sun, c)
                _colour_by_lamps(
                    wall, np.float32(panel[24]), frame, glass, light, np.float32(env[ENV_LAMP + c]), buf[stone, :n],
                    buf[trim, :n], buf[pane, :n], buf[shade, :n], buf[lamp, :n], buf[head, :n], buf[4 + c, :n],
                )  # fmt: skip
        elif planes.shape[0] == 1:
            grey_wall, grey_frame, grey_glass = F0, F0, F0
            for c in range(3):
                wall, frame, glass, light = _paint(panel, env, sun, c)
                weight = np.float32(LUMA[c])
                grey_wall += weight * light * wall
                grey_frame += weight * light * frame
                grey_glass += weight * glass
            _colour(
                grey_wall, np.float32(panel[24]), grey_frame, grey_glass, F1, buf[stone, :n], buf[trim, :n], buf[pane, :n],
                buf[shade, :n], buf[4, :n],
            )  # fmt: skip
        else:
            for c in range(3):
                wall, frame, glass, light = _paint(panel, env, sun, c)
                _colour(
                    wall, np.float32(panel[24]), frame, glass, light, buf[stone, :n], buf[trim, :n], buf[pane, :n], buf[shade, :n],
                    buf[4 + c, :n],
                )  # fmt: skip
        if env[ENV_WINDOW] > 0 and panel[11] > 0:
            _lit(
                buf[s, :n],
                buf[t, :n],
                buf[ws, :n],
                buf[wt, :n],
                upper,
                ground,
                int(panel[16]),
                LIT_SHARE,
                buf[lit, :n],
            )
            for c in range(3):
                _shine(buf[lit, :n], np.float32(env[ENV_WINDOW + c]), buf[4 + c, :n])
        if planes.shape[0] == 1 and night:
            _to_luminance(buf[4, :n], buf[5, :n], buf[6, :n])
        at = INT(0)
        for r in range(entries):
            row, a, b = listed[r, 0], listed[r, 1], listed[r, 2]
            add_row(buf, 4, 0, 2, at, scratch, row, a, b)
            grow(spans, row, a, b)
            at += b - a


@kernel
def _to_luminance(red, green, blue):
    for i in range(red.shape[0]):
        red[i] = np.float32(0.2126) * red[i] + np.float32(0.7152) * green[i] + np.float32(0.0722) * blue[i]
