"""Other vehicles on highway-env's road, on a clock of their own.

Decisions fall every ``1 / TRAFFIC_HZ`` whatever the world's rates; in between the acceleration is constant, so poses at
any time are exact. Other drivers brake at up to 6 m/s2 on any road: they are scenery, the same in all weathers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from pedcross_env.config import EgoConfig
from pedcross_env.scenario.layout import to_street, to_world
from pedcross_env.scenario.scenario import Scenario, VehicleSpec
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.trigger import Fires
from pedcross_env.world.crossing import way_stays
from pedcross_env.world.doors import Doors
from pedcross_env.world.drivers import GIVE_WAY_S, HARDEST_BRAKING_MPS2, Driver, Hazard, Passive, Phase
from pedcross_env.world.highway import Road
from pedcross_env.world.lanes import route_of, street_network
from pedcross_env.world.pedestrians import Pedestrians

__all__ = ["HARDEST_BRAKING_MPS2", "TRAFFIC_HZ", "DrivingPoses", "Traffic"]

TRAFFIC_HZ = 10
_SIDE_CLEARANCE_M = 0.5
_TINY_S = 1e-9
_PEDALLED_M = 5.0  # way of a bicycle per turn of the crank: 70 turns a minute at 5.8 m/s

EgoPose = tuple[float, float, float, float]
"""x and y of the ego's centre in metres, heading in rad, speed in m/s."""


class DrivingPoses(NamedTuple):
    """State of the vehicles that drive, each (M,) float64; units and meanings as in ACTOR_DTYPE."""

    x: np.ndarray
    y: np.ndarray
    yaw: np.ndarray
    speed: np.ndarray
    pitch: np.ndarray
    brake_light: np.ndarray
    gait_phase: np.ndarray  # turns of a cyclist's crank


class Traffic:
    """The other vehicles of a scenario.

    Args:
        scenario: Street, vehicles; its street's seed varies the drivers.
        ego: The ego's size; drivers see it as a vehicle.
        pedestrians: People to stop for.

    Attributes:
        movers: Indices (into scenario.vehicles) of vehicles that drive.
        doors: The doors of parked cars that may open.

    Raises:
        ConfigError: Where a vehicle that drives is not in a lane of its direction.
    """

    def __init__(self, scenario: Scenario, ego: EgoConfig, pedestrians: Pedestrians) -> None:
        street = scenario.street
        self._scenario, self._people = scenario, pedestrians
        rng = np.random.RandomState(street.seed & 0xFFFFFFFF)
        self._road = Road(street_network(street), np_random=rng)
        ego_size = (ego.length_m, ego.width_m)
        self._ego = Passive(self._road, (scenario.ego_x_m, street.ego_lane_y_m), 0.0, ego_size)
        self._ego.speed = scenario.ego_speed_mps
        self._road.vehicles.append(self._ego)
        self.movers = [
            i for i, spec in enumerate(scenario.vehicles)
            if not spec.parked and (spec.speed_mps > 0 or spec.maneuvers)
        ]  # fmt: skip
        self._drivers = [self._driver(scenario.vehicles[i]) for i in self.movers]
        self._road.vehicles.extend(self._drivers)
        for index, spec in enumerate(scenario.vehicles):
            if index not in self.movers:
                self._add_obstacle(spec)
        self.doors = Doors(scenario.vehicles)
        self._decisions = 0
        self._history: list[tuple[float, tuple[Phase, ...]]] = []
        self.see_people()
        self.decide_until(0.5 / TRAFFIC_HZ, None, None)  # at time 0

    def _driver(self, spec: VehicleSpec) -> Driver:
        street = self._scenario.street
        route, left, lane_d = route_of(spec, street)
        driver = Driver(self._road, spec, route, left, street.lane_width_m, lane_d)
        driver.randomize_behavior()
        if spec.turn and street.intersection is not None:
            driver.gives_way = partial(self._way_given, spec=spec)
        return driver

    def see_people(self) -> None:
        """Look anew where people will be in the drivers' ways: at the start, and whenever somebody's way changes."""
        for index, driver in zip(self.movers, self._drivers, strict=True):
            spec = self._scenario.vehicles[index]
            driver.hazards = []
            if not spec.yields:
                continue
            half_width = 0.5 * driver.WIDTH + _SIDE_CLEARANCE_M
            for walk, radius in zip(self._people.walks, self._people.radius_m, strict=True):
                for stay in way_stays(walk, driver.way, driver.left_m, half_width + float(radius)):
                    driver.hazards.append(
                        Hazard(stay.start_s, stay.end_s, stay.x_low_m, stay.x_high_m, float(radius))
                    )

    def _add_obstacle(self, spec: VehicleSpec) -> None:
        street, size = self._scenario.street, vehicle_size(spec.model)
        at, aside = to_street(street, spec.x_m, spec.y_m)
        turned = spec.yaw_rad - float(to_world(street, at)[2])
        across = size.width_m * abs(math.cos(turned)) + size.length_m * abs(math.sin(turned))
        if abs(float(aside)) - 0.5 * across < street.lanes_per_direction * street.lane_width_m - 0.3:
            self._road.vehicles.append(
                Passive(self._road, (spec.x_m, spec.y_m), spec.yaw_rad, (size.length_m, size.width_m))
            )

    def _way_given(self, driver: Driver, *, spec: VehicleSpec) -> float:
        """Distance to where a turning driver must wait now, inf where it need not."""
        crossing = self._scenario.street.intersection
        if crossing is None or (spec.turn != "left" and abs(math.sin(spec.yaw_rad)) < 0.5):
            return math.inf
        breaks = driver.way.breaks_m
        enter = breaks[0] if breaks else driver.way.project(crossing.x_m, 0.0)[0] - crossing.kerb_m
        leave = breaks[-1] if breaks else enter + 2 * crossing.kerb_m
        gap = enter - driver.phase.along_m - 0.5 * driver.LENGTH
        if gap < 0 or gap > 40.0:
            return math.inf
        clear_s = (leave - driver.phase.along_m + driver.LENGTH) / max(driver.speed, 4.0)
        from_side = abs(math.sin(spec.yaw_rad)) > 0.5
        for other in self._road.vehicles:
            if other is driver or other.speed < 0.3 or abs(math.sin(other.heading)) > 0.5:
                continue
            if not from_side and math.cos(other.heading - spec.yaw_rad) > 0:
                continue  # who drives the same way is no oncoming traffic
            sign = 1.0 if math.cos(other.heading) > 0 else -1.0
            ahead = sign * (crossing.x_m - float(other.position[0]))
            reach = crossing.kerb_m + 0.5 * other.LENGTH
            if ahead + reach > 0 and (ahead - reach) / other.speed < clear_s + GIVE_WAY_S:
                return gap
        return math.inf

    def forget(self, before_s: float) -> None:
        """Drop what no time from ``before_s`` on needs."""
        while len(self._history) > 1 and self._history[1][0] <= before_s:
            self._history.pop(0)

    @property
    def next_decision_s(self) -> float:
        """When the drivers next decide; inf without drivers."""
        return self._decisions / TRAFFIC_HZ if self._drivers else math.inf

    def decide_until(
        self,
        end_s: float,
        ego_at: Callable[[float], EgoPose] | None,
        fires: Fires | None,
    ) -> None:
        """Take all decisions that fall before ``end_s``.

        Args:
            end_s: Time up to which the ego's motion is known.
            ego_at: The ego at a time; None: as the scenario starts.
            fires: Whether a trigger's conditions hold for an actor: (trigger, (x, y, heading), time); None: never.
        """
        while self._drivers and self._decisions / TRAFFIC_HZ < end_s - _TINY_S:
            now = self._decisions / TRAFFIC_HZ
            if ego_at is not None:
                x, y, self._ego.heading, self._ego.speed = ego_at(now)
                self._ego.position[:] = x, y
            for driver in self._drivers:
                driver.follow_to(now)
            turned = False
            for driver in self._drivers:
                if fires is not None:
                    turned |= driver.start_maneuvers(fires, now)
            if turned:
                self.see_people()
            for driver in self._drivers:
                driver.decide()
            self._history.append((now, tuple(driver.phase for driver in self._drivers)))
            self._decisions += 1

    def _phases(self, time_s: float) -> tuple[Phase, ...]:
        for start, phases in reversed(self._history):
            if start <= time_s + _TINY_S:
                return phases
        return self._history[0][1]

    def pose(self, mover: int, time_s: float) -> tuple[float, float, float, float]:
        """(x, y, heading, speed) of one vehicle that drives; ``mover`` counts along ``movers``."""
        phase = self._phases(time_s)[mover]
        along, speed = phase.run(time_s)
        left, turned = phase.beside(along)
        x, y, heading = self._drivers[mover].way.pose(along)
        if left:
            x, y = x - left * math.sin(heading), y + left * math.cos(heading)
        return x, y, heading + turned, speed

    def poses(self, time_s: float) -> DrivingPoses:
        """All vehicles that drive, in the order of ``movers``."""
        if not self._drivers:
            return DrivingPoses(*(np.zeros(0),) * len(DrivingPoses._fields))
        rows = []
        for index, phase in enumerate(self._phases(time_s)):
            x, y, yaw, speed = self.pose(index, time_s)
            turns = phase.run(time_s)[0] / _PEDALLED_M if self._drivers[index].pedals else 0.0
            rows.append((x, y, yaw, speed, phase.pitch(time_s), float(phase.braking(speed)), turns))
        return DrivingPoses(*np.array(rows).T)

    def arrives_in_s(self, x_m: float, y_m: float, time_s: float) -> float:
        """Time until the first vehicle passes a place beside or on its way, holding its speed; inf: none comes.

        0 while one is passing.
        """
        soonest = math.inf
        for driver, phase in zip(self._drivers, self._phases(time_s) if self._history else (), strict=True):
            along, speed = phase.run(time_s)
            there, left = driver.way.project(x_m, y_m)
            ahead = there - along
            if abs(left) > 15.0 or ahead < -0.5 * driver.LENGTH:
                continue
            gap = max(0.0, ahead - 0.5 * driver.LENGTH)
            if gap == 0.0:
                return 0.0
            if speed > 0.3:
                soonest = min(soonest, gap / speed)
        return soonest
