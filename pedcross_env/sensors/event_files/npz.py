"""Events in NumPy's zip archive: one structured array called ``events``, and ``shape`` (height, width) where known.

Field names tell the unit of time: ``pol`` stands in our own records, in nanoseconds; ``p`` or ``polarity`` in those of
tonic and others, in microseconds.
"""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError
from pedcross_env.sensors.event_files.recording import Recording, damaged, join

__all__ = ["read", "write"]


def read(path: Path) -> Recording:
    """Read ``events`` (and ``shape``) from an archive; see formats.read_events."""
    try:
        with zipfile.ZipFile(path) as archive:
            offsets = {item.filename: item.header_offset for item in archive.infolist()}
    except zipfile.BadZipFile as error:
        size = path.stat().st_size
        raise damaged(
            path, size, f"the file ends without the archive's directory ({error}): it is truncated"
        ) from None
    if "events.npy" not in offsets:
        held = ", ".join(sorted(offsets)) or "nothing"
        raise DataError(
            f"{path} holds {held}, but no array 'events'; write it by write_events or np.savez(path, events=...)."
        )
    shape = None
    member = "events.npy"
    try:
        with np.load(path, allow_pickle=False) as archive:
            events = archive["events"]
            if "shape" in archive:
                member = "shape.npy"
                height, width = (int(n) for n in archive["shape"])
                shape = height, width
    except (zipfile.BadZipFile, zlib.error, ValueError, EOFError, OSError) as error:
        raise damaged(
            path, offsets[member], f"the array {member[:-4]!r} that begins here is damaged ({error})"
        ) from None
    return Recording(_as_events(events, path), shape, "npz")


def _as_events(events: np.ndarray, path: Path) -> np.ndarray:
    if events.ndim != 1:
        raise DataError(
            f"{path}: 'events' has shape {events.shape}; allowed: one dimension, an event per entry."
        )
    if events.dtype == EVENT_DTYPE:
        return events
    names = events.dtype.names or ()
    polarity = next((name for name in ("pol", "p", "polarity") if name in names), None)
    if not {"x", "y", "t"} <= set(names) or polarity is None:
        raise DataError(
            f"{path}: 'events' has dtype {events.dtype}; allowed: a structured array with fields x, y, t and "
            f"pol (t in ns) or p or polarity (t in us)."
        )
    if events["t"].dtype.kind not in "iu":
        raise DataError(f"{path}: field 't' is {events['t'].dtype}; allowed: integers.")
    out = join(events["x"], events["y"], events["t"], events[polarity] > 0, path=path, what="'events'")
    if polarity == "pol":
        out["t"] = events["t"]
    return out


def write(path: Path, events: np.ndarray, shape: tuple[int, int] | None, round_times: bool) -> None:
    """Write an archive, compressed; see formats.write_events. Nanoseconds are kept."""
    extra = {} if shape is None else {"shape": np.array(shape, np.int64)}
    with path.open("wb") as file:  # a name alone would be given the suffix .npz
        np.savez_compressed(file, events=events, **extra)  # type: ignore[arg-type]
