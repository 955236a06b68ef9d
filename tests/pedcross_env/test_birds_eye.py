"""The view from above shows where the road ends, where houses stand and which way people head."""

import math

import numpy as np
import pytest
from camera_scenes import STREET, pedestrian, snapshot

from pedcross_env.birds_eye import ASPHALT, HOUSES, KERB, PEDESTRIAN, SIDEWALK, SKIN, draw_birds_eye
from pedcross_env.camera.layout import scenery_for
from pedcross_env.contracts import Snapshot
from pedcross_env.scenario import Scenario

PX_PER_M, AHEAD_M = 20.0, 50.0


def above(scene: Snapshot) -> np.ndarray:
    return draw_birds_eye(Scenario(name="s", street=STREET), scene, px_per_m=PX_PER_M, ahead_m=AHEAD_M)


def at(image: np.ndarray, x: float, y: float) -> tuple[int, ...]:
    """Colour of a place; the ego is at x = 0."""
    middle = 0.5 * image.shape[1] / PX_PER_M
    return tuple(image[int((AHEAD_M - x) * PX_PER_M), int((middle - y) * PX_PER_M)].tolist())


@pytest.mark.parametrize("side", [-1, 1])
def test_a_kerb_lies_between_road_and_sidewalk(side: int) -> None:
    image, kerb_y = above(snapshot()), STREET.kerb_y_m
    for x in (-8.0, 7.0):
        road, kerb, beyond = (at(image, x, side * (kerb_y + out)) for out in (-0.4, 0.12, 0.5))
        assert (road, kerb, beyond) == (ASPHALT, KERB, SIDEWALK)


def test_a_house_is_drawn_behind_its_front_the_brighter_its_wall() -> None:
    image, tones = above(snapshot()), []
    for panel in scenery_for(STREET).panels:
        low, high = sorted((panel[0], panel[0] + panel[3] * panel[6]))
        if panel[11] > 0 and panel[43] == 0 and panel[2] <= 0 and low > -5 and high < 45:  # a front, in view
            colour = at(image, 0.5 * (low + high), panel[1] + math.copysign(1.7, panel[1]))
            assert colour not in (HOUSES, SIDEWALK)
            tones.append((panel[8:11].sum(), sum(colour)))
    walls, shown = np.array(tones).T
    assert len(walls) >= 4
    assert np.corrcoef(walls, shown)[0, 1] > 0.8


@pytest.mark.parametrize("yaw", [0.0, 0.5 * math.pi, 2.5, -2.0])
def test_a_persons_head_is_ahead_of_its_shoulders(yaw: float) -> None:
    image = above(snapshot(pedestrian(5, 20.0, 0.0, yaw=yaw, length=2.0, width=2.0)))
    head, body = (np.argwhere((image == colour).all(axis=2)).mean(axis=0) for colour in (SKIN, PEDESTRIAN))
    up, right = head - body
    assert math.cos(math.atan2(-right, -up) - yaw) > 0.9
