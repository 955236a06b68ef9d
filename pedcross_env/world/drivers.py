"""The drivers of other vehicles: IDM along a way, stopping for people, giving way, changing line when triggered."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from pedcross_env.scenario.route import Route
from pedcross_env.scenario.scenario import Maneuver, VehicleSpec
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.trigger import Fires
from pedcross_env.world.ego import settle
from pedcross_env.world.highway import IDMVehicle, Road, Vehicle
from pedcross_env.world.lanes import RouteLane

__all__ = ["GIVE_WAY_S", "HARDEST_BRAKING_MPS2", "Driver", "Hazard", "Passive", "Phase"]

HARDEST_BRAKING_MPS2 = 6.0  # highway-env's IDMVehicle.ACC_MAX; a maneuver may ask for more
_BRAKE_LIGHT_FROM_MPS2 = 0.7
_YIELD_GAP_M = 2.0  # kept to a pedestrian's path
_YIELD_TIME_GAP_S = 0.8
_SPARE_S = 0.5
GIVE_WAY_S = 1.5  # kept free of who has the right of way
_SHORTEST_CHANGE_M = 8.0
_FREE_AHEAD_M, _FREE_BEHIND_S = 3.0, 1.0  # to change lines: room before, and time until who comes from behind


class Hazard(NamedTuple):
    """Somebody's stay in the way of a vehicle, by distances along that way."""

    start_s: float
    end_s: float
    near_m: float
    far_m: float
    radius_m: float


class Phase(NamedTuple):
    """A driver between two decisions: constant acceleration that ends at standstill, on a way with its lines.

    Attributes:
        start_s: Of the phase.
        along_m: Distance along the way then.
        speed_mps: Then.
        acceleration_mps2: Until the vehicle stands.
        pitch_rad: Nose dive then.
        line: (from m, length m, left before, left after) of the last change of lines.
    """

    start_s: float
    along_m: float
    speed_mps: float
    acceleration_mps2: float
    pitch_rad: float
    line: tuple[float, float, float, float]

    def run(self, time_s: float) -> tuple[float, float]:
        """(distance along the way, speed) at a time."""
        elapsed, a, v = max(0.0, time_s - self.start_s), self.acceleration_mps2, self.speed_mps
        if a < 0 and elapsed * -a >= v:
            return self.along_m - 0.5 * v * v / a, 0.0
        return self.along_m + elapsed * (v + 0.5 * a * elapsed), v + a * elapsed

    def pitch(self, time_s: float) -> float:
        """Nose dive at a time, rad."""
        elapsed, a, v = max(0.0, time_s - self.start_s), self.acceleration_mps2, self.speed_mps
        moving = min(elapsed, -v / a) if a < 0 else elapsed
        diving = settle(self.pitch_rad, -a, 0.0, moving)
        return float(settle(diving, 0.0, 0.0, elapsed - moving))

    def beside(self, along_m: float) -> tuple[float, float]:
        """(metres to the left of the way, heading relative to it) where the vehicle is at ``along_m``."""
        start, length, before, after = self.line
        share = (along_m - start) / length if length > 0 else 1.0
        if share >= 1.0:
            return after, 0.0
        if share <= 0.0:
            return before, 0.0
        # quintic: neither heading nor curvature jumps at either end
        left = before + (after - before) * share**3 * (10 - 15 * share + 6 * share * share)
        slope = (after - before) * 30 * (share * (1 - share)) ** 2 / length
        return left, math.atan(slope)

    def braking(self, speed_mps: float) -> bool:
        """Whether the brake lights are lit."""
        return self.acceleration_mps2 < -_BRAKE_LIGHT_FROM_MPS2 or speed_mps < 0.05


class Passive(Vehicle):
    """A vehicle that others see but highway-env does not move: the ego, and whatever stands in a lane."""

    def __init__(
        self, road: Road, position: tuple[float, float], heading: float, size_m: tuple[float, float]
    ) -> None:
        super().__init__(road, list(position), heading, 0.0)
        self.LENGTH, self.WIDTH = size_m
        self.check_collisions = False

    def act(self, action: dict | str | None = None) -> None:
        """Do nothing."""

    def step(self, dt: float) -> None:
        """Do nothing."""


class Driver(IDMVehicle):
    """IDM along a way, never backwards; who will be in its way is a standing obstacle to it.

    Args:
        road: With the ego and all others.
        spec: Where it starts, how fast, what it is.
        route: Its way.
        left_m: Where it starts, to the left of the way.
        width_m: Of its lane.
        lane_d_m: The way's line in street coordinates; nan for one that turns.
    """

    def __init__(
        self, road: Road, spec: VehicleSpec, route: Route, left_m: float, width_m: float, lane_d_m: float
    ) -> None:
        super().__init__(road, [spec.x_m, spec.y_m], spec.yaw_rad, spec.speed_mps, enable_lane_change=False)
        size = vehicle_size(spec.model)
        self.LENGTH, self.WIDTH = size.length_m, size.width_m
        self.check_collisions = False
        self.pedals = spec.model == "cyclist"
        self.way = route
        self.lane = RouteLane(route, width_m)
        self.hazards: list[Hazard] = []
        self.gives_way: Callable[[Driver], float] | None = None
        self._pending: list[tuple[Maneuver, float]] = [(maneuver, math.inf) for maneuver in spec.maneuvers]
        self._lane_d_m, self._forward = lane_d_m, 1.0 if math.cos(spec.yaw_rad) > 0 else -1.0
        self._limit_mps2: float | None = None
        along = route.project(spec.x_m, spec.y_m)[0]
        self.phase = Phase(0.0, along, spec.speed_mps, 0.0, 0.0, (along, 0.0, left_m, left_m))
        self.speed: float = spec.speed_mps

    @property
    def left_m(self) -> float:
        """The line it keeps, or is going over to, to the left of its way."""
        return self.phase.line[3]

    def follow_to(self, time_s: float) -> None:
        """Take highway-env's state to a time: position, heading, speed."""
        along, self.speed = self.phase.run(time_s)
        left, turned = self.phase.beside(along)
        x, y, heading = self.way.pose(along)
        self.position[0], self.position[1] = x - left * math.sin(heading), y + left * math.cos(heading)
        self.heading = heading + turned
        pitch = self.phase.pitch(time_s)
        self.phase = self.phase._replace(start_s=time_s, along_m=along, speed_mps=self.speed, pitch_rad=pitch)

    def start_maneuvers(self, fires: Fires, now_s: float) -> bool:
        """Begin the maneuvers that are due; returns whether one of them goes to another line."""
        place = (float(self.position[0]), float(self.position[1]), self.heading)
        waiting, turned = [], False
        for maneuver, due_s in self._pending:
            if due_s == math.inf and fires(maneuver.when, place, now_s):
                due_s = now_s + maneuver.when.delay_s
            if due_s <= now_s and self._start(maneuver):
                turned |= maneuver.to_y_m is not None
            else:
                waiting.append((maneuver, due_s))
        self._pending = waiting
        return turned

    def _start(self, maneuver: Maneuver) -> bool:
        """Begin a maneuver, unless the line it goes to is not free yet; returns whether it began."""
        if maneuver.to_y_m is not None:
            target = self._forward * (maneuver.to_y_m - self._lane_d_m)
            if not self._free_beside(target):
                return False
            along, (now, _) = self.phase.along_m, self.phase.beside(self.phase.along_m)
            length = max(_SHORTEST_CHANGE_M, self.speed * maneuver.duration_s)
            self.phase = self.phase._replace(line=(along, length, now, target))
        if maneuver.speed_mps is not None:
            self.target_speed, self._limit_mps2 = maneuver.speed_mps, maneuver.acceleration_mps2
        return True

    def _free_beside(self, left_m: float) -> bool:
        own = self.phase.along_m
        for other in self.road.vehicles:
            if other is self:
                continue
            along, left = self.way.project(float(other.position[0]), float(other.position[1]))
            if abs(left - left_m) >= 0.5 * (self.WIDTH + other.WIDTH):
                continue
            room = abs(along - own) - 0.5 * (self.LENGTH + other.LENGTH)
            with_us = math.cos(other.heading - self.heading) > 0
            closing = (self.speed - other.speed if with_us else self.speed + other.speed) * (
                1 if along > own else -1
            )
            if room < _FREE_AHEAD_M or room < closing * (_FREE_BEHIND_S if with_us else 4.0):
                return False
        return True

    def decide(self) -> None:
        """Choose the acceleration until the next decision."""
        front, rear = self._neighbours()
        acceleration = self._free_or_following(front, rear)
        for hazard in self.hazards:
            acceleration = min(acceleration, self._yielding(hazard))
        if self.gives_way is not None:
            gap = self.gives_way(self)
            if gap < math.inf:
                acceleration = min(acceleration, self._stopping(gap))
        hardest = max(HARDEST_BRAKING_MPS2, self._limit_mps2 or 0.0)
        acceleration = max(-hardest, min(HARDEST_BRAKING_MPS2, acceleration))
        self.phase = self.phase._replace(acceleration_mps2=acceleration)

    def _free_or_following(self, front: Vehicle | None, rear: Vehicle | None) -> float:
        if self._limit_mps2 is None:
            return float(self.acceleration(self, front, rear))
        short = self.target_speed - self.speed
        if abs(short) < 0.05 and self.target_speed > 0:
            self._limit_mps2 = None
        wanted = math.copysign(min(self._limit_mps2 or 0.0, abs(short) / 0.1), short)
        if front is None:
            return wanted
        # a target of 0 has no IDM: its interaction term alone, from a target that is out of reach
        kept, self.target_speed = self.target_speed, max(self.target_speed, self.speed, 1.0)
        following = float(self.acceleration(self, front, rear))
        self.target_speed = kept
        return min(wanted, following)

    def _neighbours(self) -> tuple[Vehicle | None, Vehicle | None]:
        """Who is ahead on the line it keeps or goes over to, and on the strip it still covers."""
        lane = self.lane
        own = lane.local_coordinates(self.position)[0]
        now, target = self.phase.beside(self.phase.along_m)[0], self.left_m
        low = min(now, target) - 0.5 * self.WIDTH
        high = max(now, target) + 0.5 * self.WIDTH
        nearest, front = math.inf, None
        for other in self.road.vehicles:
            if other is self:
                continue
            along, left = lane.local_coordinates(other.position)
            if not own <= along < nearest:
                continue
            turned = other.heading - lane.heading_at(along)
            across = other.WIDTH * abs(math.cos(turned)) + other.LENGTH * abs(math.sin(turned))
            if left + 0.5 * across > low - 0.2 and left - 0.5 * across < high + 0.2:
                nearest, front = along, other
        return front, None

    def desired_gap(
        self, ego_vehicle: Vehicle, front_vehicle: Vehicle = None, projected: bool = True
    ) -> float:
        """IDM's gap between centres, for the true lengths instead of highway-env's 5 m."""
        usual = super().desired_gap(ego_vehicle, front_vehicle, projected)
        return float(usual + 0.5 * (ego_vehicle.LENGTH + front_vehicle.LENGTH) - Vehicle.LENGTH)

    def _yielding(self, hazard: Hazard) -> float:
        """Acceleration that keeps clear of a pedestrian in its way; inf: nothing to yield to."""
        now, along, reach = self.phase.start_s, self.phase.along_m, hazard.radius_m + 0.5 * self.LENGTH
        gap = hazard.near_m - along - reach
        if gap < 0 or now > hazard.end_s:
            return math.inf
        cleared_s = now + (hazard.far_m - along + reach) / max(self.speed, 0.1)
        reached_s = now + gap / max(self.speed, 3.0)
        if cleared_s + _SPARE_S < hazard.start_s or reached_s - _SPARE_S > hazard.end_s:
            return math.inf
        return self._stopping(gap)

    def _stopping(self, gap_m: float) -> float:
        """IDM's acceleration towards something that stands ``gap_m`` ahead."""
        braking = 2.0 * math.sqrt(-self.COMFORT_ACC_MAX * self.COMFORT_ACC_MIN)
        wanted = _YIELD_GAP_M + self.speed * (_YIELD_TIME_GAP_S + self.speed / braking)
        free = 1.0 - (self.speed / max(self.target_speed, 0.1)) ** self.DELTA
        return float(self.COMFORT_ACC_MAX * (free - (wanted / max(gap_m, 0.1)) ** 2))
