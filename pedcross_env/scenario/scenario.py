"""A scenario: one episode, wholly described."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from pedcross_env.config import require
from pedcross_env.errors import unknown_name
from pedcross_env.scenario.street import StreetSpec

__all__ = [
    "ACCESSORIES",
    "PEDESTRIAN_MODELS",
    "VEHICLE_MODELS",
    "Leg",
    "PedestrianSpec",
    "Scenario",
    "VehicleSpec",
]

VEHICLE_MODELS: list[str] = ["hatchback", "sedan", "suv", "van", "bus", "truck", "motorcycle", "bicycle"]
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
    """Wait, then walk straight to a point."""

    to_x_m: float
    to_y_m: float
    speed_mps: float
    wait_s: float = 0.0  # before setting off

    def __post_init__(self) -> None:
        require(
            0 < self.speed_mps <= 10, "Leg.speed_mps", self.speed_mps, "above 0, at most 10 (stand: no legs)"
        )
        require(self.wait_s >= 0, "Leg.wait_s", self.wait_s, "0 or more")


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


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSpec:
    """Another vehicle: parked where its speed is 0 and ``parked`` is set, else driving along its lane by IDM."""

    x_m: float
    y_m: float
    yaw_rad: float = 0.0  # 0: with the ego, pi: oncoming
    speed_mps: float = 0.0
    parked: bool = False
    model: str = "hatchback"
    seed: int = 0

    def __post_init__(self) -> None:
        if self.model not in VEHICLE_MODELS:
            raise unknown_name("vehicle model", self.model, VEHICLE_MODELS)
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
