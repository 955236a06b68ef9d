"""A detector's probability as an observation."""

import gymnasium
import numpy as np
import pytest

from agents.wrappers import DetectorProbability
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError

CONFIG = {"modalities": ("dvs",), "camera": {"width_px": 32, "height_px": 24}}


class Counter:
    """A detector whose probability tells how often it was asked since its reset."""

    name, modality, frames = "counter", "dvs", 1

    def __init__(self):
        self.asked = 0

    def reset(self):
        self.asked = 0

    def update(self, observation):
        assert observation[self.modality].shape == (24, 32, 2)
        self.asked += 1
        return self.asked / 100

    def predict(self, clips):
        return np.zeros(len(clips))


def test_each_observation_holds_what_the_detector_says_of_it():
    env = DetectorProbability(CrossingEnv(CONFIG), Counter())
    for _ in range(2):
        observation, _ = env.reset(seed=1)
        for k in range(1, 5):
            assert set(observation) == {"ego", "p_crossing"}
            assert env.observation_space.contains(observation)
            assert observation["p_crossing"] == np.float32(k / 100)
            observation, *_ = env.step(np.zeros(1))


def test_the_camera_stays_on_request():
    env = DetectorProbability(CrossingEnv(CONFIG), Counter(), keep_camera=True)
    observation, _ = env.reset(seed=1)
    assert set(observation) == {"ego", "dvs", "p_crossing"}
    assert isinstance(env.observation_space, gymnasium.spaces.Dict)


def test_a_detector_of_another_camera_is_refused():
    with pytest.raises(ConfigError, match="dvs"):
        DetectorProbability(CrossingEnv({"modalities": ()}), Counter())
