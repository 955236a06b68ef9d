"""Clouds on the rendered sky: the difference that they make, at nodes a few pixels apart, added where nothing stands before it."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel
from pedcross_env.camera.kernels.lighting import ENV_BETA, sky_radiance
from pedcross_env.camera.kernels.rows import free_row

__all__ = ["add_clouds", "cloud_row", "cloudy_rows"]

LUMA = (0.2126, 0.7152, 0.0722)
FOG_LAYER_M = 150.0  # that veils the sky, as the ground's kernels have it


@kernel
def _look_up(texture, x, y, sine, found):
    """Read the texture in the direction (x, y) of a ray over the ground, bilinear; see camera.clouds."""
    rows, columns = texture.shape[1], texture.shape[2]
    diamond = y / (abs(x) + abs(y) + 1e-12)
    angle = diamond if x >= 0.0 else 2.0 - diamond
    if angle < 0.0:
        angle += 4.0
    p, q = angle * (0.25 * columns), min(max(sine, 0.0), 1.0) * (rows - 1)
    i, j = int(p), min(int(q), rows - 2)
    s, t = p - i, q - j
    i %= columns
    k = (i + 1) % columns
    for c in range(2):
        low = texture[c, j, i] + s * (texture[c, j, k] - texture[c, j, i])
        high = texture[c, j + 1, i] + s * (texture[c, j + 1, k] - texture[c, j + 1, i])
        found[c] = low + t * (high - low)


@kernel
def _fill(texture, white, rotation, env, optics, step, j, first, last, nodes, work):
    """Fill columns first * step to last * step of one row with what clouds add to the sky's radiance, linear between nodes."""
    focal, cx, cy = optics
    found, before, here = work[:2], work[2:5], work[5:8]
    v = (j * step - cy) / focal
    channels = nodes.shape[0]
    for i in range(first, last + 1):
        u = (i * step - cx) / focal
        x = rotation[0, 0] * u + rotation[1, 0] * v + rotation[2, 0]
        y_left = rotation[0, 1] * u + rotation[1, 1] * v + rotation[2, 1]
        z = rotation[0, 2] * u + rotation[1, 2] * v + rotation[2, 2]
        sine = z / math.sqrt(1.0 + u * u + v * v)
        here[:] = 0.0
        if sine > 0.0:
            _look_up(texture, x, y_left, sine, found)
            seen = math.exp(-env[ENV_BETA] * FOG_LAYER_M / max(sine, 0.02))
            luminance = 0.0
            for c in range(3):
                luminance += LUMA[c] * sky_radiance(sine, env, c)
            for c in range(3):
                value = sky_radiance(sine, env, c)
                tinted = max(0.0, value + found[1] * (white[c] * luminance - value))
                more = seen * (found[0] * tinted - value)
                if channels == 3:
                    here[c] = more
                else:
                    here[0] += LUMA[c] * more
        for c in range(channels):
            if i > first:
                slope = (here[c] - before[c]) / step
                for k in range(step):
                    nodes[c, j, (i - 1) * step + k] = np.float32(before[c] + slope * (k + 0.5))
            before[c] = here[c]


@kernel
def _know(a, b, rotation, env, optics, clouds, j):
    """Fill a row of nodes between columns a and b, where it is not known yet."""
    texture, white, step, nodes, known, work = clouds
    first, last = a // step, (b + step - 1) // step
    low, high = known[j, 0], known[j, 1]
    if low == high:
        low = high = first
    if first < low:
        _fill(texture, white, rotation, env, optics, step, j, first, low, nodes, work)
        low = first
    if last > high:
        _fill(texture, white, rotation, env, optics, step, j, high, last, nodes, work)
        high = last
    known[j, 0], known[j, 1] = low, high


@kernel
def _add_between(low, high, part, free, piece):
    """Add what lies between two rows of nodes to the share that is free."""
    for i in range(piece.shape[0]):
        piece[i] += free[i] * (low[i] + part * (high[i] - low[i]))


@kernel
def cloudy_rows(rotation, optics, height, width):
    """How many of the image's rows have clouds: down to the lowest that looks above the horizon at either edge."""
    focal, cx, cy = optics
    tilt = -rotation[0, 2] / rotation[1, 2]
    middle = cy - focal * rotation[2, 2] / rotation[1, 2]
    return min(height, int(max(middle - tilt * cx, middle + tilt * (width - cx))) + 1)


@kernel
def cloud_row(row, a, b, free, rotation, env, optics, clouds, out):
    """Add clouds between columns a and b of one row; see ``add_clouds``."""
    step, nodes = clouds[2], clouds[3]
    at = (row + 0.5) / step
    k = int(at)
    for j in range(k, k + 2):
        _know(a, b, rotation, env, optics, clouds, j)
    part = np.float32(at - k)
    for c in range(out.shape[0]):
        _add_between(nodes[c, k, a:b], nodes[c, k + 1, a:b], part, free[a:b], out[c, row, a:b])


@entry
def add_clouds(out, alpha, rotation, env, optics, clouds, free):
    """Add clouds to the sky.

    Args:
        out: (C, H, W) radiance or luminance with the plain sky in it.
        alpha: (H, W) share of each pixel that objects cover.
        rotation: World to camera.
        env: (ENV_SIZE,) see kernels.lighting.
        optics: Focal length, cx, cy.
        clouds: (their texture (2, rows, columns) of camera.clouds.cloud_texture; (3,) their colour, of luminance 1; pixels between
            nodes; what they add in every such row, (C, H // step + 2, columns in whole steps), filled where it is needed and not known;
            (H // step + 2, 2) int32, from which step to which that is known of a row for this light and rotation; (8,) float64 work space).
        free: (W,) float32 work space.
    """
    for row in range(cloudy_rows(rotation, optics, out.shape[1], out.shape[2])):
        a, b = free_row(alpha[row], free)
        if b > a:
            cloud_row(row, a, b, free, rotation, env, optics, clouds, out)
