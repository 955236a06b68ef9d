"""Kernels of rain and snow: drops and flakes from hashed cells, streaks with soft edges."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.hashing import combine, unit

__all__ = ["FADE", "draw_rain"]

FADE = 0.4  # above the least width, over which a drop gains its full strength

# A cell's size depends on the rain alone, so that cameras of any optics see the same drops.
_DROPS_PER_CELL = 4.0
_LARGEST_CELL_M = 3.0
_SWAY_LEAST, _SWAY_MORE = 3.0, 4.0  # rad/s at which flakes sway
TURN = 2.0 * math.pi
_EDGE_PX = 0.5  # half a pixel: edges are blurred by the pixel's own width


@njit(cache=True, error_model="numpy")
def _poisson(mean: float, key: np.uint64) -> int:
    """Draw a Poisson number by inversion; for means up to some tens."""
    chance = math.exp(-mean)
    total, target, number = chance, unit(key), 0
    while total < target and number < 1000:
        number += 1
        chance *= mean / number
        total += chance
    return number


@njit(cache=True, error_model="numpy")
def _interval(slope: float, offset: float, half: float, low: float, high: float) -> tuple[float, float]:
    """Narrow [low, high] to where |slope x + offset| <= half; an empty result has low > high."""
    if abs(slope) < 1e-9:
        return (low, high) if abs(offset) <= half else (1.0, 0.0)
    a, b = (-half - offset) / slope, (half - offset) / slope
    return max(low, min(a, b)), min(high, max(a, b))


@njit(cache=True, error_model="numpy")
def _streak(
    luminance: np.ndarray,
    radiance: np.ndarray,
    depth: np.ndarray,
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    width_px: float,
    z: float,
    brightness: float,
    strength: float,
) -> bool:
    """Blend a streak between two image points; whether any pixel was reached."""
    rows, columns = luminance.shape
    length = math.hypot(x1 - x0, y1 - y0)
    along_x, along_y = ((x1 - x0) / length, (y1 - y0) / length) if length > 1e-6 else (0.0, 1.0)
    middle_x, middle_y = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    half_across = 0.5 * width_px + _EDGE_PX
    half_along = 0.5 * (width_px + length) + _EDGE_PX
    # Where the streak is narrower than a pixel, the pixel's share of it is what counts.
    opacity = strength * width_px / (width_px + length)
    most_across, most_along = min(1.0, width_px), min(1.0, width_px + length)
    reach = half_along * abs(along_y) + half_across * abs(along_x)
    first_row = max(0, math.floor(middle_y - reach))
    last_row = min(rows - 1, math.floor(middle_y + reach))
    hit = False
    for row in range(first_row, last_row + 1):
        dy = row + 0.5 - middle_y
        low, high = _interval(along_y, -along_x * dy, half_across, -1e9, 1e9)
        low, high = _interval(along_x, along_y * dy, half_along, low, high)
        if low > high:
            continue
        first = max(0, math.ceil(max(low + middle_x - 0.5, -1.0)))
        last = min(columns - 1, math.floor(min(high + middle_x - 0.5, float(columns))))
        for column in range(first, last + 1):
            if depth.shape[0] > 0 and depth[row, column] < z:
                continue
            dx = column + 0.5 - middle_x
            across = min(most_across, half_across - abs(dx * along_y - dy * along_x))
            along = min(most_along, half_along - abs(dx * along_x + dy * along_y))
            if across <= 0 or along <= 0:
                continue
            share = np.float32(opacity * across * along)
            hit = True
            luminance[row, column] += share * (brightness - luminance[row, column])
            for c in range(radiance.shape[0]):
                radiance[c, row, column] += share * (brightness - radiance[c, row, column])
    return hit


@njit(cache=True, error_model="numpy")
def _beam_lx(table: np.ndarray, spans: np.ndarray, beam: np.ndarray, x: float, y: float, z: float) -> float:
    """Illuminance at a point in camera coordinates from the headlights."""
    dx, dy, dz = x - beam[0], y - beam[1], z - beam[2]
    forward = dx * beam[3] + dy * beam[4] + dz * beam[5]
    if forward < 0.05:
        return 0.0
    rows, columns = table.shape
    left = (dx * beam[6] + dy * beam[7] + dz * beam[8]) / forward
    up = (dx * beam[9] + dy * beam[10] + dz * beam[11]) / forward
    i = (left - spans[0]) / (spans[1] - spans[0]) * (columns - 1)
    j = (up - spans[2]) / (spans[3] - spans[2]) * (rows - 1)
    if not (0 <= i < columns - 1 and 0 <= j < rows - 1):
        return 0.0
    a, b = int(j), int(i)
    t, s = i - b, j - a
    low = table[a, b] + t * (table[a, b + 1] - table[a, b])
    high = table[a + 1, b] + t * (table[a + 1, b + 1] - table[a + 1, b])
    return (low + s * (high - low)) / max(0.25, dx * dx + dy * dy + dz * dz)


@njit(cache=True, error_model="numpy")
def _class_streaks(
    luminance: np.ndarray,
    radiance: np.ndarray,
    depth: np.ndarray,
    origin: np.ndarray,
    rotation: np.ndarray,
    optics: tuple[float, float, float],
    time_s: float,
    exposure_s: float,
    velocity: np.ndarray,
    ego_mps: float,
    size: tuple[float, float, float, float],
    limits: tuple[float, float],
    brightness: float,
    lights: tuple[float, np.ndarray, np.ndarray, np.ndarray],
    sway_m: float,
    key: np.uint64,
) -> int:
    """Draw one size class of drops, all moving at ``velocity`` (world), swaying about their way by ``sway_m``."""
    focal, cx, cy = optics
    low_mm, high_mm, per_m3, slope = size
    least_px, nearest = limits
    scatter, table, spans, beam = lights
    rows, columns = luminance.shape
    farthest = 1e-3 * high_mm * focal / least_px
    if farthest <= nearest:
        return 0
    cell = min(_LARGEST_CELL_M, (_DROPS_PER_CELL / per_m3) ** (1.0 / 3.0))
    moved = rotation @ velocity
    moved[2] -= ego_mps
    # Bounds of the frustum in the frame that falls with the drops, widened by half a streak.
    shift = velocity * time_s
    slack = sway_m + 0.5 * exposure_s * (np.abs(velocity) + abs(ego_mps) * np.abs(rotation[2]))
    low, high = np.full(3, 1e18), np.full(3, -1e18)
    for z in (nearest, farthest):
        for u in (0.0, float(columns)):
            for v in (0.0, float(rows)):
                ray = np.array([(u - cx) / focal * z, (v - cy) / focal * z, z])
                for axis in range(3):
                    corner = (
                        rotation[0, axis] * ray[0] + rotation[1, axis] * ray[1] + rotation[2, axis] * ray[2]
                    )
                    corner += origin[axis] - shift[axis]
                    low[axis] = min(low[axis], corner - slack[axis])
                    high[axis] = max(high[axis], corner + slack[axis])
    first, last = np.floor(low / cell).astype(np.int64), np.floor(high / cell).astype(np.int64)
    # A cell is skipped when its bounding sphere, widened by half a streak, lies outside the frustum.
    radius = 0.5 * math.sqrt(3.0) * cell + math.sqrt(slack[0] ** 2 + slack[1] ** 2 + slack[2] ** 2)
    side, top = max(cx, columns - cx) / focal, max(cy, rows - cy) / focal
    side_norm, top_norm = math.hypot(1.0, side), math.hypot(1.0, top)
    mean = per_m3 * cell**3
    falling = math.exp(-slope * (high_mm - low_mm))
    drawn = 0
    here = np.empty(3)
    for ix in range(first[0], last[0] + 1):
        for iy in range(first[1], last[1] + 1):
            for iz in range(first[2], last[2] + 1):
                wx = (ix + 0.5) * cell + shift[0] - origin[0]
                wy = (iy + 0.5) * cell + shift[1] - origin[1]
                wz = (iz + 0.5) * cell + shift[2] - origin[2]
                px = rotation[0, 0] * wx + rotation[0, 1] * wy + rotation[0, 2] * wz
                py = rotation[1, 0] * wx + rotation[1, 1] * wy + rotation[1, 2] * wz
                pz = rotation[2, 0] * wx + rotation[2, 1] * wy + rotation[2, 2] * wz
                if pz + radius < nearest or pz - radius > farthest:
                    continue
                if abs(px) - side * pz > radius * side_norm or abs(py) - top * pz > radius * top_norm:
                    continue
                place = combine(combine(combine(key, np.uint64(ix)), np.uint64(iy)), np.uint64(iz))
                for drop in range(_poisson(mean, combine(place, np.uint64(0)))):
                    own = combine(place, np.uint64(drop + 1))
                    # Truncated exponential: the law of sizes within the class.
                    diameter_mm = low_mm - math.log(1.0 - unit(own) * (1.0 - falling)) / slope
                    for axis in range(3):
                        index = ix if axis == 0 else (iy if axis == 1 else iz)
                        own = combine(own, np.uint64(axis))
                        here[axis] = (index + unit(own)) * cell + shift[axis] - origin[axis]
                    if sway_m > 0:
                        own = combine(own, np.uint64(3))
                        turn = TURN * unit(own) + time_s * (
                            _SWAY_LEAST + _SWAY_MORE * unit(combine(own, np.uint64(4)))
                        )
                        here[0] += sway_m * math.cos(turn)
                        here[1] += sway_m * math.sin(turn)
                    z = rotation[2, 0] * here[0] + rotation[2, 1] * here[1] + rotation[2, 2] * here[2]
                    width_px = 1e-3 * diameter_mm * focal / z
                    if z < nearest or width_px < least_px:
                        continue
                    # What comes nearer appears little by little.
                    strength = min(1.0, (width_px / least_px - 1.0) / FADE)
                    x = rotation[0, 0] * here[0] + rotation[0, 1] * here[1] + rotation[0, 2] * here[2]
                    y = rotation[1, 0] * here[0] + rotation[1, 1] * here[1] + rotation[1, 2] * here[2]
                    shine = brightness
                    if table.shape[0] > 0:
                        shine += scatter * _beam_lx(table, spans, beam, x, y, z)
                    half = 0.5 * exposure_s
                    # A camera that overtakes the drop during the exposure sees it up to the near limit.
                    z0, z1 = max(0.5 * nearest, z - moved[2] * half), max(0.5 * nearest, z + moved[2] * half)
                    if _streak(
                        luminance, radiance, depth,
                        cx + focal * (x - moved[0] * half) / z0, cy + focal * (y - moved[1] * half) / z0,
                        cx + focal * (x + moved[0] * half) / z1, cy + focal * (y + moved[1] * half) / z1,
                        width_px, z, shine, strength,
                    ):  # fmt: skip
                        drawn += 1
    return drawn


@njit(cache=True, error_model="numpy")
def draw_rain(
    luminance: np.ndarray,
    radiance: np.ndarray,
    depth: np.ndarray,
    origin: np.ndarray,
    rotation: np.ndarray,
    focal: float,
    cx: float,
    cy: float,
    time_s: float,
    exposure_s: float,
    ego_mps: float,
    wind_mps: float,
    low_mm: np.ndarray,
    high_mm: np.ndarray,
    per_m3: np.ndarray,
    speed_mps: np.ndarray,
    slope: np.ndarray,
    least_px: float,
    nearest: float,
    brightness: float,
    lights: tuple[float, np.ndarray, np.ndarray, np.ndarray],
    sway_m: float,
    key: np.uint64,
) -> int:
    """Draw all classes of drops; return the number of streaks that reached a pixel.

    ``lights``: What the headlights add: luminance per lx, their candela table (or none), its spans (tangents to the
    left from .. to, upwards from .. to) and their place in camera coordinates.
    """
    drawn = 0
    for k in range(low_mm.size):
        drawn += _class_streaks(
            luminance, radiance, depth, origin, rotation, (focal, cx, cy), time_s, exposure_s,
            np.array([0.0, wind_mps, -speed_mps[k]]), ego_mps, (low_mm[k], high_mm[k], per_m3[k], slope[k]),
            (least_px, nearest), brightness, lights, sway_m, combine(key, np.uint64(k)),
        )  # fmt: skip
    return drawn
