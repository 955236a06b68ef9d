"""Our event camera's pixels that no noise or refractory period disturbs: a tile's events, many pixels at a time."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import LANES, exact_inlined, exact_kernel

__all__ = ["HOT", "LADDER", "LANES", "LEAK", "SHOT", "SIGNAL", "aim", "fire", "first_source"]

SIGNAL, LEAK, SHOT, HOT = 0, 1, 2, 3  # sources of an event, two bits of its sort key
LADDER = 32  # events up to this one of a pixel are written side by side with other pixels'
_NS = 1e9
_ZERO, _HALF = np.float32(0), np.float32(0.5)


@exact_kernel
def aim(previous, frame, reference, on_step, off_step, leak_per_s, fired, dt, first, gap):
    """When each pixel meets its next threshold, in ns from the start, and how long it takes to the ones after it."""
    dt_s = np.float32(dt / _NS)
    for i in range(frame.size):
        start = np.float64(previous[i])
        on, off = on_step[i], off_step[i]
        step = np.float64(on if fired[i] > 0 else -off)
        slope = np.float64(frame[i]) - start + np.float64(leak_per_s[i] * dt_s)
        pace = dt / slope
        pace = pace if slope * step > 0.0 else 0.0
        gap[i] = step * pace
        first[i] = (step - (start - np.float64(reference[i]))) * pace


@exact_inlined
def first_source(on, leaked, drift, on_step):
    """What a pixel's first event in an interval is put down to."""
    return LEAK if on and leaked > _ZERO and drift + leaked >= _HALF * on_step else SIGNAL


@exact_kernel
def _line_up(begin, chosen, fired, first, gap, line):
    """Line up a tile's chosen pixels, those with the most events first; return the largest number of events.

    ``more[j]`` becomes how many pixels have more than j events; LADDER or more are not told apart.
    """
    rungs, places, lined, lows = line
    more, ends, times, gaps = rungs[0], rungs[1], lined[0], lined[1]
    most = np.int32(0)
    for i in range(fired.size):
        most = max(most, abs(fired[i]))
    top = min(most, np.int32(LADDER))
    for j in range(top + 1):
        number = np.int32(0)
        for i in range(fired.size):
            number += np.int32(abs(fired[i]) > np.int32(j))
        more[j] = number
        ends[j] = number
    ends[top] = 0
    for h in range(chosen.size):
        k = np.uint64(chosen[h])
        rung = np.uint64(min(abs(fired[k]), np.int32(LADDER)))
        if most == 1:  # nothing to line up
            at = np.int32(h)
        else:
            at = ends[rung]
            ends[rung] = at + np.int32(1)
        places[h] = at
        times[np.uint64(at)], gaps[np.uint64(at)] = first[k], gap[k]
        lows[np.uint64(at)] = ((np.uint64(begin) + k) << np.uint64(3)) | (
            np.uint64(fired[k] > 0) << np.uint64(2)
        )
    return most


@exact_kernel
def fire(begin, chosen, fired, first, gap, marks, dt, keys, bits, found, line):
    """Write the events of a tile's chosen pixels: the first of each, the second of each that has one, and so on.

    LANES are written at a time: what is too much, the next overwrites.

    Args:
        begin: The tile's first pixel. chosen: Those of it that fire. fired: Each pixel's events, negative for OFF.
        first: When each pixel fires for the first time, in ns. gap: How long it takes to the next time.
        marks: Leak per second, the interval in s, ON thresholds, and what had leaked (or (0,)).
        dt: The interval in ns. keys, bits, found: As in ``advance``, and how many there are before.
        line: Work: (2, LADDER + 1) int32, (TILE,) int32, (2, TILE) float64 and (TILE,) uint64.
    """
    leak, dt_s, on_step, drifts = marks
    rungs, places, lined, lows = line
    more, times, gaps = rungs[0], lined[0], lined[1]
    total = 0
    for i in range(fired.size):
        total += abs(fired[i])
    if found + total + LANES > keys.size:  # counted, not kept
        return found + total
    most = _line_up(begin, chosen, fired, first, gap, line)
    end, bits, at = dt - 1.0, np.uint64(bits), np.uint64(found)
    for j in range(min(most, LADDER)):
        number = np.uint64(more[j])
        for h in range((number + np.uint64(LANES - 1)) & ~np.uint64(LANES - 1)):
            t = times[h]
            keys[at + h] = (np.uint64(np.int64(min(max(t, 0.0), end))) << bits) | lows[h]
            times[h] = t + gaps[h]
        at += number
    for h in range(more[LADDER - 1] if most > LADDER else 0):
        t, low = times[h], lows[h]
        for _ in range(LADDER, abs(fired[(low >> np.uint64(3)) - np.uint64(begin)])):
            keys[at] = (np.uint64(np.int64(min(max(t, 0.0), end))) << bits) | low
            t += gaps[h]
            at += np.uint64(1)
    if drifts.size > 0:
        for h in range(chosen.size):
            k = chosen[h]
            source = first_source(fired[k] > 0, leak[k] * dt_s, drifts[k], on_step[k])
            keys[np.uint64(found + places[h])] |= np.uint64(source)
    return found + total
