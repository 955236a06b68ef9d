"""Coverage of pixels by convex polygons against clipping."""

from __future__ import annotations

import numpy as np
import pytest

from pedcross_env.camera.kernels.jit import entry
from pedcross_env.camera.kernels.polygons import (
    MAX_CORNERS,
    cover_between,
    cover_row,
    slanted_edges,
    upright_borders,
)

WIDTH, HEIGHT = 30, 20


@entry
def _cover(corners, edges, work, out):
    """Cover all rows, as walls are; return how many had two borders only."""
    sides = slanted_edges(corners, corners.shape[0], edges)
    upright = 0
    for row in range(HEIGHT):
        first, second, until = upright_borders(edges, sides, row)
        if until > row:
            a, b = cover_between(edges[first], edges[second], row, WIDTH, work[2])
            upright += 1
        else:
            a, b = cover_row(edges, sides, row, WIDTH, work[0], work[1], work[2])
        for i in range(b - a):
            out[row, a + i] = work[2, i]
    return upright


def _clip(polygon, normal, limit):
    """Keep what normal.p <= limit holds for."""
    kept = []
    for p, q in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        u, v = normal @ p - limit, normal @ q - limit
        if u <= 0:
            kept.append(p)
        if (u <= 0) != (v <= 0):
            kept.append(p + u / (u - v) * (q - p))
    return np.array(kept).reshape(-1, 2)


def _expected(polygon):
    area = np.zeros((HEIGHT, WIDTH))
    for row in range(HEIGHT):
        strip = _clip(_clip(polygon, np.array([0.0, -1.0]), -row), np.array([0.0, 1.0]), row + 1.0)
        for column in range(WIDTH):
            part = _clip(_clip(strip, np.array([-1.0, 0.0]), -column), np.array([1.0, 0.0]), column + 1.0)
            x, y = part[:, 0], part[:, 1]
            area[row, column] = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    return area


POLYGONS = {
    "upright wall": [(8.3, 2.2), (14.6, 3.4), (14.6, 17.7), (8.3, 15.1)],
    "leaning wall": [(3.3, -4.0), (27.6, -9.4), (21.1, 35.7), (6.9, 33.1)],
    "sliver": [(11.2, -3.0), (11.5, -3.0), (11.9, 30.0), (11.6, 30.0)],
    "over both sides": [(-8.0, 1.5), (44.0, 5.5), (44.0, 11.0), (-8.0, 16.5)],
    "left border": [(-2.4, -5.0), (3.7, 30.0), (-9.0, 30.0)],
    "right border": [(33.4, -5.0), (26.7, 30.0), (49.0, 30.0)],
    "right of it": [(33.4, -5.0), (36.7, 30.0), (49.0, 30.0)],
    "within a pixel": [(5.2, 5.3), (5.8, 5.4), (5.5, 5.9)],
    "on the grid": [(4.0, 4.0), (9.0, 4.0), (9.0, 12.0), (4.0, 12.0)],
    "all": [(-5.0, -5.0), (40.0, -5.0), (40.0, 40.0), (-5.0, 40.0)],
}


@pytest.mark.parametrize("turn", [1, -1])
@pytest.mark.parametrize("name", POLYGONS)
def test_a_pixel_is_covered_by_the_area_that_a_polygon_has_in_it(name, turn):
    corners = np.array(POLYGONS[name])[::turn].copy()
    work, out = np.zeros((3, WIDTH + 3), np.float32), np.zeros((HEIGHT, WIDTH))
    upright = _cover(corners, np.empty((MAX_CORNERS, 5)), work, out)
    assert out == pytest.approx(_expected(corners), abs=2e-6)
    assert not work[1].any(), "the work space is left as it was"
    assert (upright > 0) == (name != "within a pixel")
