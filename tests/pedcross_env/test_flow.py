"""The bound on the image's motion against the optical flow of every pixel."""

from __future__ import annotations

import numpy as np
import pytest

from pedcross_env.camera import camera_pose
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import Snapshot
from pedcross_env.env import CrossingEnv
from pedcross_env.flow import image_flow_px
from pedcross_env.scenario import Leg, PedestrianSpec, Scenario
from pedcross_env.scenario.street import StreetSpec

HOLD = np.zeros(1, np.float32)
SMALL = {"camera": {"width_px": 112, "height_px": 64}}


@pytest.mark.parametrize("seed", [0, 2, 4, 5])
def test_the_bound_holds_for_every_pixel_and_is_not_far_above(seed: int) -> None:
    """Streets with parked and oncoming cars and people; flow by depth, from the picture before."""
    env = CrossingEnv(SMALL | {"modalities": ("rgb",)})
    env.reset(seed=seed)
    ratios = []
    for step in range(16):
        env.step(HOLD)
        if step % 4:
            continue
        now = env.world.time_s
        before, after = env.world.snapshot(now - 1 / 30), env.world.snapshot(now)
        bound = image_flow_px(env.config.camera, env.world.scenario.street, before, after)
        flow = np.hypot(*np.moveaxis(env.truth(flow=True).flow_px, -1, 0))
        ratios.append(bound / np.nanmax(flow))
    assert min(ratios) > 1.0
    assert np.median(ratios) < 1.3


def test_nothing_moves_before_a_camera_at_rest() -> None:
    env = CrossingEnv(SMALL | {"modalities": ()})
    env.reset(seed=0, options={"scenario": Scenario(name="still", ego_speed_mps=0.0)})
    env.step(HOLD)
    snapshots = env.world.snapshot(0.0), env.world.snapshot(env.world.time_s)
    assert image_flow_px(env.config.camera, env.world.scenario.street, *snapshots) == pytest.approx(
        0, abs=1e-9
    )


def test_a_walker_before_a_camera_at_rest_moves_by_speed_over_depth() -> None:
    walker = PedestrianSpec(
        behaviour="crossing", x_m=20.0, y_m=3.0, legs=(Leg(to_x_m=20.0, to_y_m=-8.0, speed_mps=2.0),)
    )
    env = CrossingEnv(SMALL | {"modalities": ()})
    env.reset(seed=0, options={"scenario": Scenario(name="walker", ego_speed_mps=0.0, pedestrians=(walker,))})
    for _ in range(40):
        env.step(HOLD)
    now = env.world.time_s
    before, after = env.world.snapshot(now - 1 / 30), env.world.snapshot(now)
    depth = 20.0 - camera_pose(env.config.camera, after.ego).origin[0]
    expected = env.config.camera.focal_px * 2.0 / 30 / depth
    found = image_flow_px(env.config.camera, env.world.scenario.street, before, after)
    assert expected <= found < 1.05 * expected


def test_the_road_under_the_bottom_row_moves_by_its_projection() -> None:
    """Nothing but road: at the bottom corner, v = (h/2) and u = (w/2) from the axis, depth is height f / v."""
    camera = CameraConfig(width_px=112, height_px=64)
    env = CrossingEnv({"camera": {"width_px": 112, "height_px": 64}, "modalities": ()})
    env.reset(seed=0, options={"scenario": Scenario(name="drive", ego_speed_mps=10.0)})
    env.step(HOLD)
    pair = [env.world.snapshot(t) for t in (0.0, env.world.time_s)]
    alone = [Snapshot(s.time_s, s.ego, s.actors[:0]) for s in pair]
    depth = camera.mount_z_m * camera.focal_px / 32
    expected = np.hypot(56, 32) / depth * 10.0 / 30
    assert image_flow_px(camera, StreetSpec(), *alone) == pytest.approx(expected, rel=0.03)
