"""What a wet road mirrors, taken from the rendered picture.

A flat mirror shows an object of inverse depth q at row v as far below the road's own row for that depth as v lies above it, and
the sky upside down about the horizon. The film on asphalt is no flat mirror: slopes of root mean square s tilt the mirrored
ray by 2 s. Along the line of sight that smears the picture by 2 s f pixels of what is high above the road and by less of what
stands on it (a foot touches its mirror image); across it by 2 s times the sine of the grazing angle. Slopes that face the
camera are seen better than those turned away, so that lights stretch towards it.

All this happens on a grid of half the picture's rows and columns: what asphalt mirrors is no sharper.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.jit import entry, kernel

__all__ = ["FILM", "GRID_PLANES", "mirror_in_road"]

FILM = 0.6  # share of a soaked road's surface that is smooth water
LEAST_ROWS = 1.5  # of blur, on the grid: with less of it mirrored edges would jump from row to row
TOWARDS, AWAY = 1.3, 0.7  # of the blur: towards the camera, away from it
UNKNOWN = np.float32(
    1e-3
)  # weight of the horizon's light, which fills in where the picture shows nothing to mirror
SCALES = 5  # of the blur across: spacings 1, 2, 4, 8, 16
SKY, GROUND = 0, -1
# planes of the grid: light of things and of the sky (3 each), their numbers, inverse depth; light mirrored (3), its weight, its cover,
# inverse depth of what is mirrored
THINGS, FREE, COUNT, COUNT_FREE, INVERSE, LIGHT, WEIGHT, COVER, NEAR, GRID_PLANES = (
    0,
    3,
    6,
    7,
    8,
    9,
    12,
    13,
    14,
    15,
)
F0, F1, HALF = np.float32(0), np.float32(1), np.float32(0.5)


@kernel
def _things_of(upper, lower, ids_upper, ids_lower, line):
    for i in range(line.shape[0]):
        a, b = ids_upper[i], ids_lower[i]
        line[i] = (upper[i] if a != GROUND and a != SKY else F0) + (
            lower[i] if b != GROUND and b != SKY else F0
        )


@kernel
def _sky_of(upper, lower, ids_upper, ids_lower, line):
    for i in range(line.shape[0]):
        line[i] = (upper[i] if ids_upper[i] == SKY else F0) + (lower[i] if ids_lower[i] == SKY else F0)


@kernel
def _fold(line, out):
    for j in range(out.shape[0]):
        out[j] = line[2 * j] + line[2 * j + 1]


@kernel
def _shrink(out, inverse, ids, grid, lowest_sky, line, ones):
    """Gather light, numbers and inverse depths of things and, down to a row, of the sky, two by two pixels."""
    channels, rows = out.shape[0], grid.shape[1]
    for i in range(ones.shape[0]):
        ones[i] = F1
    for row in range(rows):
        k, m = 2 * row, 2 * row + 1
        above, below = ids[k], ids[m]
        _things_of(ones, ones, above, below, line)
        _fold(line, grid[COUNT, row])
        _things_of(inverse[k], inverse[m], above, below, line)
        _fold(line, grid[INVERSE, row])
        for c in range(channels):
            _things_of(out[c, k], out[c, m], above, below, line)
            _fold(line, grid[THINGS + c, row])
        if row > lowest_sky:
            _clear(grid[COUNT_FREE, row])
            continue
        _sky_of(ones, ones, above, below, line)
        _fold(line, grid[COUNT_FREE, row])
        for c in range(channels):
            _sky_of(out[c, k], out[c, m], above, below, line)
            _fold(line, grid[FREE + c, row])


@kernel
def _clear(row):
    for j in range(row.shape[0]):
        row[j] = F0


@kernel
def _throw(grid, channels, horizon, tilt, scale, first):
    """Throw what stands on the road across the horizon, the nearest foremost; each cell spreads over the two rows it falls between."""
    rows, columns = grid.shape[1], grid.shape[2]
    down = 1.0 / (1.0 + tilt * tilt)  # of a way across the horizon, per row of difference: rows and columns
    side = -tilt * down
    for row in range(rows):
        y = 2.0 * row + 1.0
        for j in range(columns):
            number = grid[COUNT, row, j]
            if number <= F0 or number < grid[COUNT_FREE, row, j]:
                continue
            x = 2.0 * j + 1.0
            q = grid[INVERSE, row, j] / number
            away = 2.0 * (scale * q - (y - horizon - tilt * x))
            at, column = 0.5 * (y + away * down) - 0.5, int(0.5 * (x + away * side))
            target = math.floor(at)
            if away < 0.0 or target + 1 < first or target >= rows or column < 0 or column >= columns:
                continue
            later = np.float32(at - target)
            foremost = q * q
            foremost *= foremost
            for e in range(2):
                k = target + e
                share = later if e == 1 else F1 - later
                if k < first or k >= rows:
                    continue
                weight = share * foremost
                grid[WEIGHT, k, column] += weight
                grid[COVER, k, column] += share
                grid[NEAR, k, column] += weight * q
                for c in range(channels):
                    grid[LIGHT + c, k, column] += weight * grid[THINGS + c, row, j] / number


@kernel
def _resolve(weight, cover, near):
    """Turn sums into the cover and the inverse depth of what is mirrored; ``weight`` into what its light is to be scaled by."""
    for j in range(weight.shape[0]):
        known = F1 / weight[j] if weight[j] > F0 else F0
        near[j] *= known
        cover[j] = min(F1, cover[j])
        weight[j] = cover[j] * known


@kernel
def _scale_row(scale, light):
    for j in range(light.shape[0]):
        light[j] *= scale[j]


@kernel
def _open_row(cover, gap):
    for j in range(cover.shape[0]):
        gap[j] = F1 - cover[j]


@kernel
def _add_sky_light(source, number, share, gap, light):
    for j in range(light.shape[0]):
        light[j] += share * gap[j] * source[j] / max(F1, number[j])


@kernel
def _add_sky_cover(number, share, gap, cover):
    for j in range(cover.shape[0]):
        cover[j] += share * gap[j] if number[j] > F0 else F0


@kernel
def _mirror_sky(grid, channels, row, horizon, tilt):
    """Put the sky, upside down about the horizon, behind what a row mirrors; the light stays weighted by the cover."""
    rows, columns = grid.shape[1], grid.shape[2]
    y = 2.0 * row + 1.0
    gap, cover = grid[WEIGHT, row], grid[COVER, row]
    _open_row(cover, gap)
    if tilt == 0.0:
        at = horizon - 0.5 * y - 0.5
        above = math.floor(at)
        for e in range(2):
            share = np.float32(at - above if e == 1 else above + 1 - at)
            k = min(max(above + e, 0), rows - 1)
            for c in range(channels):
                _add_sky_light(grid[FREE + c, k], grid[COUNT_FREE, k], share, gap, grid[LIGHT + c, row])
            _add_sky_cover(grid[COUNT_FREE, k], share, gap, cover)
        return
    across = 1.0 / (1.0 + tilt * tilt)
    for j in range(columns):
        x = 2.0 * j + 1.0
        below = y - horizon - tilt * x
        a = min(max(int(0.5 * (y - 2.0 * below * across)), 0), rows - 1)
        b = min(max(int(0.5 * (x + 2.0 * below * tilt * across)), 0), columns - 1)
        if below > 0.0 and grid[COUNT_FREE, a, b] > F0:
            for c in range(channels):
                grid[LIGHT + c, row, j] += gap[j] * grid[FREE + c, a, b] / grid[COUNT_FREE, a, b]
            cover[j] = F1


@kernel
def _share_row(near, horizon, tilt, y, scale, spread, out):
    """Share that a cell keeps of its own when smeared along the line of sight; what stands on the road less than what is high above."""
    for j in range(out.shape[0]):
        below = max(F1, y - horizon - tilt * np.float32(2 * j + 1))
        high = max(F0, min(F1, F1 - scale * near[j] / below))
        out[j] = F1 / (F1 + np.float32(LEAST_ROWS) + spread * high)


@kernel
def _smear_row(share, before, row):
    for j in range(row.shape[0]):
        row[j] = before[j] + share[j] * (row[j] - before[j])


@kernel
def _smear(grid, channels, first, horizon, tilt, scale, rows_of_slope, shares):
    """Smear light and cover along the columns: recursive means, down towards the camera and back up."""
    rows = grid.shape[1]
    for k in range(2):
        spread = np.float32(rows_of_slope * (TOWARDS if k == 0 else AWAY))
        for step in range(1, rows - first):
            row = first + step if k == 0 else rows - 1 - step
            before = row - 1 if k == 0 else row + 1
            _share_row(
                grid[NEAR, row],
                np.float32(horizon),
                np.float32(tilt),
                np.float32(2 * row + 1),
                np.float32(scale),
                spread,
                shares,
            )
            for c in range(channels):
                _smear_row(shares, grid[LIGHT + c, before], grid[LIGHT + c, row])
            _smear_row(shares, grid[COVER, before], grid[COVER, row])


@kernel
def _mean_row(light, cover, unknown):
    for j in range(light.shape[0]):
        light[j] = (light[j] + UNKNOWN * unknown) / (cover[j] + UNKNOWN)


@kernel
def _spread_row(variance, line, row):
    """Blur a row by a variance in cells squared, in passes of 1 : 2 : 1 at growing distances; ``line`` is work space."""
    n = row.shape[0]
    left = variance
    for k in range(SCALES):
        d = 1 << k
        part = min(F1, left * np.float32(2.0 / (d * d)))
        if part <= F0 or n <= 2 * d:
            return
        left -= part * np.float32(0.5 * d * d)
        a, b = part * np.float32(0.25), F1 - part * HALF
        for j in range(n):
            line[j] = row[j]
        before, after = line[: n - 2 * d], line[2 * d : n]
        middle, target = line[d : n - d], row[d : n - d]
        for j in range(target.shape[0]):
            target[j] = a * (before[j] + after[j]) + b * middle[j]
        for j in range(d):
            row[j] = a * (line[0] + line[j + d]) + b * line[j]
            row[n - 1 - j] = a * (line[n - 1] + line[n - 1 - j - d]) + b * line[n - 1 - j]


@kernel
def _gain_row(y, horizon, tilt, focal, slope, most, alpha, gain):
    """Mirrored share of each pixel's light: Schlick's Fresnel factor at the mean angle of the slopes that are seen."""
    for i in range(gain.shape[0]):
        below = y - horizon - tilt * (np.float32(i) + HALF)
        tangent = max(F0, below) / focal
        squared = tangent * tangent
        away = F1 - min(F1, np.sqrt(squared / (F1 + squared) + slope * slope))
        fifth = away * away
        fifth = fifth * fifth * away
        road = max(F0, F1 - alpha[i]) * max(F0, min(F1, below + HALF))
        gain[i] = road * most * (np.float32(0.02) + np.float32(0.98) * fifth)


@kernel
def _between_rows(low, high, part, line):
    for j in range(line.shape[0]):
        line[j] = low[j] + part * (high[j] - low[j])


@kernel
def _reflect_row(line, gain, out):
    """Mix the mirrored light, a value per two pixels, into a row of the picture."""
    n = line.shape[0]
    near, far = np.float32(0.75), np.float32(0.25)
    out[0] += gain[0] * (line[0] - out[0])
    for j in range(n - 1):
        a, b = line[j], line[j + 1]
        left, right = out[2 * j + 1], out[2 * j + 2]
        out[2 * j + 1] = left + gain[2 * j + 1] * (near * a + far * b - left)
        out[2 * j + 2] = right + gain[2 * j + 2] * (far * a + near * b - right)
    for i in range(2 * n - 1, out.shape[0]):
        out[i] += gain[i] * (line[n - 1] - out[i])


@entry
def mirror_in_road(out, inverse, ids, alpha, horizon, tilt, focal, height_m, film, unknown, grid, work):
    """Add what the wet ground mirrors: F of the light comes from there and 1 - F from the road.

    Fog needs no care: the mirrored picture holds that of the whole way, and the share F of the road's own is taken away.

    Args:
        out: (C, H, W) radiance, changed on the ground only.
        inverse: (H, W) inverse depth of the pixels' owners.
        ids: (H, W) instance ids.
        alpha: (H, W) share of each pixel that objects cover: they do not mirror.
        horizon: Row of the horizon at the image's left edge, continuous.
        tilt: Rows by which it descends per column.
        focal: Pixels, over the cosine of the pitch.
        height_m: Of the camera.
        film: (wetness 0 to 1, root mean square slope of the film).
        unknown: (C,) radiance of the horizon.
        grid: (GRID_PLANES, H // 2, W // 2) work space.
        work: (2, W) work space.
    """
    wetness, slope = film
    channels, height, width = out.shape
    rows = grid.shape[1]
    highest = min(horizon, horizon + tilt * width)
    first = max(0, int(math.floor(0.5 * highest)))
    if first >= rows - 1:
        return
    scale = focal * height_m * math.sqrt(1.0 + tilt * tilt)
    lowest = int(0.5 * max(horizon, horizon + tilt * width)) + 1
    _shrink(out, inverse, ids, grid, lowest, work[0], work[1])
    for row in range(first, rows):
        for plane in range(LIGHT, GRID_PLANES):
            _clear(grid[plane, row])
    _throw(grid, channels, horizon, tilt, scale, first)
    for row in range(first, rows):
        _resolve(grid[WEIGHT, row], grid[COVER, row], grid[NEAR, row])
        for c in range(channels):
            _scale_row(grid[WEIGHT, row], grid[LIGHT + c, row])
        _mirror_sky(grid, channels, row, horizon, tilt)
    columns = grid.shape[2]
    _smear(grid, channels, first, horizon, tilt, scale, slope * focal / math.sqrt(2.0), work[0, :columns])
    for row in range(first, rows):
        below = max(0.0, 2.0 * row + 1.0 - horizon - tilt * 0.5 * width)
        variance = np.float32((slope * below) ** 2)  # of 2 s below, in cells of two pixels
        for c in range(channels):
            _mean_row(grid[LIGHT + c, row], grid[COVER, row], unknown[c])
            _spread_row(variance, work[0, :columns], grid[LIGHT + c, row])
    most = np.float32(FILM * wetness)
    for row in range(max(0, int(highest)), height):
        _gain_row(
            np.float32(row + 0.5), np.float32(horizon), np.float32(tilt), np.float32(focal), np.float32(slope), most, alpha[row], work[1],
        )  # fmt: skip
        at = 0.5 * (row + 0.5) - 0.5
        k = min(max(int(at), first), rows - 2)
        part = np.float32(min(1.0, max(0.0, at - k)))
        for c in range(channels):
            _between_rows(grid[LIGHT + c, k], grid[LIGHT + c, k + 1], part, work[0, :columns])
            _reflect_row(work[0, :columns], work[1], out[c, row])
