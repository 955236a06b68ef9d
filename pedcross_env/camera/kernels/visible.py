"""Which parts of upright walls are seen, exactly: every wall less all that stand before it, as convex polygons in the image.

Shares of a pixel that are seen add up to what the walls cover together, whatever their order, and change smoothly with the camera.
"""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.jit import INT, allocating_kernel, inlined, kernel
from pedcross_env.camera.kernels.polygons import project_clipped

__all__ = ["MAX_PARTS", "move_outlines", "outline_walls", "visible_parts", "visible_work"]

MAX_SIDES, MAX_PARTS = 20, 48  # of one part; of one wall
TOUCH_M = 1e-3  # walls that pass through each other by no more only touch
TOUCH_PX = 1e-7
OVERLAP_M = 0.3  # of houses in two layers
LEAST_PX2 = 1e-9  # smaller parts are rounding


@allocating_kernel
def visible_work(walls):
    """Allocate outlines (corners, their number, bounds, which are seen at all) and the parts of one wall (corners, their number)."""
    return (
        np.empty((walls, MAX_SIDES, 2)), np.zeros(walls, np.int64), np.empty((walls, 4)), np.empty(walls, np.int64),
        np.empty((MAX_PARTS, MAX_SIDES, 2)), np.zeros(MAX_PARTS, np.int64), np.empty((2, MAX_SIDES, 2)), np.empty((4, 3)),
        np.empty((2, MAX_SIDES, 2)), np.empty((MAX_PARTS, 4)),
    )  # fmt: skip


@kernel
def outline_walls(panels, row, slab, rotation, camera, optics, size, work):
    """Project the walls of one row of houses, or what of them is in ``slab``, that face the camera and reach the image.

    Returns their number. ``slab`` is where the layer starts and ends, see scene.draw_scene; a little more of the houses is taken
    before its start, so that nothing shows through where those nearer by end.
    """
    outlines, sides, bounds, seen, _, _, _, corners3, _, _ = work
    focal, cx, cy = optics
    count = 0
    for i in range(panels.shape[0]):
        p = panels[i]
        dx, dy, dz = p[0] - camera[0], p[1] - camera[1], p[2] - camera[2]
        # the outward normal is axis x up, so that a panel is seen counter-clockwise
        if p[29] != row or dx * p[4] - dy * p[3] >= -1e-6:
            continue
        first, last = _within(p, slab[row] - OVERLAP_M, slab[2 + row])
        if last <= first:
            continue
        for c in range(4):
            s = last if c in (1, 2) else first
            z = dz + p[7] if c >= 2 else dz
            x, y = dx + s * p[3], dy + s * p[4]
            for k in range(3):
                corners3[c, k] = rotation[k, 0] * x + rotation[k, 1] * y + rotation[k, 2] * z
        n = project_clipped(corners3, INT(4), focal, cx, cy, outlines[i])
        if n < 3:
            continue
        _bound(outlines[i], n, bounds[i])
        b = bounds[i]
        if b[2] <= 0 or b[3] <= 0 or b[0] >= size[1] or b[1] >= size[0]:
            continue
        b[0], b[1], b[2], b[3] = max(b[0], 0.0), max(b[1], 0.0), min(b[2], size[1]), min(b[3], size[0])
        sides[i] = n
        seen[count] = i
        count += 1
    return count


@kernel
def move_outlines(count, window, work):
    """Bring the outlines of the walls that are seen into the coordinates of a window of the image: its first row and column come first."""
    outlines, sides, bounds, seen, _, _, _, _, _, _ = work
    top, left = window[0], window[1]
    for k in range(count):
        i = seen[k]
        for c in range(sides[i]):
            outlines[i, c, 0] -= left
            outlines[i, c, 1] -= top
        b = bounds[i]
        b[0], b[1], b[2], b[3] = b[0] - left, b[1] - top, b[2] - left, b[3] - top


@inlined
def _within(panel, low, high):
    """Where along a wall, in metres from its start, x is between two values."""
    if abs(panel[3]) < 1e-9:
        return 0.0, panel[6] if low <= panel[0] < high else 0.0
    a, b = (low - panel[0]) / panel[3], (high - panel[0]) / panel[3]
    return max(0.0, min(a, b)), min(panel[6], max(a, b))


@kernel
def _bound(corners, count, out):
    """Fill least and greatest column and row: (left, top, right, bottom)."""
    out[0] = out[2] = corners[0, 0]
    out[1] = out[3] = corners[0, 1]
    for i in range(1, count):
        out[0], out[2] = min(out[0], corners[i, 0]), max(out[2], corners[i, 0])
        out[1], out[3] = min(out[1], corners[i, 1]), max(out[3], corners[i, 1])


@inlined
def _area2(corners, count):
    """Twice the signed area."""
    total = 0.0
    for i in range(1, count - 1):
        ax, ay = corners[i, 0] - corners[0, 0], corners[i, 1] - corners[0, 1]
        bx, by = corners[i + 1, 0] - corners[0, 0], corners[i + 1, 1] - corners[0, 1]
        total += ax * by - ay * bx
    return total


@kernel
def _push(x, y, n, out):
    """Append a corner unless it is the one before: edges without length have no direction; return the number of corners."""
    if n == MAX_SIDES or (n > 0 and abs(out[n - 1, 0] - x) + abs(out[n - 1, 1] - y) < TOUCH_PX):
        return n
    out[n, 0], out[n, 1] = x, y
    return n + 1


@kernel
def _half(corners, count, a, b, c, out):
    """Keep of a convex polygon what a x + b y + c >= 0 holds for; return its number of corners."""
    n = INT(0)
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        x0, y0, x1, y1 = corners[i, 0], corners[i, 1], corners[j, 0], corners[j, 1]
        d0, d1 = a * x0 + b * y0 + c, a * x1 + b * y1 + c
        if d0 >= 0:
            n = _push(x0, y0, n, out)
        if (d0 >= 0) != (d1 >= 0):
            t = d0 / (d0 - d1)
            n = _push(x0 + t * (x1 - x0), y0 + t * (y1 - y0), n, out)
    while n > 1 and abs(out[n - 1, 0] - out[0, 0]) + abs(out[n - 1, 1] - out[0, 1]) < TOUCH_PX:
        n -= 1
    return n


@kernel
def _reach(of, line):
    """How far a wall reaches before another one's plane, and behind it, metres."""
    x, y = of[0] - line[0], of[1] - line[1]
    first = x * line[4] - y * line[3]
    last = first + of[6] * (of[3] * line[4] - of[4] * line[3])
    return max(0.0, first, last), max(0.0, -first, -last)


@kernel
def _passing(p, q, rotation, camera, optics, corners, count, out):
    """Keep of wall q's outline where wall p, which passes through it, is behind it; return the number of corners."""
    focal, cx, cy = optics
    side = q[4] * p[3] - q[3] * p[4]  # by how much p comes forward per metre
    along = -((p[0] - q[0]) * q[4] - (p[1] - q[1]) * q[3]) / side
    x, y = p[0] + along * p[3] - camera[0], p[1] + along * p[4] - camera[1]
    # the upright plane through the camera and the line where they meet: its normal in the world, towards p's end behind q
    sense = 1.0 if (y * p[3] - x * p[4]) * side < 0 else -1.0
    nx, ny = sense * y, -sense * x
    a = (rotation[0, 0] * nx + rotation[0, 1] * ny) / focal
    b = (rotation[1, 0] * nx + rotation[1, 1] * ny) / focal
    c = rotation[2, 0] * nx + rotation[2, 1] * ny - a * cx - b * cy
    return _half(corners, count, a, b, c, out)


@kernel
def _before(i, j, panels, rotation, camera, optics, work):
    """Return where wall j hides what is behind wall i's image: the number of corners, filled into the work space; 0: nowhere."""
    outlines, sides, _, _, _, _, _, _, hull, _ = work
    p, q = panels[i], panels[j]
    before_q, behind_q = _reach(p, q)
    before_p, behind_p = _reach(q, p)
    hides, hidden = min(before_q, behind_p), min(behind_q, before_p)
    if min(hides, hidden) > TOUCH_M:
        return _passing(p, q, rotation, camera, optics, outlines[j], sides[j], hull[0])
    if hidden < hides or (hides == hidden and i < j):
        return 0
    for k in range(sides[j]):
        hull[0, k, 0], hull[0, k, 1] = outlines[j, k, 0], outlines[j, k, 1]
    return sides[j]


@kernel
def _apart(corners, count, hull, sides):
    """Whether a convex polygon lies beyond one of the edges of another."""
    for e in range(sides):
        f = e + 1 if e + 1 < sides else 0
        x, y = hull[e, 0], hull[e, 1]
        a, b = hull[f, 1] - y, x - hull[f, 0]
        touch = TOUCH_PX * (abs(a) + abs(b))
        if touch < TOUCH_PX * TOUCH_PX:
            continue
        i = 0
        while i < count and a * (corners[i, 0] - x) + b * (corners[i, 1] - y) <= touch:
            i += 1
        if i == count:
            return True
    return False


@kernel
def _cut_out(part, parts, hull, sides, work):
    """Replace one part by what a convex polygon leaves of it; return the number of parts."""
    _, _, _, _, corners, counts, rest, _, _, boxes = work
    now, n = 0, counts[part]
    for i in range(n):
        rest[0, i, 0], rest[0, i, 1] = corners[part, i, 0], corners[part, i, 1]
    parts -= 1  # the last takes the place of the one that is cut
    for i in range(counts[parts]):
        corners[part, i, 0], corners[part, i, 1] = corners[parts, i, 0], corners[parts, i, 1]
    counts[part] = counts[parts]
    for k in range(4):
        boxes[part, k] = boxes[parts, k]
    for e in range(sides):
        f = e + 1 if e + 1 < sides else 0
        x, y = hull[e, 0], hull[e, 1]
        a, b = hull[f, 1] - y, x - hull[f, 0]
        if abs(a) + abs(b) < TOUCH_PX:
            continue
        c = -a * x - b * y
        i = 0
        while i < n and a * rest[now, i, 0] + b * rest[now, i, 1] + c >= 0.0:
            i += 1
        if i == n:  # nothing of it is beyond this edge
            continue
        m = _half(rest[now], n, -a, -b, -c, corners[parts])
        if m >= 3 and abs(_area2(corners[parts], m)) > LEAST_PX2:
            counts[parts] = m
            _bound(corners[parts], m, boxes[parts])
            parts += 1
        n = _half(rest[now], n, a, b, c, rest[1 - now])
        now = 1 - now
        if n < 3:
            break
    return parts


@kernel
def visible_parts(which, seen_count, panels, rotation, camera, optics, work):
    """Find what is seen of one wall: disjoint convex polygons in the work space; return their number.

    Args:
        which: Index of the panel.
        seen_count: From ``outline_walls``.
        panels: (P, PANEL_SIZE).
        rotation: (3, 3) world to camera.
        camera: (3,) its position.
        optics: (focal, cx, cy).
        work: From ``visible_work``.
    """
    outlines, sides, bounds, seen, corners, counts, _, _, hull, boxes = work
    counts[0] = sides[which]
    for i in range(counts[0]):
        corners[0, i, 0], corners[0, i, 1] = outlines[which, i, 0], outlines[which, i, 1]
    parts = INT(1)
    left, top, right, bottom = bounds[which, 0], bounds[which, 1], bounds[which, 2], bounds[which, 3]
    boxes[0, 0], boxes[0, 1], boxes[0, 2], boxes[0, 3] = left, top, right, bottom
    for k in range(seen_count):
        other = seen[k]
        o = bounds[other]
        if other == which or o[0] >= right or o[2] <= left or o[1] >= bottom or o[3] <= top:
            continue
        n = _before(which, other, panels, rotation, camera, optics, work)
        if n < 3:
            continue
        part = parts - 1
        cut = False
        while part >= 0:
            b = boxes[part]
            if (
                o[0] < b[2] and o[2] > b[0] and o[1] < b[3] and o[3] > b[1] and parts + n <= MAX_PARTS
                and not _apart(corners[part], counts[part], hull[0], n) and not _apart(hull[0], n, corners[part], counts[part])
            ):  # fmt: skip
                parts = _cut_out(part, parts, hull[0], n, work)
                cut = True
            part -= 1
        if parts == 0:
            break
        if cut:
            left, top, right, bottom = boxes[0, 0], boxes[0, 1], boxes[0, 2], boxes[0, 3]
            for p in range(1, parts):
                left, top = min(left, boxes[p, 0]), min(top, boxes[p, 1])
                right, bottom = max(right, boxes[p, 2]), max(bottom, boxes[p, 3])
    return parts
