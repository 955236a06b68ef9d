"""What rain does to the road: water film, wetness, friction."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.config import require

__all__ = ["friction_of_film", "rain_film_mm", "wetness_of_film"]

_FILM_MM = (0.0, 0.2, 1.0, 2.0)
_FRICTION = (0.85, 0.65, 0.55, 0.50)


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


def friction_of_film(film_mm: float) -> float:
    """Highest braking deceleration over g of ordinary tyres at town speeds.

    0.85 on a dry road, 0.65 at 0.2 mm, 0.55 at 1 mm, 0.50 from 2 mm on; linear between.
    """
    require(film_mm >= 0, "film_mm", film_mm, "0 or more")
    return float(np.interp(film_mm, _FILM_MM, _FRICTION))
