"""Facades: upright rectangles with a band-limited pattern of windows."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import inlined, kernel
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
from pedcross_env.camera.kernels.polygons import MAX_CORNERS, cover_row, grow, project_clipped, row_range
from pedcross_env.camera.kernels.rows import F0, F1, HALF, fill_row, hash01, merge_row

__all__ = ["PANEL_SIZE", "draw_panel", "panel_work"]

# a panel: 0-2 origin, 3-5 axis along it, 6 length, 7 height, 8-10 wall albedo, 11 bay, 12 storey, 13 window share of the
# bay, 14 of the storey, 15 sill height share, 16 seed, 17 base height above the ground, 18 trim albedo factor,
# 19 height of the ground floor, 20 its bay, 21 its windows' share of the bay, 22-23 their sill and lintel, 24 its albedo factor,
# 25 where the cornice starts, 26 which map of lamp light, 27 where on it the panel starts, 28 how it runs along it per metre;
# a bay of 0: a plain wall
PANEL_SIZE = 29
CHUNK = 1500  # pixels worked on at a time: fits the first-level caches
LIT_SHARE = np.float32(0.22)  # of windows at night
INV_PI = np.float32(1 / math.pi)


@inlined
def _pulse(p, duty):
    whole = np.floor(p)
    return whole * duty + min(p - whole, duty)


@kernel
def _inverse_depth(xs, ys, i0, i1, i2, inverse):
    for i in range(xs.shape[0]):
        inverse[i] = i0 + i1 * xs[i] + i2 * ys[i]


@kernel
def _coordinates(xs, ys, inverse, i1, i2, n0, n1, n2, shift, coordinate, footprint):
    """Position on the panel and the pixel's extent there, from quantities linear in column and row.

    A box as wide as the gradient is long has the variance of the true footprint (two boxes folded), and so its edges' width.
    """
    for i in range(xs.shape[0]):
        inv = inverse[i]
        num = n0 + n1 * xs[i] + n2 * ys[i]
        z = F1 / max(inv, np.float32(1e-6))
        coordinate[i] = num * z - shift
        across, down = n1 * inv - num * i1, n2 * inv - num * i2
        footprint[i] = np.sqrt(across * across + down * down) * z * z


@kernel
def _windows(coordinate, footprint, period, duty, margin, phase, outer, inner):
    """Box-filtered pulse trains: outer with its frame, inner the glass."""
    for i in range(coordinate.shape[0]):
        p = coordinate[i] / period - phase
        w = max(footprint[i] / period, np.float32(1e-4))
        lo, hi = p - HALF * w, p + HALF * w
        outer[i] = (_pulse(hi, duty) - _pulse(lo, duty)) / w
        thin = duty - np.float32(2.0) * margin
        inner[i] = (_pulse(hi - margin, thin) - _pulse(lo - margin, thin)) / w


@inlined
def _interval(t, w, low, high):
    """Share of the box of width ``w`` around ``t`` that lies between ``low`` and ``high``."""
    return max(F0, min(t + HALF * w, high) - max(t - HALF * w, low)) / w


@kernel
def _upper_zone(t, footprint, floor, cornice, upper, upper_glass):
    """Mask the upper storeys' windows to their zone."""
    for i in range(t.shape[0]):
        zone = _interval(t[i], max(footprint[i], np.float32(1e-4)), floor, cornice)
        upper[i] *= zone
        upper_glass[i] *= zone


@kernel
def _low_windows(t, footprint, sill, lintel, margin, outer, glass):
    for i in range(t.shape[0]):
        w = max(footprint[i], np.float32(1e-4))
        outer[i] = _interval(t[i], w, sill, lintel)
        glass[i] = _interval(t[i], w, sill + margin, lintel - margin)


@kernel
def _bands(t, footprint, floor, cornice, base, band):
    """Cover of the ground floor's wall, and of the cornices."""
    for i in range(t.shape[0]):
        w = max(footprint[i], np.float32(1e-4))
        base[i] = _interval(t[i], w, np.float32(-1e3), floor)
        band[i] = _interval(t[i], w, floor - np.float32(0.3), floor) + _interval(
            t[i], w, cornice, np.float32(1e3)
        )


@kernel
def _lit(s, t, ws, wt, bay, storey, low_bay, floor, gaps, seed, share, out, low_out):
    """Share of windows that are lit, by a hash per window.

    It fades to its mean before a pixel could see two windows: ``gaps`` are the walls between them (metres: along, up, and along
    the ground floor).
    """
    gap_s, gap_t, low_gap = gaps
    for i in range(out.shape[0]):
        column = int(math.floor(s[i] / bay))
        level = int(math.floor((t[i] - floor) / storey))
        fade = min(F1, max(F0, np.float32(2.0) * max(ws[i] / gap_s, wt[i] / gap_t) - F1))
        own = F1 if hash01(column + seed * 131, level + seed) < share else F0
        out[i] = own + (share - own) * fade
        fade = min(F1, max(F0, np.float32(2.0) * ws[i] / low_gap - F1))
        own = F1 if hash01(int(math.floor(s[i] / low_bay)) + seed * 17, seed) < share else F0
        low_out[i] = own + (share - own) * fade


@kernel
def _frames(inner_s, outer_t, inner_t, low_outer_s, low_inner_s, low_outer_t, low_inner_t, outer_s):
    """Turn the upper windows' cover along the street into the cover of all window frames."""
    for i in range(outer_s.shape[0]):
        low = max(F0, low_outer_s[i] * low_outer_t[i] - low_inner_s[i] * low_inner_t[i])
        outer_s[i] = max(F0, outer_s[i] * outer_t[i] - inner_s[i] * inner_t[i]) + low


@kernel
def _lit_panes(inner_s, inner_t, low_inner_s, low_inner_t, lit, low_lit, out):
    for i in range(out.shape[0]):
        out[i] = inner_s[i] * inner_t[i] * lit[i] + low_inner_s[i] * low_inner_t[i] * low_lit[i]


@kernel
def _panes(inner_t, low_inner_s, low_inner_t, inner_s):
    for i in range(inner_s.shape[0]):
        inner_s[i] = inner_s[i] * inner_t[i] + low_inner_s[i] * low_inner_t[i]


@kernel
def _colour(wall, stone, trim, glass, lit_radiance, height, base_z, frame, pane, lit, base, band, light, out):
    for i in range(out.shape[0]):
        shade = np.float32(0.72) + np.float32(0.28) * min(F1, (height[i] + base_z) * np.float32(0.2))
        surface = wall + (stone - wall) * base[i]
        bare = (
            F1 - pane[i]
        )  # frames and bands are shares of the pixel, as panes are: they take from the wall alone
        surface = bare * surface + min(bare, band[i] + frame[i]) * (trim - surface)
        out[i] = surface * light[i] * shade + pane[i] * glass + lit[i] * lit_radiance


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
def _light_row(constant, lamp, lamp_tint, head, out):
    for i in range(out.shape[0]):
        out[i] = (constant + lamp[i] * lamp_tint + head[i]) * INV_PI


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


@njit(cache=True)
def panel_work():
    """Allocate what ``draw_panel`` works in."""
    return (
        np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((4, 3)), np.empty((MAX_CORNERS, 2)),
        np.empty(3), np.empty((4097, 2), np.int64),
    )  # fmt: skip


@kernel
def draw_panel(
    panel, rotation, camera, env, table, lamp_maps, map_frame, optics, xs, size, scratch, buf, work, spans
):
    """Draw one panel into the buildings' scratch planes; nothing where the camera is behind it.

    ``work`` is from ``panel_work``; ``lamp_maps`` is (maps, rows, columns) lx, right and left fronts first, ``map_frame`` (start x, step).
    """
    focal, cx, cy = optics
    height, width = size
    planes = scratch[0]
    # the outward normal is axis x up, so that a panel is seen counter-clockwise
    nx, ny = panel[4], -panel[3]
    if (camera[0] - panel[0]) * nx + (camera[1] - panel[1]) * ny <= 1e-6:
        return
    axis, normal, up, origin, corners3, corners, point, listed = work
    for k in range(3):
        axis[k] = rotation[k, 0] * panel[3] + rotation[k, 1] * panel[4]
        normal[k] = rotation[k, 0] * nx + rotation[k, 1] * ny
        up[k] = rotation[k, 2]
        origin[k] = (
            rotation[k, 0] * (panel[0] - camera[0]) + rotation[k, 1] * (panel[1] - camera[1])
            + rotation[k, 2] * (panel[2] - camera[2])
        )  # fmt: skip
    for i in range(4):
        s = panel[6] if i in (1, 2) else 0.0
        t = panel[7] if i >= 2 else 0.0
        for k in range(3):
            corners3[i, k] = origin[k] + s * axis[k] + t * up[k]
    count = project_clipped(corners3, 4, focal, cx, cy, corners)
    if count < 3:
        return
    top, bottom = row_range(corners, count, height)
    distance = normal[0] * origin[0] + normal[1] * origin[1] + normal[2] * origin[2]
    shift_s = axis[0] * origin[0] + axis[1] * origin[1] + axis[2] * origin[2]
    shift_t = up[0] * origin[0] + up[1] * origin[1] + up[2] * origin[2]
    sun = max(0.0, normal[0] * env[0] + normal[1] * env[1] + normal[2] * env[2])
    night = env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0
    bay, storey = np.float32(max(panel[11], 0.5)), np.float32(max(panel[12], 0.5))
    patterned = panel[11] > 0
    low_bay, floor = np.float32(max(panel[20], 0.5)), np.float32(panel[19])
    duty_s, duty_t, seed = np.float32(panel[13]), np.float32(panel[14]), int(panel[16])
    phase_s, phase_t = np.float32(0.5 * (1 - panel[13])), np.float32(panel[15])
    v1, v2 = normal[0] / focal / distance, normal[1] / focal / distance
    v0 = normal[2] / distance - v1 * cx - v2 * cy
    row = top
    while row < bottom:
        first, n = row, 0
        while (
            row < bottom and n < CHUNK
        ):  # gather a list of pixels: few long loops instead of many short ones
            a, b = cover_row(corners, count, row, width, buf[0, n:])
            listed[row - first, 0], listed[row - first, 1] = a, b
            for i in range(b - a):
                buf[21, n + i] = xs[a + i]
                buf[22, n + i] = np.float32(row + 0.5)
            n += b - a
            row += 1
        if n == 0:
            continue
        x, y = buf[21, :n], buf[22, :n]
        _inverse_depth(x, y, np.float32(v0), np.float32(v1), np.float32(v2), buf[2, :n])
        for k in range(2):
            d = axis if k == 0 else up
            n1, n2 = d[0] / focal, d[1] / focal
            _coordinates(
                x, y, buf[2, :n], np.float32(v1), np.float32(v2), np.float32(d[2] - n1 * cx - n2 * cy), np.float32(n1),
                np.float32(n2), np.float32(shift_s if k == 0 else shift_t), buf[7 + k, :n], buf[9 + k, :n],
            )  # fmt: skip
        if patterned:
            margin = np.float32(0.09)
            _windows(buf[7, :n], buf[9, :n], bay, duty_s, margin / bay, phase_s, buf[12, :n], buf[13, :n])
            phase_up = phase_t + floor / storey
            _windows(
                buf[8, :n], buf[10, :n], storey, duty_t, margin / storey, phase_up, buf[14, :n], buf[15, :n]
            )
            phase_low = np.float32(0.5 * (1 - panel[21]))
            _windows(
                buf[7, :n],
                buf[9, :n],
                low_bay,
                np.float32(panel[21]),
                margin / low_bay,
                phase_low,
                buf[16, :n],
                buf[17, :n],
            )
            cornice = np.float32(panel[25])
            _upper_zone(buf[8, :n], buf[10, :n], floor, cornice, buf[14, :n], buf[15, :n])
            sill, lintel = np.float32(panel[22]), np.float32(panel[23])
            _low_windows(buf[8, :n], buf[10, :n], sill, lintel, margin, buf[18, :n], buf[19, :n])
            _bands(buf[8, :n], buf[10, :n], floor, cornice, buf[20, :n], buf[11, :n])
            if env[ENV_WINDOW] > 0:
                gaps = (
                    bay * (F1 - duty_s), np.float32(2.0) * storey * min(phase_t, F1 - phase_t - duty_t),
                    low_bay * np.float32(1 - panel[21]),
                )  # fmt: skip
                _lit(
                    buf[7, :n], buf[8, :n], buf[9, :n], buf[10, :n], bay, storey, low_bay, floor, gaps, seed, LIT_SHARE,
                    buf[3, :n], buf[23, :n],
                )  # fmt: skip
            _frames(
                buf[13, :n], buf[14, :n], buf[15, :n], buf[16, :n], buf[17, :n], buf[18, :n], buf[19, :n], buf[12, :n],
            )  # fmt: skip
            if env[ENV_WINDOW] > 0:
                _lit_panes(
                    buf[13, :n], buf[15, :n], buf[17, :n], buf[19, :n], buf[3, :n], buf[23, :n], buf[14, :n]
                )
            else:
                fill_row(F0, buf[14, :n])
            _panes(buf[15, :n], buf[17, :n], buf[19, :n], buf[13, :n])
        else:
            for k in (11, 12, 13, 14, 20):
                fill_row(F0, buf[k, :n])
        if night:
            _lamp_light(
                buf[7, :n],
                buf[8, :n],
                panel[17],
                panel[27],
                panel[28],
                lamp_maps[int(panel[26])],
                map_frame[0],
                map_frame[1],
                buf[17, :n],
            )
            _head_row(x, y, buf[2, :n], normal, env, table, optics, point, buf[18, :n])
        else:
            fill_row(F0, buf[17, :n])
            fill_row(F0, buf[18, :n])
        for c in range(3):
            sky, bounce = env[ENV_SKY + c], env[ENV_BOUNCE + c]
            constant = 0.5 * (sky + bounce) + env[ENV_SUN + c] * sun
            _light_row(
                np.float32(constant), buf[17, :n], np.float32(env[ENV_LAMP + c]), buf[18, :n], buf[19, :n]
            )
            wall = np.float32(panel[8 + c])
            trim = min(np.float32(0.75), wall * np.float32(panel[18]) + np.float32(0.06))
            glass = np.float32(0.10 * sky_radiance(0.35, env, c) + 0.02 * constant / math.pi)
            _colour(
                wall, wall * np.float32(panel[24]), trim, glass, np.float32(env[ENV_WINDOW + c]), buf[8, :n], np.float32(panel[17]),
                buf[12, :n], buf[13, :n], buf[14, :n], buf[20, :n], buf[11, :n], buf[19, :n], buf[4 + c, :n],
            )  # fmt: skip
        if planes.shape[0] == 1:
            _to_luminance(buf[4, :n], buf[5, :n], buf[6, :n])
        at = 0
        for r in range(first, row):
            a, b = listed[r - first, 0], listed[r - first, 1]
            if b > a:
                end = at + b - a
                merge_row(buf, 4, 0, 2, at, scratch, r, a, b)
                grow(spans, r, a, b)
                at = end


@kernel
def _to_luminance(red, green, blue):
    for i in range(red.shape[0]):
        red[i] = np.float32(0.2126) * red[i] + np.float32(0.7152) * green[i] + np.float32(0.0722) * blue[i]
