"""highway-env's road network over a street's lanes, bends and side street included."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.errors import ConfigError
from pedcross_env.scenario.layout import lane_route, lanes, side_street, to_street, to_world, turning_route
from pedcross_env.scenario.route import Route
from pedcross_env.scenario.scenario import VehicleSpec
from pedcross_env.scenario.street import Intersection, StreetSpec
from pedcross_env.world.highway import AbstractLane, LineType, RoadNetwork

__all__ = ["RouteLane", "route_of", "street_network"]

_BEFORE_M = 1000.0  # a lane reaches so far back before its way begins


class RouteLane(AbstractLane):
    """A lane of highway-env along a Route, endless both ways.

    Args:
        route: Its middle.
        width_m: Its width.
    """

    def __init__(self, route: Route, width_m: float) -> None:
        self.route, self.width = route, width_m
        self.length = math.inf
        self.line_types = [LineType.STRIPED, LineType.STRIPED]
        self.forbidden, self.priority, self.speed_limit = False, 0, None
        x, y, heading = route.pose(0.0)
        self._line = (x, y, math.cos(heading), math.sin(heading)) if route.straight else None

    def position(self, longitudinal: float, lateral: float) -> np.ndarray:
        """Place at lane coordinates, metres."""
        x, y, heading = self.route.pose(longitudinal - _BEFORE_M)
        return np.array([x - lateral * math.sin(heading), y + lateral * math.cos(heading)])

    def local_coordinates(self, position: np.ndarray) -> tuple[float, float]:
        """(along, to the left) of a place, metres."""
        px, py = float(position[0]), float(position[1])
        if self._line is None:
            along, left = self.route.project(px, py)
        else:
            x, y, cos, sin = self._line
            along, left = (px - x) * cos + (py - y) * sin, (py - y) * cos - (px - x) * sin
        return along + _BEFORE_M, left

    def heading_at(self, longitudinal: float) -> float:
        """Heading of the lane, rad."""
        return self.route.pose(longitudinal - _BEFORE_M)[2]

    def width_at(self, longitudinal: float) -> float:
        """Width, metres."""
        return self.width

    def to_config(self) -> dict:
        """highway-env's interface; lanes come from a StreetSpec, never from its configs."""
        raise NotImplementedError("a RouteLane is made from a StreetSpec")


def street_network(street: StreetSpec) -> RoadNetwork:
    """Lanes: ("west", "east", i) for +x and ("east", "west", i) for -x, i from the right-hand kerb.

    A side street adds ("south", "north", i) for +y and ("north", "south", i) for -y.
    """
    network = RoadNetwork()
    for offset, direction in lanes(street):
        ends = ("west", "east") if direction > 0 else ("east", "west")
        network.add_lane(
            *ends, RouteLane(lane_route(street, offset, forward=direction > 0), street.lane_width_m)
        )
    if street.intersection is not None:
        side = side_street(street)
        for offset, direction in lanes(side):
            ends = ("south", "north") if direction > 0 else ("north", "south")
            start = (street.intersection.x_m - offset, 0.0, math.copysign(0.5 * math.pi, direction))
            network.add_lane(*ends, RouteLane(Route([(math.inf, 0.0)], start=start), side.lane_width_m))
    return network


def route_of(spec: VehicleSpec, street: StreetSpec) -> tuple[Route, float, float]:
    """The way of a vehicle that drives.

    Returns:
        The way; where the vehicle starts to the left of it, metres (0 in the middle of its lane); the way's
        distance to the left of the street's centre line, nan for one that turns or follows the side street.

    Raises:
        ConfigError: Where it is not in a lane of its direction, turns where no side street is, or is to change its line
            while it turns or comes along the side street.
    """
    s, d = (float(v) for v in to_street(street, spec.x_m, spec.y_m))
    turned = spec.yaw_rad - float(to_world(street, s)[2])
    quarter = round(turned / (0.5 * math.pi)) % 4
    found = None
    if abs(math.remainder(turned, 0.5 * math.pi)) < 1e-3:
        if street.intersection is not None and (spec.turn or quarter % 2 == 1):
            found = _through(spec, street, street.intersection, quarter)
        elif quarter % 2 == 0 and not spec.turn:
            found = _along(street, d, 1 if quarter == 0 else -1)
    if found is not None:
        _require_line(spec, found[2])
        return found
    right, wrong = (sorted(offset for offset, way in lanes(street) if way == sign) for sign in (1, -1))
    raise ConfigError(
        f"VehicleSpec (x_m = {spec.x_m}, y_m = {spec.y_m}, yaw_rad = {spec.yaw_rad}, turn = {spec.turn!r}) drives "
        f"outside the lanes of its direction: yaw must be the street's (0) with y near one of {right}, or the opposite "
        f"(pi) with y near one of {wrong}; it may turn, or come along y, at a street's intersection only; a right turn "
        "starts in the outermost lane, a left turn in the innermost one."
    )


def _require_line(spec: VehicleSpec, lane_d_m: float) -> None:
    """Refuse a maneuver to a line of the street for a vehicle that does not follow one."""
    lines = [maneuver.to_y_m for maneuver in spec.maneuvers if maneuver.to_y_m is not None]
    if lines and math.isnan(lane_d_m):
        raise ConfigError(
            f"Maneuver.to_y_m = {lines[0]:g} is not allowed for a vehicle with turn = {spec.turn!r}, "
            f"yaw_rad = {spec.yaw_rad:g}: only one that drives along the street goes over to another line of it; "
            'leave to_y_m out, or turn = "" and yaw_rad = 0 (along x) or pi (against it).'
        )


def _along(street: StreetSpec, d_m: float, direction: int) -> tuple[Route, float, float] | None:
    for offset, way in lanes(street):
        if way == direction and abs(d_m - offset) <= 0.5 * street.lane_width_m:
            return lane_route(street, offset, forward=way > 0), way * (d_m - offset), offset
    return None


def _through(
    spec: VehicleSpec, street: StreetSpec, crossing: Intersection, quarter: int
) -> tuple[Route, float, float] | None:
    width = street.lane_width_m if quarter % 2 == 0 else crossing.lane_width_m
    route = turning_route(street, spec.turn or "straight", quarter_turns=quarter)
    left = route.project(spec.x_m, spec.y_m)[1]
    return (route, left, math.nan) if abs(left) <= 0.5 * width else None
