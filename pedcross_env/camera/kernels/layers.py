"""Layers of the picture, between two renders of each, put one before the other."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import entry

__all__ = ["put_before", "put_between", "put_between_before"]

F1 = np.float32(1)


@entry
def put_between(first, last, share, picture):
    """Fill a picture's upper rows with what lies between two of its renders; all are (rows, W)."""
    for row in range(first.shape[0]):
        a, b, out = first[row], last[row], picture[row]
        for i in range(a.shape[0]):
            out[i] = a[i] + share * (b[i] - a[i])


@entry
def put_before(seen, cover, picture):
    """Put a render of a layer, premultiplied, before a picture."""
    for row in range(seen.shape[0]):
        a, hides, out = seen[row], cover[row], picture[row]
        for i in range(a.shape[0]):
            out[i] = a[i] + (F1 - hides[i]) * out[i]


@entry
def put_between_before(first, first_cover, last, last_cover, share, picture):
    """Put what lies between two renders of a layer before a picture."""
    for row in range(first.shape[0]):
        a, b, out = first[row], last[row], picture[row]
        hides, hides_next = first_cover[row], last_cover[row]
        for i in range(a.shape[0]):
            left = F1 - (hides[i] + share * (hides_next[i] - hides[i]))
            out[i] = a[i] + share * (b[i] - a[i]) + left * out[i]
