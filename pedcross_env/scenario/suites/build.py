"""From a cell to its scenario: geometry and timing in closed form.

The contact is where the pedestrian's box first touches the ego's front: the pedestrian's middle is then at the
stated share of the ego's width. With a run-up of r metres at constant acceleration and D metres from the start to the
contact, a pedestrian of speed u needs (D + r) / u; it waits for the rest of the time that the ego needs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from pedcross_env.config import EgoConfig, require
from pedcross_env.errors import ConfigError
from pedcross_env.scenario.layout import turning_route
from pedcross_env.scenario.scenario import Leg, PedestrianSpec, Scenario, VehicleSpec
from pedcross_env.scenario.sizes import Size, pedestrian_size, vehicle_size
from pedcross_env.scenario.street import Intersection, SteelPlate, StreetSpec
from pedcross_env.scenario.suites.cell import Cell
from pedcross_env.scenario.trigger import Trigger
from pedcross_env.scenario.walk import RAMP_S

__all__ = ["CHILD_M", "build_scenario"]

ADULT_M, CHILD_M = 1.8, 1.15  # heights of Euro NCAP's dummies
LANE_M, PARKING_M = 3.5, 2.2
_TO_NEAR_KERB_M, _TO_FAR_KERB_M = 0.5 * LANE_M, 1.5 * LANE_M  # from the lane's middle, without parking strips
OBSTRUCTION_GAP_M = 1.0  # to the pedestrian's path, between the cars and to the ego's side
PASS_THROUGH_M = 4.5  # between the cars of a false activation test
PLATE_M = (3.7, 2.4)  # length, width of the trench plate of another one
AFTER_M, AFTER_S = 15.0, 6.0  # of the scenario, beyond the contact
SPARE_S = 0.1  # nobody sets off sooner
TURN_ARM_M = 1.0  # of straight way between the end of a turn and the ego's rear at the contact
TURN_AT_M = 90.0  # where the side street is
BEYOND_S = 25.0  # who walks along goes on for so long


@dataclass(frozen=True, slots=True)
class _Frame:
    """Where the ego is at the contact: a line along which it drives.

    Attributes:
        x: Of the ego's front, y: of it; both at the contact.
        ux: Direction of driving; uy.
        contact_m: The front's distance along the ego's way.
    """

    x: float
    y: float
    ux: float
    uy: float
    contact_m: float

    def at(self, ahead_m: float, left_m: float) -> tuple[float, float]:
        """Place ahead of the front's middle and to the left of it."""
        return self.x + ahead_m * self.ux - left_m * self.uy, self.y + ahead_m * self.uy + left_m * self.ux

    @property
    def yaw(self) -> float:
        return math.atan2(self.uy, self.ux)


def build_scenario(cell: Cell, ego: EgoConfig, seed: int) -> Scenario:
    """Build the scenario of a cell; see ``Cell.scenario``."""
    street = _street(cell, seed)
    person = pedestrian_size(CHILD_M if cell.child else ADULT_M)
    contact_s = _contact_s(cell, ego, person)
    frame = _frame(cell, street, ego, contact_s)
    if cell.kind == "plate":
        plate = SteelPlate(
            x_m=frame.x + 0.5 * PLATE_M[0], y_m=frame.y, length_m=PLATE_M[0], width_m=PLATE_M[1]
        )
        street = replace(street, plates=(plate,))
    people, vehicles = _actors(cell, frame, ego, person, contact_s, seed)
    return Scenario(
        name=cell.id,
        street=street,
        ego_x_m=frame.contact_m - 0.5 * ego.length_m - cell.ego_mps * contact_s,
        ego_speed_mps=cell.ego_mps,
        ego_turn=cell.turn or "straight",
        finish_x_m=frame.contact_m + AFTER_M,
        duration_s=contact_s + max(AFTER_S, (AFTER_M + ego.length_m) / cell.ego_mps),
        pedestrians=tuple(people),
        vehicles=tuple(vehicles),
    )


def _street(cell: Cell, seed: int) -> StreetSpec:
    if cell.turn:
        # the radius of turning_route's arc is the corner's plus what lies between kerb and lane
        inside = _TO_NEAR_KERB_M if cell.turn == "right" else _TO_FAR_KERB_M
        return StreetSpec(
            lane_width_m=LANE_M, parking_width_m=0.0, sidewalk_width_m=4.0, seed=seed, end_x_m=240.0,
            intersection=Intersection(
                x_m=TURN_AT_M, lane_width_m=LANE_M, sidewalk_width_m=4.0,
                corner_radius_m=cell.turn_radius_m - inside,
            ),
        )  # fmt: skip
    parking = PARKING_M if cell.obstructed or cell.kind in ("group", "gap") else 0.0
    return StreetSpec(
        lane_width_m=LANE_M, parking_width_m=parking, sidewalk_width_m=4.0, seed=seed, start_x_m=-120.0, end_x_m=340.0,
    )  # fmt: skip


def _side(cell: Cell) -> float:
    """-1: comes from the ego's right, 1: from its left."""
    return 1.0 if cell.far_side else -1.0


def _offset_m(cell: Cell, ego: EgoConfig) -> float:
    """Place of the contact to the left of the ego's middle."""
    return (cell.impact_share - 0.5) * ego.width_m


def _depth_m(cell: Cell, person: Size) -> float:
    """How far the pedestrian's box reaches towards the ego from its middle."""
    if cell.kind in ("along", "standing"):
        return 0.5 * person.length_m
    turned = math.radians(cell.heading_deg)
    return 0.5 * (person.length_m * abs(math.sin(turned)) + person.width_m * math.cos(turned))


def _walk_m(cell: Cell, ego: EgoConfig) -> float:
    """From the start to the contact."""
    sideways = cell.start_m - _side(cell) * _offset_m(cell, ego)
    return sideways / math.cos(math.radians(cell.heading_deg))


def _walk_s(cell: Cell, ego: EgoConfig) -> float:
    """From setting off to the contact."""
    speed = cell.pedestrian_kmh / 3.6
    run_up = cell.run_up_m or 0.5 * speed * RAMP_S
    walk_m = _walk_m(cell, ego)
    require(
        walk_m >= run_up, f"Cell({cell.id!r}).run_up_m", run_up,
        f"no longer than the way to the contact ({walk_m:.2f} m), e.g. {0.5 * max(walk_m, 0.2):.1f}",
    )  # fmt: skip
    return (walk_m + run_up) / speed


def _least_trigger_s(run_up_m: float, speed_mps: float, earlier_s: float) -> float:
    return math.ceil(10 * ((run_up_m + max(0.5, run_up_m)) / speed_mps + earlier_s)) / 10


def _contact_s(cell: Cell, ego: EgoConfig, person: Size) -> float:
    if cell.kind not in ("crossing", "group") or cell.trigger_s:
        return max(cell.ttc_s, cell.trigger_s + 1.0 if cell.trigger_s else 0.0)
    needed = _walk_s(cell, ego) + SPARE_S
    if needed <= cell.ttc_s:
        return cell.ttc_s
    if cell.strict:
        raise ConfigError(
            f"Cell({cell.id!r}).ttc_s = {cell.ttc_s:g} is impossible: from {cell.start_m:g} m to the side a "
            f"pedestrian of {cell.pedestrian_kmh:g} km/h with a run-up of {cell.run_up_m:g} m needs {needed:.2f} s "
            f"to the contact; give ttc_s = {math.ceil(10 * needed) / 10:g} or more, less start_m or strict = False."
        )
    return needed


def _frame(cell: Cell, street: StreetSpec, ego: EgoConfig, contact_s: float) -> _Frame:
    if not cell.turn:
        front = 0.5 * ego.length_m + cell.ego_mps * contact_s
        return _Frame(front, street.ego_lane_y_m, 1.0, 0.0, front)
    route = turning_route(street, cell.turn)
    front = route.breaks_m[-1] + ego.length_m + TURN_ARM_M
    x, y, heading = route.pose(front)
    return _Frame(x, y, round(math.cos(heading)), round(math.sin(heading)), front)


def _actors(
    cell: Cell, frame: _Frame, ego: EgoConfig, person: Size, contact_s: float, seed: int
) -> tuple[list[PedestrianSpec], list[VehicleSpec]]:
    if cell.kind == "gap":
        return [], _pass_through(frame, seed)
    if cell.kind == "plate":
        return [], []
    if cell.kind in ("along", "standing"):
        return [_in_lane(cell, frame, ego, person, contact_s, seed)], []
    people = [_crossing(cell, frame, ego, person, contact_s, seed)]
    if cell.kind == "group":  # two more behind, slower and later: 1.3 to 2.0 m/s, idle 0 to 1.5 s
        for k, (share, idle_s) in enumerate(((0.8, 0.75), (0.65, 1.5)), start=1):
            people.append(
                _crossing(
                    cell,
                    frame,
                    ego,
                    person,
                    contact_s,
                    seed + k,
                    beside_m=0.9 * k,
                    share=share,
                    idle_s=idle_s,
                )
            )
    vehicles = _obstruction(cell, frame, ego, person, seed) if cell.obstructed else []
    return people, vehicles


def _crossing(
    cell: Cell, frame: _Frame, ego: EgoConfig, person: Size, contact_s: float, seed: int, *,
    beside_m: float = 0.0, share: float = 1.0, idle_s: float = 0.0,
) -> PedestrianSpec:  # fmt: skip
    side, turned = _side(cell), math.radians(cell.heading_deg)
    speed, depth = cell.pedestrian_kmh / 3.6, _depth_m(cell, person)
    walk_m, ahead = _walk_m(cell, ego), depth + beside_m
    if cell.trigger_s:  # counted to the pedestrian's middle: the contact comes sooner by its depth
        run_up = cell.run_up_m or 0.5 * speed * RAMP_S
        walk_m = speed * (cell.trigger_s - depth / cell.ego_mps) - run_up
        if walk_m < max(0.5, run_up):
            raise ConfigError(
                f"Cell({cell.id!r}).trigger_s = {cell.trigger_s:g} is impossible: the ego arrives before the "
                f"pedestrian has sped up; give {_least_trigger_s(run_up, speed, depth / cell.ego_mps):.1f} or more, or "
                f"less run_up_m."
            )
    along, across = math.sin(turned), -side * math.cos(turned)
    to = (ahead, _offset_m(cell, ego))
    start = (to[0] - walk_m * along, to[1] - walk_m * across)
    beyond = _beyond_m(cell, side, start[1])
    far = (start[0] + beyond * along, start[1] + beyond * across)
    x, y = frame.at(*start)
    far_x, far_y = frame.at(*far)
    leg = Leg(
        to_x_m=far_x, to_y_m=far_y, speed_mps=share * speed, run_up_m=cell.run_up_m or None,
        wait_s=idle_s if cell.trigger_s else contact_s - _walk_s(cell, ego),
        go=Trigger(ttc_s=cell.trigger_s) if cell.trigger_s else None,
    )  # fmt: skip
    return PedestrianSpec(
        behaviour="crossing", x_m=x, y_m=y, yaw_rad=math.atan2(far_y - y, far_x - x), legs=(leg,),
        model="child" if cell.child else "adult", height_m=CHILD_M if cell.child else ADULT_M, seed=seed,
        accessory="none",
    )  # fmt: skip


def _beyond_m(cell: Cell, side: float, start_left_m: float) -> float:
    """Length of the whole way: to the middle of the sidewalk opposite."""
    parking = PARKING_M if cell.obstructed or cell.kind == "group" else 0.0
    opposite = (_TO_FAR_KERB_M if side < 0 else _TO_NEAR_KERB_M) + parking + 2.0
    return (opposite + abs(start_left_m)) / math.cos(math.radians(cell.heading_deg))


def _in_lane(
    cell: Cell, frame: _Frame, ego: EgoConfig, person: Size, contact_s: float, seed: int
) -> PedestrianSpec:
    speed = cell.pedestrian_kmh / 3.6 if cell.kind == "along" else 0.0
    x, y = frame.at(0.5 * person.length_m - speed * contact_s, _offset_m(cell, ego))
    to_x, to_y = frame.at(speed * BEYOND_S, _offset_m(cell, ego))
    legs = (Leg(to_x_m=to_x, to_y_m=to_y, speed_mps=speed),) if speed else ()
    return PedestrianSpec(
        behaviour="walking_along" if speed else "standing", x_m=x, y_m=y, yaw_rad=frame.yaw, legs=legs,
        model="child" if cell.child else "adult", height_m=CHILD_M if cell.child else ADULT_M, seed=seed,
        accessory="none",
    )  # fmt: skip


def _obstruction(cell: Cell, frame: _Frame, ego: EgoConfig, person: Size, seed: int) -> list[VehicleSpec]:
    """A small car nearest the pedestrian's path, an SUV before it; on the side the pedestrian comes from."""
    side, cars = _side(cell), []
    # the free space ends before the pedestrian's near side, where its path is nearest to the cars
    outer = 0.5 * ego.width_m + OBSTRUCTION_GAP_M + vehicle_size("suv").width_m
    slant = max(0.0, math.tan(math.radians(cell.heading_deg))) * (outer + 0.5 * person.length_m)
    end = -OBSTRUCTION_GAP_M - slant
    for k, model in enumerate(("hatchback", "suv")):
        size = vehicle_size(model)
        left = side * (0.5 * ego.width_m + OBSTRUCTION_GAP_M + 0.5 * size.width_m)
        x, y = frame.at(end - 0.5 * size.length_m, left)
        cars.append(
            VehicleSpec(
                x_m=x,
                y_m=y,
                yaw_rad=0.0 if side < 0 else math.pi,
                parked=True,
                model=model,
                seed=seed + 11 + k,
            )
        )
        end -= size.length_m + OBSTRUCTION_GAP_M
    return cars


def _pass_through(frame: _Frame, seed: int) -> list[VehicleSpec]:
    """A car on either side of the lane, to drive between."""
    size = vehicle_size("sedan")
    beside = 0.5 * (PASS_THROUGH_M + size.width_m)
    places = [frame.at(0.5 * size.length_m, side * beside) for side in (-1.0, 1.0)]
    return [
        VehicleSpec(x_m=x, y_m=y, parked=True, model="sedan", seed=seed + 21 + k)
        for k, (x, y) in enumerate(places)
    ]
