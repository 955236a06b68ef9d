"""A tunnel around the street up to its exit: walls and ceiling by each pixel's own ray, and darkness on what is inside.

The street's picture is changed afterwards: what lies inside is dimmed to the tunnel's light, walls and ceiling hide what
lies behind them, and through the portal, whose edges are covered by exact areas, the rest stays as it is.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import INT, entry

__all__ = ["CEILING", "ROAD", "WALL", "daylight_share", "enclose"]

F0, F1, HALF = np.float32(0), np.float32(1), np.float32(0.5)
JOINT_M = 6.0  # wavelength of the walls' pattern
JOINT_DEPTH = 0.12
# What the portal shows is as bright as a surface of this albedo in the light outside: CIE 88:2004 reckons with 3000 to
# 6000 cd/m2 before a portal in full daylight (from memory), where white paper has some 27,000.
PORTAL_ALBEDO = 0.2
SHADE_M = 6.0
ROAD, WALL, CEILING = INT(0), INT(1), INT(2)


@entry
def daylight_share(inside_m, half_width_m, height_m, surface):
    """Share of the light outside that falls onto a surface ``inside_m`` metres into the tunnel.

    It is the view factor of the portal, a rectangle that stands on the road, from the surface, times PORTAL_ALBEDO, for
    through the portal there is a street to see and not white paper. From the road and the ceiling it is the factor from
    a small horizontal surface before the middle of the rectangle's edge, from a wall that of one at half its height
    before its side; both fall with the cube of the distance (Howell, A Catalog of Radiation Heat Transfer Configuration
    Factors, B-5; from memory). On the road the open sky's light fades out over SHADE_M metres: the shade of the portal,
    made soft so that it is no line that jumps from pixel to pixel.

    Args:
        inside_m: From the portal; negative outside.
        half_width_m: Of the portal.
        height_m: Of the portal.
        surface: ROAD, WALL or CEILING.
    """
    d = max(1e-3, inside_m)
    across, along = (0.5 * height_m, 2.0 * half_width_m) if surface == WALL else (half_width_m, height_m)
    slant = math.sqrt(d * d + along * along)
    share = PORTAL_ALBEDO * (math.atan(across / d) - d / slant * math.atan(across / slant)) / math.pi
    if surface == ROAD:
        open_sky = min(1.0, max(0.0, 1.0 - inside_m / SHADE_M)) ** 2
        share = open_sky + (1.0 - open_sky) * share
    return share


@entry
def enclose(out, luminance, depth, ids, rotation, camera, optics, shape, light):
    """Draw the tunnel into a finished picture.

    Args:
        out: (C, H, W) radiance, or luminance.
        luminance: (H, W).
        depth: (H, W) metres, inf for the sky; changed where the tunnel is seen.
        ids: (H, W) likewise.
        rotation: World to camera.
        camera: Its place.
        optics: Focal length, cx, cy.
        shape: x of the exit, y of the right and of the left wall, height.
        light: Illuminance outside, of the tunnel's lamps, albedo of walls and of the ceiling; building id.
    """
    focal, cx, cy = optics
    exit_x, right_y, left_y, top_z = shape
    half = 0.5 * (left_y - right_y)
    outside_lx, lamps_lx, wall, ceiling, ident = light
    channels = out.shape[0]
    height, width = luminance.shape
    if exit_x - camera[0] < 0.05:
        return
    for row in range(height):
        v = (row + 0.5 - cy) / focal
        for i in range(width):
            u = (i + 0.5 - cx) / focal
            dx = rotation[0, 0] * u + rotation[1, 0] * v + rotation[2, 0]
            dy = rotation[0, 1] * u + rotation[1, 1] * v + rotation[2, 1]
            dz = rotation[0, 2] * u + rotation[1, 2] * v + rotation[2, 2]
            side = (
                (left_y - camera[1]) / dy
                if dy > 1e-9
                else ((right_y - camera[1]) / dy if dy < -1e-9 else 1e9)
            )
            above = (top_z - camera[2]) / dz if dz > 1e-9 else 1e9
            hit = min(side, above)
            opening = 0.0
            if dx > 1e-6:
                t = (exit_x - camera[0]) / dx
                pixel = t / focal
                y, z = camera[1] + t * dy, camera[2] + t * dz
                opening = max(0.0, min(1.0, min(left_y - y, y - right_y) / pixel + 0.5))
                opening *= max(0.0, min(1.0, (top_z - z) / pixel + 0.5))
            behind = max(0.0, min(1.0, (depth[row, i] / hit - 1.0) * 100.0 + 0.5)) if hit < 1e8 else 0.0
            hidden = (1.0 - opening) * behind
            seen_x = camera[0] + min(1e6, depth[row, i]) * dx
            dim = 1.0
            if seen_x < exit_x:
                dim = min(1.0, lamps_lx / outside_lx + daylight_share(exit_x - seen_x, half, top_z, 0))
            surface = 0.0
            if hidden > 0:
                hit_x = min(exit_x, camera[0] + hit * dx)
                lux = lamps_lx + outside_lx * daylight_share(
                    exit_x - hit_x, half, top_z, WALL if side < above else CEILING
                )
                spread = hit * max(abs(dx), 0.2) / (focal * max(0.02, abs(dy) if side < above else abs(dz)))
                pattern = (
                    JOINT_DEPTH
                    * max(0.0, 1.0 - 2.0 * spread / JOINT_M)
                    * math.cos(2 * math.pi * hit_x / JOINT_M)
                )
                surface = (wall if side < above else ceiling) * (1.0 + pattern) * lux / math.pi
            keep, add = np.float32(dim * (1.0 - hidden)), np.float32(hidden * surface)
            luminance[row, i] = keep * luminance[row, i] + add
            for c in range(channels):
                out[c, row, i] = keep * out[c, row, i] + add
            if hidden > 0.5:
                depth[row, i], ids[row, i] = np.float32(hit), int(ident)
