"""Events as in the DSEC data set's HDF5 files (Gehrig et al., RA-L 2021).

    events/x, events/y  uint16    events/p  uint8    events/t  uint32, us since t_offset
    t_offset            int64, us
    ms_to_idx           uint64; ms_to_idx[k] is the first event with t >= 1000 k

We add ``height`` and ``width`` as attributes of the group ``events``; readers of DSEC do not mind.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pedcross_env.errors import ConfigError, DataError
from pedcross_env.sensors.event_files.recording import Recording, join, whole_us

__all__ = ["read", "write"]

_COLUMNS = ("x", "y", "p", "t")
_LONGEST_US = 2**32 - 1


def _libraries() -> tuple[Any, Any]:
    try:
        import h5py
        import hdf5plugin  # registers the compressions that DSEC uses
    except ImportError as error:
        raise ConfigError(
            f"HDF5 files of events need {error.name}, which is not installed: pip install 'pedcross[events]'."
        ) from error
    return h5py, hdf5plugin


def read(path: Path) -> Recording:
    """Read a DSEC file; see formats.read_events."""
    h5py, _ = _libraries()
    try:
        with h5py.File(path, "r") as file:
            missing = [f"events/{name}" for name in _COLUMNS if f"events/{name}" not in file]
            if missing:
                raise DataError(
                    f"{path} lacks {', '.join(missing)}; a DSEC file has events/x, events/y, events/p, events/t and "
                    f"t_offset, this one has {', '.join(sorted(file)) or 'nothing'}."
                )
            x, y, p, t = (file[f"events/{name}"][()] for name in _COLUMNS)
            offset_us = int(file["t_offset"][()]) if "t_offset" in file else 0
            attributes = file["events"].attrs
            shape = None
            if "height" in attributes and "width" in attributes:
                shape = int(attributes["height"]), int(attributes["width"])
    except (
        OSError
    ) as error:  # HDF5's own message gives the offsets, e.g. "eof = 1024, ..., stored_eof = 4096"
        raise DataError(
            f"{path}: of {path.stat().st_size} bytes, HDF5 cannot read what it should: {error}; it is truncated or "
            f"damaged: copy or record the file again."
        ) from error
    return Recording(
        join(x, y, t.astype(np.int64) + offset_us, p > 0, path=path, what="events"), shape, "dsec"
    )


def write(path: Path, events: np.ndarray, shape: tuple[int, int] | None, round_times: bool) -> None:
    """Write a DSEC file, compressed as DSEC's own (Blosc with Zstandard); see formats.write_events."""
    h5py, hdf5plugin = _libraries()
    t_us = whole_us(events, "DSEC's HDF5", round_times=round_times)
    offset_us = int(t_us[0]) if t_us.size else 0
    t_us = t_us - offset_us
    if t_us.size and t_us[-1] > _LONGEST_US:
        raise DataError(
            f"the events span {t_us[-1] / 1e6:.0f} s, but DSEC's 32-bit times hold {_LONGEST_US / 1e6:.0f} s; write "
            f"parts of the recording, or .npz."
        )
    milliseconds = np.arange(t_us[-1] // 1000 + 1 if t_us.size else 0)
    columns = {
        "events/x": events["x"],
        "events/y": events["y"],
        "events/p": events["pol"].astype(np.uint8),
        "events/t": t_us.astype(np.uint32),
        "ms_to_idx": np.searchsorted(t_us, 1000 * milliseconds).astype(np.uint64),
    }
    filters = hdf5plugin.Blosc(cname="zstd", clevel=1, shuffle=hdf5plugin.Blosc.SHUFFLE)
    with h5py.File(path, "w") as file:
        for name, column in columns.items():
            file.create_dataset(name, data=column, **(filters if column.size else {}))
        file.create_dataset("t_offset", data=np.int64(offset_us))
        if shape is not None:
            file["events"].attrs["height"], file["events"].attrs["width"] = shape
