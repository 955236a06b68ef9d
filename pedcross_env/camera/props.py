"""Street furniture that ships, registered on import, and roofs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pedcross_env.camera.models import (
    PAINT,
    Model,
    ModelBuilder,
    add_material,
    register_prop_model,
)
from pedcross_env.config import require

__all__ = ["FURNITURE", "TILES", "PropKind", "register_prop"]

STEEL = add_material(0.30, 0.31, 0.32, 0.4)
DARK_STEEL = add_material(0.06, 0.065, 0.07, 0.3)
WOOD = add_material(0.17, 0.10, 0.055, 0.05)
WHITE = add_material(0.62, 0.62, 0.60, 0.2)
BLUE = add_material(0.015, 0.06, 0.27, 0.2)
RED = add_material(0.36, 0.015, 0.02, 0.2)
YELLOW = add_material(0.55, 0.34, 0.015, 0.3)
BLACK = add_material(0.015, 0.015, 0.016, 0.1)
GREEN = add_material(0.035, 0.075, 0.045, 0.2)
RUST = add_material(0.15, 0.115, 0.095, 0.3)


TILES = ((0.20, 0.075, 0.045), (0.15, 0.065, 0.045), (0.075, 0.075, 0.08), (0.11, 0.085, 0.07))


@dataclass(frozen=True, slots=True, kw_only=True)
class PropKind:
    """Where a piece of furniture stands.

    Attributes:
        place: At the "facade", clear of the walking space; or at the "kerb", for thin things only.
        per_100_m: How many there are on 100 m of one side, on average.
        turned_rad: Yaw on the right side of the street; half a turn is added on the left one.
        colours: Albedos to draw its paint from.
    """

    place: Literal["facade", "kerb"]
    per_100_m: float
    turned_rad: float = 0.0
    colours: tuple[tuple[float, float, float], ...] = ((0.3, 0.3, 0.3),)

    def __post_init__(self) -> None:
        require(self.place in ("facade", "kerb"), "PropKind.place", self.place, "facade or kerb")
        require(0 <= self.per_100_m <= 50, "PropKind.per_100_m", self.per_100_m, "0 to 50")
        require(bool(self.colours), "PropKind.colours", self.colours, "one colour or more")


FURNITURE: dict[str, PropKind] = {}
"""What stands along the streets; add to it with ``register_prop``."""


def register_prop(name: str, model: Model, kind: PropKind) -> None:
    """Add a piece of street furniture; from then on it stands in every street.

    Args:
        name: A new name.
        model: At most 0.5 m deep (y) at the facade and 0.7 m wide at the kerb, so that nobody walks through it.
        kind: Where, and how often.

    Raises:
        ConfigError: If the name is taken or the model is too large for its place.
    """
    if kind.place == "facade":
        across = abs(model.size.length_m * np.sin(kind.turned_rad)) + abs(
            model.size.width_m * np.cos(kind.turned_rad)
        )
        require(across <= 0.65, f"depth of {name}", round(float(across), 2), "at most 0.65 m at the facade")
    else:
        require(
            model.size.width_m <= 0.7, f"width of {name}", model.size.width_m, "at most 0.7 m at the kerb"
        )
    register_prop_model(name, model)
    FURNITURE[name] = kind


def _bin() -> Model:
    b = ModelBuilder()
    b.pole(0, 0, (0.05, 0.80), 0.20, PAINT, 8)
    b.pole(0, 0, (0.80, 0.88), 0.22, BLACK, 8)
    return b.build(0.44, 0.44, 0.88)


def _bench() -> Model:
    b = ModelBuilder()
    for x in (-0.62, 0.62):
        b.box((x - 0.04, x + 0.04), (-0.20, 0.20), (0.0, 0.42), DARK_STEEL)
    b.box((-0.85, 0.85), (-0.22, 0.20), (0.42, 0.47), WOOD)
    b.box((-0.85, 0.85), (-0.24, -0.20), (0.55, 0.85), WOOD)
    return b.build(1.7, 0.48, 0.85)


def _post_box() -> Model:
    b = ModelBuilder()
    b.box((-0.22, 0.22), (-0.16, 0.16), (0.45, 1.20), YELLOW)
    b.paint([(-0.15, 0.161, 1.04), (0.15, 0.161, 1.04), (0.15, 0.161, 1.08), (-0.15, 0.161, 1.08)], BLACK)
    b.paint([(-0.12, 0.161, 0.65), (0.12, 0.161, 0.65), (0.12, 0.161, 0.85), (-0.12, 0.161, 0.85)], WHITE)
    b.pole(0, 0, (0.0, 0.45), 0.05, DARK_STEEL)
    return b.build(0.44, 0.34, 1.20)


def _cabinet() -> Model:
    b = ModelBuilder()
    b.box((-0.5, 0.5), (-0.17, 0.17), (0.0, 1.05), PAINT)
    b.paint(
        [(-0.006, 0.171, 0.1), (0.006, 0.171, 0.1), (0.006, 0.171, 1.0), (-0.006, 0.171, 1.0)],
        BLACK,
        fine=True,
    )
    return b.build(1.0, 0.36, 1.05)


def _planter() -> Model:
    b = ModelBuilder()
    b.box((-0.45, 0.45), (-0.22, 0.22), (0.0, 0.45), WOOD)
    ring = [(-0.42, -0.2), (0.42, -0.2), (0.42, 0.2), (-0.42, 0.2)]
    b.loft([[(s * x, s * y, z) for x, y in ring] for s, z in ((1.0, 0.45), (1.05, 0.62), (0.6, 0.85))], GREEN)
    return b.build(0.9, 0.44, 0.85)


def _bollard() -> Model:
    b = ModelBuilder()
    b.pole(0, 0, (0.0, 0.78), 0.055, DARK_STEEL)
    b.pole(0, 0, (0.78, 0.88), 0.058, WHITE)
    b.pole(0, 0, (0.88, 0.95), 0.055, DARK_STEEL)
    return b.build(0.12, 0.12, 0.95)


def _crossing_sign() -> Model:
    """The blue square with a white triangle, on both faces."""
    b = ModelBuilder()
    b.pole(0, 0, (0.0, 2.75), 0.03, STEEL)
    b.box((-0.045, -0.033), (-0.31, 0.31), (2.10, 2.72), BLUE)
    for x in (-0.046, -0.032):
        b.paint([(x, -0.25, 2.18), (x, 0.25, 2.18), (x, 0.0, 2.64)], WHITE)
        b.paint([(x, -0.05, 2.22), (x, 0.06, 2.22), (x, 0.03, 2.48), (x, -0.02, 2.48)], BLACK)
    return b.build(0.12, 0.62, 2.75)


def _round_sign() -> Model:
    """A round sign: red rim, white field, two digits as bars."""
    b = ModelBuilder()
    b.pole(0, 0, (0.0, 2.70), 0.03, STEEL)
    turn = np.arange(12) * np.pi / 6
    for radius, material in ((0.30, RED), (0.22, WHITE)):
        rim = [[(x, radius * np.cos(a), 2.38 + radius * np.sin(a)) for a in turn] for x in (-0.045, -0.033)]
        if material == RED:
            b.loft(rim, RED, STEEL)
            b.paint([(-0.046, y, z) for _, y, z in rim[0]], RED)
        else:
            b.paint([(-0.046, y, z) for _, y, z in rim[0]], WHITE)
    for y in (-0.07, 0.07):
        b.paint(
            [
                (-0.046, y - 0.045, 2.28),
                (-0.046, y + 0.045, 2.28),
                (-0.046, y + 0.045, 2.48),
                (-0.046, y - 0.045, 2.48),
            ],
            BLACK,
            fine=True,
        )
    return b.build(0.12, 0.60, 2.70)


def _roof(hipped: float, tiles: int) -> Model:
    """A roof on a unit square, its ridge along x, shortened by ``hipped`` at either end."""
    b = ModelBuilder()
    eaves = [(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)]
    r = 0.5 - hipped
    b.loft([eaves, [(-r, -0.01, 1.0), (r, -0.01, 1.0), (r, 0.01, 1.0), (-r, 0.01, 1.0)]], tiles)
    return b.build(1.0, 1.0, 1.0)


def _steel_plate() -> Model:
    """A rusty plate on a unit square; every plate is scaled to its own size."""
    b = ModelBuilder()
    b.box((-0.5, 0.5), (-0.5, 0.5), (0.0, 1.0), RUST)
    return b.build(1.0, 1.0, 1.0)


GREYS = ((0.22, 0.23, 0.23), (0.10, 0.11, 0.11), (0.05, 0.09, 0.06), (0.30, 0.30, 0.28))
register_prop("bin", _bin(), PropKind(place="facade", per_100_m=1.6, colours=GREYS))
register_prop("bench", _bench(), PropKind(place="facade", per_100_m=1.2))
register_prop("post_box", _post_box(), PropKind(place="facade", per_100_m=0.4))
register_prop("cabinet", _cabinet(), PropKind(place="facade", per_100_m=0.8, colours=GREYS))
register_prop("planter", _planter(), PropKind(place="facade", per_100_m=1.2))
register_prop("round_sign", _round_sign(), PropKind(place="kerb", per_100_m=1.0))
for _name, _model in (("crossing_sign", _crossing_sign()), ("bollard", _bollard())):
    register_prop_model(_name, _model)
for _k, _colour in enumerate(TILES):
    for _shape, _hipped in (("gable", 0.0), ("hip", 0.22)):
        register_prop_model(f"{_shape}_roof_{_k}", _roof(_hipped, add_material(*_colour, 0.0)))
register_prop_model("steel_plate", _steel_plate())
