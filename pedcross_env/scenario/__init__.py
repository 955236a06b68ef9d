"""What happens: the street, who moves in it and when."""

from pedcross_env.scenario.scenario import (
    ACCESSORIES,
    PEDESTRIAN_MODELS,
    VEHICLE_MODELS,
    Leg,
    PedestrianSpec,
    Scenario,
    VehicleSpec,
)
from pedcross_env.scenario.street import Crosswalk, Intersection, StreetSpec

__all__ = [
    "ACCESSORIES", "PEDESTRIAN_MODELS", "VEHICLE_MODELS", "Crosswalk", "Intersection", "Leg", "PedestrianSpec",
    "Scenario", "StreetSpec", "VehicleSpec",
]  # fmt: skip
