"""Fronts of houses: where windows, bars, curtains, doors and signs are, and what a coarse pixel sees of them."""

from __future__ import annotations

import numpy as np
import pytest

from pedcross_env.camera.kernels.entrances import entrances_of, hang_signs
from pedcross_env.camera.kernels.facade import PANEL_SIZE
from pedcross_env.camera.kernels.facade_pattern import ground_pattern, pattern_of, upper_pattern
from pedcross_env.camera.kernels.jit import entry
from pedcross_env.camera.scenery.entrances import add_entrance

BAY, STOREY, FLOOR, LENGTH = 3.0, 3.2, 3.6, 24.0
FRAME, BAR = 0.09, 0.06  # metres
FINE = 4e-3


def front() -> np.ndarray:
    """(PANEL_SIZE,) eight bays of windows 1.2 m wide and 1.6 m high."""
    panel = np.zeros(PANEL_SIZE)
    panel[6], panel[7] = LENGTH, 14.0
    panel[11:17] = BAY, STOREY, 0.4, 0.5, 0.25, 77
    panel[18:26] = 1.3, FLOOR, 2 * BAY, 0.7, 0.4, 2.8, 1.0, 13.5
    return panel


@entry
def _covers(panel, s, t, ws, wt, covers):
    """Fill (7, N): stone, trim, pane, shade, accent, a sign's letters and its board beside them."""
    upper, ground = pattern_of(panel)
    entrances = entrances_of(panel)
    stone, trim, pane, shade, accent = covers[0], covers[1], covers[2], covers[3], covers[4]
    upper_pattern(s, t, ws, wt, np.float32(0), upper, ground[0], np.float32(0.3), stone, trim, pane, shade)
    ground_pattern(s, t, ws, wt, ground, entrances, stone, trim, pane, accent)
    if panel[40] > panel[39]:
        hang_signs(s, t, ws, wt, entrances, int(panel[16]), trim, pane, accent, covers[5], covers[6])


def covers(panel, s, t, pixel_m=FINE):
    """(7, N) of pixels of this size at these places."""
    s, t = (np.ascontiguousarray(v, np.float32).ravel() for v in np.broadcast_arrays(s, t))
    size, out = np.full(s.size, pixel_m, np.float32), np.zeros((7, s.size), np.float32)
    _covers(panel, s, t, size, size, out)
    return out


def window(column, level):
    """Left edge, foot, width, height of an upper window."""
    return (column + 0.3) * BAY, FLOOR + (level + 0.25) * STOREY, 0.4 * BAY, 0.5 * STOREY


def test_a_window_has_a_frame_and_a_bar_in_its_middle():
    left, foot, wide, high = window(2, 1)
    across = np.array(
        [0.5 * FRAME, FRAME + 0.1, 0.5 * wide - BAR, 0.5 * wide, 0.5 * wide + BAR, wide - 0.5 * FRAME]
    )
    _, trim, pane, *_ = covers(front(), left + across, foot + 0.5 * high)
    np.testing.assert_array_equal(pane > 0, [False, True, True, False, True, False])
    np.testing.assert_allclose(trim[[0, 3, 5]], 1.0, atol=5e-3)
    outside = covers(front(), left - 0.05, foot + 0.5 * high)
    assert outside[1] == outside[2] == 0


def test_half_of_the_windows_have_curtains_that_hide_up_to_half_of_them():
    places = [window(column, level) for column in range(8) for level in range(3)]
    s, t = (np.array(v) for v in zip(*[(x + 0.25 * w, y + 0.5 * h) for x, y, w, h in places], strict=True))
    _, trim, pane, *_ = covers(front(), s, t)
    np.testing.assert_allclose(trim + pane, 1.0, atol=5e-3)
    hidden = 1 - pane
    assert hidden.min() < 0.01
    assert 0.3 < hidden.max() < 0.5
    assert 6 <= np.count_nonzero(hidden > 0.01) <= 18


@pytest.mark.parametrize("pixel_m", [0.3, 1.1, 5.0])
@pytest.mark.parametrize("kind", ["door", "glass", "shop"])
def test_a_coarse_pixel_sees_the_mean_of_fine_ones(pixel_m, kind):
    panel = front()
    add_entrance(panel, kind)
    rng = np.random.default_rng(3)
    s, t = rng.uniform(4.0, 20.0, 60), rng.uniform(0.5, 9.0, 60)
    coarse = covers(panel, s, t, pixel_m)
    steps = ((np.arange(64) + 0.5) / 64 - 0.5) * pixel_m
    grid_s, grid_t = s[:, None, None] + steps[:, None], t[:, None, None] + steps
    fine = covers(panel, grid_s, grid_t, pixel_m / 64).reshape(7, 60, -1).mean(axis=2)
    for k, name in ((1, "trim"), (2, "pane"), (4, "accent"), (5, "letters"), (6, "board")):
        error = np.abs(coarse[k] - fine[k])
        assert error.mean() < 0.02, name
        assert error.max() < 0.2, name


def test_a_door_reaches_the_step_and_takes_the_place_of_a_window():
    panel = front()
    add_entrance(panel, "door")
    unit, start, width = (
        panel[33] * panel[20],
        (panel[34] + panel[37]) * panel[20] - 0.5 * panel[35],
        panel[35],
    )
    assert unit == pytest.approx(LENGTH)
    heights = np.array([0.2, 0.4, 1.2, 2.0])
    _, trim, pane, _, accent, *_ = covers(panel, start + 0.5 * width, heights)
    np.testing.assert_allclose(accent, [0, 1, 1, 1], atol=5e-3)
    np.testing.assert_allclose(pane, 0, atol=5e-3)
    assert trim[0] == pytest.approx(1.0, abs=5e-3)  # the step
    elsewhere = covers(panel, np.arange(0.05, LENGTH, 0.1), 1.2)[4]
    assert elsewhere.sum() * 0.1 == pytest.approx(width - 2 * 0.08, abs=0.1)


def test_every_shop_has_a_sign_with_letters_and_a_door_of_glass():
    panel = front()
    add_entrance(panel, "shop")
    foot, top = panel[39:41]
    assert panel[23] < foot < top < panel[19]
    s, t = np.meshgrid(np.arange(0.01, LENGTH, 0.02), np.linspace(foot, top, 40)[1:-1])
    _, trim, pane, _, accent, *_ = covers(panel, s, t, 0.01)
    assert accent.mean() > 0.6
    assert 0.02 < (trim - accent).mean() < 0.3  # its letters: the accent is a part of the trim
    assert pane.max() == 0
    middle = (panel[34] + panel[37]) * panel[20]
    assert covers(panel, middle, 1.2)[2] > 0.5


def test_some_shops_signs_shine_after_dark_and_it_is_the_same_ones_every_time():
    lights = []
    for seed in range(1, 200):
        panel = front()
        panel[16] = seed
        add_entrance(panel, "shop")
        again = front()
        again[16] = seed
        add_entrance(again, "shop")
        assert tuple(panel[41:43]) == tuple(again[41:43])
        lights.append(panel[41:43])
    letters, board = np.array(lights).T
    assert 0.4 < np.mean(letters > 0) < 0.8
    assert np.any((letters > 0) & (board == 0))
    assert np.all(board < letters + 1e-9)
    assert letters.max() < 400  # cd/m2
    door = front()
    add_entrance(door, "door")
    assert door[41] == door[42] == 0


@pytest.mark.parametrize("pixel_m", [0.15, 0.3, 0.6])
def test_a_coarse_pixel_sees_as_much_glass_in_bands_as_fine_ones(pixel_m):
    """Windows with nothing but frames between them: a curtain of one of them could not be told from afar."""
    panel = front()
    panel[13] = 0.95
    rng = np.random.default_rng(4)
    s, t = rng.uniform(4.0, 20.0, 80), rng.uniform(FLOOR + 0.5, 11.0, 80)
    steps = ((np.arange(32) + 0.5) / 32 - 0.5) * pixel_m
    fine = covers(panel, s[:, None, None] + steps[:, None], t[:, None, None] + steps, pixel_m / 32)
    fine = fine.reshape(7, 80, -1).mean(axis=2)
    np.testing.assert_allclose(covers(panel, s, t, pixel_m)[1:3], fine[1:3], atol=5e-3)
