"""What reading a file of events gives, and the checks and conversions that all formats share."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError

__all__ = ["NS_PER_US", "Recording", "check_events", "damaged", "in_order", "join", "whole_us"]

NS_PER_US = 1000


@dataclass(frozen=True, slots=True)
class Recording:
    """The content of a file of events.

    Attributes:
        events: (N,) EVENT_DTYPE in order of time, in the file's own clock.
        shape: (height, width) of the sensor, None where the file does not say.
        format: Name of the format, one of FORMATS.
        skipped: Events before the stream's first complete time or address, which therefore have none (EVT2, EVT3).
    """

    events: np.ndarray
    shape: tuple[int, int] | None
    format: str
    skipped: int = 0


def damaged(
    path: Path | str, byte: int, found: str, remedy: str = "copy or record the file again"
) -> DataError:
    """Build the error for a file that is not what its format says: names the place, what is there, what to do."""
    return DataError(f"{path}: byte {byte}: {found}; {remedy}.")


def join(
    x: np.ndarray, y: np.ndarray, t_us: np.ndarray, on: np.ndarray, *, path: Path | str, what: str
) -> np.ndarray:
    """Put columns of equal length together, microseconds to nanoseconds.

    Raises:
        DataError: For columns of different lengths, or addresses outside of 0..65535.
    """
    lengths = {name: len(column) for name, column in (("x", x), ("y", y), ("t", t_us), ("p", on))}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise DataError(
            f"{path}: the columns of {what} differ in length ({told}): the file was not finished; record it again."
        )
    events = np.empty(len(x), EVENT_DTYPE)
    for name, column in (("x", x), ("y", y)):
        if len(column) and (column.min() < 0 or column.max() > 0xFFFF):
            bad = int(np.flatnonzero((column < 0) | (column > 0xFFFF))[0])
            raise DataError(f"{path}: event {bad} of {what} has {name} = {column[bad]}; allowed: 0 to 65535.")
        events[name] = column
    events["t"] = np.asarray(t_us, np.int64) * NS_PER_US
    events["pol"] = on
    return events


def check_events(events: np.ndarray, shape: tuple[int, int] | None) -> None:
    """Refuse what no file should hold: another dtype, times that go back, addresses outside the shape."""
    if events.dtype != EVENT_DTYPE or events.ndim != 1:
        raise DataError(
            f"events are {events.dtype} of shape {events.shape}, expected a one-dimensional array of "
            f"contracts.EVENT_DTYPE (x, y, t in ns, pol)."
        )
    back = np.flatnonzero(np.diff(events["t"]) < 0)
    if back.size:
        k = int(back[0]) + 1
        raise DataError(
            f"event {k} is at {events['t'][k]} ns, before the one ahead of it at {events['t'][k - 1]} ns; sort them "
            f"first: events[np.argsort(events['t'], kind='stable')]."
        )
    if shape is not None and events.size:
        height, width = shape
        if events["x"].max() >= width or events["y"].max() >= height:
            raise DataError(
                f"events reach x = {events['x'].max()}, y = {events['y'].max()}, outside the shape (height, width) = "
                f"{shape}; is the shape given as (width, height)?"
            )


def in_order(recording: Recording, path: Path, *, sort: bool) -> Recording:
    """Check what was read, or sort it by time where asked for.

    Raises:
        DataError: Where times go back and ``sort`` is not set, or an address is outside the sensor.
    """
    events = recording.events
    back = np.flatnonzero(np.diff(events["t"]) < 0)
    if back.size:
        k = int(back[0]) + 1
        if not sort:
            by_us = (int(events["t"][k - 1]) - int(events["t"][k])) // NS_PER_US
            raise DataError(
                f"{path}: event {k} of {events.size} lies {by_us} us before the one ahead of it ({back.size} such "
                f"places): the sensor or the transfer mixed them up; read_events(path, sort=True) puts them in order."
            )
        order = np.argsort(events["t"], kind="stable")
        recording = Recording(events[order], recording.shape, recording.format, recording.skipped)
    try:
        check_events(recording.events, recording.shape)
    except DataError as error:
        raise DataError(f"{path}: {error}") from None
    return recording


def whole_us(events: np.ndarray, form: str, *, round_times: bool) -> np.ndarray:
    """Times in microseconds, (N,) int64.

    Args:
        events: (N,) EVENT_DTYPE.
        form: For the error: a format that counts in microseconds.
        round_times: Cut times down to whole microseconds, as sensors do, instead of refusing others.

    Raises:
        DataError: For a time that is no whole microsecond, unless ``round_times``.
    """
    t_us, rest = np.divmod(events["t"], NS_PER_US)
    if not round_times and rest.any():
        k = int(np.flatnonzero(rest)[0])
        raise DataError(
            f"event {k} is at {events['t'][k]} ns, but {form} counts in whole microseconds; allow it to cut "
            f"them down (round_times=True), or write .npz, which keeps nanoseconds."
        )
    return t_us
