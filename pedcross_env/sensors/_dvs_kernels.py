"""Our event camera: what a pixel does between two frames. All images are flat float32.

Levels that every pixel shares come as arrays of one value, else all of them as one value per pixel.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel
from pedcross_env.sensors._dvs_maths import TILE, add_count, exp_in_place, pack

__all__ = ["HOT", "LEAK", "SHOT", "SIGNAL", "advance", "follow", "queue"]

SIGNAL, LEAK, SHOT, HOT = 0, 1, 2, 3  # sources of an event, two bits of its sort key
_NS = 1e9
_ZERO, _ONE, _HALF = np.float32(0), np.float32(1), np.float32(0.5)
_SMALL = np.float32(0.05)  # below this the series is closer than the difference


@kernel
def follow(before, after, followed, angle, ln_half, out, work, ints):
    """Low-pass a movie whose values run straight between frames: the photoreceptor, exactly at any frame rate.

    A pole at f gives y1 = x1 - m (1 - e) + (y0 - x0) e with e = exp(-a), m = (x1 - x0) / a and
    a = ``angle`` l / (l + l_half) for light l, the geometric mean of the frames'; ``angle`` is 2 pi f dt of full light.

    Args:
        before: (N,) log luminance at the start; after: at the end; followed: the photoreceptor at the start.
        angle: float32. ln_half: ln of the luminance at which the pole is half as fast, float32.
        out: (N,) the photoreceptor at the end; work: (TILE,) float32; ints: (TILE,) int32.
    """
    for begin in range(0, before.size, TILE):
        n = min(TILE, before.size - begin)
        a, x0, x1 = work[:n], before[begin : begin + n], after[begin : begin + n]
        y0, y1 = followed[begin : begin + n], out[begin : begin + n]
        for i in range(n):
            a[i] = ln_half - _HALF * (x0[i] + x1[i])
        exp_in_place(a, ints)
        for i in range(n):
            a[i] = angle / (_ONE + a[i])
            y1[i] = -a[i]
        exp_in_place(y1, ints)
        for i in range(n):
            gone, turn = _ONE - y1[i], a[i]
            series = _ONE - turn * (_HALF - turn * (np.float32(1 / 6) - turn * np.float32(1 / 24)))
            share = series if turn < _SMALL else gone / turn
            y1[i] = x1[i] - (x1[i] - x0[i]) * share + (y0[i] - x0[i]) * y1[i]


@kernel
def _settle_shared(end, reference, on_step, off_step, leak, out_reference, fired):
    """Count the thresholds between each pixel and its reference, move that by them; whether there are any."""
    some = np.int32(0)
    for i in range(end.size):
        level = reference[i] - leak
        away = end[i] - level
        step = on_step if away >= _ZERO else off_step
        crossings = np.int32(away / step)
        out_reference[i] = level + np.float32(crossings) * step
        fired[i] = crossings
        some |= crossings
    return some != 0


@kernel
def _settle(end, reference, on_step, off_step, leak_per_s, dt_s, out_reference, fired):
    """Count the thresholds as above, each pixel with its own."""
    some = np.int32(0)
    for i in range(end.size):
        level = reference[i] - leak_per_s[i] * dt_s
        away = end[i] - level
        step = on_step[i] if away >= _ZERO else off_step[i]
        crossings = np.int32(away / step)
        out_reference[i] = level + np.float32(crossings) * step
        fired[i] = crossings
        some |= crossings
    return some != 0


@kernel
def _drifted_shared(drift, fired, leak, out_drift):
    """Add up what leaked since each pixel's last event."""
    for i in range(drift.size):
        out_drift[i] = drift[i] + leak if fired[i] == 0 else _ZERO


@kernel
def _drifted(drift, fired, leak_per_s, dt_s, out_drift):
    """Add up what leaked, as above, each pixel with its own rate."""
    for i in range(drift.size):
        out_drift[i] = drift[i] + leak_per_s[i] * dt_s if fired[i] == 0 else _ZERO


@kernel
def _held(last_event_s, t0_s, refractory_s, slow):
    """Mark pixels that are still in their refractory period; whether there are any."""
    some = np.uint8(0)
    for i in range(last_event_s.size):
        held = np.uint8(last_event_s[i] > _ZERO) & np.uint8(last_event_s[i] + refractory_s > t0_s)
        slow[i] |= held
        some |= held
    return some > 0


@kernel
def _tally(fired, counts, top):
    """Add crossings to counts (n, 2), which stop at ``top``."""
    for i in range(fired.size):
        on = np.int32(counts[i, 0]) + max(fired[i], np.int32(0))
        off = np.int32(counts[i, 1]) + max(-fired[i], np.int32(0))
        counts[i, 0] = min(on, top)
        counts[i, 1] = min(off, top)


@inlined
def _emit(found, t_ns, index, on, source, counts, keys, bits):
    if counts.shape[0] > 0:
        add_count(index, on, counts)
    elif found < keys.size:
        keys[np.uint64(found)] = pack(t_ns, index, on, source, bits)
    return found + 1


@kernel
def _fire(i, crossings, images, on_step, off_step, leak, drift, dt, counts, keys, bits, found):
    """Write the events of a pixel that only follows its light: each where the line meets the next threshold."""
    previous, frame, reference = images
    on = crossings > 0
    step = np.float64(on_step if on else -off_step)
    start = np.float64(previous[i]) - np.float64(reference[i])
    slope = np.float64(frame[i]) - np.float64(previous[i]) + np.float64(leak)
    pace = dt / slope if slope * step > 0 else 0.0
    source = LEAK if on and drift >= _HALF * on_step and leak > _ZERO else SIGNAL
    for k in range(1, abs(crossings) + 1):
        t = (k * step - start) * pace
        found = _emit(found, np.int64(min(max(t, 0.0), dt - 1.0)), i, on, source, counts, keys, bits)
        source = SIGNAL
    return found


@kernel
def _live(i, images, levels, drifts, last_event_s, outs, interval, noise, place, counts, keys, bits, found):
    """Follow one pixel through noise events and refractory periods.

    After an event it is held for the refractory period and starts anew from the level it then sees; a noise event also
    makes it forget what it had seen. Returns the number of events and the place of the next noise event.
    """
    previous, frame, reference = images
    on_steps, off_steps, leak_per_s = levels
    out_reference, out_last_s, out_drift = outs
    t0_ns, dt, refractory = interval
    noise_pixel, noise_t, noise_code = noise
    j = i if on_steps.size > 1 else 0
    on_step, off_step = np.float64(on_steps[j]), np.float64(off_steps[j])
    leak = np.float64(leak_per_s[j]) / _NS
    start = np.float64(previous[i])
    slope = (np.float64(frame[i]) - start) / dt
    t, level = 0.0, np.float64(reference[i])
    drift = np.float64(drifts[i]) if drifts.size > 0 else 0.0
    last_s, free = 0.0, -1.0
    if refractory > 0:
        last_s = last_event_s[i]
        if last_s > 0:
            free = last_s * _NS - t0_ns + refractory
    held = free > 0
    while True:
        if held:
            while place < noise_pixel.size and noise_pixel[place] == i and noise_t[place] < free:
                place += 1
            if free >= dt:
                t = dt
                level = start + slope * dt
                break
            t, level, held, drift = free, start + slope * free, False, 0.0
        away = start + slope * t - level
        rate = slope + leak
        due, on, source = np.inf, True, SIGNAL
        if rate > 0:
            due = max(t, t + (on_step - away) / rate)
        elif rate < 0:
            due, on = max(t, t + (off_step + away) / -rate), False
        if place < noise_pixel.size and noise_pixel[place] == i and noise_t[place] <= due:
            due = max(t, noise_t[place])
            on, source = (noise_code[place] & np.uint8(4)) != 0, np.int64(noise_code[place] & np.uint8(3))
            place += 1
            level = start + slope * due
        elif due > dt:
            break
        else:
            drift += leak * (due - t)
            if on and leak > 0 and drift >= 0.5 * on_step:
                source = LEAK
            level += (on_step if on else -off_step) - leak * (due - t)
        t, drift = due, 0.0
        at = np.int64(min(t, dt - 1.0))
        found = _emit(found, at, i, on, source, counts, keys, bits)
        if refractory > 0:
            last_s, held, free = (t0_ns + at) / _NS, True, t + refractory
    out_reference[i] = np.float32(level - leak * (dt - t))
    if drifts.size > 0:
        out_drift[i] = np.float32(drift + leak * (dt - t))
    if refractory > 0:
        out_last_s[i] = last_s
    return found, place


@kernel
def advance(images, levels, drifts, last_event_s, outs, interval, noise, counts, keys, bits, work):
    """Move every pixel to the next frame; return how many events there are.

    Args:
        images: Photoreceptor at the start and at the end, and the reference.
        levels: ON and OFF thresholds and the leak per second, all of one value or all of (N,).
        drifts: (N,) what leaked since each pixel's last event, or (0,) without leak.
        last_event_s: (N,) float64, 0 before the first; or (0,) without refractory period.
        outs: New reference, last events and drifts.
        interval: Start in ns, length in ns (float64), refractory period in ns (float64).
        noise: Pixels (int32), times from the start in ns (float64) and codes (source, 4 for ON) of events, sorted.
        counts: (N, 2) to be added to, or (0, 2) where ``keys`` are wanted; further keys than fit are counted, not kept.
        keys: uint64. bits: those below the time. work: (TILE,) each of int32, uint8 and int32.
    """
    _, frame, reference = images
    on_steps, off_steps, leak_per_s = levels
    out_reference, _, out_drift = outs
    t0_ns, dt, refractory = interval
    fired_work, slow_work, chosen = work
    shared, counting = on_steps.size == 1, counts.shape[0] > 0
    dt_s = np.float32(dt / _NS)
    top = np.int32(255 if counts.itemsize == 1 else 65535)
    t0_s, refractory_s = t0_ns / _NS, refractory / _NS
    found, place = 0, 0
    for begin in range(0, frame.size, TILE):
        n = min(TILE, frame.size - begin)
        stop = begin + n
        fired, slow = fired_work[:n], slow_work[:n]
        if shared:
            any_fired = _settle_shared(
                frame[begin:stop], reference[begin:stop], on_steps[0], off_steps[0], leak_per_s[0] * dt_s,
                out_reference[begin:stop], fired,
            )  # fmt: skip
        else:
            any_fired = _settle(
                frame[begin:stop], reference[begin:stop], on_steps[begin:stop], off_steps[begin:stop],
                leak_per_s[begin:stop], dt_s, out_reference[begin:stop], fired,
            )  # fmt: skip
        if drifts.size > 0 and shared:
            _drifted_shared(drifts[begin:stop], fired, leak_per_s[0] * dt_s, out_drift[begin:stop])
        elif drifts.size > 0:
            _drifted(drifts[begin:stop], fired, leak_per_s[begin:stop], dt_s, out_drift[begin:stop])
        noisy = place < noise[0].size and noise[0][place] < stop
        any_slow = noisy
        if noisy or refractory > 0:
            for i in range(n):
                slow[i] = np.uint8(fired[i] != 0) & np.uint8(refractory > 0)
            later = place
            while later < noise[0].size and noise[0][later] < stop:
                slow[noise[0][later] - begin] = 1
                later += 1
            if refractory > 0:
                any_slow |= _held(last_event_s[begin:stop], t0_s, refractory_s, slow) or any_fired
        if any_slow:
            for i in range(n):
                if slow[i] != 0:
                    fired[i] = 0
                    found, place = _live(
                        begin + i, images, levels, drifts, last_event_s, outs, interval, noise, place,
                        counts, keys, bits, found,
                    )  # fmt: skip
        if not any_fired:
            continue
        if counting:
            for i in range(n):
                found += abs(fired[i])
            _tally(fired, counts[begin:stop], top)
            continue
        hits = 0
        for i in range(n):
            chosen[hits] = i
            hits += np.int64(fired[i] != 0)
        for k in range(hits):
            i = begin + chosen[k]
            j = 0 if shared else i
            leak = leak_per_s[j] * dt_s
            drift = drifts[i] + leak if drifts.size > 0 else _ZERO
            found = _fire(
                i,
                fired[chosen[k]],
                images,
                on_steps[j],
                off_steps[j],
                leak,
                drift,
                dt,
                counts,
                keys,
                bits,
                found,
            )
    return found


@kernel
def queue(keys, bits, gap_ns, free_ns, longest_ns):
    """Send sorted events over a bus, one in ``gap_ns``; what would wait longer than ``longest_ns`` is lost.

    Keys are changed in place to the times of their sending. Returns how many are left and when the bus is free.
    """
    mask = (np.uint64(1) << np.uint64(bits)) - np.uint64(1)
    kept = 0
    for k in range(keys.size):
        t = np.float64(keys[k] >> np.uint64(bits))
        sent = max(t, free_ns)
        if sent - t > longest_ns:
            continue
        free_ns = sent + gap_ns
        keys[kept] = (np.uint64(np.int64(sent)) << np.uint64(bits)) | (keys[k] & mask)
        kept += 1
    return kept, free_ns
