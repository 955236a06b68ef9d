"""Kernels of rain and snow: drops and flakes from hashed cells, streaks with soft edges."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env._optics_kernels import bend
from pedcross_env.hashing import combine, unit

__all__ = ["FADE", "draw_rain"]

FADE = 0.4  # above the least width, over which a drop gains its full strength

# A cell's size depends on the rain alone, so that cameras of any optics see the same drops.
_DROPS_PER_CELL = 4.0
_LARGEST_CELL_M = 3.0
_SWAY_LEAST, _SWAY_MORE = 3.0, 4.0  # rad/s at which flakes sway
_TUMBLE, _GLINT = (
    6.0,
    0.8,
)  # how many times as fast they tumble, and how far what they send back strays from its mean
TURN = 2.0 * math.pi
_PLACE, _PER_PLACE = np.uint64((1 << 21) - 1), 2.0**-21
_ROUND_PX = 1.5  # width from which a drop is drawn round and soft
_APERTURE_M = (
    1.6e-3  # of a dashcam's lens, 3.2 mm at f/2: it sees what is near as if smeared over a disc of this size
)
_SHORTEST_PX = 0.05  # of a streak: integrals over less lose their digits
_PIXEL_PX2 = 0.25  # by which a pixel's own size widens the square of a radius
_LENS_PX2 = 1.5  # the same by a lens and its pixel, where light stands before the dark: an edge would show
_EDGE_M = 0.02  # a drop's own size, so far beyond the frustum's sides
_EDGE_PX = 0.5  # half a pixel: edges are blurred by the pixel's own width


@njit(cache=True, error_model="numpy")
def _poisson(none: float, mean: float, key: np.uint64) -> int:
    """Draw a Poisson number by inversion, for means up to some tens; ``none`` = exp(-mean)."""
    chance = none
    total, target, number = chance, unit(key), 0
    while total < target and number < 1000:
        number += 1
        chance *= mean / number
        total += chance
    return number


@njit(cache=True, error_model="numpy")
def _passed(along: float, across: float, end: float, radius2: float) -> float:
    """Integral of 1 - r^2 / radius^2 over the places of a disc whose middle moves from -end to end along a line."""
    left2 = radius2 - across * across
    if left2 <= 0.0:
        return 0.0
    chord = math.sqrt(left2)
    a, b = max(-chord, along - end), min(chord, along + end)
    if b <= a:
        return 0.0
    return ((b - a) * left2 - (b * b * b - a * a * a) / 3.0) / radius2


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
    blur_px: float,
    z: float,
    bright0: float,
    bright1: float,
    strength: float,
    shines: bool,
) -> bool:
    """Blend a streak of two ends, out of focus by ``blur_px``; whether any pixel was reached.

    One that ``shines`` hides nothing: it is light on its way from one brightness to another, added to what is there.
    """
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
    side = half_along * abs(along_x) + half_across * abs(along_y)
    # In a row: the columns no farther than half the width from the streak's line, and within its ends' reach.
    steep = abs(along_y) > 1e-3
    slant = along_x / along_y if steep else 0.0
    half_row = half_across / abs(along_y) if steep else side
    colour, hidden = radiance.shape[0] > 0, depth.shape[0] > 0
    # Wide ones are round and thin out towards their edges, as 1 - (r / radius)^2, the area below which is the square's:
    # flakes are fluff, and what is near is out of focus.
    radius2, end, thickest = 1.0, 0.5 * max(length, _SHORTEST_PX), 0.0
    mean, slope, hides = 0.5 * (bright0 + bright1), 0.5 * (bright1 - bright0) / end, np.float32(not shines)
    wide = width_px > _ROUND_PX or shines
    if wide:
        soft = _LENS_PX2 if shines else _PIXEL_PX2
        radius2 = 2.0 / math.pi * width_px * width_px + 0.5 * blur_px * blur_px + soft
        thickest = strength * width_px * width_px / (math.pi * radius2 * end)
        half_across = math.sqrt(radius2)
        half_along = half_across + end
        reach = half_along * abs(along_y) + half_across * abs(along_x)
        side = half_along * abs(along_x) + half_across * abs(along_y)
        half_row = half_across / abs(along_y) if steep else side
    first_row = max(0, math.floor(middle_y - reach))
    last_row = min(rows - 1, math.floor(middle_y + reach))
    if last_row < first_row or middle_x + side < 0 or middle_x - side > columns:
        return False
    hit, brightness = False, mean
    for row in range(first_row, last_row + 1):
        dy = row + 0.5 - middle_y
        at = slant * dy
        low, high = max(at - half_row, -side), min(at + half_row, side)
        first = max(0, math.ceil(low + middle_x - 0.5))
        last = min(columns - 1, math.floor(high + middle_x - 0.5))
        for column in range(first, last + 1):
            if hidden and depth[row, column] < z:
                continue
            dx = column + 0.5 - middle_x
            if wide:
                share = np.float32(
                    thickest * _passed(dx * along_x + dy * along_y, dx * along_y - dy * along_x, end, radius2)
                )
            else:
                across = min(most_across, half_across - abs(dx * along_y - dy * along_x))
                along = min(most_along, half_along - abs(dx * along_x + dy * along_y))
                share = np.float32(opacity * max(0.0, across) * max(0.0, along))
            if share <= 0:
                continue
            hit = True
            if shines:
                brightness = mean + slope * min(end, max(-end, dx * along_x + dy * along_y))
            luminance[row, column] += share * (brightness - hides * luminance[row, column])
            if colour:
                radiance[0, row, column] += share * (brightness - hides * radiance[0, row, column])
                radiance[1, row, column] += share * (brightness - hides * radiance[1, row, column])
                radiance[2, row, column] += share * (brightness - hides * radiance[2, row, column])
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
def _span(rotation: np.ndarray, axis: int, slope: float) -> float:
    """How far a world-aligned unit cube reaches across the planes |camera axis| = slope * depth, both ways together."""
    one = other = 0.0
    for k in range(3):
        one += abs(rotation[axis, k] - slope * rotation[2, k])
        other += abs(rotation[axis, k] + slope * rotation[2, k])
    return max(one, other)


@njit(cache=True, error_model="numpy")
def _class_streaks(
    luminance: np.ndarray,
    radiance: np.ndarray,
    depth: np.ndarray,
    origin: np.ndarray,
    rotation: np.ndarray,
    optics: tuple[float, float, float, float, float, int, np.ndarray],
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
    focal, cx, cy, side, top, lens, coefficients = optics
    low_mm, high_mm, per_m3, slope = size
    least_px, nearest = limits
    scatter, table, spans, beam = lights
    farthest = 1e-3 * high_mm * focal / least_px
    if farthest <= nearest:
        return 0
    cell = min(_LARGEST_CELL_M, (_DROPS_PER_CELL / per_m3) ** (1.0 / 3.0))
    moved = (
        rotation[0, 1] * velocity[1] + rotation[0, 2] * velocity[2],
        rotation[1, 1] * velocity[1] + rotation[1, 2] * velocity[2],
        rotation[2, 1] * velocity[1] + rotation[2, 2] * velocity[2] - ego_mps,
    )
    # Bounds of the frustum in the frame that falls with the drops, widened by half a streak.
    shift = velocity * time_s
    slack = sway_m + 0.5 * exposure_s * (np.abs(velocity) + abs(ego_mps) * np.abs(rotation[2]))
    low, high = np.full(3, 1e18), np.full(3, -1e18)
    for z in (nearest, farthest):
        for u in (-side, side):
            for v in (-top, top):
                for axis in range(3):
                    corner = z * (rotation[0, axis] * u + rotation[1, axis] * v + rotation[2, axis])
                    corner += origin[axis] - shift[axis]
                    low[axis] = min(low[axis], corner - slack[axis])
                    high[axis] = max(high[axis], corner + slack[axis])
    first, last = np.floor(low / cell).astype(np.int64), np.floor(high / cell).astype(np.int64)
    # A drop is skipped where it lies outside the frustum by more than half a streak, and a cell where all of it does.
    widest = math.sqrt(slack[0] ** 2 + slack[1] ** 2 + slack[2] ** 2)
    side_norm, top_norm = math.hypot(1.0, side), math.hypot(1.0, top)
    beyond_side, beyond_top = (widest + _EDGE_M) * side_norm, (widest + _EDGE_M) * top_norm
    reach_z = 0.5 * cell * _span(rotation, 2, 0.0) + sway_m
    reach_side = 0.5 * cell * _span(rotation, 0, side) + sway_m * side_norm + beyond_side
    reach_top = 0.5 * cell * _span(rotation, 1, top) + sway_m * top_norm + beyond_top
    mean = per_m3 * cell**3
    none = math.exp(-mean)
    falling = math.exp(-slope * (high_mm - low_mm))
    half = 0.5 * exposure_s
    drawn = 0
    for ix in range(first[0], last[0] + 1):
        wx = (ix + 0.5) * cell + shift[0] - origin[0]
        for iy in range(first[1], last[1] + 1):
            wy = (iy + 0.5) * cell + shift[1] - origin[1]
            column_key = combine(combine(key, np.uint64(ix)), np.uint64(iy))
            for iz in range(first[2], last[2] + 1):
                wz = (iz + 0.5) * cell + shift[2] - origin[2]
                pz = rotation[2, 0] * wx + rotation[2, 1] * wy + rotation[2, 2] * wz
                if pz + reach_z < nearest or pz - reach_z > farthest:
                    continue
                px = rotation[0, 0] * wx + rotation[0, 1] * wy + rotation[0, 2] * wz
                py = rotation[1, 0] * wx + rotation[1, 1] * wy + rotation[1, 2] * wz
                if abs(px) - side * pz > reach_side or abs(py) - top * pz > reach_top:
                    continue
                place = combine(column_key, np.uint64(iz))
                for drop in range(_poisson(none, mean, combine(place, np.uint64(0)))):
                    own = combine(place, np.uint64(drop + 1))
                    # Three places in the cell of 21 bits each.
                    hx = wx + (np.float64(own & _PLACE) * _PER_PLACE - 0.5) * cell
                    hy = wy + (np.float64((own >> np.uint64(21)) & _PLACE) * _PER_PLACE - 0.5) * cell
                    hz = wz + (np.float64((own >> np.uint64(42)) & _PLACE) * _PER_PLACE - 0.5) * cell
                    own = combine(own, np.uint64(1))
                    glint0 = glint1 = 1.0
                    if sway_m > 0:
                        turns = combine(own, np.uint64(3))
                        speed = _SWAY_LEAST + _SWAY_MORE * unit(combine(turns, np.uint64(4)))
                        turn = TURN * unit(turns) + time_s * speed
                        hx += sway_m * math.cos(turn)
                        hy += sway_m * math.sin(turn)
                        glint0 += _GLINT * math.sin(_TUMBLE * (turn - speed * half))
                        glint1 += _GLINT * math.sin(_TUMBLE * (turn + speed * half))
                    z = rotation[2, 0] * hx + rotation[2, 1] * hy + rotation[2, 2] * hz
                    if z < nearest or z > farthest:
                        continue
                    x = rotation[0, 0] * hx + rotation[0, 1] * hy + rotation[0, 2] * hz
                    y = rotation[1, 0] * hx + rotation[1, 1] * hy + rotation[1, 2] * hz
                    if abs(x) - side * z > beyond_side or abs(y) - top * z > beyond_top:
                        continue
                    # Truncated exponential: the law of sizes within the class.
                    diameter_mm = low_mm - math.log(1.0 - unit(own) * (1.0 - falling)) / slope
                    width_px = 1e-3 * diameter_mm * focal / z
                    if width_px < least_px:
                        continue
                    # What comes nearer appears little by little.
                    strength = min(1.0, (width_px / least_px - 1.0) / FADE)
                    # A camera that overtakes the drop during the exposure sees it up to the near limit.
                    z0, z1 = max(0.5 * nearest, z - moved[2] * half), max(0.5 * nearest, z + moved[2] * half)
                    u0, v0, scale0 = bend(
                        lens, coefficients, (x - moved[0] * half) / z0, (y - moved[1] * half) / z0
                    )
                    u1, v1, scale1 = bend(
                        lens, coefficients, (x + moved[0] * half) / z1, (y + moved[1] * half) / z1
                    )
                    if scale0 <= 0 or scale1 <= 0:
                        continue
                    shine = 0.0
                    if table.shape[0] > 0:
                        shine = scatter * _beam_lx(table, spans, beam, x, y, z)
                    u0, v0, u1, v1 = cx + focal * u0, cy + focal * v0, cx + focal * u1, cy + focal * v1
                    seen_px, blur_px = 0.5 * (scale0 + scale1) * width_px, _APERTURE_M * focal / z
                    here = brightness if sway_m > 0 else brightness + shine
                    if _streak(
                        luminance, radiance, depth, u0, v0, u1, v1, seen_px, blur_px, z, here, here, strength, False,
                    ):  # fmt: skip
                        drawn += 1
                        if sway_m > 0 and shine > 0:
                            _streak(
                                luminance, radiance, depth, u0, v0, u1, v1, seen_px, blur_px, z, shine * glint0,
                                shine * glint1, strength, True,
                            )  # fmt: skip
    return drawn


@njit(cache=True, error_model="numpy")
def draw_rain(
    luminance: np.ndarray,
    radiance: np.ndarray,
    depth: np.ndarray,
    origin: np.ndarray,
    rotation: np.ndarray,
    optics: tuple[float, float, float, float, float, int, np.ndarray],
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

    ``optics``: Focal length, cx, cy; the tangents that the view reaches to the side and up or down; the lens and its
    four coefficients as ``bend`` takes them. ``lights``: What the headlights add: luminance per lx, their candela table
    (or none), its spans (tangents to the left from .. to, upwards from .. to) and their place in camera coordinates.
    """
    drawn = 0
    for k in range(low_mm.size):
        drawn += _class_streaks(
            luminance, radiance, depth, origin, rotation, optics, time_s, exposure_s,
            np.array([0.0, wind_mps, -speed_mps[k]]), ego_mps, (low_mm[k], high_mm[k], per_m3[k], slope[k]),
            (least_px, nearest), brightness, lights, sway_m, combine(key, np.uint64(k)),
        )  # fmt: skip
    return drawn
