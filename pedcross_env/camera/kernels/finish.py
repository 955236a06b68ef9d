"""The last step: depth from inverse depth, luminance from radiance."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel

__all__ = ["finish_frame", "finish_row"]

F0, F1 = np.float32(0), np.float32(1)


@kernel
def _depth_row(depth):
    for i in range(depth.shape[0]):
        depth[i] = F1 / depth[i] if depth[i] > F0 else np.float32(np.inf)


@kernel
def _luminance_row(red, green, blue, out):
    for i in range(out.shape[0]):
        out[i] = np.float32(0.2126) * red[i] + np.float32(0.7152) * green[i] + np.float32(0.0722) * blue[i]


@kernel
def finish_row(row, out, depth, luminance):
    """Turn one row of ``depth`` from inverse metres to metres (inf: sky) and fill its ``luminance`` if there is colour."""
    _depth_row(depth[row])
    if out.shape[0] == 3:
        _luminance_row(out[0, row], out[1, row], out[2, row], luminance[row])


@entry
def finish_frame(out, depth, luminance):
    """Finish all rows.

    Args:
        out: (3, H, W) radiance, or (0, H, W): then ``luminance`` is left alone.
        depth: (H, W) inverse metres, changed to metres.
        luminance: (H, W) cd/m2, filled.
    """
    for row in range(luminance.shape[0]):
        finish_row(row, out, depth, luminance)
