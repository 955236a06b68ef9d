"""Layers of the picture, each between two of its renders, put one before the other, a piece of the picture at a time."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel

__all__ = ["lay", "lay_all"]

F1 = np.float32(1)


@kernel
def _between(a, b, share, out):
    """What lies between two renders."""
    for i in range(out.size):
        out[i] = a[i] + share * (b[i] - a[i])


@kernel
def _before(a, hides, out):
    """Put a render, premultiplied, before what is there."""
    for i in range(out.size):
        out[i] = a[i] + (F1 - hides[i]) * out[i]


@kernel
def _between_before(a, hides, b, hides_next, share, out):
    """Put what lies between two renders before what is there."""
    for i in range(out.size):
        left = F1 - (hides[i] + share * (hides_next[i] - hides[i]))
        out[i] = a[i] + share * (b[i] - a[i]) + left * out[i]


@kernel
def lay(layers, begin, out):
    """Fill a piece of the picture.

    Args:
        layers: The nearest first; of each a render before and one after the moment, and where between them that lies:
            (luminance, cover, luminance, cover, share), images flat, of the picture's upper rows.
        begin: The piece's first pixel.
        out: (n,) cd/m2.
    """
    for place in range(len(layers)):
        k = len(layers) - 1 - place
        first, first_cover, last, last_cover, share = layers[k]
        n = min(out.size, first.size - begin)
        if n <= 0:
            continue
        behind = 0 if place == 0 else min(n, max(0, layers[k + 1][0].size - begin))
        a, b = first[begin : begin + n], last[begin : begin + n]
        if behind < n:
            _between(a[behind:], b[behind:], share, out[behind:n])
        if behind == 0:
            continue
        hides, hides_next = first_cover[begin : begin + behind], last_cover[begin : begin + behind]
        if share == 0:
            _before(a, hides, out[:behind])
        else:
            _between_before(a, hides, b, hides_next, share, out[:behind])


@entry
def lay_all(layers, picture):
    """Fill a whole picture (N,)."""
    lay(layers, 0, picture)
