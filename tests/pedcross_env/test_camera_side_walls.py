"""Side walls of houses: storeys go round the corner, windows are whole, and nothing else moves for them."""

from __future__ import annotations

import numpy as np
import pytest

from pedcross_env.camera.scenery import buildings
from pedcross_env.camera.scenery.buildings import COPING_M, building_rows
from pedcross_env.scenario.street import StreetSpec

STREETS = [StreetSpec(seed=seed) for seed in range(6)]


def rows(street, seed=0):
    return building_rows(street, np.random.default_rng(seed)).panels


@pytest.fixture(scope="module")
def sides():
    panels = np.concatenate([rows(street, k) for k, street in enumerate(STREETS)])
    return panels[panels[:, 43] > 0]


def test_most_side_walls_have_windows_and_some_have_none(sides):
    large = sides[sides[:, 6] > 4.0]
    share = np.mean(large[:, 13] > 0)
    assert len(large) > 50
    assert 0.5 < share < 0.95
    narrow = sides[sides[:, 6] < 4.0]
    assert np.all(narrow[:, 13] == 0)


def test_whole_windows_stand_on_the_foot_of_a_wall_above_a_neighbour(sides):
    above = sides[(sides[:, 2] > 0) & (sides[:, 13] > 0)]
    foot = above[:, 15]  # of the storey, as the kernel counts from the wall's foot
    assert len(above) > 20
    assert np.all(foot > 0)
    assert np.all(foot + above[:, 14] < 1.0)  # the next lower one ends below the wall


def test_ground_floor_and_cornice_go_round_the_corner(sides):
    panels = rows(STREETS[0])
    fronts = {float(p[16]): p for p in panels if p[33] > 0}
    walls = panels[(panels[:, 43] > 0) & (panels[:, 2] == 0)]
    assert len(walls) > 0
    for wall in walls:
        front = fronts[wall[16]]
        np.testing.assert_array_equal(wall[[12, 18, 19, 22, 23, 24, 25]], front[[12, 18, 19, 22, 23, 24, 25]])


def test_side_walls_take_nothing_from_the_streets_random_numbers(monkeypatch):
    finished = rows(STREETS[1])
    monkeypatch.setattr(buildings, "finish_side_wall", lambda wall, front: None)
    plain = rows(STREETS[1])
    same = finished[:, 43] == 0
    np.testing.assert_array_equal(finished[same], plain[same])
    np.testing.assert_array_equal(finished[:, :11], plain[:, :11])


def test_garden_walls_have_stones_on_top_and_hedges_none():
    panels = np.concatenate([rows(street, k) for k, street in enumerate(STREETS)])
    low = [k for k, p in enumerate(panels) if p[11] == 0 and p[43] == 0 and p[2] == 0 and p[7] < 2.0]
    hedges = [k for k in low if panels[k, 9] > 1.3 * panels[k, 8]]
    walls = [k for k in low if k not in hedges]
    assert hedges
    assert walls
    for k in walls:
        assert panels[k + 1, 2] == panels[k, 7]
        assert panels[k + 1, 7] == pytest.approx(COPING_M)
    for k in hedges:
        assert panels[k + 1, 2] == 0
