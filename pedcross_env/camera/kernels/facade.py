"""Facades: upright rectangles with a band-limited pattern of windows."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM, ENV_BEAM_TINT, ENV_BETA, ENV_BOUNCE, ENV_LAMP, ENV_SKY, ENV_SUN, ENV_WINDOW, head_irradiance, sky_radiance,
)  # fmt: skip
from pedcross_env.camera.kernels.polygons import MAX_CORNERS, _column_range, _row_range, grow, polygon_edges, project_clipped
from pedcross_env.camera.kernels.rows import F0, F1, HALF, coverage_row, hash01, merge_row

__all__ = ["PANEL_SIZE", "draw_panel"]

# a panel: 0-2 origin, 3-5 axis along it, 6 length, 7 height, 8-10 wall albedo, 11 bay, 12 storey, 13 window share of the
# bay, 14 of the storey, 15 sill height share, 16 seed, 17 base height above the ground, 18 trim albedo factor, 19 gloss
PANEL_SIZE = 20
INV_PI = np.float32(1 / math.pi)


@njit(cache=True, inline="always")
def _pulse(p, duty):
    whole = np.floor(p)
    return whole * duty + min(p - whole, duty)


@njit(cache=True)
def _coordinates(xs, i0, i1, n0, n1, shift, dv_num, dv_inv, inverse, coordinate, footprint):
    """Position on the panel and the pixel's extent there (L1), from quantities linear in the column."""
    for i in range(xs.shape[0]):
        inv = i0 + i1 * xs[i]
        num = n0 + n1 * xs[i]
        z = F1 / max(inv, np.float32(1e-6))
        inverse[i] = inv
        coordinate[i] = num * z - shift
        footprint[i] = (abs(n1 * inv - num * i1) + abs(dv_num * inv - num * dv_inv)) * z * z


@njit(cache=True)
def _windows(coordinate, footprint, period, duty, margin, phase, outer, inner):
    """Box-filtered pulse trains: outer with its frame, inner the glass."""
    for i in range(coordinate.shape[0]):
        p = coordinate[i] / period - phase
        w = max(footprint[i] / period, np.float32(1e-4))
        lo, hi = p - HALF * w, p + HALF * w
        outer[i] = (_pulse(hi, duty) - _pulse(lo, duty)) / w
        thin = duty - np.float32(2.0) * margin
        inner[i] = (_pulse(hi - margin, thin) - _pulse(lo - margin, thin)) / w


@njit(cache=True)
def _lit(s, t, ws, wt, bay, storey, s_phase, t_phase, seed, share, out):
    """Share of windows that are lit, by a hash per window that fades to its mean where windows are below a pixel."""
    for i in range(out.shape[0]):
        column = int(math.floor(s[i] / bay - s_phase))
        level = int(math.floor(t[i] / storey - t_phase))
        fade = min(F1, max(F0, np.float32(2.0) * (max(ws[i] / bay, wt[i] / storey) - np.float32(0.3))))
        h = hash01(column + seed * 131, level + seed)
        own = F1 if h < share else F0
        out[i] = own + (share - own) * fade


@njit(cache=True)
def _colour(wall, trim, glass, lit_radiance, height, outer_s, outer_t, inner_s, inner_t, lit, light, out):
    for i in range(out.shape[0]):
        outer = outer_s[i] * outer_t[i]
        inner = min(outer, inner_s[i] * inner_t[i])
        shade = np.float32(0.72) + np.float32(0.28) * min(F1, height[i] * np.float32(0.2))
        surface = wall + (trim - wall) * outer
        out[i] = (surface * (F1 - inner / max(outer, np.float32(1e-3)) * outer)) * light[i] * shade
        out[i] = out[i] + inner * (glass + lit[i] * lit_radiance)


@njit(cache=True)
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


@njit(cache=True)
def _light_row(constant, lamp, lamp_tint, head, out):
    for i in range(out.shape[0]):
        out[i] = (constant + lamp[i] * lamp_tint + head[i]) * INV_PI


@njit(cache=True)
def _head_row(xs, y, inverse, normal, env, table, optics, out):
    point = np.empty(3)
    focal, cx, cy = optics
    for i in range(out.shape[0]):
        z = 1.0 / max(inverse[i], np.float32(1e-6))
        point[0], point[1], point[2] = (xs[i] - cx) * z / focal, (y - cy) * z / focal, z
        r = math.sqrt(point[0] ** 2 + point[1] ** 2 + z * z)
        cosine = -(point[0] * normal[0] + point[1] * normal[1] + z * normal[2]) / r
        out[i] = head_irradiance(point, env, table, env[ENV_BETA]) * max(0.0, cosine)


@njit(cache=True)
def draw_panel(panel, rotation, camera, env, table, lamp_maps, map_frame, optics, xs, size, scratch, buf, box):
    """Draw one panel into the buildings' scratch planes; nothing where the camera is behind it.

    ``lamp_maps`` is (2, rows, columns) lx on the right and left fronts, ``map_frame`` (start x, step).
    """
    focal, cx, cy = optics
    height, width = size
    planes, alpha, inverse = scratch
    # the outward normal is axis x up, so that a panel is seen counter-clockwise
    nx, ny = panel[4], -panel[3]
    if (camera[0] - panel[0]) * nx + (camera[1] - panel[1]) * ny <= 1e-6:
        return
    axis, normal, up, origin = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(3):
        axis[k] = rotation[k, 0] * panel[3] + rotation[k, 1] * panel[4]
        normal[k] = rotation[k, 0] * nx + rotation[k, 1] * ny
        up[k] = rotation[k, 2]
        origin[k] = (
            rotation[k, 0] * (panel[0] - camera[0]) + rotation[k, 1] * (panel[1] - camera[1])
            + rotation[k, 2] * (panel[2] - camera[2])
        )  # fmt: skip
    corners3, corners = np.empty((4, 3)), np.empty((MAX_CORNERS, 2))
    for i in range(4):
        s = panel[6] if i in (1, 2) else 0.0
        t = panel[7] if i >= 2 else 0.0
        for k in range(3):
            corners3[i, k] = origin[k] + s * axis[k] + t * up[k]
    count = project_clipped(corners3, 4, focal, cx, cy, corners)
    if count < 3:
        return
    edges = np.empty((MAX_CORNERS, 3), np.float32)
    edge_count = polygon_edges(corners, count, edges)
    top, bottom = _row_range(corners, count, height)
    distance = normal[0] * origin[0] + normal[1] * origin[1] + normal[2] * origin[2]
    shift_s = axis[0] * origin[0] + axis[1] * origin[1] + axis[2] * origin[2]
    shift_t = up[0] * origin[0] + up[1] * origin[1] + up[2] * origin[2]
    side = 0 if panel[1] < 0 else 1
    sun = max(0.0, normal[0] * env[0] + normal[1] * env[1] + normal[2] * env[2])
    night = env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0
    bay, storey = np.float32(max(panel[11], 0.5)), np.float32(max(panel[12], 0.5))
    patterned = panel[11] > 0
    duty_s, duty_t, seed = np.float32(panel[13]), np.float32(panel[14]), int(panel[16])
    phase_s, phase_t = np.float32(0.5 * (1 - panel[13])), np.float32(panel[15])
    for row in range(top, bottom):
        a, b = _column_range(corners, count, row, width)
        n = b - a
        if n <= 0:
            continue
        y = row + 0.5
        yn = (y - cy) / focal
        i1, iv = normal[0] / focal / distance, normal[1] / focal / distance
        i0 = (normal[1] * yn + normal[2]) / distance - cx * i1
        x = xs[a:b]
        coverage_row(edges, edge_count, np.float32(y), x, buf[12:16, :n], buf[0, :n])
        for k in range(2):
            d = axis if k == 0 else up
            n1 = d[0] / focal
            _coordinates(
                x, np.float32(i0), np.float32(i1), np.float32(d[1] * yn + d[2] - cx * n1), np.float32(n1),
                np.float32(shift_s if k == 0 else shift_t), np.float32(d[1] / focal), np.float32(iv),
                buf[2, :n], buf[7 + k, :n], buf[9 + k, :n],
            )  # fmt: skip
        if patterned:
            _windows(buf[7, :n], buf[9, :n], bay, duty_s, np.float32(0.09) / bay, phase_s, buf[12, :n], buf[13, :n])
            _windows(buf[8, :n], buf[10, :n], storey, duty_t, np.float32(0.09) / storey, phase_t, buf[14, :n], buf[15, :n])
            _lit(
                buf[7, :n], buf[8, :n], buf[9, :n], buf[10, :n], bay, storey, phase_s, phase_t, seed,
                np.float32(0.22), buf[16, :n],
            )  # fmt: skip
        else:
            buf[12:17, :n] = F0
        if night:
            _lamp_light(buf[7, :n], buf[8, :n], panel[17], panel[0], panel[3], lamp_maps[side], map_frame[0], map_frame[1], buf[17, :n])
            _head_row(x, y, buf[2, :n], normal, env, table, optics, buf[18, :n])
        else:
            buf[17:19, :n] = F0
        buf[20, :n] = buf[8, :n] + np.float32(panel[17])
        for c in range(3):
            sky, bounce = env[ENV_SKY + c], env[ENV_BOUNCE + c]
            constant = 0.5 * (sky + bounce) + env[ENV_SUN + c] * sun
            _light_row(np.float32(constant), buf[17, :n], np.float32(env[ENV_LAMP + c]), buf[18, :n], buf[19, :n])
            wall = np.float32(panel[8 + c])
            trim = min(np.float32(0.75), wall * np.float32(panel[18]) + np.float32(0.06))
            glass = np.float32(0.10 * sky_radiance(0.35, env, c) + 0.02 * constant / math.pi)
            _colour(
                wall, trim, glass, np.float32(env[ENV_WINDOW + c]), buf[20, :n], buf[12, :n], buf[14, :n], buf[13, :n], buf[15, :n],
                buf[16, :n], buf[19, :n], buf[4 + c, :n],
            )  # fmt: skip
        if planes.shape[0] == 1:
            _to_luminance(buf[4, :n], buf[5, :n], buf[6, :n])
        merge_row(
            buf[4 : 4 + planes.shape[0], :n], buf[0, :n], buf[2, :n],
            planes[:, row, a:b], alpha[row, a:b], inverse[row, a:b], buf[12:14, :n],
        )  # fmt: skip
        grow(box, a, b, row, row + 1)


@njit(cache=True)
def _to_luminance(red, green, blue):
    for i in range(red.shape[0]):
        red[i] = np.float32(0.2126) * red[i] + np.float32(0.7152) * green[i] + np.float32(0.0722) * blue[i]
