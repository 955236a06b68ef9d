"""Cyclists: a person on the frames of a riding body, and a bicycle of thin capsules on the ground's frame."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np

from pedcross_env.camera.body import Body, Colour, Point
from pedcross_env.camera.kernels.pose import B_RIDES, CRANK, GROUND
from pedcross_env.camera.people import ADULT, Person, person_of

__all__ = ["RIDER_HEIGHT_M", "rider_of"]

RIDER_HEIGHT_M = 1.75
_WHEEL_M, _AXLES_M, _SPOKES = 0.34, (-0.53, 0.53), 10
_REACH = (1.0, 0.42, 0.22)  # arms held; upper arm ahead of down and bend of the elbow, rad
_PAINTS = (
    (0.03, 0.03, 0.035),
    (0.36, 0.02, 0.02),
    (0.03, 0.09, 0.24),
    (0.45, 0.45, 0.44),
    (0.05, 0.16, 0.10),
)
_RUBBER, _METAL, _TAIL = (0.02, 0.02, 0.022), (0.30, 0.30, 0.31), (0.30, 0.01, 0.01)
_REFLECTOR = 50.0  # cd/(lx m2) of its area, much below that of a vest's tape
_HEAVY = ("coat", "skirt", "shorts")  # clothes made for a standing body


def _bicycle(paint: Colour) -> Body:
    scale = 1.0 / RIDER_HEIGHT_M
    bicycle = Body()

    def bar(a: Point, b: Point, radius: float, colour: Colour, retro: float = 0.0) -> None:
        start, end = (scale * a[0], scale * a[1], scale * a[2]), (scale * b[0], scale * b[1], scale * b[2])
        bicycle.add(GROUND, start, end, radius * scale, radius * scale, colour, retro=retro)

    for x in _AXLES_M:
        turn = 2 * np.pi * np.arange(_SPOKES + 1) / _SPOKES
        rim = [
            (x + _WHEEL_M * float(np.cos(t)), 0.0, _WHEEL_M + 0.02 + _WHEEL_M * float(np.sin(t)))
            for t in turn
        ]
        for a, b in itertools.pairwise(rim):
            bar(a, b, 0.018, _RUBBER)
    crank, seat, head = (CRANK[0], 0.0, CRANK[1]), (-0.20, 0.0, 0.90), (0.36, 0.0, 0.84)
    rear, front = (_AXLES_M[0], 0.0, _WHEEL_M), (_AXLES_M[1], 0.0, _WHEEL_M)
    for a, b in (
        (crank, seat),
        (crank, head),
        ((-0.18, 0.0, 0.78), head),
        (crank, rear),
        ((-0.18, 0.0, 0.78), rear),
    ):
        bar(a, b, 0.017, paint)
    bar(head, front, 0.016, paint)
    bar((0.34, -0.26, 1.04), (0.34, 0.26, 1.04), 0.014, _METAL)
    bar((-0.32, 0.0, 0.92), (-0.10, 0.0, 0.92), 0.035, _RUBBER)
    bar((-0.66, 0.0, 0.62), (-0.66, 0.0, 0.65), 0.03, _TAIL, _REFLECTOR)
    return bicycle


@lru_cache(maxsize=64)
def rider_of(seed: int) -> Person:
    """Draw a cyclist from a seed: an adult without coat or skirt, on a bicycle of some colour.

    The bicycle is tall as the rider is.
    """
    person = person_of(ADULT, seed, RIDER_HEIGHT_M, "none")
    other = seed
    while any(piece in person.wears for piece in _HEAVY):
        other += 1
        person = person_of(ADULT, other, RIDER_HEIGHT_M, "none")
    build = person.build.copy()
    build[B_RIDES] = 1.0
    build[8:11] = build[11:14] = _REACH
    drawn = _bicycle(_PAINTS[seed % len(_PAINTS)])
    body = [row.tolist() for row in person.body if row[8] > 0]
    drawn.rows += sorted(body, key=lambda row: row[14])  # what is always seen first
    return Person(build, drawn.table(), person.wears)
