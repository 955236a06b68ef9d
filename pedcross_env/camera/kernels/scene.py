"""One frame: actors and static groups front to back, facades, then ground and sky under what is left."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.capsules import draw_capsule
from pedcross_env.camera.kernels.crown import draw_crown
from pedcross_env.camera.kernels.facade import draw_panel, panel_work
from pedcross_env.camera.kernels.jit import BOOL, INT, LANES, allocating, allocating_kernel, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_AIR,
    ENV_BEAM_POSITION,
    ENV_BEAM_TINT,
    ENV_BETA,
    ENV_LAMP,
    ENV_SUN,
    ENV_SUN_DIRECTION,
    head_irradiance,
    light_field,
)  # fmt: skip
from pedcross_env.camera.kernels.people import draw_pedestrian, people_work
from pedcross_env.camera.kernels.polyhedra import polyhedron_work
from pedcross_env.camera.kernels.rows import F0, composite_row, fill_row, mean_depths
from pedcross_env.camera.kernels.vehicles import draw_vehicle, vehicle_work
from pedcross_env.camera.kernels.visible import move_outlines, outline_walls, visible_parts, visible_work
from pedcross_env.camera.kernels.windows import (
    houses_window,
    look_through,
    plane_of,
    store,
    visible,
    window_of,
)

__all__ = ["BODY_REACH_M", "LEVELS", "NODES", "REACH", "REACH_M", "ROOF_KIND", "draw_scene"]

NOWHERE = 1 << 30
NODES, LEVELS = 64, 32  # along a panel and up it
ROOF_KIND = 3  # besides contracts.ActorKind: bodies that belong to the houses
MAX_PRIMITIVES = 64  # of one body or group
# Of an actor's size's diagonal, and metres: how far it reaches from its middle. Nothing is drawn beyond.
REACH, REACH_M, BODY_REACH_M = 0.55, 0.3, 0.9  # the last: of a pedestrian with what it carries or pushes
EAVES_M = 0.5  # more than a roof reaches beyond its walls
TIE_M2 = 1e-5  # keeps walls that share a corner in the same order, whatever the rounding
LUMA_R, LUMA_G, LUMA_B = 0.2126, 0.7152, 0.0722


@kernel
def _to_camera(rotation, camera, x, y, z, out):
    dx, dy, dz = x - camera[0], y - camera[1], z - camera[2]
    for k in range(3):
        out[k] = rotation[k, 0] * dx + rotation[k, 1] * dy + rotation[k, 2] * dz


@kernel
def _capsule_lit(
    p0, p1, r0, r1, albedo, shine, env, lamps, beams, table, optics, size, scratch, free, work, spans
):  # fmt: skip
    """Light one capsule at its middle (the ego's beam at both ends) and draw it."""
    middle, field, light, heads, sun, head, seg = work
    channels = light.shape[0]
    for k in range(3):
        middle[k] = 0.5 * (p0[k] + p1[k])
        sun[k] = env[ENV_SUN_DIRECTION + k]
    light_field(middle, env, lamps, beams, table, field)
    beta = env[ENV_BETA]
    head0, head1 = head_irradiance(p0, env, table, beta), head_irradiance(p1, env, table, beta)
    for c in range(channels):
        for k in range(6):
            light[c, k] = 0
        heads[c, 0] = heads[c, 1] = 0
    for c in range(3):
        weight = 1.0 if channels == 3 else (LUMA_R, LUMA_G, LUMA_B)[c]
        rho = weight * albedo[c] / math.pi
        o = c if channels == 3 else 0
        for k in range(4):
            light[o, k] += rho * field[c, k]
        light[o, 4] += rho * env[ENV_SUN + c]
        light[o, 5] += weight * shine * env[ENV_LAMP + c]
        heads[o, 0] += rho * head0 * env[ENV_BEAM_TINT + c]
        heads[o, 1] += rho * (head1 - head0) * env[ENV_BEAM_TINT + c]
    away = 1e-9
    for k in range(3):
        away += (env[ENV_BEAM_POSITION + k] - middle[k]) ** 2
    for k in range(3):
        head[k] = (env[ENV_BEAM_POSITION + k] - middle[k]) / math.sqrt(away)
    draw_capsule(p0, p1, r0, r1, light, heads, sun, head, optics, size, scratch, free, seg, spans)


@allocating_kernel
def _capsule_work(channels):
    """Allocate what ``_capsule_lit`` works in."""
    return (
        np.empty(3), np.empty((3, 4)), np.empty((channels, 6), np.float32), np.empty((channels, 2), np.float32),
        np.empty(3, np.float32), np.empty(3, np.float32), np.zeros(17, np.float32),
    )  # fmt: skip


@kernel
def _shine(env, sun, share):
    """Let a share of the sun's light through to what is drawn next."""
    for c in range(3):
        env[ENV_SUN + c] = share * sun[c]


@kernel
def _sort(keys, order, count):
    """Order by key, ascending (insertion sort: short and nearly sorted lists)."""
    for i in range(count):
        order[i] = i
    for i in range(1, count):
        k = order[i]
        j = i - 1
        while j >= 0 and keys[order[j]] > keys[k]:
            order[j + 1] = order[j]
            j -= 1
        order[j + 1] = k


@kernel
def _draw_group(
    group,
    capsules,
    crowns,
    rotation,
    camera,
    env,
    lamps,
    beams,
    table,
    optics,
    size,
    scratch,
    free,
    work,
    bones,
    spans,
):
    """Draw a tree or a lamp: its crown, then its capsules under it."""
    ends, keys, order = bones
    if group[7] >= 0:
        _to_camera(rotation, camera, group[8], group[9], group[10], ends[0])
        draw_crown(group[7:], ends[0], crowns, env, lamps, beams, table, optics, size, scratch, work, spans)
    first = int(group[0])
    count = min(int(group[1]) - first, keys.shape[0])
    for i in range(count):
        s = capsules[first + i]
        middle_x, middle_y, middle_z = (
            s[0] + s[3] - 2 * camera[0],
            s[1] + s[4] - 2 * camera[1],
            s[2] + s[5] - 2 * camera[2],
        )
        keys[i] = rotation[2, 0] * middle_x + rotation[2, 1] * middle_y + rotation[2, 2] * middle_z
    _sort(keys, order, count)
    seg = work[6]
    seg[10] = 1.0  # their depths' order does not change while the camera drives
    for m in range(count):
        s = capsules[first + order[m]]
        _to_camera(rotation, camera, s[0], s[1], s[2], ends[0])
        _to_camera(rotation, camera, s[3], s[4], s[5], ends[1])
        shine = 9000.0 if s[11] > 0 else 0.0
        _capsule_lit(
            ends[0], ends[1], s[6], s[7], s[8:11], shine, env, lamps, beams, table, optics, size, scratch, free, work,
            spans,
        )  # fmt: skip
    seg[10] = 0.0


@kernel
def _put(scratch, window, spans, ident, env, air, frame, owners, buf):
    """Composite an object's scratch planes onto the frame where their window is, clear them and its spans."""
    last, width = spans.shape[0] - 1, scratch[1].shape[1]
    beta = np.float32(env[ENV_BETA])
    for row in range(spans[last, 0], spans[last, 1]):
        a, b = spans[row, 0], spans[row, 1]
        if b > a:  # in whole vectors: an object's planes are zero beside it
            a, b = a // LANES * LANES, min(width, (b + LANES - 1) // LANES * LANES)
            composite_row(scratch, row, a, b, window, beta, air, ident, frame, owners, buf)
        spans[row, 0], spans[row, 1] = NOWHERE, 0
    spans[last, 0], spans[last, 1] = NOWHERE, 0


@kernel
def _wall_distance(panel, camera):
    """Horizontal distance to the nearest point of a wall, squared."""
    dx, dy = camera[0] - panel[0], camera[1] - panel[1]
    s = min(panel[6], max(0.0, dx * panel[3] + dy * panel[4]))
    return (dx - s * panel[3]) ** 2 + (dy - s * panel[4]) ** 2


@kernel
def _roof_distance(roof, camera):
    """The same to what a roof rests on: a little within the walls, so that it is drawn after its own and before what it hides."""
    dx, dy = camera[0] - roof[0], camera[1] - roof[1]
    c, s = math.cos(roof[3]), math.sin(roof[3])
    along, across = abs(c * dx + s * dy), abs(c * dy - s * dx)
    return (
        max(0.0, along - max(0.0, 0.5 * roof[6] - EAVES_M)) ** 2
        + max(0.0, across - max(0.0, 0.5 * roof[7] - EAVES_M)) ** 2
    )


@allocating
def draw_scene(
    actors,
    idents,
    looks,
    builds,
    bodies,
    vehicles,
    materials,
    capsules,
    groups,
    panels,
    maps,
    rotation,
    camera,
    env,
    lamps,
    beams,
    table,
    optics,
    xs,
    size,
    scratch,
    frame,
    owners,
    free,
    sunlit,
    belong,
    slab,
    buf,
):
    """Draw all objects, front to back.

    Args:
        actors: (N, 14) float64: x, y, z, yaw, pitch, model, length, width, height, gait phase, stride, head yaw, brake, headlight.
        idents: (N, 2) int64: instance id, ActorKind or ROOF_KIND.
        looks: (N, 8, 4) a vehicle's paint in [:, 0, :3].
        builds: (N, BUILD_SIZE) proportions of pedestrians, see kernels.pose.
        bodies: (N, MAX_BODY, PART_SIZE) their capsules, see kernels.people.
        vehicles: ``arrays`` of camera.model_table.ModelTable.
        materials: (M, 5).
        capsules: (S, 12) static capsules, see scenery.
        groups: (G, 16) static groups, see scenery.trees.
        panels: (P, PANEL_SIZE).
        maps: (front lamp maps, map frame, textures of crowns as kernels.crown).
        rotation: (3, 3) world to camera.
        camera: (3,) its position.
        env: (ENV_SIZE,) see kernels.lighting.
        lamps: (L, 3) camera coordinates.
        beams: (B, 13) others' low beams.
        table: (2, rows, columns) candela of the ego's and of others' beams.
        optics: (focal, cx, cy).
        xs: (W,) pixel centres.
        size: (height, width).
        scratch: (planes (C H W,), alpha (H W,), inverse depth (H W,)), zeroed; zeroed again on return.
        frame: (out (C, H, W), alpha, nearest, weight, depth inverse, ids); what no object covers is left as it is, but for alpha.
        owners: Whether to fill the frame's last three.
        free: (H W,) float32 twice, work space.
        sunlit: Shares of (N,) actors, (G,) groups and (P,) panels that the sun reaches, see kernels.shade; (P, NODES + LEVELS)
            float32 how high up the shade reaches along each panel, and which share of it lies above, by height.
        belong: (n,) bool, whether the first n actors are of the layer; the others, props among them, are by their places.
        slab: World x where the layer starts on the right and on the left side, and where it ends.
        buf: (24, W).
    """
    n, g = actors.shape[0], groups.shape[0]
    for row in range(size[0]):
        fill_row(F0, frame[1][row])
    keys, windows = np.empty(n + g), np.empty((n + g, 4), np.int64)
    for i in range(n + g):
        keys[i] = 1e9
    centre = np.empty(3)
    for i in range(n):
        side = 1 if actors[i, 1] > 0 else 0
        within = belong[i] if i < belong.size else slab[side] <= actors[i, 0] < slab[2 + side]
        if not within or actors[i, 6] <= 0.0:  # of another layer, or furniture too far away
            continue
        _to_camera(rotation, camera, actors[i, 0], actors[i, 1], actors[i, 2] + 0.5 * actors[i, 8], centre)
        diagonal = math.sqrt(actors[i, 6] ** 2 + actors[i, 7] ** 2 + actors[i, 8] ** 2)
        radius = REACH * diagonal + (REACH_M if idents[i, 1] == 1 else BODY_REACH_M)
        if visible(centre, radius, optics, size):
            keys[i] = centre[2] - 0.5 * actors[i, 6]
            store(window_of(centre, radius, optics, size), windows[i])
    for i in range(g):
        side = 1 if groups[i, 3] > 0 else 0
        if groups[i, 2] < slab[side] or groups[i, 2] >= slab[2 + side]:
            continue
        _to_camera(rotation, camera, groups[i, 2], groups[i, 3], groups[i, 4], centre)
        if visible(centre, groups[i, 5], optics, size):
            keys[n + i] = centre[2]
            store(window_of(centre, groups[i, 5], optics, size), windows[n + i])
    air = np.zeros(frame[0].shape[0], np.float32)
    for c in range(3):
        if air.shape[0] == 3:
            air[c] = env[ENV_AIR + c]
        else:
            air[0] += np.float32((LUMA_R, LUMA_G, LUMA_B)[c] * env[ENV_AIR + c])
    spans = np.empty((size[0] + 1, 2), np.int32)
    spans[:, 0], spans[:, 1] = NOWHERE, 0
    channels = frame[0].shape[0]
    work, hulls, fronts = _capsule_work(channels), polyhedron_work(channels, size[1]), panel_work(size[1])
    seen = visible_work(panels.shape[0])
    people = people_work()
    bones = (
        np.empty((2, 3)),
        np.empty(MAX_PRIMITIVES),
        np.empty(MAX_PRIMITIVES, np.int64),
    )
    car = vehicle_work(vehicles[0].shape[0], vehicles[6].shape[0], channels)
    most = max(n + g, n + panels.shape[0])
    ranks, near, which = np.empty(most, np.int64), np.empty(most), np.empty(most, np.int64)
    _sort(keys, ranks, n + g)
    sun = (env[ENV_SUN], env[ENV_SUN + 1], env[ENV_SUN + 2])
    for k in ranks[: n + g]:
        if keys[k] >= 1e9:
            break
        window = (windows[k, 0], windows[k, 1], windows[k, 2], windows[k, 3])
        if window[2] * window[3] == 0 or (k < n and idents[k, 1] == ROOF_KIND):
            continue
        planes, view, extent = look_through(window, scratch, channels, optics)
        sides = plane_of(window, free[0]), plane_of(window, free[1])
        _shine(env, sun, sunlit[0][k] if k < n else sunlit[1][k - n])
        if k >= n:
            _draw_group(
                groups[k - n], capsules, maps[2], rotation, camera, env, lamps, beams, table, view, extent, planes,
                sides, work, bones, spans,
            )  # fmt: skip
        elif idents[k, 1] == 1:
            draw_vehicle(
                actors[k], looks[k, 0], vehicles, materials, rotation, camera, env, lamps, beams, table, view, xs, extent, planes,
                work, hulls, car, spans, BOOL(False),
            )  # fmt: skip
        else:
            draw_pedestrian(
                actors[k], builds[k], bodies[k], rotation, camera, env, lamps, beams, table, view, extent, planes,
                sides, work, people, spans,
            )  # fmt: skip
        ident = idents[k, 0] if k < n else INT(groups[k - n, 6])
        _put(planes, window, spans, ident, env, air, frame, owners, buf)
    for side in range(2):  # the two rows of houses apart: their bounding boxes leave out the street
        faced = outline_walls(panels, side, slab, rotation, camera, optics, size, seen)
        count = faced
        for k in range(faced):
            which[k] = seen[3][k]
            near[k] = _wall_distance(panels[which[k]], camera) + TIE_M2 * which[k]
        _sort(near, ranks, faced)
        for k in range(faced):  # nearest first: the sooner nothing is left of a wall
            seen[3][k] = which[ranks[k]]
        for i in range(n):
            if idents[i, 1] == ROOF_KIND and keys[i] < 1e9 and (actors[i, 1] > 0) == (side == 1):
                near[count], which[count] = _roof_distance(actors[i], camera), -1 - i
                count += 1
        _sort(near, ranks, count)
        window = houses_window(faced, count, which, seen, windows, size)
        planes, view, extent = look_through(window, scratch, channels, optics)
        move_outlines(faced, window, seen)
        for k in ranks[:count]:
            i = which[k]
            share = sunlit[2][i] if i >= 0 else 1.0
            crossed = 0.0 < share < 1.0  # by an edge of shade
            _shine(env, sun, 1.0 if crossed else share)
            if i < 0:
                roof = -1 - i
                draw_vehicle(
                    actors[roof], looks[roof, 0], vehicles, materials, rotation, camera, env, lamps, beams, table, view, xs, extent,
                    planes, work, hulls, car, spans, BOOL(True),
                )  # fmt: skip
                continue
            parts = visible_parts(i, faced, panels, rotation, camera, view, seen)
            if parts > 0:
                nodes = NODES if crossed else 0
                shades = sunlit[3][i, :nodes], sunlit[3][i, NODES:]
                draw_panel(
                    panels[i], (seen[4], seen[5], parts), rotation, camera, env, shades, table, maps[0],
                    maps[1], view, xs[: extent[1]], extent, planes, buf, fronts, spans,
                )  # fmt: skip
        _shine(env, sun, 1.0)
        for row in range(spans[size[0], 0], spans[size[0], 1]):
            a, b = spans[row, 0], spans[row, 1]
            if b > a:
                mean_depths(planes[1][row, a:b], planes[2][row, a:b])
        _put(planes, window, spans, INT(-2), env, air, frame, owners, buf)
