"""How large road users are: footprints for contact, boxes for the camera."""

from __future__ import annotations

from typing import NamedTuple

from pedcross_env.errors import unknown_name

__all__ = [
    "REFERENCE_HEIGHT_M",
    "VEHICLE_SIZES",
    "Size",
    "contact_radius_m",
    "pedestrian_size",
    "vehicle_size",
]

REFERENCE_HEIGHT_M = 1.8
"""Height of Euro NCAP's adult dummy, in mid-step 0.6 m long along its way and 0.5 m wide; other heights scale it."""


class Size(NamedTuple):
    """Length along the heading, width across it, height; metres."""

    length_m: float
    width_m: float
    height_m: float


VEHICLE_SIZES: dict[str, Size] = {
    "hatchback": Size(4.1, 1.75, 1.47),
    "sedan": Size(4.7, 1.82, 1.45),
    "suv": Size(4.6, 1.88, 1.68),
    "van": Size(5.6, 2.0, 2.4),
    "bus": Size(12.0, 2.55, 3.1),
    "truck": Size(7.5, 2.45, 3.3),
    "motorcycle": Size(2.1, 0.75, 1.15),
    "bicycle": Size(1.75, 0.6, 1.05),
    "car_door": Size(1.05, 0.09, 1.15),
    "cyclist": Size(1.75, 0.6, 1.75),
}


def vehicle_size(model: str) -> Size:
    """Size of a vehicle model of pedcross_env.scenario.

    Raises:
        ConfigError: For an unknown model.
    """
    if model not in VEHICLE_SIZES:
        raise unknown_name("vehicle model", model, VEHICLE_SIZES)
    return VEHICLE_SIZES[model]


def pedestrian_size(height_m: float) -> Size:
    """Box of a pedestrian: Euro NCAP's adult footprint, scaled with the height."""
    scale = height_m / REFERENCE_HEIGHT_M
    return Size(0.6 * scale, 0.5 * scale, height_m)


def contact_radius_m(height_m: float) -> float:
    """Radius of a disc as large as a pedestrian's box: mean half extent, for who only keeps clear of it."""
    size = pedestrian_size(height_m)
    return 0.25 * (size.length_m + size.width_m)
