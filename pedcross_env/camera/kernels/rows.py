"""Loops over one row of pixels: coverage, merging within an object, compositing onto the frame.

All arrays are row slices of the same length; the loops are free of branches, so that they vectorise.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel

__all__ = [
    "composite_row",
    "exp_minus",
    "hash01",
    "merge_row",
    "nearness",
]

F0, F1, HALF = np.float32(0), np.float32(1), np.float32(0.5)
FAR = np.float32(1e-9)  # added to inverse depths where nothing is


@inlined
def exp_minus(x):
    """Return exp(-x) for x >= 0 within 1e-4 up to x = 8 (series of exp(x / 16), four squarings)."""
    y = min(x, np.float32(80.0)) * np.float32(0.0625)
    p = F1 + y * (
        F1 + y * (HALF + y * (np.float32(1 / 6) + y * (np.float32(1 / 24) + y * np.float32(1 / 120))))
    )
    p = p * p
    p = p * p
    p = p * p
    p = p * p
    return F1 / p


@inlined
def hash01(a, b):
    """Hash two integers to [0, 1)."""
    h = np.uint32(a) * np.uint32(374761393) + np.uint32(b) * np.uint32(668265263)
    h = (h ^ (h >> np.uint32(13))) * np.uint32(1274126177)
    h = h ^ (h >> np.uint32(16))
    return np.float32(h & np.uint32(0xFFFFFF)) * np.float32(1.0 / 16777216.0)


@inlined
def nearness(inverse_new, inverse_old, thickness):
    """Return 1 where the new surface is nearer, 0 where farther, a ramp where both are within ``thickness`` metres.

    A hard comparison would let pixels flicker where primitives of one object pass through each other.
    """
    step = (inverse_new - inverse_old) / (inverse_new * inverse_new * thickness)
    return max(F0, min(F1, HALF + step))


@kernel
def _merge_weights(alpha_new, inverse_new, alpha, inverse, front, back):
    for i in range(alpha.shape[0]):
        a, old = alpha_new[i], alpha[i]
        near = nearness(inverse_new[i] + FAR, inverse[i], np.float32(0.02))
        total = min(F1, a + old)
        front[i] = near * a + (F1 - near) * (total - old)
        back[i] = near * min(F1, (F1 - a) / max(old, np.float32(1e-6))) + (F1 - near)
        inverse[i] = (inverse[i] * old * back[i] + inverse_new[i] * front[i]) / max(total, np.float32(1e-6))
        alpha[i] = total


@kernel
def _merge_plane(colour, front, back, plane):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] * back[i] + colour[i] * front[i]


@kernel
def merge_row(colours, alpha_new, inverse_new, planes, alpha, inverse, work):
    """Unite a primitive with its object: the nearer covers, coverage adds up to 1 (no seams).

    Args:
        colours: (C, n) radiance of the primitive, not premultiplied.
        alpha_new: (n,) its coverage.
        inverse_new: (n,) its inverse depth.
        planes: (C, n) the object's premultiplied radiance.
        alpha: (n,) the object's coverage.
        inverse: (n,) the object's inverse depth (mean of what is visible), 0 where it is not.
        work: (2, n).
    """
    _merge_weights(alpha_new, inverse_new, alpha, inverse, work[0], work[1])
    for c in range(planes.shape[0]):
        _merge_plane(colours[c], work[0], work[1], planes[c])


@kernel
def _clear_air_weights(alpha_new, inverse_new, alpha, nearest, front, back, owner):
    for i in range(alpha.shape[0]):
        a, old = alpha_new[i], alpha[i]
        near = inverse_new[i] > nearest[i]
        free = F1 - old
        share = a if near else a * free
        keep = F1 - a if near else F1
        front[i] = F1 if near else free
        back[i] = keep
        alpha[i] = old * keep + share
        nearest[i] = (nearest[i] * old * keep + inverse_new[i] * share) / max(alpha[i], np.float32(1e-6))
        owner[i] = share


@kernel
def _clear_air_plane(colour, front, back, plane):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] * back[i] + colour[i] * front[i]
        colour[i] = F0


@kernel
def _composite_weights(alpha_new, inverse_new, beta, alpha, nearest, front, back, haze, owner):
    for i in range(alpha.shape[0]):
        a, old = alpha_new[i], alpha[i]
        near = inverse_new[i] > nearest[i]
        free = F1 - old
        share = a if near else a * free
        keep = F1 - a if near else F1
        passed = exp_minus(beta / max(inverse_new[i], np.float32(1e-5)))
        scale = F1 if near else free
        front[i] = scale * passed
        haze[i] = share * (F1 - passed)
        back[i] = keep
        alpha[i] = old * keep + share
        nearest[i] = (nearest[i] * old * keep + inverse_new[i] * share) / max(alpha[i], np.float32(1e-6))
        owner[i] = share


@kernel
def _composite_plane(colour, front, back, haze, air, plane):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] * back[i] + colour[i] * front[i] + haze[i] * air
        colour[i] = F0


@kernel
def _composite_owner(inverse_new, share, back, ident, weight, depth_inverse, ids):
    for i in range(share.shape[0]):
        kept = weight[i] * back[i]
        takes = share[i] > kept
        weight[i] = share[i] if takes else kept
        depth_inverse[i] = inverse_new[i] if takes else depth_inverse[i]
        ids[i] = ident if takes else ids[i]


@kernel
def _clear(alpha, inverse):
    for i in range(alpha.shape[0]):
        alpha[i] = F0
        inverse[i] = F0


@kernel
def composite_row(
    planes, alpha_new, inverse_new, beta, air, ident, out, alpha, nearest, weight, depth_inverse, ids, work
):
    """Put an object's row onto the frame, fog applied, over what is farther and under what is nearer; clear it.

    Args:
        planes: (C, n) premultiplied radiance of the object; zeroed.
        alpha_new: (n,) its coverage; zeroed.
        inverse_new: (n,) its inverse depth; zeroed.
        beta: Extinction per metre along the optical axis.
        air: (C,) airlight.
        ident: Instance id.
        out: (C, n) premultiplied radiance of the frame.
        alpha: (n,) coverage of the frame.
        nearest: (n,) inverse depth (mean of what is visible) so far.
        weight: (n,) visible share of the pixel's owner.
        depth_inverse: (n,) inverse depth of the owner.
        ids: (n,) id of the owner.
        work: (4, n).
    """
    if beta > F0:
        _composite_weights(alpha_new, inverse_new, beta, alpha, nearest, work[0], work[1], work[2], work[3])
        for c in range(out.shape[0]):
            _composite_plane(planes[c], work[0], work[1], work[2], air[c], out[c])
    else:
        _clear_air_weights(alpha_new, inverse_new, alpha, nearest, work[0], work[1], work[3])
        for c in range(out.shape[0]):
            _clear_air_plane(planes[c], work[0], work[1], out[c])
    _composite_owner(inverse_new, work[3], work[1], ident, weight, depth_inverse, ids)
    _clear(alpha_new, inverse_new)
