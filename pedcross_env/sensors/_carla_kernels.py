"""CARLA's rule, bit for bit: float32 throughout, thresholds added one by one."""

from __future__ import annotations

import numpy as np
from numba import njit

from pedcross_env.hashing import combine
from pedcross_env.sensors._dvs_maths import MIN_THRESHOLD, TILE, add_count, normal, pack

__all__ = ["advance"]

_TOLERANCE = np.float32(1e-6)  # smaller changes are none
_NS = 1e9


@njit(cache=True, error_model="numpy")
def _reaching(frame, reference, positive, negative, hits):
    """Mark the pixels a threshold or more away from their reference; whether there are any."""
    some = np.uint8(0)
    for i in range(frame.size):
        hit = np.uint8(frame[i] >= reference[i] + positive) | np.uint8(frame[i] <= reference[i] - negative)
        hits[i] = hit
        some |= hit
    return some > 0


@njit(cache=True, error_model="numpy")
def advance(
    previous, reference, last_event_s, frame, positive, negative, out_reference, out_last_s, interval, refractory_ns,
    sigma, key, counts, keys, bits,
):  # fmt: skip
    """Find every threshold crossing between two frames; return how many events there are.

    All images are flat. Keys beyond the room in ``keys`` are counted but not kept. ``interval`` is (t0_ns, t1_ns).
    With ``sigma`` thresholds are drawn once per pixel and frame: small draws make pixels stick, as CARLA's do.
    """
    out_reference[:] = reference
    out_last_s[:] = last_event_s
    t0_ns, t1_ns = interval
    dt = np.float32(t1_ns - t0_ns)
    counting = counts.shape[0] > 0
    hits, chosen = np.empty(TILE, np.uint8), np.empty(TILE, np.int32)
    found = 0
    for begin in range(0, frame.size, TILE):
        stop = min(begin + TILE, frame.size)
        # Most of a street stands still: a vectorised look tells which pixels of a tile can fire.
        if sigma > 0:
            hits[:] = 1
        elif not _reaching(frame[begin:stop], reference[begin:stop], positive, negative, hits):
            continue
        hit_count = 0
        for i in range(stop - begin):
            chosen[hit_count] = begin + i
            hit_count += np.int64(hits[i])
        for k in range(hit_count):
            i = chosen[k]
            start, end, level = previous[i], frame[i], reference[i]
            if not abs(start - end) > _TOLERANCE:
                continue
            on = end >= start
            change = positive if on else negative
            if sigma > 0:
                drawn = change + np.float32(sigma * normal(combine(key, np.uint64(i + 1))))
                change = max(MIN_THRESHOLD, drawn)
            change = change if on else -change
            crossing = level + change
            last_s = last_event_s[i]
            last_ns = np.int64(last_s * _NS)
            slope = end - start
            while (start < crossing <= end) if on else (end <= crossing < start):
                t = t0_ns + np.int64(np.float32((crossing - start) * dt) / slope)
                if t >= last_ns:
                    if last_s == 0 or t - last_ns >= refractory_ns:
                        if counting:
                            add_count(i, on, counts)
                        elif found < keys.size:
                            keys[np.uint64(found)] = pack(t - t0_ns, i, on, 0, bits)
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
