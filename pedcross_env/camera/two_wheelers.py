"""Models of a bicycle and a motorcycle."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.models import (
    HEADLIGHT,
    PAINT,
    RIM,
    TAIL,
    TYRE,
    Model,
    ModelBuilder,
    Point,
    add_material,
    ring,
)

__all__ = ["BLACK", "STEEL", "bicycle_model", "motorcycle_model"]

STEEL = add_material(0.42, 0.43, 0.44, 0.6)
BLACK = add_material(0.025, 0.025, 0.027, 0.3)


def _hoop(b: ModelBuilder, x: float, radius: float, rim: float, half_width: float) -> None:
    """Add a wheel one can look through: a ring of eight bars."""
    for k in range(8):
        a0, a1 = (2 * math.pi * (k + d) / 8 for d in (0.0, 1.0))
        rings = []
        for y in (-half_width, half_width):
            rings.append([(x + r * math.cos(a), y, radius + r * math.sin(a))
                          for r, a in ((radius, a0), (radius, a1), (radius - rim, a1), (radius - rim, a0))])  # fmt: skip
        b.loft(rings, TYRE)


def _bar(b: ModelBuilder, start: Point, end: Point, thick: float, material: int) -> None:
    """Add a bar of square section; it does not stand upright along y."""
    along = np.subtract(end, start)
    side = (
        np.cross(along, [0.0, 1.0, 0.0])
        if abs(along[0]) + abs(along[2]) > 1e-6
        else np.array([1.0, 0.0, 0.0])
    )
    side = 0.5 * thick * side / np.sqrt((side**2).sum())
    other = np.cross(along, side)
    other = 0.5 * thick * other / np.sqrt((other**2).sum())
    rings = [
        [
            tuple(np.add(p, sign_a * side + sign_b * other))
            for sign_a, sign_b in ((1, 1), (1, -1), (-1, -1), (-1, 1))
        ]
        for p in (start, end)
    ]
    b.loft(rings, material)


def bicycle_model(size: tuple[float, float, float]) -> Model:
    """Return a bicycle of a length, width and height in metres."""
    b = ModelBuilder()
    for x in (-0.53, 0.53):
        _hoop(b, x, 0.34, 0.045, 0.02)
    seat, crank, head = (-0.20, 0.0, 0.86), (-0.08, 0.0, 0.30), (0.36, 0.0, 0.82)
    for start, end in ((seat, crank), (crank, head), ((-0.18, 0.0, 0.76), head), (crank, (-0.53, 0.0, 0.34)), ((-0.18, 0.0, 0.76), (-0.53, 0.0, 0.34)),
                       (head, (0.53, 0.0, 0.34))):  # fmt: skip
        _bar(b, start, end, 0.035, PAINT)
    _bar(b, head, (0.33, 0.0, 1.02), 0.03, STEEL)
    _bar(b, (0.33, -0.29, 1.03), (0.33, 0.29, 1.03), 0.03, BLACK)
    b.box((-0.34, -0.08), (-0.07, 0.07), (0.87, 0.93), BLACK)
    b.box((-0.72, -0.70), (-0.04, 0.04), (0.62, 0.68), TAIL)
    return b.build(*size)


def motorcycle_model(size: tuple[float, float, float]) -> Model:
    """Return a motorcycle of a length, width and height in metres."""
    b = ModelBuilder()
    for x in (-0.68, 0.70):
        b.loft(
            [
                [(x + 0.30 * math.cos(a), y, 0.30 + 0.30 * math.sin(a)) for a in np.arange(12) * np.pi / 6]
                for y in (-0.07, 0.07)
            ],
            TYRE,
        )
        for side in (-0.07, 0.07):
            b.disc(x, side, 0.30, 0.19, RIM)
    b.loft(
        [
            ring(-0.30, 0.30, 0.45, 0.72, (0.12, 0.16, 0.10)),
            ring(0.35, 0.32, 0.50, 0.86, (0.12, 0.17, 0.10)),
        ],
        BLACK,
    )
    b.loft(
        [
            ring(-0.15, 0.70, 0.80, 0.92, (0.10, 0.16, 0.10)),
            ring(0.40, 0.74, 0.86, 1.00, (0.10, 0.15, 0.08)),
        ],
        PAINT,
    )
    b.loft(
        [
            ring(-0.95, 0.78, 0.82, 0.88, (0.05, 0.07, 0.05)),
            ring(-0.12, 0.74, 0.80, 0.84, (0.12, 0.15, 0.12)),
        ],
        BLACK,
    )
    b.paint([(-0.952, -0.06, 0.79), (-0.952, 0.06, 0.79), (-0.952, 0.06, 0.86), (-0.952, -0.06, 0.86)], TAIL)
    _bar(b, (0.42, 0.0, 0.95), (0.70, 0.0, 0.30), 0.10, STEEL)
    b.loft(
        [
            ring(0.45, 0.85, 0.98, 1.12, (0.09, 0.14, 0.08)),
            ring(0.62, 0.86, 0.95, 1.00, (0.07, 0.11, 0.06)),
        ],
        PAINT,
    )
    b.paint([(0.622, -0.07, 0.88), (0.622, 0.07, 0.88), (0.622, 0.06, 0.99), (0.622, -0.06, 0.99)], HEADLIGHT)
    _bar(b, (0.40, -0.36, 1.06), (0.40, 0.36, 1.06), 0.04, BLACK)
    return b.build(*size)
