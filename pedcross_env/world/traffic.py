"""Other vehicles on highway-env's road: IDM drivers that also stop for people, on a clock of their own.

Decisions fall every ``1 / TRAFFIC_HZ`` whatever the world's rates; in between the acceleration is constant,
so poses at any time are exact. Other drivers brake at up to 6 m/s2 on any road: they are scenery, the same in
all weathers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from highway_env.road.lane import LineType, StraightLane
from highway_env.road.road import Road, RoadNetwork
from highway_env.vehicle.behavior import IDMVehicle
from highway_env.vehicle.kinematics import Vehicle

from pedcross_env.config import EgoConfig
from pedcross_env.errors import ConfigError
from pedcross_env.scenario.scenario import Scenario, VehicleSpec
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.world.crossing import Stay, corridor_stays
from pedcross_env.world.ego import settle
from pedcross_env.world.pedestrians import Pedestrians

__all__ = ["HARDEST_BRAKING_MPS2", "TRAFFIC_HZ", "Traffic", "street_network"]

TRAFFIC_HZ = 10
HARDEST_BRAKING_MPS2 = IDMVehicle.ACC_MAX
_BRAKE_LIGHT_FROM_MPS2 = 0.7
_YIELD_GAP_M = 2.0  # kept to a pedestrian's path
_YIELD_TIME_GAP_S = 0.8
_SIDE_CLEARANCE_M = 0.5
_SPARE_S = 0.5


def street_network(street: StreetSpec) -> RoadNetwork:
    """Lanes of a street: ("west", "east", i) for +x and ("east", "west", i) for -x, i from the middle."""
    network = RoadNetwork()
    for sign, start, end in ((-1, "west", "east"), (1, "east", "west")):
        for index in range(street.lanes_per_direction):
            y = sign * (index + 0.5) * street.lane_width_m
            ends = [np.array([x, y]) for x in (street.start_x_m, street.end_x_m)]
            lines = (LineType.CONTINUOUS_LINE if index == 0 else LineType.STRIPED, LineType.STRIPED)
            first, last = ends if sign < 0 else ends[::-1]
            network.add_lane(
                start,
                end,
                StraightLane(first, last, width=street.lane_width_m, line_types=lines, speed_limit=None),
            )
    return network


class _Passive(Vehicle):
    """A vehicle that others see but highway-env does not move: the ego, and whatever stands in a lane."""

    def act(self, action: dict | str | None = None) -> None:
        """Do nothing."""

    def step(self, dt: float) -> None:
        """Do nothing."""


class _Driver(IDMVehicle):
    """IDM along its lane, never backwards; who will be in its way is a standing obstacle to it."""

    def __init__(self, road: Road, spec: VehicleSpec, hazards: list[tuple[Stay, float]]) -> None:
        heading = 0.0 if math.cos(spec.yaw_rad) > 0 else math.pi
        super().__init__(road, [spec.x_m, spec.y_m], heading, spec.speed_mps, enable_lane_change=False)
        size = vehicle_size(spec.model)
        self.LENGTH, self.WIDTH = size.length_m, size.width_m
        self.sign = 1.0 if heading == 0.0 else -1.0
        self.check_collisions = False
        self.speed: float = spec.speed_mps
        self.now_s = 0.0
        self._hazards = hazards

    def act(self, action: dict | str | None = None) -> None:
        """Choose the acceleration until the next decision."""
        front, rear = self.road.neighbour_vehicles(self, self.lane_index)
        acceleration = float(self.acceleration(self, front, rear))
        for stay, radius in self._hazards:
            acceleration = min(acceleration, self._yielding(stay, radius))
        self.action = {"steering": 0.0, "acceleration": max(-self.ACC_MAX, min(self.ACC_MAX, acceleration))}

    def desired_gap(
        self, ego_vehicle: Vehicle, front_vehicle: Vehicle = None, projected: bool = True
    ) -> float:
        """IDM's gap between centres, for the true lengths instead of highway-env's 5 m."""
        usual = super().desired_gap(ego_vehicle, front_vehicle, projected)
        return float(usual + 0.5 * (ego_vehicle.LENGTH + front_vehicle.LENGTH) - Vehicle.LENGTH)

    def _yielding(self, stay: Stay, radius_m: float) -> float:
        """Acceleration that keeps clear of a pedestrian in the lane; inf: nothing to yield to."""
        x = float(self.position[0])
        near, far = (stay.x_low_m, stay.x_high_m) if self.sign > 0 else (stay.x_high_m, stay.x_low_m)
        gap = self.sign * (near - x) - radius_m - 0.5 * self.LENGTH
        if gap < 0 or self.now_s > stay.end_s:
            return math.inf
        cleared_s = self.now_s + (self.sign * (far - x) + radius_m + 0.5 * self.LENGTH) / max(self.speed, 0.1)
        reached_s = self.now_s + gap / max(self.speed, 3.0)
        if cleared_s + _SPARE_S < stay.start_s or reached_s - _SPARE_S > stay.end_s:
            return math.inf
        braking = 2.0 * math.sqrt(-self.COMFORT_ACC_MAX * self.COMFORT_ACC_MIN)
        wanted = _YIELD_GAP_M + self.speed * (_YIELD_TIME_GAP_S + self.speed / braking)
        free = 1.0 - (self.speed / max(self.target_speed, 0.1)) ** self.DELTA
        return float(self.COMFORT_ACC_MAX * (free - (wanted / max(gap, 0.1)) ** 2))

    def step(self, dt: float) -> None:
        """Move along the lane with constant acceleration, stopping at 0."""
        acceleration = self.action["acceleration"]
        moving_s = min(dt, -self.speed / acceleration) if acceleration < 0 else dt
        self.position[0] += self.sign * moving_s * (self.speed + 0.5 * acceleration * moving_s)
        self.speed = max(0.0, self.speed + acceleration * moving_s) if moving_s == dt else 0.0
        self.now_s += dt


class _Interval(NamedTuple):
    """State of all drivers at a decision; arrays are (M,)."""

    start_s: float
    x: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    pitch: np.ndarray


class Traffic:
    """The other vehicles of a scenario.

    Args:
        scenario: Street, vehicles; its street's seed varies the drivers.
        ego: The ego's size; drivers see it as a vehicle.
        pedestrians: People to stop for.

    Attributes:
        movers: Indices (into scenario.vehicles) of vehicles that drive.

    Raises:
        ConfigError: Where a vehicle that drives is not in a lane of its direction.
    """

    def __init__(self, scenario: Scenario, ego: EgoConfig, pedestrians: Pedestrians) -> None:
        street = scenario.street
        rng = np.random.RandomState(street.seed & 0xFFFFFFFF)
        self._road = Road(street_network(street), np_random=rng)
        self._ego = _Passive(self._road, [scenario.ego_x_m, street.ego_lane_y_m], 0.0, scenario.ego_speed_mps)
        self._ego.LENGTH, self._ego.WIDTH = ego.length_m, ego.width_m
        self._ego.check_collisions = False
        self._road.vehicles.append(self._ego)
        self.movers = [
            i for i, spec in enumerate(scenario.vehicles) if not spec.parked and spec.speed_mps > 0
        ]
        self._drivers = [self._driver(scenario.vehicles[i], street, pedestrians) for i in self.movers]
        self._road.vehicles.extend(self._drivers)
        for index, spec in enumerate(scenario.vehicles):
            if index not in self.movers:
                self._add_obstacle(spec, street)
        self._sign = np.array([driver.sign for driver in self._drivers])
        self._decisions = 0
        self._intervals: list[_Interval] = []
        self.decide_until(0.5 / TRAFFIC_HZ, None)  # at time 0

    def _driver(self, spec: VehicleSpec, street: StreetSpec, pedestrians: Pedestrians) -> _Driver:
        side = -1.0 if math.cos(spec.yaw_rad) > 0 else 1.0
        lanes = [side * (i + 0.5) * street.lane_width_m for i in range(street.lanes_per_direction)]
        offset = min(abs(spec.y_m - lane) for lane in lanes)
        if abs(math.sin(spec.yaw_rad)) > 1e-3 or offset > 0.5 * street.lane_width_m:
            raise ConfigError(
                f"VehicleSpec (y_m = {spec.y_m}, yaw_rad = {spec.yaw_rad}) drives outside the lanes of its "
                f"direction: yaw must be 0 with y near one of {[-abs(y) for y in lanes]}, "
                f"or pi with y near one of {[abs(y) for y in lanes]}."
            )
        half_width = 0.5 * vehicle_size(spec.model).width_m + _SIDE_CLEARANCE_M
        hazards = [
            (stay, float(radius))
            for walk, radius in zip(pedestrians.walks, pedestrians.radius_m, strict=True)
            for stay in corridor_stays(walk, spec.y_m, half_width + float(radius))
        ]
        driver = _Driver(self._road, spec, hazards)
        driver.randomize_behavior()
        return driver

    def _add_obstacle(self, spec: VehicleSpec, street: StreetSpec) -> None:
        size = vehicle_size(spec.model)
        across = size.width_m * abs(math.cos(spec.yaw_rad)) + size.length_m * abs(math.sin(spec.yaw_rad))
        if abs(spec.y_m) - 0.5 * across < street.lanes_per_direction * street.lane_width_m - 0.3:
            obstacle = _Passive(self._road, [spec.x_m, spec.y_m], spec.yaw_rad, 0.0)
            obstacle.LENGTH, obstacle.WIDTH, obstacle.check_collisions = size.length_m, size.width_m, False
            self._road.vehicles.append(obstacle)

    def forget(self, before_s: float) -> None:
        """Drop what no time from ``before_s`` on needs."""
        while len(self._intervals) > 1 and self._intervals[1].start_s <= before_s:
            self._intervals.pop(0)

    def decide_until(self, end_s: float, ego_motion: Callable[[float], tuple[float, float]] | None) -> None:
        """Take all decisions that fall before ``end_s``.

        Args:
            end_s: Time up to which the ego's motion is known.
            ego_motion: Function time -> (x, speed) of the ego; None: as the scenario starts.
        """
        while self._drivers and self._decisions / TRAFFIC_HZ < end_s - 1e-9:
            now = self._decisions / TRAFFIC_HZ
            if ego_motion is not None:
                self._ego.position[0], self._ego.speed = ego_motion(now)
            if self._decisions > 0:
                self._road.step(1.0 / TRAFFIC_HZ)
            last = self._intervals[-1] if self._intervals else None
            pitch = self._moved(last, now - last.start_s)[2] if last else np.zeros(len(self._drivers))
            self._road.act()
            self._intervals.append(
                _Interval(
                    now,
                    np.array([driver.position[0] for driver in self._drivers]),
                    np.array([driver.speed for driver in self._drivers]),
                    np.array([driver.action["acceleration"] for driver in self._drivers]),
                    pitch,
                )
            )
            self._decisions += 1

    def _moved(self, interval: _Interval, elapsed_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(x, speed, pitch) after ``elapsed_s`` of constant acceleration that ends at standstill."""
        a = interval.acceleration
        stop_s = np.where(a < 0, interval.speed / np.maximum(-a, 1e-9), np.inf)
        moving_s = np.minimum(elapsed_s, stop_s)
        x = interval.x + self._sign * moving_s * (interval.speed + 0.5 * a * moving_s)
        diving = settle(interval.pitch, -a, 0.0, moving_s)
        return (
            x,
            np.maximum(interval.speed + a * moving_s, 0.0),
            settle(diving, 0.0, 0.0, elapsed_s - moving_s),
        )

    def poses(self, time_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """(x, speed, pitch, brake light) of the drivers, each (M,), in the order of ``movers``."""
        if not self._intervals:
            return (np.zeros(0),) * 4
        interval = next(
            (i for i in reversed(self._intervals) if i.start_s <= time_s + 1e-9), self._intervals[0]
        )
        x, speed, pitch = self._moved(interval, max(0.0, time_s - interval.start_s))
        light = ((interval.acceleration < -_BRAKE_LIGHT_FROM_MPS2) | (speed < 0.05)).astype(np.float64)
        return x, speed, pitch, light
