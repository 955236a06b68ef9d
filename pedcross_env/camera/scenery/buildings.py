"""Rows of houses as panels: ground floor, storeys, cornice, side walls; their roofs, and the gardens between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from pedcross_env.camera.kernels.facade import PANEL_SIZE
from pedcross_env.camera.props import TILES
from pedcross_env.camera.scenery.entrances import ENTRANCES, Entrance, add_entrance
from pedcross_env.camera.scenery.sides import finish_side_wall
from pedcross_env.config import require
from pedcross_env.scenario.street import StreetSpec

__all__ = [
    "BUILDINGS",
    "DEEP_M",
    "BuildingKind",
    "Roof",
    "Rows",
    "building_rows",
    "fit_bays",
    "register_building",
]

Range = tuple[float, float]
Colour = tuple[float, float, float]
HEDGE_DEEP_M, HEDGE_INSIDE = 0.5, 0.45  # half of a hedge, and how much of the light reaches into it
HEDGE = ((0.045, 0.085, 0.028), (0.06, 0.095, 0.03))
DEEP_M = 12.0  # of the houses
COPING_M, COPING = 0.1, np.array([0.42, 0.41, 0.38])  # stones on top of a garden's wall: height, albedo
PLASTER = (
    (0.44, 0.40, 0.33), (0.50, 0.48, 0.44), (0.46, 0.36, 0.24), (0.42, 0.38, 0.38), (0.36, 0.39, 0.40), (0.52, 0.45, 0.33),
    (0.45, 0.41, 0.27), (0.47, 0.36, 0.31), (0.38, 0.42, 0.36),
)  # fmt: skip
BRICK = ((0.27, 0.13, 0.09), (0.32, 0.17, 0.11), (0.22, 0.12, 0.09), (0.33, 0.22, 0.15))
CONCRETE = ((0.34, 0.34, 0.34), (0.46, 0.46, 0.45), (0.20, 0.21, 0.23), (0.40, 0.38, 0.35))


@dataclass(frozen=True, slots=True, kw_only=True)
class BuildingKind:
    """A kind of house; ranges are drawn from evenly.

    Attributes:
        share: How often it is built, in relation to the others.
        walls: Albedos of the wall.
        length_m: Along the street.
        storeys: Above the ground floor, least and most.
        storey_m: Height of one.
        ground_m: Height of the ground floor.
        bay_m: From window to window.
        window: Share of the bay and of the storey that is window; .95 and more along: bands of glass.
        ground_window: The same for the ground floor; shops have wide ones.
        ground_bays: How many bays one window of the ground floor takes.
        ground_tone: Albedo of the ground floor's wall over that of the others.
        trim: Albedo of cornices and window frames over that of the wall.
        roof: Its shape.
        setback_m: Behind the line of the facades.
        entrance: A door, one of glass, or shops with doors of glass and signs.
    """

    share: float
    walls: tuple[Colour, ...]
    length_m: Range = (9.0, 20.0)
    storeys: tuple[int, int] = (2, 5)
    storey_m: Range = (2.9, 3.3)
    ground_m: Range = (3.2, 4.0)
    bay_m: Range = (2.4, 3.4)
    window: tuple[Range, Range] = ((0.36, 0.52), (0.45, 0.58))
    ground_window: tuple[Range, Range] = ((0.36, 0.52), (0.42, 0.52))
    ground_bays: int = 1
    ground_tone: Range = (0.75, 1.0)
    trim: Range = (1.1, 1.5)
    roof: Literal["flat", "gable", "hip"] = "flat"
    setback_m: Range = (0.0, 0.4)
    entrance: Entrance = "door"

    def __post_init__(self) -> None:
        require(self.share >= 0, "BuildingKind.share", self.share, "0 or more")
        require(bool(self.walls), "BuildingKind.walls", self.walls, "one colour or more")
        require(self.roof in ("flat", "gable", "hip"), "BuildingKind.roof", self.roof, "flat, gable or hip")
        require(self.entrance in ENTRANCES, "BuildingKind.entrance", self.entrance, ", ".join(ENTRANCES))
        require(
            4 <= self.length_m[0] <= self.length_m[1] <= 60,
            "BuildingKind.length_m",
            self.length_m,
            "(low, high) within 4 to 60",
        )
        require(
            0 <= self.storeys[0] <= self.storeys[1] <= 30,
            "BuildingKind.storeys",
            self.storeys,
            "(least, most) within 0 to 30",
        )
        require(
            1.5 <= self.bay_m[0] <= self.bay_m[1],
            "BuildingKind.bay_m",
            self.bay_m,
            "(low, high), 1.5 or more",
        )
        require(
            0 <= self.setback_m[0] <= self.setback_m[1] <= 3,
            "BuildingKind.setback_m",
            self.setback_m,
            "(low, high) within 0 to 3",
        )
        for name in ("window", "ground_window"):
            for low, high in getattr(self, name):
                require(
                    0.05 <= low <= high <= 0.98,
                    f"BuildingKind.{name}",
                    (low, high),
                    "(low, high) within .05 to .98",
                )


BUILDINGS: dict[str, BuildingKind] = {
    "residential": BuildingKind(share=3.0, walls=PLASTER),
    "gabled": BuildingKind(share=2.0, walls=PLASTER, storeys=(1, 3), length_m=(7.0, 14.0), roof="gable"),
    "shop": BuildingKind(
        share=2.5, walls=PLASTER + BRICK, ground_m=(3.6, 4.3), ground_window=((0.62, 0.88), (0.55, 0.68)), ground_bays=2,
        ground_tone=(0.5, 0.9), entrance="shop",
    ),
    "brick": BuildingKind(
        share=2.0, walls=BRICK, storeys=(2, 4), window=((0.32, 0.42), (0.48, 0.58)), trim=(1.7, 2.4), roof="hip", ground_tone=(0.8, 1.3),
    ),
    "office": BuildingKind(
        share=1.2, walls=CONCRETE, length_m=(16.0, 30.0), storeys=(4, 7), storey_m=(3.3, 3.7), ground_m=(4.0, 4.8), bay_m=(3.2, 4.2),
        window=((0.94, 0.97), (0.50, 0.62)), ground_window=((0.88, 0.95), (0.68, 0.76)), trim=(0.9, 1.2), setback_m=(0.0, 1.0), entrance="glass",
    ),
    "townhouse": BuildingKind(
        share=1.2, walls=PLASTER + BRICK, length_m=(6.0, 8.5), storeys=(1, 2), bay_m=(2.0, 2.6), trim=(1.3, 1.7), roof="gable",
        setback_m=(0.0, 0.8),
    ),
}  # fmt: skip
"""Kinds of houses; add to it with ``register_building``."""


def register_building(name: str, kind: BuildingKind) -> None:
    """Add a kind of house; from then on streets have it by its share.

    Raises:
        ConfigError: If the name is taken.
    """
    require(
        bool(name) and name not in BUILDINGS, "building name", name, f"new; taken: {', '.join(BUILDINGS)}"
    )
    BUILDINGS[name] = kind


class House(NamedTuple):
    """One house: side of the street, x range, y of its front, height, its front's panel."""

    side: int
    x0: float
    x1: float
    front: float
    height: float
    panel: np.ndarray


class Roof(NamedTuple):
    """A roof: its prop, middle and base, extent."""

    prop: str
    x: float
    y: float
    z: float
    size: tuple[float, float, float]


class Gap(NamedTuple):
    """A garden between two houses: side, x range, y of its wall."""

    side: int
    x0: float
    x1: float
    front: float


class Hedge(NamedTuple):
    """Bushes side by side: x range, y of their middle, height above the sidewalk's base, albedo of the leaves."""

    x0: float
    x1: float
    y: float
    height: float
    leaves: tuple[float, float, float]


class Rows(NamedTuple):
    """Both rows of houses: panels (P, PANEL_SIZE), roofs, and hedges between."""

    panels: np.ndarray
    roofs: list[Roof]
    hedges: list[Hedge]


def _panel(
    x: float, y: float, z: float, ax: float, ay: float, length: float, height: float, wall: np.ndarray
) -> np.ndarray:
    """Return a plain wall; see kernels.facade for what the numbers are."""
    panel = np.zeros(PANEL_SIZE)
    panel[:8] = x, y, z, ax, ay, 0.0, length, height
    panel[8:11] = wall
    panel[12], panel[17], panel[18], panel[24] = 3.0, z, 1.25, 1.0
    panel[26:30] = float(y > 0), x, ax, float(y > 0)
    return panel


def _side_wall(side: int, x: float, facing: float, house: House, neighbour: House | None) -> list[np.ndarray]:
    """Return the visible parts of a side wall: above the neighbour, and in front of it."""

    def strip(near: float, far: float, base: float, top: float) -> np.ndarray:
        start = near if (facing > 0) == (side > 0) else far
        wall = _panel(x, start, base, 0.0, facing, abs(far - near), top - base, 0.92 * house.panel[8:11])
        finish_side_wall(wall, house.panel)
        return wall

    front, height = house.front, house.height
    if neighbour is None:
        return [strip(front, front + side * DEEP_M, 0.0, height)]
    parts = []
    if height > neighbour.height:
        parts.append(strip(front, front + side * DEEP_M, neighbour.height, height))
    if side * (neighbour.front - front) > 0.01:
        parts.append(strip(front, neighbour.front, 0.0, min(height, neighbour.height)))
    return parts


def _front(
    kind: BuildingKind,
    side: int,
    x: float,
    length: float,
    street: StreetSpec,
    rng: np.random.Generator,
    loose: bool,
) -> tuple[np.ndarray, House]:
    """Draw one house of a kind."""
    draw = lambda span: float(rng.uniform(*span))  # noqa: E731
    storeys, storey, ground = (
        int(rng.integers(kind.storeys[0], kind.storeys[1] + 1)),
        draw(kind.storey_m),
        draw(kind.ground_m),
    )
    wall = np.array(kind.walls[rng.integers(len(kind.walls))]) * rng.uniform(0.85, 1.12)
    front = side * (street.facade_y_m + draw(kind.setback_m) * loose)
    bays = max(1, round(length / draw(kind.bay_m)))
    height = ground + storeys * storey
    # the outward normal is axis x up: it points at the street on either side
    panel = _panel(x if side > 0 else x + length, front, 0.0, float(side), 0.0, length, height + 0.5, wall)
    panel[11:17] = (
        length / bays,
        storey,
        draw(kind.window[0]),
        draw(kind.window[1]),
        0.25,
        int(rng.integers(1, 30_000)),
    )
    low, tall = draw(kind.ground_window[0]), draw(kind.ground_window[1])
    sill = 0.10 if kind.ground_bays > 1 or low > 0.8 else 0.28
    panel[18] = draw(kind.trim)
    panel[19:22] = ground, length / max(1, bays // kind.ground_bays), low
    panel[22:26] = sill * ground, min(0.92, sill + tall) * ground, draw(kind.ground_tone), height
    add_entrance(panel, kind.entrance)
    return panel, House(side, x, x + length, front, height + 0.4, panel)


def _garden(gap: Gap, rng: np.random.Generator) -> tuple[list[np.ndarray], list[Hedge]]:
    """A low wall or a hedge at the street and the back of another house behind: nothing is seen through a gap."""
    side, along, length = gap.side, float(gap.side), gap.x1 - gap.x0
    start = gap.x0 if side > 0 else gap.x1
    surfaces = (BRICK, PLASTER, HEDGE)[int(rng.integers(3))]
    stone = np.array(surfaces[rng.integers(len(surfaces))])
    low = _panel(start, gap.front, 0.0, along, 0.0, length, rng.uniform(1.0, 1.9), 0.9 * stone)
    coping = _panel(start, gap.front, low[7], along, 0.0, length, COPING_M, COPING)
    back = _panel(
        start,
        gap.front + side * (DEEP_M - 0.2),
        0.0,
        along,
        0.0,
        length,
        rng.uniform(6.0, 11.0),
        0.85 * np.array(PLASTER[0]),
    )
    bay = length / max(1, round(length / 2.8))
    back[11:17] = bay, 3.0, 0.38, 0.5, 0.25, int(rng.integers(1, 30_000))
    back[19:22], back[22:26] = (3.2, bay, 0.38), (0.9, 2.4, 1.0, back[7] - 0.4)
    if surfaces is not HEDGE:
        return [low, coping, back], []
    hedge = Hedge(gap.x0, gap.x1, gap.front + side * HEDGE_DEEP_M, low[7], tuple(stone.tolist()))
    low[1] += side * 1.2 * HEDGE_DEEP_M  # what is seen of it is the dark inside
    low[7] *= 0.85
    low[8:11] *= HEDGE_INSIDE
    return [low, back], [hedge]


def fit_bays(panel: np.ndarray) -> None:
    """Stretch a front's bays so that whole ones fill its length."""
    for k in (11, 20):
        if panel[k] > 0:
            panel[k] = panel[6] / max(1, round(panel[6] / panel[k]))


def building_rows(street: StreetSpec, rng: np.random.Generator, loose: bool = True) -> Rows:
    """Build both sides of a street; every street favours some kinds of houses."""
    names = list(BUILDINGS)
    taste = np.array([BUILDINGS[name].share for name in names]) * rng.uniform(0.25, 1.75, len(names))
    panels: list[np.ndarray] = []
    houses: list[House] = []
    roofs: list[Roof] = []
    hedges: list[Hedge] = []
    for side in (-1, 1):
        x = street.start_x_m - 20.0
        while x < street.end_x_m + 40.0:
            kind = BUILDINGS[names[int(rng.choice(len(names), p=taste / taste.sum()))]]
            length = float(rng.uniform(*kind.length_m))
            panel, house = _front(kind, side, x, length, street, rng, loose)
            panels.append(panel)
            houses.append(house)
            if kind.roof != "flat":
                size = (
                    length + 0.3 if kind.roof == "hip" else length,
                    DEEP_M + 0.7,
                    float(rng.uniform(3.2, 5.0)),
                )
                middle = house.front + side * 0.5 * DEEP_M
                prop = f"{kind.roof}_roof_{int(rng.integers(len(TILES)))}"
                roofs.append(Roof(prop, x + 0.5 * length, middle, house.height, size))
            x += length
            if rng.random() < 0.13 and loose:
                wide = float(rng.uniform(4.0, 9.0))
                walls, bushes = _garden(Gap(side, x, x + wide, side * (street.facade_y_m + 0.1)), rng)
                panels += walls
                hedges += bushes
                x += wide
    for i, house in enumerate(houses):
        before = houses[i - 1] if i > 0 and houses[i - 1].side == house.side else None
        after = houses[i + 1] if i + 1 < len(houses) and houses[i + 1].side == house.side else None
        before = before if before and math.isclose(before.x1, house.x0, abs_tol=0.5) else None
        after = after if after and math.isclose(after.x0, house.x1, abs_tol=0.5) else None
        panels += _side_wall(house.side, house.x0, -1.0, house, before)
        panels += _side_wall(house.side, house.x1, 1.0, house, after)
    return Rows(np.array(panels), roofs, hedges)
