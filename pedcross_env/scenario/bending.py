"""A scenario of a straight street, moved to one that bends: who meets whom, and when, stays."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from pedcross_env.scenario.layout import to_world
from pedcross_env.scenario.scenario import Leg, PedestrianSpec, Scenario, VehicleSpec
from pedcross_env.scenario.street import StreetSpec

__all__ = ["Bend", "bent", "draw_bend"]

_RADIUS_M = (100.0, 300.0)  # parked cars keep their gaps on the inside
_LENGTH_M = (30.0, 80.0)
_STEP_M = 3.0  # of the chords of who walks along the bend: at most 2 cm beside it


@dataclass(frozen=True, slots=True)
class Bend:
    """An arc of a street's centre line: 1 / radius (positive to the left), where it begins, how long it is."""

    curvature_per_m: float
    start_m: float
    length_m: float


def draw_bend(rng: np.random.Generator, meeting_x_m: float) -> Bend:
    """Draw a bend that begins before the meeting point, which lies in it or beyond."""
    side, radius = int(rng.choice((-1, 1))), float(rng.uniform(*_RADIUS_M))
    start = meeting_x_m * float(rng.uniform(0.1, 0.8))
    return Bend(side / radius, start, float(rng.uniform(*_LENGTH_M)))


def bent(scenario: Scenario, bend: Bend) -> Scenario:
    """Return a straight street's scenario on a street that bends.

    Distances ahead of the ego are kept along the middle of its lane, so it is where it was at any time; whoever walks
    along the street goes as far as before, on a longer or shorter arc, and arrives where and when it did.

    Args:
        scenario: Of a straight street.
        bend: Of its centre line.
    """
    street = replace(
        scenario.street,
        curvature_per_m=bend.curvature_per_m,
        curve_start_x_m=bend.start_m,
        curve_length_m=bend.length_m,
    )
    lane = street.ego_lane_y_m
    zebras = tuple(replace(zebra, x_m=_street_m(bend, zebra.x_m, lane)) for zebra in street.crosswalks)
    street = replace(street, crosswalks=zebras)
    return replace(
        scenario,
        street=street,
        pedestrians=tuple(_person(spec, street, bend) for spec in scenario.pedestrians),
        vehicles=tuple(_vehicle(spec, street, bend) for spec in scenario.vehicles),
    )


def _line_m(bend: Bend, street_m: float, left_m: float) -> float:
    """Length of a line beside the centre line, up to a distance along the street."""
    arc = min(max(street_m - bend.start_m, 0.0), bend.length_m)
    return street_m - bend.curvature_per_m * left_m * arc


def _street_m(bend: Bend, line_m: float, left_m: float) -> float:
    """Distance along the street at a length of a line beside its centre line: the inverse of ``_line_m``."""
    stretch = 1.0 - bend.curvature_per_m * left_m
    on_arc = line_m - bend.start_m
    if on_arc <= 0:
        return line_m
    if on_arc < stretch * bend.length_m:
        return bend.start_m + on_arc / stretch
    return line_m + (1.0 - stretch) * bend.length_m


def _vehicle(spec: VehicleSpec, street: StreetSpec, bend: Bend) -> VehicleSpec:
    at = _street_m(bend, spec.x_m, street.ego_lane_y_m)
    x, y, heading = (float(v) for v in to_world(street, at, spec.y_m))
    return replace(spec, x_m=x, y_m=y, yaw_rad=spec.yaw_rad + heading)


def _person(spec: PedestrianSpec, street: StreetSpec, bend: Bend) -> PedestrianSpec:
    """The way is laid out from its end: where it ends is fixed, how long its parts are too."""
    corners = [(spec.x_m, spec.y_m), *((leg.to_x_m, leg.to_y_m) for leg in spec.legs)]
    at = [_street_m(bend, corners[-1][0], street.ego_lane_y_m)]
    for (x0, y0), (x1, _) in reversed(list(itertools.pairwise(corners))):
        at.append(_street_m(bend, _line_m(bend, at[-1], y0) - (x1 - x0), y0))
    at.reverse()
    legs: list[Leg] = []
    for k, leg in enumerate(spec.legs):
        legs += _legs(leg, street, bend, (at[k], corners[k][1]), (at[k + 1], corners[k + 1][1]))
    x, y, heading = (float(v) for v in to_world(street, at[0], spec.y_m))
    return replace(spec, x_m=x, y_m=y, yaw_rad=spec.yaw_rad + heading, legs=tuple(legs))


def _legs(
    leg: Leg, street: StreetSpec, bend: Bend, start: tuple[float, float], end: tuple[float, float]
) -> list[Leg]:
    """The chords of a leg between two (distance along the street, to the left of its centre line)."""
    low, high = sorted((start[0], end[0]))
    beside = high <= bend.start_m or low >= bend.start_m + bend.length_m
    count = 1 if beside else max(1, int(np.ceil((high - low) / _STEP_M)))
    s, d = (np.linspace(a, b, count + 1)[1:] for a, b in zip(start, end, strict=True))
    xs, ys, _ = to_world(street, s, d)
    first = replace(leg, to_x_m=float(xs[0]), to_y_m=float(ys[0]))
    on = [
        Leg(to_x_m=float(x), to_y_m=float(y), speed_mps=leg.speed_mps)
        for x, y in zip(xs[1:], ys[1:], strict=True)
    ]
    return [first, *on]
