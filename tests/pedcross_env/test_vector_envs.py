"""The environment in other processes."""

import os

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.vec_env import SubprocVecEnv

CONFIG = {"camera": {"width_px": 48, "height_px": 32}, "modalities": ["dvs"]}


WORKERS = int(os.environ.get("PEDCROSS_WORKERS", "2"))
"""How many run beside each other; set the variable for more than a small machine has cores for."""


def make():
    return gymnasium.make("pedcross_env:pedcross/Crossing-v0", config=CONFIG)


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_workers_give_the_bytes_of_single_environments(method):
    seeds, steps = list(range(3, 3 + WORKERS)), 3
    vector = gymnasium.vector.AsyncVectorEnv([make] * WORKERS, context=method)
    try:
        seen = [vector.reset(seed=seeds)[0]]
        rewards = []
        for _ in range(steps):
            observations, reward, *_ = vector.step(np.full((WORKERS, 1), -0.3, np.float32))
            seen.append(observations)
            rewards.append(reward)
    finally:
        vector.close()
    for row, seed in enumerate(seeds):
        single = make()
        expected, _ = single.reset(seed=seed)
        for k in range(steps + 1):
            assert all(np.array_equal(seen[k][key][row], value) for key, value in expected.items())
            if k < steps:
                expected, reward, *_ = single.step(np.array([-0.3], np.float32))
                assert rewards[k][row] == reward
        single.close()


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
