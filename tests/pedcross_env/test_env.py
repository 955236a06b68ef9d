"""The environment as Gymnasium, Stable-Baselines3 and a user see it."""

import math
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as sb3_check_env

import pedcross_env
from pedcross_env.birds_eye import ASPHALT, EGO, PAINT, SIDEWALK
from pedcross_env.contracts import INFO_KEYS, Outcome, check_info
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import ConfigError
from pedcross_env.scenario import Intersection, PedestrianSpec, Scenario, StreetSpec

SMALL = {"camera": {"width_px": 64, "height_px": 48}}
BRAKE, HOLD = np.array([-1.0], np.float32), np.array([0.0], np.float32)


def small(**settings):
    return CrossingEnv(SMALL | settings)


def play(env, seed, action=HOLD, steps=400, **options):
    observations, infos = [], []
    observation, info = env.reset(seed=seed, options=options)
    for _ in range(steps):
        observations.append(observation)
        infos.append(info)
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            break
    return [*observations, observation], [*infos, info]


def test_gymnasium_finds_the_environment_and_its_checker_has_no_complaint():
    env = gymnasium.make("pedcross/Crossing-v0", config=SMALL, render_mode="rgb_array")
    assert pedcross_env.__version__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Gymnasium itself warns that speeds have a finite range nobody normalised; that is not about us.
        warnings.filterwarnings("ignore", message=".*not normalized.*")
        check_env(env.unwrapped)


def test_stable_baselines_checker_has_no_complaint():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sb3_check_env(small())


def test_every_step_has_the_same_info_keys_of_plain_types():
    _, infos = play(small(), seed=1, steps=12)
    for info in infos:
        check_info(info)
        assert set(info) == set(INFO_KEYS)


def test_same_seed_same_episode_bit_for_bit():
    runs = [play(small(weather=("rain",)), seed=7, steps=15) for _ in range(2)]
    for first, second in zip(*(observations for observations, _ in runs), strict=True):
        for key in first:
            assert np.array_equal(first[key], second[key]), key
    assert repr(runs[0][1]) == repr(runs[1][1])


def test_an_episode_replays_from_the_seed_in_its_info():
    env = small(modalities=())
    env.reset(seed=3)
    _, drawn = env.reset()
    _, again = env.reset(seed=drawn["episode_seed"])
    assert repr(drawn) == repr(again)


def test_another_weather_is_the_same_crossing():
    env = small(modalities=())
    clear, _ = play(env, 5, weather="clear", steps=60)
    foggy, _ = play(env, 5, weather="fog", steps=60)
    assert np.array_equal([o["ego"] for o in clear], [o["ego"] for o in foggy])


@pytest.mark.parametrize("modalities", [(), ("rgb",), ("dvs",), ("rgb", "dvs")])
def test_only_the_modalities_asked_for_are_observed(modalities):
    env = small(modalities=modalities)
    observations, _ = play(env, seed=2, steps=3)
    assert all(set(o) == {"ego", *modalities} for o in observations)
    assert all(env.observation_space.contains(o) for o in observations)


def test_dvs_alone_and_beside_rgb_give_the_same_events():
    alone, _ = play(small(modalities=("dvs",)), seed=4, steps=10)
    beside, _ = play(small(modalities=("rgb", "dvs")), seed=4, steps=10)
    for first, second in zip(alone, beside, strict=True):
        assert np.array_equal(first["dvs"], second["dvs"])


def test_events_on_request_add_up_to_the_observation():
    env = small(modalities=("dvs",), return_events=True)
    observations, infos = play(env, seed=4, steps=10)
    for observation, info in zip(observations, infos, strict=True):
        counts = np.zeros(observation["dvs"].shape, int)
        events = info["events"]
        np.add.at(counts, (events["y"], events["x"], np.where(events["pol"], 0, 1)), 1)
        assert np.array_equal(np.minimum(counts, 255), observation["dvs"])


def test_a_moving_view_gives_events_and_an_observer_at_rest_few():
    moving, _ = play(small(modalities=("dvs",)), seed=1, steps=10)
    scenario = Scenario(name="still", ego_speed_mps=0.0)
    resting, _ = play(small(modalities=("dvs",)), seed=1, steps=10, scenario=scenario)
    assert sum(int(o["dvs"].sum()) for o in moving) > 10 * sum(int(o["dvs"].sum()) for o in resting)


def test_braking_ends_every_episode_standing_or_hit_before():
    env = small(modalities=())
    for seed in range(10):
        observations, infos = play(env, seed, action=BRAKE)
        assert infos[-1]["outcome"] in (Outcome.TIMEOUT, Outcome.COLLISION)
        assert all(o["ego"][0] >= 0 for o in observations)


def test_a_pedestrian_in_the_lane_is_hit_by_who_does_not_brake_and_reward_says_so():
    scenario = Scenario(
        name="standing in the lane", pedestrians=(PedestrianSpec(behaviour="standing", x_m=30.0, y_m=-1.75),)
    )
    env = small(modalities=())
    env.reset(seed=0, options={"scenario": scenario})
    terminated = False
    while not terminated:
        _, reward, terminated, _, info = env.step(HOLD)
    assert info["outcome"] == Outcome.COLLISION
    assert info["impact_speed_mps"] == pytest.approx(10.0, abs=0.01)
    assert reward < -5


def test_views_for_people():
    env = CrossingEnv(SMALL | {"modalities": ()}, render_mode="rgb_array", view="birds_eye")
    env.reset(seed=0)
    above = env.render()
    assert above.dtype == np.uint8
    assert above.shape[2] == 3
    assert env.driver_view().shape == (48, 64, 3)


def test_nothing_touches_the_global_random_state():
    np.random.seed(0)  # noqa: NPY002
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    play(small(weather=("rain",)), seed=1, steps=3)
    assert np.array_equal(before, np.random.get_state()[1])  # noqa: NPY002


@pytest.mark.parametrize(
    ("make", "hint"),
    [
        (lambda: CrossingEnv({"weathr": ["clear"]}), "weather"),
        (lambda: CrossingEnv({"weather": ["fogg"]}), "'fog'"),
        (lambda: CrossingEnv({"modalities": ["dsv"]}), "'dvs'"),
        (lambda: CrossingEnv({"camera": {"width": 3}}), "'width_px'"),
        (lambda: CrossingEnv({"world": {"tick_hz": 100}}), "multiple of policy_hz"),
        (lambda: CrossingEnv({"return_events": True, "modalities": ["rgb"]}), "dvs"),
        (lambda: CrossingEnv(render_mode="rgb"), "'rgb_array'"),
        (lambda: small(modalities=()).reset(options={"wether": "fog"}), "'weather'"),
        (lambda: small(modalities=()).step(HOLD), "reset"),
    ],
)
def test_bad_settings_are_refused_by_name(make, hint):
    with pytest.raises(ConfigError, match=hint):
        make()


def test_nan_action_is_refused():
    env = small(modalities=())
    env.reset(seed=0)
    with pytest.raises(ConfigError, match="nan"):
        env.step(np.array([math.nan], np.float32))


@pytest.mark.parametrize(
    ("street", "turn"),
    [
        (StreetSpec(intersection=Intersection(x_m=60.0)), "left"),
        (StreetSpec(curvature_per_m=1 / 60), "straight"),
    ],
)
def test_from_above_the_ego_is_on_the_carriageway_of_any_street(street, turn):
    env = CrossingEnv(SMALL | {"modalities": ()})
    env.reset(
        seed=0, options={"scenario": Scenario(name="s", street=street, ego_turn=turn, ego_speed_mps=12.0)}
    )
    for step in range(190):
        env.step(HOLD)
        if step % 30 == 0:
            above = env.birds_eye()
            assert (above == EGO).all(axis=2).any()
            rows, columns = np.nonzero((above == EGO).all(axis=2))
            around = above[
                max(0, rows.min() - 3) : rows.max() + 4, max(0, columns.min() - 3) : columns.max() + 4
            ]
            assert not (around == SIDEWALK).all(axis=2).any()
            rim = [*around[[0, -1]].reshape(-1, 3).tolist(), *around[:, [0, -1]].reshape(-1, 3).tolist()]
            # the rest: what lies between stripes and road, blended
            assert np.mean([tuple(pixel) in (ASPHALT, PAINT) for pixel in rim]) > 0.4
