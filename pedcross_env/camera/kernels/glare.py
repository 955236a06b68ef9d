"""Light scattered in lens and windscreen: a veil around what is much brighter than the rest, and the sun's disc.

A source of illuminance E at the lens veils what lies at the angle theta from it with the luminance k E / theta^2. With
angles as pixels over the focal length this is k times the source's luminance summed over its pixels, over the squared
distance in pixels: neither the focal length nor the depth enters. The veil is smooth, so it is computed on a coarse grid
and interpolated; sources are gathered cell by cell at their centres of light, so that they move smoothly.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel

__all__ = ["add_sun_disc", "add_veil", "gather_sources", "sky_share"]

F0, F1 = np.float32(0), np.float32(1)


@kernel
def _raise_row(row, top):
    for i in range(row.shape[0]):
        top[i] = max(top[i], row[i])


@entry
def gather_sources(out, luminance, threshold, cell, border, top, sources):
    """Fill (S, 5): column, row and light per channel of what exceeds ``threshold``; return how many there are.

    Light is luminance summed over pixels; the share of it that counts grows from 0 at the threshold, and falls to 0 over
    ``border`` pixels at the image's border, so that no veil vanishes at once where its source leaves the view.
    """
    height, width = luminance.shape
    channels = out.shape[0]
    count = 0
    first = 0
    while first < height:
        bottom = min(height, first + cell)
        for i in range(width):
            top[i] = F0
        for row in range(first, bottom):
            _raise_row(luminance[row], top)
        left = 0
        while left < width and count < sources.shape[0]:
            right = min(width, left + cell)
            bright = False
            for i in range(left, right):
                bright = bright or top[i] > threshold
            if not bright:
                left = right
                continue
            total, at_x, at_y = 0.0, 0.0, 0.0
            for c in range(3):
                sources[count, 2 + c] = 0.0
            for row in range(first, bottom):
                for i in range(left, right):
                    value = luminance[row, i]
                    if value > threshold:
                        excess = value - threshold
                        total += excess
                        at_x += excess * (i + 0.5)
                        at_y += excess * (row + 0.5)
                        share = excess / value
                        for c in range(channels):
                            sources[count, 2 + c] += share * out[c, row, i]
            if total > 0:
                x, y = at_x / total, at_y / total
                inside = min(1.0, min(min(x, width - x), min(y, height - y)) / border)
                for c in range(channels):
                    sources[count, 2 + c] *= inside * inside * (3.0 - 2.0 * inside)
                sources[count, 0], sources[count, 1] = x, y
                count += 1
            left = right
        first = bottom
    return count


@entry
def sky_share(alpha, column, row, radius):
    """Share of a disc in the image that no object covers; a place outside the image counts as its nearest border."""
    height, width = alpha.shape
    column, row = min(max(column, 0.5), width - 0.5), min(max(row, 0.5), height - 0.5)
    free, total = 0.0, 0.0
    for j in range(max(0, int(row - radius - 1)), min(height, int(row + radius + 2))):
        for i in range(max(0, int(column - radius - 1)), min(width, int(column + radius + 2))):
            cover = min(1.0, max(0.0, radius + 0.5 - math.hypot(i + 0.5 - column, j + 0.5 - row)))
            free += cover * max(0.0, 1.0 - alpha[j, i])
            total += cover
    return free / total if total > 0 else 0.0


@entry
def add_sun_disc(out, luminance, alpha, column, row, radius, radiance):
    """Draw a disc of ``radiance`` (3,) behind all objects, its rim a pixel wide; of one channel only ``luminance`` is changed."""
    height, width = luminance.shape
    channels = out.shape[0]
    luma = 0.2126 * radiance[0] + 0.7152 * radiance[1] + 0.0722 * radiance[2]
    for j in range(max(0, int(row - radius - 2)), min(height, int(row + radius + 3))):
        for i in range(max(0, int(column - radius - 2)), min(width, int(column + radius + 3))):
            cover = min(1.0, max(0.0, radius + 0.5 - math.hypot(i + 0.5 - column, j + 0.5 - row)))
            cover *= max(0.0, 1.0 - alpha[j, i])
            luminance[j, i] += np.float32(cover * luma)
            if channels == 3:
                for c in range(3):
                    out[c, j, i] += np.float32(cover * radiance[c])


@kernel
def _spread(sources, count, channels, strength, core, step, nodes):
    """Fill the coarse grid (3, rows, columns), whose nodes lie ``step`` pixels apart."""
    for c in range(channels):
        for j in range(nodes.shape[1]):
            for i in range(nodes.shape[2]):
                nodes[c, j, i] = F0
    squared = core * core
    for k in range(count):
        x, y = np.float32(sources[k, 0] / step), np.float32(sources[k, 1] / step)
        near = np.float32(squared / (step * step))
        for c in range(channels):
            light = np.float32(strength * sources[k, 2 + c] / (step * step))
            for j in range(nodes.shape[1]):
                dy = np.float32(j) - y
                offset = dy * dy + near
                line = nodes[c, j]
                for i in range(line.shape[0]):
                    dx = np.float32(np.int32(i)) - x
                    line[i] += light / (dx * dx + offset)


@kernel
def _add_row(low, high, part, step, line, plane):
    """Interpolate one row of pixels between two rows of nodes and add it."""
    for i in range(line.shape[0]):
        line[i] = low[i] + part * (high[i] - low[i])
    scale = F1 / np.float32(step)
    cell, first = 0, 0
    while first < plane.shape[0]:
        a, slope = line[cell], (line[cell + 1] - line[cell]) * scale
        piece = plane[first : min(plane.shape[0], first + step)]
        for i in range(piece.shape[0]):
            piece[i] += a + slope * (np.float32(np.int32(i)) + np.float32(0.5))
        cell += 1
        first += step


@entry
def add_veil(out, luminance, sources, count, strength, core, step, nodes, line):
    """Add the veil of ``count`` sources to (C, H, W) and to the luminance.

    Args:
        out: Radiance; of one channel it is left alone.
        luminance: (H, W).
        sources: (S, 5) as gather_sources fills them.
        count: How many of them there are.
        strength: k of the module's text, for angles in radians.
        core: Pixels within which the veil no longer rises.
        step: Pixels between nodes.
        nodes: (3, H / step + 2, W / step + 2) work space.
        line: (W / step + 2,) work space.
    """
    channels = out.shape[0]
    height = luminance.shape[0]
    _spread(sources, count, channels, strength, core, step, nodes)
    if channels == 3:
        for j in range(height):
            at = (j + 0.5) / step
            k = int(at)
            part = np.float32(at - k)
            for c in range(3):
                _add_row(nodes[c, k], nodes[c, k + 1], part, step, line, out[c, j])
        for j in range(nodes.shape[1]):  # the luminance of a sum is the sum of the luminances
            for i in range(nodes.shape[2]):
                nodes[0, j, i] = (
                    np.float32(0.2126) * nodes[0, j, i]
                    + np.float32(0.7152) * nodes[1, j, i]
                    + np.float32(0.0722) * nodes[2, j, i]
                )
    for j in range(height):
        at = (j + 0.5) / step
        k = int(at)
        _add_row(nodes[0, k], nodes[0, k + 1], np.float32(at - k), step, line, luminance[j])
