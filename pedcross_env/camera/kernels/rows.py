"""Loops over one row of pixels: merging within an object, compositing onto the frame.

All arrays are row slices of the same length. Loops are free of branches, so that they vectorise; each exists for one plane
(luminance) and for three (colour).
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import inlined, kernel

__all__ = [
    "add_row",
    "composite_row",
    "exp_minus",
    "fill_row",
    "free_row",
    "hash01",
    "mean_depths",
    "merge_row",
    "nearness",
    "settle_row",
]

F0, F1, HALF = np.float32(0), np.float32(1), np.float32(0.5)
TINY = np.float32(1e-6)
SOLID_M = np.float32(0.02)  # how far surfaces of one object may pass through each other
LEAST_FREE, BLOCK = np.float32(1e-4), 64
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
def fill_row(value, out):
    """Set a row."""
    for i in range(out.shape[0]):
        out[i] = value


@kernel
def settle_row(alpha, plane):
    """Clear what objects do not cover, which holds anything until then: planes are not cleared before they are drawn in."""
    for i in range(plane.shape[0]):
        value = plane[i]
        plane[i] = value if alpha[i] > F0 else F0


@kernel
def _free_block(alpha, free):
    """Fill shares; return how many are worth it. Integers add up in vectors, floats would not."""
    count = np.int32(0)
    for i in range(free.shape[0]):
        free[i] = max(F0, F1 - alpha[i])
        count += np.int32(free[i] >= LEAST_FREE)
    return count


@kernel
def free_row(alpha, free):
    """Share of each pixel that objects left over; return the columns where there is any."""
    n = alpha.shape[0]
    a, b = n, 0
    for first in range(0, n, BLOCK):
        last = min(n, first + BLOCK)
        if _free_block(alpha[first:last], free[first:last]) > 0:
            a, b = min(a, first), last
    while a < b and free[a] < LEAST_FREE:
        a += 1
    while b > a and free[b - 1] < LEAST_FREE:
        b -= 1
    return a, b


@inlined
def _merge_grey(cover, depth, colour, alpha, inverse, plane):
    for i in range(alpha.shape[0]):
        new, old = cover[i], alpha[i]
        near = nearness(depth[i] + FAR, inverse[i], SOLID_M)
        total = min(F1, new + old)
        front = near * new + (F1 - near) * (total - old)
        back = near * min(F1, (F1 - new) / max(old, TINY)) + (F1 - near)
        inverse[i] = (inverse[i] * old * back + depth[i] * front) / max(total, TINY)
        alpha[i] = total
        plane[i] = plane[i] * back + colour[i] * front


@inlined
def _merge_colour(cover, depth, red, green, blue, alpha, inverse, plane0, plane1, plane2):
    for i in range(alpha.shape[0]):
        new, old = cover[i], alpha[i]
        near = nearness(depth[i] + FAR, inverse[i], SOLID_M)
        total = min(F1, new + old)
        front = near * new + (F1 - near) * (total - old)
        back = near * min(F1, (F1 - new) / max(old, TINY)) + (F1 - near)
        inverse[i] = (inverse[i] * old * back + depth[i] * front) / max(total, TINY)
        alpha[i] = total
        plane0[i] = plane0[i] * back + red[i] * front
        plane1[i] = plane1[i] * back + green[i] * front
        plane2[i] = plane2[i] * back + blue[i] * front


@inlined
def merge_row(buf, colour, cover, depth, at, scratch, row, a, b):
    """Unite a primitive's pixels with its object: the nearer covers, coverage adds up to 1 (no seams).

    Args:
        buf: Work space that holds the primitive.
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
    e = at + b - a
    new, inverse_new = buf[cover, at:e], buf[depth, at:e]
    alpha, inverse = alphas[row, a:b], inverses[row, a:b]
    if planes.shape[0] == 1:
        _merge_grey(new, inverse_new, buf[colour, at:e], alpha, inverse, planes[0, row, a:b])
    else:
        _merge_colour(
            new, inverse_new, buf[colour, at:e], buf[colour + 1, at:e], buf[colour + 2, at:e], alpha, inverse,
            planes[0, row, a:b], planes[1, row, a:b], planes[2, row, a:b],
        )  # fmt: skip


@inlined
def _add_grey(cover, depth, colour, alpha, inverse, plane):
    for i in range(alpha.shape[0]):
        share = min(cover[i], F1 - alpha[i])
        alpha[i] += share
        inverse[i] += depth[i] * share
        plane[i] += colour[i] * share


@inlined
def _add_colour(cover, depth, red, green, blue, alpha, inverse, plane0, plane1, plane2):
    for i in range(alpha.shape[0]):
        share = min(cover[i], F1 - alpha[i])
        alpha[i] += share
        inverse[i] += depth[i] * share
        plane0[i] += red[i] * share
        plane1[i] += green[i] * share
        plane2[i] += blue[i] * share


@inlined
def add_row(buf, colour, cover, depth, at, scratch, row, a, b):
    """Add a primitive's pixels to its object behind all that was added before; see ``merge_row``.

    The object's inverse depth is left multiplied by its coverage: ``mean_depths`` ends it.
    """
    planes, alphas, inverses = scratch
    e = at + b - a
    new, inverse_new = buf[cover, at:e], buf[depth, at:e]
    alpha, inverse = alphas[row, a:b], inverses[row, a:b]
    if planes.shape[0] == 1:
        _add_grey(new, inverse_new, buf[colour, at:e], alpha, inverse, planes[0, row, a:b])
    else:
        _add_colour(
            new, inverse_new, buf[colour, at:e], buf[colour + 1, at:e], buf[colour + 2, at:e], alpha, inverse,
            planes[0, row, a:b], planes[1, row, a:b], planes[2, row, a:b],
        )  # fmt: skip


@kernel
def mean_depths(alpha, inverse):
    """Divide a row's inverse depths by its coverage, once all is added."""
    for i in range(alpha.shape[0]):
        inverse[i] = inverse[i] / max(alpha[i], TINY)


@kernel
def _passed(inverse_new, beta, passed):
    for i in range(passed.shape[0]):
        passed[i] = exp_minus(beta / max(inverse_new[i], np.float32(1e-5)))


@kernel
def _over_grey(new, inverse_new, passed, colour, air, alpha, nearest, plane):
    # ``nearest`` is multiplied by ``alpha``, as radiance is: nothing has to be divided
    for i in range(alpha.shape[0]):
        a, v, old, kept_inverse = new[i], inverse_new[i], alpha[i], nearest[i]
        held = old > F0
        kept_inverse = kept_inverse if held else F0
        nearer = v * old > kept_inverse
        back = F1 - a if nearer else F1
        front = F1 if nearer else F1 - old
        share, rest = a * front, old * back
        t = passed[i]
        kept = plane[i]
        plane[i] = (kept if held else F0) * back + colour[i] * (front * t) + share * (F1 - t) * air
        nearest[i] = kept_inverse * back + v * share
        alpha[i] = rest + share
        new[i] = F0
        inverse_new[i] = F0
        colour[i] = F0


@kernel
def _over_grey_clearly(new, inverse_new, colour, alpha, nearest, plane):
    """The same where the air takes and adds nothing."""
    for i in range(alpha.shape[0]):
        a, v, old, kept_inverse = new[i], inverse_new[i], alpha[i], nearest[i]
        held = old > F0
        kept_inverse = kept_inverse if held else F0
        nearer = v * old > kept_inverse
        back = F1 - a if nearer else F1
        front = F1 if nearer else F1 - old
        share, rest = a * front, old * back
        kept = plane[i]
        plane[i] = (kept if held else F0) * back + colour[i] * front
        nearest[i] = kept_inverse * back + v * share
        alpha[i] = rest + share
        new[i] = F0
        inverse_new[i] = F0
        colour[i] = F0


@kernel
def _own(new, inverse_new, alpha, nearest, ident, weight, depth, ids):
    for i in range(alpha.shape[0]):
        a, v, old, inverse, had = new[i], inverse_new[i], alpha[i], nearest[i], weight[i]
        nearer = v * old > (inverse if old > F0 else F0)
        share = a if nearer else a * (F1 - old)
        had = had if old > F0 else F0
        held = had * (F1 - a) if nearer else had
        owns = share > held
        ids[i] = ident if owns else ids[i]
        depth[i] = v if owns else depth[i]
        weight[i] = share if owns else held


@kernel
def _over_colour(new, inverse_new, passed, red, green, blue, air, alpha, nearest, plane0, plane1, plane2):
    air0, air1, air2 = air[0], air[1], air[2]
    for i in range(alpha.shape[0]):
        a, v, old, kept_inverse = new[i], inverse_new[i], alpha[i], nearest[i]
        held = old > F0
        kept_inverse = kept_inverse if held else F0
        nearer = v * old > kept_inverse
        back = F1 - a if nearer else F1
        front = F1 if nearer else F1 - old
        share, rest = a * front, old * back
        t = passed[i]
        through, haze = front * t, share * (F1 - t)
        kept0 = plane0[i]
        plane0[i] = (kept0 if held else F0) * back + red[i] * through + haze * air0
        kept1 = plane1[i]
        plane1[i] = (kept1 if held else F0) * back + green[i] * through + haze * air1
        kept2 = plane2[i]
        plane2[i] = (kept2 if held else F0) * back + blue[i] * through + haze * air2
        nearest[i] = kept_inverse * back + v * share
        alpha[i] = rest + share
        new[i] = F0
        inverse_new[i] = F0
        red[i] = F0
        green[i] = F0
        blue[i] = F0


@kernel
def _over_colour_clearly(new, inverse_new, red, green, blue, alpha, nearest, plane0, plane1, plane2):
    """The same where the air takes and adds nothing."""
    for i in range(alpha.shape[0]):
        a, v, old, kept_inverse = new[i], inverse_new[i], alpha[i], nearest[i]
        held = old > F0
        kept_inverse = kept_inverse if held else F0
        nearer = v * old > kept_inverse
        back = F1 - a if nearer else F1
        front = F1 if nearer else F1 - old
        share, rest = a * front, old * back
        kept0 = plane0[i]
        plane0[i] = (kept0 if held else F0) * back + red[i] * front
        kept1 = plane1[i]
        plane1[i] = (kept1 if held else F0) * back + green[i] * front
        kept2 = plane2[i]
        plane2[i] = (kept2 if held else F0) * back + blue[i] * front
        nearest[i] = kept_inverse * back + v * share
        alpha[i] = rest + share
        new[i] = F0
        inverse_new[i] = F0
        red[i] = F0
        green[i] = F0
        blue[i] = F0


@inlined
def composite_row(scratch, row, a, b, window, beta, air, ident, frame, owners, buf):
    """Put an object's row onto the frame, fog applied, over what is nearer and under what is farther; clear it.

    Args:
        scratch: The object's (premultiplied radiance (C, h, w), coverage, inverse depth) in a window; zeroed between a and b.
        row: Of the window.
        a: First column of the window.
        b: Its column beyond the last.
        window: Where the window begins in the frame: row, column and more.
        beta: Extinction per metre along the optical axis.
        air: (C,) airlight.
        ident: Instance id.
        frame: (premultiplied radiance (C, H, W), coverage, inverse depth of what is visible, multiplied by it, visible share of the pixel's owner,
            its inverse depth, its id); all but the coverage only hold something where something is covered.
        owners: Whether to keep track of each pixel's owner.
        buf: Work space; row 0 is overwritten.
    """
    planes, alphas_new, inverses_new = scratch
    out, alphas, nearests, weights, depths, ids = frame
    new, inverse_new = alphas_new[row, a:b], inverses_new[row, a:b]
    at, first, last = window[0] + row, window[1] + a, window[1] + b
    alpha, nearest = alphas[at, first:last], nearests[at, first:last]
    if owners:
        _own(
            new, inverse_new, alpha, nearest, np.int32(ident), weights[at, first:last], depths[at, first:last], ids[at, first:last]
        )  # fmt: skip
    grey = out.shape[0] == 1
    if beta > F0:
        passed = buf[0, : b - a]
        _passed(inverse_new, beta, passed)
        if grey:
            _over_grey(
                new, inverse_new, passed, planes[0, row, a:b], air[0], alpha, nearest, out[0, at, first:last]
            )  # fmt: skip
        else:
            _over_colour(
                new, inverse_new, passed, planes[0, row, a:b], planes[1, row, a:b], planes[2, row, a:b], air, alpha, nearest,
                out[0, at, first:last], out[1, at, first:last], out[2, at, first:last],
            )  # fmt: skip
    elif grey:
        _over_grey_clearly(new, inverse_new, planes[0, row, a:b], alpha, nearest, out[0, at, first:last])
    else:
        _over_colour_clearly(
            new, inverse_new, planes[0, row, a:b], planes[1, row, a:b], planes[2, row, a:b], alpha, nearest,
            out[0, at, first:last], out[1, at, first:last], out[2, at, first:last],
        )  # fmt: skip
