"""Elementary functions of the event cameras' kernels, the same bits on every processor.

NumPy's error model: a division that may raise is not vectorised.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.jit import exact_kernel
from pedcross_env.hashing import combine, unit

__all__ = [
    "MIN_THRESHOLD",
    "TILE",
    "add_count",
    "exp_in_place",
    "log_above",
    "log_tile",
    "lognormal",
    "normal",
    "pack",
    "spread",
]

TILE = 256
MIN_THRESHOLD = np.float32(0.01)  # CARLA's and v2e's least
_SQRT_HALF_BITS = np.int32(0x3F3504F3)
_LN2 = np.float32(0.6931471805599453)
_LOG2_E = np.float32(1.4426950408889634)
_THIRD, _FIFTH, _SEVENTH, _NINTH = np.float32(1 / 3), np.float32(1 / 5), np.float32(1 / 7), np.float32(1 / 9)
_E2, _E3, _E4, _E5, _E6 = (np.float32(1 / math.factorial(n)) for n in range(2, 7))
_ONE = np.float32(1)


@exact_kernel
def log_tile(
    values: np.ndarray, floor: np.float32, out: np.ndarray, work: tuple[np.ndarray, np.ndarray]
) -> None:
    """ln of values + floor, which are positive and normal: exponent ln 2 + 2 atanh((m - 1) / (m + 1)), m near 1.

    ``work`` is two of float32, at least as long as ``values``.
    """
    n = values.size
    exponent, mantissa = work[0][:n], work[1][:n]
    bits = mantissa.view(np.int32)
    for i in range(n):
        mantissa[i] = values[i] + floor
    for i in range(n):
        shift = np.int32(np.int32(bits[i] - _SQRT_HALF_BITS) >> np.int32(23))
        exponent[i] = np.float32(shift)
        bits[i] = np.int32(bits[i] - np.int32(shift << np.int32(23)))
    for i in range(n):
        m = mantissa[i]
        s = (m - _ONE) / (m + _ONE)
        q = s * s
        series = q * (_THIRD + q * (_FIFTH + q * (_SEVENTH + q * _NINTH)))
        out[i] = exponent[i] * _LN2 + np.float32(2) * (s + s * series)


@njit(cache=True, error_model="numpy")
def log_above(values: np.ndarray, floor: np.float32, out: np.ndarray) -> None:
    """ln of values + floor, which are positive and normal."""
    work = np.empty(TILE, np.float32), np.empty(TILE, np.float32)
    for start in range(0, values.size, TILE):
        stop = min(values.size, start + TILE)
        log_tile(values[start:stop], floor, out[start:stop], work)


@njit(cache=True, error_model="numpy")
def exp_in_place(values: np.ndarray, work: np.ndarray) -> None:
    """e to float32 values, which are taken between -87 and 87, to 3e-7 of it.

    2^k times a series in the rest. ``work`` (n,) int32 is overwritten.
    """
    for i in range(values.size):
        scaled = min(np.float32(125), max(np.float32(-125), values[i] * _LOG2_E))
        whole = np.float32(np.int32(scaled + np.float32(126.5))) - np.float32(126)
        rest = (scaled - whole) * _LN2
        work[i] = np.int32((np.int32(whole) + np.int32(127)) << np.int32(23))
        tail = rest * rest * (_E2 + rest * (_E3 + rest * (_E4 + rest * (_E5 + rest * _E6))))
        values[i] = _ONE + rest + tail
    powers = work.view(np.float32)
    for i in range(values.size):
        values[i] *= powers[i]


@njit(cache=True, error_model="numpy")
def normal(key: np.uint64) -> float:
    """Draw a standard normal number (Box and Muller, 1958)."""
    first, second = unit(combine(key, np.uint64(0))), unit(combine(key, np.uint64(1)))
    return math.sqrt(-2.0 * math.log(first)) * math.cos(2.0 * math.pi * second)


@njit(cache=True, error_model="numpy")
def spread(values: np.ndarray, sigma: float, key: np.uint64) -> None:
    """Add a normal spread to every threshold, never below the least."""
    for i in range(values.size):
        drawn = np.float32(values[i] + np.float32(sigma * normal(combine(key, np.uint64(i)))))
        values[i] = max(MIN_THRESHOLD, drawn)


@njit(cache=True, error_model="numpy")
def lognormal(values: np.ndarray, decades: float, key: np.uint64) -> None:
    """Multiply every value by ten to a normal number of this spread."""
    for i in range(values.size):
        values[i] *= np.float32(10.0 ** (decades * normal(combine(key, np.uint64(i)))))


@njit(cache=True, inline="always")
def add_count(index: int, on: bool, counts: np.ndarray) -> None:
    """Add one event to the counts, which stop at their type's largest value."""
    channel = np.uint64(0 if on else 1)
    value = counts[index, channel]
    following = counts.dtype.type(value + 1)
    if following != 0:
        counts[index, channel] = following


@njit(cache=True, inline="always")
def pack(t_ns: int, index: int, on: bool, source: int, bits: int) -> np.uint64:
    """Pack time since the last frame, pixel, polarity and source: sorted keys are events sorted by (t, y, x, pol)."""
    low = (np.uint64(index) << np.uint64(3)) | (np.uint64(on) << np.uint64(2)) | np.uint64(source)
    return (np.uint64(t_ns) << np.uint64(bits)) | low
