"""Poses at any time: continuous, in a fixed order, the same from either side of a step."""

import numpy as np
import pytest

from pedcross_env.config import EgoConfig, LabelConfig, TrafficConfig, WorldConfig
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError
from pedcross_env.scenario.sampler import sample_crossing
from pedcross_env.scenario.walk import wrap_angle
from pedcross_env.world import World


def build(seed: int, policy_hz: int = 30) -> World:
    clock = WorldConfig(policy_hz=policy_hz, tick_hz=4 * policy_hz)
    scenario = sample_crossing(seed, TrafficConfig(), EgoConfig())
    return World(scenario, ego=EgoConfig(), world=clock, label=LabelConfig(), friction=0.85)


def poses(seed: int, per_step: int = 5, policy_hz: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """(times, records of ego and others over them) while braking now and then."""
    world, times, rows = build(seed, policy_hz), [], []
    while world.outcome is Outcome.RUNNING:
        start = world.time_s
        world.step(-4.0 if 2.0 < start < 3.0 else 1.0)
        for time in np.linspace(start, world.time_s, per_step, endpoint=False):
            if world.outcome is Outcome.COLLISION and time > world.contact_time_s:
                break
            shot = world.snapshot(float(time))
            times.append(time)
            rows.append(np.concatenate([shot.ego[None], shot.actors]))
    return np.array(times), np.stack(rows)


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 6])
def test_nothing_jumps(seed: int) -> None:
    times, rows = poses(seed)
    dt = np.diff(times)[:, None]
    top = np.maximum(rows["speed"][1:], rows["speed"][:-1])
    moved = np.hypot(np.diff(rows["x"], axis=0), np.diff(rows["y"], axis=0))
    assert (moved <= top * dt + 0.5 * 30 * dt**2 + 1e-9).all()
    turned = np.abs(np.vectorize(wrap_angle)(np.diff(rows["yaw"], axis=0)))
    assert (turned <= 9.0 * dt + 1e-9).all()
    assert (np.diff(rows["gait_phase"], axis=0) >= -1e-9).all()
    assert (np.diff(rows["gait_phase"], axis=0) <= 2.0 * dt + 1e-9).all()
    for field, rate in (("z", 1.5), ("pitch", 0.4), ("gait_stride", 8.0), ("head_yaw", 8.0)):
        assert (np.abs(np.diff(rows[field], axis=0)) <= rate * dt + 1e-9).all(), field


@pytest.mark.parametrize("seed", [1, 4])
def test_feet_do_not_slip(seed: int) -> None:
    """Cycles times stride is the way gone."""
    times, rows = poses(seed)
    people = rows[:, rows["kind"][0] == 2]
    gone = np.hypot(np.diff(people["x"], axis=0), np.diff(people["y"], axis=0))
    stride = 0.5 * (people["gait_stride"][1:] + people["gait_stride"][:-1])
    assert np.abs(np.diff(people["gait_phase"], axis=0) * stride - gone).max() < 0.01
    assert len(times) > 100


def test_a_pose_is_the_same_from_both_sides_of_a_step() -> None:
    world = build(3)
    for _ in range(60):
        world.step(-5.0)
        before = world.snapshot(world.time_s)
        world.step(-5.0)
        after = world.snapshot(before.time_s)
        for field in ("x", "y", "yaw", "gait_phase", "speed", "pitch"):
            np.testing.assert_allclose(before.actors[field], after.actors[field], atol=1e-9)
            np.testing.assert_allclose(before.ego[field], after.ego[field], atol=1e-9)


def test_snapshots_are_pure() -> None:
    world = build(2)
    world.step(0.0)
    first = world.snapshot(0.01)
    world.snapshot(0.03).actors["x"][:] = 0.0
    again = world.snapshot(0.01)
    assert first.actors.tobytes() == again.actors.tobytes()
    assert first.ego.tobytes() == again.ego.tobytes()


def test_ids_are_fixed_and_in_order() -> None:
    world = build(5)
    ids = world.snapshot(0.0).actors["id"]
    assert ids.tolist() == list(range(2, 2 + len(ids)))
    world.step(0.0)
    assert world.snapshot(world.time_s).actors["id"].tolist() == ids.tolist()
    assert int(world.snapshot(0.0).ego["id"]) == 1


def test_a_time_outside_the_last_step_is_refused() -> None:
    world = build(1)
    world.step(0.0)
    world.step(0.0)
    with pytest.raises(ConfigError, match="within the last step"):
        world.snapshot(0.0)
    with pytest.raises(ConfigError, match="within the last step"):
        world.snapshot(1.0)


def test_slow_policies_see_the_same_world() -> None:
    fast, slow = build(7, 30), build(7, 5)
    for _ in range(6):
        fast.step(0.0)
    slow.step(0.0)
    a, b = fast.snapshot(0.19), slow.snapshot(0.19)
    for field in ("x", "y", "yaw", "speed", "gait_phase"):
        np.testing.assert_allclose(a.actors[field], b.actors[field], atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_several_snapshots_are_those_taken_one_by_one(seed: int) -> None:
    world = build(seed)
    while world.outcome is Outcome.RUNNING and world.time_s < 3.0:
        start = world.time_s
        world.step(0.5)
        times = np.linspace(start, world.time_s, 5).tolist()
        for time_s, shot in zip(times, world.snapshots(times), strict=True):
            alone = world.snapshot(time_s)
            assert shot.time_s == alone.time_s == time_s
            assert shot.actors.tobytes() == alone.actors.tobytes()
            assert shot.ego.tobytes() == alone.ego.tobytes()
    assert world.time_s > 1.0
    assert world.snapshots([]) == []
    with pytest.raises(ConfigError, match="within the last step"):
        world.snapshots([world.time_s + 1.0])
