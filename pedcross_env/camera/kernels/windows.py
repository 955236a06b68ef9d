"""Windows: the parts of the image that objects can reach, each drawn in the coordinates of its own.

A window is its first row, its first column, its rows and its columns.
"""

from __future__ import annotations

import math

from pedcross_env.camera.kernels.jit import LANES, allocating_kernel, kernel
from pedcross_env.camera.kernels.polygons import NEAR_M

__all__ = ["houses_window", "look_through", "plane_of", "store", "visible", "window_of"]


@kernel
def visible(centre, radius, optics, size):
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


@kernel
def window_of(centre, radius, optics, size):
    """The window that a sphere can reach, its columns in whole vectors."""
    focal, cx, cy = optics
    top, bottom = _reach(centre[1], centre[2], radius, focal, cy, size[0])
    left, right = _reach(centre[0], centre[2], radius, focal, cx, size[1])
    left = left // LANES * LANES
    return top, left, bottom - top, min(size[1] - left, (right - left + LANES - 1) // LANES * LANES)


@kernel
def _reach(across, ahead, radius, focal, middle, extent):
    """First pixel, of ``extent`` along one axis, that a sphere can reach, and the one beyond the last."""
    if ahead <= radius + NEAR_M:
        return 0, extent
    tangent = math.sqrt(across * across + ahead * ahead - radius * radius)
    low = (across * tangent - ahead * radius) / (ahead * tangent + across * radius)
    high = (across * tangent + ahead * radius) / (ahead * tangent - across * radius)
    first, last = middle + focal * low, middle + focal * high
    first, last = max(0.0, min(first, extent + 0.0)), max(0.0, min(last, extent + 0.0))
    return int(first), int(math.ceil(last))


@allocating_kernel
def look_through(window, planes, channels, optics):
    """Scratch planes, optics and size of a window: objects are drawn in its coordinates.

    All are drawn in the same memory, wherever they are in the image: it stays in the cache.
    """
    top, left, rows, columns = window
    focal, cx, cy = optics
    colours, cover, inverse = planes
    pixels = rows * columns
    scratch = (
        colours[: channels * pixels].reshape((channels, rows, columns)), cover[:pixels].reshape((rows, columns)),
        inverse[:pixels].reshape((rows, columns)),
    )  # fmt: skip
    return scratch, (focal, cx - left, cy - top), (rows, columns)


@allocating_kernel
def plane_of(window, plane):
    """One more plane of a window's size."""
    return plane[: window[2] * window[3]].reshape((window[2], window[3]))


@kernel
def houses_window(faced, count, which, seen, windows, size):
    """The window that walls and roofs (which[faced:count], as -1 - actor) reach."""
    left, top, right, bottom = size[1] + 0.0, size[0] + 0.0, 0.0, 0.0
    for k in range(faced):
        b = seen[2][which[k]]
        left, top, right, bottom = min(left, b[0]), min(top, b[1]), max(right, b[2]), max(bottom, b[3])
    for k in range(faced, count):
        w = windows[-1 - which[k]]
        left, top = min(left, w[1] + 0.0), min(top, w[0] + 0.0)
        right, bottom = max(right, w[1] + w[3] + 0.0), max(bottom, w[0] + w[2] + 0.0)
    first, beyond = int(left) // LANES * LANES, int(math.ceil(right))
    columns = min(size[1] - first, (beyond - first + LANES - 1) // LANES * LANES)
    return int(top), first, max(0, int(math.ceil(bottom)) - int(top)), max(0, columns)


@kernel
def store(window, out):
    """Keep a window in a row of a table."""
    out[0], out[1], out[2], out[3] = window
