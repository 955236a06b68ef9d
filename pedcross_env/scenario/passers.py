"""Vehicles in a random crossing: oncoming cars, cyclists, cars that turn across, a car ahead, doors that open."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pedcross_env.config import EgoConfig
from pedcross_env.scenario.scenario import PedestrianSpec, VehicleSpec
from pedcross_env.scenario.sizes import contact_radius_m, vehicle_size
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.scenario.trigger import Trigger
from pedcross_env.scenario.walk import Walk

__all__ = ["CARS", "CAR_SHARES", "cyclists", "leading_car", "oncoming_cars", "turning_cars", "with_door"]

CARS = ("hatchback", "sedan", "suv", "van")
CAR_SHARES = (0.4, 0.3, 0.2, 0.1)
_FIRST_AHEAD_M = (35.0, 110.0)  # oncoming cars start where they can still yield
_HEADWAY_M = (20.0, 45.0)
_SPEED_MPS = (7.0, 13.5)
_CYCLIST_MPS = (3.5, 7.0)
_FROM_EDGE_M = 0.15  # a cyclist keeps so far inside its lane's edge
_BESIDE_PARKED_M = 0.1  # and so far from parked cars
_BESIDE_EGO_M = 0.15  # nobody rides where an ego in the middle of its lane has less room
_APART_M = 12.0  # between the middles of a cyclist and of a car that start in the same lane
_PASSES_M = 0.2  # room beside a cyclist without which drivers stay behind it
_LEAD_S = (2.0, 3.2)  # between the fronts of the car ahead and of the ego
_DOOR_TTC_S = (1.2, 2.5)
_DOOR_CLEAR_M = 0.15  # an open door leaves so much room to who keeps the middle of the lane
_DOOR_REACH_M = 0.92


def _car(rng: np.random.Generator) -> tuple[str, int]:
    return str(rng.choice(CARS, p=CAR_SHARES)), int(rng.integers(2**31))


def oncoming_cars(
    rng: np.random.Generator, street: StreetSpec, most: int, *, meeting_x_m: float
) -> tuple[VehicleSpec, ...]:
    """0 to ``most`` cars in the opposite lane, beyond the meeting point, with room to stop before it."""
    x = meeting_x_m + float(rng.uniform(*_FIRST_AHEAD_M))
    cars = []
    for _ in range(int(rng.integers(most + 1))):
        speed = float(rng.uniform(*_SPEED_MPS))
        model, seed = _car(rng)
        cars.append(
            VehicleSpec(
                x_m=x, y_m=-street.ego_lane_y_m, yaw_rad=math.pi, speed_mps=speed, model=model, seed=seed
            )
        )
        x += float(rng.uniform(*_HEADWAY_M))
    return tuple(cars)


def turning_cars(
    rng: np.random.Generator, street: StreetSpec, *, first_x_m: float
) -> tuple[VehicleSpec, ...]:
    """One or two oncoming cars that turn left across the ego's lane, or right; they give way to the ego."""
    x, cars = first_x_m, []
    inner, outer = 0.5 * street.lane_width_m, -street.ego_lane_y_m
    for _ in range(int(rng.integers(1, 3))):
        turn = "left" if rng.random() < 0.75 else "right"
        speed = float(rng.uniform(5.0, 9.0))
        model, seed = _car(rng)
        cars.append(
            VehicleSpec(
                x_m=x, y_m=inner if turn == "left" else outer, yaw_rad=math.pi, speed_mps=speed, model=model,
                seed=seed, turn="left" if turn == "left" else "right",
            )
        )  # fmt: skip
        x += float(rng.uniform(12.0, 30.0))
    return tuple(cars)


def cyclists(
    rng: np.random.Generator,
    street: StreetSpec,
    others: tuple[VehicleSpec, ...],
    ego: EgoConfig,
    *,
    ego_speed_mps: float,
    meeting_x_m: float,
) -> tuple[VehicleSpec, ...]:
    """One cyclist at the right-hand edge of either direction: overtaken by the ego, or oncoming.

    None where parked cars leave no room beside the ego, where another vehicle starts, or where oncoming cars turn
    right across its way.
    """
    speed, share = float(rng.uniform(*_CYCLIST_MPS)), float(rng.uniform())
    ahead, seed = bool(rng.random() < 0.6), int(rng.integers(2**31))
    if ahead:
        speed = min(speed, 0.75 * ego_speed_mps)
        meets_s = meeting_x_m / ego_speed_mps * (0.3 + 0.6 * share)  # the ego comes up with it then
        x, side, yaw = max(10.0, (ego_speed_mps - speed) * meets_s), -1, 0.0
    else:
        x, side, yaw = meeting_x_m * (0.6 + 0.8 * share) + 10.0, 1, math.pi
    rider = VehicleSpec(
        x_m=x, y_m=side * _riding_line_m(street, others, side), yaw_rad=yaw, speed_mps=speed, model="cyclist", seed=seed
    )  # fmt: skip
    beside_m = abs(rider.y_m - street.ego_lane_y_m) - 0.5 * (vehicle_size("cyclist").width_m + ego.width_m)
    hooked = not ahead and any(car.turn == "right" for car in others)
    taken = any(abs(car.x_m - x) < _APART_M and car.y_m * side > 0 for car in others if not car.parked)
    return () if beside_m < _BESIDE_EGO_M or hooked or taken else (rider,)


def _riding_line_m(street: StreetSpec, others: tuple[VehicleSpec, ...], side: int) -> float:
    """How far from the centre line a cyclist rides on a side of the street: inside its lane, clear of parked cars."""
    line = street.lanes_per_direction * street.lane_width_m - _FROM_EDGE_M
    for car in others:
        if car.parked and car.y_m * side > 0:
            room = abs(car.y_m) - 0.5 * (vehicle_size(car.model).width_m + vehicle_size("cyclist").width_m)
            line = min(line, room - _BESIDE_PARKED_M)
    return line


def leading_car(
    rng: np.random.Generator,
    street: StreetSpec,
    ego: EgoConfig,
    *,
    ego_speed_mps: float,
    crossing: list[PedestrianSpec],
    others: tuple[VehicleSpec, ...],
    until_s: float,
) -> tuple[VehicleSpec, ...]:
    """A car ahead of the ego at its speed that hides the meeting point and is past it before anybody steps out.

    None where the people it would hide, or a cyclist whom it could not pass in its lane, are in its way.
    """
    ahead_s, (model, seed) = float(rng.uniform(*_LEAD_S)), _car(rng)
    size = vehicle_size(model)
    x = ego_speed_mps * ahead_s + 0.5 * (ego.length_m - size.length_m)
    for other in others:
        beside_m = abs(other.y_m - street.ego_lane_y_m) - 0.5 * (
            size.width_m + vehicle_size(other.model).width_m
        )
        if not other.parked and other.y_m < 0 and beside_m < _PASSES_M:
            return ()
    times = np.arange(0.0, until_s, 0.02)
    for spec in crossing:
        xy = Walk(spec).positions(times)
        reach = contact_radius_m(spec.height_m) + 0.4
        beside = np.abs(xy[:, 1] - street.ego_lane_y_m) < 0.5 * size.width_m + reach
        if (beside & (np.abs(xy[:, 0] - x - ego_speed_mps * times) < 0.5 * size.length_m + reach)).any():
            return ()
    return (
        VehicleSpec(
            x_m=x, y_m=street.ego_lane_y_m, speed_mps=ego_speed_mps, model=model, seed=seed, yields=False
        ),
    )


def with_door(
    rng: np.random.Generator,
    parked: tuple[VehicleSpec, ...],
    street: StreetSpec,
    ego: EgoConfig,
    path_x_m: tuple[float, float],
    riders: tuple[VehicleSpec, ...],
) -> tuple[VehicleSpec, ...]:
    """Let the door of one parked car open as the ego comes, where there is room for who keeps to its lane.

    Not beside ``path_x_m``, where people walk between the cars, nor on a side where somebody rides.
    """
    when = Trigger(ttc_s=float(rng.uniform(*_DOOR_TTC_S)))
    lane_edge = 0.5 * (street.lane_width_m - ego.width_m)
    able = []
    for index, car in enumerate(parked):
        size = vehicle_size(car.model)
        out_m = _DOOR_REACH_M - 0.5 * (street.parking_width_m - size.width_m)
        clear_x = car.x_m + size.length_m < path_x_m[0] or car.x_m - size.length_m > path_x_m[1]
        ridden = any(rider.y_m * car.y_m > 0 for rider in riders)
        near = 12.0 < car.x_m < path_x_m[1] + 15.0
        if out_m + _DOOR_CLEAR_M <= lane_edge and clear_x and near and not ridden:
            able.append(index)
    if not able:
        return parked
    chosen = int(rng.choice(able))
    return tuple(replace(car, door=when) if k == chosen else car for k, car in enumerate(parked))
