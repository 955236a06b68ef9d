"""The environment in other processes."""

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.vec_env import SubprocVecEnv

CONFIG = {"camera": {"width_px": 48, "height_px": 32}, "modalities": ["dvs"]}


def make():
    return gymnasium.make("pedcross_env:pedcross/Crossing-v0", config=CONFIG)


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_async_vector_env_equals_single_environments(method):
    vector = gymnasium.vector.AsyncVectorEnv([make, make], context=method)
    try:
        observations, _ = vector.reset(seed=[3, 4])
        observations, *_ = vector.step(np.zeros((2, 1), np.float32))
    finally:
        vector.close()
    for row, seed in enumerate((3, 4)):
        single = make()
        single.reset(seed=seed)
        expected, *_ = single.step(np.zeros(1, np.float32))
        for key, value in expected.items():
            assert np.array_equal(observations[key][row], value)


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_subproc_vec_env_steps(method):
    vector = SubprocVecEnv([make, make], start_method=method)
    try:
        vector.reset()
        observations, rewards, _, infos = vector.step(np.zeros((2, 1), np.float32))
    finally:
        vector.close()
    assert observations["dvs"].shape == (2, 32, 48, 2)
    assert rewards.shape == (2,)
    assert infos[0]["outcome"] == "running"
