"""Tapered capsules (limbs, trunks, poles) and spheres (heads, leaves)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from pedcross_env.camera.kernels.polygons import NEAR_M, grow
from pedcross_env.camera.kernels.rows import F0, F1, HALF, merge_row

__all__ = ["draw_capsule"]


@njit(cache=True)
def _shape_row(xs, y, seg, alpha, along, nx, ny, nz):
    """Coverage, position along the axis and normal of a tapered capsule.

    seg: (u0, v0, du, dv, 1/len^2, r0, dr, taper) float32 in pixels.
    """
    u0, v0, du, dv, inv, r0, dr = seg[0], seg[1], seg[2], seg[3], seg[4], seg[5], seg[6]
    dy = y - v0
    for i in range(xs.shape[0]):
        dx = xs[i] - u0
        t = max(F0, min(F1, (dx * du + dy * dv) * inv))
        px, py = dx - t * du, dy - t * dv
        r = r0 + t * dr
        d = np.sqrt(px * px + py * py)
        outer = max(F0, min(F1, r - d + HALF))
        inner = max(F0, min(F1, r + d + HALF))
        alpha[i] = max(F0, outer + inner - F1)
        along[i] = t
        scale = F1 / max(r, d + np.float32(1e-6))
        nx[i], ny[i] = px * scale, py * scale
        nz[i] = -np.sqrt(max(F0, F1 - nx[i] * nx[i] - ny[i] * ny[i]))


@njit(cache=True)
def _shade_row(along, nx, ny, nz, base, gx, gy, gz, sun, sx, sy, sz, head, head_slope, hx, hy, hz, out):
    """Radiance in one channel: linear light field, the sun and the ego's beam."""
    for i in range(out.shape[0]):
        field = max(F0, base + gx * nx[i] + gy * ny[i] + gz * nz[i])
        direct = sun * max(F0, sx * nx[i] + sy * ny[i] + sz * nz[i])
        beam = (head + head_slope * along[i]) * max(F0, hx * nx[i] + hy * ny[i] + hz * nz[i])
        out[i] = field + direct + beam


@njit(cache=True)
def _inverse_row(along, nz, i0, di, radius, out):
    for i in range(out.shape[0]):
        centre = i0 + di * along[i]
        out[i] = centre / (F1 + radius * nz[i] * centre)


@njit(cache=True)
def draw_capsule(p0, p1, r0, r1, albedo_light, head_ends, sun_direction, head_direction, optics, xs, size, scratch, buf, box):
    """Draw a tapered capsule into its object's scratch planes.

    Args:
        p0: (3,) one end, camera coordinates, metres.
        p1: (3,) the other end.
        r0: Radius at ``p0``.
        r1: Radius at ``p1``.
        albedo_light: (C, 5) radiance: constant, gradient along camera x, y, z, and from the sun at normal incidence.
        head_ends: (C, 2) radiance from the ego's beam at normal incidence at both ends.
        sun_direction: (3,) towards the sun, camera coordinates.
        head_direction: (3,) towards the ego's lamps.
        optics: (focal, cx, cy).
        xs: (W,) pixel centres.
        size: (height, width).
        scratch: (planes, alpha, inverse depth).
        buf: (24, W) work space.
        box: Bounding box to extend.
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
    seg = np.empty(7, np.float32)
    seg[0], seg[1], seg[2], seg[3] = u0, v0, u1 - u0, v1 - v0
    seg[4] = 1.0 / max(length2, 1e-6)
    seg[5], seg[6] = q0, q1 - q0
    i0, di = np.float32(1 / z0), np.float32(1 / z1 - 1 / z0)
    radius = np.float32(min(0.5 * (r0 + r1), 0.9 * min(z0, z1)))
    s, h = sun_direction, head_direction
    for row in range(row0, row1):
        f0, f1 = _span(u0, v0, q0, u1, v1, q1, row, a, b)
        n = f1 - f0
        if n <= 0:
            continue
        _shape_row(xs[f0:f1], np.float32(row + 0.5), seg, buf[0, :n], buf[1, :n], buf[8, :n], buf[9, :n], buf[10, :n])
        _inverse_row(buf[1, :n], buf[10, :n], i0, di, radius, buf[2, :n])
        for c in range(planes.shape[0]):
            k = albedo_light[c]
            _shade_row(
                buf[1, :n], buf[8, :n], buf[9, :n], buf[10, :n], k[0], k[1], k[2], k[3], k[4], s[0], s[1], s[2],
                head_ends[c, 0], head_ends[c, 1] - head_ends[c, 0], h[0], h[1], h[2], buf[4 + c, :n],
            )  # fmt: skip
        merge_row(
            buf[4 : 4 + planes.shape[0], :n], buf[0, :n], buf[2, :n],
            planes[:, row, f0:f1], alpha[row, f0:f1], inverse[row, f0:f1], buf[12:14, :n],
        )  # fmt: skip
    grow(box, a, b, row0, row1)


@njit(cache=True)
def _span(u0, v0, q0, u1, v1, q1, row, a, b):
    """Columns of a row that the capsule can touch: its two discs and the band between them."""
    y = row + 0.5
    du, dv = u1 - u0, v1 - v0
    reach = max(q0, q1) + 1.0
    low, high = 1e9, -1e9
    if abs(dv) < 1e-6:
        low, high = min(u0, u1) - reach, max(u0, u1) + reach
    else:
        slant = reach * math.sqrt(du * du + dv * dv) / abs(dv)
        ta = min(1.0, max(0.0, (y - reach - v0) / dv))
        tb = min(1.0, max(0.0, (y + reach - v0) / dv))
        xa, xb = u0 + ta * du, u0 + tb * du
        pad = min(reach, slant)
        low, high = min(xa, xb) - pad, max(xa, xb) + pad
    return max(a, int(math.floor(max(low, -1.0)))), min(b, int(math.ceil(min(high, b + 1.0))))
