"""Kernels of the event camera. Flat pixel arrays; float32 throughout, as in CARLA.

NumPy's error model: a division that may raise is not vectorised.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.hashing import combine, unit

__all__ = ["add_background", "advance", "log_in_place", "spread_thresholds", "unpack"]

_SQRT_HALF_BITS = np.int32(0x3F3504F3)
_LN2 = np.float32(0.6931471805599453)
_THIRD, _FIFTH, _SEVENTH, _NINTH = np.float32(1 / 3), np.float32(1 / 5), np.float32(1 / 7), np.float32(1 / 9)
_TOLERANCE = np.float32(1e-6)  # smaller changes are none
_MIN_THRESHOLD = np.float32(0.01)
_NS = 1e9
_TILE = 128


@njit(cache=True, error_model="numpy")
def log_in_place(values: np.ndarray) -> None:
    """ln of positive, normal float32 values: exponent ln 2 + 2 atanh((m - 1) / (m + 1)), m near 1."""
    bits = values.view(np.int32)
    exponent = np.empty(_TILE, np.float32)
    mantissa = np.empty(_TILE, np.float32)
    mantissa_bits = mantissa.view(np.int32)
    for start in range(0, values.size, _TILE):
        n = min(_TILE, values.size - start)
        tile = bits[start : start + n]
        for i in range(n):
            shift = np.int32(np.int32(tile[i] - _SQRT_HALF_BITS) >> np.int32(23))
            exponent[i] = np.float32(shift)
            mantissa_bits[i] = np.int32(tile[i] - np.int32(shift << np.int32(23)))
        out = values[start : start + n]
        for i in range(n):
            m = mantissa[i]
            s = (m - np.float32(1)) / (m + np.float32(1))
            q = s * s
            series = q * (_THIRD + q * (_FIFTH + q * (_SEVENTH + q * _NINTH)))
            out[i] = exponent[i] * _LN2 + np.float32(2) * (s + s * series)


@njit(cache=True, error_model="numpy")
def _normal(key: np.uint64) -> float:
    """Draw a standard normal number (Box and Muller, 1958)."""
    first, second = unit(combine(key, np.uint64(0))), unit(combine(key, np.uint64(1)))
    return math.sqrt(-2.0 * math.log(first)) * math.cos(2.0 * math.pi * second)


@njit(cache=True, error_model="numpy")
def spread_thresholds(values: np.ndarray, sigma: float, key: np.uint64) -> None:
    """Add a normal spread to every threshold, never below CARLA's least."""
    for i in range(values.size):
        drawn = np.float32(values[i] + np.float32(sigma * _normal(combine(key, np.uint64(i)))))
        values[i] = max(_MIN_THRESHOLD, drawn)


@njit(cache=True, inline="always")
def _count(index: int, on: bool, counts: np.ndarray) -> None:
    """Add one event to the counts, which stop at their type's largest value."""
    channel = np.uint64(0 if on else 1)
    value = counts[index, channel]
    following = counts.dtype.type(value + 1)
    if following != 0:
        counts[index, channel] = following


@njit(cache=True, inline="always")
def _sort_key(index: int, on: bool, t_ns: int, bits: int) -> np.uint64:
    """Pack time since the last frame, pixel and polarity: sorted keys are events sorted by (t, y, x, pol)."""
    return (np.uint64(t_ns) << np.uint64(bits)) | (np.uint64(index) << np.uint64(1)) | np.uint64(on)


@njit(cache=True, error_model="numpy")
def _reaches_shared(frame: np.ndarray, reference: np.ndarray, positive: float, negative: float) -> bool:
    """Whether any pixel is a threshold or more away from its reference, all with the same thresholds."""
    hits = np.uint8(0)
    for i in range(frame.size):
        above = frame[i] >= reference[i] + positive
        below = frame[i] <= reference[i] - negative
        hits |= np.uint8(above) | np.uint8(below)
    return bool(hits > 0)


@njit(cache=True, error_model="numpy")
def _reaches(frame: np.ndarray, reference: np.ndarray, positive: np.ndarray, negative: np.ndarray) -> bool:
    """Whether any pixel is a threshold or more away from its reference."""
    hits = np.uint8(0)
    for i in range(frame.size):
        above = frame[i] >= reference[i] + positive[i]
        below = frame[i] <= reference[i] - negative[i]
        hits |= np.uint8(above) | np.uint8(below)
    return bool(hits > 0)


@njit(cache=True, error_model="numpy")
def advance(
    previous: np.ndarray,
    reference: np.ndarray,
    last_event_s: np.ndarray,
    frame: np.ndarray,
    positive: np.ndarray,
    negative: np.ndarray,
    out_previous: np.ndarray,
    out_reference: np.ndarray,
    out_last_s: np.ndarray,
    t0_ns: int,
    t1_ns: int,
    refractory_ns: int,
    sigma: float,
    key: np.uint64,
    counts: np.ndarray,
    keys: np.ndarray,
    bits: int,
) -> int:
    """Find every threshold crossing between two frames; return how many events there are.

    Keys beyond the room in ``keys`` are counted but not kept.
    """
    out_previous[:] = frame
    out_reference[:] = reference
    out_last_s[:] = last_event_s
    dt = np.float32(t1_ns - t0_ns)
    shared = positive.size == 1
    counting = counts.shape[0] > 0
    found = 0
    for begin in range(0, frame.size, _TILE):
        stop = min(begin + _TILE, frame.size)
        # Most of a street stands still: a vectorised look tells whether any pixel of a tile can fire.
        ends, levels = frame[begin:stop], reference[begin:stop]
        if sigma > 0:
            quiet = False
        elif shared:
            quiet = not _reaches_shared(ends, levels, positive[0], negative[0])
        else:
            quiet = not _reaches(ends, levels, positive[begin:stop], negative[begin:stop])
        if quiet:
            continue
        for i in range(begin, stop):
            start, end, level = previous[i], frame[i], reference[i]
            on = end >= start
            change = positive[0 if shared else i] if on else -negative[0 if shared else i]
            if sigma > 0 and abs(start - end) > _TOLERANCE:
                drawn = abs(change) + np.float32(sigma * _normal(combine(key, np.uint64(i + 1))))
                change = max(_MIN_THRESHOLD, drawn) if on else -max(_MIN_THRESHOLD, drawn)
            crossing = level + change
            if (end >= crossing if on else end <= crossing) and abs(start - end) > _TOLERANCE:
                last_s = last_event_s[i]
                last_ns = np.int64(last_s * _NS)
                slope = end - start
                while (start < crossing <= end) if on else (end <= crossing < start):
                    t = t0_ns + np.int64(np.float32((crossing - start) * dt) / slope)
                    if t >= last_ns:
                        if last_s == 0 or t - last_ns >= refractory_ns:
                            if counting:
                                _count(i, on, counts)
                            elif found < keys.size:
                                keys[np.uint64(found)] = _sort_key(i, on, t - t0_ns, bits)
                            found += 1
                            last_s = t / _NS
                            last_ns = np.int64(last_s * _NS)
                        level = crossing
                    following = crossing + change
                    if following == crossing:  # a threshold below the values' resolution would never end
                        break
                    crossing = following
                out_last_s[i] = last_s
                out_reference[i] = level
    return found


@njit(cache=True, error_model="numpy")
def add_background(pixels, rate_hz, interval_ns, key, counts, keys, bits, found):
    """Add a Poisson process of spurious events over all pixels; return the new number of events."""
    if rate_hz <= 0:
        return found
    mean_gap_ns = _NS / (rate_hz * pixels)
    t_ns = 0.0
    counter = np.uint64(0)
    while True:
        t_ns -= mean_gap_ns * math.log(unit(combine(key, counter)))
        if t_ns >= interval_ns:
            return found
        drawn = combine(key, counter + np.uint64(1))
        index = np.int64(((drawn >> np.uint64(32)) * np.uint64(pixels)) >> np.uint64(32))
        on = (drawn & np.uint64(1)) == np.uint64(1)
        if counts.shape[0] > 0:
            _count(index, on, counts)
        elif found < keys.size:
            keys[found] = _sort_key(index, on, np.int64(t_ns), bits)
        found += 1
        counter += np.uint64(2)


@njit(cache=True, error_model="numpy")
def unpack(keys, bits, width, t0_ns, events):
    """Write sort keys out as event records."""
    mask = (np.uint64(1) << np.uint64(bits)) - np.uint64(1)
    for k in range(keys.size):
        key = keys[k]
        index = np.uint32((key & mask) >> np.uint64(1))
        row = index // np.uint32(width)
        event = events[k]
        event["x"] = index - row * np.uint32(width)
        event["y"] = row
        event["t"] = t0_ns + np.int64(key >> np.uint64(bits))
        event["pol"] = (key & np.uint64(1)) == np.uint64(1)
