"""From light to counts of events in one pass over the picture, in place.

For pixels that have thresholds and noise and nothing else.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import exact_entry, exact_kernel
from pedcross_env.camera.kernels.layers import lay
from pedcross_env.sensors._dvs_kernels import live
from pedcross_env.sensors._dvs_maths import log_tile
from pedcross_env.sensors._noise_kernels import draw_noise

__all__ = ["TILE", "count_events", "log_picture"]

TILE = 512

_ZERO = np.float32(0)
_NONE, _BITS, _MOST = np.int32(0), np.int32(8), np.int32(255)


@exact_kernel
def _count(end, reference, on_step, off_step, pairs):
    """Move each pixel's reference by the thresholds that it crossed, and count those.

    A pair has ON in its lower byte and OFF in the upper one, each up to 255.
    """
    for i in range(end.size):
        away, on, off = end[i] - reference[i], on_step[i], off_step[i]
        step = on if away >= _ZERO else off
        crossings = np.int32(away / step)
        reference[i] += np.float32(crossings) * step
        pair = np.int32(pairs[i])
        ons = min(np.int32((pair & _MOST) + max(crossings, _NONE)), _MOST)
        offs = min(np.int32(np.int32(pair >> _BITS) - min(crossings, _NONE)), _MOST)
        pairs[i] = np.uint16(ons | np.int32(offs << _BITS))


@exact_entry
def count_events(layers, floor, log_frame, reference, levels, interval, source, room, counts, pairs, work):
    """Move every pixel to the next picture; return the number of noise events; if there is no room for them do nothing.

    Args:
        layers: The picture, see kernels.layers.
        floor: cd/m2, added to it.
        log_frame: (N,) log luminance: that of the picture before becomes that of this one.
        reference: (N,) changed in place.
        levels: ON and OFF thresholds, and no leak: float32, all of one value or all of (N,).
        interval: Start, length and refractory period in ns (float64): the last is 0.
        source: Of noise, see draw_noise: nominal thresholds, shot noise, hot pixels, key.
        room: Written: pixels (int32), times from the start in ns (float64) and codes (uint8) of noise events.
        counts: (N, 2) uint8 to be added to; pairs: (N,) uint16, the same memory.
        work: (7, TILE) and, of 64-bit integers, (TILE,).
    """
    nominal, shot, hot, key = source
    fired = draw_noise(log_frame, (levels[0], levels[1]), nominal, shot, hot, interval[1], key, *room)
    if fired > room[0].size:
        return fired
    noise = room[0][:fired], room[1][:fired], room[2][:fired]
    planes, noisy = work
    shared = levels[0].size == 1
    if shared:
        for i in range(TILE):
            planes[0, i], planes[1, i] = levels[0][0], levels[1][0]
    nothing_kept = noise[1][:0]
    no_keys = noisy[:0].view(np.uint64)
    place = 0
    for begin in range(0, log_frame.size, TILE):
        n = min(TILE, log_frame.size - begin)
        stop = begin + n
        end, level = log_frame[begin:stop], reference[begin:stop]
        light, logs, before, set_aside = planes[2, :n], (planes[3], planes[4]), planes[5, :n], planes[6]
        on_step, off_step = planes[0, :n], planes[1, :n]
        if not shared:
            on_step, off_step = levels[0][begin:stop], levels[1][begin:stop]
        lay(layers, begin, light)
        fires = place < noise[0].size and noise[0][place] < stop
        if fires:
            for i in range(n):
                before[i] = end[i]
        log_tile(light, floor, end, logs)
        held = 0
        while place < noise[0].size and noise[0][place] < stop:
            # followed by itself, and at its reference for the others' sake
            i = noise[0][place]
            pixel = before[i - begin], log_frame[i], reference[i]
            _, place = live(
                i, pixel, levels, reference[:0], nothing_kept, (reference, nothing_kept, reference[:0]), interval,
                noise, place, counts, no_keys, 0, 0,
            )  # fmt: skip
            noisy[held], set_aside[held] = i, reference[i]
            reference[i] = log_frame[i]
            held += 1
        _count(end, level, on_step, off_step, pairs[begin:stop])
        for h in range(held):
            reference[noisy[h]] = set_aside[h]
    return fired


@exact_entry
def log_picture(layers, floor, log_frame, work):
    """Fill (N,) with ln of a picture and a floor; ``work`` is (3, TILE) float32."""
    for begin in range(0, log_frame.size, TILE):
        stop = min(log_frame.size, begin + TILE)
        light = work[0, : stop - begin]
        lay(layers, begin, light)
        log_tile(light, floor, log_frame[begin:stop], (work[1], work[2]))
