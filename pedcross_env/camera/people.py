"""People: their proportions, clothes, hair and what they carry, as capsules on the frames of a posed body.

All lengths are shares of the body's height. A person is drawn from its seed alone; ``PedestrianSpec.accessory`` adds to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from pedcross_env.camera.kernels.people import MAX_BODY, PART_SIZE
from pedcross_env.camera.kernels.pose import (
    ANKLE_Z,
    BUILD_SIZE,
    CHEST,
    FOOT,
    FOREARM,
    GROUND,
    HAND,
    HEAD,
    HELD,
    PELVIS,
    RIGHT,
    SHANK,
    THIGH,
    TOES,
    UPPER_ARM,
)

__all__ = ["Person", "person_of"]

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
RETRO_CLASS_2 = 330.0  # cd/(lx m2) at 12', ISO 20471
EYES = (0.03, 0.025, 0.022)
RUBBER, METAL, WOOD = (0.02, 0.02, 0.022), (0.30, 0.30, 0.31), (0.12, 0.07, 0.035)
ADULT, CHILD, ELDERLY = range(3)
COAT_ENDS = 0.62  # share of the thigh that it covers
FINE = 45.0  # pixels of body height from which fingers, noses and toes begin to show


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


Point = tuple[float, float, float]
Colour = tuple[float, float, float]


class _Body:
    """Collects capsules."""

    def __init__(self) -> None:
        self.rows: list[list[float]] = []

    def add(
        self, frame: int, a: Point, b: Point, ra: float, rb: float, colour: Colour, *, to: int | None = None, fine: float = 0.0,
        retro: float = 0.0,
    ) -> None:  # fmt: skip
        """Add a capsule between two points, the second in the frame ``to``."""
        end = frame if to is None else to
        self.rows.append([frame, *a, end, *b, ra, rb, *colour, retro, fine])

    def pair(
        self, frame: int, a: Point, b: Point, ra: float, rb: float, colour: Colour, *, fine: float = 0.0, retro: float = 0.0
    ) -> None:  # fmt: skip
        """Add a capsule to the left limb and its mirror image to the right one."""
        for side, at in ((1.0, frame), (-1.0, frame + RIGHT)):
            self.add(
                at,
                (a[0], side * a[1], a[2]),
                (b[0], side * b[1], b[2]),
                ra,
                rb,
                colour,
                fine=fine,
                retro=retro,
            )

    def table(self) -> np.ndarray:
        table = np.zeros((MAX_BODY, PART_SIZE))
        table[: len(self.rows)] = self.rows
        return table


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


def _trunk(b: _Body, girth: float, top: Colour, bottom: Colour, skin: Colour, coat: bool) -> None:
    """Add chest, belly, hips and neck."""
    g = girth
    for side in (
        1.0,
        -1.0,
    ):  # upright: a capsule seen along its axis jumps from one end's depth to the other's
        b.add(
            PELVIS,
            (0.0, side * 0.027, 0.020),
            (0.0, side * 0.027, -0.014),
            0.053 * g,
            0.053 * g,
            top if coat else bottom,
        )
    hem, hem_r = (-0.055, 0.064) if coat else (0.006, 0.066)  # proud of the hips: a hem, no blur
    for side in (1.0, -1.0):
        b.add(
            CHEST, (0.0, side * 0.040, -0.070), (0.004, side * 0.030 * g, -0.165), 0.056 * g, 0.054 * g, top
        )
        b.add(
            CHEST,
            (0.004, side * 0.030 * g, -0.165),
            (0.0, side * 0.031 * g, hem),
            0.054 * g,
            hem_r * g,
            top,
            to=PELVIS,
        )
        b.add(
            CHEST, (-0.010, side * 0.012, -0.016), (-0.004, side * 0.084, -0.046), 0.028, 0.034 * g**0.5, top
        )
    b.add(
        CHEST,
        (0.004, 0.0, -0.066),
        (0.003 + 0.03 * (g - 0.9), 0.0, 0.03),
        0.058 * g,
        0.060 * g,
        top,
        to=PELVIS,
    )
    b.add(CHEST, (-0.004, 0.0, -0.010), (-0.004, 0.0, -0.030), 0.029, 0.027, skin, to=HEAD)


def _legs(
    b: _Body,
    build: np.ndarray,
    girth: float,
    bottom: Colour,
    skin: Colour,
    shoes: Colour,
    style: str,
    coat: bool,
) -> None:
    """Add legs and feet; ``style``: trousers, slim, shorts, skirt. A leg begins where what is worn over it ends."""
    thigh, shank, g = float(build[4]), float(build[5]), girth**0.7
    bare = style in ("shorts", "skirt")
    wide = {"trousers": 0.030, "slim": 0.024}.get(style, 0.023)
    # first what covers: a leg behind it would show through where two parts of it meet
    if style == "shorts":
        b.pair(THIGH, (0.0, 0.0, -0.004), (0.0, 0.002, -0.80 * thigh), 0.052 * g, 0.050 * g, bottom)
    if style == "skirt":
        b.pair(THIGH, (0.0, 0.0, -0.004), (0.0, -0.004, -0.86 * thigh), 0.056 * g, 0.060 * g, bottom)
        b.add(PELVIS, (0.0, 0.0, -0.02), (0.0, 0.0, -0.80 * thigh), 0.056 * g, 0.062 * g, bottom)
    begins = {"shorts": 0.78, "skirt": 0.84}.get(style, COAT_ENDS - 0.02 if coat else 0.0)
    b.pair(
        THIGH,
        (0.0, 0.0, -0.004 - begins * thigh),
        (0.0, 0.0, -thigh),
        (0.050 - 0.015 * begins) * g,
        0.035 * g,
        bottom if not bare else skin,
    )
    b.pair(
        SHANK,
        (0.0, 0.0, 0.0),
        (-0.006, 0.0, -0.30 * shank),
        0.035 * g,
        0.034 * g,
        bottom if not bare else skin,
    )
    b.pair(
        SHANK,
        (-0.006, 0.0, -0.30 * shank),
        (0.0, 0.0, -shank + 0.008),
        0.034 * g,
        wide * g,
        bottom if not bare else skin,
    )
    sole = 0.020 - ANKLE_Z
    b.pair(FOOT, (-0.024, 0.0, sole), (0.066, 0.0, sole - 0.003), 0.020, 0.017, shoes)
    b.pair(FOOT, (-0.006, 0.0, -0.004), (0.03, 0.0, -0.014), 0.022, 0.019, shoes, fine=FINE)
    b.pair(TOES, (-0.009, 0.0, 0.017), (0.026, 0.0, 0.014), 0.017, 0.014, shoes)


def _arms(b: _Body, girth: float, sleeve: Colour, lower: Colour, skin: Colour) -> None:
    """Add arms; a bare forearm begins well inside the sleeve: its edge would show beside the sleeve's."""
    g, inside = girth**0.7, 0.0 if sleeve == lower else 0.016
    b.pair(UPPER_ARM, (0.0, 0.0, -0.002), (0.0, 0.0, -0.18), 0.032 * g, (0.026 + 0.25 * inside) * g, sleeve)
    b.pair(FOREARM, (0.0, 0.0, -inside), (0.0, 0.0, -0.142), (0.025 - 0.15 * inside) * g, 0.019 * g, lower)
    b.pair(HAND, (0.0, 0.0, -0.014), (0.0, 0.0, -0.038), 0.0140, 0.0165, skin)
    b.pair(HAND, (0.0, 0.0, -0.038), (0.010, 0.0, -0.076), 0.0145, 0.009, skin, fine=FINE)


def _head(b: _Body, size: float, skin: Colour, hair: Colour, style: str, cloth: Colour) -> None:
    """Add face and hair; ``style``: short, long, tail, bald, cap, beanie, hood."""

    def at(x: float, y: float, z: float) -> Point:
        return x * size, y * size, z * size

    cover = cloth if style in ("cap", "beanie", "hood") else hair
    b.add(HEAD, at(0.006, 0.0, 0.014), at(0.014, 0.0, -0.030), 0.0435 * size, 0.029 * size, skin)
    b.add(
        HEAD, at(0.042, 0.0, -0.002), at(0.045, 0.0, -0.012), 0.005 * size, 0.007 * size, skin, fine=2 * FINE
    )
    for side in (1.0, -1.0):
        b.add(
            HEAD,
            at(0.037, side * 0.0165, 0.006),
            at(0.037, side * 0.0125, 0.006),
            0.0040 * size,
            0.0040 * size,
            EYES,
            fine=3 * FINE,
        )
        b.add(
            HEAD,
            at(-0.002, side * 0.046, 0.002),
            at(-0.002, side * 0.042, -0.008),
            0.007 * size,
            0.005 * size,
            skin,
            fine=2 * FINE,
        )
    lips = (0.72 * skin[0], 0.5 * skin[1], 0.5 * skin[2])
    b.add(
        HEAD,
        at(0.036, 0.009, -0.032),
        at(0.036, -0.009, -0.032),
        0.0042 * size,
        0.0042 * size,
        lips,
        fine=3 * FINE,
    )
    if style == "bald":
        b.add(HEAD, at(-0.004, 0.0, 0.019), at(-0.008, 0.0, 0.010), 0.046 * size, 0.045 * size, skin)
        b.add(HEAD, at(-0.015, 0.0, -0.004), at(-0.018, 0.0, -0.012), 0.040 * size, 0.034 * size, hair)
        return
    r = 0.050 if style in ("beanie", "hood") else 0.0475
    b.add(HEAD, at(-0.004, 0.0, 0.066 - r), at(-0.014, 0.0, 0.008), r * size, 0.0445 * size, cover)
    b.add(
        HEAD,
        at(-0.014, 0.0, 0.004),
        at(-0.018, 0.0, -0.020),
        0.043 * size,
        0.033 * size,
        cover if style != "cap" else hair,
    )
    if style == "long":
        for side in (1.0, -1.0):
            b.add(
                HEAD,
                at(-0.012, side * 0.022, 0.0),
                at(-0.026, side * 0.024, -0.085),
                0.028 * size,
                0.020 * size,
                hair,
            )
    if style == "tail":
        b.add(HEAD, at(-0.055, 0.0, 0.018), at(-0.062, 0.0, -0.055), 0.018 * size, 0.010 * size, hair)
    if style == "cap":
        b.add(HEAD, at(0.030, 0.014, 0.030), at(0.066, 0.010, 0.026), 0.013 * size, 0.006 * size, cloth)
        b.add(HEAD, at(0.030, -0.014, 0.030), at(0.066, -0.010, 0.026), 0.013 * size, 0.006 * size, cloth)
    if style == "hood":
        b.add(HEAD, at(-0.016, 0.0, -0.005), (-0.022, 0.0, -0.015), 0.044 * size, 0.050, cloth, to=CHEST)


def _coat_tails(b: _Body, thigh: float, girth: float, top: Colour) -> None:
    g = girth
    b.pair(THIGH, (0.0, 0.0, 0.0), (-0.002, 0.0, -COAT_ENDS * thigh), 0.060 * g, 0.056 * g, top)
    b.add(PELVIS, (-0.006, 0.0, -0.03), (-0.004, 0.0, -0.55 * thigh), 0.060 * g, 0.056 * g, top)


def _backpack(b: _Body, colour: Colour) -> None:
    b.add(CHEST, (-0.075, 0.026, -0.050), (-0.082, 0.024, -0.175), 0.038, 0.046, colour)
    b.add(CHEST, (-0.075, -0.026, -0.050), (-0.082, -0.024, -0.175), 0.038, 0.046, colour)
    strap = (
        (-0.050, 0.046, -0.040),
        (-0.012, 0.048, 0.003),
        (0.034, 0.050, -0.020),
        (0.058, 0.056, -0.075),
        (0.055, 0.062, -0.130),
    )
    for side in (1.0, -1.0):
        for (x0, y0, z0), (x1, y1, z1) in pairwise(strap):
            b.add(CHEST, (x0, side * y0, z0), (x1, side * y1, z1), 0.010, 0.010, colour, fine=FINE)


def _handbag(b: _Body, colour: Colour) -> None:
    for z in (0.010, -0.028):
        b.add(PELVIS, (0.040, -0.100, z), (-0.050, -0.100, z), 0.022, 0.022, colour)
    b.add(PELVIS, (0.0, -0.100, 0.01), (-0.006, 0.040, 0.0), 0.006, 0.006, colour, to=CHEST)


def _hi_vis(b: _Body, girth: float) -> None:
    """Add two bands of retro-reflective tape round a vest (the trunk's colour) and one over each shoulder."""
    g, tape = girth, (0.55, 0.55, 0.56)
    for side in (1.0, -1.0):
        b.add(
            CHEST,
            (0.030, side * 0.048, -0.050),
            (0.038, side * 0.044, -0.10),
            0.026,
            0.025,
            tape,
            retro=RETRO_CLASS_2,
        )
    for z in (-0.118, -0.172):
        for y in (0.036 * g, 0.0, -0.036 * g):
            b.add(CHEST, (0.004, y, z), (0.004, y, z), 0.0625 * g, 0.0625 * g, tape, retro=RETRO_CLASS_2)


def _umbrella(b: _Body, colour: Colour, raining: bool) -> None:
    """Add an umbrella: up in the rain (a dome of ribs and cloth), else rolled in the hand."""
    if not raining:
        b.add(HELD, (0.0, 0.0, 0.02), (0.0, 0.0, -0.34), 0.012, 0.020, colour)
        return
    b.add(HELD, (0.0, 0.0, -0.03), (0.0, 0.0, 0.42), 0.006, 0.005, METAL)
    for k in range(20):
        c, s = float(np.cos(k * np.pi / 10)), float(np.sin(k * np.pi / 10))
        b.add(HELD, (0.03 * c, 0.03 * s, 0.405), (0.245 * c, 0.245 * s, 0.31), 0.016, 0.039, colour)


def _stroller(b: _Body, colour: Colour) -> None:
    """Add a stroller ahead of the hands: tub, hood, frame and wheels."""
    ahead = 0.30
    for side in (1.0, -1.0):
        y = side * 0.075
        b.add(GROUND, (ahead + 0.06, y, 0.30), (ahead + 0.36, y, 0.26), 0.065, 0.050, colour)
        b.add(GROUND, (ahead + 0.10, y, 0.40), (ahead + 0.08, y, 0.33), 0.085, 0.075, colour)
        b.add(GROUND, (0.24, side * 0.11, 0.535), (ahead + 0.34, side * 0.13, 0.075), 0.009, 0.009, METAL)
        b.add(
            GROUND, (ahead + 0.20, side * 0.13, 0.26), (ahead + 0.02, side * 0.13, 0.075), 0.009, 0.009, METAL
        )
        for x in (ahead + 0.02, ahead + 0.34):
            corners = [
                (x + 0.055 * np.cos(a), side * 0.14, 0.068 + 0.055 * np.sin(a))
                for a in np.arange(5) * 0.4 * np.pi
            ]
            for k in range(5):
                b.add(GROUND, corners[k], corners[(k + 1) % 5], 0.013, 0.013, RUBBER)
    b.add(GROUND, (0.24, 0.11, 0.535), (0.24, -0.11, 0.535), 0.011, 0.011, RUBBER)


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
    b = _Body()
    _trunk(b, girth, HI_VIS if carries == "hi-vis" else top, bottom, skin, coat)
    if coat:
        _coat_tails(b, float(build[4]), girth, top)
    _legs(b, build, girth, bottom, skin, shoes, legs, coat)
    _arms(b, girth, top, top if long_sleeves else skin, skin)
    _head(b, float(build[2]), skin, hair, style, top if style == "hood" else cloth)
    _carry(b, build, girth, carries, bag, raining)
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


def _carry(b: _Body, build: np.ndarray, girth: float, carries: str, colour: Colour, raining: bool) -> None:
    """Add what somebody carries and set its arms to it."""
    left, right = slice(8, 11), slice(11, 14)
    if carries == "backpack":
        _backpack(b, colour)
    elif carries == "handbag":
        _handbag(b, colour)
    elif carries == "hi-vis":
        _hi_vis(b, girth)
    elif carries == "umbrella":
        _umbrella(b, colour, raining)
        build[left] = (0.95, 0.25, 1.95) if raining else (0.6, 0.0, 0.15)
    elif carries == "stroller":
        _stroller(b, colour)
        build[left] = build[right] = 1.0, 0.40, 0.75
    elif carries == "cane":
        b.add(HELD, (0.0, 0.0, 0.01), (0.02, 0.01, -0.40), 0.009, 0.007, WOOD)
        build[left] = 0.75, 0.20, 0.35
    elif carries == "phone":
        b.add(HELD, (0.0, 0.0, 0.02), (0.0, 0.0, -0.02), 0.014, 0.014, RUBBER)
        build[left] = 1.0, 0.30, 1.75
