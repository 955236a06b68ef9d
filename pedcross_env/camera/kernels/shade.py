"""How much of a standing thing the sun reaches over the houses, and how large furniture is drawn."""

from __future__ import annotations

import math

from pedcross_env.camera.kernels.jit import entry, inlined, kernel

__all__ = ["shade_heights", "shrink_far", "sunlit_actors", "sunlit_shares"]

SHORT_M = 0.4
NEIGHBOUR_M = 5.0  # to a wall; farther ones are across the street


@inlined
def _ray_to_wall(wall, sun, x, y):
    """Where a ray from (x, y) towards the sun meets a wall's plane: how far on (0: nowhere) and how far along the wall; the
    wall's length and how wide it looks from there."""
    ex, ey = wall[2] - wall[0], wall[3] - wall[1]
    dx, dy = wall[0] - x, wall[1] - y
    turn = ex * sun[1] - ey * sun[0]  # sin of the angle between wall and ray, times the wall's length
    length = math.sqrt(ex * ex + ey * ey)
    if turn == 0.0:
        return 0.0, 0.0, length, 0.0
    return (ex * dy - ey * dx) / turn, (sun[0] * dy - sun[1] * dx) / turn * length, length, abs(turn)


@kernel
def _sunlit_share(walls, sun, x, y, foot, top, half):
    """Share of an upright thing that no wall shades; see ``sunlit_shares``."""
    shaded = 0.0
    for k in range(walls.shape[0]):
        away, along, length, width = _ray_to_wall(walls[k], sun, x, y)
        if away <= 0.0 or away * sun[2] > walls[k, 4] - foot:
            continue
        reach = half * length / width  # the thing's width as the wall sees it
        cover = min(along, length - along) / (2.0 * reach) + 1.0
        if cover <= 0.0:
            continue
        high = (walls[k, 4] - away * sun[2] - foot) / (top - foot)
        shaded = max(shaded, min(1.0, cover) * min(1.0, high))
    return 1.0 - shaded


@entry
def sunlit_shares(walls, sun, places, shares):
    """Fill the share of each upright thing that no wall shades; continuous in where it stands.

    A ray towards the sun meets the wall's plane ``away`` metres on, at ``away * sun[2]`` above its start: the wall shades
    whatever is lower than its top minus that. Beyond a wall's end its shade fades over the thing's own width, so that neighbours
    leave no seam.

    Args:
        walls: (W, 5) float64: ends x0, y0, x1, y1, height.
        sun: (3,) unit vector on the ground towards the sun, tangent of its altitude.
        places: (N, 5) float64: x, y, foot, top, half width.
        shares: (N,) float64, filled: 1 in the sun, 0 in the shade.
    """
    for i in range(places.shape[0]):
        p = places[i]
        shares[i] = _sunlit_share(walls, sun, p[0], p[1], p[2], p[3], p[4])


@entry
def shade_heights(walls, sun, places, overlap, heights):
    """Fill how high up the walls shade what stands at places; see ``sunlit_shares``.

    Args:
        walls: (W, 5). sun: (3,).
        places: (N, 3) float64: x, y, foot.
        overlap: Metres by which walls across the street are taken for longer, so that the shades of neighbours leave no seam.
            What stands out by less than SHORT_M casts no strip of shade: it would be narrower than the way between places.
        heights: (N,) float32, filled: metres above the foot, or below it where nothing is shaded.
    """
    for i in range(places.shape[0]):
        x, y, foot = places[i, 0], places[i, 1], places[i, 2]
        highest = -1.0
        for k in range(walls.shape[0]):
            away, along, length, _ = _ray_to_wall(walls[k], sun, x, y)
            more = overlap if away > NEIGHBOUR_M else 0.0
            if length > SHORT_M and away > 0.0 and -more <= along <= length + more:
                highest = max(highest, walls[k, 4] - away * sun[2] - foot)
        heights[i] = highest


@entry
def sunlit_actors(walls, sun, numbers, shares):
    """Fill the same for actors, (N, 14) as kernels.scene."""
    for i in range(shares.shape[0]):
        a = numbers[i]
        top = a[2] + max(a[8], 0.1)
        shares[i] = _sunlit_share(walls, sun, a[0], a[1], a[2], top, 0.5 * max(a[6], a[7]))


@kernel
def shrink_far(numbers, lasting, camera, range_m, fade_m, out):
    """Copy furniture, (N, 14) as kernels.scene, that shrinks to nothing at ``range_m`` from the camera rather than pop up.

    ``lasting`` (N,) is 1 for what keeps its size at any distance.
    """
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            out[i, k] = numbers[i, k]
        dx, dy = numbers[i, 0] - camera[0], numbers[i, 1] - camera[1]
        scale = max(lasting[i], min(1.0, max(0.0, (range_m - math.sqrt(dx * dx + dy * dy)) / fade_m)))
        for k in range(6, 9):
            out[i, k] *= scale
