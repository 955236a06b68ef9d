"""Tapered capsules (limbs, trunks, poles) and spheres (heads, leaves).

They are small and many, so that one fused loop over their pixels beats passes over row slices; it has no branches, so that it
runs in vectors.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import LANES, inlined, kernel
from pedcross_env.camera.kernels.polygons import NEAR_M, grow
from pedcross_env.camera.kernels.rows import F0, F1, HALF, TINY, nearness

__all__ = ["draw_capsule"]

# within what distance two surfaces mingle: a share of the radius, at most about a pixel, and metres more
MINGLE_SHARE, MINGLE_PX, MINGLE_M = 0.25, 1.0, 0.002
MEAN_NZ = np.float32(-0.7854)  # of a cylinder's front over its width: -pi / 4


@inlined
def _span(u0, v0, q0, u1, v1, q1, row, a, b):
    """Columns of a row that the capsule can touch: its two discs and the band between them."""
    y = row + 0.5
    du, dv = u1 - u0, v1 - v0
    reach = max(q0, q1) + 0.8
    if abs(du) + abs(dv) < 0.5:
        half = math.sqrt(max(0.25, reach * reach - max(0.0, abs(y - v0) - 0.5) ** 2)) + 0.5
        low, high = min(u0, u1) - half, max(u0, u1) + half
    elif abs(dv) < 1e-6:
        low, high = min(u0, u1) - reach, max(u0, u1) + reach
    else:
        ta = min(1.0, max(0.0, (y - reach - v0) / dv))
        tb = min(1.0, max(0.0, (y + reach - v0) / dv))
        xa, xb = u0 + ta * du, u0 + tb * du
        low, high = min(xa, xb) - reach, max(xa, xb) + reach
    return max(a, int(math.floor(max(low, -1.0)))), min(b, int(math.ceil(min(high, b + 1.0))))


@kernel
def _mean_light(seg, sun, head):
    """Fill seg[11] and seg[12] with the mean cosines to ``sun`` and ``head`` over the width of a cylinder that is seen."""
    length = np.sqrt(seg[2] * seg[2] + seg[3] * seg[3])
    ex, ey = (-seg[3] / length, seg[2] / length) if length > np.float32(1e-3) else (F1, F0)
    seg[11] = seg[12] = F0
    for k in range(8):
        across = np.float32(0.25) * np.float32(k) - np.float32(0.875)
        nz = -np.sqrt(F1 - across * across)
        seg[11] += np.float32(0.125) * max(F0, (sun[0] * ex + sun[1] * ey) * across + sun[2] * nz)
        seg[12] += np.float32(0.125) * max(F0, (head[0] * ex + head[1] * ey) * across + head[2] * nz)


@kernel
def _cut_ends(seg, dx, dy, dz, q0, q1):
    """Fill seg[14] to seg[16]: the ends of posts are flat, discs that are seen as far as the post points at the camera."""
    seg[14], seg[15], seg[16] = F0, F1, F1
    if seg[10] > F0:
        towards = abs(dz) / math.sqrt(dx * dx + dy * dy + dz * dz + 1e-12)
        seg[14] = math.sqrt(seg[2] * seg[2] + seg[3] * seg[3])
        seg[15], seg[16] = 0.5 + q0 * towards, 0.5 + q1 * towards + seg[14]


@inlined
def _shade(k, x, dy, seg, sun, head):
    """Shade a pixel of a capsule.

    Returns:
        Coverage and inverse depth; place along the capsule, normal, cosines to the sun and the ego's lamps; in the picture, the way
        from the capsule's axis to the pixel: the side that is left free, shorter than 1 where both are.
    """
    dx = x + np.float32(np.int32(k))
    along = (dx * seg[2] + dy * seg[3]) * seg[4]
    t = max(F0, min(F1, along))
    px, py = dx - t * seg[2], dy - t * seg[3]
    r = seg[5] + t * seg[6]
    d = np.sqrt(px * px + py * py)
    a = max(F0, min(F1, r - d + HALF) + min(F1, r + d + HALF) - F1)
    a *= max(F0, min(F1, min(seg[15] + along * seg[14], seg[16] - along * seg[14])))
    scale, out = F1 / max(r, d + TINY), F1 / max(d, HALF)
    nx, ny = px * scale, py * scale
    nz = -np.sqrt(max(F0, F1 - nx * nx - ny * ny))
    centre = seg[7] + seg[8] * t
    inverse = centre / (F1 + seg[9] * nz * centre)
    cos_sun = max(F0, sun[0] * nx + sun[1] * ny + sun[2] * nz)
    cos_head = max(F0, head[0] * nx + head[1] * ny + head[2] * nz)
    # what a pixel sees whole has the mean light of its width, not its centre's
    point = max(F0, min(F1, r - HALF))
    cos_sun, cos_head = seg[11] + point * (cos_sun - seg[11]), seg[12] + point * (cos_head - seg[12])
    nx, ny, nz = point * nx, point * ny, MEAN_NZ + point * (nz - MEAN_NZ)
    return a, inverse, t, nx, ny, nz, cos_sun, cos_head, px * out, py * out


@inlined
def _lay_under(a, inverse, old, behind):
    """Put a pixel's coverage under what its object has there: ``old`` at the inverse depth ``behind``.

    Returns:
        New coverage and inverse depth, share of the new radiance.
    """
    total = min(F1, a + old)
    front = total - old
    return total, (behind * old + inverse * front) / max(total, TINY), front


@inlined
def _mingle(a, inverse, free_x, free_y, old, behind, was_x, was_y, thickness):
    """Unite a pixel's coverage with what its object has there; the nearer covers.

    Two parts that leave the same side of the pixel free cover the same of it; others cover what the other leaves, so that there
    are no gaps between them.

    Returns:
        New coverage and inverse depth, shares of the old and of the new radiance, and the side that is left free now.
    """
    was_x, was_y = was_x if old > F0 else F0, was_y if old > F0 else F0
    total = min(F1, a + old)
    alike = max(F0, free_x * was_x + free_y * was_y)
    total += alike * alike * (max(a, old) - total)
    near = nearness(inverse, behind, thickness)
    front = near * a + (F1 - near) * (total - old)
    back = near * ((total - a) / max(old, TINY)) + (F1 - near)
    inverse = (behind * old * back + inverse * front) / max(total, TINY)
    share = a / max(a + old, TINY)
    return total, inverse, back, front, was_x + share * (free_x - was_x), was_y + share * (free_y - was_y)


@inlined
def _radiance(light, heads, t, nx, ny, nz, cos_sun, cos_head):
    value = light[0] + light[1] * nx + light[2] * ny + light[3] * nz + light[4] * cos_sun + light[5]
    return value + (heads[0] + heads[1] * t) * cos_head


@inlined
def _under_grey(x, dy, seg, light, heads, sun, head, alpha, inverse, plane):
    for k in range(alpha.shape[0]):
        a, depth, t, nx, ny, nz, cos_sun, cos_head, _, _ = _shade(k, x, dy, seg, sun, head)
        alpha[k], inverse[k], front = _lay_under(a, depth, alpha[k], inverse[k])
        plane[k] += _radiance(light, heads, t, nx, ny, nz, cos_sun, cos_head) * front


@inlined
def _under_colour(x, dy, seg, light, heads, sun, head, alpha, inverse, plane0, plane1, plane2):
    for k in range(alpha.shape[0]):
        a, depth, t, nx, ny, nz, cos_sun, cos_head, _, _ = _shade(k, x, dy, seg, sun, head)
        alpha[k], inverse[k], front = _lay_under(a, depth, alpha[k], inverse[k])
        plane0[k] += _radiance(light[0], heads[0], t, nx, ny, nz, cos_sun, cos_head) * front
        plane1[k] += _radiance(light[1], heads[1], t, nx, ny, nz, cos_sun, cos_head) * front
        plane2[k] += _radiance(light[2], heads[2], t, nx, ny, nz, cos_sun, cos_head) * front


@inlined
def _mingle_grey(x, dy, seg, light, heads, sun, head, alpha, inverse, right, down, plane):
    thickness = seg[13]
    for k in range(alpha.shape[0]):
        a, depth, t, nx, ny, nz, cos_sun, cos_head, free_x, free_y = _shade(k, x, dy, seg, sun, head)
        alpha[k], inverse[k], back, front, right[k], down[k] = _mingle(
            a, depth, free_x, free_y, alpha[k], inverse[k], right[k], down[k], thickness
        )
        plane[k] = plane[k] * back + _radiance(light, heads, t, nx, ny, nz, cos_sun, cos_head) * front


@inlined
def _mingle_colour(
    x, dy, seg, light, heads, sun, head, alpha, inverse, right, down, plane0, plane1, plane2
):  # fmt: skip
    thickness = seg[13]
    for k in range(alpha.shape[0]):
        a, depth, t, nx, ny, nz, cos_sun, cos_head, free_x, free_y = _shade(k, x, dy, seg, sun, head)
        alpha[k], inverse[k], back, front, right[k], down[k] = _mingle(
            a, depth, free_x, free_y, alpha[k], inverse[k], right[k], down[k], thickness
        )
        plane0[k] = plane0[k] * back + _radiance(light[0], heads[0], t, nx, ny, nz, cos_sun, cos_head) * front
        plane1[k] = plane1[k] * back + _radiance(light[1], heads[1], t, nx, ny, nz, cos_sun, cos_head) * front
        plane2[k] = plane2[k] * back + _radiance(light[2], heads[2], t, nx, ny, nz, cos_sun, cos_head) * front


@inlined
def _six(v):
    return v[0], v[1], v[2], v[3], v[4], v[5]


@inlined
def _fill(row, f0, f1, seg, light, heads, sun, head, planes, alpha, inverse, free):
    """Shade and unite one row; see ``draw_capsule`` and ``rows.merge_row``.

    seg: u0, v0, du, dv, 1 / length^2, r0, dr (pixels), 1/z0, its slope, radius in metres, 1 if layered, mean cosines (2), how far
    from another surface it mingles with it, metres, pixels of coverage per length along it where its ends are cut off, or 0;
    coverage at its first end and, falling, from its second, or 1 (2).
    """
    # whole vectors: what a capsule does not touch does not change
    wide = min(alpha.shape[1], (f1 - f0 + LANES - 1) // LANES * LANES)
    f0 = min(f0, alpha.shape[1] - wide)
    f1 = f0 + wide
    facts = (
        seg[0], seg[1], seg[2], seg[3], seg[4], seg[5], seg[6], seg[7], seg[8], seg[9], seg[10], seg[11], seg[12], seg[13], seg[14],
        seg[15], seg[16],
    )  # fmt: skip
    x, dy = np.float32(f0) + HALF - seg[0], np.float32(row) + HALF - seg[1]
    towards, shining = (sun[0], sun[1], sun[2]), (head[0], head[1], head[2])
    cover, depth, right, down = (
        alpha[row, f0:f1],
        inverse[row, f0:f1],
        free[0][row, f0:f1],
        free[1][row, f0:f1],
    )
    if planes.shape[0] == 1:
        lit, beam, plane = _six(light[0]), (heads[0, 0], heads[0, 1]), planes[0, row, f0:f1]
        if seg[10] > F0:
            _under_grey(x, dy, facts, lit, beam, towards, shining, cover, depth, plane)
        else:
            _mingle_grey(x, dy, facts, lit, beam, towards, shining, cover, depth, right, down, plane)
        return
    three = (_six(light[0]), _six(light[1]), _six(light[2]))
    beams = ((heads[0, 0], heads[0, 1]), (heads[1, 0], heads[1, 1]), (heads[2, 0], heads[2, 1]))
    red, green, blue = planes[0, row, f0:f1], planes[1, row, f0:f1], planes[2, row, f0:f1]
    if seg[10] > F0:
        _under_colour(x, dy, facts, three, beams, towards, shining, cover, depth, red, green, blue)
    else:
        _mingle_colour(
            x, dy, facts, three, beams, towards, shining, cover, depth, right, down, red, green, blue
        )


@kernel
def draw_capsule(p0, p1, r0, r1, light, heads, sun, head, optics, size, scratch, free, seg, spans):
    """Draw a tapered capsule into its object's scratch planes.

    Args:
        p0: (3,) one end, camera coordinates, metres.
        p1: (3,) the other end.
        r0: Radius at ``p0``.
        r1: Radius at ``p1``.
        light: (C, 6) radiance: constant, gradient along camera x, y, z, from the sun at normal incidence, emitted.
        heads: (C, 2) radiance from the ego's beam at normal incidence at ``p0``, and its change towards ``p1``.
        sun: (3,) float32 towards the sun, camera coordinates.
        head: (3,) float32 towards the ego's lamps.
        optics: (focal, cx, cy).
        size: (height, width).
        scratch: (planes, alpha, inverse depth).
        free: (H, W) float32 twice: the side of each pixel that the object leaves free, to the right and down; what is not covered yet
            may hold anything. Not touched where primitives are drawn strictly front to back.
        seg: (17,) float32 work space; [10] is 1 where primitives are drawn strictly front to back, posts with flat ends.
        spans: What the object covers, extended by ``grow``.
    """
    focal, cx, cy = optics
    height, width = size
    planes, alpha, inverse = scratch
    x0, y0, z0, x1, y1, z1 = p0[0], p0[1], p0[2], p1[0], p1[1], p1[2]
    if z0 < NEAR_M and z1 < NEAR_M:
        return
    if z0 < NEAR_M or z1 < NEAR_M:
        t = (NEAR_M - z0) / (z1 - z0)
        x, y, r = x0 + t * (x1 - x0), y0 + t * (y1 - y0), r0 + t * (r1 - r0)
        if z0 < NEAR_M:
            x0, y0, z0, r0 = x, y, NEAR_M, r
        else:
            x1, y1, z1, r1 = x, y, NEAR_M, r
    u0, v0, q0 = cx + focal * x0 / z0, cy + focal * y0 / z0, focal * r0 / z0
    u1, v1, q1 = cx + focal * x1 / z1, cy + focal * y1 / z1, focal * r1 / z1
    top = max(-1.0, min(v0 - q0, v1 - q1) - 0.5)
    bottom = min(height + 1.0, max(v0 + q0, v1 + q1) + 0.5)
    left = max(-1.0, min(u0 - q0, u1 - q1) - 0.5)
    right = min(width + 1.0, max(u0 + q0, u1 + q1) + 0.5)
    row0, row1 = max(0, int(math.floor(top))), min(height, int(math.ceil(bottom)))
    a, b = max(0, int(math.floor(left))), min(width, int(math.ceil(right)))
    if row1 <= row0 or b <= a:
        return
    length2 = (u1 - u0) ** 2 + (v1 - v0) ** 2
    seg[0], seg[1], seg[2], seg[3] = u0, v0, u1 - u0, v1 - v0
    seg[4] = 1.0 / max(length2, 1e-6)
    seg[5], seg[6] = q0, q1 - q0
    seg[7], seg[8] = 1 / z0, 1 / z1 - 1 / z0
    seg[9] = min(0.5 * (r0 + r1), 0.9 * min(z0, z1))
    seg[13] = min(MINGLE_SHARE * seg[9], MINGLE_PX * max(z0, z1) / focal) + MINGLE_M
    _cut_ends(seg, x1 - x0, y1 - y0, z1 - z0, q0, q1)
    _mean_light(seg, sun, head)
    for row in range(row0, row1):
        f0, f1 = _span(u0, v0, q0, u1, v1, q1, row, a, b)
        if f1 > f0:
            _fill(row, f0, f1, seg, light, heads, sun, head, planes, alpha, inverse, free)
            grow(spans, row, f0, f1)
