"""Trees: trunk and limbs as capsules, the crown as a texture of leaves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pedcross_env.camera.scenery import foliage
from pedcross_env.contracts import StaticClass

__all__ = ["GROUP_SIZE", "Plant", "bushes", "draw_season", "tree"]

GROUP_SIZE = 16
"""A group of static primitives: capsule range (2), bounding sphere (4), StaticClass, then its crown: texture (-1: none), centre (3),
half width (negative: mirrored), half height, albedo (3)."""

BARK = np.array([[0.075, 0.055, 0.040], [0.10, 0.085, 0.07], [0.055, 0.045, 0.038]])
SUMMER = np.array(
    [
        [0.070, 0.125, 0.030],
        [0.085, 0.130, 0.034],
        [0.055, 0.105, 0.032],
        [0.105, 0.130, 0.036],
        [0.075, 0.115, 0.050],
    ]
)
AUTUMN = np.array([[0.20, 0.13, 0.025], [0.20, 0.10, 0.025], [0.16, 0.14, 0.03], [0.21, 0.16, 0.03]])
BUSH_M, BUSH_HALF_M = 1.6, 1.05  # from one to the next; half as wide
BUSH_INSET_M = 0.7  # of the first and the last: a crown seen askew would leave the end bare
NEEDLES = np.array([[0.035, 0.070, 0.032], [0.045, 0.075, 0.048]])


@dataclass(frozen=True, slots=True)
class Plant:
    """One tree.

    Attributes:
        capsules: Rows of CAPSULE_SIZE numbers.
        group: GROUP_SIZE numbers; the capsule range counts from 0.
        shadow: Crown centre, half width, half height, strength of its shadow.
    """

    capsules: list[list[float]]
    group: list[float]
    shadow: tuple[float, float, float, float, float, float]


def draw_season(rng: np.random.Generator) -> str:
    """Draw the season of a street: most are green."""
    return str(rng.choice(("summer", "autumn", "winter"), p=(0.76, 0.12, 0.12)))


def _plant(
    capsules: list[list[float]], centre: np.ndarray, base: float, texture: int, half: tuple[float, float], colour: np.ndarray,
    strength: float, rng: np.random.Generator,
) -> Plant:  # fmt: skip
    width, height = half
    top = centre[2] + height
    middle, reach = 0.5 * (base + top), 0.5 * (top - base)
    mirrored = -1.0 if rng.random() < 0.5 else 1.0
    group = [
        0.0, float(len(capsules)), centre[0], centre[1], middle, math.hypot(reach, width) + 0.1, float(StaticClass.VEGETATION),
        float(texture), *centre, mirrored * width, height, *colour,
    ]  # fmt: skip
    return Plant(capsules, group, (centre[0], centre[1], centre[2], width, height, strength))


def _trunk(
    x: float,
    y: float,
    base: float,
    fork: float,
    radius: float,
    bark: np.ndarray,
    rng: np.random.Generator,
    limbs: float,
) -> list[list[float]]:
    """Trunk with a swell at its foot, and limbs of a length of ``limbs`` from the fork into the crown."""
    lean = rng.normal(0, 0.06, 2)
    tx, ty = x + lean[0], y + lean[1]
    parts = [
        [x, y, base, x, y, base + 0.4, 1.45 * radius, radius, *bark, 0.0],
        [x, y, base + 0.4, tx, ty, base + fork, radius, 0.75 * radius, *bark, 0.0],
    ]
    turn = rng.uniform(0, 2 * math.pi)
    for k in range(3 if limbs > 0 else 0):
        angle = turn + 2.1 * k
        tip = (tx + 0.6 * limbs * math.cos(angle), ty + 0.6 * limbs * math.sin(angle), base + fork + limbs)
        parts.append([tx, ty, base + fork - 0.05, *tip, 0.6 * radius, 0.25 * radius, *bark, 0.0])
    return parts


def tree(x: float, y: float, base: float, species: str, season: str, rng: np.random.Generator) -> Plant:
    """Grow a tree.

    Args:
        x: Of its trunk, world.
        y: Of its trunk.
        base: Height of the ground.
        species: "round", "columnar" or "conifer".
        season: From ``draw_season``.
        rng: Of this tree.
    """
    bark = BARK[rng.integers(len(BARK))] * rng.uniform(0.85, 1.15)
    tone = rng.uniform(0.85, 1.2)
    if species == "conifer":
        height, half = rng.uniform(6.0, 9.5), (rng.uniform(1.3, 1.8), 0.0)
        half = (half[0], 0.5 * (height - 1.5))
        needles = NEEDLES[rng.integers(len(NEEDLES))] * tone
        trunk = _trunk(x, y, base, height - 1.0, 0.13, bark, rng, 0.0)
        return _plant(
            trunk,
            np.array([x, y, base + height - half[1]]),
            base,
            foliage.CONIFERS[0],
            half,
            needles,
            0.8,
            rng,
        )
    if species == "columnar":
        height, half = rng.uniform(7.5, 11.0), (rng.uniform(0.95, 1.3), 0.0)
        half = (half[0], 0.5 * (height - 2.1))
        texture, fork = foliage.COLUMNAR[0], 4.0
    else:
        height, wide = rng.uniform(6.0, 9.0), rng.uniform(1.75, 2.45)
        half = (wide, wide * rng.uniform(0.85, 1.15))
        texture = int(rng.choice(foliage.ROUND))
        fork = height - 1.65 * half[1]
    palette = AUTUMN if season == "autumn" else SUMMER
    leaves = palette[rng.integers(len(palette))] * tone
    centre = np.array([x, y, base + height - half[1]])
    if season == "winter":
        trunk = _trunk(x, y, base, height - 1.95 * half[1], 0.15, bark, rng, 0.0)
        return _plant(trunk, centre, base, int(rng.choice(foliage.BARE)), half, bark, 0.3, rng)
    trunk = _trunk(x, y, base, fork, 0.15, bark, rng, 0.55 * half[1] if species == "round" else 0.0)
    return _plant(trunk, centre, base, texture, half, leaves, 0.8, rng)


def bushes(
    x0: float, x1: float, y: float, base: float, height: float, leaves: np.ndarray, rng: np.random.Generator
) -> list[Plant]:
    """Plant bushes side by side between two places along the street, clipped to nearly one height.

    Args:
        x0: World, where the first begins.
        x1: Where the last ends.
        y: Of their middle.
        base: Height of the ground.
        height: Above it.
        leaves: (3,) albedo.
        rng: Of these bushes.
    """
    number = max(2, round((x1 - x0) / BUSH_M))
    plants = []
    for x in np.linspace(x0 + BUSH_INSET_M, x1 - BUSH_INSET_M, number):
        half = 0.5 * height * rng.uniform(0.96, 1.04)
        centre = np.array([x, y + rng.uniform(-0.05, 0.05), base + half])
        texture, tone = int(rng.choice(foliage.ROUND)), rng.uniform(0.9, 1.15)
        plants.append(_plant([], centre, base, texture, (BUSH_HALF_M, half), tone * leaves, 0.0, rng))
    return plants
