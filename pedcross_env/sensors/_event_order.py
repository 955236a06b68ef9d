"""Events into order: keys of 64 bits, sorted faster than as a whole, and written out as records.

Keys that share their upper bits, which are moments of some microseconds, are dealt into the same row; the lower halves
are sorted row by row, which NumPy does in one call: 32 bits three times as fast per number as 64, and rows of up to 512
twice as fast again. Rows get half as many places again as keys would fill if they came evenly; where that is too few,
the keys are dealt a second time, with what the fullest row needs.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator

import numpy as np
from numpy.typing import DTypeLike

from pedcross_env.camera.kernels.jit import exact_entry, exact_inlined

__all__ = ["array_of", "in_order", "workspace", "write", "write_in_order"]

_FEW = 16384  # keys that are sorted as they are
_ROW = 384  # keys of a row on average, at most: few rows get more than 512
_THIN = 4  # keys of a row on average, at least
_FILL = 1.5  # places per key, where keys are spread evenly enough
_LINE = 16  # places in a line of the processor's cache
_TOGETHER = 128  # rows sorted and written at a time: they stay in the processor's cache
_WORST_FILL = 4  # places per key, above which events crowd in few rows and the others stand empty
_LAST = np.uint32(0xFFFFFFFF)


def array_of(number: int, dtype: DTypeLike) -> np.ndarray:
    """(number,) of whatever content, in memory whose size goes in steps of a sixteenth.

    Frames make nearly equal numbers of events. What one gave back, the next one can have; memory that is asked of the
    system anew would cost a fifth of a step.
    """
    step = max(1, (1 << number.bit_length()) // 16)
    return np.empty(-(-number // step) * step, dtype)[:number]


_thread = threading.local()


def workspace(name: str, number: int, dtype: DTypeLike) -> np.ndarray:
    """(number,) of whatever content, until the calling thread asks for this name again.

    What works on every frame keeps its memory: given back and asked for anew it would cost a tenth of a step.
    """
    held: dict[str, np.ndarray] = _thread.__dict__
    if name not in held or held[name].size < number:
        held[name] = np.empty(number, dtype)
    return held[name][:number]


def in_order(keys: np.ndarray, span: int | None = None) -> np.ndarray:
    """Sort (N,) uint64 keys in place and return them; all lie below ``span``, if that is known."""
    rows = _in_rows(keys, span)
    if rows is None:
        keys.sort()
        return keys
    found = 0
    for part in _sorted(*rows):
        found += int(_collect(*part, keys[found:]))
    return keys


def write_in_order(
    keys: np.ndarray, bits: int, width: int, t0_ns: int, events: np.ndarray, span: int | None = None
) -> None:
    """Write (N,) uint64 sort keys (``pack``'s), in any order and overwritten, as (N,) EVENT_DTYPE in order."""
    rows = _in_rows(keys, span)
    if rows is None:
        keys.sort()
        write(keys, bits, width, t0_ns, events)
        return
    found = 0
    for part in _sorted(*rows):
        found += int(_write_rows(*part, bits, width, t0_ns, events[found:]))


def _in_rows(keys: np.ndarray, span: int | None) -> tuple[np.ndarray, np.ndarray, np.uint64] | None:
    """Lower halves of the keys (rows, room); how many of each row are keys; how many bits lie below a row's.

    None where the keys are few, far apart or crowded.
    """
    if keys.size < _FEW:
        return None
    span = span or int(keys.max()) + 1
    shift = min(32, max(1, _ROW * span // keys.size).bit_length() - 1)
    rows = ((span - 1) >> shift) + 1
    if _THIN * rows > keys.size:
        return None
    counts = np.zeros(rows, np.uint32)
    most = math.ceil(_FILL * keys.size / rows)
    while most * rows <= _WORST_FILL * keys.size:
        lines = -(-most // _LINE) | 1  # odd, else rows would share few places of the processor's cache
        halves = workspace("halves", rows * lines * _LINE, np.uint32).reshape(rows, lines * _LINE)
        most = int(_deal(keys, np.uint64(shift), counts, halves))
        if most <= halves.shape[1]:
            return halves, counts, np.uint64(shift)
    return None


def _sorted(
    halves: np.ndarray, counts: np.ndarray, shift: np.uint64
) -> Iterator[tuple[np.ndarray, np.ndarray, np.uint64, np.uint64]]:
    """Sort some rows at a time; yield their halves, how many of each are keys, the first's number, and shift."""
    for first in range(0, counts.size, _TOGETHER):
        some = counts[first : first + _TOGETHER]
        part = halves[first : first + _TOGETHER, : int(some.max())]
        _pad(part, some)
        part.sort(axis=1)
        yield part, some, np.uint64(first), shift


@exact_entry
def _deal(keys: np.ndarray, shift: np.uint64, counts: np.ndarray, halves: np.ndarray) -> np.uint32:
    """Write each key's lower half into its row; count those of each row; return the largest number.

    Where that is more than there is room for, what was written is worth nothing.
    """
    room, places = np.uint64(halves.shape[1]), halves.reshape(halves.size)
    last = np.uint64(places.size - 1)
    for row in range(counts.size):
        counts[row] = np.uint64(row) * room
    for k in range(keys.size):
        key = keys[k]
        row = key >> shift
        at = counts[row]
        places[min(np.uint64(at), last)] = np.uint32(key)
        counts[row] = at + np.uint32(1)
    most = np.uint32(0)
    for row in range(counts.size):
        counts[row] -= np.uint32(np.uint64(row) * room)
        most = max(most, counts[row])
    return most


@exact_entry
def _pad(halves: np.ndarray, counts: np.ndarray) -> None:
    """Write what sorts last after each row's keys."""
    for row in range(counts.size):
        for place in range(np.uint64(counts[row]), np.uint64(halves.shape[1])):
            halves[row, place] = _LAST


@exact_entry
def _collect(
    halves: np.ndarray, counts: np.ndarray, first: np.uint64, shift: np.uint64, keys: np.ndarray
) -> np.uint64:
    """Join the rows' halves to keys again; return how many."""
    found = np.uint64(0)
    for row in range(counts.size):
        lower, upper, number = halves[row], (first + np.uint64(row)) << shift, np.uint64(counts[row])
        for k in range(number):
            keys[found + k] = upper | np.uint64(lower[k])
        found += number
    return found


@exact_inlined
def _divider(width: int) -> tuple[np.uint64, np.uint64]:
    """What index // width = (index factor) >> shift takes, exactly for 31 bits (Granlund and Montgomery, 1994)."""
    shift = np.uint64(31)
    while (np.uint64(1) << (shift - np.uint64(31))) < np.uint64(width):
        shift += np.uint64(1)
    return ((np.uint64(1) << shift) + np.uint64(width) - np.uint64(1)) // np.uint64(width), shift


@exact_inlined
def _write_event(
    event: np.void, key: np.uint64, bits: int, width: int, divider: tuple[np.uint64, np.uint64], t0_ns: int
) -> None:
    index = (key & ((np.uint64(1) << np.uint64(bits)) - np.uint64(1))) >> np.uint64(3)
    row = (index * divider[0]) >> divider[1]
    event["x"] = index - row * np.uint64(width)
    event["y"] = row
    event["t"] = t0_ns + np.int64(key >> np.uint64(bits))
    event["pol"] = (key & np.uint64(4)) != np.uint64(0)


@exact_entry
def write(keys: np.ndarray, bits: int, width: int, t0_ns: int, events: np.ndarray) -> None:
    """Write sorted keys out as event records."""
    divider = _divider(width)
    for k in range(keys.size):
        _write_event(events[k], keys[k], bits, width, divider, t0_ns)


@exact_entry
def _write_rows(
    halves: np.ndarray, counts: np.ndarray, first: np.uint64, shift: np.uint64, bits: int, width: int, t0_ns: int,
    events: np.ndarray,
) -> np.uint64:  # fmt: skip
    """Write the rows' sorted halves out as event records; return how many."""
    divider = _divider(width)
    found = np.uint64(0)
    for row in range(counts.size):
        lower, upper, number = halves[row], (first + np.uint64(row)) << shift, np.uint64(counts[row])
        for k in range(number):
            _write_event(events[found + k], upper | np.uint64(lower[k]), bits, width, divider, t0_ns)
        found += number
    return found
