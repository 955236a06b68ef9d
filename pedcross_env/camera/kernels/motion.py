"""How far things move in the picture from one moment to another: bounds for how often the event camera's scene is rendered.

Moments are two: rotations (2, 3, 3) world to camera and origins (2, 3) of the camera, actors (N, 13) float64 at each, of which
the columns below are read.
"""

from __future__ import annotations

import math

from pedcross_env._optics_kernels import bend
from pedcross_env.camera.kernels.jit import entry, kernel

__all__ = ["fastest_in_view", "fastest_beyond"]

X, Y, Z, YAW, LENGTH, WIDTH, HEIGHT = 0, 1, 2, 3, 6, 7, 8
CORNERS_AHEAD = (0.5, -0.5, -0.5, 0.5)  # of a box from above, in order around
CORNERS_LEFT = (0.5, 0.5, -0.5, -0.5)
MARGIN_PX = 1.0
NEAR_M = 0.5  # points nearer than this to the image plane are not followed
NEAR_BOX_M = 1.0  # the same for actors' corners, of which others lie farther away
# Of the interval: flow is that of a moment, since what leaves the picture is not followed beyond.
INSTANT = 1 / 32


@kernel
def _set_feet(actors, spare, feet):
    """Fill (N, 4, 2) ``feet`` with the corners of boxes from above, each with something to spare around."""
    for i in range(actors.shape[0]):
        cosine, sine = math.cos(actors[i, YAW]), math.sin(actors[i, YAW])
        for k in range(4):
            ahead = CORNERS_AHEAD[k] * (actors[i, LENGTH] + 2 * spare[i])
            left = CORNERS_LEFT[k] * (actors[i, WIDTH] + 2 * spare[i])
            feet[i, k, 0] = actors[i, X] + cosine * ahead - sine * left
            feet[i, k, 1] = actors[i, Y] + sine * ahead + cosine * left


@kernel
def _local(rotation, origin, point, out):
    for k in range(3):
        out[k] = (
            rotation[k, 0] * (point[0] - origin[0])
            + rotation[k, 1] * (point[1] - origin[1])
            + rotation[k, 2] * (point[2] - origin[2])
        )


@kernel
def _shift_px(rotation, origin, moved_rotation, moved_origin, optics, lens, point, way, work):
    """Displacement in the picture of a point that goes ``INSTANT`` of ``way``, in pixels; 0 where it is not in view."""
    focal, cx, cy, width, height = optics
    first, second, place = work[0], work[1], work[2]
    _local(rotation, origin, point, first)
    for k in range(3):
        place[k] = point[k] + INSTANT * way[k]
    _local(moved_rotation, moved_origin, place, second)
    if not (first[2] > NEAR_M and second[2] > NEAR_M):
        return 0.0
    x0, y0, seen0 = bend(lens[0], lens[1], first[0] / first[2], first[1] / first[2])
    x1, y1, seen1 = bend(lens[0], lens[1], second[0] / second[2], second[1] / second[2])
    u, v = cx + focal * x0, cy + focal * y0
    inside = -MARGIN_PX < u < width + MARGIN_PX and -MARGIN_PX < v < height + MARGIN_PX
    if not inside or seen0 == 0.0 or seen1 == 0.0:
        return 0.0
    return focal * math.hypot(x1 - x0, y1 - y0)


@kernel
def _first_met(origin, ray, feet, sizes):
    """How many of its lengths away a ray first meets the side of a box (inf: nowhere), and whose."""
    nearest, owner = math.inf, -1
    for i in range(feet.shape[0]):
        for k in range(4):
            x, y = feet[i, k, 0], feet[i, k, 1]
            along_x, along_y = feet[i, (k + 1) % 4, 0] - x, feet[i, (k + 1) % 4, 1] - y
            away_x, away_y = x - origin[0], y - origin[1]
            across = ray[0] * along_y - ray[1] * along_x
            if abs(across) <= 1e-9:
                continue
            reach = (away_x * along_y - away_y * along_x) / across
            share = (away_x * ray[1] - away_y * ray[0]) / across
            above = origin[2] + reach * ray[2] - sizes[i, Z]
            if 0.0 < reach < nearest and 0.0 <= share <= 1.0 and 0.0 <= above <= sizes[i, HEIGHT]:
                nearest, owner = reach, i
    return nearest, owner


@kernel
def _fastest_from(rotations, origins, now, then, optics, lens, edges, side_m, feet, sizes, work):
    """Displacement over INSTANT of the way to the other moment of what is in view, at the fastest."""
    rotation, origin = rotations[now], origins[now]
    moved_rotation, moved_origin = work[:3], work[3]
    point, way, ray, rest = work[4], work[5], work[6], work[7:]
    for k in range(3):
        moved_origin[k] = origin[k] + INSTANT * (origins[then, k] - origin[k])
        for m in range(3):
            moved_rotation[k, m] = rotation[k, m] + INSTANT * (rotations[then, k, m] - rotation[k, m])
    most = 0.0
    for e in range(edges.shape[0]):
        if not math.isfinite(edges[e, 0] + edges[e, 1]):
            continue
        for k in range(3):
            ray[k] = edges[e, 0] * rotation[0, k] + edges[e, 1] * rotation[1, k] + rotation[2, k]
            way[k] = 0.0
        reach = -origin[2] / ray[2] if ray[2] < -1e-6 else math.inf
        side = edges[e, 2]
        if side != 0.0:
            wall = (side * side_m - origin[1]) / ray[1] if abs(ray[1]) > 1e-6 else -1.0
            reach = wall if 0.0 < wall < reach else reach
            met, owner = _first_met(origin, ray, feet[now], sizes)
            if met < reach:
                reach = met
                for k in range(4):
                    for m in range(2):
                        way[m] += 0.25 * (feet[then, owner, k, m] - feet[now, owner, k, m])
        if reach < math.inf:
            for k in range(3):
                point[k] = origin[k] + reach * ray[k]
            shift = _shift_px(rotation, origin, moved_rotation, moved_origin, optics, lens, point, way, rest)
            most = max(most, shift)
    way[2] = 0.0
    for i in range(feet.shape[1]):
        for k in range(4):
            for m in range(2):
                point[m] = feet[now, i, k, m]
                way[m] = feet[then, i, k, m] - point[m]
            for top in range(2):
                point[2] = sizes[i, Z] + top * sizes[i, HEIGHT]
                shift = _shift_px(
                    rotation, origin, moved_rotation, moved_origin, optics, lens, point, way, rest
                )
                most = max(most, shift)
    return most / INSTANT


@entry
def fastest_in_view(rotations, origins, optics, lens, edges, side_m, first, second, spare, feet, work):
    """Return how far what is in view moves, in pixels: the larger of the speeds at both moments, times the interval.

    Args:
        rotations: See the module.
        origins: See the module.
        optics: (focal, cx, cy, width, height) in pixels, float64.
        lens: (number, coefficients) for ``bend``.
        edges: (E, 3) rays at the picture's edges over their depth, and the side that the wall is on; 0: only the road counts.
        side_m: Distance of the facades from the street's middle.
        first: Actors, see the module; as high at the second moment as at the first.
        second: The same actors at the second moment.
        spare: (N,) what each reaches out of its box, in metres.
        feet: (2, N, 4, 2) float64 to work in.
        work: (10, 3) float64 to work in.
    """
    _set_feet(first, spare, feet[0])
    _set_feet(second, spare, feet[1])
    return max(
        _fastest_from(rotations, origins, 0, 1, optics, lens, edges, side_m, feet, first, work),
        _fastest_from(rotations, origins, 1, 0, optics, lens, edges, side_m, feet, first, work),
    )


@kernel
def _standing(rotations, origins, now, then, optics, sides, ahead, px):
    """Raise (P,) ``px`` to how far the nearest that can stand beyond each distance moves in the picture."""
    focal, cx, cy, width, height = optics
    rotation, origin, other = rotations[now], origins[now], rotations[then]
    for row in range(5):
        for column in range(9):
            x, y = (column * width / 8 - cx) / focal, (row * height / 4 - cy) / focal
            across = x * rotation[0, 1] + y * rotation[1, 1] + rotation[2, 1]
            down = -(x * rotation[0, 2] + y * rotation[1, 2] + rotation[2, 2])
            nearness = max(0.0, down / origin[2])  # 1 / m: of the road
            for side_m in sides:
                room = side_m - origin[1]
                nearness = max(nearness, across / room) if room * side_m > 0 else math.inf
            for p in range(ahead.shape[0]):
                near = min(nearness, 1.0 / ahead[p])
                seen_x, seen_y, seen_z = 0.0, 0.0, 0.0
                for k in range(3):
                    ray = x * rotation[0, k] + y * rotation[1, k] + rotation[2, k]
                    way = ray + near * (origin[k] - origins[then, k])
                    seen_x += other[0, k] * way
                    seen_y += other[1, k] * way
                    seen_z += other[2, k] * way
                px[p] = max(px[p], focal * math.hypot(seen_x / seen_z - x, seen_y / seen_z - y))


@entry
def fastest_beyond(
    rotations,
    origins,
    optics,
    sides,
    shear,
    first,
    second,
    spare,
    limbs,
    planes,
    ahead,
    standing,
    moving,
    feet,
    work,
):
    """Raise how far what is beyond planes across the street moves in the picture of a pinhole.

    Args:
        rotations: See the module.
        origins: See the module.
        optics: (focal, cx, cy, width, height) in pixels, float64.
        sides: y in metres of what lines the road on either side.
        shear: How far a shadow falls per metre of height along x and y; (nan, nan): there is none.
        first: Actors, see the module.
        second: The same at the second moment.
        spare: (N,) what each reaches out of its box, in metres.
        limbs: (N,) how far its limbs move besides, in metres.
        planes: (P,) world x.
        ahead: (P,) how far ahead of the camera each is at the least.
        standing: (P,) pixels, raised to the bound for all that stands.
        moving: (P,) the same for actors and their shadows.
        feet: (2, N, 4, 2) float64 to work in.
        work: (4, 3) float64 to work in.
    """
    _standing(rotations, origins, 0, 1, optics, sides, ahead, standing)
    _standing(rotations, origins, 1, 0, optics, sides, ahead, standing)
    _set_feet(first, spare, feet[0])
    _set_feet(second, spare, feet[1])
    one, two, here, there = work[0], work[1], work[2], work[3]
    for i in range(first.shape[0]):
        for k in range(12 if math.isfinite(shear[0]) else 8):  # feet, heads, shadows of heads
            up = 1.0 if 4 <= k < 8 else 0.0
            for m in range(2):
                one[m], two[m] = feet[0, i, k % 4, m], feet[1, i, k % 4, m]
                if k >= 8:
                    one[m] += shear[m] * first[i, HEIGHT]
                    two[m] += shear[m] * second[i, HEIGHT]
            one[2] = first[i, Z] + up * first[i, HEIGHT]
            two[2] = second[i, Z] + up * second[i, HEIGHT]
            _local(rotations[0], origins[0], one, here)
            _local(rotations[1], origins[1], two, there)
            depth = min(here[2], there[2])
            if depth <= NEAR_BOX_M:
                continue
            across, along = there[0] / there[2] - here[0] / here[2], there[1] / there[2] - here[1] / here[2]
            px = optics[0] * (math.hypot(across, along) + limbs[i] / depth)
            for p in range(planes.shape[0]):
                if min(one[0], two[0]) >= planes[p]:
                    moving[p] = max(moving[p], px)
