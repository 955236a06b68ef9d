"""Models of a van, a bus and a box truck."""

from __future__ import annotations

from pedcross_env.camera.cars import paint_sides, wheel_arch
from pedcross_env.camera.models import (
    DARK,
    GLASS,
    HEADLIGHT,
    PAINT,
    PLATE,
    TAIL,
    TRIM,
    Model,
    ModelBuilder,
    add_material,
    ring,
)
from pedcross_env.camera.two_wheelers import BLACK

__all__ = ["bus_model", "truck_model", "van_model"]

CANVAS = add_material(0.50, 0.50, 0.49, 0.1)


def _panes(
    b: ModelBuilder,
    x: tuple[float, float],
    count: int,
    y: tuple[float, float],
    z: tuple[float, float],
    gap: float = 0.06,
) -> None:
    """Paint a row of windows on both sides; ``y``: half widths at their lower and upper edge."""
    step = (x[1] - x[0]) / count
    for k in range(count):
        a, c = x[0] + k * step + 0.5 * gap, x[0] + (k + 1) * step - 0.5 * gap
        b.paint([(a, y[0], z[0]), (c, y[0], z[0]), (c, y[1], z[1]), (a, y[1], z[1])], GLASS, mirror=True)


def _square_front(b: ModelBuilder, half: float, w: float, z: float) -> None:
    """Paint lights, grille and plate on the front of a van, a bus or a cab, the lamps at a height of ``z``."""
    f = half + 0.002
    b.paint(
        [(f, 0.56 * w, z), (f, 0.92 * w, z + 0.02), (f, 0.92 * w, z + 0.18), (f, 0.58 * w, z + 0.14)],
        HEADLIGHT,
        mirror=True,
    )
    b.paint(
        [(f, -0.5 * w, z - 0.04), (f, 0.5 * w, z - 0.04), (f, 0.5 * w, z + 0.12), (f, -0.5 * w, z + 0.12)],
        TRIM,
    )
    b.paint([(f, -0.9 * w, 0.34), (f, 0.9 * w, 0.34), (f, 0.9 * w, 0.50), (f, -0.9 * w, 0.50)], BLACK)
    b.paint([(f, -0.26, 0.50), (f, 0.26, 0.50), (f, 0.26, 0.61), (f, -0.26, 0.61)], PLATE)


def _square_rear(b: ModelBuilder, half: float, w: float, z: float = 0.36) -> None:
    """Paint lamps, bumper and plate on the rear of a van, a bus or a box, the bumper's lower edge at ``z``."""
    r = -half - 0.002
    b.paint(
        [(r, 0.78 * w, z + 0.44), (r, 0.96 * w, z + 0.44), (r, 0.96 * w, z + 0.89), (r, 0.78 * w, z + 0.89)],
        TAIL,
        mirror=True,
    )
    b.paint([(r, -0.9 * w, z), (r, 0.9 * w, z), (r, 0.9 * w, z + 0.18), (r, -0.9 * w, z + 0.18)], BLACK)
    b.paint([(r, -0.26, z + 0.24), (r, 0.26, z + 0.24), (r, 0.26, z + 0.35), (r, -0.26, z + 0.35)], PLATE)


def van_model(size: tuple[float, float, float]) -> Model:
    """Build a van: bonnet and box meet in one ring, at the foot of its windscreen."""
    length, width, height = size
    b = ModelBuilder()
    half, w, low = length / 2, width / 2, 0.28
    glass = 0.56 * height
    wheel, front, rear = 0.34, half - 0.95, -half + 1.05
    foot = ring(half - 0.95, low, 0.85, glass + 0.02, (0.96 * w, w, 0.90 * w))  # of the windscreen
    b.loft(
        [
            foot,
            ring(half - 0.25, low, 0.80, glass - 0.22, (0.92 * w, 0.96 * w, 0.84 * w)),
            ring(half, low + 0.06, 0.70, glass - 0.48, (0.80 * w, 0.84 * w, 0.74 * w)),
        ],
        PAINT,
    )
    b.paint(wheel_arch(front, 0.985 * w, wheel, low), DARK, mirror=True)
    _square_front(b, half, w, glass - 0.62)
    b.loft(
        [
            ring(-half, low, 0.9, height - 0.06, (0.94 * w, 0.97 * w, 0.84 * w)),
            ring(-half + 0.12, low, 0.9, height, (0.96 * w, w, 0.86 * w)),
            ring(half - 1.75, low, 0.9, height, (0.96 * w, w, 0.86 * w)),
            foot,
        ],
        PAINT,
    )
    for x in (front, rear):
        b.paint(wheel_arch(x, 0.985 * w, wheel, low), DARK, mirror=True)
    b.paint([(half - 0.98, -0.80 * w, glass + 0.06), (half - 0.98, 0.80 * w, glass + 0.06), (half - 1.70, 0.76 * w, height - 0.08),
             (half - 1.70, -0.76 * w, height - 0.08)], GLASS)  # fmt: skip
    low_z, high_z = glass - 0.05, height - 0.34
    front_x = [
        half - 0.95 - 0.8 * (z - glass - 0.02) / (height - glass - 0.02) - 0.12 for z in (low_z, high_z)
    ]
    b.paint([(half - 2.2, 0.95 * w, low_z), (front_x[0], 0.95 * w, low_z), (front_x[1], 0.89 * w, high_z), (half - 2.2, 0.89 * w, high_z)],
            GLASS, mirror=True)  # fmt: skip
    r = -half - 0.002
    b.paint(
        [(r, 0.08, glass), (r, 0.80 * w, glass), (r, 0.76 * w, height - 0.30), (r, 0.08, height - 0.30)],
        GLASS,
        mirror=True,
    )
    paint_sides(b, (rear + 0.6, half - 2.25, half - 1.05), w, low, glass - 0.1)
    _square_rear(b, half, w)
    for side in (-1.0, 1.0):
        y = (side * w, side * (w + 0.18))
        b.box((half - 1.25, half - 1.12), (min(y), max(y)), (glass + 0.02, glass + 0.30), BLACK)
    b.wheel(front, wheel, 0.97 * w, 0.24)
    b.wheel(rear, wheel, 0.97 * w, 0.24)
    return b.build(*size)


def bus_model(size: tuple[float, float, float]) -> Model:
    """Build a bus, its door ahead of its front wheels."""
    length, width, height = size
    b = ModelBuilder()
    half, w, low = length / 2, width / 2, 0.30
    b.loft(
        [
            ring(-half, low, 1.0, height - 0.10, (0.95 * w, 0.97 * w, 0.86 * w)),
            ring(-half + 0.2, low, 1.0, height, (0.98 * w, w, 0.90 * w)),
            ring(half - 0.45, low, 1.0, height, (0.98 * w, w, 0.90 * w)),
            ring(half, low + 0.04, 1.0, height - 0.30, (0.90 * w, 0.92 * w, 0.84 * w)),
        ],
        PAINT,
    )
    wheel, front, rear = 0.48, half - 2.6, -half + 3.0
    for x in (front, rear):
        b.paint(wheel_arch(x, 0.99 * w, wheel, low), DARK, mirror=True)
    _panes(b, (-half + 0.35, half - 1.9), 7, (0.985 * w, 0.925 * w), (1.25, height - 0.42))
    _panes(b, (half - 1.75, half - 0.55), 1, (0.99 * w, 0.925 * w), (0.45, height - 0.42))  # the door
    f = half + 0.002
    b.paint(
        [
            (f, -0.82 * w, 1.05),
            (f, 0.82 * w, 1.05),
            (f, 0.78 * w, height - 0.55),
            (f, -0.78 * w, height - 0.55),
        ],
        GLASS,
    )
    b.paint(
        [
            (f, -0.7 * w, height - 0.50),
            (f, 0.7 * w, height - 0.50),
            (f, 0.68 * w, height - 0.32),
            (f, -0.68 * w, height - 0.32),
        ],
        BLACK,
    )
    r = -half - 0.002
    b.paint(
        [(r, -0.75 * w, 1.5), (r, 0.75 * w, 1.5), (r, 0.72 * w, height - 0.5), (r, -0.72 * w, height - 0.5)],
        GLASS,
    )
    _square_front(b, half, w, 0.62)
    _square_rear(b, half, w)
    b.wheel(front, wheel, 0.98 * w, 0.28)
    b.wheel(rear, wheel, 0.98 * w, 0.28)
    return b.build(*size)


def truck_model(size: tuple[float, float, float]) -> Model:
    """Build a box truck: cab, cargo box, chassis."""
    length, width, height = size
    b = ModelBuilder()
    half, w = length / 2, width / 2
    b.box((-half, half - 2.0), (-w, w), (0.95, height), CANVAS)
    _square_rear(b, half, w, 0.96)  # on the box, whose floor is at 0.95 m
    b.box((-half + 0.1, half - 0.3), (-0.45 * w, 0.45 * w), (0.45, 0.95), BLACK)
    cab = height - 0.75
    b.loft(
        [
            ring(half - 1.85, 0.42, 1.0, cab, (0.93 * w, 0.95 * w, 0.84 * w)),
            ring(half - 0.50, 0.42, 1.0, cab - 0.05, (0.93 * w, 0.95 * w, 0.82 * w)),
            ring(half, 0.42, 1.0, 1.35, (0.88 * w, 0.90 * w, 0.86 * w)),
        ],
        PAINT,
    )
    b.paint(
        [
            (half - 0.03, -0.78 * w, 1.40),
            (half - 0.03, 0.78 * w, 1.40),
            (half - 0.45, 0.74 * w, cab - 0.2),
            (half - 0.45, -0.74 * w, cab - 0.2),
        ],
        GLASS,
    )
    _panes(b, (half - 1.35, half - 0.42), 1, (0.93 * w, 0.86 * w), (1.35, cab - 0.28))
    b.paint(wheel_arch(half - 1.05, 0.955 * w, 0.45, 0.42), DARK, mirror=True)
    _square_front(b, half, 0.9 * w, 0.66)
    b.wheel(half - 1.05, 0.45, 0.96 * w, 0.28)
    b.wheel(-half + 1.3, 0.45, 0.98 * w, 0.45)
    return b.build(*size)
