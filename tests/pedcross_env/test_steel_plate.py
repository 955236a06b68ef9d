"""A steel plate lies in the lane: seen where it is and as large as it is, and driven over."""

import numpy as np
import pytest

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig, EgoConfig, LabelConfig, WorldConfig
from pedcross_env.contracts import Outcome, StaticClass
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import SteelPlate, StreetSpec
from pedcross_env.scenario.suites import suite
from pedcross_env.weather import weather_by_name
from pedcross_env.world import World

CAMERA = CameraConfig(width_px=320, height_px=160)


def test_the_plate_of_the_false_activation_is_seen_and_driven_over() -> None:
    scenario = suite("fmvss-127").cell("FALSE-PLATE/80").scenario()
    world = World(
        scenario, ego=EgoConfig(), world=WorldConfig(), label=LabelConfig(), friction=0.85, camera=CAMERA
    )
    (plate,) = scenario.street.plates
    assert (plate.length_m, plate.width_m, plate.height_m) == (3.7, 2.4, 0.025)
    assert plate.y_m == scenario.street.ego_lane_y_m
    renderer = Renderer(CAMERA)
    renderer.load(scenario.street, weather_by_name("clear"))
    while world.front_m < plate.x_m - 10.0:
        world.step(0.0)
    frame = renderer.render(world.snapshot(world.time_s))
    rows, columns = np.nonzero(frame.instance == StaticClass.FURNITURE)
    lane = (rows > CAMERA.height_px * 0.6) & (np.abs(columns - CAMERA.width_px / 2) < CAMERA.width_px * 0.12)
    depth = frame.depth[rows[lane], columns[lane]]
    mount = world.front_m - 0.5 * EgoConfig().length_m + CAMERA.mount_x_m
    near, far = plate.x_m - 0.5 * plate.length_m - mount, plate.x_m + 0.5 * plate.length_m - mount
    assert lane.sum() > 100
    row_m = 1.0 / (CAMERA.focal_px * CAMERA.mount_z_m)  # of a row of pixels, over depth squared
    assert near - 0.02 < depth.min() < near + near**2 * row_m
    assert far - far**2 * row_m < depth.max() < far + 0.02
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
    assert world.outcome is Outcome.PASSED


def test_a_plate_beside_the_road_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"SteelPlate x_m, y_m = \(50.0, 9.0\)"):
        StreetSpec(plates=(SteelPlate(x_m=50.0, y_m=9.0),))
