"""What stands on the sidewalks: lamps and trees between kerb and walking space, furniture there and at the facades."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pedcross_env.camera.kernels.scene import ROOF_KIND
from pedcross_env.camera.models import model_index
from pedcross_env.camera.props import FURNITURE, PropKind
from pedcross_env.camera.scenery.buildings import Roof, Rows
from pedcross_env.camera.scenery.lamps import LAMP_HEIGHT_M, lamp_places, lamp_post
from pedcross_env.camera.scenery.trees import GROUP_SIZE, Plant, bushes, draw_season, tree
from pedcross_env.contracts import ActorKind, StaticClass
from pedcross_env.scenario.street import StreetSpec

__all__ = ["CAPSULE_SIZE", "Props", "Standing", "standing_things"]

CAPSULE_SIZE = 12  # ends (6), radii (2), albedo (3), 1 where it shines as a street lamp
TREE_FROM_KERB_M = 0.9
CLEAR_OF_ZEBRA_M, CLEAR_OF_LAMP_M = 5.0, 2.6
FROM_FACADE_M, FROM_KERB_M = 0.26, 0.45  # people stand 0.35 m from the kerb and walk 0.5 m from the facade


@dataclass(frozen=True, slots=True)
class Props:
    """Polyhedra that stand still, as actors are given to the kernels.

    Attributes:
        numbers: (P, 14) as kernels.scene.
        idents: (P, 2) StaticClass, and how it is drawn: as vehicles are, or with the houses.
        looks: (P, 8, 4) paint in [:, 0, :3].
    """

    numbers: np.ndarray
    idents: np.ndarray
    looks: np.ndarray


@dataclass(frozen=True, slots=True)
class Prop:
    """One of them: model, place, yaw, size, paint, what it counts as."""

    model: str
    place: tuple[float, float, float]
    yaw: float
    size: tuple[float, float, float]
    colour: tuple[float, float, float]
    kind: StaticClass = StaticClass.FURNITURE


@dataclass(frozen=True, slots=True)
class Standing:
    """Tables of what stands in a street; see Scenery."""

    capsules: np.ndarray
    groups: np.ndarray
    lamps: np.ndarray
    shadows: np.ndarray
    props: Props


def _rows_of_trees(street: StreetSpec, lamps: np.ndarray, rng: np.random.Generator) -> list[Plant]:
    """Trees along both kerbs: one species per street, here and there another."""
    season = draw_season(rng)
    main = str(rng.choice(("round", "columnar"), p=(0.8, 0.2)))
    spacing = rng.uniform(8.0, 15.0)
    plants = []
    for side in (-1, 1):
        x = street.start_x_m + rng.uniform(4, 12)
        while x < street.end_x_m:
            near_zebra = _near_zebra(street, x, CLEAR_OF_ZEBRA_M)
            near_lamp = bool((np.abs(x - lamps[lamps[:, 1] * side > 0, 0]) < CLEAR_OF_LAMP_M).any())
            if not near_zebra and not near_lamp:
                species = main if rng.random() < 0.85 else str(rng.choice(("round", "columnar")))
                y = side * (street.kerb_y_m + TREE_FROM_KERB_M)
                plants.append(tree(x, y, street.kerb_height_m, species, season, rng))
            x += spacing * rng.uniform(0.75, 1.3)
    return plants


def _near_zebra(street: StreetSpec, x: float, clear: float) -> bool:
    return any(abs(x - c.x_m) < 0.5 * c.width_m + clear for c in street.crosswalks)


def _placed(
    name: str, kind: PropKind, x: float, side: int, street: StreetSpec, rng: np.random.Generator
) -> Prop:
    size = model_index(name)[1]
    y = street.facade_y_m - FROM_FACADE_M if kind.place == "facade" else street.kerb_y_m + FROM_KERB_M
    yaw = kind.turned_rad + (math.pi if side > 0 else 0.0)
    return Prop(
        name, (x, side * y, street.kerb_height_m), yaw, size, kind.colours[rng.integers(len(kind.colours))]
    )


def _furniture(street: StreetSpec, rng: np.random.Generator) -> list[Prop]:
    """Furniture at kerbs and facades, what belongs to the zebras, and plates on the road."""
    props = []
    for place in ("facade", "kerb"):
        kinds = [
            (name, kind) for name, kind in FURNITURE.items() if kind.place == place and kind.per_100_m > 0
        ]
        shares = np.array([kind.per_100_m for _, kind in kinds])
        for side in (-1, 1) if len(kinds) else ():
            x = street.start_x_m + rng.uniform(0, 15)
            while x < street.end_x_m:
                name, kind = kinds[int(rng.choice(len(kinds), p=shares / shares.sum()))]
                if not _near_zebra(street, x, CLEAR_OF_ZEBRA_M):
                    props.append(_placed(name, kind, x, side, street, rng))
                x += 100.0 / shares.sum() * rng.uniform(0.3, 1.7)
    for zebra in street.crosswalks:
        for side in (-1, 1):
            ahead = -side  # traffic on this side comes from there
            y, base = side * (street.kerb_y_m + FROM_KERB_M), street.kerb_height_m
            for name, away in (("crossing_sign", ahead * -0.7), ("bollard", 1.6), ("bollard", -1.6)):
                x = zebra.x_m + math.copysign(0.5 * zebra.width_m + abs(away), away)
                props.append(
                    Prop(
                        name,
                        (x, y, base),
                        math.pi if side > 0 else 0.0,
                        model_index(name)[1],
                        (0.3, 0.3, 0.3),
                    )
                )
    for plate in street.plates:
        size = plate.length_m, plate.width_m, plate.height_m
        props.append(Prop("steel_plate", (plate.x_m, plate.y_m, 0.0), 0.0, size, (0.3, 0.3, 0.3)))
    return props


def _table(props: list[Prop]) -> Props:
    numbers, idents = np.zeros((len(props), 14)), np.ones((len(props), 2), np.int64)
    looks = np.zeros((len(props), 8, 4))
    for k, prop in enumerate(props):
        numbers[k, :4] = *prop.place, prop.yaw
        numbers[k, 5:9] = model_index(prop.model)[0], *prop.size
        idents[k] = int(prop.kind), ROOF_KIND if prop.kind == StaticClass.BUILDING else ActorKind.VEHICLE
        looks[k, 0, :3] = prop.colour
    return Props(numbers, idents, looks)


def _roofs(roofs: list[Roof]) -> list[Prop]:
    return [Prop(r.prop, (r.x, r.y, r.z), 0.0, r.size, (0.2, 0.2, 0.2), StaticClass.BUILDING) for r in roofs]


def standing_things(street: StreetSpec, rows: Rows, rng: np.random.Generator) -> Standing:
    """Place lamps, trees, furniture, hedges and roofs."""
    tree_rng, prop_rng, hedge_rng = rng.spawn(3)
    base = street.kerb_height_m
    capsules: list[list[float]] = []
    groups: list[list[float]] = []
    lamps = []
    for x, y, head_y, side in lamp_places(street):
        first = len(capsules)
        capsules += lamp_post(x, y, head_y, side, base)
        group = [
            first,
            len(capsules),
            x,
            0.5 * (y + head_y),
            base + 3.6,
            4.0,
            float(StaticClass.FURNITURE),
            -1.0,
        ]
        groups.append(group + [0.0] * (GROUP_SIZE - len(group)))
        lamps.append((x, head_y, base + LAMP_HEIGHT_M - 0.05))
    shining = np.array(lamps)
    plants = _rows_of_trees(street, shining, tree_rng)
    hedges = [
        bush
        for x0, x1, y, height, leaves in rows.hedges
        for bush in bushes(x0, x1, y, base, height, np.array(leaves), hedge_rng)
    ]
    for plant in [*plants, *hedges]:
        first = len(capsules)
        capsules += plant.capsules
        groups.append([float(first), float(len(capsules)), *plant.group[2:]])
    furniture = _furniture(street, prop_rng)
    shadows = [(*plant.shadow, 1.1) for plant in plants]
    for prop in furniture:  # as upright ellipses, see shadows
        length, width, height = prop.size
        half = 0.5 * height
        shadows.append(
            (prop.place[0], prop.place[1], half, min(0.6, 0.5 * max(length, width)), half / 0.6, 0.7, 0.12)
        )
    return Standing(
        np.array(capsules).reshape(-1, CAPSULE_SIZE), np.array(groups).reshape(-1, GROUP_SIZE), shining,
        np.array(shadows).reshape(-1, 7), _table(furniture + _roofs(rows.roofs)),
    )  # fmt: skip
