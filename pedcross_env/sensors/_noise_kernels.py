"""Noise events without a draw per pixel: a Poisson process over (pixel, time) in row-major order, thinned by the light.

Only as many numbers are drawn as there are candidates, and they come sorted by pixel and time.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import exact_entry, exact_inlined
from pedcross_env.hashing import combine, unit
from pedcross_env.sensors._fire_kernels import HOT, SHOT

__all__ = ["MOST_BY_THRESHOLD", "draw_noise"]

MOST_BY_THRESHOLD = 2.0  # low thresholds make a pixel noisier, at most so much


@exact_inlined
def _insert(pixels, times, codes, found, first, t, index, on, source):
    """Append an event of pixel ``index``, whose events begin at ``first``, in order of time."""
    if found < pixels.size:
        k = found
        while k > first and times[k - 1] > t:
            pixels[k], times[k], codes[k] = pixels[k - 1], times[k - 1], codes[k - 1]
            k -= 1
        pixels[k], times[k], codes[k] = index, t, np.uint8(source) | (np.uint8(on) << np.uint8(2))


@exact_entry
def draw_noise(log_frame, levels, nominal, shot, hot, dt_ns, key, pixels, times, codes):
    """Draw shot noise and the events of hot pixels in an interval; return how many (more than fit are not kept).

    Args:
        log_frame: (N,) log luminance.
        levels: ON and OFF thresholds, (1,) or (N,). nominal: the two of the configuration.
        shot: Rate in the dark per pixel and second, both polarities together, and ln of the luminance that halves it.
        hot: Hot pixels (int32, ascending) and their rates in Hz. dt_ns: float64.
        pixels, times, codes: Written: int32, float64 from the start in ns, uint8.
    """
    shot_hz, ln_half = shot
    hot_pixels, hot_hz = hot
    shared = levels[0].size == 1
    bound = 1.0 if shared else MOST_BY_THRESHOLD
    expected = shot_hz * bound * dt_ns * 1e-9  # candidates per pixel
    found, drawn, next_hot = 0, np.uint64(0), 0
    position, end = 0.0, np.float64(log_frame.size)
    first, before = 0, -1
    while True:
        position = position - math.log(unit(combine(key, drawn))) / expected if expected > 0 else end
        index = np.int64(min(position, end))
        while next_hot < hot_pixels.size and hot_pixels[next_hot] <= index:
            spot = np.int64(hot_pixels[next_hot])
            if spot != before:
                first, before = found, spot
            spot_key = combine(key, np.uint64(0xF000000000000000) + np.uint64(spot))
            gap_ns = 1e9 / hot_hz[next_hot]
            t, n = 0.0, np.uint64(0)
            while True:
                t -= gap_ns * math.log(unit(combine(spot_key, n)))
                if t >= dt_ns:
                    break
                on = (combine(spot_key, n + np.uint64(1)) & np.uint64(1)) != 0
                _insert(pixels, times, codes, found, first, t, spot, on, HOT)
                found += 1
                n += np.uint64(2)
            next_hot += 1
        if position >= end:
            return found
        chance = combine(key, drawn + np.uint64(1))
        on = (chance & np.uint64(1)) != 0
        share = 1.0 / (1.0 + math.exp(np.float64(log_frame[index]) - ln_half))
        if not shared:
            share *= min(
                MOST_BY_THRESHOLD, nominal[0] / levels[0][index] if on else nominal[1] / levels[1][index]
            )
        if unit(chance) * bound <= share:
            if index != before:
                first, before = found, index
            _insert(pixels, times, codes, found, first, (position - index) * dt_ns, index, on, SHOT)
            found += 1
        drawn += np.uint64(2)
