"""Kernels of the windscreen: drops from hashed cells of the glass, out of focus, and the blade that wipes them."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.hashing import combine, unit

__all__ = ["coarse_picture", "draw_blade", "draw_drops"]

CELL_M = 0.008  # of the glass
_GROWN_S = 0.02  # in which a drop spreads once it has struck
_SPREAD = 0.9  # radius on the glass over the drop's diameter
_RUNS_FROM_MM = 1.8  # smaller drops stick
_CLEAR = 0.93  # share of the light that a drop lets through
_SIDE, _UP = 0.35, 0.45  # of the picture's width and height that a drop shows to either side, upside down


@njit(cache=True, error_model="numpy")
def coarse_picture(plane: np.ndarray, coarse: np.ndarray) -> None:
    """Fill ``coarse`` (h, w) with the means of the plane's blocks."""
    rows, columns = coarse.shape
    height, width = plane.shape
    for a in range(rows):
        top, bottom = a * height // rows, (a + 1) * height // rows
        for b in range(columns):
            left, right = b * width // columns, (b + 1) * width // columns
            total = 0.0
            for y in range(top, bottom):
                for x in range(left, right):
                    total += plane[y, x]
            coarse[a, b] = total / ((bottom - top) * (right - left))


@njit(cache=True, error_model="numpy")
def _sample(coarse: np.ndarray, u: float, v: float) -> float:
    """Bilinear value at shares u, v of width and height."""
    rows, columns = coarse.shape
    p = min(max(u * columns - 0.5, 0.0), columns - 1.001)
    q = min(max(v * rows - 0.5, 0.0), rows - 1.001)
    i, j = int(p), int(q)
    s, t = p - i, q - j
    low = coarse[j, i] + s * (coarse[j, i + 1] - coarse[j, i])
    high = coarse[j + 1, i] + s * (coarse[j + 1, i + 1] - coarse[j + 1, i])
    return low + t * (high - low)


@njit(cache=True, error_model="numpy")
def _drop(planes: np.ndarray, coarse: np.ndarray, x: float, y: float, radius: float, blur: float) -> None:
    """Put one drop before (C, H, W): a disc with a soft rim, through which the scene is seen small and upside down."""
    channels, height, width = planes.shape
    reach = radius + blur
    strongest = _CLEAR * min(1.0, (radius / blur) ** 2) if blur > 0 else _CLEAR
    for row in range(max(0, math.floor(y - reach)), min(height, math.ceil(y + reach))):
        dy = row + 0.5 - y
        for column in range(max(0, math.floor(x - reach)), min(width, math.ceil(x + reach))):
            dx = column + 0.5 - x
            cover = min(
                1.0, max(0.0, (reach - math.sqrt(dx * dx + dy * dy)) / (2.0 * min(radius, blur) + 1e-6))
            )
            if cover <= 0.0:
                continue
            share = np.float32(strongest * cover * cover * (3.0 - 2.0 * cover))
            u, v = 0.5 - _SIDE * dx / radius, 0.5 - _UP * dy / radius
            for c in range(channels):
                seen = np.float32(_CLEAR * _sample(coarse[c], u, v))
                planes[c, row, column] += share * (seen - planes[c, row, column])


@njit(cache=True, error_model="numpy")
def _at(table: np.ndarray, times: np.ndarray, time_s: float) -> float:
    """Interpolate a running total of the drive; before its first moment it went on as it began."""
    n = times.size
    if time_s >= times[n - 1]:
        return table[n - 1]
    if time_s <= times[0]:
        return table[0]
    k = n - 2
    while times[k] > time_s:
        k -= 1
    return table[k] + (table[k + 1] - table[k]) * (time_s - times[k]) / (times[k + 1] - times[k])


@njit(cache=True, error_model="numpy")
def _time_of(table: np.ndarray, times: np.ndarray, value: float) -> float:
    n = times.size
    if value >= table[n - 1]:
        return times[n - 1]
    k = n - 2
    while k > 0 and table[k] > value:
        k -= 1
    rise = table[k + 1] - table[k]
    return times[k] + (times[k + 1] - times[k]) * (value - table[k]) / rise if rise > 0 else times[k]


@njit(cache=True, error_model="numpy")
def wiped_s(time_s: float, angle: float, wiper: tuple[float, float, float, float]) -> float:
    """When the blade last passed ``angle`` from the upright; ``wiper``: period, sweep, phase, largest angle."""
    period, sweep, phase, most = wiper
    if period <= 0 or abs(angle) >= most:
        return -1e9
    there = sweep / math.pi * math.acos(-angle / most)
    start = math.floor((time_s - phase) / period) * period + phase
    age = time_s - start
    if age >= 2.0 * sweep - there:
        return start + 2.0 * sweep - there
    if age >= there:
        return start + there
    return start - period + 2.0 * sweep - there


@njit(cache=True, error_model="numpy")
def draw_drops(
    planes: np.ndarray,
    coarse: np.ndarray,
    optics: tuple[float, float, float, float],
    drops: tuple[float, float, float],
    drive: tuple[np.ndarray, np.ndarray, np.ndarray],
    wiper: tuple[float, float, float, float],
    pivot: tuple[float, float],
    lifetime_s: float,
    time_s: float,
    key: np.uint64,
) -> int:
    """Draw the drops that have struck since the blade last passed; return how many.

    Args:
        planes: (C, H, W), changed.
        coarse: (C, h, w) the picture in blocks.
        optics: Pixels per metre of glass, cx, cy, radius in pixels by which the glass is out of focus.
        drops: Smallest diameter in mm, slope of the diameters' exponential law per mm, largest diameter.
        drive: Times (N,); drops per m2 of glass since the start (N,); metres that large drops have run upwards (N,).
        wiper: See ``wiped_s``; a period of 0: none.
        pivot: Of the blade, metres right of and below the optical axis.
        lifetime_s: After which a drop that nothing wipes has run off.
        time_s: Now.
        key: Of the drops' hash.
    """
    per_m, cx, cy, blur = optics
    smallest, slope, largest = drops
    times, struck, ran = drive
    height, width = planes.shape[1], planes.shape[2]
    now, run_now = _at(struck, times, time_s), _at(ran, times, time_s)
    most_run = abs(run_now - _at(ran, times, time_s - lifetime_s)) + 1e-3
    left, right = math.floor(-cx / per_m / CELL_M) - 1, math.ceil((width - cx) / per_m / CELL_M) + 1
    margin = math.ceil(most_run / CELL_M) + 1
    top, bottom = (
        math.floor(-cy / per_m / CELL_M) - margin,
        math.ceil((height - cy) / per_m / CELL_M) + margin,
    )
    area = CELL_M * CELL_M  # a bin of the hash holds as much rain as brings one drop to a cell on average
    drawn = 0
    for a in range(top, bottom):
        for b in range(left, right):
            cell_key = combine(combine(key, np.uint64(a + 100000)), np.uint64(b + 100000))
            middle = math.atan2((b + 0.5) * CELL_M - pivot[0], pivot[1] - (a + 0.5) * CELL_M)
            since = max(wiped_s(time_s, middle, wiper), time_s - lifetime_s)
            earliest = _at(struck, times, since - 0.2) * area
            for strip in range(math.floor(earliest), math.floor(now * area) + 1):
                place = combine(cell_key, np.uint64(strip + 100000))
                chance, number = unit(place), 0
                step = 0.36787944117144233  # e^-1: a Poisson number of mean 1
                below = step
                while below < chance and number < 8:
                    number += 1
                    step /= number
                    below += step
                for drop in range(number):
                    own = combine(place, np.uint64(drop + 1))
                    when = (strip + unit(own)) / area
                    if when > now:
                        continue
                    own = combine(own, np.uint64(1))
                    x = (b + unit(own)) * CELL_M
                    own = combine(own, np.uint64(2))
                    y = (a + unit(own)) * CELL_M
                    own = combine(own, np.uint64(3))
                    size_mm = min(largest, smallest - math.log(1.0 - 0.999999 * unit(own)) / slope)
                    born_s = _time_of(struck, times, when)
                    age = time_s - born_s
                    if age > lifetime_s:
                        continue
                    if size_mm > _RUNS_FROM_MM:  # upwards is to smaller y
                        y -= min(1.0, size_mm - _RUNS_FROM_MM) * (run_now - _at(ran, times, born_s))
                    if wiped_s(time_s, math.atan2(x - pivot[0], pivot[1] - y), wiper) > born_s:
                        continue
                    grown = min(1.0, age / _GROWN_S) * min(1.0, (lifetime_s - age) / (0.1 * lifetime_s))
                    radius = _SPREAD * 1e-3 * size_mm * per_m * math.sqrt(max(grown, 1e-3))
                    u, v = cx + x * per_m, cy + y * per_m
                    if (
                        -radius - blur < u < width + radius + blur
                        and -radius - blur < v < height + radius + blur
                    ):
                        _drop(planes, coarse, u, v, radius, blur)
                        drawn += 1
    return drawn


@njit(cache=True, error_model="numpy")
def draw_blade(
    planes: np.ndarray,
    optics: tuple[float, float, float, float],
    angle: float,
    pivot: tuple[float, float],
    half_m: float,
    kept: float,
) -> None:
    """Darken what the blade covers at ``angle`` from the upright; ``kept``: share of the light that is left there."""
    per_m, cx, cy, blur = optics
    channels, height, width = planes.shape
    s, c = math.sin(angle), math.cos(angle)
    half, reach = half_m * per_m, half_m * per_m + blur
    px, py = cx + pivot[0] * per_m, cy + pivot[1] * per_m
    for row in range(height):
        up = py - (row + 0.5)
        # across = (x - px) c - up s: the columns within reach
        if abs(c) < 1e-3:
            continue
        middle = px + up * s / c
        for column in range(
            max(0, math.floor(middle - reach / c)), min(width, math.ceil(middle + reach / c) + 1)
        ):
            across = abs((column + 0.5 - px) * c - up * s)
            cover = min(1.0, max(0.0, (half + blur - across) / (2.0 * blur)))
            share = np.float32(1.0 - (1.0 - kept) * cover * cover * (3.0 - 2.0 * cover))
            for k in range(channels):
                planes[k, row, column] *= share
