"""The vehicles that ship, registered on import, and the colours they are painted in."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.cars import car_door_model, car_model
from pedcross_env.camera.models import register_vehicle
from pedcross_env.camera.two_wheelers import bicycle_model, motorcycle_model
from pedcross_env.camera.vans_and_trucks import bus_model, truck_model, van_model
from pedcross_env.scenario.sizes import VEHICLE_SIZES

__all__ = ["PAINTS"]

PAINTS = np.array(
    [
        [0.62, 0.62, 0.60], [0.66, 0.66, 0.65], [0.30, 0.31, 0.33], [0.36, 0.37, 0.38], [0.13, 0.135, 0.14], [0.07, 0.07, 0.075],
        [0.018, 0.019, 0.021], [0.022, 0.024, 0.028], [0.03, 0.07, 0.22], [0.05, 0.09, 0.15], [0.10, 0.16, 0.24], [0.36, 0.02, 0.02],
        [0.20, 0.03, 0.04], [0.42, 0.40, 0.36], [0.03, 0.10, 0.07], [0.50, 0.30, 0.03],
    ]
)  # fmt: skip
"""Colours of paint, about as often as they are seen: white, grey and black first."""

register_vehicle(
    "hatchback",
    car_model(VEHICLE_SIZES["hatchback"], hood=1.02, boot=0.15, belt=0.94, rake=(0.42, 0.80), wheel=0.31),
)
register_vehicle(
    "sedan", car_model(VEHICLE_SIZES["sedan"], hood=1.28, boot=0.72, belt=0.93, rake=(0.72, 0.92), wheel=0.32)
)
register_vehicle(
    "suv",
    car_model(
        VEHICLE_SIZES["suv"], hood=1.16, boot=0.15, belt=1.07, rake=(0.36, 0.72), wheel=0.36, pillars=2
    ),
)
register_vehicle("van", van_model(VEHICLE_SIZES["van"]))
register_vehicle("bus", bus_model(VEHICLE_SIZES["bus"]))
register_vehicle("truck", truck_model(VEHICLE_SIZES["truck"]))
register_vehicle("motorcycle", motorcycle_model(VEHICLE_SIZES["motorcycle"]))
register_vehicle("bicycle", bicycle_model(VEHICLE_SIZES["bicycle"]))
register_vehicle("cyclist", bicycle_model(VEHICLE_SIZES["cyclist"]))  # who rides it is drawn by camera.riders
register_vehicle("car_door", car_door_model(VEHICLE_SIZES["car_door"]))
