import numpy as np
import pytest

from agents import AebConfig, AebPolicy, AebState, Policy
from pedcross_env.errors import ConfigError, DataError

STEP_S = 1 / 30


def drive(policy, probabilities, speed_mps=10.0):
    """Feed p(crossing) frame by frame at constant speed; return the actions."""
    policy.reset(0)
    actions = []
    for i, p in enumerate(probabilities):
        action = policy.act({}, {"time_s": i * STEP_S, "speed_mps": speed_mps}, p)
        assert action.shape == (1,)
        assert action.dtype == np.float32
        actions.append(float(action[0]))
    return actions


def test_aeb_fulfils_the_policy_protocol():
    assert isinstance(AebPolicy(), Policy)


def test_holds_the_speed_while_nothing_is_seen():
    assert drive(AebPolicy(), [0.0, 0.2, 0.49, None, 0.1]) == [0.0] * 5


def test_brakes_on_the_second_frame_in_a_row_and_not_on_a_single_outlier():
    assert drive(AebPolicy(), [0.9, 0.1, 0.9, 0.1, 0.9]) == [0.0] * 5
    assert drive(AebPolicy(), [0.1, 0.5, 0.5]) == [0.0, 0.0, -1.0]


@pytest.mark.parametrize("frames", [1, 2, 5])
def test_trigger_needs_exactly_the_configured_frames(frames):
    actions = drive(AebPolicy(AebConfig(consecutive_frames=frames)), [0.8] * 8)
    assert actions.index(-1.0) == frames - 1


def test_keeps_braking_between_the_two_thresholds():
    policy = AebPolicy(AebConfig(threshold=0.6, release_threshold=0.3))
    assert set(drive(policy, [0.9, 0.9] + [0.4] * 200)[1:]) == {-1.0}


def test_releases_after_release_s_below_the_release_threshold():
    policy = AebPolicy(AebConfig(release_s=0.5))
    actions = drive(policy, [0.9, 0.9] + [0.0] * 30, speed_mps=10.0)
    # the first low frame is number 2; 0.5 s = 15 frames later the brake is let go
    assert actions[1:17] == [-1.0] * 16
    assert actions[17] >= 0.0
    assert policy.state is AebState.CRUISE  # the speed never fell in this rollout


def test_a_high_frame_restarts_the_release_clock():
    policy = AebPolicy(AebConfig(release_s=0.5))
    actions = drive(policy, [0.9, 0.9] + [0.0] * 10 + [0.3] + [0.0] * 15)
    assert actions[1:] == [-1.0] * (len(actions) - 1)


def test_returns_to_the_set_speed_gently_and_without_overshoot():
    policy = AebPolicy()
    policy.reset(0)
    speed, time_s, speeds = 10.0, 0.0, []
    for i in range(600):
        action = float(policy.act({}, {"time_s": time_s, "speed_mps": speed}, 0.9 if i < 40 else 0.0)[0])
        assert action <= policy.config.resume_level
        speed = max(0.0, speed + STEP_S * action * (3.0 if action > 0 else 9.0))
        time_s += STEP_S
        speeds.append(speed)
    assert min(speeds) == 0.0
    assert max(speeds) <= 10.0 + 1e-6
    assert speeds[-1] == pytest.approx(10.0, abs=0.06)
    assert policy.state is AebState.CRUISE


def test_brakes_again_while_resuming():
    policy = AebPolicy()
    policy.reset(0)
    ps = [0.9] * 3 + [0.0] * 20 + [0.9] * 3
    states = []
    for i, p in enumerate(ps):
        policy.act({}, {"time_s": i * STEP_S, "speed_mps": 10.0 if i == 0 else 4.0}, p)
        states.append(policy.state)
    assert AebState.RESUME in states
    assert states[-1] is AebState.BRAKE


def test_no_estimate_yet_neither_triggers_nor_releases():
    assert drive(AebPolicy(), [None] * 5) == [0.0] * 5
    assert drive(AebPolicy(), [0.9, 0.9] + [None] * 30)[1:] == [-1.0] * 31


def test_reset_forgets_brake_and_set_speed():
    policy = AebPolicy()
    drive(policy, [0.9] * 5, speed_mps=12.0)
    assert drive(policy, [0.1], speed_mps=7.0) == [0.0]
    assert policy.set_speed_mps == 7.0


@pytest.mark.parametrize("p", [float("nan"), -0.1, 1.1])
def test_a_broken_probability_is_an_error_not_a_calm_detector(p):
    with pytest.raises(DataError, match="p_crossing"):
        drive(AebPolicy(), [p])


@pytest.mark.parametrize(
    "bad",
    [{"threshold": -0.1}, {"threshold": 1.5}, {"consecutive_frames": 0}, {"release_threshold": 0.7},
     {"release_s": -1.0}, {"braking_level": 0.0}, {"resume_level": 2.0}],
)  # fmt: skip
def test_config_refuses_what_cannot_work_and_names_it(bad):
    with pytest.raises(ConfigError, match=next(iter(bad))):
        AebConfig(**bad)
