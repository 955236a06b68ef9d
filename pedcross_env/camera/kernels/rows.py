"""Loops over one row of pixels: coverage, merging within an object, compositing onto the frame.

All arrays are row slices of the same length. Loops are free of branches and write one array each: with more, the compiler
gives up proving that they do not overlap, and does not vectorise.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel

__all__ = [
    "composite_row",
    "exp_minus",
    "fill_row",
    "hash01",
    "merge_row",
    "nearness",
]

F0, F1, HALF = np.float32(0), np.float32(1), np.float32(0.5)
SOLID_M = np.float32(0.02)  # how far surfaces of one object may pass through each other
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
def _merge_front(alpha_new, inverse_new, alpha, inverse, front):
    for i in range(alpha.shape[0]):
        a, old = alpha_new[i], alpha[i]
        near = nearness(inverse_new[i] + FAR, inverse[i], SOLID_M)
        front[i] = near * a + (F1 - near) * (min(F1, a + old) - old)


@kernel
def _merge_back(alpha_new, inverse_new, alpha, inverse, back):
    for i in range(alpha.shape[0]):
        near = nearness(inverse_new[i] + FAR, inverse[i], SOLID_M)
        back[i] = near * min(F1, (F1 - alpha_new[i]) / max(alpha[i], np.float32(1e-6))) + (F1 - near)


@kernel
def _merge_inverse(alpha_new, inverse_new, alpha, front, back, inverse):
    for i in range(alpha.shape[0]):
        total = min(F1, alpha_new[i] + alpha[i])
        inverse[i] = (inverse[i] * alpha[i] * back[i] + inverse_new[i] * front[i]) / max(
            total, np.float32(1e-6)
        )


@kernel
def _merge_alpha(alpha_new, alpha):
    for i in range(alpha.shape[0]):
        alpha[i] = min(F1, alpha_new[i] + alpha[i])


@kernel
def _merge_plane(colour, front, back, plane):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] * back[i] + colour[i] * front[i]


@kernel
def merge_row(buf, colour, cover, depth, at, scratch, row, a, b):
    """Unite a primitive's pixels with its object: the nearer covers, coverage adds up to 1 (no seams).

    Args:
        buf: Work space; rows 12 and 13 are overwritten from 0 on.
        colour: First row of ``buf`` with the primitive's radiance, not premultiplied.
        cover: Row with its coverage.
        depth: Row with its inverse depth.
        at: Where in those rows the pixels start.
        scratch: The object's (premultiplied radiance (C, H, W), coverage (H, W), inverse depth of what is visible (H, W)).
        row: Image row.
        a: First column.
        b: Column beyond the last.
    """
    planes, alphas, inverses = scratch
    n = b - a
    alpha_new, inverse_new = buf[cover, at : at + n], buf[depth, at : at + n]
    alpha, inverse, front, back = alphas[row, a:b], inverses[row, a:b], buf[12, :n], buf[13, :n]
    _merge_front(alpha_new, inverse_new, alpha, inverse, front)
    _merge_back(alpha_new, inverse_new, alpha, inverse, back)
    _merge_inverse(alpha_new, inverse_new, alpha, front, back, inverse)
    _merge_alpha(alpha_new, alpha)
    for c in range(planes.shape[0]):
        _merge_plane(buf[colour + c, at : at + n], front, back, planes[c, row, a:b])


@kernel
def _keep(alpha_new, inverse_new, nearest, back):
    for i in range(back.shape[0]):
        back[i] = F1 - alpha_new[i] if inverse_new[i] > nearest[i] else F1


@kernel
def _share(alpha_new, inverse_new, nearest, alpha, share):
    for i in range(share.shape[0]):
        share[i] = alpha_new[i] if inverse_new[i] > nearest[i] else alpha_new[i] * (F1 - alpha[i])


@kernel
def _passed(inverse_new, beta, front):
    for i in range(front.shape[0]):
        front[i] = exp_minus(beta / max(inverse_new[i], np.float32(1e-5)))


@kernel
def _haze(share, passed, haze):
    for i in range(haze.shape[0]):
        haze[i] = share[i] * (F1 - passed[i])


@kernel
def _scale(inverse_new, nearest, alpha, front):
    for i in range(front.shape[0]):
        front[i] *= F1 if inverse_new[i] > nearest[i] else F1 - alpha[i]


@kernel
def _nearest(inverse_new, alpha, back, share, nearest):
    for i in range(nearest.shape[0]):
        kept = alpha[i] * back[i]
        nearest[i] = (nearest[i] * kept + inverse_new[i] * share[i]) / max(kept + share[i], np.float32(1e-6))


@kernel
def _frame_alpha(back, share, alpha):
    for i in range(alpha.shape[0]):
        alpha[i] = alpha[i] * back[i] + share[i]


@kernel
def _composite_plane(colour, front, back, haze, air, plane):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] * back[i] + colour[i] * front[i] + haze[i] * air


@kernel
def _clear_air_plane(colour, front, back, plane):
    for i in range(plane.shape[0]):
        plane[i] = plane[i] * back[i] + colour[i] * front[i]


@kernel
def _owner_id(share, back, weight, ident, ids):
    for i in range(ids.shape[0]):
        ids[i] = ident if share[i] > weight[i] * back[i] else ids[i]


@kernel
def _owner_depth(share, back, weight, inverse_new, depth_inverse):
    for i in range(depth_inverse.shape[0]):
        depth_inverse[i] = inverse_new[i] if share[i] > weight[i] * back[i] else depth_inverse[i]


@kernel
def _owner_weight(share, back, weight):
    for i in range(weight.shape[0]):
        weight[i] = max(share[i], weight[i] * back[i])


@kernel
def fill_row(value, out):
    """Set a row."""
    for i in range(out.shape[0]):
        out[i] = value


@kernel
def composite_row(scratch, row, a, b, beta, air, ident, frame, buf):
    """Put an object's row onto the frame, fog applied, over what is farther and under what is nearer; clear it.

    Args:
        scratch: The object's (premultiplied radiance (C, H, W), coverage, inverse depth); zeroed between a and b.
        row: Image row.
        a: First column.
        b: Column beyond the last.
        beta: Extinction per metre along the optical axis.
        air: (C,) airlight.
        ident: Instance id.
        frame: (premultiplied radiance (C, H, W), coverage, inverse depth of what is visible, visible share of the pixel's owner,
            its inverse depth, its id).
        buf: Work space; rows 0 to 3 are overwritten.
    """
    planes, alphas_new, inverses_new = scratch
    out, alphas, nearests, weights, depths, ids = frame
    n = b - a
    alpha_new, inverse_new = alphas_new[row, a:b], inverses_new[row, a:b]
    alpha, nearest, weight = alphas[row, a:b], nearests[row, a:b], weights[row, a:b]
    front, back, haze, share = buf[0, :n], buf[1, :n], buf[2, :n], buf[3, :n]
    _keep(alpha_new, inverse_new, nearest, back)
    _share(alpha_new, inverse_new, nearest, alpha, share)
    if beta > F0:
        _passed(inverse_new, beta, front)
        _haze(share, front, haze)
    else:
        fill_row(F1, front)
    _scale(inverse_new, nearest, alpha, front)
    for c in range(out.shape[0]):
        plane = planes[c, row, a:b]
        if beta > F0:
            _composite_plane(plane, front, back, haze, air[c], out[c, row, a:b])
        else:
            _clear_air_plane(plane, front, back, out[c, row, a:b])
        fill_row(F0, plane)
    _nearest(inverse_new, alpha, back, share, nearest)
    _frame_alpha(back, share, alpha)
    _owner_id(share, back, weight, np.int32(ident), ids[row, a:b])
    _owner_depth(share, back, weight, inverse_new, depths[row, a:b])
    _owner_weight(share, back, weight)
    fill_row(F0, alpha_new)
    fill_row(F0, inverse_new)
