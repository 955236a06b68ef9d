"""Where things are on streets that bend or are crossed: street coordinates, lanes, ways through an intersection.

Street coordinates are s, metres along the centre line (x where the street is straight), and d, metres to its left (y).
"""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from pedcross_env.config import require
from pedcross_env.errors import ConfigError, unknown_name
from pedcross_env.scenario.route import Route
from pedcross_env.scenario.street import Crosswalk, Intersection, StreetSpec

__all__ = [
    "TURNS", "Turn", "carriageway_m", "facade_m", "lane_path", "lane_route", "lanes", "side_street", "to_side_street",
    "to_street", "to_world", "turning_path", "turning_route",
]  # fmt: skip

Turn = Literal["left", "right", "straight"]
TURNS: tuple[Turn, ...] = get_args(Turn)


def to_world(
    street: StreetSpec, s: ArrayLike, d: ArrayLike = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Convert street coordinates to the world's.

    Args:
        street: Any layout.
        s: Metres along the centre line, any shape.
        d: Metres to the left of it, broadcast against ``s``.

    Returns:
        x and y in metres and the street's heading in rad (0 along x, positive to the left), of the common shape.
    """
    s, d = np.broadcast_arrays(np.asarray(s, np.float64), np.asarray(d, np.float64))
    k, start = street.curvature_per_m, street.curve_start_x_m
    if k == 0:
        return s.copy(), d.copy(), np.zeros_like(s)
    arc = np.clip(s - start, 0.0, street.curve_length_m)
    heading = k * arc
    sine, cosine = np.sin(heading), np.cos(heading)
    beyond = np.maximum(0.0, s - start - street.curve_length_m) + np.minimum(0.0, s - start)
    # 2 sin^2(a / 2) for 1 - cos a keeps its digits where the street hardly bends
    x = start + sine / k + beyond * cosine - d * sine
    y = 2 * np.sin(0.5 * heading) ** 2 / k + beyond * sine + d * cosine
    return x, y, heading


def to_street(street: StreetSpec, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Convert world coordinates to the main street's; the inverse of ``to_world`` out to the curve's centre.

    Args:
        street: Any layout.
        x: Metres, any shape.
        y: Metres, broadcast against ``x``.

    Returns:
        s and d, in metres, of the common shape.
    """
    x, y = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
    k, start, length = street.curvature_per_m, street.curve_start_x_m, street.curve_length_m
    if k == 0:
        return x.copy(), y.copy()
    side, radius = math.copysign(1.0, k), 1 / abs(k)
    ahead, inward = x - start, radius - side * y
    angle = np.arctan2(ahead, inward)
    angle = np.where(angle < 0, angle + 2 * math.pi, angle)
    end = abs(k) * length
    sine, cosine = math.sin(end), math.cos(end)
    on_arc = start + angle * radius, side * (radius - np.hypot(ahead, inward))
    beyond = start + length + ahead * cosine - inward * sine
    after = beyond, side * (radius - ahead * sine - inward * cosine)
    s = np.where(ahead < 0, x, np.where(angle <= end, on_arc[0], after[0]))
    d = np.where(ahead < 0, y, np.where(angle <= end, on_arc[1], after[1]))
    return s, d


def _crossing(street: StreetSpec) -> Intersection:
    if street.intersection is None:
        raise ConfigError(
            "StreetSpec.intersection = None: there is no side street; give one, e.g. "
            "StreetSpec(intersection=Intersection(x_m=60.0))."
        )
    return street.intersection


def side_street(street: StreetSpec) -> StreetSpec:
    """Return the side street as a straight street of its own.

    Its s runs along the world's y from -length_m to length_m, 0 where it meets the main street's centre line, and its d
    is measured towards -x: see ``to_side_street``.

    Raises:
        ConfigError: Where there is no intersection.
    """
    crossing = _crossing(street)
    away = street.kerb_y_m + crossing.corner_radius_m + 0.5 * crossing.crosswalk_width_m
    zebras = tuple(
        Crosswalk(x_m=sign * away, width_m=crossing.crosswalk_width_m)
        for sign in (-1, 1)
        if crossing.crosswalk_width_m > 0
    )
    return StreetSpec(
        start_x_m=-crossing.length_m, end_x_m=crossing.length_m, lane_width_m=crossing.lane_width_m,
        lanes_per_direction=crossing.lanes_per_direction, parking_width_m=crossing.parking_width_m,
        sidewalk_width_m=crossing.sidewalk_width_m, kerb_height_m=street.kerb_height_m, crosswalks=zebras,
        seed=street.seed + 7919,
    )  # fmt: skip


def to_side_street(street: StreetSpec, x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Convert world coordinates to the side street's s (along y) and d (towards -x).

    Raises:
        ConfigError: Where there is no intersection.
    """
    crossing = _crossing(street)
    x, y = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
    return y.copy(), crossing.x_m - x


def lanes(street: StreetSpec) -> tuple[tuple[float, int], ...]:
    """Return each lane's centre line as (d in metres, 1 with s or -1 against it), from right to left."""
    width, count = street.lane_width_m, street.lanes_per_direction
    return tuple(((k + 0.5 - count) * width, 1 if k < count else -1) for k in range(2 * count))


def lane_path(
    street: StreetSpec, d_m: float, *, from_s_m: float, to_s_m: float, step_m: float = 0.5
) -> np.ndarray:
    """Return the way along a line at constant distance from the centre line.

    Args:
        street: Any layout.
        d_m: To the left of the centre line.
        from_s_m: Where it starts.
        to_s_m: Where it ends; smaller than ``from_s_m`` to drive against s.
        step_m: Along the centre line.

    Returns:
        (N, 3) float64: x, y in metres, heading in rad.
    """
    require(step_m > 0, "step_m", step_m, "positive")
    count = max(2, math.ceil(abs(to_s_m - from_s_m) / step_m) + 1)
    x, y, heading = to_world(street, np.linspace(from_s_m, to_s_m, count), d_m)
    return np.stack([x, y, heading + (math.pi if to_s_m < from_s_m else 0.0)], axis=1)


def carriageway_m(street: StreetSpec, x: ArrayLike, y: ArrayLike) -> np.ndarray:
    """How far inside the carriageway a place is: metres to the nearest kerb, negative beyond it.

    At an intersection both streets' carriageways count, rounded corners included.

    Args:
        street: Any layout.
        x: Metres, any shape.
        y: Metres, broadcast against ``x``.
    """
    inside = street.kerb_y_m - np.abs(to_street(street, x, y)[1])
    crossing = street.intersection
    if crossing is None:
        return np.asarray(inside)
    aside = crossing.kerb_m - np.abs(to_side_street(street, x, y)[1])
    radius = crossing.corner_radius_m
    p, q = radius + inside, radius + aside  # to the lines on which the corner's centre lies
    corner = np.where((p > 0) & (q > 0) & (p < radius) & (q < radius), np.hypot(p, q) - radius, -np.inf)
    return np.asarray(np.maximum(np.maximum(inside, aside), corner))


def facade_m(street: StreetSpec, x: ArrayLike, y: ArrayLike) -> np.ndarray:
    """How far before the house fronts a place is: metres to the nearest, negative inside a house.

    Args:
        street: Any layout.
        x: Metres, any shape.
        y: Metres, broadcast against ``x``.
    """
    before = street.facade_y_m - np.abs(to_street(street, x, y)[1])
    crossing = street.intersection
    if crossing is None:
        return np.asarray(before)
    s, d = to_side_street(street, x, y)
    return np.asarray(
        np.maximum(before, np.minimum(crossing.facade_m - np.abs(d), crossing.length_m - np.abs(s)))
    )


def lane_route(street: StreetSpec, d_m: float, *, forward: bool = True) -> Route:
    """Return the way along a line at constant distance from the main street's centre line.

    Args:
        street: Any layout.
        d_m: To the left of the centre line.
        forward: Along s, else against it.

    Returns:
        Without end. Distances along it are s where the way begins: x of a straight street; against s, -x.
    """
    k, first, length = street.curvature_per_m, street.curve_start_x_m, street.curve_length_m
    if k == 0:
        start = (street.start_x_m, d_m, 0.0) if forward else (street.end_x_m, d_m, math.pi)
        return Route([(math.inf, 0.0)], start=start, start_m=start[0] if forward else -start[0])
    arc = (length * (1 - k * d_m), k / (1 - k * d_m))
    ends = [(max(first - street.start_x_m, 1.0), 0.0), (max(street.end_x_m - first - length, 1.0), 0.0)]
    if forward:
        begin = first - ends[0][0]
        return Route([ends[0], arc, (math.inf, 0.0)], start=(begin, d_m, 0.0), start_m=begin)
    begin = first + length + ends[1][0]
    x, y, heading = (float(v) for v in to_world(street, begin, d_m))
    return Route(
        [ends[1], (arc[0], -arc[1]), (math.inf, 0.0)], start=(x, y, heading + math.pi), start_m=-begin
    )


def turning_route(street: StreetSpec, turn: Turn, *, quarter_turns: int = 0) -> Route:
    """Return a way through the intersection: straight, a quarter of a circle, straight without end.

    A right turn keeps to the lanes nearest the kerb, around the centre of the kerb's corner; a left turn goes from
    innermost lane to innermost lane, between the inner edges of the zebras.

    Args:
        street: With an intersection.
        turn: "left", "right" or "straight" (in the lane nearest the kerb).
        quarter_turns: Heading of the approach: 0 along x, 1 along y, 2 against x, 3 against y.

    Returns:
        Distances along it are counted from the approach's own origin: x on the main street with ``quarter_turns`` 0,
        else from the intersection's middle.

    Raises:
        ConfigError: Where there is no intersection, or for an unknown turn.
    """
    crossing = _crossing(street)
    if turn not in TURNS:
        raise unknown_name("turn", turn, TURNS)
    own, other = (street, side_street(street)) if quarter_turns % 2 == 0 else (side_street(street), street)
    sign = {"left": 1.0, "right": -1.0, "straight": 0.0}[turn]
    inner = turn == "left"
    entry = -0.5 * own.lane_width_m if inner else own.ego_lane_y_m
    leave = sign * (-0.5 * other.lane_width_m if inner else other.ego_lane_y_m) * -1.0
    corner = crossing.corner_radius_m
    if inner:
        radius = min(other.kerb_y_m + leave, own.kerb_y_m - entry) + corner
    else:
        radius = min(other.kerb_y_m - abs(leave), own.kerb_y_m - abs(entry)) + corner
    base = 0.5 * math.pi * quarter_turns
    c, s = round(math.cos(base)), round(math.sin(base))
    approach = crossing.x_m - street.start_x_m if quarter_turns % 4 == 0 else crossing.length_m
    start = (crossing.x_m - c * approach - s * entry, -s * approach + c * entry, base)
    start_m = street.start_x_m if quarter_turns % 4 == 0 else -approach
    if not sign:
        return Route([(math.inf, 0.0)], start=start, start_m=start_m)
    arc = (0.5 * math.pi * radius, sign / radius)
    return Route([(approach + leave - radius, 0.0), arc, (math.inf, 0.0)], start=start, start_m=start_m)


def turning_path(
    street: StreetSpec,
    turn: Turn,
    *,
    quarter_turns: int = 0,
    before_m: float = 30.0,
    after_m: float = 30.0,
    step_m: float = 0.25,
) -> np.ndarray:
    """Return points of ``turning_route``.

    Args:
        street: With an intersection.
        turn: "left", "right" or "straight".
        quarter_turns: Heading of the approach: 0 along x, 1 along y, 2 against x, 3 against y.
        before_m: Length of the straight way before the curve (before the middle for "straight").
        after_m: Beyond it.
        step_m: Distance between points along the way.

    Returns:
        (N, 3) float64: x, y in metres, heading in rad (not wrapped), every ``step_m`` of arc length.

    Raises:
        ConfigError: Where there is no intersection, or for an unknown turn.
    """
    require(step_m > 0, "step_m", step_m, "positive")
    route = turning_route(street, turn, quarter_turns=quarter_turns)
    if turn == "straight":
        crossing = _crossing(street)
        begin, arc = (crossing.x_m if quarter_turns % 4 == 0 else 0.0), 0.0
    else:
        begin, end = route.breaks_m
        arc = end - begin
    along = np.arange(0.0, before_m + arc + after_m + 1e-9, step_m) - before_m
    return np.stack(route.poses(begin + along), axis=1)
