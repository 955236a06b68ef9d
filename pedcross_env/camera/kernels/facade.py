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
from pedcross_env.camera.kernels.polygons import (
    MAX_CORNERS,
    NEAR_M,
    cover_row,
    grow,
    row_range,
    slanted_edges,
)
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
COVER, INVERSE, COLOUR, S, T, WS, WT = 0, 2, 4, 7, 8, 9, 10  # rows of the work space
STONE, TRIM, PANE, SHADE, LIT, LAMP, HEAD, X, Y = 11, 12, 13, 14, 15, 16, 17, 21, 22
LIT_SHARE = np.float32(0.22)  # of windows at night
INV_PI = np.float32(1 / math.pi)
TWO = np.float32(2.0)
MARGIN = np.float32(0.09)  # width of a window frame
LEAST_HALF = np.float32(2e-4)  # of a pixel's extent, metres
LUMA = (0.2126, 0.7152, 0.0722)


@inlined
def _pulse(p, duty):
    whole = np.floor(p)
    return whole * duty + min(p - whole, duty)


@inlined
def _clamp(p, most):
    return max(F0, min(p, most))


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
    thin_s, thin_t, thin_l = (
        max(F0, duty_s - TWO * ms),
        max(F0, duty_t - TWO * mt),
        max(F0, low_duty - TWO * ml),
    )
    inv_bay, inv_storey, inv_low = F1 / bay, F1 / storey, F1 / low_bay
    for i in range(s.shape[0]):
        half = max(HALF * ws[i], LEAST_HALF)
        rate = HALF / half
        first, last = (s[i] - half) * inv_bay - phase_s, (s[i] + half) * inv_bay - phase_s
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m  # place within the bay, of the pixel's either border
        outer = ((m - n) * duty_s + (min(last, duty_s) - min(first, duty_s))) * (bay * rate)
        inner = ((m - n) * thin_s + (_clamp(last - ms, thin_s) - _clamp(first - ms, thin_s))) * (bay * rate)
        first, last = (s[i] - half) * inv_low - low_phase, (s[i] + half) * inv_low - low_phase
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m
        low_outer = ((m - n) * low_duty + (min(last, low_duty) - min(first, low_duty))) * (low_bay * rate)
        low_inner = ((m - n) * thin_l + (_clamp(last - ml, thin_l) - _clamp(first - ml, thin_l))) * (
            low_bay * rate
        )
        half = max(HALF * wt[i], LEAST_HALF)
        inv = HALF / half
        low, high = t[i] - half, t[i] + half
        first, last = low * inv_storey - phase_t, high * inv_storey - phase_t
        n, m = np.floor(first), np.floor(last)
        first, last = first - n, last - m
        above_floor, above_cornice = min(max(floor, low), high), min(max(cornice, low), high)
        zone = (above_cornice - above_floor) * inv * inv * storey
        up_outer = ((m - n) * duty_t + (min(last, duty_t) - min(first, duty_t))) * zone
        up_inner = ((m - n) * thin_t + (_clamp(last - mt, thin_t) - _clamp(first - mt, thin_t))) * zone
        door_outer = _interval(low, high, sill, lintel) * inv
        door_inner = _interval(low, high, sill + MARGIN, lintel - MARGIN) * inv
        glass, low_glass = inner * up_inner, low_inner * door_inner
        frame = max(F0, outer * up_outer - glass) + max(F0, low_outer * door_outer - low_glass)
        below_ledge = min(max(floor - np.float32(0.3), low), high)
        band = ((above_floor - below_ledge) + (high - above_cornice)) * inv
        glass += low_glass
        stone[i] = (above_floor - low) * inv
        pane[i] = glass
        trim[i] = min(
            F1 - glass, band + frame
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
        np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((4096, 3), np.int64), np.empty(2, np.int64),
        np.empty((MAX_CORNERS, 5)),
    )  # fmt: skip


@kernel
def _upright_row(edges, sides, row, width, out):
    """Cover a row whose two borders are steep lines, as most are; return its columns, (-1, -1) for any other."""
    left = right = -1
    for e in range(sides):
        if edges[e, 0] < row + 1.0 and edges[e, 1] > row:
            if left >= 0 or edges[e, 0] > row or edges[e, 1] < row + 1.0:
                return -1, -1
            left, right = right, e
    if left < 0:
        return -1, -1
    x0 = edges[left, 2] + edges[left, 3] * (row - edges[left, 0])
    x1 = edges[right, 2] + edges[right, 3] * (row - edges[right, 0])
    y0, y1 = x0 + edges[left, 3], x1 + edges[right, 3]
    if x0 + y0 > x1 + y1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    a, b = 0, width
    if x0 > 0.0 or y0 > 0.0:
        if x0 < 0.0 or y0 < 0.0 or x0 >= width:
            return -1, -1
        a = int(x0)
        if a != int(y0):
            return -1, -1
    if x1 < width or y1 < width:
        if x1 >= width or y1 >= width or x1 < 0.0:
            return -1, -1
        b = int(x1) + 1
        if b != int(y1) + 1:
            return -1, -1
    for i in range(b - a):
        out[i] = F1
    if x0 > 0.0:
        out[0] -= np.float32(0.5 * (x0 + y0) - a)
    if x1 < width:
        out[b - 1 - a] -= np.float32(b - 0.5 * (x1 + y1))
    return a, b


@kernel
def _list_pixels(edges, sides, row, bottom, width, xs, listed, full, buf):
    """List a part's pixels from ``row`` on after those that are listed already, until there are enough.

    ``full`` holds the number of pixels and of the entries (row, first column, column beyond the last) in ``listed``.

    Returns:
        The row to go on from.
    """
    n, entries = full[0], full[1]
    while row < bottom and n < CHUNK:
        a, b = _upright_row(edges, sides, row, width, buf[COVER, n:])
        if a < 0:
            a, b = cover_row(edges, sides, row, width, buf[COVER, n:])
        if b > a:
            listed[entries, 0], listed[entries, 1], listed[entries, 2] = row, a, b
            entries += 1
            x, y, middle = buf[X, n : n + b - a], buf[Y, n : n + b - a], np.float32(row + 0.5)
            for i in range(b - a):
                x[i] = xs[a + i]
                y[i] = middle
            n += b - a
        row += 1
    full[0], full[1] = n, entries
    return row


@kernel
def _to_luminance(red, green, blue):
    for i in range(red.shape[0]):
        red[i] = np.float32(0.2126) * red[i] + np.float32(0.7152) * green[i] + np.float32(0.0722) * blue[i]


@kernel
def _shade(panel, n, geometry, layout, light, channels, buf, vectors):
    """Fill the radiance of ``n`` listed pixels: one plane of luminance or three of colour.

    ``geometry`` is (constants of the inverse depth, its least and greatest value, slopes along and up, shifts along and up).
    """
    plane, least, most, along, rise, shift_s, shift_t = geometry
    upper, ground = layout
    env, table, lamp_maps, map_frame, optics, sun = light
    normal, point = vectors
    x, y, inverse = buf[X, :n], buf[Y, :n], buf[INVERSE, :n]
    s, t, ws, wt = buf[S, :n], buf[T, :n], buf[WS, :n], buf[WT, :n]
    stone, trim, pane, shade = buf[STONE, :n], buf[TRIM, :n], buf[PANE, :n], buf[SHADE, :n]
    _place(
        x, y, plane[0], plane[1], plane[2], least, most, along, rise, shift_s, shift_t, inverse, s, t, ws, wt
    )
    base_z, masonry = np.float32(panel[17]), np.float32(panel[24])
    if panel[11] > 0:
        _pattern(s, t, ws, wt, base_z, upper, ground, stone, trim, pane, shade)
    else:
        _plain(t, base_z, stone, trim, pane, shade)
    night = env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0
    windows = env[ENV_WINDOW] > 0 and panel[11] > 0
    if channels == 1 and not night and not windows:
        grey_wall, grey_frame, grey_glass = F0, F0, F0
        for c in range(3):
            wall, frame, glass, white = _paint(panel, env, sun, c)
            weight = np.float32(LUMA[c])
            grey_wall += weight * white * wall
            grey_frame += weight * white * frame
            grey_glass += weight * glass
        _colour(grey_wall, masonry, grey_frame, grey_glass, F1, stone, trim, pane, shade, buf[COLOUR, :n])
        return
    lamp, head, lit = buf[LAMP, :n], buf[HEAD, :n], buf[LIT, :n]
    if night:
        _lamp_light(
            s, t, panel[17], panel[27], panel[28], lamp_maps[int(panel[26])], map_frame[0], map_frame[1], lamp
        )
        _head_row(x, y, inverse, normal, env, table, optics, point, head)
    if windows:
        _lit(s, t, ws, wt, upper, ground, int(panel[16]), LIT_SHARE, lit)
    for c in range(3):
        wall, frame, glass, white = _paint(panel, env, sun, c)
        out = buf[COLOUR + c, :n]
        if night:
            tint = np.float32(env[ENV_LAMP + c])
            _colour_by_lamps(
                wall, masonry, frame, glass, white, tint, stone, trim, pane, shade, lamp, head, out
            )
        else:
            _colour(wall, masonry, frame, glass, white, stone, trim, pane, shade, out)
        if windows:
            _shine(lit, np.float32(env[ENV_WINDOW + c]), out)
    if channels == 1:
        _to_luminance(buf[COLOUR, :n], buf[COLOUR + 1, :n], buf[COLOUR + 2, :n])


@kernel
def _add_rows(listed, entries, scratch, buf, spans):
    """Add the listed pixels to the buildings' scratch planes."""
    at = INT(0)
    for r in range(entries):
        row, a, b = listed[r, 0], listed[r, 1], listed[r, 2]
        add_row(buf, COLOUR, COVER, INVERSE, at, scratch, row, a, b)
        grow(spans, row, a, b)
        at += b - a


@kernel
def draw_panel(
    panel, seen, rotation, camera, env, table, lamp_maps, map_frame, optics, xs, size, scratch, buf, work, spans
):  # fmt: skip
    """Draw what is seen of one panel into the buildings' scratch planes, behind all that is there already.

    The pixels of many rows are listed and shaded together: long loops, not many short ones.

    ``seen`` is (corners, their numbers, parts) from ``visible.visible_parts``; ``work`` is from ``panel_work``; ``lamp_maps`` is
    (maps, rows, columns) lx, right and left fronts first, ``map_frame`` (start x, step).
    """
    focal, cx, cy = optics
    height, width = size
    corners, counts, parts = seen
    axis, normal, up, origin, point, listed, full, edges = work
    for k in range(3):
        axis[k] = rotation[k, 0] * panel[3] + rotation[k, 1] * panel[4]
        normal[k] = rotation[k, 0] * panel[4] - rotation[k, 1] * panel[3]
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
    v1, v2 = normal[0] / focal / distance, normal[1] / focal / distance
    plane = (np.float32(normal[2] / distance - v1 * cx - v2 * cy), np.float32(v1), np.float32(v2))
    geometry = (
        plane, np.float32(1.0 / farthest), np.float32(1.0 / nearest), _slopes(axis, optics), _slopes(up, optics),
        np.float32(shift_s), np.float32(shift_t),
    )  # fmt: skip
    sun = max(0.0, normal[0] * env[0] + normal[1] * env[1] + normal[2] * env[2])
    light, layout = (env, table, lamp_maps, map_frame, optics, sun), _layout(panel)
    channels = scratch[0].shape[0]
    full[0] = full[1] = 0
    for part in range(parts):
        sides = slanted_edges(corners[part], counts[part], edges)
        row, bottom = row_range(corners[part], counts[part], height)
        while row < bottom:
            row = _list_pixels(edges, sides, row, bottom, width, xs, listed, full, buf)
            if full[0] >= CHUNK:
                _shade(panel, full[0], geometry, layout, light, channels, buf, (normal, point))
                _add_rows(listed, full[1], scratch, buf, spans)
                full[0] = full[1] = 0
    if full[0] > 0:
        _shade(panel, full[0], geometry, layout, light, channels, buf, (normal, point))
        _add_rows(listed, full[1], scratch, buf, spans)
