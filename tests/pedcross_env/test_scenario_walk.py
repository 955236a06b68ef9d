"""Walks: where and when, by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pedcross_env.scenario import Leg, PedestrianSpec
from pedcross_env.scenario.walk import RAMP_S, Walk, cadence_hz


def walk(*legs: Leg) -> Walk:
    return Walk(PedestrianSpec(behaviour="x", x_m=0.0, y_m=0.0, legs=legs))


def test_a_leg_after_a_wait_loses_half_a_ramp_at_either_end() -> None:
    way = walk(Leg(to_x_m=6.0, to_y_m=0.0, speed_mps=1.5, wait_s=2.0))
    assert way.position(2.0) == (0.0, 0.0)
    assert way.position(2.0 + 2.0 + 0.5 * RAMP_S) == (pytest.approx(3.0), 0.0)
    assert way.end_s == pytest.approx(2.0 + 4.0 + RAMP_S)
    assert way.position(99.0) == (6.0, 0.0)


def test_a_first_leg_without_wait_is_under_way() -> None:
    way = walk(Leg(to_x_m=6.0, to_y_m=0.0, speed_mps=1.5))
    assert way.position(1.0) == (pytest.approx(1.5), 0.0)


def test_legs_without_wait_are_walked_on_without_stopping() -> None:
    way = walk(Leg(to_x_m=3.0, to_y_m=0.0, speed_mps=1.5), Leg(to_x_m=3.0, to_y_m=3.0, speed_mps=1.5))
    assert way.position(3.0) == (pytest.approx(3.0), pytest.approx(1.5))


def test_legs_that_lead_nowhere_only_wait() -> None:
    way = walk(
        Leg(to_x_m=0.0, to_y_m=0.0, speed_mps=1.0, wait_s=1.0),
        Leg(to_x_m=2.0, to_y_m=0.0, speed_mps=1.0, wait_s=0.5),
    )
    assert way.position(1.5) == (0.0, 0.0)
    assert way.end_s == pytest.approx(1.5 + 2.0 + RAMP_S)


def test_free_walking_takes_two_steps_a_second() -> None:
    assert 2 * cadence_hz(1.4, 1.75) == pytest.approx(2.0)
    assert cadence_hz(1.2, 1.15) > cadence_hz(1.2, 1.8)


coordinate = st.floats(-20, 20, allow_nan=False)
a_leg = st.builds(
    Leg, to_x_m=coordinate, to_y_m=coordinate,
    speed_mps=st.floats(0.3, 4), wait_s=st.sampled_from([0.0, 0.0, 0.4, 2.0]),
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(st.lists(a_leg, max_size=5))
def test_any_walk_is_continuous_and_ends_at_its_last_goal(legs: list[Leg]) -> None:
    way = walk(*legs)
    times = np.linspace(0, way.end_s + 1, 4000)
    xy = way.positions(times)
    assert np.isfinite(xy).all()
    steps = np.hypot(*np.diff(xy, axis=0).T)
    assert (steps <= way.top_speed_mps * (times[1] - times[0]) + 1e-6).all()
    if legs:
        assert math.dist(xy[-1], (legs[-1].to_x_m, legs[-1].to_y_m)) < 1e-5
    at = float(times[1234])
    assert way.position(at) == (pytest.approx(xy[1234, 0]), pytest.approx(xy[1234, 1]))
