"""The event camera before a rendered scene: pictures, perhaps in layers, in; the numbers of events out.

What ``dvs.step_counts`` does of frames, for a run of pictures at a time: composing layers, taking logarithms and
counting thresholds are one pass over each picture.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from pedcross_env.camera.layers import Picture
from pedcross_env.hashing import child_key
from pedcross_env.sensors import _count_kernels as kernels
from pedcross_env.sensors.dvs import step_counts
from pedcross_env.sensors.dvs_config import DvsConfig
from pedcross_env.sensors.dvs_state import FRAME_STREAMS, DvsState

__all__ = ["count_pictures", "log_picture"]


def log_picture(picture: Picture, shape: tuple[int, ...], floor: float) -> np.ndarray:
    """ln of a picture's luminance: what ``dvs.log_luminance`` gives of it put together.

    Args:
        picture: Its layers.
        shape: (H, W).
        floor: cd/m2, positive (DvsConfig.log_floor_cd_m2).

    Returns:
        (H, W) float32 that nobody can write to.
    """
    log_frame = np.empty(shape, np.float32)
    kernels.log_picture(
        picture, np.float32(floor), log_frame.reshape(-1), np.empty((3, kernels.TILE), np.float32)
    )
    log_frame.flags.writeable = False
    return log_frame


def count_pictures(
    state: DvsState, pictures: Iterable[tuple[Picture, int]], config: DvsConfig, counts: np.ndarray
) -> DvsState:
    """Advance picture by picture; see ``dvs.step_counts``.

    Args:
        state: Unchanged.
        pictures: Pictures of the state's shape, and their times in ns, each later than the one before.
        config: The camera, the same as for the state before.
        counts: (H, W, 2) uint8 or uint16, ON and OFF, C-contiguous; added to in place, saturating.

    Returns:
        The state after the last picture.
    """
    shape, floor = state.log_frame.shape, config.log_floor_cd_m2
    if counts.dtype != np.uint8 or not _counts_only(config):
        for picture, time_ns in pictures:
            state = step_counts(state, log_picture(picture, shape, floor), time_ns, config, counts)
        return state
    log_frame, reference = state.log_frame.copy(), state.reference.copy()
    flat = log_frame.reshape(-1), reference.reshape(-1)
    levels = state.positive_threshold, state.negative_threshold, state.leak_per_s
    tallies = counts.reshape(-1, 2), counts.reshape(-1).view(np.uint16)
    work = np.empty((7, kernels.TILE), np.float32), np.empty(kernels.TILE, np.int64)
    nominal = float(config.positive_threshold), float(config.negative_threshold)
    shot, hot = (float(config.shot_hz), math.log(config.shot_half_cd_m2)), (state.hot_pixels, state.hot_hz)
    room, now_ns, frame = _room(16), state.time_ns, state.frame
    for picture, time_ns in pictures:
        interval = now_ns, float(time_ns - now_ns), 0.0
        source = nominal, shot, hot, child_key(state.key, FRAME_STREAMS + frame)
        while True:
            done = picture, np.float32(floor), *flat, levels, interval, source, room, *tallies, work
            found = kernels.count_events(*done)
            if found <= len(room[0]):
                break
            room = _room(found)
        now_ns, frame = time_ns, frame + 1
    log_frame.flags.writeable = False
    return replace(
        state, log_frame=log_frame, photoreceptor=log_frame, reference=reference, time_ns=now_ns, frame=frame,
    )  # fmt: skip


def _room(events: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For so many events of noise: their pixels, times and codes."""
    return np.empty(events, np.int32), np.empty(events, np.float64), np.empty(events, np.uint8)


def _counts_only(config: DvsConfig) -> bool:
    """Whether pixels have thresholds and noise and nothing else, and all events are read out."""
    plain = config.model == "pedcross" and config.refractory_ns == config.cutoff_hz == config.leak_hz == 0
    return plain and config.bus_events_per_s is None
