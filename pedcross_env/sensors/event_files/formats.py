"""The registry of formats: which there are, how a file tells which one it is."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from pedcross_env.errors import ConfigError, DataError, unknown_name
from pedcross_env.sensors.event_files.recording import Recording, check_events, in_order

__all__ = ["FORMATS", "Format", "read_events", "write_events"]

_PACKAGE = "pedcross_env.sensors.event_files"
_HEAD_BYTES = 4096


@dataclass(frozen=True, slots=True)
class Format:
    """One format: its suffixes, how its files begin, and where its functions are.

    Attributes:
        suffixes: In lower case; the first is the usual one.
        magic: First bytes of every file; several formats may share it.
        reader: "module:function" of (path) -> Recording.
        writer: "module:function" of (path, events, shape, round_times), or "" where files are only read.
    """

    suffixes: tuple[str, ...]
    magic: bytes
    reader: str
    writer: str = ""


FORMATS: MappingProxyType[str, Format] = MappingProxyType(
    {
        "npz": Format((".npz",), b"PK", "npz:read", "npz:write"),
        "dsec": Format((".h5", ".hdf5"), b"\x89HDF\r\n\x1a\n", "dsec:read", "dsec:write"),
        "aedat4": Format((".aedat4",), b"#!AER-DAT4.0\r\n", "aedat4:read", "aedat4:write"),
        "dat": Format((".dat",), b"%", "prophesee:read_dat"),
        "evt2": Format((".raw",), b"%", "prophesee:read_evt2"),
        "evt21": Format((".raw",), b"%", "prophesee:read_evt21"),
        "evt3": Format((".raw",), b"%", "prophesee:read_evt3"),
        "rosbag": Format((".db3",), b"SQLite format 3\0", "rosbag:read"),
    }
)
"""Name to format."""


def _function(spec: str) -> Callable[..., Any]:
    module, name = spec.split(":")
    return getattr(importlib.import_module(f"{_PACKAGE}.{module}"), name)


def _allowed(*, writing: bool) -> str:
    kinds = [(n, f) for n, f in FORMATS.items() if f.writer or not writing]
    return "; ".join(f"{name} ({', '.join(form.suffixes)})" for name, form in kinds)


def _recognise(path: Path) -> str:
    """Name of the format a file is in: by its first bytes, which a wrong suffix does not change."""
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
    except OSError as error:
        raise DataError(f"{path} cannot be read ({error.strerror}); give a file of events.") from error
    if not head:
        raise DataError(
            f"{path} is empty; record it again. Formats that are read: {_allowed(writing=False)}."
        )
    if head.startswith(b"%"):
        from pedcross_env.sensors.event_files.prophesee import recognise

        return recognise(path, head)
    for name, form in FORMATS.items():
        if head.startswith(form.magic):
            return name
    if head.startswith(b"#!AER-DAT"):
        raise DataError(
            f"{path} is AEDAT {head[9:12].decode('latin-1')}; only 4.0 is read: convert it with iniVation's DV."
        )
    by_suffix = next((n for n, form in FORMATS.items() if path.suffix.lower() in form.suffixes), None)
    if by_suffix == "evt2":  # .raw stands for three formats; without a header nothing tells which
        raise DataError(
            f"{path} has no header; name its encoding: read_events(path, format='evt3'), 'evt21' or 'evt2'."
        )
    begins = f"begins with {head[:8]!r}"
    if by_suffix is not None:
        raise DataError(
            f"{path}: byte 0: {begins}, but a {path.suffix} file begins with {FORMATS[by_suffix].magic!r}: it is "
            f"damaged or has the wrong suffix; copy it again."
        )
    raise DataError(
        f"{path} {begins}: no format of events that is known. Allowed: {_allowed(writing=False)}."
    )


def read_events(path: Path | str, *, format: str | None = None, sort: bool = False) -> Recording:
    """Read a file of events, in any format of FORMATS.

    Args:
        path: Of the file; its header decides what it is, whatever its suffix.
        format: Name of the format, for raw files without a header.
        sort: Sort by time what a file holds out of order, instead of refusing it.

    Raises:
        ConfigError: For an unknown format, or one whose optional dependency is not installed.
        DataError: For a file that is missing, truncated or damaged: says at which byte, and what to do.
    """
    path = Path(path)
    if format is not None and format not in FORMATS:
        raise unknown_name("format", format, FORMATS)
    name = format or _recognise(path)
    recording = _function(FORMATS[name].reader)(path)
    return in_order(recording, path, sort=sort)


def write_events(
    path: Path | str,
    events: np.ndarray,
    *,
    shape: tuple[int, int] | None = None,
    round_times: bool = False,
) -> None:
    """Write a file of events; its suffix says in which format. It is there whole or not at all.

    Args:
        path: Of the file; one that exists is replaced.
        events: (N,) EVENT_DTYPE in order of time.
        shape: (height, width) of the sensor; required by aedat4, kept by all others.
        round_times: Allow formats that count in microseconds to cut times down to them.

    Raises:
        ConfigError: For a suffix that no written format has, or a missing optional dependency.
        DataError: For events out of order or outside the shape, or times that the format cannot hold.
    """
    path = Path(path)
    writers = {s: form.writer for form in FORMATS.values() if form.writer for s in form.suffixes}
    if path.suffix.lower() not in writers:
        raise ConfigError(
            f"{path}: suffix {path.suffix!r} names no format that is written. Allowed: {_allowed(writing=True)}."
        )
    check_events(events, shape)
    temporary = path.with_name(f".{os.getpid()}-{path.name}")
    try:
        _function(writers[path.suffix.lower()])(temporary, events, shape, round_times)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
