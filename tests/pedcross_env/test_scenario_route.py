"""Ways of lines and arcs against elementary geometry."""

import math

import numpy as np
import pytest

from pedcross_env.errors import ConfigError
from pedcross_env.scenario.layout import carriageway_m, lane_route, to_world, turning_route
from pedcross_env.scenario.route import Route
from pedcross_env.scenario.street import Intersection, StreetSpec

CURVED = StreetSpec(curvature_per_m=1 / 50, curve_start_x_m=20.0, curve_length_m=70.0)
CROSSED = StreetSpec(intersection=Intersection(x_m=60.0))
WAY = Route([(10.0, 0.0), (15.0, 0.1), (math.inf, -0.02)], start=(2.0, -1.0, 0.3), start_m=5.0)


def test_poses_are_the_integral_of_the_heading():
    s = np.linspace(-5.0, 60.0, 200_001)
    x, y, heading = WAY.poses(s)
    middle = 0.5 * (heading[1:] + heading[:-1])
    ds = s[1] - s[0]
    np.testing.assert_allclose(np.diff(x), ds * np.cos(middle), atol=1e-8)
    np.testing.assert_allclose(np.diff(y), ds * np.sin(middle), atol=1e-8)
    one = WAY.pose(float(s[123_456]))
    assert one == pytest.approx((x[123_456], y[123_456], heading[123_456]), abs=1e-9)


@pytest.mark.parametrize("s", [-3.0, 7.0, 15.0, 22.0, 29.9, 40.0])
@pytest.mark.parametrize("d", [-3.0, 0.0, 2.5])
def test_projection_is_the_inverse_of_a_step_aside(s, d):
    x, y, heading = WAY.pose(s)
    found = WAY.project(x - d * math.sin(heading), y + d * math.cos(heading))
    assert found == pytest.approx((s, d), abs=1e-9)


@pytest.mark.parametrize("forward", [True, False])
def test_a_lane_of_a_bend_keeps_its_distance_from_the_centre_line(forward):
    way = lane_route(CURVED, -1.75, forward=forward)
    s = np.linspace(0.0, 120.0, 61) if forward else np.linspace(-150.0, 0.0, 61)
    x, y, _ = way.poses(s)
    line = np.linspace(-20, 200, 40001)
    cx, cy, _ = to_world(CURVED, line, 0.0)
    gap = [np.hypot(cx - a, cy - b).min() for a, b in zip(x, y, strict=True)]
    np.testing.assert_allclose(gap, 1.75, atol=1e-4)


@pytest.mark.parametrize("quarter_turns", [0, 1, 2, 3])
@pytest.mark.parametrize("turn", ["left", "right", "straight"])
def test_a_turn_begins_at_the_edge_and_stays_on_the_carriageway(turn, quarter_turns):
    way = turning_route(CROSSED, turn, quarter_turns=quarter_turns)
    middle = 60.0 if quarter_turns == 0 else 0.0
    x, y, _ = way.poses(np.linspace(middle - 50.0, middle + 60.0, 300))
    assert carriageway_m(CROSSED, x, y).min() > -1.3  # within the rounded corner


def test_places_are_inside_by_their_distance_to_the_kerb():
    assert float(carriageway_m(StreetSpec(), 10.0, -5.0)) == pytest.approx(0.7)
    assert float(carriageway_m(CROSSED, 60.0, 30.0)) == pytest.approx(3.25)
    assert float(carriageway_m(CROSSED, 70.0, 30.0)) == pytest.approx(3.25 - 10.0)


def test_a_way_needs_pieces_that_lead_somewhere():
    with pytest.raises(ConfigError, match="at least one"):
        Route([])
    with pytest.raises(ConfigError, match="positive"):
        Route([(0.0, 0.1)])
    with pytest.raises(ConfigError, match="endless"):
        Route([(math.inf, 0.0), (3.0, 0.0)])
