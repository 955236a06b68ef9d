"""The last passes: what a wet road mirrors, depth from inverse depth, luminance from radiance.

The mirror image is taken from the rendered image: an object at depth z that is seen at row v appears mirrored about the row in
which the ground has depth z. Every pixel above the ground is thrown to that place in its column (the nearest wins), the sky to
the horizon's mirror image; roughness blurs the result vertically; Schlick's Fresnel factor scales it.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import kernel

__all__ = ["finish_frame", "mirror_in_road"]

FILM = 0.6  # share of a soaked road's surface that is smooth water
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
def finish_frame(out, depth, luminance):
    """Turn ``depth`` from inverse metres to metres (inf: sky) and fill ``luminance`` if there is colour."""
    for row in range(luminance.shape[0]):
        _depth_row(depth[row])
        if out.shape[0] == 3:
            _luminance_row(out[0, row], out[1, row], out[2, row], luminance[row])


@kernel
def _throw(source, inverse, ids, ground_scale, horizon, first, mirror, mirror_inverse):
    """Fill the mirror image below row ``first``; see the module's text.

    ``ground_scale``: rows below the horizon per inverse metre of depth (focal length x height).
    """
    height, width = inverse.shape
    channels = source.shape[0]
    for row in range(first, height):  # what nothing stands in front of: the sky
        from_row = min(max(int(2 * horizon - row - 0.5), 0), max(0, int(horizon) - 2))
        for i in range(width):
            mirror_inverse[row, i] = F0
            for c in range(channels):
                mirror[c, row, i] = source[c, from_row, i]
    for row in range(height):
        for i in range(width):
            inv = inverse[row, i]
            if ids[row, i] == -1 or inv <= F0:
                continue
            target = int(np.floor(2.0 * (horizon + ground_scale * inv) - row - 0.5))
            if target < first or target >= height or target < row:
                continue
            if inv >= mirror_inverse[target, i]:
                mirror_inverse[target, i] = inv
                for c in range(channels):
                    mirror[c, target, i] = source[c, row, i]


@kernel
def _blur_columns(plane, first, horizon, sums, out):
    """Running vertical mean whose width grows with the distance below the horizon."""
    height, width = plane.shape
    for i in range(width):
        sums[first, i] = 0.0
    for row in range(first, height):
        for i in range(width):
            sums[row + 1, i] = sums[row, i] + plane[row, i]
    for row in range(first, height):
        half = 2.0 + 0.16 * (row - horizon)
        low, high = max(first + 0.0, row + 0.5 - half), min(height - 1e-6, row + 0.5 + half)
        a, b = int(low), int(high)
        fa, fb = low - a, high - b
        scale = 1.0 / (high - low)
        for i in range(width):
            below = sums[b, i] + fb * (sums[b + 1, i] - sums[b, i])
            above = sums[a, i] + fa * (sums[a + 1, i] - sums[a, i])
            out[row, i] = (below - above) * scale


@kernel
def mirror_in_road(
    out, inverse, ids, horizon, focal, height_m, wetness, beta, share, mirror, mirror_inverse, blurred, sums
):
    """Add what the wet ground mirrors.

    Args:
        out: (C, H, W) radiance, changed on the ground only.
        inverse: (H, W) inverse depth of the pixels' owners.
        ids: (H, W) instance ids.
        horizon: Row of the horizon, continuous.
        focal: Pixels.
        height_m: Of the camera.
        wetness: 0 to 1.
        beta: Extinction per metre; what is mirrored is seen through the fog before the road once more.
        share: (H, W) visible share of the pixel's owner.
        mirror: (C, H, W) work space.
        mirror_inverse: (H, W) work space.
        blurred: (H, W) work space.
        sums: (H + 1, W) float64 work space.
    """
    height, width = inverse.shape
    first = max(0, int(horizon) + 1)
    if first >= height:
        return
    _throw(out, inverse, ids, focal * height_m, horizon, first, mirror, mirror_inverse)
    for c in range(out.shape[0]):
        _blur_columns(mirror[c], first, horizon, sums, blurred)
        for row in range(first, height):
            slope = (row + 0.5 - horizon) / focal
            cosine = slope / np.sqrt(1.0 + slope * slope)
            fresnel = 0.02 + 0.98 * (1.0 - cosine) ** 5
            through = np.exp(-beta * height_m / max(slope, 1e-4))
            gain = np.float32(FILM * wetness * fresnel * through)
            for i in range(width):
                if ids[row, i] == -1:
                    weight = min(F1, share[row, i])
                    out[c, row, i] += weight * gain * blurred[row, i]
