"""Signs of shops that shine after dark, in the picture."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from camera_scenes import STREET, renderer, snapshot

from pedcross_env.camera import camera_pose, project
from pedcross_env.camera.kernels.facade import PANEL_SIZE
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.camera.scenery.entrances import add_entrance
from pedcross_env.weather.weather import Weather

DAY, NIGHT = Weather(), Weather(sun_altitude_deg=-30.0, street_lamps=True)
FRONT_M, LETTERS, BOARD = 8.0, 120.0, 30.0
LUMA = np.array([0.2126, 0.7152, 0.0722])


def shop(letters, board):
    """Scenery with one shop on the left, its sign lit so much."""
    panel = np.zeros(PANEL_SIZE)
    panel[:2], panel[3], panel[6], panel[7] = (0.0, FRONT_M), 1.0, 24.0, 11.0
    panel[8:11] = 0.3
    panel[11:17] = 3.0, 3.2, 0.4, 0.5, 0.25, 77
    panel[18:26] = 1.3, 3.8, 6.0, 0.7, 0.4, 2.6, 1.0, 10.5
    add_entrance(panel, "shop")
    panel[41:43] = letters, board
    scenery = scenery_of(STREET)
    props = dataclasses.replace(
        scenery.props, numbers=scenery.props.numbers[:0], idents=scenery.props.idents[:0], looks=scenery.props.looks[:0]
    )  # fmt: skip
    return dataclasses.replace(scenery, panels=panel[None], groups=scenery.groups[:0], props=props), panel


@pytest.fixture
def seen(monkeypatch):
    """Return a function from letters, board and weather to a picture, its luminance, the sign's (rows, columns)."""

    def look(letters, board, weather):
        scenery, panel = shop(letters, board)
        monkeypatch.setattr("pedcross_env.camera.renderer.scenery_for", lambda street: scenery)
        camera, moment = renderer(weather), snapshot()
        pose = camera_pose(camera.config, moment.ego)
        s, z = np.meshgrid(np.linspace(12.0, 23.0, 40), np.linspace(panel[39] + 0.15, panel[40] - 0.15, 5))
        places = np.stack([s.ravel(), np.full(s.size, FRONT_M), z.ravel()], axis=1)
        u, v = project(pose, places)[:, :2].astype(int).T
        return camera.render(moment), camera.render(moment, luminance_only=True), (v, u)

    return look


def test_a_lit_sign_is_brighter_by_night_and_the_same_by_day(seen):
    for weather, brighter in ((NIGHT, True), (DAY, False)):
        (lit, lit_grey, place), (unlit, _, _) = seen(LETTERS, BOARD, weather), seen(0.0, 0.0, weather)
        gain = lit.luminance - unlit.luminance
        if brighter:
            assert gain[place].mean() > 2.0
            assert (gain[place] > 0).mean() > 0.8  # between two shops there is a gap
        else:
            assert np.abs(gain).max() == 0
        np.testing.assert_allclose(lit_grey.luminance, lit.luminance, rtol=1e-4)


def test_letters_alone_add_white_light_and_a_board_adds_its_colour(seen):
    unlit, _, _ = seen(0.0, 0.0, NIGHT)
    letters, _, place = seen(LETTERS, 0.0, NIGHT)
    board, _, _ = seen(0.0, BOARD, NIGHT)
    assert unlit.radiance is not None
    assert letters.radiance is not None
    assert board.radiance is not None
    white, painted = (
        (frame.radiance - unlit.radiance)[:, place[0], place[1]].mean(axis=1) for frame in (letters, board)
    )
    assert white.min() > 0.98 * white.max() > 0
    albedo = shop(0.0, 0.0)[1][30:33]
    np.testing.assert_allclose(painted / painted.max(), albedo / albedo.max(), rtol=0.02)
