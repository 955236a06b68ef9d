"""Cars at the kerb, placed so that nobody has to walk through one."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from pedcross_env.scenario.passers import CAR_SHARES, CARS
from pedcross_env.scenario.scenario import VehicleSpec
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.street import StreetSpec

__all__ = ["BAY_M", "CLEAR_OF_ZEBRA_M", "Beside", "parked_cars"]

Beside = Literal["", "between", "behind"]

BAY_M = 6.4
CLEAR_OF_ZEBRA_M = 5.0  # no parking before and behind a zebra
_SEEN_BEYOND_M = 60.0
_CLEAR_OF_CORNER_M = 5.0


def _car(rng: np.random.Generator, x_m: float, side: int, street: StreetSpec) -> VehicleSpec:
    return VehicleSpec(
        x_m=x_m,
        y_m=side * (street.kerb_y_m - 0.5 * street.parking_width_m),
        yaw_rad=0.0 if side < 0 else math.pi,
        parked=True,
        model=str(rng.choice(CARS, p=CAR_SHARES)),
        seed=int(rng.integers(2**31)),
    )


def parked_cars(
    rng: np.random.Generator,
    street: StreetSpec,
    share: float,
    *,
    path_x_m: tuple[float, float],
    beside: Beside = "",
    side_of_path: int = 0,
) -> tuple[VehicleSpec, ...]:
    """Cars in the bays of both sides.

    Args:
        rng: Of the scene.
        street: With its zebras, which stay clear by 5 m.
        share: Of bays that are taken.
        path_x_m: (low, high) x that pedestrians walk through; no car stands there on either side.
        beside: Where cars stand right beside that path (if share > 0): on both sides of it ("between"), on the side
            from which the ego comes ("behind" a car), or nowhere in particular.
        side_of_path: Side (+-1) of the street on which they do.

    Returns:
        Parked vehicles; none overlaps another, the path or a zebra's surroundings.
    """
    low, high = path_x_m
    clear = [(low, high)]
    if street.intersection is not None:
        corner = street.intersection
        reach = corner.kerb_m + corner.corner_radius_m + corner.crosswalk_width_m + _CLEAR_OF_CORNER_M
        clear.append((corner.x_m - reach, corner.x_m + reach))
    for zebra in street.crosswalks:
        reach = 0.5 * zebra.width_m + CLEAR_OF_ZEBRA_M
        clear.append((zebra.x_m - reach, zebra.x_m + reach))
    cars: list[VehicleSpec] = []
    for side in (-1, 1):
        bays = [(high + k * BAY_M, 1) for k in range(int((_SEEN_BEYOND_M) / BAY_M))]
        bays += [(low - k * BAY_M, -1) for k in range(max(0, int(low / BAY_M)))]
        for edge, direction in bays:
            walls = {"between": (low, high), "behind": (low,), "": ()}[beside]
            beside_path = side == side_of_path and edge in walls
            taken, jitter = bool(rng.random() < share), float(rng.uniform(0.0, 0.4))
            car = _car(rng, 0.0, side, street)
            if not taken and not (beside_path and share > 0):
                continue
            slack = 0.0 if beside_path else 0.2 + jitter
            half = 0.5 * vehicle_size(car.model).length_m
            x = edge + direction * (half + slack)
            if all(x + half < a or x - half > b for a, b in clear if (a, b) != (low, high)):
                cars.append(
                    VehicleSpec(
                        x_m=x, y_m=car.y_m, yaw_rad=car.yaw_rad, parked=True, model=car.model, seed=car.seed
                    )
                )
    return tuple(cars)
