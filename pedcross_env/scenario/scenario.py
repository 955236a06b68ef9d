"""A scenario: one episode, wholly described."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from pedcross_env.config import require
from pedcross_env.errors import unknown_name
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
]
"""Names by index; ``pedcross_env.camera.models.register_vehicle`` appends to them."""
PEDESTRIAN_MODELS = ("adult", "child", "elderly")
ACCESSORIES = (
    "", "none", "umbrella", "backpack", "handbag", "hi-vis", "stroller", "cane", "phone",
)  # fmt: skip
"""What a pedestrian wears or carries; "" leaves it to the seed.

Umbrellas are up where it rains, else rolled in the hand.
"""


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
    go: Trigger | None = None

    def __post_init__(self) -> None:
        require(
            0 < self.speed_mps <= 10, "Leg.speed_mps", self.speed_mps, "above 0, at most 10 (stand: no legs)"
        )
        require(0 <= self.wait_s < math.inf, "Leg.wait_s", self.wait_s, "finite, 0 or more")
        place = (self.to_x_m, self.to_y_m)
        require(all(map(math.isfinite, place)), "Leg to_x_m, to_y_m", place, "finite")


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
        require(all(map(math.isfinite, pose)), "PedestrianSpec x_m, y_m, yaw_rad", pose, "finite")


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
            require(0 <= self.speed_mps <= 40, "Maneuver.speed_mps", self.speed_mps, "0 to 40")
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
        require(math.isfinite(self.yaw_rad), "VehicleSpec.yaw_rad", self.yaw_rad, "finite")
        require(self.door is None or self.parked, "VehicleSpec.door", self.door, "None unless it is parked")
        require(
            not self.parked or not self.maneuvers, "VehicleSpec.maneuvers", self.maneuvers, "() if parked"
        )
        require(0 <= self.speed_mps <= 40, "VehicleSpec.speed_mps", self.speed_mps, "0 to 40")
        require(
            not self.parked or self.speed_mps == 0, "VehicleSpec.speed_mps", self.speed_mps, "0 if parked"
        )
        require(
            math.isfinite(self.x_m) and math.isfinite(self.y_m),
            "VehicleSpec position",
            (self.x_m, self.y_m),
            "finite",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One episode without its weather: the same crossing can be played in any weather."""

    name: str
    street: StreetSpec = field(default_factory=StreetSpec)
    ego_x_m: float = 0.0  # of the ego's centre at reset
    ego_speed_mps: float = 10.0
    finish_x_m: float = 100.0  # passed when the ego's front is beyond it
    duration_s: float = 10.0
    pedestrians: tuple[PedestrianSpec, ...] = ()
    vehicles: tuple[VehicleSpec, ...] = ()

    def __post_init__(self) -> None:
        require(0 <= self.ego_speed_mps <= 40, "Scenario.ego_speed_mps", self.ego_speed_mps, "0 to 40")
        require(self.duration_s > 0, "Scenario.duration_s", self.duration_s, "positive")
        require(
            self.finish_x_m > self.ego_x_m,
            "Scenario.finish_x_m",
            self.finish_x_m,
            f"beyond ego_x_m ({self.ego_x_m})",
        )
        for pedestrian in self.pedestrians:
            require(abs(pedestrian.y_m) <= self.street.facade_y_m, "PedestrianSpec.y_m", pedestrian.y_m,
                    f"within the facades (+-{self.street.facade_y_m} m)")  # fmt: skip
