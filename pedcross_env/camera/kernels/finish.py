"""The last pass: depth from inverse depth (exact per pixel on the ground), luminance from radiance."""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["finish_frame"]


@njit(cache=True)
def _depth_row(depth):
    for i in range(depth.shape[0]):
        depth[i] = np.float32(1.0) / depth[i] if depth[i] > np.float32(0) else np.float32(np.inf)


@njit(cache=True)
def _luminance_row(red, green, blue, out):
    for i in range(out.shape[0]):
        out[i] = np.float32(0.2126) * red[i] + np.float32(0.7152) * green[i] + np.float32(0.0722) * blue[i]


@njit(cache=True)
def finish_frame(out, depth, luminance, horizon, down, ahead, height, focal, cy, env):
    """Turn ``depth`` from inverse metres to metres (inf: sky) and fill ``luminance``."""
    for row in range(luminance.shape[0]):
        _depth_row(depth[row])
        if out.shape[0] == 3:
            _luminance_row(out[0, row], out[1, row], out[2, row], luminance[row])
        else:
            luminance[row] = out[0, row]
