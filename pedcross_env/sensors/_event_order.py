"""Events into order: keys of 64 bits, sorted faster than as a whole.

Keys that share their upper 32 bits, which are moments of some microseconds, are dealt into the same row; the lower
halves are sorted row by row, which NumPy does in one call, three times as fast per number as it sorts 64 bits.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import exact_entry

__all__ = ["in_order"]

_FEW = 16384  # keys that are sorted as they are
_WORST_FILL = 4  # places per key, above which events crowd in few rows and the others stand empty
_HALF = np.uint64(32)
_LAST = np.uint32(0xFFFFFFFF)


def in_order(keys: np.ndarray) -> np.ndarray:
    """Sort (N,) uint64 keys in place and return them."""
    rows = (int(keys.max(initial=0)) >> 32) + 1
    if keys.size < _FEW or rows > keys.size:
        keys.sort()
        return keys
    counts = np.zeros(rows, np.uint32)
    most = int(_count(keys, counts))
    if most * rows > _WORST_FILL * keys.size:
        keys.sort()
        return keys
    halves = np.empty((rows, most), np.uint32)
    _deal(keys, counts, halves)
    halves.sort(axis=1)
    _collect(halves, counts, keys)
    return keys


@exact_entry
def _count(keys: np.ndarray, counts: np.ndarray) -> np.uint32:
    """Add up how many keys each row gets, ``counts`` being zeros; return the largest number."""
    for k in range(keys.size):
        counts[keys[k] >> _HALF] += np.uint32(1)
    most = np.uint32(0)
    for row in range(counts.size):
        most = max(most, counts[row])
    return most


@exact_entry
def _deal(keys: np.ndarray, counts: np.ndarray, halves: np.ndarray) -> None:
    """Write each key's lower half into its row, and after a row's ``counts`` what sorts last."""
    room, places = np.uint64(halves.shape[1]), halves.reshape(halves.size)
    for row in range(counts.size):
        counts[row] = np.uint64(row) * room
    for k in range(keys.size):
        key = keys[k]
        row = key >> _HALF
        at = counts[row]
        places[np.uint64(at)] = np.uint32(key)
        counts[row] = at + np.uint32(1)
    for row in range(counts.size):
        begin = np.uint64(row) * room
        for place in range(np.uint64(counts[row]), begin + room):
            places[place] = _LAST
        counts[row] -= np.uint32(begin)


@exact_entry
def _collect(halves: np.ndarray, counts: np.ndarray, keys: np.ndarray) -> None:
    """Join the rows' halves to keys again."""
    found = np.uint64(0)
    for row in range(counts.size):
        lower, upper, number = halves[row], np.uint64(row) << _HALF, np.uint64(counts[row])
        for k in range(number):
            keys[found + k] = upper | np.uint64(lower[k])
        found += number
