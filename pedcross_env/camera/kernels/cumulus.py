"""A layer of clouds seen from below: flat bases, and tops that rise where the layer is thick, looked through from base to top."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel

__all__ = ["look_at_clouds"]

LEVELS = 5  # at which a ray looks into the layer,
STEPS = 4  # and steps from each to the next where there may be a cloud
HIGHEST = 1.7  # roots of the thickness that tops reach
THICK = 2.5  # over the cut: as dark as clouds get; where nearly all is covered what is thickest is
CLEAR = 1.2  # so much less than a cloud's thickness, no billow makes a cloud


@kernel
def _tiled(field, x, y):
    """Read a square field that repeats at every integer, bilinear; its size is a power of 2."""
    n = field.shape[0]
    p, q = x * n, y * n
    left, low = math.floor(p), math.floor(q)
    s, t = p - left, q - low
    i, j = int(left) & (n - 1), int(low) & (n - 1)
    k, m = (i + 1) & (n - 1), (j + 1) & (n - 1)
    near = field[j, i] + s * (field[j, k] - field[j, i])
    far = field[m, i] + s * (field[m, k] - field[m, i])
    return near + t * (far - near)


@kernel
def _through(x, y, base, detail, shape, shown, seen):
    """Follow one ray, which is at (x, y) where it meets the clouds' base, and fill in what it sees."""
    wide, fine, _, cut, soft, rise, _, _ = shape
    covered = high = thick = 0.0
    top, full = HIGHEST * rise, THICK + max(0.0, -cut)
    here = _tiled(base, x / wide, y / wide) - cut
    for level in range(LEVELS):
        below = here
        h = top * (level + 1) / LEVELS
        here = _tiled(base, x * (1.0 + h) / wide, y * (1.0 + h) / wide) - cut
        if max(below, here) < (HIGHEST * level / LEVELS) ** 2 - CLEAR:
            continue
        for step in range(STEPS):
            part = (level + step / STEPS) / LEVELS
            more = 1.0 + top * part
            depth = below + (here - below) * step / STEPS
            depth += shown * _tiled(detail, x * more / fine, y * more / fine)
            share = min(1.0, max(0.0, (depth - (HIGHEST * part) ** 2) / soft + 0.5))
            share *= share * (3.0 - 2.0 * share)
            if share > covered:
                high += (share - covered) * part
                thick += (share - covered) * min(1.0, max(0.0, depth / full))
                covered = share
            if covered > 0.99 or rise <= 0.0:
                break
        if covered > 0.99 or rise <= 0.0:
            break
    seen[0], seen[1], seen[2] = np.float32(covered), np.float32(high), np.float32(thick)


@entry
def look_at_clouds(x, y, z, base, detail, shape, out):
    """Look along directions through the layer, whose base is at height 1.

    Args:
        x: (N, M) of unit vectors.
        y: The same.
        z: The same, upwards.
        base: (K, K) float32 thickness over the layer's mean, in standard deviations, tiled.
        detail: (K, K) the same of its billows.
        shape: Lengths that the two tiles span, how strong the billows are, the thickness that makes a cloud, over which thickness its
            edges fade, how high a cloud rises per root of its thickness, the curve of the layer, and by how much z grows from row to row.
        out: (N, M, 3) float32: share that is covered, how high (share of the highest) and how thick the cloud is where it is seen.
    """
    for n in range(x.shape[0]):
        for m in range(x.shape[1]):
            far = 1.0 / (z[n, m] + shape[6])
            # finer billows than the rows show would alias
            shown = shape[2] * min(1.0, max(0.0, 1.6 - 6.0 * shape[7] * far * far))
            _through(x[n, m] * far, y[n, m] * far, base, detail, shape, shown, out[n, m])
