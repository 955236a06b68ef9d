"""Our event camera: what a pixel does between two frames. All images are flat float32.

Levels that every pixel shares come as arrays of one value, else all of them as one value per pixel.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import exact_entry, exact_inlined, exact_kernel
from pedcross_env.sensors._dvs_maths import TILE, add_count, exp_in_place, pack
from pedcross_env.sensors._fire_kernels import LEAK, SIGNAL, aim, fire, first_source

__all__ = ["advance", "follow", "live", "queue"]

_NS = 1e9
_ZERO, _ONE, _HALF = np.float32(0), np.float32(1), np.float32(0.5)
_SMALL = np.float32(0.05)  # below this the series is closer than the difference


@exact_entry
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


@exact_kernel
def _settle(end, reference, on_step, off_step, leak_per_s, dt_s, out_reference, fired):
    """Count the thresholds between each pixel and its reference, move that by them; whether there are any."""
    some = np.int32(0)
    for i in range(end.size):
        level, on, off = reference[i] - leak_per_s[i] * dt_s, on_step[i], off_step[i]  # loaded, not gathered
        away = end[i] - level
        step = on if away >= _ZERO else off
        crossings = np.int32(away / step)
        out_reference[i] = level + np.float32(crossings) * step
        fired[i] = crossings
        some |= crossings
    return some != 0


@exact_kernel
def _drifted(drift, fired, leak_per_s, dt_s, out_drift):
    """Add up what leaked since each pixel's last event."""
    for i in range(drift.size):
        out_drift[i] = drift[i] + leak_per_s[i] * dt_s if fired[i] == 0 else _ZERO


@exact_kernel
def _held(last_event_s, t0_s, refractory_s, slow):
    """Mark pixels that are still in their refractory period; whether there are any."""
    some = np.uint8(0)
    for i in range(last_event_s.size):
        held = np.uint8(last_event_s[i] > _ZERO) & np.uint8(last_event_s[i] + refractory_s > t0_s)
        slow[i] |= held
        some |= held
    return some > 0


@exact_kernel
def _tally(chosen, fired, counts, top):
    """Add the crossings of chosen pixels to counts (n, 2), which stop at ``top``; return how many there are."""
    found = 0
    for h in range(chosen.size):
        k = np.uint64(chosen[h])
        number, channel = abs(fired[k]), np.uint64(fired[k] < 0)
        counts[k, channel] = min(np.int32(counts[k, channel]) + number, top)
        found += number
    return found


@exact_inlined
def _emit(found, t_ns, index, on, source, counts, keys, bits):
    if counts.shape[0] > 0:
        add_count(index, on, counts)
    elif found < keys.size:
        keys[np.uint64(found)] = pack(t_ns, index, on, source, bits)
    return found + 1


@exact_kernel
def _held_after(i, first, gap, dt, start, change, leak, refractory_at, outs, source, on, found, sink):
    """Write the events of a pixel that fires, is held, starts anew from what it then sees, fires again, and so on.

    The light runs straight, so that it takes ``gap`` from each release to the next event.
    """
    t0_ns, refractory = refractory_at
    out_reference, out_last_s, out_drift = outs
    counts, keys, bits = sink
    t, at = first, np.int64(0)
    while True:
        at = np.int64(min(max(t, 0.0), dt - 1.0))
        found = _emit(found, at, i, on, source, counts, keys, bits)
        source = SIGNAL
        released = t + refractory
        if gap <= 0.0 or released + gap > dt:
            break
        t = released + gap
    left = max(0.0, dt - released)
    out_last_s[i] = (t0_ns + at) / _NS
    out_reference[i] = np.float32(start + change * (1.0 - left / dt) - leak * (left / dt))
    if out_drift.size > 0:
        out_drift[i] = np.float32(leak * (left / dt))
    return found


@exact_kernel
def live(i, pixel, levels, drifts, last_event_s, outs, interval, noise, place, counts, keys, bits, found):
    """Follow one pixel through noise events and refractory periods.

    ``pixel`` is its photoreceptor at both frames and its reference at the first.
    After an event it is held for the refractory period and starts anew from the level it then sees; a noise event also
    makes it forget what it had seen. Returns the number of events and the place of the next noise event.
    """
    start, end, level = pixel
    on_steps, off_steps, leak_per_s = levels
    out_reference, out_last_s, out_drift = outs
    t0_ns, dt, refractory = interval
    noise_pixel, noise_t, noise_code = noise
    j = i if on_steps.size > 1 else 0
    on_step, off_step = np.float64(on_steps[j]), np.float64(off_steps[j])
    leak = np.float64(leak_per_s[j]) / _NS
    start, level, t = np.float64(start), np.float64(level), 0.0
    slope = (np.float64(end) - start) / dt
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


@exact_kernel
def _mark_slow(begin, n, place, noise_pixel, last_event_s, t0_s, refractory_s, slow):
    """Mark the pixels of a tile to be followed: those with noise, and those still held; whether there are any."""
    for i in range(n):
        slow[i] = 0
    any_slow = False
    while place < noise_pixel.size and noise_pixel[place] < begin + n:
        slow[noise_pixel[place] - begin] = 1
        place += 1
        any_slow = True
    if refractory_s > 0:
        any_slow |= _held(last_event_s[begin : begin + n], t0_s, refractory_s, slow)
    return any_slow


@exact_entry
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
        counts: (N, 2) to be added to, or (0, 2) where ``keys`` are wanted.
        keys: uint64; more than fit, with LANES to spare, are counted, not kept. bits: those below the time.
        work: (TILE,) of int32, uint8 and int32; (2, TILE) float64; (3, TILE) float32; then fire's.
    """
    previous, frame, reference = images
    out_reference, _, out_drift = outs
    t0_ns, dt, refractory = interval
    fired_work, slow, chosen, times, steps, line = work
    shared, counting = levels[0].size == 1, counts.shape[0] > 0
    if shared:
        for i in range(TILE):
            steps[0, i], steps[1, i], steps[2, i] = levels[0][0], levels[1][0], levels[2][0]
    dt_s = np.float32(dt / _NS)
    top = np.int32(255 if counts.itemsize == 1 else 65535)
    found, place = 0, 0
    for begin in range(0, frame.size, TILE):
        n = min(TILE, frame.size - begin)
        stop = begin + n
        fired, first, gap = fired_work[:n], times[0, :n], times[1, :n]
        if shared:
            on_step, off_step, leak = steps[0, :n], steps[1, :n], steps[2, :n]
        else:
            on_step, off_step, leak = levels[0][begin:stop], levels[1][begin:stop], levels[2][begin:stop]
        any_fired = _settle(
            frame[begin:stop],
            reference[begin:stop],
            on_step,
            off_step,
            leak,
            dt_s,
            out_reference[begin:stop],
            fired,
        )
        if drifts.size > 0:
            _drifted(drifts[begin:stop], fired, leak, dt_s, out_drift[begin:stop])
        if (refractory > 0 or (place < noise[0].size and noise[0][place] < stop)) and _mark_slow(
            begin, n, place, noise[0], last_event_s, t0_ns / _NS, refractory / _NS, slow
        ):
            for i in range(n):
                if slow[i] != 0:
                    fired[i] = 0
                    pixel = previous[begin + i], frame[begin + i], reference[begin + i]
                    found, place = live(
                        begin + i, pixel, levels, drifts, last_event_s, outs, interval, noise, place,
                        counts, keys, bits, found,
                    )  # fmt: skip
        if not any_fired:
            continue
        hits = np.uint64(0)
        for i in range(n):
            chosen[hits] = i
            hits += np.uint64(fired[i] != 0)
        if counting and refractory == 0:
            found += _tally(chosen[:hits], fired, counts[begin:stop], top)
            continue
        aim(
            previous[begin:stop],
            frame[begin:stop],
            reference[begin:stop],
            on_step,
            off_step,
            leak,
            fired,
            dt,
            first,
            gap,
        )
        if refractory == 0:
            marks = (leak, dt_s, on_step, drifts[begin:stop] if drifts.size > 0 else drifts)
            found = fire(begin, chosen[:hits], fired, first, gap, marks, dt, keys, bits, found, line)
            continue
        for h in range(hits):
            k = chosen[h]
            i, on = begin + k, fired[k] > 0
            leaked = leak[k] * dt_s
            source = first_source(on, leaked, drifts[i] if leaked > _ZERO else _ZERO, on_step[k])
            start = np.float64(previous[i])
            found = _held_after(
                i, first[k], gap[k], dt, start, np.float64(frame[i]) - start, np.float64(leaked),
                (t0_ns, refractory), outs, source, on, found, (counts, keys, bits),
            )  # fmt: skip
    return found


@exact_entry
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
