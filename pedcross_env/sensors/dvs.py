"""The event camera: light in, events out, the state an argument.

    config = dvs_preset("davis346")
    state = initial_state(log_luminance(first, config.log_floor_cd_m2), 0, config, seed=1)
    state, events = step(state, log_luminance(second, config.log_floor_cd_m2), 1_000_000, config)

8-bit frames come by ``log_image(frame, config)``. Three models, see DvsConfig; ours, between two frames:

1. The photoreceptor follows ln(light), which runs straight, through a pole that light makes faster.
2. The reference leaks downwards.
3. Wherever the photoreceptor is a threshold away from the reference, there is an event, at that very time, and the
   reference moves by the threshold; after a refractory period it starts anew from what is seen then.
4. Shot noise and hot pixels fire as Poisson processes; such an event makes the pixel forget what it had seen.
5. A bus sends so many events a second; the others wait, and are lost where too many do.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pedcross_env.contracts import EVENT_DTYPE, EventCause
from pedcross_env.errors import require
from pedcross_env.hashing import child_key
from pedcross_env.sensors import _carla_kernels as carla
from pedcross_env.sensors import _dvs_kernels as ours
from pedcross_env.sensors import _dvs_maths as maths
from pedcross_env.sensors import _noise_kernels as noise_kernels
from pedcross_env.sensors import _v2e_kernels as v2e
from pedcross_env.sensors._event_order import array_of, in_order, workspace, write, write_in_order
from pedcross_env.sensors._fire_kernels import LADDER, LANES
from pedcross_env.sensors.dvs_config import DvsConfig
from pedcross_env.sensors.dvs_state import FRAME_STREAMS, NO_LABELS, DvsState, check_frame, initial_state
from pedcross_env.sensors.intensity import log_luminance

__all__ = [
    "DvsState",
    "add_counts",
    "initial_state",
    "log_luminance",
    "step",
    "step_counts",
    "step_labelled",
]

_NO_KEYS = np.empty(0, np.uint64)
_NO_COUNTS = np.empty((0, 2), np.uint8)
_EVENTS_PER_PIXEL = 6  # room of the first try; where it is short, the frame is run again with enough
_SOURCE_CAUSE = np.array(
    [EventCause.SIGNAL, EventCause.LEAK, EventCause.SHOT_NOISE, EventCause.HOT_PIXEL], np.int32
)


def _index_bits(pixels: int) -> int:
    """Bits that hold a pixel's index, the polarity and the source in an event's sort key."""
    return (pixels - 1).bit_length() + 3


def _run(
    state: DvsState, log_frame: np.ndarray, time_ns: int, config: DvsConfig, counts: np.ndarray
) -> tuple[DvsState, np.ndarray]:
    """Advance by one frame; add to ``counts`` if it has rows, else return the events' sort keys, in any order.

    The keys last until this thread's next frame.
    """
    log_frame = check_frame(log_frame, state.log_frame.shape)
    require(time_ns > state.time_ns, "time_ns", time_ns, f"later than the previous frame's {state.time_ns}")
    longest = 1 << (62 - _index_bits(log_frame.size))
    require(time_ns - state.time_ns < longest, "time_ns", time_ns,
            f"less than {longest} ns after the previous frame's {state.time_ns}")  # fmt: skip
    run = {"pedcross": _run_ours, "carla": _run_carla, "v2e": _run_v2e}[config.model]
    keys = _NO_KEYS if len(counts) else workspace("keys", _EVENTS_PER_PIXEL * log_frame.size, np.uint64)
    advanced, found = run(state, log_frame, int(time_ns), config, counts, keys)
    if len(counts):
        return advanced, _NO_KEYS
    if found + LANES > keys.size:
        keys = workspace("keys", found + LANES, np.uint64)
        advanced, found = run(state, log_frame, int(time_ns), config, counts, keys)
    return advanced, keys[:found]


def _run_ours(
    state: DvsState,
    log_frame: np.ndarray,
    time_ns: int,
    config: DvsConfig,
    counts: np.ndarray,
    keys: np.ndarray,
) -> tuple[DvsState, int]:
    work = (
        *(np.empty(maths.TILE, kind) for kind in (np.int32, np.uint8, np.int32)),
        np.empty((2, maths.TILE)), np.empty((3, maths.TILE), np.float32),
        (np.empty((2, LADDER + 1), np.int32), np.empty(maths.TILE, np.int32), np.empty((2, maths.TILE)),
         np.empty(maths.TILE, np.uint64)),
    )  # fmt: skip
    dt_ns = float(time_ns - state.time_ns)
    photoreceptor = log_frame
    if config.cutoff_hz > 0:
        photoreceptor = np.empty_like(log_frame)
        ours.follow(
            state.log_frame.reshape(-1), log_frame.reshape(-1), state.photoreceptor.reshape(-1),
            np.float32(2 * math.pi * config.cutoff_hz * dt_ns * 1e-9), np.float32(math.log(config.cutoff_half_cd_m2)),
            photoreceptor.reshape(-1), np.empty(maths.TILE, np.float32), work[0],
        )  # fmt: skip
    reference, drift = np.empty_like(state.reference), np.empty_like(state.drift)
    last_event_s = state.last_event_s.copy()
    found = ours.advance(
        (state.photoreceptor.reshape(-1), photoreceptor.reshape(-1), state.reference.reshape(-1)),
        (state.positive_threshold, state.negative_threshold, state.leak_per_s), state.drift, state.last_event_s,
        (reference.reshape(-1), last_event_s, drift), (state.time_ns, dt_ns, float(config.refractory_ns)),
        _noise(state, dt_ns, config), counts, keys, _index_bits(log_frame.size), work,
    )  # fmt: skip
    return _advanced(state, log_frame, photoreceptor, reference, last_event_s, drift, time_ns), found


def _noise(state: DvsState, dt_ns: float, config: DvsConfig) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Noise events of the interval: pixels, times from its start, codes."""
    mean = config.shot_hz * noise_kernels.MOST_BY_THRESHOLD * state.log_frame.size + float(state.hot_hz.sum())
    room = int(mean * dt_ns * 1e-9 + 8 * math.sqrt(mean * dt_ns * 1e-9)) + 16 if mean > 0 else 0
    while True:
        noise = (np.empty(room, np.int32), np.empty(room, np.float64), np.empty(room, np.uint8))
        if mean == 0:
            return noise
        found = noise_kernels.draw_noise(
            state.log_frame.reshape(-1), (state.positive_threshold, state.negative_threshold),
            (float(config.positive_threshold), float(config.negative_threshold)),
            (float(config.shot_hz), math.log(config.shot_half_cd_m2)), (state.hot_pixels, state.hot_hz), dt_ns,
            child_key(state.key, FRAME_STREAMS + state.frame), *noise,
        )  # fmt: skip
        if found <= room:
            return noise[0][:found], noise[1][:found], noise[2][:found]
        room = found


def _run_carla(
    state: DvsState,
    log_frame: np.ndarray,
    time_ns: int,
    config: DvsConfig,
    counts: np.ndarray,
    keys: np.ndarray,
) -> tuple[DvsState, int]:
    reference, last_event_s = np.empty_like(state.reference), np.empty_like(state.last_event_s)
    found = carla.advance(
        state.log_frame.reshape(-1), state.reference.reshape(-1), state.last_event_s, log_frame.reshape(-1),
        state.positive_threshold[0], state.negative_threshold[0], reference.reshape(-1), last_event_s,
        (state.time_ns, time_ns), int(config.refractory_ns), np.float32(config.sigma_threshold),
        child_key(state.key, FRAME_STREAMS + state.frame), counts, keys, _index_bits(log_frame.size),
    )  # fmt: skip
    return _advanced(state, log_frame, log_frame, reference, last_event_s, state.drift, time_ns), found


def _run_v2e(
    state: DvsState,
    log_frame: np.ndarray,
    time_ns: int,
    config: DvsConfig,
    counts: np.ndarray,
    keys: np.ndarray,
) -> tuple[DvsState, int]:
    dt_ns = float(time_ns - state.time_ns)
    flat, photoreceptor, marks = log_frame.reshape(-1), log_frame, np.empty(0, np.uint8)
    levels = (state.positive_threshold, state.negative_threshold, state.leak_per_s)
    if config.cutoff_hz > 0 or config.shot_hz > 0:
        light = np.empty(flat.size, np.float32)
        v2e.intensity(flat, light)
        if config.cutoff_hz > 0:
            photoreceptor = np.empty_like(log_frame)
            angle = np.float32(2 * math.pi * config.cutoff_hz * dt_ns * 1e-9)
            v2e.follow(flat, state.photoreceptor.reshape(-1), light, angle, photoreceptor.reshape(-1))
        if config.shot_hz > 0:
            marks = np.empty(flat.size, np.uint8)
            v2e.mark_shots(
                light, levels[0], levels[1], (float(config.positive_threshold), float(config.negative_threshold)),
                0.5 * config.shot_hz * dt_ns * 1e-9, child_key(state.key, FRAME_STREAMS + state.frame), marks,
            )  # fmt: skip
    reference, drift = np.empty_like(state.reference), np.empty_like(state.drift)
    last_event_s = np.empty_like(state.last_event_s)
    found = v2e.advance(
        photoreceptor.reshape(-1), state.reference.reshape(-1), levels, state.drift, state.last_event_s,
        (reference.reshape(-1), last_event_s, drift), (state.time_ns, dt_ns, float(config.refractory_ns)), marks,
        counts, keys, _index_bits(flat.size),
    )  # fmt: skip
    return _advanced(state, log_frame, photoreceptor, reference, last_event_s, drift, time_ns), found


def _advanced(
    state: DvsState, log_frame: np.ndarray, photoreceptor: np.ndarray, reference: np.ndarray, last_event_s: np.ndarray,
    drift: np.ndarray, time_ns: int,
) -> DvsState:  # fmt: skip
    return replace(
        state, log_frame=log_frame, photoreceptor=photoreceptor, reference=reference, last_event_s=last_event_s,
        drift=drift, time_ns=time_ns, frame=state.frame + 1,
    )  # fmt: skip


def _read_out(
    state: DvsState, keys: np.ndarray, start_ns: int, config: DvsConfig
) -> tuple[DvsState, np.ndarray]:
    """Send sorted keys over the bus, if it has a limit."""
    if config.bus_events_per_s is None:
        return state, keys
    gap_ns = 1e9 / config.bus_events_per_s
    kept, free_ns = ours.queue(
        keys,
        _index_bits(state.log_frame.size),
        gap_ns,
        state.bus_free_ns - start_ns,
        gap_ns * config.bus_queue,
    )
    return replace(state, bus_free_ns=free_ns + start_ns, lost=state.lost + keys.size - kept), keys[:kept]


def _events(
    state: DvsState,
    log_frame: np.ndarray,
    time_ns: int,
    config: DvsConfig,
    causes: np.ndarray | None = None,
    *,
    labelled: bool = False,
    ordered: bool = True,
) -> tuple[DvsState, np.ndarray, np.ndarray]:
    start_ns = state.time_ns
    state, keys = _run(state, log_frame, time_ns, config, _NO_COUNTS)
    bits, width = _index_bits(log_frame.size), log_frame.shape[1]
    span = (
        None if config.model == "carla" else int(time_ns - start_ns) << bits
    )  # CARLA's times may lie beyond
    if config.bus_events_per_s is None and not labelled:
        events = array_of(keys.size, EVENT_DTYPE)
        if ordered:
            write_in_order(keys, bits, width, start_ns, events, span)
        else:
            write(keys, bits, width, start_ns, events)
        return state, events, NO_LABELS
    state, keys = _read_out(state, in_order(keys, span), start_ns, config)
    events = array_of(keys.size, EVENT_DTYPE)
    write(keys, bits, width, start_ns, events)
    labels = _labels(keys, bits, causes) if labelled else NO_LABELS
    if config.bus_events_per_s is None:
        return state, events, labels
    # What the bus sends after this frame is delivered with a later one: every step's events lie within it.
    events = np.concatenate([state.waiting, events])
    now = int(np.searchsorted(events["t"], time_ns))
    if labelled:
        labels = np.concatenate([state.waiting_causes, labels])
    state = replace(state, waiting=events[now:], waiting_causes=labels[now:])
    return state, events[:now], labels[:now]


def _labels(keys: np.ndarray, bits: int, causes: np.ndarray | None) -> np.ndarray:
    labels = _SOURCE_CAUSE[(keys & np.uint64(3)).astype(np.intp)]
    if causes is not None:
        signal = labels == EventCause.SIGNAL
        index = (keys[signal] & np.uint64((1 << bits) - 1)) >> np.uint64(3)
        labels[signal] = causes.reshape(-1)[index.astype(np.intp)]
    return labels


def step(
    state: DvsState, log_frame: np.ndarray, time_ns: int, config: DvsConfig, *, ordered: bool = True
) -> tuple[DvsState, np.ndarray]:
    """Advance to the next frame.

    Args:
        state: Unchanged.
        log_frame: (H, W) float32 at ``time_ns``: ln(cd/m2) by ``log_luminance``, or of an 8-bit frame by ``log_image``;
            for CARLA's linear mode, grey levels. v2e's filter and shot noise read grey levels from it (``lin_log``).
        time_ns: Later than the state's.
        config: The camera, the same as for the state before.
        ordered: False for the same events in an order of no meaning, each pixel's still by their times: enough for
            whoever adds them up, in half the time where there are many. A bus sends them in order all the same.

    Returns:
        The new state and (N,) EVENT_DTYPE sorted by (t, y, x, pol), state.time_ns <= t < time_ns (CARLA's rounding may
        reach ``time_ns`` and a few ns beyond).

    Raises:
        ConfigError: For a frame of another shape or dtype, or a time that does not advance.
    """
    return _events(state, log_frame, time_ns, config, ordered=ordered)[:2]


def step_labelled(
    state: DvsState, log_frame: np.ndarray, time_ns: int, config: DvsConfig, causes: np.ndarray | None = None
) -> tuple[DvsState, np.ndarray, np.ndarray]:
    """Advance like step, and tell for each event what made it.

    An event is LEAK where the leak made up half of the threshold or more since the pixel's last event.

    Args:
        state: Unchanged.
        log_frame: As for step.
        time_ns: As for step.
        config: The camera.
        causes: (H, W) int32, what a change of light at each pixel is put down to: an actor's id, a StaticClass or an
            EventCause (``sensors.causes`` makes it); None: all is EventCause.SIGNAL.

    Returns:
        The new state, the events, and (N,) int32: their causes; those of noise are EventCause's.
    """
    if causes is not None:
        require(causes.shape == log_frame.shape and causes.dtype == np.int32, "causes", (causes.dtype, causes.shape),
                f"int32 of shape {log_frame.shape}")  # fmt: skip
    return _events(state, log_frame, time_ns, config, causes, labelled=True)


def step_counts(
    state: DvsState, log_frame: np.ndarray, time_ns: int, config: DvsConfig, counts: np.ndarray
) -> DvsState:
    """Advance like step, but only add the events to counts: the way for consumers that need no times.

    Args:
        state: Unchanged.
        log_frame: As for step.
        time_ns: As for step.
        config: The camera.
        counts: (H, W, 2) uint8 or uint16, ON and OFF, C-contiguous; added to in place, saturating.

    Returns:
        The new state, the same as step's.
    """
    shape = (*log_frame.shape, 2)
    fits = counts.shape == shape and counts.dtype in (np.uint8, np.uint16) and counts.flags.c_contiguous
    require(fits, "counts", (counts.dtype, counts.shape), f"C-contiguous uint8 or uint16 of shape {shape}")
    if config.bus_events_per_s is not None:  # which events are lost depends on their times
        state, events = step(state, log_frame, time_ns, config)
        add_counts(counts, events)
        return state
    return _run(state, log_frame, time_ns, config, counts.reshape(-1, 2))[0]


def add_counts(counts: np.ndarray, events: np.ndarray) -> None:
    """Add events to counts in place, saturating: step and this do what step_counts does.

    Args:
        counts: (H, W, 2) uint8 or uint16, ON and OFF.
        events: (N,) EVENT_DTYPE within the counts' shape.
    """
    require(events.dtype == EVENT_DTYPE, "events.dtype", events.dtype, "contracts.EVENT_DTYPE")
    height, width = counts.shape[:2]
    index = 2 * (events["y"].astype(np.int64) * width + events["x"]) + ~events["pol"]
    found = np.bincount(index, minlength=2 * height * width).reshape(counts.shape)
    np.minimum(counts + found, np.iinfo(counts.dtype).max, out=counts, casting="unsafe")
