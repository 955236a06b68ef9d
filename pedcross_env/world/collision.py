"""What the ego touches, and when: all pedestrians and vehicles near it, over one policy step."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from pedcross_env.config import EgoConfig
from pedcross_env.scenario.footprints import box_to_box_m
from pedcross_env.scenario.scenario import Scenario
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.walk import FASTEST_TURN_RADPS
from pedcross_env.world.contact import first_contact
from pedcross_env.world.doors import DOOR_MODEL, DOOR_OPEN_RAD, DOOR_SWING_S
from pedcross_env.world.drive import Drive
from pedcross_env.world.pedestrians import Pedestrians
from pedcross_env.world.traffic import HARDEST_BRAKING_MPS2, Traffic

__all__ = ["CollisionFinder"]

_TINY_MPS = 1e-6
_TURNING_SHARE = (
    1.5  # speed of the fastest corner over that of the middle: half a bus's length over a turn's radius
)
# smoothstep is 1.5 times faster in the middle than on average; the hinge of a door never moves
_DOOR_TIP_MPS = 1.5 * DOOR_OPEN_RAD / DOOR_SWING_S * vehicle_size(DOOR_MODEL).length_m


class CollisionFinder:
    """First contacts of the ego, and the time to a vehicle ahead.

    Everybody's footprint is a box that moves and turns; a contact is found where the boxes, swept over the step,
    first touch.

    Args:
        scenario: Who is there.
        ego: Its size.
        drive: Its motion over the present step.
        people: The pedestrians.
        traffic: The vehicles that drive.
        longest_step_s: The search looks at least this often.
    """

    def __init__(
        self,
        scenario: Scenario,
        ego: EgoConfig,
        *,
        drive: Drive,
        people: Pedestrians,
        traffic: Traffic,
        longest_step_s: float,
    ) -> None:
        self._scenario, self._longest_step_s = scenario, longest_step_s
        self._size = (ego.length_m, ego.width_m)
        self._half_diagonal_m = 0.5 * math.hypot(*self._size)
        self._drive, self._people, self._traffic = drive, people, traffic
        self._people_sizes = [(float(a), float(b)) for a, b in people.footprints_m]
        self._people_half_m = 0.5 * np.hypot(*people.footprints_m.T)
        models = [spec.model for spec in scenario.vehicles] + [DOOR_MODEL] * len(traffic.doors)
        self._vehicle_sizes = [vehicle_size(model)[:2] for model in models]
        self._vehicles = self._vehicles_in_reach(ego)

    def _vehicles_in_reach(self, ego: EgoConfig) -> list[tuple[int, int | None]]:
        """(index, position among the movers or None) of vehicles the ego may meet; doors count on after vehicles.

        An ego that drives straight on meets of those that stand only the ones in its strip of road.
        """
        found: list[tuple[int, int | None]] = []
        lane_y = self._drive.plan.pose(self._scenario.ego_x_m)[1]
        for index, spec in enumerate(self._scenario.vehicles):
            length, width = self._vehicle_sizes[index]
            across = length * abs(math.sin(spec.yaw_rad)) + width * abs(math.cos(spec.yaw_rad))
            if index in self._traffic.movers:
                found.append((index, self._traffic.movers.index(index)))
            elif not self._drive.straight or abs(spec.y_m - lane_y) < 0.5 * (across + ego.width_m):
                found.append((index, None))
        doors = len(self._traffic.doors)
        return found + [(len(self._scenario.vehicles) + k, None) for k in range(doors)]

    def first(self, start_s: float, end_s: float) -> tuple[float, bool, int] | None:
        """The first contact in the interval, None without one.

        Returns:
            (time, whether with a pedestrian, index into the scenario's pedestrians or vehicles).
        """
        found: list[tuple[float, bool, int]] = []
        top = self._drive.motion.top_speed_mps
        turning = self._drive.sharpest_per_m(start_s, end_s) * self._half_diagonal_m
        ego_bound = top * (1.0 + turning)
        x, y, _ = self._drive.pose(start_s)
        for index in self._near_pedestrians(x, y, start_s, end_s, ego_bound):
            bound = ego_bound + self._pedestrian_bound(int(index))
            time = self._search(partial(self._gap_to_pedestrian, int(index)), bound, start_s, end_s)
            if time is not None:
                found.append((time, True, int(index)))
        for index, mover in self._vehicles:
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
            lambda t: self._drive.motion.motion(t)[1],
            closing_bound_mps=max(bound_mps, 0.1),
            start_s=start_s,
            end_s=end_s,
            longest_step_s=self._longest_step_s,
        )

    def _pedestrian_bound(self, index: int) -> float:
        turning = FASTEST_TURN_RADPS if self._people.walks[index].turns_at_all else 0.0
        return float(self._people.top_speed_mps[index] + turning * self._people_half_m[index])

    def _vehicle_bound(self, index: int, start_s: float, end_s: float, mover: int | None) -> float:
        if mover is None:
            return _DOOR_TIP_MPS if index >= len(self._scenario.vehicles) else 0.0
        ends = (self._traffic.pose(mover, t)[3] for t in (start_s, end_s))
        # a body that turns moves faster at its corners than in its middle
        return _TURNING_SHARE * max(ends) + HARDEST_BRAKING_MPS2 * (end_s - start_s)

    def _near_pedestrians(
        self, x_m: float, y_m: float, start_s: float, end_s: float, ego_bound_mps: float
    ) -> np.ndarray:
        if not len(self._people):
            return np.zeros(0, dtype=np.int64)
        xy = np.array([walk.position(start_s) for walk in self._people.walks])
        distance = np.hypot(xy[:, 0] - x_m, xy[:, 1] - y_m)
        own = self._half_diagonal_m + self._people_half_m
        return np.flatnonzero(
            distance <= own + (ego_bound_mps + self._people.top_speed_mps) * (end_s - start_s)
        )

    def _seen_from_ego(self, x_m: float, y_m: float, time_s: float) -> tuple[float, float, float]:
        """(ahead, to the left, the ego's heading) of a place."""
        ex, ey, heading = self._drive.pose(time_s)
        cos, sin = math.cos(heading), math.sin(heading)
        dx, dy = x_m - ex, y_m - ey
        return dx * cos + dy * sin, dy * cos - dx * sin, heading

    def _gap_to_pedestrian(self, index: int, time_s: float) -> float:
        walk = self._people.walks[index]
        dx, dy, heading = self._seen_from_ego(*walk.position(time_s), time_s)
        return box_to_box_m(dx, dy, self._size, self._people_sizes[index], walk.yaw(time_s) - heading)

    def _vehicle_pose(
        self, index: int, mover: int | None, time_s: float
    ) -> tuple[float, float, float, float]:
        """(x, y, heading, speed) of a vehicle or a door."""
        if mover is not None:
            return self._traffic.pose(mover, time_s)
        if index >= len(self._scenario.vehicles):
            return (*self._traffic.doors.pose(index - len(self._scenario.vehicles), time_s), 0.0)
        spec = self._scenario.vehicles[index]
        return spec.x_m, spec.y_m, spec.yaw_rad, 0.0

    def _gap_to_vehicle(self, index: int, mover: int | None, time_s: float) -> float:
        x, y, yaw, _ = self._vehicle_pose(index, mover, time_s)
        dx, dy, heading = self._seen_from_ego(x, y, time_s)
        return box_to_box_m(dx, dy, self._size, self._vehicle_sizes[index], yaw - heading)

    def vehicle_ahead(self, time_s: float, speed_mps: float, margin_m: float) -> tuple[float, float, float]:
        """The vehicle in the ego's way that it reaches first, both holding speed and direction.

        Returns:
            (time until they are within ``margin_m``, gap in m less the margin, closing speed in m/s); inf, inf, 0
            without one. The gap is along the ego's heading.
        """
        soonest = (math.inf, math.inf, 0.0)
        for index, mover in self._vehicles:
            x, y, yaw, speed = self._vehicle_pose(index, mover, time_s)
            dx, dy, heading = self._seen_from_ego(x, y, time_s)
            length, width = self._vehicle_sizes[index]
            cos, sin = math.cos(yaw - heading), math.sin(yaw - heading)
            along, across = (
                length * abs(cos) + width * abs(sin),
                length * abs(sin) + width * abs(cos),
            )
            closing = speed_mps - speed * cos
            if dx > 0 and abs(dy) < 0.5 * (across + self._size[1]) and closing > _TINY_MPS:
                gap = max(0.0, dx - 0.5 * (along + self._size[0]) - margin_m)
                soonest = min(soonest, (gap / closing, gap, closing))
        return soonest
