"""Street coordinates, lanes and turns against elementary geometry."""

import math

import numpy as np
import pytest

from pedcross_env.errors import ConfigError
from pedcross_env.scenario.layout import (
    lane_path,
    lanes,
    side_street,
    to_side_street,
    to_street,
    to_world,
    turning_path,
)
from pedcross_env.scenario.street import Crosswalk, Intersection, StreetSpec

LEFT = StreetSpec(curvature_per_m=1 / 50, curve_start_x_m=20.0, curve_length_m=70.0)
RIGHT = StreetSpec(curvature_per_m=-1 / 40, curve_start_x_m=-10.0, curve_length_m=40.0)
CROSSED = StreetSpec(intersection=Intersection(x_m=60.0))


@pytest.mark.parametrize("street", [StreetSpec(), LEFT, RIGHT], ids=["straight", "left", "right"])
def test_street_and_world_coordinates_are_inverse(street):
    s, d = np.meshgrid(np.linspace(-60, 240, 151), np.linspace(-12, 12, 25))
    x, y, _ = to_world(street, s, d)
    back_s, back_d = to_street(street, x, y)
    np.testing.assert_allclose(back_s, s, atol=1e-9)
    np.testing.assert_allclose(back_d, d, atol=1e-9)


@pytest.mark.parametrize("street", [LEFT, RIGHT], ids=["left", "right"])
def test_the_curve_is_a_circle_about_its_centre_and_tangent_at_both_ends(street):
    k, start, length = street.curvature_per_m, street.curve_start_x_m, street.curve_length_m
    x, y, heading = to_world(street, np.linspace(start, start + length, 50))
    np.testing.assert_allclose(np.hypot(x - start, y - 1 / k), 1 / abs(k), rtol=1e-12)
    assert heading[-1] == pytest.approx(k * length)
    line = np.linspace(start - 5, start + length + 5, 4001)
    x, y, heading = to_world(street, line)
    step = line[1] - line[0]
    np.testing.assert_allclose(np.hypot(np.diff(x), np.diff(y)), step, rtol=1e-6)
    middle = 0.5 * (heading[1:] + heading[:-1])
    np.testing.assert_allclose(np.unwrap(np.arctan2(np.diff(y), np.diff(x))), middle, atol=1e-4)


def test_left_is_left_of_the_way():
    x, y, heading = to_world(LEFT, 60.0, 0.0)
    left_x, left_y, _ = to_world(LEFT, 60.0, 2.0)
    assert (left_x - x, left_y - y) == pytest.approx((-2 * math.sin(heading), 2 * math.cos(heading)))


def test_the_side_street_meets_the_main_street_at_its_middle():
    assert [float(v) for v in to_side_street(CROSSED, 60.0, 0.0)] == [0.0, 0.0]
    assert [float(v) for v in to_side_street(CROSSED, 58.0, 30.0)] == [30.0, 2.0]
    side = side_street(CROSSED)
    assert side.straight
    assert (side.kerb_y_m, side.facade_y_m) == (CROSSED.intersection.kerb_m, CROSSED.intersection.facade_m)
    # its zebras lie beyond the main street's kerb, where the corners end
    assert [c.x_m - 0.5 * c.width_m for c in side.crosswalks if c.x_m > 0] == [CROSSED.kerb_y_m + 6.0]


def test_lanes_keep_to_the_right():
    assert lanes(StreetSpec(lane_width_m=3.0, lanes_per_direction=2)) == (
        (-4.5, 1), (-1.5, 1), (1.5, -1), (4.5, -1),
    )  # fmt: skip
    path = lane_path(LEFT, 1.75, from_s_m=30.0, to_s_m=10.0)
    assert path[-1] == pytest.approx((10.0, 1.75, math.pi))


@pytest.mark.parametrize("turn", ["left", "right", "straight"])
@pytest.mark.parametrize("quarter_turns", [0, 1, 2, 3])
def test_a_turn_starts_and_ends_in_the_right_hand_lane(turn, quarter_turns):
    path = turning_path(CROSSED, turn, quarter_turns=quarter_turns, before_m=20.0, after_m=20.0, step_m=0.1)
    for (x, y, heading), at in ((path[0], 0), (path[-1], 1)):
        quarter = quarter_turns + at * {"left": 1, "right": -1, "straight": 0}[turn]
        assert heading == pytest.approx(quarter * math.pi / 2)
        forward = (math.cos(heading), math.sin(heading))
        to_the_right = (x - 60.0) * forward[1] - y * forward[0]
        assert to_the_right == pytest.approx(1.75 if quarter % 2 == 0 else 1.625)


@pytest.mark.parametrize("turn", ["left", "right"])
def test_a_turn_is_smooth_and_a_quarter_of_a_circle(turn):
    path = turning_path(CROSSED, turn, before_m=5.0, after_m=5.0, step_m=0.05)
    steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
    np.testing.assert_allclose(steps, 0.05, rtol=1e-3)
    direction = np.unwrap(np.arctan2(np.diff(path[:, 1]), np.diff(path[:, 0])))
    np.testing.assert_allclose(direction, 0.5 * (path[1:, 2] + path[:-1, 2]), atol=1e-3)
    bending = np.abs(np.diff(path[:, 2])) / 0.05
    radius = {"left": 3.25 + 1.625 + 6.0, "right": 3.25 - 1.625 + 6.0}[turn]
    assert bending.max() == pytest.approx(1 / radius, rel=1e-6)
    # a body 1.8 m wide stays on the carriageway, corners rounded
    x, y = np.abs(path[:, 0] - 60.0), np.abs(path[:, 1])
    p = CROSSED.kerb_y_m + 6.0 - y
    q = CROSSED.intersection.kerb_m + 6.0 - x
    inside = np.hypot(np.maximum(p, 0), np.maximum(q, 0)) + np.minimum(np.maximum(p, q), 0) - 6.0
    assert inside.min() > 0.9


def test_a_street_keeps_its_hash_and_default_is_straight():
    assert hash(CROSSED) == hash(StreetSpec(intersection=Intersection(x_m=60.0)))
    assert StreetSpec().straight
    assert not CROSSED.straight
    assert CROSSED.straightened().straight
    assert len(CROSSED.all_crosswalks) == 2


@pytest.mark.parametrize(
    "values",
    [
        {"curvature_per_m": 1 / 12},
        {"curvature_per_m": math.nan},
        {"curvature_per_m": 1 / 50, "curve_length_m": 200.0},
        {"curvature_per_m": 1e-9},
        {"intersection": Intersection(x_m=239.0)},
        {"intersection": Intersection(x_m=60.0), "curvature_per_m": 0.01, "curve_start_x_m": 70.0},
        {"crosswalks": (Crosswalk(x_m=500.0),)},
    ],
)
def test_impossible_streets_are_refused(values):
    with pytest.raises(ConfigError):
        StreetSpec(**values)


def test_ways_through_an_intersection_need_one():
    with pytest.raises(ConfigError, match="intersection"):
        turning_path(StreetSpec(), "left")
    with pytest.raises(ConfigError, match="straight"):
        turning_path(CROSSED, "strait")
