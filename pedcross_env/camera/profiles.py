"""A street's profile across as piecewise linear bands: what the ground's rows are filled with."""

from __future__ import annotations

import itertools

import numpy as np

__all__ = ["BAND_SIZE", "bands_of", "stripes_of"]

BAND_SIZE = 9  # y range; albedo r, g, b at its low end, at its high end; lines
TOLERANCE = 1e-3  # of an albedo
JUMP = 2e-3  # between two texels: an edge
BEYOND_M = 1e6


def bands_of(integral: np.ndarray, start_m: float, texel_m: float) -> np.ndarray:
    """Cut a profile into bands within which its albedo is linear.

    Args:
        integral: (N + 1, 8) running integrals in texels: cover, r, g, b, lines, and others that are left out.
        start_m: y of its first row.
        texel_m: Of its rows.

    Returns:
        (S, BAND_SIZE) float32 of the bands that cover anything, by y; the outermost reach on without end.
    """
    profile = np.diff(integral[:, :5].astype(np.float64), axis=0)
    covered = profile[:, 0] > 0.5
    jump = (np.abs(np.diff(profile, axis=0)) > JUMP).any(axis=1)
    edges = [0, *(np.flatnonzero(jump) + 1), len(profile)]
    bands = [
        _band(profile, a, b, start_m, texel_m)
        for first, last in itertools.pairwise(edges)
        if covered[first]
        for a, b in _linear_runs(profile[:, 1:4], first, last)
    ]
    out = np.array(bands, np.float32).reshape(-1, BAND_SIZE)
    if len(out) and covered[0]:
        out[0, 0] -= BEYOND_M
    if len(out) and covered[-1]:
        out[-1, 1] += BEYOND_M
    return out


def covered_by(bands: np.ndarray) -> np.ndarray:
    """Return the (R, 2) float32 ranges of y that bands cover without a gap."""
    begins = np.concatenate([[True], bands[1:, 0] != bands[:-1, 1]]) if len(bands) else np.zeros(0, bool)
    ends = np.concatenate([begins[1:], [True]]) if len(bands) else begins
    return np.ascontiguousarray(np.stack([bands[begins, 0], bands[ends, 1]], axis=1))


def stripes_of(integral: np.ndarray, channel: int, start_m: float, texel_m: float) -> np.ndarray:
    """Return the (S, 2) float32 ranges of y in which a marking of the profile lies."""
    inside = np.diff(integral[:, channel].astype(np.float64)) > 0.5
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    return np.ascontiguousarray(start_m + texel_m * edges.reshape(-1, 2), dtype=np.float32)


def _linear_runs(values: np.ndarray, first: int, last: int) -> list[tuple[int, int]]:
    """Split texels first..last until each part lies on the chord between its ends (Douglas and Peucker)."""
    if last - first <= 2:
        return [(first, last)]
    t = np.linspace(0.0, 1.0, last - first)[:, None]
    off = np.abs(values[first:last] - (values[first] + t * (values[last - 1] - values[first]))).max(axis=1)
    if off.max() <= TOLERANCE:
        return [(first, last)]
    middle = first + max(1, int(off.argmax()))
    return _linear_runs(values, first, middle) + _linear_runs(values, middle, last)


def _band(profile: np.ndarray, a: int, b: int, start_m: float, texel_m: float) -> list[float]:
    """One band over texels a..b: the line through their middles, taken on to the band's edges."""
    low, high = profile[a, 1:4], profile[b - 1, 1:4]
    half = 0.5 * (high - low) / max(1, b - 1 - a)
    return [start_m + a * texel_m, start_m + b * texel_m, *(low - half), *(high + half), profile[a, 4]]
