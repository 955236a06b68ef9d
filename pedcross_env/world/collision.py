"""What the ego touches, and when: all pedestrians and the vehicles in its way, over one policy step."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from pedcross_env.config import EgoConfig
from pedcross_env.scenario.scenario import Scenario
from pedcross_env.scenario.sizes import Size, vehicle_size
from pedcross_env.world.contact import box_to_box_m, box_to_disc_m, first_contact
from pedcross_env.world.doors import DOOR_MODEL, DOOR_OPEN_RAD, DOOR_SWING_S
from pedcross_env.world.ego import EgoMotion, EgoState
from pedcross_env.world.pedestrians import Pedestrians
from pedcross_env.world.traffic import HARDEST_BRAKING_MPS2, Traffic

__all__ = ["CollisionFinder"]

_TINY_MPS = 1e-6
TURNING_SHARE = (
    1.5  # speed of the fastest corner over that of the middle: half a bus's length over a turn's radius
)
# smoothstep is 1.5 times faster in the middle than on average; the hinge of a door never moves
DOOR_TIP_MPS = 1.5 * DOOR_OPEN_RAD / DOOR_SWING_S * vehicle_size(DOOR_MODEL).length_m


class CollisionFinder:
    """First contacts of the ego, and the time to a vehicle ahead.

    Args:
        scenario: Who is there.
        ego: Its size.
        motion: Its motion over the present step.
        people: The pedestrians.
        traffic: The vehicles that drive.
        longest_step_s: The search looks at least this often.
    """

    def __init__(
        self,
        scenario: Scenario,
        ego: EgoConfig,
        *,
        motion: EgoMotion,
        people: Pedestrians,
        traffic: Traffic,
        longest_step_s: float,
    ) -> None:
        self._scenario, self._config, self._longest_step_s = scenario, ego, longest_step_s
        self._lane_y_m = scenario.street.ego_lane_y_m
        self._motion, self._people, self._traffic = motion, people, traffic
        self._in_the_way = self._vehicles_in_the_way()

    def _vehicles_in_the_way(self) -> list[tuple[int, int | None]]:
        """(index, position among the movers or None): what stands in the ego's strip of road, and whatever drives.

        Doors count on after the scenario's vehicles.
        """
        found: list[tuple[int, int | None]] = []
        for index, spec in enumerate(self._scenario.vehicles):
            if index in self._traffic.movers:
                found.append((index, self._traffic.movers.index(index)))
                continue
            size = vehicle_size(spec.model)
            across = size.length_m * abs(math.sin(spec.yaw_rad)) + size.width_m * abs(math.cos(spec.yaw_rad))
            if abs(spec.y_m - self._lane_y_m) < 0.5 * (across + self._config.width_m):
                found.append((index, None))
        doors = len(self._traffic.doors)
        return found + [(len(self._scenario.vehicles) + k, None) for k in range(doors)]

    def _pose(self, index: int, mover: int | None, time_s: float) -> tuple[float, float, float, float]:
        """(x, y, heading, speed) of a vehicle or a door."""
        if mover is not None:
            return self._traffic.pose(mover, time_s)
        if index >= len(self._scenario.vehicles):
            return (*self._traffic.doors.pose(index - len(self._scenario.vehicles), time_s), 0.0)
        spec = self._scenario.vehicles[index]
        return spec.x_m, spec.y_m, spec.yaw_rad, 0.0

    def _size(self, index: int) -> Size:
        vehicles = self._scenario.vehicles
        return vehicle_size(vehicles[index].model if index < len(vehicles) else DOOR_MODEL)

    def first(self, start_s: float, end_s: float) -> tuple[float, bool, int] | None:
        """The first contact in the interval, None without one.

        Returns:
            (time, whether with a pedestrian, index into the scenario's pedestrians or vehicles).
        """
        found: list[tuple[float, bool, int]] = []
        ego_bound = self._motion.top_speed_mps
        for index in self._near_pedestrians(start_s, end_s, ego_bound):
            bound = ego_bound + float(self._people.top_speed_mps[index])
            time = self._search(partial(self._gap_to_pedestrian, int(index)), bound, start_s, end_s)
            if time is not None:
                found.append((time, True, int(index)))
        for index, mover in self._in_the_way:
            bound = ego_bound + self._vehicle_bound(index, start_s, end_s, mover)
            if self._gap_to_vehicle(index, mover, start_s) > bound * (end_s - start_s):
                continue
            time = self._search(partial(self._gap_to_vehicle, index, mover), bound, start_s, end_s)
            if time is not None:
                found.append((time, False, index))
        return min(found, default=None)

    def _search(
        self, gap: Callable[[float], float], bound_mps: float, start_s: float, end_s: float
    ) -> float | None:
        return first_contact(
            gap,
            lambda t: self._motion.motion(t)[1],
            closing_bound_mps=max(bound_mps, 0.1),
            start_s=start_s,
            end_s=end_s,
            longest_step_s=self._longest_step_s,
        )

    def _vehicle_bound(self, index: int, start_s: float, end_s: float, mover: int | None) -> float:
        if mover is None:
            swings = index >= len(self._scenario.vehicles)
            return DOOR_TIP_MPS if swings else 0.0
        ends = (self._traffic.pose(mover, t)[3] for t in (start_s, end_s))
        # a body that turns moves faster at its corners than in its middle
        return TURNING_SHARE * max(ends) + HARDEST_BRAKING_MPS2 * (end_s - start_s)

    def _near_pedestrians(self, start_s: float, end_s: float, ego_bound_mps: float) -> np.ndarray:
        if not len(self._people):
            return np.zeros(0, dtype=np.int64)
        xy = np.array([walk.position(start_s) for walk in self._people.walks])
        distance_x = np.abs(xy[:, 0] - self._motion.motion(start_s)[0])
        outside_x = np.maximum(distance_x - 0.5 * self._config.length_m, 0.0)
        outside_y = np.maximum(np.abs(xy[:, 1] - self._lane_y_m) - 0.5 * self._config.width_m, 0.0)
        reach = self._people.radius_m + (ego_bound_mps + self._people.top_speed_mps) * (end_s - start_s)
        return np.flatnonzero(np.hypot(outside_x, outside_y) <= reach)

    def _gap_to_pedestrian(self, index: int, time_s: float) -> float:
        x, y = self._people.walks[index].position(time_s)
        dx, dy = x - self._motion.motion(time_s)[0], y - self._lane_y_m
        radius = float(self._people.radius_m[index])
        return box_to_disc_m(dx, dy, self._config.length_m, self._config.width_m, radius)

    def _gap_to_vehicle(self, index: int, mover: int | None, time_s: float) -> float:
        x, y, yaw, _ = self._pose(index, mover, time_s)
        dx, dy = x - self._motion.motion(time_s)[0], y - self._lane_y_m
        size = self._size(index)
        return box_to_box_m(dx, dy, (self._config.length_m, self._config.width_m), size[:2], yaw)

    def time_to_vehicle_s(self, time_s: float, ego: EgoState, margin_m: float) -> float:
        """Time to come within ``margin_m`` of a vehicle ahead in the lane, both holding speed; inf without one."""
        soonest = math.inf
        for index, mover in self._in_the_way:
            x, y, yaw, speed = self._pose(index, mover, time_s)
            size = self._size(index)
            cos, sin = math.cos(yaw), math.sin(yaw)
            across = size.length_m * abs(sin) + size.width_m * abs(cos)
            closing = ego.speed_mps - speed * cos
            if abs(y - self._lane_y_m) >= 0.5 * (across + self._config.width_m) or x <= ego.x_m:
                continue
            if closing > _TINY_MPS:
                along = size.length_m * abs(cos) + size.width_m * abs(sin)
                gap = max(0.0, x - 0.5 * along - ego.front_m - margin_m)
                soonest = min(soonest, gap / closing)
        return soonest
