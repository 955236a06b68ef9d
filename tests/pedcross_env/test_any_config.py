"""Any configuration is refused by a ConfigError, or plays to its end without nan.

The suite tries a few hundred of either kind; for ten thousand, set PEDCROSS_CONFIGS=10000 and run this file alone.
"""

import math

import numpy as np
import pytest
from any_config import CONFIG, EGO, EXAMPLES, ODD, SCENARIO, many, scenario, spoilt
from hypothesis import event, given, reject
from hypothesis import strategies as st

from pedcross_env.contracts import Outcome, check_info
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError

played: list[int] = []


def play(env: CrossingEnv, seed: int, pick: float, options: dict) -> None:
    """Play to the end, watching for nan and for time that stands still."""
    space, clock = env.action_space, env.config.world
    _, info = env.reset(seed=seed, options=options)
    action = int(pick * (space.n - 1)) if hasattr(space, "n") else np.full(space.shape, 2 * pick - 1)
    most = math.ceil(env.world.scenario.duration_s * clock.policy_hz) + 1
    for k in range(1, most + 1):
        observation, reward, terminated, truncated, info = env.step(action)
        check_info(info)
        assert info["time_s"] == k / clock.policy_hz
        assert env.observation_space.contains(observation)
        values = [v for v in info.values() if isinstance(v, float)]
        assert not any(math.isnan(v) for v in [reward, *values])
        assert math.isfinite(reward)
        assert 0.0 <= info["speed_mps"] <= 70.0
        actors = env.world.snapshot(info["time_s"]).actors
        for name in ("x", "y", "z", "yaw", "pitch", "speed", "gait_phase", "gait_stride", "head_yaw"):
            assert np.isfinite(actors[name]).all(), name
        assert (actors["speed"] >= 0).all()
        if terminated or truncated:
            assert info["outcome"] != Outcome.RUNNING
            return
    raise AssertionError(f"still running after {most} steps: {info}")


@many
@given(config=CONFIG, seed=st.integers(0, 2**32), pick=st.floats(0, 1))
def play_allowed_settings(config, seed, pick):
    try:
        play(CrossingEnv(config), seed, pick, {})
    except ConfigError:
        # does not count as an example: another is drawn
        reject()
    played.append(seed)


@many
@given(drawn=SCENARIO, ego=EGO, seed=st.integers(0, 99), pick=st.floats(0, 1))
def play_an_allowed_scenario(drawn, ego, seed, pick):
    try:
        play(CrossingEnv({"modalities": (), "ego": ego}), seed, pick, {"scenario": scenario(drawn)})
    except ConfigError:
        reject()
    played.append(seed)


@pytest.mark.parametrize("property_of", [play_allowed_settings, play_an_allowed_scenario])
def test_what_is_allowed_plays_to_its_end(property_of):
    played.clear()
    property_of()
    assert len(played) >= EXAMPLES / 2


@many
@given(config=spoilt(CONFIG, ODD | st.just("clear")), seed=st.integers(0, 2**32), pick=st.floats(0, 1))
def test_absurd_settings_play_or_are_refused(config, seed, pick):
    try:
        play(CrossingEnv(config), seed, pick, {})
    except ConfigError as error:
        event(f"refused: {str(error)[:60]}")


@many
@given(drawn=spoilt(SCENARIO), ego=EGO, seed=st.integers(0, 99), pick=st.floats(0, 1))
def test_an_absurd_scenario_plays_or_is_refused(drawn, ego, seed, pick):
    try:
        play(CrossingEnv({"modalities": (), "ego": ego}), seed, pick, {"scenario": scenario(drawn)})
    except ConfigError as error:
        event(f"refused: {str(error)[:60]}")
