"""v2e's rule: whole thresholds per frame, spread evenly over its time.

Source: Hu, Liu and Delbruck, CVPRW 2021, and github.com/SensorsINI/v2e at cac6384.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import exact_entry, exact_kernel
from pedcross_env.hashing import combine, unit
from pedcross_env.sensors._dvs_maths import add_count, pack
from pedcross_env.sensors._fire_kernels import LEAK, SHOT, SIGNAL

__all__ = ["advance", "follow", "intensity", "mark_shots"]

_KNEE = 20.0  # grey level where v2e's mapping turns from linear to logarithmic
_SLOPE = math.log(_KNEE) / _KNEE
_NS = 1e9


@exact_entry
def intensity(log_frame, out):
    """v2e's intensity (DN + 20) / 275 from its lin-log values."""
    for i in range(log_frame.size):
        level = np.float64(log_frame[i])
        grey = level / _SLOPE if level <= _KNEE * _SLOPE else math.exp(level)
        out[i] = np.float32((min(255.0, max(0.0, grey)) + 20.0) / 275.0)


@exact_entry
def follow(log_frame, followed, light, angle, out):
    """Low-pass by eps = min(1, light angle), angle = 2 pi f dt."""
    for i in range(log_frame.size):
        eps = min(np.float32(1), light[i] * angle)
        out[i] = (np.float32(1) - eps) * followed[i] + eps * log_frame[i]


@exact_entry
def mark_shots(light, on_steps, off_steps, nominal, expected, key, marks):
    """Mark pixels with a shot noise event: 1 OFF, 2 ON, each with p = expected (1 - .75 light) nominal / threshold.

    Chances are skipped over by geometric gaps at a bound of p, so there are as many draws as candidates.
    """
    least = np.inf
    for i in range(on_steps.size):
        least = min(least, np.float64(on_steps[i]) / nominal[0], np.float64(off_steps[i]) / nominal[1])
    bound = min(1.0, 2.0 * expected / least)
    marks[:] = 0
    position, drawn = -1.0, np.uint64(0)
    last = on_steps.size - 1
    while bound > 0:
        gap = math.log(unit(combine(key, drawn))) / math.log(1.0 - bound) if bound < 1.0 else 0.0
        position += 1.0 + math.floor(gap)
        if position >= light.size:
            return
        i = np.int64(position)
        weakened = expected * (1.0 - 0.75 * np.float64(light[i]))
        on_chance = weakened * nominal[0] / on_steps[min(i, last)]
        off_chance = weakened * nominal[1] / off_steps[min(i, last)]
        drawn_share = unit(combine(key, drawn + np.uint64(1))) * bound
        # v2e takes both polarities from one number: ON from its upper end, OFF from its lower.
        if drawn_share <= on_chance:
            marks[i] = 2
        elif drawn_share <= on_chance + off_chance:
            marks[i] = 1
        drawn += np.uint64(2)


@exact_kernel
def _crossings(away, on_step, off_step):
    return np.int64(np.float64(away) / (np.float64(on_step) if away >= 0 else np.float64(off_step)))


@exact_entry
def advance(frame, reference, levels, drifts, last_event_s, outs, interval, marks, counts, keys, bits):
    """Count thresholds from reference to frame, give them times, add shot noise; return how many events there are."""
    on_steps, off_steps, leak_per_s = levels
    out_reference, out_last_s, out_drift = outs
    t0_ns, dt, refractory = interval
    dt_s, last = dt / _NS, on_steps.size - 1
    most = np.int64(1)
    for i in range(frame.size):
        j = min(i, last)
        level = reference[i] - np.float32(np.float64(leak_per_s[j]) * dt_s)
        out_reference[i] = level
        most = max(most, abs(_crossings(frame[i] - level, on_steps[j], off_steps[j])))
    pace = dt / most
    holding = refractory > pace
    counting, found = counts.shape[0] > 0, 0
    for i in range(frame.size):
        j = min(i, last)
        level = out_reference[i]
        crossings = _crossings(frame[i] - level, on_steps[j], off_steps[j])
        on, kept = crossings > 0, np.int64(0)
        drift = drifts[i] + leak_per_s[j] * np.float32(dt_s) if drifts.size > 0 else np.float32(0)
        source = LEAK if on and drift > 0 and drift >= np.float32(0.5) * on_steps[j] else SIGNAL
        last_s = last_event_s[i] if holding else 0.0
        for k in range(1, abs(crossings) + 1):
            t = np.int64(k * pace)
            if holding and not (t0_ns + t) / _NS - last_s > refractory / _NS:
                continue
            kept += 1
            last_s = (t0_ns + t) / _NS
            if counting:
                add_count(i, on, counts)
            elif found < keys.size:
                keys[np.uint64(found)] = pack(min(t, np.int64(dt) - 1), i, on, source, bits)
            found, source = found + 1, SIGNAL
        if last_event_s.size > 0:
            out_last_s[i] = last_s if holding else last_event_s[i]
        level += np.float32(kept) * (on_steps[j] if on else -off_steps[j])
        if marks.size > 0 and marks[i] > 0:
            level = frame[i]  # a noise event resets the pixel
            kept += 1
            shot_on = marks[i] == 2
            if counting:
                add_count(i, shot_on, counts)
            elif found < keys.size:
                keys[np.uint64(found)] = pack(np.int64(dt) - 1, i, shot_on, SHOT, bits)
            found += 1
        out_reference[i] = level
        if drifts.size > 0:
            out_drift[i] = drift if kept == 0 else np.float32(0)
    return found
