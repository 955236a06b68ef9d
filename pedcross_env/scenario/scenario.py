"""A scenario: one episode, wholly described."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from pedcross_env.config import require
from pedcross_env.errors import unknown_name
from pedcross_env.scenario.layout import facade_m
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.scenario.trigger import Trigger

__all__ = [
    "ACCESSORIES",
    "PEDESTRIAN_MODELS",
    "VEHICLE_MODELS",
    "Leg",
    "Maneuver",
    "PedestrianSpec",
    "Scenario",
    "VehicleSpec",
]

_WAY_STEP_M = 0.25
_LONGEST_WAY_M = 1000.0  # farther nobody walks in an episode

VEHICLE_MODELS: list[str] = [
    "hatchback",
    "sedan",
    "suv",
    "van",
    "bus",
    "truck",
    "motorcycle",
    "bicycle",
    "car_door",
    "cyclist",
]
"""Names by index; ``pedcross_env.camera.models.register_vehicle`` appends to them."""
PEDESTRIAN_MODELS = ("adult", "child", "elderly")
ACCESSORIES = (
    "", "none", "umbrella", "backpack", "handbag", "hi-vis", "stroller", "cane", "phone",
)  # fmt: skip
"""What a pedestrian wears or carries; "" leaves it to the seed.

Umbrellas are up where it rains, else rolled in the hand.
"""


LONGEST_S, FARTHEST_M = 3600.0, 10_000.0
"""No episode or wait is longer, nothing farther from the street's origin."""


def _near(*values: float) -> bool:
    return all(abs(value) <= FARTHEST_M for value in values)


@dataclass(frozen=True, slots=True, kw_only=True)
class Leg:
    """Wait, then walk straight to a point.

    With ``go``, the walk stops where the leg begins until the trigger fires, and ``wait_s`` counts from then. Who
    arrives while its conditions hold walks on without stopping, unless there is a delay or a wait.
    """

    to_x_m: float
    to_y_m: float
    speed_mps: float
    wait_s: float = 0.0  # before setting off
    run_up_m: float | None = None  # over which it speeds up from standing; None: within 0.3 s
    go: Trigger | None = None

    def __post_init__(self) -> None:
        require(
            0 < self.speed_mps <= 10,
            "Leg.speed_mps",
            self.speed_mps,
            "above 0, at most 10, e.g. 1.4 (stand: no legs)",
        )
        require(0 <= self.wait_s <= LONGEST_S, "Leg.wait_s", self.wait_s, f"0 to {LONGEST_S:g}")
        place = (self.to_x_m, self.to_y_m)
        require(_near(*place), "Leg to_x_m, to_y_m", place, f"within +-{FARTHEST_M:g} m")
        if self.run_up_m is not None:
            require(self.run_up_m > 0, "Leg.run_up_m", self.run_up_m, "positive, or None: within 0.3 s")


@dataclass(frozen=True, slots=True, kw_only=True)
class PedestrianSpec:
    """A pedestrian and the way it takes; without legs it stands."""

    behaviour: str  # free text for tables: "crossing", "walking_along", "waiting", "standing", ...
    x_m: float
    y_m: float
    yaw_rad: float = 0.0  # before the first leg
    legs: tuple[Leg, ...] = ()
    model: str = "adult"
    height_m: float = 1.75
    seed: int = 0
    accessory: str = ""  # one of ACCESSORIES

    def __post_init__(self) -> None:
        if self.accessory not in ACCESSORIES:
            raise unknown_name("accessory", self.accessory, ACCESSORIES)
        if self.model not in PEDESTRIAN_MODELS:
            raise unknown_name("pedestrian model", self.model, PEDESTRIAN_MODELS)
        require(0.7 <= self.height_m <= 2.2, "PedestrianSpec.height_m", self.height_m, "0.7 to 2.2")
        pose = (self.x_m, self.y_m, self.yaw_rad)
        require(_near(*pose), "PedestrianSpec x_m, y_m, yaw_rad", pose, f"within +-{FARTHEST_M:g}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Maneuver:
    """What a driver does when a trigger fires: another speed, another line in the carriageway, or both."""

    when: Trigger
    speed_mps: float | None = None  # wanted from then on; 0 stops
    acceleration_mps2: float = 2.0  # how fast it is reached; braking for others may be harder
    to_y_m: float | None = None  # goes over to this line of the street, once it is free beside
    duration_s: float = 3.0  # of going over, at the speed it has then

    def __post_init__(self) -> None:
        given = self.speed_mps is not None or self.to_y_m is not None
        require(given, "Maneuver", "neither speed_mps nor to_y_m", "one of them or both")
        if self.speed_mps is not None:
            require(0 <= self.speed_mps <= 40, "Maneuver.speed_mps", self.speed_mps, "0 to 40, e.g. 10")
        if self.to_y_m is not None:
            require(math.isfinite(self.to_y_m), "Maneuver.to_y_m", self.to_y_m, "finite")
        require(0 < self.acceleration_mps2 <= 9, "Maneuver.acceleration_mps2", self.acceleration_mps2,
                "above 0, at most 9")  # fmt: skip
        require(1 <= self.duration_s <= 20, "Maneuver.duration_s", self.duration_s, "1 to 20")


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSpec:
    """Another vehicle: parked where its speed is 0 and ``parked`` is set, else driving along its lane by IDM.

    With ``turn`` it turns at the intersection, giving way to who has the right of way; with ``maneuvers`` it changes
    speed or line when their triggers fire; a parked one may open the ``door`` on its left.
    """

    x_m: float
    y_m: float
    yaw_rad: float = 0.0  # 0: with the ego, pi: oncoming
    speed_mps: float = 0.0
    parked: bool = False
    model: str = "hatchback"
    seed: int = 0
    turn: Literal["", "left", "right", "straight"] = ""
    maneuvers: tuple[Maneuver, ...] = ()
    door: Trigger | None = None
    yields: bool = True  # whether it stops for pedestrians

    def __post_init__(self) -> None:
        if self.model not in VEHICLE_MODELS:
            raise unknown_name("vehicle model", self.model, VEHICLE_MODELS)
        if self.turn not in ("", "left", "right", "straight"):
            raise unknown_name("turn", self.turn, ("left", "right", "straight"))
        require(_near(self.yaw_rad), "VehicleSpec.yaw_rad", self.yaw_rad, "finite")
        require(self.door is None or self.parked, "VehicleSpec.door", self.door, "None unless it is parked")
        require(
            not self.parked or not self.maneuvers, "VehicleSpec.maneuvers", self.maneuvers, "() if parked"
        )
        require(0 <= self.speed_mps <= 40, "VehicleSpec.speed_mps", self.speed_mps, "0 to 40, e.g. 10")
        require(
            not self.parked or self.speed_mps == 0, "VehicleSpec.speed_mps", self.speed_mps, "0 if parked"
        )
        require(
            _near(self.x_m, self.y_m),
            "VehicleSpec position",
            (self.x_m, self.y_m),
            f"within +-{FARTHEST_M:g} m",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One episode without its weather: the same crossing can be played in any weather.

    The ego keeps to its lane, or takes it through the intersection. Distances along its way are x up to where a street
    bends or the ego turns, and go on in metres driven.
    """

    name: str
    street: StreetSpec = field(default_factory=StreetSpec)
    ego_x_m: float = 0.0  # of the ego's centre at reset, along its way
    ego_speed_mps: float = 10.0
    ego_turn: Literal["straight", "left", "right"] = "straight"  # where there is an intersection
    finish_x_m: float = 100.0  # along its way; passed when the ego's front is beyond it
    duration_s: float = 10.0
    pedestrians: tuple[PedestrianSpec, ...] = ()
    vehicles: tuple[VehicleSpec, ...] = ()

    def __post_init__(self) -> None:
        require(
            0 <= self.ego_speed_mps <= 40, "Scenario.ego_speed_mps", self.ego_speed_mps, "0 to 40, e.g. 10"
        )
        require(
            0 < self.duration_s <= 600,
            "Scenario.duration_s",
            self.duration_s,
            "above 0, at most 600, e.g. 10",
        )
        if self.ego_turn not in ("straight", "left", "right"):
            raise unknown_name("Scenario.ego_turn", self.ego_turn, ("straight", "left", "right"))
        require(
            self.ego_turn == "straight" or self.street.intersection is not None,
            "Scenario.ego_turn", self.ego_turn,
            "'straight' unless the street has an intersection: StreetSpec(intersection=Intersection(x_m=60.0))",
        )  # fmt: skip
        require(
            self.finish_x_m > self.ego_x_m,
            "Scenario.finish_x_m",
            self.finish_x_m,
            f"beyond ego_x_m ({self.ego_x_m})",
        )
        for index, pedestrian in enumerate(self.pedestrians):
            self._check_way(index, pedestrian)

    def _check_way(self, index: int, pedestrian: PedestrianSpec) -> None:
        """Nobody stands in or walks through a house or a parked car."""
        street, name = self.street, f"Scenario.pedestrians[{index}]"
        corners = np.array(
            [(pedestrian.x_m, pedestrian.y_m), *((g.to_x_m, g.to_y_m) for g in pedestrian.legs)]
        )
        ways = [corners[:1]]
        for start, end in itertools.pairwise(corners):
            count = 2 + int(min(math.dist(start, end), _LONGEST_WAY_M) / _WAY_STEP_M)
            ways.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
        way = np.concatenate(ways)
        inside = int(np.argmin(facade_m(street, *way.T)))
        x, y = (round(float(v), 2) for v in way[inside])
        require(
            bool(facade_m(street, x, y) >= -0.01), name, (x, y),
            f"before the house fronts, all along its way: they are {street.facade_y_m:g} m from the centre line; "
            f"e.g. y_m = {street.kerb_y_m + 0.5 * street.sidewalk_width_m:g} on the sidewalk",
        )  # fmt: skip
        for k, vehicle in enumerate(self.vehicles):
            if not vehicle.parked:
                continue
            size, cos, sin = vehicle_size(vehicle.model), math.cos(vehicle.yaw_rad), math.sin(vehicle.yaw_rad)
            dx, dy = way[:, 0] - vehicle.x_m, way[:, 1] - vehicle.y_m
            through = (np.abs(dx * cos + dy * sin) < 0.5 * size.length_m) & (
                np.abs(dy * cos - dx * sin) < 0.5 * size.width_m
            )
            place = way[int(np.argmax(through))]
            require(
                not through.any(), name, tuple(round(float(v), 2) for v in place),
                f"outside of the parked Scenario.vehicles[{k}] ({vehicle.model} at x_m = {vehicle.x_m:g}, y_m = "
                f"{vehicle.y_m:g}), all along its way; e.g. cross at x_m = "
                f"{vehicle.x_m + 0.5 * size.length_m + 0.5:.1f}",
            )  # fmt: skip
