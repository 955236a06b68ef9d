"""Cars at the kerb and oncoming, placed so that nobody has to walk through one."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.scenario.scenario import VehicleSpec
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.scenario.street import StreetSpec

__all__ = ["BAY_M", "CLEAR_OF_ZEBRA_M", "oncoming_cars", "parked_cars"]

BAY_M = 6.4
CLEAR_OF_ZEBRA_M = 5.0  # no parking before and behind a zebra
_CARS = ("hatchback", "sedan", "suv", "van")
_CAR_SHARES = (0.4, 0.3, 0.2, 0.1)
_SEEN_BEYOND_M = 60.0
_FIRST_AHEAD_M = (35.0, 110.0)  # oncoming cars start where they can still yield
_HEADWAY_M = (20.0, 45.0)
_SPEED_MPS = (7.0, 13.5)


def _car(rng: np.random.Generator, x_m: float, side: int, street: StreetSpec) -> VehicleSpec:
    return VehicleSpec(
        x_m=x_m,
        y_m=side * (street.kerb_y_m - 0.5 * street.parking_width_m),
        yaw_rad=0.0 if side < 0 else math.pi,
        parked=True,
        model=str(rng.choice(_CARS, p=_CAR_SHARES)),
        seed=int(rng.integers(2**31)),
    )


def parked_cars(
    rng: np.random.Generator,
    street: StreetSpec,
    share: float,
    *,
    path_x_m: tuple[float, float],
    between_side: int,
) -> tuple[VehicleSpec, ...]:
    """Cars in the bays of both sides.

    Args:
        rng: Of the scene.
        street: With its zebras, which stay clear by 5 m.
        share: Of bays that are taken.
        path_x_m: (low, high) x that pedestrians walk through; no car stands there on either side.
        between_side: Side (+-1) on which cars stand right beside that path (if share > 0); 0: on neither.

    Returns:
        Parked vehicles; none overlaps another, the path or a zebra's surroundings.
    """
    low, high = path_x_m
    clear = [(low, high)]
    for zebra in street.crosswalks:
        reach = 0.5 * zebra.width_m + CLEAR_OF_ZEBRA_M
        clear.append((zebra.x_m - reach, zebra.x_m + reach))
    cars: list[VehicleSpec] = []
    for side in (-1, 1):
        bays = [(high + k * BAY_M, 1) for k in range(int((_SEEN_BEYOND_M) / BAY_M))]
        bays += [(low - k * BAY_M, -1) for k in range(max(0, int(low / BAY_M)))]
        for edge, direction in bays:
            beside_path = side == between_side and edge in (low, high)
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


def oncoming_cars(
    rng: np.random.Generator, street: StreetSpec, most: int, *, meeting_x_m: float
) -> tuple[VehicleSpec, ...]:
    """0 to ``most`` cars in the opposite lane, beyond the meeting point, with room to stop before it."""
    x = meeting_x_m + float(rng.uniform(*_FIRST_AHEAD_M))
    cars = []
    for _ in range(int(rng.integers(most + 1))):
        cars.append(
            VehicleSpec(
                x_m=x,
                y_m=-street.ego_lane_y_m,
                yaw_rad=math.pi,
                speed_mps=float(rng.uniform(*_SPEED_MPS)),
                model=str(rng.choice(_CARS, p=_CAR_SHARES)),
                seed=int(rng.integers(2**31)),
            )
        )
        x += float(rng.uniform(*_HEADWAY_M))
    return tuple(cars)
