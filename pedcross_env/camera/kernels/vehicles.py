"""Drawing a vehicle, a piece of furniture or a roof: a model's convex parts, each face lit at its middle."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import BOOL, allocating_kernel, kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM_TINT,
    ENV_BETA,
    beam_candela,
    face_radiance,
    head_irradiance,
    light_field,
)
from pedcross_env.camera.kernels.polygons import NEAR_M
from pedcross_env.camera.kernels.polyhedra import PLACED, draw_polyhedron, fineness

__all__ = ["draw_vehicle", "vehicle_work"]

LUMA_R, LUMA_G, LUMA_B = 0.2126, 0.7152, 0.0722


@allocating_kernel
def vehicle_work(points, faces, channels):
    """Allocate what ``draw_vehicle`` works in: a model's corners and which are placed, its faces' planes and colours, vectors."""
    return (
        np.empty((points, PLACED)), np.empty(points, np.int64), np.empty((faces, 4)), np.empty((faces, channels), np.float32),
        np.empty((4, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3),
    )  # fmt: skip


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
def _eye(actor, scale, camera, out):
    """Fill the camera's place in a model's own coordinates, where its faces' planes never change."""
    c, s, cp, sp = math.cos(actor[3]), math.sin(actor[3]), math.cos(actor[4]), math.sin(actor[4])
    dx, dy, dz = camera[0] - actor[0], camera[1] - actor[1], camera[2] - actor[2]
    along, across = c * dx + s * dy, c * dy - s * dx
    out[0] = (along * cp - dz * sp) / scale[0]
    out[1] = across / scale[1]
    out[2] = (dz * cp + along * sp) / scale[2]


@kernel
def _turn(actor, rotation, camera, out):
    """Fill how a model's axes (columns of the first three rows) and its origin (the fourth) lie in camera coordinates."""
    c, s, cp, sp = math.cos(actor[3]), math.sin(actor[3]), math.cos(actor[4]), math.sin(actor[4])
    dx, dy, dz = actor[0] - camera[0], actor[1] - camera[1], actor[2] - camera[2]
    for k in range(3):
        r0, r1, r2 = rotation[k, 0], rotation[k, 1], rotation[k, 2]
        ahead = r0 * c + r1 * s
        out[k, 0] = ahead * cp - r2 * sp  # nose down positive
        out[k, 1] = r1 * c - r0 * s
        out[k, 2] = ahead * sp + r2 * cp
        out[3, k] = r0 * dx + r1 * dy + r2 * dz


@kernel
def _place(point, scale, turn, optics, out):
    """Bring a point of the model into the camera: x, y, z and, where it can be seen, column and row."""
    x, y, z = point[0] * scale[0], point[1] * scale[1], point[2] * scale[2]
    for k in range(3):
        out[k] = turn[k, 0] * x + turn[k, 1] * y + turn[k, 2] * z + turn[3, k]
    if out[2] >= NEAR_M:
        focal, cx, cy = optics
        out[3], out[4] = cx + focal * out[0] / out[2], cy + focal * out[1] / out[2]


@kernel
def _middle(middle, scale, turn, centre):
    """Bring a face's middle into camera coordinates."""
    x, y, z = middle[0] * scale[0], middle[1] * scale[1], middle[2] * scale[2]
    for k in range(3):
        centre[k] = turn[k, 0] * x + turn[k, 1] * y + turn[k, 2] * z + turn[3, k]


@kernel
def _normal(plane, scale, stretch, turn, normal):
    """Bring a face's normal, as long as the face has twice the area, into camera coordinates."""
    nx, ny, nz = stretch * plane[0] / scale[0], stretch * plane[1] / scale[1], stretch * plane[2] / scale[2]
    for k in range(3):
        normal[k] = turn[k, 0] * nx + turn[k, 1] * ny + turn[k, 2] * nz


@kernel
def _face_plane(normal, distance, optics, out):
    """Fill a face's inverse depth per column, per row and constant, from n.p = distance."""
    focal, cx, cy = optics
    out[0] = normal[0] / (focal * distance)
    out[1] = normal[1] / (focal * distance)
    out[2] = normal[2] / distance - out[0] * cx - out[1] * cy


@kernel
def draw_vehicle(
    actor, paint, vehicles, materials, rotation, camera, env, lamps, beams, table, optics, xs, size, scratch, work, hulls, car, spans,
    behind,
):  # fmt: skip
    """Draw one body into its object's scratch planes.

    Args:
        actor: (14,) as kernels.scene.
        paint: (3,) albedo of material 0.
        vehicles: ``arrays`` of camera.model_table.ModelTable.
        materials: (M, 5).
        rotation: (3, 3) world to camera.
        camera: (3,) its position.
        env: (ENV_SIZE,) see kernels.lighting.
        lamps: (L, 3) camera coordinates.
        beams: (B, 13) others' low beams.
        table: Candela of the ego's and of others' beams.
        optics: (focal, cx, cy).
        xs: (W,) pixel centres.
        size: (height, width).
        scratch: (planes (C, H, W), alpha, inverse depth).
        work: Work space of a capsule, see kernels.scene.
        hulls: From ``polyhedron_work``.
        car: From ``vehicle_work``.
        spans: What the object covers, extended.
        behind: As ``draw_polyhedron``.
    """
    (
        points, model_points, model_parts, part_faces, face_start, corners, surface, detail, planes, nominal, middles,
        beyond, bends,
    ) = vehicles  # fmt: skip
    channels = scratch[0].shape[0]
    model = int(actor[5])
    first, count = model_points[model], model_points[model + 1] - model_points[model]
    placed, known, facing, colours, turn, scale, eye, normal, rgb, albedo = car
    centre, field = work[0], work[1]
    for k in range(3):
        scale[k] = actor[6 + k] / nominal[model, k]
    _eye(actor, scale, camera, eye)
    _turn(actor, rotation, camera, turn)
    for i in range(count):
        known[i] = 0
    stretch = scale[0] * scale[1] * scale[2]
    lit = lamps.shape[0] + beams.shape[0] > 0  # or the light is the same everywhere
    light_field(turn[3], env, lamps, beams, table, field)
    whole = BOOL(True)
    f0, f1 = part_faces[model_parts[model]], part_faces[model_parts[model + 1]]
    for face in range(f0, f1):
        plane, seen = planes[face], facing[face - f0]
        seen[3] = 0.0
        height = stretch * (plane[0] * eye[0] + plane[1] * eye[1] + plane[2] * eye[2] - plane[3])
        if height <= 1e-12:
            continue
        for k in range(face_start[face], face_start[face + 1]):
            i = corners[k]
            if known[i] == 0:
                known[i] = 1
                _place(points[first + i], scale, turn, optics, placed[i])
                whole = whole and placed[i, 2] >= NEAR_M
        seen[3] = fineness(detail[face], optics[0], placed[corners[face_start[face]], 2])
        if seen[3] <= 0.0:
            continue
        _middle(middles[face], scale, turn, centre)
        _normal(plane, scale, stretch, turn, normal)
        _face_plane(normal, -height, optics, seen)
        if bends[face, 3] > 0.0:
            _normal(bends[face], scale, stretch, turn, normal)
        size2 = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]
        shorten = 1.0 / (math.sqrt(size2) + 1e-12)
        for k in range(3):
            normal[k] *= shorten
        if lit:
            light_field(centre, env, lamps, beams, table, field)
        head = head_irradiance(centre, env, table, env[ENV_BETA])
        m = surface[face]
        for k in range(3):
            albedo[k] = materials[m, k] if m > 0 else paint[k]
        face_radiance(centre, normal, albedo, materials[m, 3], env, field, head, rgb)
        _lamp_glow(int(materials[m, 4]), actor, centre, normal, rotation, env, table, albedo, rgb)
        if channels == 3:
            for k in range(3):
                colours[face - f0, k] = rgb[k]
        else:
            colours[face - f0, 0] = LUMA_R * rgb[0] + LUMA_G * rgb[1] + LUMA_B * rgb[2]
    mesh = (face_start, corners, detail, beyond)
    for part in range(model_parts[model], model_parts[model + 1]):
        draw_polyhedron(
            part_faces[part], part_faces[part + 1], f0, whole, mesh, placed, facing, colours, optics, xs, size, scratch, hulls, spans, behind,
        )  # fmt: skip
