"""People: what their proportions, clothes, hair and colours are, and what they carry.

A person is drawn from its seed alone; ``PedestrianSpec.accessory`` adds to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pedcross_env.camera.body import Body, Colour, add_arms, add_coat_tails, add_head, add_legs, add_trunk
from pedcross_env.camera.carried import add_carried
from pedcross_env.camera.kernels.pose import BUILD_SIZE

__all__ = ["ADULT", "Person", "person_of"]

SKINS = (
    (0.50, 0.31, 0.21),
    (0.42, 0.25, 0.16),
    (0.30, 0.17, 0.10),
    (0.16, 0.085, 0.05),
    (0.09, 0.048, 0.028),
)
HAIRS = (
    (0.012, 0.010, 0.009),
    (0.04, 0.022, 0.012),
    (0.10, 0.055, 0.025),
    (0.30, 0.20, 0.09),
    (0.13, 0.035, 0.012),
)
GREYS = ((0.32, 0.31, 0.30), (0.50, 0.49, 0.47), (0.18, 0.18, 0.18))
TOPS = (
    (0.02, 0.02, 0.024), (0.03, 0.03, 0.035), (0.08, 0.085, 0.10), (0.02, 0.04, 0.10), (0.26, 0.03, 0.03), (0.50, 0.48, 0.44),
    (0.04, 0.11, 0.07), (0.42, 0.30, 0.06), (0.12, 0.085, 0.055), (0.10, 0.18, 0.30), (0.18, 0.17, 0.16), (0.30, 0.24, 0.16),
)  # fmt: skip
BOTTOMS = (
    (0.02, 0.03, 0.07),
    (0.015, 0.015, 0.017),
    (0.05, 0.08, 0.16),
    (0.20, 0.16, 0.11),
    (0.06, 0.06, 0.065),
    (0.05, 0.055, 0.03),
)
SHOES = ((0.02, 0.018, 0.016), (0.45, 0.45, 0.43), (0.08, 0.04, 0.02), (0.12, 0.12, 0.13))
BRIGHT = ((0.55, 0.42, 0.03), (0.36, 0.03, 0.03), (0.03, 0.15, 0.36), (0.40, 0.10, 0.20), (0.06, 0.28, 0.10))
HI_VIS = (0.62, 0.72, 0.04)
ADULT, CHILD, ELDERLY = range(3)


@dataclass(frozen=True, slots=True)
class Person:
    """What the kernels need to draw somebody.

    Attributes:
        build: (BUILD_SIZE,) proportions, see kernels.pose.
        body: (MAX_BODY, PART_SIZE) capsules, see kernels.people; rows beyond the last are 0.
        wears: Names of what it wears and carries, for tests and tables.
    """

    build: np.ndarray
    body: np.ndarray
    wears: tuple[str, ...]


def _build(model: int, rng: np.random.Generator, height_m: float) -> tuple[np.ndarray, float]:
    """(proportions, girth): slim to heavy by the seed; children with larger heads and shorter legs the smaller they are."""
    build = np.zeros(BUILD_SIZE)
    girth = float(np.clip(rng.normal(1.0, 0.11), 0.84, 1.28))
    broad = float(rng.uniform(0.94, 1.06))
    head, leg, stoop, vigour = 1.0 * rng.uniform(0.97, 1.03), 0.491, 0.02, 1.0
    if model == CHILD:
        young = float(np.clip((1.5 - height_m) / 0.5, 0.0, 1.0))
        head, leg = head * (1.06 + 0.22 * young), leg * (1.0 - 0.06 * young)
        girth, broad = girth * 0.96, broad * 0.97
    if model == ELDERLY:
        stoop, vigour = float(rng.uniform(0.12, 0.30)), 0.72
        leg *= 1.0 + 0.2 * stoop * stoop
    build[:8] = (
        0.096 * broad * (0.7 + 0.3 * girth),
        0.048 * girth**0.5,
        head,
        stoop,
        0.499 * leg,
        0.501 * leg,
        0.10 * girth,
        vigour,
    )
    return build, girth


@lru_cache(maxsize=512)
def person_of(model: int, seed: int, height_m: float, accessory: str = "", raining: bool = False) -> Person:
    """Draw somebody from the seed.

    Args:
        model: Index into PEDESTRIAN_MODELS.
        seed: Of the looks.
        height_m: Body height: children's proportions follow it.
        accessory: One of ACCESSORIES, or "" for what the seed gives.
        raining: Whether umbrellas are up; the weather changes nothing else.
    """
    rng = np.random.default_rng([seed & 0xFFFFFFFF, model, 77])

    def pick(colours: tuple[Colour, ...], shade: float = 0.0) -> Colour:
        chosen = np.array(colours[int(rng.integers(len(colours)))]) * rng.uniform(1 - shade, 1 + shade)
        r, g, b = (float(v) for v in np.clip(chosen, 0.008, 0.72))
        return r, g, b

    build, girth = _build(model, rng, height_m)
    skin, hair = pick(SKINS, 0.1), pick(GREYS if model == ELDERLY else HAIRS, 0.15)
    top, bottom, shoes = (
        pick(TOPS + (BRIGHT * 2 if model == CHILD else BRIGHT[:1]), 0.2),
        pick(BOTTOMS, 0.2),
        pick(SHOES),
    )
    cloth, bag = pick(TOPS + BRIGHT, 0.2), pick(TOPS, 0.2)
    styles = {
        ADULT: ("short", "short", "long", "tail", "bald", "cap", "beanie", "hood"),
        CHILD: ("short", "short", "long", "tail", "cap", "beanie"),
        ELDERLY: ("short", "short", "bald", "bald", "cap"),
    }[model]
    style = str(rng.choice(styles))
    legs = str(rng.choice(("trousers", "slim", "shorts", "skirt"), p=(0.5, 0.34, 0.08, 0.08)))
    coat = bool(rng.random() < 0.25) and legs != "shorts"
    long_sleeves = coat or style == "hood" or bool(rng.random() < 0.75)
    drawn = float(rng.random())
    carries = accessory or _usual(model, drawn, raining)
    b = Body()
    add_trunk(b, girth, HI_VIS if carries == "hi-vis" else top, bottom, skin, coat)
    if coat:
        add_coat_tails(b, float(build[4]), girth, top)
    add_legs(b, build, girth, bottom, skin, shoes, legs, coat)
    add_arms(b, girth, top, top if long_sleeves else skin, skin)
    add_head(b, float(build[2]), skin, hair, style, top if style == "hood" else cloth)
    add_carried(b, build, girth, carries, bag, raining)
    return Person(build, b.table(), (style, legs, *(("coat",) if coat else ()), carries))


def _usual(model: int, drawn: float, raining: bool) -> str:
    """What the seed gives: who has an umbrella at hand takes it out in the rain."""
    if model != CHILD and drawn < (0.45 if raining else 0.06):
        return "umbrella"
    if model == ELDERLY:
        return "cane" if drawn > 0.8 else "none"
    if model == CHILD:
        return "backpack" if drawn > 0.55 else "none"
    return "backpack" if drawn > 0.82 else "handbag" if drawn > 0.68 else "hi-vis" if drawn > 0.65 else "none"
