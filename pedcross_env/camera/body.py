"""Bodies and clothes as capsules on the frames of a posed body. All lengths are shares of the body's height."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.people import MAX_BODY, PART_SIZE
from pedcross_env.camera.kernels.pose import (
    ANKLE_Z,
    CHEST,
    FOOT,
    FOREARM,
    HAND,
    HEAD,
    PELVIS,
    RIGHT,
    SHANK,
    THIGH,
    TOES,
    UPPER_ARM,
)

__all__ = [
    "FINE", "Body", "Colour", "Point", "add_arms", "add_coat_tails", "add_head", "add_legs", "add_trunk",
]  # fmt: skip

EYES = (0.03, 0.025, 0.022)
COAT_ENDS = 0.62  # share of the thigh that it covers
FINE = 45.0  # pixels of body height from which fingers, noses and toes begin to show

Point = tuple[float, float, float]
Colour = tuple[float, float, float]


class Body:
    """Collects the capsules of somebody's body, clothes and things carried."""

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
        """Return (MAX_BODY, PART_SIZE) as ``kernels.people``; rows beyond the last capsule are 0."""
        table = np.zeros((MAX_BODY, PART_SIZE))
        table[: len(self.rows)] = self.rows
        return table


def add_trunk(b: Body, girth: float, top: Colour, bottom: Colour, skin: Colour, coat: bool) -> None:
    """Add chest, belly, hips and neck."""
    g = girth
    # upright: a capsule seen along its axis jumps from one end's depth to the other's
    for side in (1.0, -1.0):
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


def add_legs(
    b: Body,
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


def add_arms(b: Body, girth: float, sleeve: Colour, lower: Colour, skin: Colour) -> None:
    """Add arms; a bare forearm begins well inside the sleeve: its edge would show beside the sleeve's."""
    g, inside = girth**0.7, 0.0 if sleeve == lower else 0.016
    b.pair(UPPER_ARM, (0.0, 0.0, -0.002), (0.0, 0.0, -0.18), 0.032 * g, (0.026 + 0.25 * inside) * g, sleeve)
    b.pair(FOREARM, (0.0, 0.0, -inside), (0.0, 0.0, -0.142), (0.025 - 0.15 * inside) * g, 0.019 * g, lower)
    b.pair(HAND, (0.0, 0.0, -0.014), (0.0, 0.0, -0.038), 0.0140, 0.0165, skin)
    b.pair(HAND, (0.0, 0.0, -0.038), (0.010, 0.0, -0.076), 0.0145, 0.009, skin, fine=FINE)


def add_head(b: Body, size: float, skin: Colour, hair: Colour, style: str, cloth: Colour) -> None:
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


def add_coat_tails(b: Body, thigh: float, girth: float, top: Colour) -> None:
    """Add what of a coat hangs over hips and thighs."""
    g = girth
    b.pair(THIGH, (0.0, 0.0, 0.0), (-0.002, 0.0, -COAT_ENDS * thigh), 0.060 * g, 0.056 * g, top)
    b.add(PELVIS, (-0.006, 0.0, -0.03), (-0.004, 0.0, -0.55 * thigh), 0.060 * g, 0.056 * g, top)
