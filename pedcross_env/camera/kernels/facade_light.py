"""Light on a front: paints under a uniform light, street lamps from a map, the ego's beam, lit windows."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BETA,
    ENV_BOUNCE,
    ENV_SKY,
    ENV_SUN,
    head_irradiance,
    sky_radiance,
)
from pedcross_env.camera.kernels.rows import F0, F1, HALF

__all__ = [
    "add_shine",
    "add_sun",
    "colour_by_lamps",
    "colour_panel",
    "head_row",
    "lamp_light",
    "paint_of",
    "split_at_shade",
    "sunlit_above",
    "to_luminance",
]

FRONTS = 0.35  # albedo of the houses opposite
PENUMBRA_M = np.float32(0.2)  # of the sun's disc, .53 degrees wide, over a street 20 m wide
INV_PI = np.float32(1 / math.pi)
QUARTER = np.float32(0.25)


@kernel
def paint_of(panel, env, sun, c):
    """Return one channel's albedo of the wall and of frames, radiance of what glass mirrors and of a white wall.

    Glass mirrors the sky over the houses opposite and, below it, their fronts.
    """
    shade = 0.5 * (env[ENV_SKY + c] + env[ENV_BOUNCE + c])
    light = shade + env[ENV_SUN + c] * sun
    wall = np.float32(panel[8 + c])
    frame = min(np.float32(0.75), wall * np.float32(panel[18]) + np.float32(0.06))
    mirrored = 0.6 * sky_radiance(0.35, env, c) + 0.4 * FRONTS * shade / math.pi
    return wall, frame, np.float32(mirrored), np.float32(light / math.pi)


@kernel
def colour_panel(wall, frame, mirrored, light, plain, trim, shine, out):
    """Fill one plane under a uniform light (radiance of a white surface); see ``facade_pattern.weigh_surfaces``."""
    wall, frame = wall * light, frame * light
    for i in range(out.shape[0]):
        out[i] = wall * plain[i] + frame * trim[i] + mirrored * shine[i]


@kernel
def colour_by_lamps(wall, frame, mirrored, light, tint, plain, trim, shine, lamp, head, out):
    """Fill one plane under a uniform light, street lamps and the ego's beam."""
    for i in range(out.shape[0]):
        total = light + (lamp[i] * tint + head[i]) * INV_PI
        out[i] = (wall * plain[i] + frame * trim[i]) * total + mirrored * shine[i]


@kernel
def add_shine(lit, radiance, out):
    """Add the light of windows."""
    for i in range(out.shape[0]):
        out[i] += lit[i] * radiance


@kernel
def split_at_shade(listed, entries, t, ws, wt, per_m, lowest, highest, level):
    """Where listed pixels, from above, begin to see what an edge of shade crosses, and where they see nothing above it.

    Arguments are as ``sunlit_above``'s; the edge's lowest and highest place, and from one level of the profile to the next.
    """
    lit, end, at = t.shape[0], 0, 0
    for r in range(entries):
        last = at + listed[r, 2] - listed[r, 1] - 1
        half = HALF * (PENUMBRA_M + max(wt[at], wt[last]))
        half += level if HALF * max(ws[at], ws[last]) * per_m > F1 else F0  # where the profile has a share
        if lit > at and min(t[at], t[last]) - half < highest:
            lit = at
        if max(t[at], t[last]) + half > lowest:
            end = last + 1
        at = last + 1
    return lit, max(lit, end)


@inlined
def _between(at):
    """The entry of a table before a place in it, and how far on from there the place is."""
    a = np.int32(at)
    return np.uint32(a), at - np.float32(a)  # unsigned: numba lets a negative index count from the end


@inlined
def _share_above(t, per_soft, edge, at):
    """Share above the edge at one place along it, between those at its nodes."""
    a, on = _between(at)
    low = min(F1, max(F0, HALF + (t - edge[a]) * per_soft))
    high = min(F1, max(F0, HALF + (t - edge[a + np.uint32(1)]) * per_soft))
    return low + on * (high - low)


@kernel
def sunlit_above(s, t, ws, wt, per_m, edge, per_rise, profile, out):
    """Share of each pixel that lies above an edge of shade.

    It is the mean of two places in the pixel along the panel. Where these are farther apart than the edge's nodes, the pixel
    has the panel's mean at its height.

    Args:
        s, t, ws, wt: As in facade_pattern.
        per_m: Heights of ``edge`` per metre along the panel. edge: (NODES,) m.
        per_rise: Entries of ``profile`` per metre up. profile: (LEVELS,) share of the panel above the edge, by height.
        out: Filled.
    """
    last, top = np.float32(edge.shape[0] - 1.001), np.float32(profile.shape[0] - 1.001)
    for i in range(out.shape[0]):
        middle, reach, high, per_soft = s[i] * per_m, HALF * ws[i] * per_m, t[i], F1 / (PENUMBRA_M + wt[i])
        first, end = min(max(middle - reach, F0), last), min(max(middle + reach, F0), last)
        inset = QUARTER * (end - first)
        near = _share_above(high, per_soft, edge, first + inset) + _share_above(
            high, per_soft, edge, end - inset
        )
        a, on = _between(min(max(high * per_rise, F0), top))
        mean = profile[a] + on * (profile[a + np.uint32(1)] - profile[a])
        out[i] = HALF * near + min(F1, max(F0, reach - F1)) * (mean - HALF * near)


@kernel
def add_sun(wall, frame, plain, trim, share, out):
    """Add to one plane what the sun adds to a wall and to frames (radiances) where it reaches them."""
    for i in range(out.shape[0]):
        out[i] += (wall * plain[i] + frame * trim[i]) * share[i]


@kernel
def lamp_light(s, t, base, origin_x, axis_x, lamp_map, map_start, map_step, out):
    """Bilinear look-up of the lamps' illuminance on this side's fronts: rows height, columns along the street."""
    last_column, last_row = np.float32(lamp_map.shape[1] - 1.001), np.float32(lamp_map.shape[0] - 1.001)
    # unsigned: numba lets a negative index count from the end
    inv, one = np.float32(1.0 / map_step), np.uint32(1)
    start, slope = np.float32((origin_x - map_start) / map_step), np.float32(axis_x / map_step)
    foot = np.float32(base / map_step)
    for i in range(out.shape[0]):
        p = min(max(start + slope * s[i], F0), last_column)
        q = min(max(foot + inv * t[i], F0), last_row)
        a, b = np.uint32(np.int32(q)), np.uint32(np.int32(p))
        fq, fp = q - np.float32(np.int32(q)), p - np.float32(np.int32(p))
        low = lamp_map[a, b] + fp * (lamp_map[a, b + one] - lamp_map[a, b])
        high = lamp_map[a + one, b] + fp * (lamp_map[a + one, b + one] - lamp_map[a + one, b])
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
def head_row(xs, ys, inverse, normal, env, table, optics, point, out):
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
def to_luminance(red, green, blue):
    """Turn the first of three planes into their luminance."""
    for i in range(red.shape[0]):
        red[i] = np.float32(0.2126) * red[i] + np.float32(0.7152) * green[i] + np.float32(0.0722) * blue[i]
