"""What happens: the street, who moves in it and when."""

from pedcross_env.scenario.scenario import (
    ACCESSORIES,
    PEDESTRIAN_MODELS,
    VEHICLE_MODELS,
    Leg,
    Maneuver,
    PedestrianSpec,
    Scenario,
    VehicleSpec,
)
from pedcross_env.scenario.street import Crosswalk, Intersection, SteelPlate, StreetSpec
from pedcross_env.scenario.trigger import Trigger

__all__ = [
    "ACCESSORIES", "PEDESTRIAN_MODELS", "VEHICLE_MODELS", "Crosswalk", "Intersection", "Leg", "Maneuver",
    "PedestrianSpec", "Scenario", "SteelPlate", "StreetSpec", "Trigger", "VehicleSpec",
]  # fmt: skip
