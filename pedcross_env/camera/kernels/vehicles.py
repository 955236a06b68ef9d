"""Drawing a vehicle, a piece of furniture or a roof: a model's convex parts, each face lit at its middle."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import kernel
from pedcross_env.camera.kernels.lighting import (
    ENV_BEAM_TINT,
    ENV_BETA,
    beam_candela,
    face_radiance,
    head_irradiance,
    light_field,
)
from pedcross_env.camera.kernels.polyhedra import draw_polyhedron, fineness

__all__ = ["draw_vehicle", "vehicle_work"]

LUMA_R, LUMA_G, LUMA_B = 0.2126, 0.7152, 0.0722


@njit(cache=True)
def vehicle_work(points, faces, channels):
    """Allocate what ``draw_vehicle`` works in: a model's corners and which are placed, its faces' planes and colours, vectors."""
    return (
        np.empty((points, 3)), np.empty(points, np.int64), np.empty((faces, 4)), np.empty((faces, channels), np.float32),
        np.empty(3), np.empty(3), np.empty(3), np.empty(3),
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
def _place_face(indices, points, first, actor, scale, rotation, camera, local, placed, centre, plane):
    """Bring the corners of a face into camera coordinates, those that are not yet; fill its middle and plane there."""
    c, s, cp, sp = math.cos(actor[3]), math.sin(actor[3]), math.cos(actor[4]), math.sin(actor[4])
    n = indices.shape[0]
    for i in indices:
        if placed[i] != 0:
            continue
        placed[i] = 1
        p = points[first + i]
        x, y, z = p[0] * scale[0], p[1] * scale[1], p[2] * scale[2]
        x, z = x * cp + z * sp, z * cp - x * sp  # nose down positive
        dx, dy = actor[0] + c * x - s * y - camera[0], actor[1] + s * x + c * y - camera[1]
        dz = actor[2] + z - camera[2]
        for k in range(3):
            local[i, k] = rotation[k, 0] * dx + rotation[k, 1] * dy + rotation[k, 2] * dz
    for k in range(3):
        centre[k] = plane[k] = 0.0
    for i in range(n):  # Newell's normal
        p, q = local[indices[i]], local[indices[i + 1 if i + 1 < n else 0]]
        for k in range(3):
            centre[k] += p[k] / n
        plane[0] += (p[1] - q[1]) * (p[2] + q[2])
        plane[1] += (p[2] - q[2]) * (p[0] + q[0])
        plane[2] += (p[0] - q[0]) * (p[1] + q[1])
    p = local[indices[0]]
    plane[3] = plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2]


@kernel
def draw_vehicle(
    actor, paint, vehicles, materials, rotation, camera, env, lamps, beams, table, optics, xs, size, scratch, work, hulls, car, spans,
    behind,
):  # fmt: skip
    """Draw one body into its object's scratch planes.

    Args:
        actor: (14,) as kernels.scene.
        paint: (3,) albedo of material 0.
        vehicles: ``arrays`` of camera.models.ModelTable.
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
    points, model_points, model_parts, part_faces, face_start, corners, surface, detail, planes, nominal = (
        vehicles
    )
    channels = scratch[0].shape[0]
    model = int(actor[5])
    first, count = model_points[model], model_points[model + 1] - model_points[model]
    local, placed, facing, colours, scale, eye, rgb, albedo = car
    centre, field, normal = work[0], work[1], eye
    for k in range(3):
        scale[k] = actor[6 + k] / nominal[model, k]
    _eye(actor, scale, camera, eye)
    ex, ey, ez = eye[0], eye[1], eye[2]
    for i in range(count):
        placed[i] = 0
    f0, f1 = part_faces[model_parts[model]], part_faces[model_parts[model + 1]]
    for face in range(f0, f1):
        plane, seen = planes[face], facing[face - f0]
        seen[3] = 0.0
        if plane[0] * ex + plane[1] * ey + plane[2] * ez <= plane[3]:
            continue
        indices = corners[face_start[face] : face_start[face + 1]]
        _place_face(indices, points, first, actor, scale, rotation, camera, local, placed, centre, seen)
        if fineness(detail[face], optics[0], local[indices[0], 2]) <= 0.0:
            seen[3] = 0.0
        if seen[3] >= -1e-12:
            continue
        norm = math.sqrt(seen[0] ** 2 + seen[1] ** 2 + seen[2] ** 2) + 1e-12
        for k in range(3):
            normal[k] = seen[k] / norm
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
    for part in range(model_parts[model], model_parts[model + 1]):
        draw_polyhedron(
            local, part_faces[part], part_faces[part + 1], face_start, corners, detail, facing, colours, f0, optics, xs, size, scratch,
            hulls, spans, behind,
        )  # fmt: skip
