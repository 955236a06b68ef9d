"""The event camera: CARLA's ``sensor.camera.dvs``, bit for bit, on log luminance of any source.

Source of the rule: CARLA's DVS sensor (MIT), itself after ESIM (Rebecq et al., CoRL 2018). All of it in
float32: between two frames each pixel's value runs straight; an event falls wherever it crosses the pixel's
reference plus or minus a threshold, and the reference moves there, even when the refractory period hides
the event.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pedcross_env.config import DvsConfig, require
from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.hashing import child_key, seed_key
from pedcross_env.sensors import _dvs_kernels as kernels

__all__ = ["DvsState", "add_counts", "carla_log", "initial_state", "log_luminance", "step", "step_counts"]

_NO_KEYS = np.empty(0, np.uint64)
_NO_COUNTS = np.empty((0, 2), np.uint8)
_EVENTS_PER_PIXEL = 6  # room of the first try; where it is short, the frame is run again with enough


@dataclass(frozen=True, slots=True)
class DvsState:
    """What the event camera remembers between frames. Never changed; step returns a new one.

    Attributes:
        log_frame: (H, W) float32, the previous frame.
        reference: (H, W) float32, the level of the last threshold crossing.
        last_event_s: (H, W) float64, time of the last event in seconds, 0 before the first.
        positive_threshold: (H * W,) float32, or (1,) where all pixels share it.
        negative_threshold: The same for OFF.
        time_ns: Of the previous frame.
        frame: Number of frames seen, counting the first as 0; part of the noise's key.
        key: 64-bit key of all that is random.
    """

    log_frame: np.ndarray
    reference: np.ndarray
    last_event_s: np.ndarray
    positive_threshold: np.ndarray
    negative_threshold: np.ndarray
    time_ns: int
    frame: int
    key: np.uint64


def log_luminance(luminance: np.ndarray, floor: float) -> np.ndarray:
    """Natural logarithm of luminance plus a floor (dark current), exact to float32 rounding.

    Its own series instead of the library's logarithm: the same bits on every processor.

    Args:
        luminance: (H, W) float32, cd/m2, 0 or more.
        floor: cd/m2, positive (DvsConfig.log_floor_cd_m2).

    Returns:
        (H, W) float32.
    """
    require(floor > 0, "floor", floor, "positive")
    out = np.add(luminance, np.float32(floor), dtype=np.float32)
    kernels.log_in_place(out.reshape(-1))
    return out


def carla_log(image: np.ndarray, eps: float = 0.001) -> np.ndarray:
    """CARLA's logarithm of an 8-bit picture: ln(eps + grey / 255).

    Args:
        image: (H, W, 3) uint8, RGB.
        eps: CARLA's ``log_eps``.

    Returns:
        (H, W) float32.
    """
    require(image.dtype == np.uint8 and image.ndim == 3 and image.shape[2] == 3, "image",
            (image.dtype, image.shape), "(H, W, 3) uint8, RGB")  # fmt: skip
    require(eps > 0, "eps", eps, "positive")
    red, green, blue = (image[..., channel].astype(np.float64) for channel in range(3))
    grey = (0.2989 * red + 0.587 * green + 0.114 * blue).astype(np.float32)
    return np.log(np.float64(np.float32(eps)) + grey.astype(np.float64) / 255.0).astype(np.float32)


def _check_frame(log_frame: np.ndarray, shape: tuple[int, ...] | None = None) -> np.ndarray:
    require(log_frame.dtype == np.float32 and log_frame.ndim == 2 and log_frame.size > 0, "log_frame",
            (log_frame.dtype, log_frame.shape), "a non-empty (H, W) float32")  # fmt: skip
    require(
        shape is None or log_frame.shape == shape, "log_frame.shape", log_frame.shape, f"the state's {shape}"
    )
    return np.ascontiguousarray(log_frame)


def initial_state(log_frame: np.ndarray, time_ns: int, config: DvsConfig, seed: int) -> DvsState:
    """Start at the first frame, which gives no events.

    Args:
        log_frame: (H, W) float32.
        time_ns: Its time.
        config: The camera.
        seed: Of the thresholds' mismatch and of the background events.
    """
    log_frame = _check_frame(log_frame)
    require(log_frame.size < 2**31, "log_frame.size", log_frame.size, "below 2**31 pixels")
    require(time_ns >= 0, "time_ns", time_ns, "0 or more")
    key = seed_key(seed)
    sigma = config.sigma_threshold if config.mismatch == "pixel" else 0.0
    thresholds = [
        np.full(log_frame.size if sigma > 0 else 1, nominal, np.float32)
        for nominal in (config.positive_threshold, config.negative_threshold)
    ]
    if sigma > 0:
        for stream, values in enumerate(thresholds):
            kernels.spread_thresholds(values, np.float32(sigma), child_key(key, stream))
    return DvsState(
        log_frame=log_frame.copy(),
        reference=log_frame.copy(),
        last_event_s=np.zeros(log_frame.shape, np.float64),
        positive_threshold=thresholds[0],
        negative_threshold=thresholds[1],
        time_ns=int(time_ns),
        frame=0,
        key=key,
    )


def _run(
    state: DvsState,
    log_frame: np.ndarray,
    time_ns: int,
    config: DvsConfig,
    counts: np.ndarray,
    keys: np.ndarray,
) -> tuple[DvsState, int]:
    """Advance by one frame; write to ``counts`` if it has rows, else to ``keys``; count the events."""
    log_frame = _check_frame(log_frame, state.log_frame.shape)
    require(time_ns > state.time_ns, "time_ns", time_ns, f"later than the previous frame's {state.time_ns}")
    bits = _index_bits(log_frame.size)
    require(time_ns - state.time_ns < 1 << (62 - bits), "time_ns", time_ns,
            f"less than {1 << (62 - bits)} ns after the previous frame's {state.time_ns}")  # fmt: skip
    reference = np.empty_like(state.reference)
    last_event_s = np.empty_like(state.last_event_s)
    previous = np.empty_like(log_frame)
    frame = state.frame + 1
    sigma = config.sigma_threshold if config.mismatch == "carla" else 0.0
    key = child_key(state.key, frame + 1)  # +1: streams 0 and 1 drew the thresholds
    found = kernels.advance(
        state.log_frame.reshape(-1), state.reference.reshape(-1), state.last_event_s.reshape(-1),
        log_frame.reshape(-1), state.positive_threshold, state.negative_threshold,
        previous.reshape(-1), reference.reshape(-1), last_event_s.reshape(-1),
        state.time_ns, int(time_ns), int(config.refractory_ns), np.float32(sigma), key, counts, keys, bits,
    )  # fmt: skip
    found = kernels.add_background(
        log_frame.size, float(config.background_rate_hz), int(time_ns) - state.time_ns,
        child_key(key, 0), counts, keys, bits, found,
    )  # fmt: skip
    advanced = DvsState(
        log_frame=previous,
        reference=reference,
        last_event_s=last_event_s,
        positive_threshold=state.positive_threshold,
        negative_threshold=state.negative_threshold,
        time_ns=int(time_ns),
        frame=frame,
        key=state.key,
    )
    return advanced, found


def _index_bits(pixels: int) -> int:
    """Bits that hold a pixel's index and the polarity in an event's sort key."""
    return (pixels - 1).bit_length() + 1


def step(
    state: DvsState, log_frame: np.ndarray, time_ns: int, config: DvsConfig
) -> tuple[DvsState, np.ndarray]:
    """Advance to the next frame.

    Args:
        state: Unchanged.
        log_frame: (H, W) float32, log luminance at ``time_ns`` (or 0..255 for CARLA's linear mode).
        time_ns: Later than the state's.
        config: The camera.

    Returns:
        The new state and (N,) EVENT_DTYPE sorted by (t, y, x, pol).

    Raises:
        ConfigError: For a frame of another shape or dtype, or a time that does not advance.
    """
    keys = np.empty(_EVENTS_PER_PIXEL * log_frame.size, np.uint64)
    advanced, found = _run(state, log_frame, time_ns, config, _NO_COUNTS, keys)
    if found > keys.size:
        keys = np.empty(found, np.uint64)
        advanced, found = _run(state, log_frame, time_ns, config, _NO_COUNTS, keys)
    keys = keys[:found]
    keys.sort()
    events = np.empty(found, EVENT_DTYPE)
    kernels.unpack(keys, _index_bits(log_frame.size), log_frame.shape[1], state.time_ns, events)
    return advanced, events


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
    return _run(state, log_frame, time_ns, config, counts.reshape(-1, 2), _NO_KEYS)[0]


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
