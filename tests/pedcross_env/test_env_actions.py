"""Actions, rewards and wrappers: what a learner sees of the environment."""

import math

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from pedcross_env.config import RewardConfig
from pedcross_env.contracts import Outcome
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.reward import TERMS
from pedcross_env.scenario import PedestrianSpec, Scenario
from pedcross_env.wrappers import SecondsLimit, StackFrames

BLIND = {"modalities": ()}
EMPTY = Scenario(name="empty", ego_speed_mps=10.0)
STANDING = Scenario(name="standing", pedestrians=(PedestrianSpec(behaviour="standing", x_m=30.0, y_m=-1.75),))


def rollout(env, actions):
    env.reset(seed=3, options={"scenario": EMPTY})
    return [env.step(action)[0]["ego"].tobytes() for action in actions]


def test_discrete_actions_are_levels_of_the_continuous_ones():
    levels = (-1.0, -0.3, 0.0, 1.0)
    discrete = CrossingEnv(BLIND | {"actions": "discrete", "demand_levels": levels})
    assert discrete.action_space == gymnasium.spaces.Discrete(4)
    picked = [0, 3, 1, 2, 3, 0]
    continuous = rollout(CrossingEnv(BLIND), [np.array([levels[k]]) for k in picked])
    assert rollout(discrete, picked) == continuous
    check_env(discrete, skip_render_check=True)


def test_discrete_actions_steer_where_the_ego_can():
    settings = {"actions": "discrete", "demand_levels": [0.0, -1.0], "steer_levels": [-0.1, 0.0, 0.1]}
    both = BLIND | {"ego": {"steering": True}}
    discrete = CrossingEnv(both | settings)
    assert discrete.action_space == gymnasium.spaces.Discrete(6)
    steered = rollout(CrossingEnv(both), [np.array([-1.0, 0.1]), np.array([0.0, -0.1])])
    assert rollout(discrete, [5, 0]) == steered


@pytest.mark.parametrize("action", [5, -1, 0.5, np.array([1.0])])
def test_actions_that_are_none_are_refused(action):
    env = CrossingEnv(BLIND | {"actions": "discrete"})
    env.reset(seed=0)
    with pytest.raises(ConfigError, match="0 to 4"):
        env.step(action)
    env = CrossingEnv(BLIND)
    env.reset(seed=0)
    with pytest.raises(ConfigError, match="allowed: 1"):
        env.step(np.zeros(2))


def steps(reward, scenario, action):
    env = CrossingEnv(BLIND | {"reward": reward})
    env.reset(seed=0, options={"scenario": scenario})
    while True:
        _, total, terminated, truncated, info = env.step(np.array([action]))
        yield env.reward_terms, total, info
        if terminated or truncated:
            return


def test_the_reward_is_the_sum_of_its_terms():
    weights = dict.fromkeys(RewardConfig.__dataclass_fields__, 0.3)
    for terms, total, _ in steps(weights, STANDING, -0.2):
        assert tuple(terms) == TERMS
        assert total == pytest.approx(sum(terms.values()))


def test_each_term_says_what_it_is_documented_to():
    alone = dict.fromkeys(RewardConfig.__dataclass_fields__, 0.0) | {"proximity_s": 1.5}

    def of(name, scenario, action, **weights):
        return [(terms[name], info) for terms, _, info in steps(alone | weights, scenario, action)]

    driven = of("progress", EMPTY, 0.0, progress_per_m=1.0)
    start_m = driven[0][1]["position_m"] - driven[0][0]
    assert sum(value for value, _ in driven) == pytest.approx(driven[-1][1]["position_m"] - start_m)
    assert of("passed", EMPTY, 0.0, passed=2.0)[-1][0] == 2.0
    value, info = of("collision", STANDING, 0.0, collision=1.0, collision_per_mps=0.5)[-1]
    assert info["outcome"] == Outcome.COLLISION
    assert value == pytest.approx(-1.0 - 0.5 * info["impact_speed_mps"])
    for value, info in of("false_braking", EMPTY, -0.5, false_braking_per_mps2=1.0):
        assert value == pytest.approx(min(0.0, info["acceleration_mps2"]))
    braking = [value for value, info in of("false_braking", STANDING, -0.5, false_braking_per_mps2=1.0)
               if info["conflict"]]  # fmt: skip
    assert len(braking) > 5
    assert not any(braking)
    for value, info in of("proximity", STANDING, 0.0, proximity=1.0):
        assert value == pytest.approx(-max(0.0, 1.0 - info["ttc_s"] / 1.5))
    changes = of("jerk", EMPTY, -0.5, jerk_per_mps3=1.0)
    jerks = np.diff([0.0, *(info["acceleration_mps2"] for _, info in changes)]) * 30
    np.testing.assert_allclose([value for value, _ in changes], -np.abs(jerks), atol=1e-9)
    assert of("time", EMPTY, 0.0, time_per_s=3.0)[4][0] == pytest.approx(-0.1)


@pytest.mark.parametrize("weights", [{"collision": -1.0}, {"passed": math.inf}, {"proximity_s": 0.0}])
def test_weights_that_are_none_are_refused(weights):
    with pytest.raises(ConfigError, match=r"reward\."):
        CrossingEnv(BLIND | {"reward": weights})


def test_stacked_frames_are_the_last_ones_and_begin_with_the_first():
    config = {"modalities": ("dvs",), "camera": {"width_px": 32, "height_px": 24}}
    plain, stacked = CrossingEnv(config), StackFrames(CrossingEnv(config), 3)
    first, _ = plain.reset(seed=2)
    seen, _ = stacked.reset(seed=2)
    frames = [first["dvs"]] * 3
    for _ in range(5):
        assert stacked.observation_space.contains(seen)
        np.testing.assert_array_equal(seen["dvs"], np.stack(frames[-3:]))
        assert seen["ego"].shape == (3,)
        frames.append(plain.step(np.zeros(1))[0]["dvs"])
        seen = stacked.step(np.zeros(1))[0]
    again, _ = stacked.reset(seed=2)
    np.testing.assert_array_equal(again["dvs"], np.stack([first["dvs"]] * 3))
    with pytest.raises(ConfigError, match="'dvs'"):
        StackFrames(CrossingEnv(config), 3, keys=("dsv",))


@pytest.mark.parametrize("policy_hz", [10, 30])
def test_the_limit_is_in_seconds(policy_hz):
    env = SecondsLimit(CrossingEnv(BLIND | {"world": {"policy_hz": policy_hz, "tick_hz": 120}}), 1.5)
    env.reset(seed=0, options={"scenario": EMPTY})
    count, truncated = 0, False
    while not truncated:
        *_, truncated, _ = env.step(np.zeros(1))
        count += 1
    assert count == round(1.5 * policy_hz)
