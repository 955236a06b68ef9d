"""Counter-based randomness for kernels: the same (seed, counters) give the same number in any process."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["child_key", "combine", "seed_key", "unit"]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)


def seed_key(seed: int) -> np.uint64:
    """Fold any integer seed, of whatever sign or size, into the 64-bit key that kernels take."""
    key = child_key(np.uint64(0), 0 if seed >= 0 else 1)
    rest = abs(seed)
    while True:
        key = child_key(key, rest & 0xFFFFFFFFFFFFFFFF)
        rest >>= 64
        if rest == 0:
            return key


def child_key(key: np.uint64, counter: int) -> np.uint64:
    """Call combine from Python, where a kernel's result would come back as a plain int."""
    return np.uint64(combine(key, np.uint64(counter)))


@njit(cache=True, inline="always")
def combine(key: np.uint64, counter: np.uint64) -> np.uint64:
    """Hash a key and a counter into a new 64-bit key (SplitMix64's finaliser; Steele et al., 2014)."""
    z = key + (np.uint64(counter) + np.uint64(1)) * _GOLDEN
    z = (z ^ (z >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


@njit(cache=True, inline="always")
def unit(key: np.uint64) -> float:
    """Turn a key into a float64 in (0, 1]: its logarithm is always finite."""
    return (np.float64(key >> np.uint64(11)) + 1.0) * (1.0 / 9007199254740992.0)
