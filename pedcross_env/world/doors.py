"""Doors of parked cars: a panel hinged at the car's left side that swings open when its trigger fires."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.scenario.scenario import VehicleSpec
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.trigger import Fires
from pedcross_env.scenario.walk import smoothstep

__all__ = ["DOOR_MODEL", "DOOR_OPEN_RAD", "DOOR_SWING_S", "Doors"]

DOOR_MODEL = "car_door"
DOOR_OPEN_RAD = math.radians(65.0)
DOOR_SWING_S = 0.9
_HINGE_SHARE = 0.13  # of the car's length, ahead of its middle
_INSIDE_M = 0.05  # a closed door lies so far inside the car's side, unseen


class Doors:
    """All doors of a scenario that may open.

    Args:
        vehicles: The scenario's.

    Attributes:
        owners: Indices of their cars.
    """

    def __init__(self, vehicles: tuple[VehicleSpec, ...]) -> None:
        self.owners = [i for i, spec in enumerate(vehicles) if spec.door is not None]
        self._cars = [vehicles[i] for i in self.owners]
        self.opens_s = np.full(len(self.owners), np.inf)

    def __len__(self) -> int:
        return len(self.owners)

    def watch(self, fires: Fires, time_s: float) -> None:
        """Open the doors whose triggers fire at a time."""
        for index, car in enumerate(self._cars):
            place = (car.x_m, car.y_m, car.yaw_rad)
            if np.isinf(self.opens_s[index]) and car.door is not None and fires(car.door, place, time_s):
                self.opens_s[index] = time_s + car.door.delay_s

    def pose(self, index: int, time_s: float) -> tuple[float, float, float]:
        """(x, y, heading) of a door's middle."""
        car = self._cars[index]
        size, length = vehicle_size(car.model), vehicle_size(DOOR_MODEL).length_m
        since = time_s - float(self.opens_s[index])
        angle = DOOR_OPEN_RAD * float(smoothstep(since / DOOR_SWING_S)) if since > 0 else 0.0
        ahead = _HINGE_SHARE * size.length_m - 0.5 * length * math.cos(angle)
        left = 0.5 * size.width_m - _INSIDE_M + 0.5 * length * math.sin(angle)
        cos, sin = math.cos(car.yaw_rad), math.sin(car.yaw_rad)
        return car.x_m + ahead * cos - left * sin, car.y_m + ahead * sin + left * cos, car.yaw_rad - angle

    def poses(self, time_s: float) -> np.ndarray:
        """(D, 3) x, y, heading of all doors."""
        return np.array([self.pose(i, time_s) for i in range(len(self))]).reshape(-1, 3)
