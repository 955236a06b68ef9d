"""Facades: upright rectangles whose visible pixels are listed, shaded together and added to their row of houses."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.entrances import (
    entrances_of,
    hang_signs,
    light_accent,
    light_accent_by_lamps,
    light_accent_by_sun,
    light_signs,
    part_accent,
)
from pedcross_env.camera.kernels.facade_light import (
    add_shine,
    add_sun,
    colour_by_lamps,
    colour_panel,
    head_row,
    lamp_light,
    paint_of,
    split_at_shade,
    sunlit_above,
    to_luminance,
)
from pedcross_env.camera.kernels.facade_pattern import (
    ground_pattern,
    lit_windows,
    pattern_of,
    place_pixels,
    plain_pattern,
    split_at_floor,
    upper_pattern,
    weigh_surfaces,
)
from pedcross_env.camera.kernels.jit import INT, allocating_kernel, kernel
from pedcross_env.camera.kernels.lighting import ENV_BEAM, ENV_LAMP, ENV_SUN, ENV_WINDOW
from pedcross_env.camera.kernels.polygons import (
    MAX_CORNERS,
    NEAR_M,
    cover_between,
    cover_row,
    grow,
    row_range,
    slanted_edges,
    upright_borders,
)
from pedcross_env.camera.kernels.rows import F0, F1, add_row, fill_row

__all__ = ["PANEL_SIZE", "draw_panel", "panel_work"]

# a panel: 0-2 origin, 3-5 axis along it, 6 length, 7 height, 8-10 wall albedo, 11 bay, 12 storey, 13 window share of the
# bay, 14 of the storey, 15 sill height share, 16 seed, 17 base height above the ground, 18 trim albedo factor,
# 19 height of the ground floor, 20 its bay, 21 its windows' share of the bay, 22-23 their sill and lintel, 24 its albedo factor,
# 25 where the cornice starts, 26 which map of lamp light, 27 where on it the panel starts, 28 how it runs along it per metre,
# 29 which row of houses it unites with, 0 or 1, 30-32 albedo of doors and signs, 33 bays of the ground floor from door to door (0: none),
# 34 in which of them the door is, 35 its width, 36 its top, 37 where in the bay its middle is, 38 its glass, 39-40 a sign's foot and top,
# 41 luminance of its letters after dark, 42 of its board if that were white, 43 whether it is a side wall; a bay of 0: a plain wall
PANEL_SIZE = 44
CHUNK = 480  # pixels worked on at a time: fits the first-level caches
COVER, INVERSE, COLOUR, S, T, WS, WT = 0, 2, 4, 7, 8, 9, 10  # rows of the work space
SUNLIT = 1
STONE, TRIM, PANE, SHADE, LIT, LAMP, HEAD, SHINE, ACCENT, X, Y = 11, 12, 13, 14, 15, 16, 17, 18, 19, 21, 22
LETTERS, BOARD = 20, 23
LIT_SHARE = np.float32(0.22)  # of windows at night
LUMA = (0.2126, 0.7152, 0.0722)


@kernel
def _slopes(direction, optics):
    """Return a ray's component along ``direction`` as constant, per column and per row."""
    focal, cx, cy = optics
    per_column, per_row = direction[0] / focal, direction[1] / focal
    constant = direction[2] - per_column * cx - per_row * cy
    return np.float32(constant), np.float32(per_column), np.float32(per_row)


@allocating_kernel
def panel_work(width):
    """Allocate what ``draw_panel`` works in."""
    return (
        np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((4096, 3), np.int64), np.empty(2, np.int64),
        np.empty((MAX_CORNERS, 5)), np.zeros((2, width + 3), np.float32),
    )  # fmt: skip


@kernel
def _centres(xs, y, out_x, out_y):
    for i in range(xs.shape[0]):
        out_x[i] = xs[i]
        out_y[i] = y


@kernel
def _list_pixels(edges, sides, row, bottom, xs, rows, listed, full, buf):
    """List a part's pixels from ``row`` on after those that are listed already, until there are enough.

    ``rows`` are two rows to work in; ``full`` holds the number of pixels and of the entries (row, first column, column beyond the
    last) in ``listed``.

    Returns:
        The row to go on from.
    """
    n, entries, width = full[0], full[1], xs.shape[0]
    until = row
    first = second = -1
    while row < bottom and n < CHUNK:
        if row >= until:
            first, second, until = upright_borders(edges, sides, row)
        cover = buf[COVER, n:]
        if row < until:
            a, b = cover_between(edges[first], edges[second], row, width, cover)
        else:
            a, b = cover_row(edges, sides, row, width, rows[0], rows[1], cover)
        if b > a:
            listed[entries, 0], listed[entries, 1], listed[entries, 2] = row, a, b
            entries += 1
            _centres(xs[a:b], np.float32(row + 0.5), buf[X, n : n + b - a], buf[Y, n : n + b - a])
            n += b - a
        row += 1
    full[0], full[1] = n, entries
    return row


@kernel
def _add_sun_above(panel, lit, end, foot, entered, sun, shades, env, channels, buf):
    """Add the sun's light above an edge of shade, which crosses the listed pixels from ``lit`` to ``end``.

    ``foot`` is the first with an accent.
    """
    edge, profile, _, _ = shades
    share = buf[SUNLIT]
    per_m = np.float32((edge.shape[0] - 1) / panel[6])
    per_rise = np.float32((profile.shape[0] - 1) / panel[7])
    fill_row(F1, share[:lit])
    sunlit_above(
        buf[S, lit:end], buf[T, lit:end], buf[WS, lit:end], buf[WT, lit:end], per_m, edge, per_rise, profile, share[lit:end]
    )  # fmt: skip
    wall, frame, accent = F0, F0, F0
    for c in range(3):
        albedo, trim, _, _ = paint_of(panel, env, sun, c)
        white = np.float32(env[ENV_SUN + c] * sun / math.pi)
        if channels == 1:
            white *= np.float32(LUMA[c])
        else:
            wall, frame, accent = F0, F0, F0
        wall += white * albedo
        frame += white * trim
        accent += white * np.float32(panel[30 + c])
        if channels == 1 and c < 2:
            continue
        out = buf[COLOUR + (c if channels == 3 else 0), :end]
        add_sun(wall, frame, buf[STONE, :end], buf[TRIM, :end], share[:end], out)
        if entered and foot < end:
            light_accent_by_sun(accent, buf[ACCENT, foot:end], share[foot:end], out[foot:])


@kernel
def _shade(panel, n, rows, geometry, layout, light, channels, buf, vectors):
    """Fill the radiance of ``n`` listed pixels: one plane of luminance or three of colour.

    ``geometry`` is (constants of the inverse depth, its least and greatest value, slopes along and up, shifts along and up, the
    camera's distance from the wall's plane), ``rows`` the table of ``_list_pixels`` and how many entries it has.
    """
    plane, least, most, along, rise, shift_s, shift_t, away = geometry
    upper, ground, entrances = layout
    env, table, lamp_maps, map_frame, optics, sun, shades = light
    normal, point = vectors
    x, y, inverse = buf[X, :n], buf[Y, :n], buf[INVERSE, :n]
    s, t, ws, wt = buf[S, :n], buf[T, :n], buf[WS, :n], buf[WT, :n]
    stone, trim, pane, shade = buf[STONE, :n], buf[TRIM, :n], buf[PANE, :n], buf[SHADE, :n]
    shine, accent, base_z = buf[SHINE, :n], buf[ACCENT, :n], np.float32(panel[17])
    place_pixels(
        x,
        y,
        plane[0],
        plane[1],
        plane[2],
        least,
        most,
        along,
        rise,
        shift_s,
        shift_t,
        inverse,
        s,
        t,
        ws,
        wt,
    )
    reached, lit_end, sun_end = sun, n, n  # the sun shines on all of them
    if shades[0].shape[0] > 0 and sun > 0.0:
        per_m = np.float32((shades[0].shape[0] - 1) / panel[6])
        lit_end, sun_end = split_at_shade(
            rows[0],
            rows[1],
            t,
            ws,
            wt,
            per_m,
            shades[2],
            shades[3],
            np.float32(panel[7] / (shades[1].shape[0] - 1)),
        )
        reached = sun if lit_end == n else 0.0
    crossed = lit_end < n and sun_end > 0
    foot, end = split_at_floor(rows[0], rows[1], t, wt, ground[0]) if panel[11] > 0 else (n, 0)
    if end > 0:
        curtains = np.float32((0.618034 * panel[16]) % 1.0)
        upper_pattern(
            s[:end], t[:end], ws[:end], wt[:end], base_z, upper, ground[0], curtains, stone[:end], trim[:end], pane[:end], shade[:end]
        )  # fmt: skip
    plain_pattern(t[end:], base_z, stone[end:], trim[end:], pane[end:], shade[end:])
    # rows are listed from above: the ground floor is below the first pixel that sees it
    low_s, low_t, low_ws, low_wt = s[foot:], t[foot:], ws[foot:], wt[foot:]
    low_trim, low_pane, accent = trim[foot:], pane[foot:], accent[foot:]
    if foot < n:
        ground_pattern(
            low_s, low_t, low_ws, low_wt, ground, entrances, stone[foot:], low_trim, low_pane, accent
        )
    entered = panel[33] > 0 and foot < n
    letters, board, shops = buf[LETTERS, foot:n], buf[BOARD, foot:n], entered and panel[40] > panel[39]
    if shops:
        hang_signs(
            low_s, low_t, low_ws, low_wt, entrances, int(panel[16]), low_trim, low_pane, accent, letters, board
        )  # fmt: skip
    weigh_surfaces(inverse, away, stone, trim, pane, shade, shine)
    if entered:
        part_accent(shade[foot:], low_trim, accent)
    night = env[ENV_LAMP] > 0 or env[ENV_BEAM] > 0
    windows = env[ENV_WINDOW] > 0 and panel[11] > 0
    if channels == 1 and not night and not windows:
        grey_wall, grey_frame, grey_mirrored, grey_accent = F0, F0, F0, F0
        for c in range(3):
            wall, frame, mirrored, white = paint_of(panel, env, reached, c)
            weight = np.float32(LUMA[c])
            grey_wall += weight * white * wall
            grey_frame += weight * white * frame
            grey_mirrored += weight * mirrored
            grey_accent += weight * white * np.float32(panel[30 + c])
        colour_panel(grey_wall, grey_frame, grey_mirrored, F1, stone, trim, shine, buf[COLOUR, :n])
        if entered:
            light_accent(grey_accent, F1, accent, buf[COLOUR, foot:n])
        if crossed:
            _add_sun_above(panel, lit_end, sun_end, foot, entered, sun, shades, env, channels, buf)
        return
    lamp, head, lit = buf[LAMP, :n], buf[HEAD, :n], buf[LIT, :n]
    if night:
        if env[ENV_LAMP] > 0:
            lamp_light(
                s,
                t,
                panel[17],
                panel[27],
                panel[28],
                lamp_maps[int(panel[26])],
                map_frame[0],
                map_frame[1],
                lamp,
            )
        else:
            fill_row(F0, lamp)
        head_row(x, y, inverse, normal, env, table, optics, point, head)
    if windows:
        lit_windows(s, t, ws, wt, upper, ground, int(panel[16]), LIT_SHARE, pane, lit)
    for c in range(3):
        wall, frame, mirrored, white = paint_of(panel, env, reached, c)
        out = buf[COLOUR + c, :n]
        if night:
            tint = np.float32(env[ENV_LAMP + c])
            colour_by_lamps(wall, frame, mirrored, white, tint, stone, trim, shine, lamp, head, out)
            if entered:
                light_accent_by_lamps(
                    np.float32(panel[30 + c]), white, tint, accent, lamp[foot:], head[foot:], out[foot:]
                )
        else:
            colour_panel(wall, frame, mirrored, white, stone, trim, shine, out)
            if entered:
                light_accent(np.float32(panel[30 + c]), white, accent, out[foot:])
        if windows:
            add_shine(lit, np.float32(env[ENV_WINDOW + c]), out)
        if windows and shops and panel[41] + panel[42] > 0:
            painted = np.float32(panel[42] * panel[30 + c])
            light_signs(np.float32(panel[41]), painted, letters, board, out[foot:])
    if channels == 1:
        to_luminance(buf[COLOUR, :n], buf[COLOUR + 1, :n], buf[COLOUR + 2, :n])
    if crossed:
        _add_sun_above(panel, lit_end, sun_end, foot, entered, sun, shades, env, channels, buf)


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
    panel, seen, rotation, camera, env, shades, table, lamp_maps, map_frame, optics, xs, size, scratch, buf, work, spans
):  # fmt: skip
    """Draw what is seen of one panel into the buildings' scratch planes, behind all that is there already.

    The pixels of many rows are listed and shaded together: long loops, not many short ones.

    ``shades`` is the edge of the shade on the panel and its profile; without an edge the sun shines on all of it.
    ``seen`` is (corners, their numbers, parts) from ``visible.visible_parts``; ``work`` is from ``panel_work``; ``lamp_maps`` is
    (maps, rows, columns) lx, right and left fronts first, ``map_frame`` (start x, step).
    """
    focal, cx, cy = optics
    height = size[0]
    corners, counts, parts = seen
    axis, normal, up, origin, point, listed, full, edges, rows = work
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
        np.float32(shift_s), np.float32(shift_t), np.float32(abs(distance)),
    )  # fmt: skip
    sun = max(0.0, normal[0] * env[0] + normal[1] * env[1] + normal[2] * env[2])
    lowest, highest = np.float32(math.inf), np.float32(-math.inf)
    for height_m in shades[0]:
        lowest, highest = min(lowest, height_m), max(highest, height_m)
    light = (env, table, lamp_maps, map_frame, optics, sun, (*shades, lowest, highest))
    upper, ground = pattern_of(panel)
    layout = (upper, ground, entrances_of(panel))
    channels = scratch[0].shape[0]
    full[0] = full[1] = 0
    for part in range(parts):
        sides = slanted_edges(corners[part], counts[part], edges)
        row, bottom = row_range(corners[part], counts[part], height)
        while row < bottom:
            row = _list_pixels(edges, sides, row, bottom, xs, rows, listed, full, buf)
            if full[0] >= CHUNK:
                _shade(
                    panel, full[0], (listed, full[1]), geometry, layout, light, channels, buf, (normal, point)
                )
                _add_rows(listed, full[1], scratch, buf, spans)
                full[0] = full[1] = 0
    if full[0] > 0:
        _shade(panel, full[0], (listed, full[1]), geometry, layout, light, channels, buf, (normal, point))
        _add_rows(listed, full[1], scratch, buf, spans)
