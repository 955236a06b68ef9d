"""The ego's brakes against kinematics worked out by hand and by brute force."""

import itertools
import math

import pytest

from pedcross_env.config import EgoConfig
from pedcross_env.errors import ConfigError
from pedcross_env.world.ego import GRAVITY_MPS2, EgoMotion


def stopping_distance_m(config: EgoConfig, speed: float, friction: float) -> float:
    """Latency, then a ramp of constant jerk, then constant braking."""
    braking = min(config.max_deceleration_mps2, friction * GRAVITY_MPS2)
    ramp_s = braking / config.jerk_mps3
    after_ramp = speed - 0.5 * config.jerk_mps3 * ramp_s**2
    ramp_m = speed * ramp_s - config.jerk_mps3 * ramp_s**3 / 6
    return speed * config.latency_s + ramp_m + after_ramp**2 / (2 * braking)


def drive(motion: EgoMotion, demands: list[float], policy_hz: int = 30) -> None:
    for step, demand in enumerate(demands):
        motion.begin(demand)
        motion.advance((step + 1) / policy_hz)


@pytest.mark.parametrize("policy_hz", [5, 30])
@pytest.mark.parametrize("friction", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("speed", [5.0, 13.9, 20.0])
def test_stopping_distance_is_the_analytic_one(speed: float, friction: float, policy_hz: int) -> None:
    config = EgoConfig()
    motion = EgoMotion(config, friction=friction, x_m=0.0, speed_mps=speed)
    drive(motion, [-9.0] * 30 * policy_hz, policy_hz)
    state = motion.state(30.0)
    assert state.speed_mps == 0.0
    assert state.x_m == pytest.approx(stopping_distance_m(config, speed, friction), abs=1e-9)


@pytest.mark.parametrize("load_kg", [0.0, 300.0, 750.0])
@pytest.mark.parametrize("friction", [0.3, 0.85])
def test_a_load_weakens_the_brakes_but_not_the_road(friction: float, load_kg: float) -> None:
    config, speed = EgoConfig(load_kg=load_kg, build_up_s=0.0), 13.9
    motion = EgoMotion(config, friction=friction, x_m=0.0, speed_mps=speed)
    drive(motion, [-9.0] * 900)
    braking = min(9.0 * 1500 / (1500 + load_kg), friction * GRAVITY_MPS2)
    ramp_s = braking / config.jerk_mps3
    # v (latency + T / 2) + v^2 / 2a - a T^2 / 24
    way_m = speed * (config.latency_s + ramp_s / 2) + speed**2 / (2 * braking) - braking * ramp_s**2 / 24
    assert motion.state(30.0).x_m == pytest.approx(way_m, abs=1e-9)
    assert motion.state(30.0).speed_mps == 0.0


def test_a_load_is_no_heavier_than_the_car() -> None:
    with pytest.raises(ConfigError, match=r"load_kg = 1501"):
        EgoConfig(load_kg=1501.0)


def test_full_braking_never_reverses_and_stands_still() -> None:
    motion = EgoMotion(EgoConfig(), friction=0.85, x_m=0.0, speed_mps=10.0)
    last = 0.0
    for step in range(120):
        motion.begin(-9.0)
        motion.advance((step + 1) / 30)
        for k in range(8):
            x, speed = motion.motion((step + k / 8) / 30)
            assert speed >= 0.0
            assert x >= last - 1e-12
            last = x
    assert motion.state(4.0).acceleration_mps2 == 0.0
    assert motion.state(4.0).brake > 0.9


def test_zero_demand_holds_the_speed() -> None:
    motion = EgoMotion(EgoConfig(), friction=0.85, x_m=2.0, speed_mps=10.0)
    drive(motion, [0.0] * 90)
    assert motion.motion(3.0) == (pytest.approx(32.0), 10.0)


def test_a_standing_car_with_zero_demand_stays() -> None:
    motion = EgoMotion(EgoConfig(), friction=0.85, x_m=0.0, speed_mps=0.0)
    drive(motion, [0.0, -9.0] * 30)
    assert motion.motion(2.0) == (0.0, 0.0)


def test_less_friction_stops_later() -> None:
    stops = []
    for friction in (0.85, 0.5, 0.3, 0.1):
        motion = EgoMotion(EgoConfig(), friction=friction, x_m=0.0, speed_mps=12.0)
        drive(motion, [-9.0] * 600)
        stops.append(motion.motion(20.0)[0])
    assert stops == sorted(stops)
    assert stops[-1] > 3 * stops[0]


def test_any_sequence_of_demands_matches_a_brute_force_integration() -> None:
    config = EgoConfig(latency_s=0.13)
    demands = [3.0, 3.0, -9.0, 0.0, -2.0, -9.0, -9.0, -9.0, 3.0, 3.0, -9.0, -9.0, 1.0, 0.0, 0.0]
    motion = EgoMotion(config, friction=0.6, x_m=0.0, speed_mps=3.0)
    grip, dt = 0.6 * GRAVITY_MPS2, 1e-5
    x, v, u = 0.0, 3.0, 0.0
    for step in range(len(demands)):
        motion.begin(demands[step])
        motion.advance((step + 1) / 5)
        for k in range(20_000):
            age = step / 5 + k * dt - config.latency_s
            target = max(-grip, min(3.0, grip, demands[math.floor(age * 5 + 1e-9)])) if age >= -1e-9 else 0.0
            u += max(-config.jerk_mps3 * dt, min(config.jerk_mps3 * dt, target - u))
            v = max(0.0, v + u * dt)
            x += v * dt
        assert motion.motion((step + 1) / 5) == (pytest.approx(x, abs=2e-3), pytest.approx(v, abs=2e-3))


def test_the_nose_dives_smoothly_under_braking() -> None:
    motion = EgoMotion(EgoConfig(), friction=0.85, x_m=0.0, speed_mps=10.0)
    pitches = []
    for step in range(75):
        motion.begin(-9.0)
        motion.advance((step + 1) / 30)
        pitches += [motion.state((step + k / 10) / 30).pitch_rad for k in range(10)]
    assert max(pitches) > 0.02
    assert max(abs(b - a) for a, b in itertools.pairwise(pitches)) < 0.001
    assert abs(pitches[-1]) < 0.002


def test_friction_out_of_range_is_named() -> None:
    with pytest.raises(ConfigError, match="friction = 0"):
        EgoMotion(EgoConfig(), friction=0.0, x_m=0.0, speed_mps=1.0)


@pytest.mark.parametrize("policy_hz", [7, 30])
@pytest.mark.parametrize("build_up_s", [0.0, 0.2, 0.4])
@pytest.mark.parametrize(("latency_s", "friction"), [(0.1, 0.85), (0.3, 0.4)])
def test_stopping_distance_is_latency_build_up_and_v2_over_2a(
    latency_s: float, friction: float, build_up_s: float, policy_hz: int
) -> None:
    """v (latency + ramp / 2) + v^2 / 2a - a ramp^2 / 24 for a ramp of constant rate: exact."""
    speed, jerk = 14.0, 1e5
    config = EgoConfig(latency_s=latency_s, jerk_mps3=jerk, build_up_s=build_up_s)
    braking = min(config.max_deceleration_mps2, friction * GRAVITY_MPS2)
    rate = min(jerk, config.max_deceleration_mps2 / build_up_s if build_up_s else jerk)
    ramp_s = braking / rate
    motion = EgoMotion(config, friction=friction, x_m=0.0, speed_mps=speed)
    drive(motion, [-9.0] * 12 * policy_hz, policy_hz)
    expected = speed * (latency_s + 0.5 * ramp_s) + speed**2 / (2 * braking) - braking * ramp_s**2 / 24
    assert motion.state(12.0).x_m == pytest.approx(expected, abs=1e-9)


def test_abs_brakes_at_the_roads_limit_and_locked_wheels_below_it() -> None:
    for abs_on, share in ((True, 1.0), (False, 0.75)):
        motion = EgoMotion(EgoConfig(abs=abs_on), friction=0.5, x_m=0.0, speed_mps=20.0)
        drive(motion, [-9.0] * 45)
        assert motion.state(1.5).acceleration_mps2 == pytest.approx(-share * 0.5 * GRAVITY_MPS2)
        gentle = EgoMotion(EgoConfig(abs=abs_on), friction=0.5, x_m=0.0, speed_mps=20.0)
        drive(gentle, [-4.0] * 45)
        assert gentle.state(1.5).acceleration_mps2 == pytest.approx(-4.0)


def test_braking_builds_up_at_its_own_rate_and_the_throttle_goes_first() -> None:
    config = EgoConfig(latency_s=0.0, build_up_s=0.9, jerk_mps3=30.0)
    motion = EgoMotion(config, friction=0.95, x_m=0.0, speed_mps=20.0)
    drive(motion, [3.0] * 30)
    motion.begin(-9.0)
    motion.advance(2.0)
    assert motion.state(1.1).acceleration_mps2 == pytest.approx(0.0)
    assert motion.state(1.1 + 0.45).acceleration_mps2 == pytest.approx(-4.5)
    assert motion.state(2.0).acceleration_mps2 == pytest.approx(-9.0)
