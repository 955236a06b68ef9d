"""Keeping a moment of an episode, and going on from it as if nothing had been between."""

import gc
import hashlib
import pickle
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest

from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Leg, Maneuver, PedestrianSpec, Scenario, Trigger, VehicleSpec

SMALL = {"camera": {"width_px": 64, "height_px": 48}, "return_events": True, "weather": ("thunderstorm",)}
STEPS = 12


def episode() -> Scenario:
    """One in which triggers fire before and after the moment that is kept."""
    lead = VehicleSpec(
        x_m=25.0, y_m=-1.75, speed_mps=8.0, maneuvers=(Maneuver(when=Trigger(time_s=0.5), speed_mps=4.0),)
    )
    people = tuple(
        PedestrianSpec(
            behaviour="crossing", x_m=x, y_m=-6.2, legs=(Leg(to_x_m=x, to_y_m=6.2, speed_mps=1.4, go=go),)
        )
        for x, go in ((30.0, Trigger(time_s=0.1)), (35.0, Trigger(distance_m=27.0)))
    )
    return Scenario(name="kept", vehicles=(lead,), pedestrians=people)


def drive(env: CrossingEnv, steps: int) -> list[bytes]:
    """Everything the next steps deliver, as bytes."""
    seen = []
    for k in range(steps):
        observation, reward, terminated, truncated, info = env.step(np.array([-0.1 * (k % 3)], np.float32))
        events = info.pop("events")
        arrays = [observation[key].tobytes() for key in sorted(observation)] + [events.tobytes()]
        seen.append(b"".join([*arrays, repr((reward, terminated, truncated, info)).encode()]))
    return seen


def kept() -> tuple[CrossingEnv, object]:
    env = CrossingEnv(SMALL)
    env.reset(seed=5, options={"scenario": episode()})
    drive(env, STEPS)
    return env, env.save_state()


def test_a_kept_moment_goes_on_bit_for_bit_as_often_as_it_is_loaded():
    env, state = kept()
    first = drive(env, STEPS)
    for _ in range(2):
        observation, info = env.load_state(state)
        assert info["time_s"] == pytest.approx(STEPS / 30)
        assert env.observation_space.contains(observation)
        assert drive(env, STEPS) == first


def test_another_environment_and_another_process_go_on_alike(tmp_path):
    env, state = kept()
    first = drive(env, STEPS)
    other = CrossingEnv(SMALL)
    other.load_state(pickle.loads(pickle.dumps(state)))
    assert drive(other, STEPS) == first
    (tmp_path / "state").write_bytes(pickle.dumps(state))
    code = (
        "import pickle, hashlib; from test_env_state import *; "
        f"state = pickle.load(open({str(tmp_path / 'state')!r}, 'rb')); "
        "env = CrossingEnv(state.config); env.load_state(state); "
        "print(hashlib.sha256(b''.join(drive(env, STEPS))).hexdigest())"
    )
    environment = {"PATH": "/usr/bin:/bin", "PYTHONPATH": ":".join([*sys.path, __file__.rpartition("/")[0]])}
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, env=environment, capture_output=True, text=True
    )
    assert done.stdout.strip() == hashlib.sha256(b"".join(first)).hexdigest()


def test_the_generator_of_episodes_is_part_of_the_state():
    env = CrossingEnv({"modalities": ()})
    env.reset(seed=1)
    state = env.save_state()
    drawn = [env.reset()[1]["episode_seed"] for _ in range(3)]
    env.load_state(state)
    assert [env.reset()[1]["episode_seed"] for _ in range(3)] == drawn


def test_what_follows_a_kept_moment_does_not_change_it():
    env, state = kept()
    before = state.payload
    drive(env, 3)
    assert state.payload == before


def test_a_state_of_another_config_is_refused():
    _, state = kept()
    with pytest.raises(ConfigError, match="config"):
        CrossingEnv({"modalities": ()}).load_state(state)
    with pytest.raises(ConfigError, match="reset"):
        CrossingEnv({"modalities": ()}).save_state()


def test_close_leaves_nothing_behind():
    threads = threading.active_count()
    env = CrossingEnv(SMALL)
    env.reset(seed=0)
    env.step(np.zeros(1, np.float32))
    world, vision = weakref.ref(env.world), weakref.ref(env._vision)
    env.close()
    env.close()
    gc.collect()
    assert world() is None
    assert vision() is None
    assert threading.active_count() == threads
    with pytest.raises(ConfigError, match="closed"):
        env.reset()
