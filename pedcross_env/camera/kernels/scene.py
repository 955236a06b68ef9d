"""One frame: actors and static groups front to back, facades, then ground and sky under what is left."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.capsules import draw_capsule
from pedcross_env.camera.kernels.crown import draw_crown
from pedcross_env.camera.kernels.facade import draw_panel, panel_work
from pedcross_env.camera.kernels.jit import INT, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_AIR,
    ENV_BEAM_POSITION,
    ENV_BEAM_TINT,
    ENV_BETA,
    ENV_LAMP,
    ENV_SUN,
    ENV_SUN_DIRECTION,
    beam_candela,
    face_radiance,
    head_irradiance,
    light_field,
)  # fmt: skip
from pedcross_env.camera.kernels.people import draw_pedestrian, people_work
from pedcross_env.camera.kernels.polyhedra import draw_polyhedron, fineness, polyhedron_work
from pedcross_env.camera.kernels.rows import composite_row
from pedcross_env.camera.kernels.visible import outline_walls, visible_parts, visible_work

__all__ = ["ROOF_KIND", "draw_scene"]

NOWHERE = 1 << 30
ROOF_KIND = 3  # besides contracts.ActorKind: bodies that belong to the houses
MAX_PRIMITIVES = 64  # of one body or group
LUMA_R, LUMA_G, LUMA_B = 0.2126, 0.7152, 0.0722


@kernel
def _to_camera(rotation, camera, x, y, z, out):
    dx, dy, dz = x - camera[0], y - camera[1], z - camera[2]
    for k in range(3):
        out[k] = rotation[k, 0] * dx + rotation[k, 1] * dy + rotation[k, 2] * dz


@kernel
def _capsule_lit(p0, p1, r0, r1, albedo, shine, env, lamps, beams, table, optics, size, scratch, work, spans):
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
    draw_capsule(p0, p1, r0, r1, light, heads, sun, head, optics, size, scratch, seg, spans)


@njit(cache=True)
def _capsule_work(channels):
    """Allocate what ``_capsule_lit`` works in."""
    return (
        np.empty(3), np.empty((3, 4)), np.empty((channels, 6), np.float32), np.empty((channels, 2), np.float32),
        np.empty(3, np.float32), np.empty(3, np.float32), np.zeros(13, np.float32),
    )  # fmt: skip


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
def _lamp_glow(kind, actor, centre, normal, rotation, env, table, albedo, out):
    """Add the radiance of a lit head, tail or brake light."""
    if kind == 1 and actor[13] > 0:
        yaw = actor[3]
        f = across = u = r2 = 0.0
        for k in range(3):
            f -= centre[k] * (rotation[k, 0] * math.cos(yaw) + rotation[k, 1] * math.sin(yaw))
            across -= centre[k] * (rotation[k, 1] * math.cos(yaw) - rotation[k, 0] * math.sin(yaw))
            u -= centre[k] * rotation[k, 2]
            r2 += centre[k] * centre[k]
        candela = 0.5 * beam_candela(table[1], across / f, u / f) if f > 0.05 else 0.0
        seen = abs(centre[0] * normal[0] + centre[1] * normal[1] + centre[2] * normal[2]) / math.sqrt(
            r2 + 1e-9
        )
        area = 0.035 * max(0.15, seen)
        for c in range(3):
            out[c] += actor[13] * (candela / area + 300.0) * env[ENV_BEAM_TINT + c]
    if kind == 2:
        level = 220.0 * actor[13] + 2800.0 * actor[12]
        out[0] += level * 3.6
        out[1] += level * 0.12
        out[2] += level * 0.06


@kernel
def _draw_vehicle(
    actor,
    paint,
    vehicles,
    materials,
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
    buf,
    work,
    hulls,
    car,
    spans,
):
    points, model_points, model_parts, part_faces, face_start, corners, surface, detail, nominal = vehicles
    channels = scratch[0].shape[0]
    model = int(actor[5])
    p0, p1 = model_points[model], model_points[model + 1]
    local, colours, normal, rgb, albedo = car
    centre, field = work[0], work[1]
    c, s = math.cos(actor[3]), math.sin(actor[3])
    cp, sp = math.cos(actor[4]), math.sin(actor[4])
    sx, sy, sz = actor[6] / nominal[model, 0], actor[7] / nominal[model, 1], actor[8] / nominal[model, 2]
    for i in range(p1 - p0):
        x, y, z = points[p0 + i, 0] * sx, points[p0 + i, 1] * sy, points[p0 + i, 2] * sz
        x, z = x * cp + z * sp, z * cp - x * sp  # nose down positive
        _to_camera(
            rotation, camera, actor[0] + c * x - s * y, actor[1] + s * x + c * y, actor[2] + z, local[i]
        )
    f0, f1 = part_faces[model_parts[model]], part_faces[model_parts[model + 1]]
    for i in range(f1 - f0):
        for k in range(channels):
            colours[i, k] = 0
    for face in range(f0, f1):
        a, b = face_start[face], face_start[face + 1]
        for k in range(3):
            centre[k] = 0.0
            normal[k] = 0.0
        for i in range(a, b):
            j = i + 1 if i + 1 < b else a
            p, q = local[corners[i]], local[corners[j]]
            for k in range(3):
                m, o = (k + 1) % 3, (k + 2) % 3
                centre[k] += p[k] / (b - a)
                normal[k] += (p[m] - q[m]) * (p[o] + q[o])
        norm = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2) + 1e-12
        facing = 0.0
        for k in range(3):
            normal[k] /= norm
            facing += normal[k] * centre[k]
        if facing >= 0 or fineness(detail[face], optics[0], centre[2]) <= 0.0:
            continue
        light_field(centre, env, lamps, beams, table, field)
        head = head_irradiance(centre, env, table, env[ENV_BETA])
        m = surface[face]
        for k in range(3):
            albedo[k] = materials[m, k] if m > 0 else paint[k]
        face_radiance(centre, normal, albedo, materials[m, 3], env, field, head, rgb)
        _lamp_glow(int(materials[m, 4]), actor, centre, normal, rotation, env, table, albedo, rgb)
        for k in range(3):
            colours[face - f0, k if channels == 3 else 0] += (
                rgb[k] if channels == 3 else (LUMA_R, LUMA_G, LUMA_B)[k] * rgb[k]
            )
    for part in range(model_parts[model], model_parts[model + 1]):
        first, last = part_faces[part], part_faces[part + 1]
        draw_polyhedron(
            local, first, last, face_start, corners, detail, colours, f0, optics, xs, size, scratch, buf, hulls, spans,
        )  # fmt: skip


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
            ends[0], ends[1], s[6], s[7], s[8:11], shine, env, lamps, beams, table, optics, size, scratch, work, spans,
        )  # fmt: skip
    seg[10] = 0.0


@kernel
def _put(scratch, spans, ident, env, air, frame, owners, buf):
    """Composite an object's scratch planes onto the frame, clear them and its spans."""
    last = spans.shape[0] - 1
    beta = np.float32(env[ENV_BETA])
    for row in range(spans[last, 0], spans[last, 1]):
        a, b = spans[row, 0], spans[row, 1]
        if b > a:
            composite_row(scratch, row, a, b, beta, air, ident, frame, owners, buf)
        spans[row, 0], spans[row, 1] = NOWHERE, 0
    spans[last, 0], spans[last, 1] = NOWHERE, 0


@kernel
def _visible(centre, radius, optics, size):
    """Whether a sphere can reach the image."""
    focal, cx, cy = optics
    if centre[2] + radius < 0.1:
        return False
    for k in range(2):
        low = (-cx if k == 0 else -cy) / focal
        high = ((size[1] - cx) if k == 0 else (size[0] - cy)) / focal
        if centre[k] - high * centre[2] > radius * math.sqrt(1 + high * high):
            return False
        if low * centre[2] - centre[k] > radius * math.sqrt(1 + low * low):
            return False
    return True


@njit(cache=True, error_model="numpy")
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
    sunlit,
    buf,
):
    """Draw all objects, front to back.

    Args:
        actors: (N, 14) float64: x, y, z, yaw, pitch, model, length, width, height, gait phase, stride, head yaw, brake, headlight.
        idents: (N, 2) int64: instance id, ActorKind or ROOF_KIND.
        looks: (N, 8, 4) a vehicle's paint in [:, 0, :3].
        builds: (N, BUILD_SIZE) proportions of pedestrians, see kernels.pose.
        bodies: (N, MAX_BODY, PART_SIZE) their capsules, see kernels.people.
        vehicles: The arrays of camera.models.ModelTable.
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
        scratch: (planes (C, H, W), alpha, inverse depth), zeroed; zeroed again on return.
        frame: (out (C, H, W), alpha, nearest, weight, depth inverse, ids).
        owners: Whether to fill the frame's last three.
        sunlit: Shares of (N,) actors, (G,) groups and (P,) panels that the sun reaches, see kernels.shade.
        buf: (24, W).
    """
    n, g = actors.shape[0], groups.shape[0]
    keys = np.empty(n + g)
    for i in range(n + g):
        keys[i] = 1e9
    centre = np.empty(3)
    for i in range(n):
        _to_camera(rotation, camera, actors[i, 0], actors[i, 1], actors[i, 2] + 0.5 * actors[i, 8], centre)
        radius = 0.5 * math.sqrt(actors[i, 6] ** 2 + actors[i, 7] ** 2 + actors[i, 8] ** 2) * 1.1 + 0.3
        radius += 0.6 if idents[i, 1] != 1 else 0.0  # what a pedestrian carries or pushes
        if _visible(centre, radius, optics, size):
            keys[i] = centre[2] - 0.5 * actors[i, 6]
    for i in range(g):
        _to_camera(rotation, camera, groups[i, 2], groups[i, 3], groups[i, 4], centre)
        if _visible(centre, groups[i, 5], optics, size):
            keys[n + i] = centre[2]
    air = np.zeros(frame[0].shape[0], np.float32)
    for c in range(3):
        if air.shape[0] == 3:
            air[c] = env[ENV_AIR + c]
        else:
            air[0] += np.float32((LUMA_R, LUMA_G, LUMA_B)[c] * env[ENV_AIR + c])
    spans = np.empty((size[0] + 1, 2), np.int32)
    spans[:, 0], spans[:, 1] = NOWHERE, 0
    channels = frame[0].shape[0]
    work, hulls, fronts = _capsule_work(channels), polyhedron_work(channels), panel_work()
    seen = visible_work(panels.shape[0])
    people = people_work()
    bones = (
        np.empty((2, 3)),
        np.empty(MAX_PRIMITIVES),
        np.empty(MAX_PRIMITIVES, np.int64),
    )
    car = (
        np.empty((vehicles[0].shape[0], 3)),
        np.empty((vehicles[6].shape[0], channels), np.float32),
        np.empty(3),
        np.empty(3),
        np.empty(3),
    )
    ranks = np.empty(n + g, np.int64)
    _sort(keys, ranks, n + g)
    sun0, sun1, sun2 = env[ENV_SUN], env[ENV_SUN + 1], env[ENV_SUN + 2]
    for k in ranks:
        if keys[k] >= 1e9:
            break
        share = sunlit[0][k] if k < n else sunlit[1][k - n]
        env[ENV_SUN], env[ENV_SUN + 1], env[ENV_SUN + 2] = share * sun0, share * sun1, share * sun2
        if k < n:
            if idents[k, 1] == ROOF_KIND:
                continue
            if idents[k, 1] == 1:
                _draw_vehicle(
                    actors[k],
                    looks[k, 0],
                    vehicles,
                    materials,
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
                    buf,
                    work,
                    hulls,
                    car,
                    spans,
                )
            else:
                draw_pedestrian(
                    actors[k],
                    builds[k],
                    bodies[k],
                    rotation,
                    camera,
                    env,
                    lamps,
                    beams,
                    table,
                    optics,
                    size,
                    scratch,
                    work,
                    people,
                    spans,
                )
            _put(scratch, spans, idents[k, 0], env, air, frame, owners, buf)
        else:
            _draw_group(
                groups[k - n],
                capsules,
                maps[2],
                rotation,
                camera,
                env,
                lamps,
                beams,
                table,
                optics,
                size,
                scratch,
                work,
                bones,
                spans,
            )
            _put(scratch, spans, int(groups[k - n, 6]), env, air, frame, owners, buf)
    for side in range(2):  # the two rows of houses apart: their bounding boxes leave out the street
        faced = outline_walls(panels, side, rotation, camera, optics, size, seen)
        for i in range(faced):
            wall = seen[3][i]
            parts = visible_parts(wall, faced, panels, rotation, camera, optics, seen)
            if parts > 0:
                share = sunlit[2][wall]
                env[ENV_SUN], env[ENV_SUN + 1], env[ENV_SUN + 2] = share * sun0, share * sun1, share * sun2
                draw_panel(
                    panels[wall], (seen[4], seen[5], parts), rotation, camera, env, table, maps[0], maps[1], optics, xs, size, scratch,
                    buf, fronts, spans,
                )  # fmt: skip
        env[ENV_SUN], env[ENV_SUN + 1], env[ENV_SUN + 2] = sun0, sun1, sun2
        for i in range(n):
            if idents[i, 1] == ROOF_KIND and keys[i] < 1e9 and (actors[i, 1] > 0) == (side == 1):
                _draw_vehicle(
                    actors[i], looks[i, 0], vehicles, materials, rotation, camera, env, lamps, beams, table, optics, xs, size, scratch,
                    buf, work, hulls, car, spans,
                )  # fmt: skip
        _put(scratch, spans, INT(-2), env, air, frame, owners, buf)
