"""Drivers: one that holds its speed, one that is late."""

import itertools
import math

import numpy as np
import pytest

from agents import Policy
from agents.drivers import CruiseDriver, HumanConfig, HumanDriver
from pedcross_env.config import EgoConfig
from pedcross_env.errors import ConfigError
from pedcross_env.world.ego import EgoMotion


def info(time_s: float, speed_mps: float = 10.0) -> dict[str, float]:
    return {"time_s": time_s, "speed_mps": speed_mps}


def first_braking_s(driver: HumanDriver, seed: int, seen_s: float, hz: int = 30) -> float:
    driver.reset(seed)
    for step in itertools.count():
        time = step / hz
        if driver.act({}, info(time), float(time >= seen_s - 1e-9))[0] < 0:
            return time


def test_drivers_are_policies() -> None:
    assert isinstance(CruiseDriver(), Policy)
    assert isinstance(HumanDriver(), Policy)


@pytest.mark.parametrize("seed", [0, 1, 7])
@pytest.mark.parametrize("hz", [10, 30])
def test_a_person_brakes_a_reaction_time_after_what_it_sees(seed: int, hz: int) -> None:
    driver = HumanDriver()
    braked = first_braking_s(driver, seed, seen_s=2.0, hz=hz)
    assert 0 <= braked - 2.0 - driver.reaction_s < 1 / hz + 1e-6
    assert first_braking_s(driver, seed, seen_s=2.0, hz=hz) == braked


def test_reaction_times_are_log_normal_as_configured() -> None:
    driver, drawn = HumanDriver(HumanConfig(median_reaction_s=1.0, spread=0.3)), []
    for seed in range(2000):
        driver.reset(seed)
        drawn.append(driver.reaction_s)
    logs = np.log(drawn)
    assert logs.mean() == pytest.approx(0.0, abs=4 * 0.3 / math.sqrt(2000))
    assert logs.std() == pytest.approx(0.3, rel=0.1)


def test_a_person_lets_go_late_too_and_drives_on() -> None:
    driver = HumanDriver(HumanConfig(median_reaction_s=1.0, spread=0.0))
    driver.reset(0)
    actions = [float(driver.act({}, info(step / 30, 5.0 if step > 50 else 10.0), float(30 <= step < 60))[0])
               for step in range(200)]  # fmt: skip
    assert min(actions) == pytest.approx(-0.8)
    last = max(step for step, action in enumerate(actions) if action < 0)
    assert last == pytest.approx(60 + 30 + 0.8 * 30, abs=1)
    assert actions[-1] > 0


def test_who_cruises_comes_back_to_its_speed_without_overshoot() -> None:
    config, driver = EgoConfig(), CruiseDriver()
    motion = EgoMotion(config, friction=0.85, x_m=0.0, speed_mps=10.0)
    speeds = []
    for step in range(600):
        speed = motion.motion(step / 30)[1]
        action = float(driver.act({}, info(step / 30, speed), 1.0)[0])
        demand = action * (config.max_acceleration_mps2 if action > 0 else config.max_deceleration_mps2)
        motion.begin(-4.0 if 30 <= step < 60 else demand)
        motion.advance((step + 1) / 30)
        speeds.append(motion.motion((step + 1) / 30)[1])
    assert speeds[28] == 10.0
    assert min(speeds) < 6.5
    assert speeds[-1] == pytest.approx(10.0, abs=0.05)
    assert max(speeds) < 10.2


def test_bad_settings_are_named() -> None:
    with pytest.raises(ConfigError, match="median_reaction_s = -1"):
        HumanConfig(median_reaction_s=-1)
    with pytest.raises(ConfigError, match="gain_per_s = 0"):
        CruiseDriver(0.0)
