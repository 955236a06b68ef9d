"""Clouds on the rendered sky: the difference that they make, at nodes some pixels apart, added where nothing stands before it."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel
from pedcross_env.camera.kernels.lighting import ENV_BETA, sky_radiance
from pedcross_env.camera.kernels.rows import F0, F1, free_row

__all__ = ["add_clouds", "cloud_row", "cloudy_rows"]

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
def _node_row(texture, white, rotation, env, optics, y, step, found, nodes, j):
    """Fill one row of nodes with what clouds add to the sky's radiance."""
    focal, cx, cy = optics
    v = (y - cy) / focal
    channels = nodes.shape[0]
    for i in range(nodes.shape[2]):
        u = (i * step - cx) / focal
        x = rotation[0, 0] * u + rotation[1, 0] * v + rotation[2, 0]
        y_left = rotation[0, 1] * u + rotation[1, 1] * v + rotation[2, 1]
        z = rotation[0, 2] * u + rotation[1, 2] * v + rotation[2, 2]
        sine = z / math.sqrt(1.0 + u * u + v * v)
        for c in range(channels):
            nodes[c, j, i] = F0
        if sine <= 0.0:
            continue
        _look_up(texture, x, y_left, sine, found)
        seen = math.exp(-env[ENV_BETA] * FOG_LAYER_M / max(sine, 0.02))
        luminance = 0.0
        for c in range(3):
            luminance += (0.2126, 0.7152, 0.0722)[c] * sky_radiance(sine, env, c)
        for c in range(3):
            value = sky_radiance(sine, env, c)
            tinted = max(0.0, value + found[1] * (white[c] * luminance - value))
            more = seen * (found[0] * tinted - value)
            if channels == 3:
                nodes[c, j, i] = np.float32(more)
            else:
                nodes[0, j, i] += np.float32((0.2126, 0.7152, 0.0722)[c] * more)


@kernel
def _between_rows(low, high, part, line):
    for i in range(line.shape[0]):
        line[i] = low[i] + part * (high[i] - low[i])


@kernel
def _add_row(line, step, first, last, free, plane):
    """Interpolate nodes to the pixels from ``first`` to ``last`` and add them to the share that is free."""
    scale = F1 / np.float32(step)
    while first < last:
        cell = first // step
        end = min(last, (cell + 1) * step)
        slope = (line[cell + 1] - line[cell]) * scale
        value = line[cell] + slope * (np.float32(first - cell * step) + np.float32(0.5))
        piece, share = plane[first:end], free[first:end]
        for i in range(piece.shape[0]):
            piece[i] += share[i] * (value + slope * np.float32(np.int32(i)))
        first = end


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
    texture, white, step, nodes, known, line, found = clouds
    at = (row + 0.5) / step
    k = int(at)
    for j in range(k, k + 2):
        if known[j] == 0:
            _node_row(texture, white, rotation, env, optics, j * step + 0.0, step, found, nodes, j)
            known[j] = 1
    part = np.float32(at - k)
    for c in range(out.shape[0]):
        _between_rows(nodes[c, k], nodes[c, k + 1], part, line)
        _add_row(line, step, a, b, free, out[c, row])


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
            nodes; nodes (C, H // step + 2, W // step + 2), filled where they are needed and not known; (H // step + 2,) uint8, which of
            their rows hold this light and rotation's values; (W // step + 2,) float32 and (2,) float64 work space).
        free: (W,) float32 work space.
    """
    for row in range(cloudy_rows(rotation, optics, out.shape[1], out.shape[2])):
        a, b = free_row(alpha[row], free)
        if b > a:
            cloud_row(row, a, b, free, rotation, env, optics, clouds, out)
