"""What networks are fed with: events of a fixed window as an array. NumPy alone, every function pure.

A window is [start_ns, end_ns): an event at its start is in, one at its end belongs to the next, so windows laid end
to end use each event once. The window is the caller's, never the first and the last event's: those depend on noise.

Channels of both polarities: 0 = ON, 1 = OFF. Events are EVENT_DTYPE arrays, sorted by time for CARLA's picture and in
any order for what only adds them up or asks for the latest.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

import numpy as np

from pedcross_env.config import require
from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError, unknown_name
from pedcross_env.sensors.events import carla_image, event_counts, grey_frame, pixel_index

__all__ = [
    "REPRESENTATIONS",
    "event_windows",
    "histogram",
    "represent",
    "time_surface",
    "voxel_grid",
    "window",
]

Shape = tuple[int, int]


def window(events: np.ndarray, start_ns: int, end_ns: int) -> np.ndarray:
    """The events of [start_ns, end_ns).

    Args:
        events: (N,) EVENT_DTYPE sorted by time.
        start_ns: First moment inside.
        end_ns: First moment after.

    Returns:
        (M,) EVENT_DTYPE, a view.

    Raises:
        ConfigError: For a window that does not go forward.
        DataError: For another dtype, or events whose times go back.
    """
    back = _checked(events, start_ns, end_ns)
    if back is not None:
        t = events["t"]
        raise DataError(
            f"event {back} is at {t[back]} ns, before the one ahead of it at {t[back - 1]} ns: this needs events in "
            f"order of time; sort them by events[np.argsort(events['t'], kind='stable')]."
        )
    return _between(events, start_ns, end_ns)


def _within(events: np.ndarray, start_ns: int, end_ns: int) -> np.ndarray:
    """The events of [start_ns, end_ns), in whatever order they come."""
    if _checked(events, start_ns, end_ns) is None:
        return _between(events, start_ns, end_ns)
    return events[(events["t"] >= start_ns) & (events["t"] < end_ns)]


def _checked(events: np.ndarray, start_ns: int, end_ns: int) -> int | None:
    """Refuse what is no window or no events; return the first event that lies before the one ahead of it."""
    require(end_ns > start_ns, "end_ns", end_ns, f"later than start_ns = {start_ns}")
    if events.dtype != EVENT_DTYPE or events.ndim != 1:
        raise DataError(
            f"events are {events.dtype} of shape {events.shape}, expected a one-dimensional array of "
            f"contracts.EVENT_DTYPE; pedcross_env.sensors.event_files reads other layouts."
        )
    back = np.flatnonzero(events["t"][1:] < events["t"][:-1])
    return int(back[0]) + 1 if back.size else None


def _between(events: np.ndarray, start_ns: int, end_ns: int) -> np.ndarray:
    first, last = np.searchsorted(events["t"], [start_ns, end_ns], side="left")
    return events[first:last]


def event_windows(start_ns: int, end_ns: int, length_ns: int) -> list[tuple[int, int]]:
    """Windows of one length laid end to end; what does not fill a whole one at the end is left out.

    Args:
        start_ns: Start of the first.
        end_ns: None ends later.
        length_ns: Of each.

    Returns:
        (start, end) pairs.
    """
    require(length_ns > 0, "length_ns", length_ns, "positive")
    return [
        (start, start + length_ns)
        for start in range(start_ns, max(start_ns, end_ns - length_ns + 1), length_ns)
    ]


def histogram(events: np.ndarray, shape: Shape, start_ns: int, end_ns: int) -> np.ndarray:
    """Count events per polarity and pixel.

    Args:
        events: (N,) EVENT_DTYPE in any order.
        shape: (height, width) of the sensor.
        start_ns: Of the window.
        end_ns: Of the window, exclusive.

    Returns:
        (2, H, W) int32, ON and OFF; nothing saturates.
    """
    chosen = _within(events, start_ns, end_ns)
    pixels = shape[0] * shape[1]
    index = pixel_index(chosen, shape) + pixels * ~chosen["pol"]
    return np.bincount(index, minlength=2 * pixels).astype(np.int32).reshape(2, *shape)


def voxel_grid(
    events: np.ndarray, shape: Shape, start_ns: int, end_ns: int, bins: int = 5, *, polarities: bool = False
) -> np.ndarray:
    """Spread events over ``bins`` moments, each to the two nearest in proportion (Zhu et al., CVPR 2019, eq. 1-2).

    The bins stand at the window's start, its end and evenly between: an event at normalised time
    tau = (bins - 1) (t - start) / (end - start) adds s max(0, 1 - |b - tau|) to bin b, s = +1 for ON, -1 for OFF.

    Args:
        events: (N,) EVENT_DTYPE in any order.
        shape: (height, width) of the sensor.
        start_ns: Of the window.
        end_ns: Of the window, exclusive.
        bins: 1 or more; a single bin takes every event whole.
        polarities: Keep ON and OFF apart, both positive, instead of subtracting OFF from ON.

    Returns:
        (bins, H, W) float32, or (2, bins, H, W) with ``polarities``.
    """
    require(bins >= 1, "bins", bins, "1 or more")
    chosen = _within(events, start_ns, end_ns)
    pixels = shape[0] * shape[1]
    index = pixel_index(chosen, shape)
    tau = (bins - 1) * (chosen["t"] - start_ns) / (end_ns - start_ns)
    low = np.floor(tau).astype(np.int64)
    late = tau - low
    index += low * pixels
    grids = 2 if polarities else 1
    weight = np.ones(index.size) if polarities else np.where(chosen["pol"], 1.0, -1.0)
    if polarities:
        index += bins * pixels * ~chosen["pol"]
    # One grid of room behind: the last bin's late share is zero but still needs an address.
    room = (grids * bins + 1) * pixels
    total = np.bincount(index, weight * (1 - late), room) + np.bincount(index + pixels, weight * late, room)
    grid = total[: grids * bins * pixels].astype(np.float32)
    return grid.reshape((2, bins, *shape) if polarities else (bins, *shape))


def time_surface(
    events: np.ndarray, shape: Shape, start_ns: int, end_ns: int, tau_ns: float | None = None
) -> np.ndarray:
    """How fresh each pixel's last event is: exp(-(end - t_last) / tau) (Lagorce et al., TPAMI 2017, eq. 3).

    Args:
        events: (N,) EVENT_DTYPE in any order.
        shape: (height, width) of the sensor.
        start_ns: Of the window.
        end_ns: Of the window, exclusive.
        tau_ns: Time constant; None: a third of the window, so that its oldest events stand at .05.

    Returns:
        (2, H, W) float32 in [0, 1), ON and OFF; 0 where no event fell.
    """
    chosen = _within(events, start_ns, end_ns)
    tau_ns = (end_ns - start_ns) / 3 if tau_ns is None else tau_ns
    require(tau_ns > 0, "tau_ns", tau_ns, "positive")
    pixels = shape[0] * shape[1]
    index = pixel_index(chosen, shape) + pixels * ~chosen["pol"]
    age_ns = np.full(2 * pixels, np.inf)
    np.minimum.at(age_ns, index, (end_ns - chosen["t"]).astype(np.float64))
    return np.exp(-age_ns / tau_ns).astype(np.float32).reshape(2, *shape)


def _carla(events: np.ndarray, shape: Shape, start_ns: int, end_ns: int) -> np.ndarray:
    """CARLA's picture, (H, W, 3) uint8 RGB: the last event of a pixel in blue (ON) or red (OFF)."""
    return carla_image(window(events, start_ns, end_ns), shape)


def _paper(events: np.ndarray, shape: Shape, start_ns: int, end_ns: int) -> np.ndarray:
    """The paper's one-channel frame, (H, W) uint8: 29 where ON prevails, 76 where OFF does."""
    return grey_frame(event_counts(_within(events, start_ns, end_ns), shape))


REPRESENTATIONS: MappingProxyType[str, Callable[[np.ndarray, Shape, int, int], np.ndarray]] = (
    MappingProxyType(
        {"carla": _carla, "paper": _paper, "counts": histogram, "voxel": voxel_grid, "surface": time_surface}
    )
)
"""Name to function of (events, shape, start_ns, end_ns)."""


def represent(name: str, events: np.ndarray, shape: Shape, start_ns: int, end_ns: int) -> np.ndarray:
    """Make the representation called ``name`` with its defaults.

    Args:
        name: One of REPRESENTATIONS.
        events: (N,) EVENT_DTYPE sorted by time (for CARLA's picture) or in any order.
        shape: (height, width) of the sensor.
        start_ns: Of the window.
        end_ns: Of the window, exclusive.

    Raises:
        ConfigError: For an unknown name (names the nearest) or a window that does not go forward.
        DataError: For what is no event, lies outside ``shape`` or goes back in time.
    """
    if name not in REPRESENTATIONS:
        raise unknown_name("representation", name, REPRESENTATIONS)
    return REPRESENTATIONS[name](events, shape, start_ns, end_ns)
