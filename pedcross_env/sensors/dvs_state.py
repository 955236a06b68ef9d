"""What the event camera remembers between frames, and how it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import require
from pedcross_env.hashing import child_key, seed_key
from pedcross_env.sensors import _dvs_maths as maths
from pedcross_env.sensors.dvs_config import DvsConfig

__all__ = ["FRAME_STREAMS", "NO_LABELS", "DvsState", "check_frame", "initial_state"]

NO_LABELS = np.empty(0, np.int32)
_NO_FLOATS = np.empty(0, np.float32)
_NO_TIMES = np.empty(0, np.float64)
_NO_EVENTS = np.empty(0, EVENT_DTYPE)
_HOT_SPREAD = (
    math.log(2) / 0.6745
)  # of ln(rate): half of the hot pixels are within a factor two of the median
_ON, _OFF, _LEAK_RATE, _PHASE, _HOT = range(5)  # streams of the state's key
FRAME_STREAMS = 16  # those of the frames follow from here on


@dataclass(frozen=True, slots=True)
class DvsState:
    """What the event camera remembers between frames. Never changed; step returns a new one.

    Attributes:
        log_frame: (H, W) float32, the previous frame.
        photoreceptor: (H, W) float32, what the pixels make of it: the same without ``cutoff_hz``.
        reference: (H, W) float32, the level that the next threshold counts from.
        last_event_s: (H * W,) float64, time of the last event in seconds, 0 before the first; (0,) where it does
            not matter.
        drift: (H * W,) float32, what leaked since each pixel's last event; (0,) without leak.
        positive_threshold: (H * W,) float32, or (1,) where all pixels share it.
        negative_threshold: The same for OFF.
        leak_per_s: The same for the leak of the reference.
        hot_pixels: (N,) int32 and hot_hz (N,) float64: pixels that fire by themselves.
        time_ns: Of the previous frame.
        frame: Number of frames seen, counting the first as 0; part of the noise's key.
        key: 64-bit key of all that is random.
        bus_free_ns: Time from which the bus is free, float.
        waiting: EVENT_DTYPE, read out after ``time_ns``, and waiting_causes (N,) int32.
        lost: Number of events that the bus lost so far.
    """

    log_frame: np.ndarray
    photoreceptor: np.ndarray
    reference: np.ndarray
    last_event_s: np.ndarray
    drift: np.ndarray
    positive_threshold: np.ndarray
    negative_threshold: np.ndarray
    leak_per_s: np.ndarray
    hot_pixels: np.ndarray
    hot_hz: np.ndarray
    time_ns: int
    frame: int
    key: np.uint64
    bus_free_ns: float = 0.0
    waiting: np.ndarray = field(default_factory=_NO_EVENTS.copy)
    waiting_causes: np.ndarray = field(default_factory=NO_LABELS.copy)
    lost: int = 0


MOST_LOG = 1e5  # far beyond any light's logarithm and any grey level; a pixel's events stay countable


def check_frame(log_frame: np.ndarray, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Take a frame, which must be a log image (of ``shape`` if given): copied, unless nobody can write to it."""
    require(log_frame.dtype == np.float32 and log_frame.ndim == 2 and log_frame.size > 0, "log_frame",
            (log_frame.dtype, log_frame.shape),
            "a non-empty (H, W) float32; log_image makes one of an 8-bit frame, log_luminance of light")  # fmt: skip
    require(
        shape is None or log_frame.shape == shape, "log_frame.shape", log_frame.shape, f"the state's {shape}"
    )
    low, high = float(log_frame.min()), float(log_frame.max())
    require(low >= -MOST_LOG and high <= MOST_LOG, "log_frame from, to", (low, high),
            f"finite and within +-{MOST_LOG:g}; log_luminance adds a floor to the light")  # fmt: skip
    kept = log_frame.flags.owndata and log_frame.flags.c_contiguous and not log_frame.flags.writeable
    return log_frame if kept else np.array(log_frame, order="C")


def initial_state(log_frame: np.ndarray, time_ns: int, config: DvsConfig, seed: int) -> DvsState:
    """Start at the first frame, which gives no events.

    With leak, pixels start anywhere on their way to the next leak event, as in a camera that has long been on.

    Args:
        log_frame: (H, W) float32, see ``step``.
        time_ns: Its time.
        config: The camera.
        seed: Of the pixels' differences and of all noise.
    """
    log_frame = check_frame(log_frame)
    pixels = log_frame.size
    require(pixels < 2**31, "log_frame.size", pixels, "below 2**31 pixels")
    require(time_ns >= 0, "time_ns", time_ns, "0 or more")
    key = seed_key(seed)
    sigma = 0.0 if config.model == "carla" else config.sigma_threshold
    size = pixels if sigma > 0 or (config.leak_hz > 0 and config.leak_spread_decades > 0) else 1
    thresholds = [
        np.full(size, c, np.float32) for c in (config.positive_threshold, config.negative_threshold)
    ]
    if sigma > 0:
        for stream, values in zip((_ON, _OFF), thresholds, strict=True):
            maths.spread(values, np.float32(sigma), child_key(key, stream))
    leak_per_s = thresholds[0] * np.float32(config.leak_hz)
    if config.leak_hz > 0 and config.leak_spread_decades > 0:
        maths.lognormal(leak_per_s, config.leak_spread_decades, child_key(key, _LEAK_RATE))
    reference, drift = log_frame.copy(), _NO_FLOATS
    if config.leak_hz > 0:
        phase = np.random.Generator(np.random.Philox(key=int(child_key(key, _PHASE)))).random(
            pixels, np.float32
        )
        drift = phase * thresholds[0]
        reference.reshape(-1)[:] -= drift
    hot_pixels, hot_hz = _hot_pixels(pixels, config, int(child_key(key, _HOT)))
    return DvsState(
        log_frame=log_frame, photoreceptor=log_frame, reference=reference,
        last_event_s=np.zeros(pixels) if config.model == "carla" or config.refractory_ns > 0 else _NO_TIMES,
        drift=drift, positive_threshold=thresholds[0], negative_threshold=thresholds[1], leak_per_s=leak_per_s,
        hot_pixels=hot_pixels, hot_hz=hot_hz, time_ns=int(time_ns), frame=0, key=key, bus_free_ns=float(time_ns),
    )  # fmt: skip


def _hot_pixels(pixels: int, config: DvsConfig, key: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.Generator(np.random.Philox(key=key))
    number = rng.binomial(pixels, config.hot_share) if config.hot_share > 0 and config.hot_hz > 0 else 0
    chosen = np.sort(rng.choice(pixels, number, replace=False)).astype(np.int32)
    return chosen, config.hot_hz * np.exp(_HOT_SPREAD * rng.standard_normal(number))
