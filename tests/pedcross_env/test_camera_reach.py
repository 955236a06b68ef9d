"""Nothing is drawn beyond the sphere in which an object is looked for: it would be cut off there."""

import math
from itertools import product

import numpy as np
import pytest
from camera_scenes import STREET, pedestrian, renderer, snapshot

from pedcross_env.camera import camera_pose
from pedcross_env.camera.kernels.crown import BORDER
from pedcross_env.camera.kernels.scene import BODY_REACH_M, REACH
from pedcross_env.camera.models import PAINT, ModelBuilder
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.camera.scenery.foliage import crown_textures
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import ACCESSORIES, PEDESTRIAN_MODELS
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.weather.weather import Weather

MARGIN_PX = 2


@pytest.mark.parametrize("model", range(len(PEDESTRIAN_MODELS)))
@pytest.mark.parametrize("weather", [Weather(), Weather(rain_mm_h=10.0)], ids=["dry", "umbrellas up"])
def test_a_walker_with_all_it_carries_stays_within_its_reach(model: int, weather: Weather) -> None:
    camera = renderer(weather, width_px=900, height_px=600, horizontal_fov_deg=50.0)
    for accessory, yaw, phase in product(range(len(ACCESSORIES)), (0.0, math.pi / 2), (0.0, 0.3, 0.6)):
        walker = pedestrian(
            5, 9.0, -1.75, model=model, accessory=accessory, seed=accessory, yaw=yaw, gait_phase=phase, gait_stride=2.4,
        )  # fmt: skip
        scene = snapshot(walker)
        mask, column, row = camera.silhouette(scene, 5)
        assert mask.any()
        pose = camera_pose(camera.config, scene.ego)
        middle = np.array([walker["x"], walker["y"], walker["z"] + 0.5 * walker["height"]])
        right, down, ahead = pose.rotation @ (middle - pose.origin)
        size = math.hypot(float(walker["length"]), float(walker["width"]), float(walker["height"]))
        radius_px = pose.focal_px * (REACH * size + BODY_REACH_M) / ahead
        rows, columns = np.nonzero(mask)
        u, v = (
            column + columns - (pose.cx + pose.focal_px * right / ahead),
            row + rows - (pose.cy + pose.focal_px * down / ahead),
        )
        assert max(abs(u).max(), abs(v).max()) < radius_px - MARGIN_PX, ACCESSORIES[accessory]


@pytest.mark.parametrize("seed", range(8))
def test_trees_and_lamps_stay_within_their_reach(seed: int) -> None:
    scenery = scenery_of(StreetSpec(seed=seed, crosswalks=STREET.crosswalks))
    assert len(scenery.groups) > 10
    for group in scenery.groups:
        centre, radius = group[2:5], group[5]
        for capsule in scenery.capsules[int(group[0]) : int(group[1])]:
            axis = (capsule[3:6] - capsule[0:3]) / math.dist(capsule[0:3], capsule[3:6])
            for end, thick in ((capsule[0:3], capsule[6]), (capsule[3:6], capsule[7])):  # flat: discs
                along = float((end - centre) @ axis)
                across = float(np.linalg.norm(end - centre - along * axis))
                assert math.hypot(along, across + thick) <= radius
        # a crown faces the camera: its texture's leaves reach from -1 to 1 of its half width and height
        if group[7] >= 0:
            columns = crown_textures().bounds[0][int(group[7])]
            rows = np.flatnonzero(columns[:, 1] > columns[:, 0])
            nodes = 0.5 * (len(columns) - 2 * BORDER - 1)
            x = np.abs(columns[rows] - BORDER - nodes).max(axis=1) / nodes * abs(group[11])
            for edge in (rows, rows + 1):
                z = group[10] - (edge - BORDER - nodes) / nodes * group[12]
                assert np.hypot(x, z - centre[2]).max() <= radius


def test_a_model_that_reaches_out_of_its_size_is_refused() -> None:
    body = ModelBuilder()
    body.box((-1.0, 1.0), (-0.5, 0.5), (0.0, 1.5), PAINT)
    assert body.build(2.0, 1.0, 1.5).size == (2.0, 1.0, 1.5)
    body.pole(0.0, 0.0, (1.0, 6.0), 0.1, PAINT)
    with pytest.raises(ConfigError, match="model's reach") as refused:
        body.build(2.0, 1.0, 1.5)
    assert "give it its true size" in str(refused.value)
