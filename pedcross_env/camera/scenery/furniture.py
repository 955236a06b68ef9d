"""What stands on the sidewalks: lamps and trees between kerb and walking space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pedcross_env.camera.scenery.lamps import LAMP_HEIGHT_M, lamp_places, lamp_post
from pedcross_env.camera.scenery.trees import GROUP_SIZE, Plant, draw_season, tree
from pedcross_env.contracts import StaticClass
from pedcross_env.scenario.street import StreetSpec

__all__ = ["CAPSULE_SIZE", "Standing", "standing_things"]

CAPSULE_SIZE = 12  # ends (6), radii (2), albedo (3), 1 where it shines as a street lamp
TREE_FROM_KERB_M = 0.9
CLEAR_OF_ZEBRA_M, CLEAR_OF_LAMP_M = 5.0, 2.6


@dataclass(frozen=True, slots=True)
class Standing:
    """Tables of what stands in a street; see Scenery."""

    capsules: np.ndarray
    groups: np.ndarray
    lamps: np.ndarray
    tree_shadows: np.ndarray


def _rows_of_trees(street: StreetSpec, lamps: np.ndarray, rng: np.random.Generator) -> list[Plant]:
    """Trees along both kerbs: one species per street, here and there another."""
    season = draw_season(rng)
    main = str(rng.choice(("round", "columnar"), p=(0.8, 0.2)))
    spacing = rng.uniform(8.0, 15.0)
    plants = []
    for side in (-1, 1):
        x = street.start_x_m + rng.uniform(4, 12)
        while x < street.end_x_m:
            near_zebra = any(abs(x - c.x_m) < 0.5 * c.width_m + CLEAR_OF_ZEBRA_M for c in street.crosswalks)
            near_lamp = bool((np.abs(x - lamps[lamps[:, 1] * side > 0, 0]) < CLEAR_OF_LAMP_M).any())
            if not near_zebra and not near_lamp:
                species = main if rng.random() < 0.85 else str(rng.choice(("round", "columnar")))
                y = side * (street.kerb_y_m + TREE_FROM_KERB_M)
                plants.append(tree(x, y, street.kerb_height_m, species, season, rng))
            x += spacing * rng.uniform(0.75, 1.3)
    return plants


def standing_things(street: StreetSpec, rng: np.random.Generator) -> Standing:
    """Place lamps and trees."""
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
    plants = _rows_of_trees(street, shining, rng)
    for plant in plants:
        first = len(capsules)
        capsules += plant.capsules
        groups.append([float(first), float(len(capsules)), *plant.group[2:]])
    shadows = np.array([plant.shadow for plant in plants]).reshape(-1, 6)
    return Standing(
        np.array(capsules).reshape(-1, CAPSULE_SIZE),
        np.array(groups).reshape(-1, GROUP_SIZE),
        shining,
        shadows,
    )
