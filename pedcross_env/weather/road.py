"""What rain, snow and ice do to the road: water film, wetness, snow cover, friction."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.config import require

__all__ = [
    "film_slope", "friction_of_film", "rain_film_mm", "road_friction", "snow_cover_of_rate", "wetness_of_film",
]  # fmt: skip

_FILM_MM = (0.0, 0.2, 1.0, 2.0)
_FRICTION = (0.85, 0.65, 0.55, 0.50)
_SNOW_FRICTION = 0.25
_ICE_FRICTION = 0.10


def rain_film_mm(rain_mm_h: float) -> float:
    """Depth of the water that steady rain keeps on a carriageway, in mm.

    Gallaway et al. (1979), 0.01485 MTD^0.11 L^0.43 I^0.59 / S^0.42, for a drainage path L of 3.5 m, a
    cross fall S of 2 % and a texture depth MTD of 0.5 mm; the texture's own depth is not subtracted.
    """
    require(rain_mm_h >= 0, "rain_mm_h", rain_mm_h, "0 or more")
    return float(0.122 * rain_mm_h**0.59)


def wetness_of_film(film_mm: float) -> float:
    """How dark and glossy the surface is, 0..1: saturates where the film hides the texture's grain."""
    require(film_mm >= 0, "film_mm", film_mm, "0 or more")
    return 1.0 - math.exp(-film_mm / 0.2)


def film_slope(film_mm: float, rain_mm_h: float) -> float:
    """Root mean square slope of a wet road's surface, which smears what it mirrors.

    Stated choices: a damp road keeps 0.10 of its grain's slope, a millimetre of water drowns it down to 0.02, and drops
    that strike the film ripple it by 0.04 in 50 mm/h, independently of the grain.
    """
    require(film_mm >= 0, "film_mm", film_mm, "0 or more")
    require(rain_mm_h >= 0, "rain_mm_h", rain_mm_h, "0 or more")
    return math.hypot(0.02 + 0.08 * math.exp(-film_mm / 0.4), 0.04 * math.sqrt(min(1.0, rain_mm_h / 50.0)))


def snow_cover_of_rate(snow_mm_h: float) -> float:
    """Share of a driven street's ground that steady snowfall keeps white: 1 - exp(-S / 1.5 mm/h), a stated choice."""
    require(snow_mm_h >= 0, "snow_mm_h", snow_mm_h, "0 or more")
    return 1.0 - math.exp(-snow_mm_h / 1.5)


def friction_of_film(film_mm: float) -> float:
    """Highest braking deceleration over g of ordinary tyres at town speeds.

    0.85 on a dry road, 0.65 at 0.2 mm, 0.55 at 1 mm, 0.50 from 2 mm on; linear between.
    """
    require(film_mm >= 0, "film_mm", film_mm, "0 or more")
    return float(np.interp(film_mm, _FILM_MM, _FRICTION))


def road_friction(film_mm: float = 0.0, snow_cover: float = 0.0, ice_cover: float = 0.0) -> float:
    """Highest braking deceleration over g on a road that is wet, snowed or iced over in part.

    The bare part has the film's friction, packed snow 0.25, wet clear ice 0.10; parts count by their share of
    the road, ice before snow. The values lie in the ranges that Wallman and Astroem (VTI meddelande 911A, 2001)
    collected: dry 0.8 to 1.0, packed snow 0.20 to 0.30, black ice 0.15 to 0.30, wet ice 0.05 to 0.10.
    """
    for name, value in (("snow_cover", snow_cover), ("ice_cover", ice_cover)):
        require(0 <= value <= 1, name, value, "0 to 1")
    bare = friction_of_film(film_mm)
    snowed = bare + (_SNOW_FRICTION - bare) * snow_cover
    return snowed + (_ICE_FRICTION - snowed) * ice_cover
