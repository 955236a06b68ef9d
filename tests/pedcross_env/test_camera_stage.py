"""The tables of one moment: all numbers of the records are in them, looks are looked up when others are seen."""

import numpy as np
import pytest
from camera_scenes import pedestrian, renderer, snapshot, vehicle

from pedcross_env.camera.kernels.stage import NUMBERS

MOVING = {name: 0.25 + k for k, name in enumerate(NUMBERS) if name not in ("x", "y", "model")}


def staged(camera, *actors):
    seen = snapshot(*actors)
    return seen, camera._moments.at(seen, camera._light).staged.cast


def test_every_number_of_a_record_is_in_the_tables():
    walker = pedestrian(3, 12.0, 2.0, **MOVING, model=1, speed=77.0, seed=5)
    camera = renderer()
    seen, cast = staged(camera, walker, vehicle(2, 20.0, -1.75, model=2, speed=8.0, headlight=1.0))
    for column, name in enumerate(NUMBERS):
        assert cast.numbers[:2, column].tolist() == [float(v) for v in seen.actors[name]], name


@pytest.mark.parametrize(
    ("name", "value"), [("id", 4), ("kind", 1), ("model", 1), ("seed", 6), ("height", 1.2), ("accessory", 2)]
)
def test_another_appearance_is_noticed_in_the_same_place(name, value):
    camera, before = renderer(), pedestrian(3, 12.0, 2.0, seed=5)
    after = before.copy()
    after[name] = value
    _, first = staged(camera, before)
    shown = [table.copy() for table in first]
    _, then = staged(camera, after)
    _, expected = staged(renderer(), after)
    assert all(np.array_equal(a, b) for a, b in zip(then, expected, strict=True))
    assert not all(np.array_equal(a, b) for a, b in zip(then, shown, strict=True))


def test_whoever_only_moves_is_not_looked_up_again():
    camera = renderer()
    _, first = staged(camera, pedestrian(3, 12.0, 2.0))
    _, then = staged(camera, pedestrian(3, 13.0, 2.0, yaw=0.1, speed=1.0, gait_phase=0.3, brake_light=1.0))
    assert then.bodies is first.bodies
    assert then.numbers[0, 0] == 13.0


def test_one_actor_more_or_less_is_noticed():
    camera = renderer()
    _, one = staged(camera, vehicle(2, 20.0, 0.0))
    _, two = staged(camera, vehicle(2, 20.0, 0.0), pedestrian(3, 12.0, 2.0))
    assert (len(one.bodies), len(two.bodies)) == (1, 2)
