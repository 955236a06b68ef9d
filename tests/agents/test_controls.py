import numpy as np
import pytest

from agents import CONTROLS, AebConfig, AebPolicy, AebState, HumanDriver, braking_policy, make_control
from pedcross_env.errors import ConfigError


def series(name, seed=0, steps=300, crossing=0):
    control = make_control(name)
    control.reset(seed)
    return [control.update({"time_s": i / 30, "crossing": crossing}) for i in range(steps)]


def test_the_controls_are_there():
    assert list(CONTROLS) == ["oracle", "human", "never", "always", "random"]


@pytest.mark.parametrize("name", ["oracle", "human"])
def test_oracle_and_human_see_the_label(name):
    assert set(series(name, crossing=0)) == {0.0}
    assert set(series(name, crossing=1)) == {1.0}


def test_a_person_brakes_behind_the_human_and_the_shared_logic_behind_all_others():
    aeb = AebConfig(threshold=0.7)
    assert isinstance(braking_policy("human", aeb), HumanDriver)
    for name in (*(name for name in CONTROLS if name != "human"), "sps_r18t-dvs"):
        policy = braking_policy(name, aeb)
        assert isinstance(policy, AebPolicy)
        assert policy.config == aeb


def test_never_and_always_ignore_the_truth():
    assert set(series("never", crossing=1)) == {0.0}
    assert set(series("always", crossing=0)) == {1.0}


def test_random_is_seeded_and_blind():
    assert series("random", seed=3) == series("random", seed=3, crossing=1)
    assert series("random", seed=3) != series("random", seed=4)


def test_random_is_uniform_and_redrawn_each_second():
    values = np.array(series("random", steps=30 * 2000)).reshape(2000, 30)
    assert (values == values[:, :1]).all()
    assert values.mean() == pytest.approx(0.5, abs=0.03)
    assert np.quantile(values[:, 0], 0.9) == pytest.approx(0.9, abs=0.03)


def test_random_begins_to_brake_in_about_one_free_second_of_ten():
    control = make_control("random")
    policy = AebPolicy(AebConfig(threshold=control.threshold))
    control.reset(1)
    policy.reset(1)
    free_steps = triggers = 0
    before = policy.state
    for i in range(30 * 3000):
        info = {"time_s": i / 30, "crossing": 0, "speed_mps": 10.0}
        policy.act({}, info, control.update(info))
        free_steps += before is not AebState.BRAKE
        triggers += policy.state is AebState.BRAKE and before is not AebState.BRAKE
        before = policy.state
    assert triggers / (free_steps / 30) == pytest.approx(0.1, abs=0.03)


def test_unknown_control_names_the_nearest():
    with pytest.raises(ConfigError, match="Did you mean 'oracle'"):
        make_control("oracel")
