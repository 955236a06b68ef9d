"""Events into order: keys of 64 bits, sorted faster than as a whole, and written out as records.

Keys that share their upper bits, which are moments of some microseconds, are dealt into the same row; the lower halves
are sorted row by row, which NumPy does in one call: 32 bits three times as fast per number as 64, and rows of up to 512
twice as fast again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike

from pedcross_env.camera.kernels.jit import exact_entry, inlined

__all__ = ["array_of", "in_order", "write", "write_in_order"]

_FEW = 16384  # keys that are sorted as they are
_ROW = 384  # keys of a row on average, at most: few rows get more than 512
_WORST_FILL = 4  # places per key, above which events crowd in few rows and the others stand empty
_LAST = np.uint32(0xFFFFFFFF)


def array_of(number: int, dtype: DTypeLike) -> np.ndarray:
    """(number,) of whatever content, in memory whose size goes in steps of a sixteenth.

    Frames make nearly equal numbers of events. What one gave back, the next one can have; memory that is asked of the
    system anew would cost a fifth of a step.
    """
    step = max(1, (1 << number.bit_length()) // 16)
    return np.empty(-(-number // step) * step, dtype)[:number]


def in_order(keys: np.ndarray) -> np.ndarray:
    """Sort (N,) uint64 keys in place and return them."""
    rows = _sorted_rows(keys)
    if rows is None:
        keys.sort()
    else:
        _collect(*rows, keys)
    return keys


def write_in_order(keys: np.ndarray, bits: int, width: int, t0_ns: int, events: np.ndarray) -> None:
    """Write (N,) uint64 sort keys (``pack``'s), in any order and overwritten, as (N,) EVENT_DTYPE in order."""
    rows = _sorted_rows(keys)
    if rows is None:
        keys.sort()
        write(keys, bits, width, t0_ns, events)
    else:
        _write_rows(*rows, bits, width, t0_ns, events)


def _sorted_rows(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.uint64] | None:
    """Lower halves of the keys (rows, most), sorted; how many of each row are keys; how many bits lie below a row's.

    None where the keys are few, far apart or crowded.
    """
    if keys.size < _FEW:
        return None
    span = int(keys.max()) + 1
    shift = min(32, (_ROW * span // keys.size).bit_length() - 1)
    rows = ((span - 1) >> shift) + 1
    if rows > keys.size:
        return None
    counts = np.zeros(rows, np.uint32)
    most = int(_count(keys, np.uint64(shift), counts))
    if most * rows > _WORST_FILL * keys.size:
        return None
    halves = array_of(rows * most, np.uint32).reshape(rows, most)
    _deal(keys, np.uint64(shift), counts, halves)
    halves.sort(axis=1)
    return halves, counts, np.uint64(shift)


@exact_entry
def _count(keys: np.ndarray, shift: np.uint64, counts: np.ndarray) -> np.uint32:
    """Add up how many keys each row gets, ``counts`` being zeros; return the largest number."""
    for k in range(keys.size):
        counts[keys[k] >> shift] += np.uint32(1)
    most = np.uint32(0)
    for row in range(counts.size):
        most = max(most, counts[row])
    return most


@exact_entry
def _deal(keys: np.ndarray, shift: np.uint64, counts: np.ndarray, halves: np.ndarray) -> None:
    """Write each key's lower half into its row, and after a row's ``counts`` what sorts last."""
    room, places = np.uint64(halves.shape[1]), halves.reshape(halves.size)
    for row in range(counts.size):
        counts[row] = np.uint64(row) * room
    for k in range(keys.size):
        key = keys[k]
        row = key >> shift
        at = counts[row]
        places[np.uint64(at)] = np.uint32(key)
        counts[row] = at + np.uint32(1)
    for row in range(counts.size):
        begin = np.uint64(row) * room
        for place in range(np.uint64(counts[row]), begin + room):
            places[place] = _LAST
        counts[row] -= np.uint32(begin)


@exact_entry
def _collect(halves: np.ndarray, counts: np.ndarray, shift: np.uint64, keys: np.ndarray) -> None:
    """Join the rows' halves to keys again."""
    found = np.uint64(0)
    for row in range(counts.size):
        lower, upper, number = halves[row], np.uint64(row) << shift, np.uint64(counts[row])
        for k in range(number):
            keys[found + k] = upper | np.uint64(lower[k])
        found += number


@inlined
def _divider(width: int) -> tuple[np.uint64, np.uint64]:
    """What index // width = (index factor) >> shift takes, exactly for 31 bits (Granlund and Montgomery, 1994)."""
    shift = np.uint64(31)
    while (np.uint64(1) << (shift - np.uint64(31))) < np.uint64(width):
        shift += np.uint64(1)
    return ((np.uint64(1) << shift) + np.uint64(width) - np.uint64(1)) // np.uint64(width), shift


@inlined
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
    halves: np.ndarray, counts: np.ndarray, shift: np.uint64, bits: int, width: int, t0_ns: int, events: np.ndarray
) -> None:  # fmt: skip
    """Write the rows' sorted halves out as event records."""
    divider = _divider(width)
    found = np.uint64(0)
    for row in range(counts.size):
        lower, upper, number = halves[row], np.uint64(row) << shift, np.uint64(counts[row])
        for k in range(number):
            _write_event(events[found + k], upper | np.uint64(lower[k]), bits, width, divider, t0_ns)
        found += number
