"""Models of cars, and of a car's open door."""

from __future__ import annotations

import math

import numpy as np

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
    Point,
    ring,
)
from pedcross_env.camera.two_wheelers import BLACK, STEEL

__all__ = ["car_door_model", "car_model", "paint_sides", "wheel_arch"]


def wheel_arch(x: float, y: float, radius: float, low: float) -> list[Point]:
    """Return the outline of a wheel's housing on the side at ``y``, cut off at a height of ``low``."""
    angles = np.linspace(0, np.pi, 9)
    reach = 1.16 * radius
    rim = [(x + reach * math.cos(a), y, max(low, radius + reach * math.sin(a))) for a in angles]
    return [(x + reach, y, low), *rim, (x - reach, y, low)]


def _ends(b: ModelBuilder, half: float, w: float, z: dict[str, float]) -> None:
    """Paint grille, lights, plates and bumpers on either end of a car's body."""
    f, r = half + 0.002, -half - 0.002
    lamp, tail = z["lamp"], z["tail"]
    b.paint(
        [
            (f, -0.50 * w, lamp - 0.02),
            (f, 0.50 * w, lamp - 0.02),
            (f, 0.46 * w, lamp - 0.14),
            (f, -0.46 * w, lamp - 0.14),
        ],
        TRIM,
    )
    b.paint([(f, -0.70 * w, 0.26), (f, 0.70 * w, 0.26), (f, 0.58 * w, 0.40), (f, -0.58 * w, 0.40)], BLACK)
    b.paint([(f, -0.26, 0.42), (f, 0.26, 0.42), (f, 0.26, 0.53), (f, -0.26, 0.53)], PLATE)
    corner = half - 0.10
    b.paint([(f, 0.52 * w, lamp - 0.13), (corner, 0.92 * w, lamp - 0.10), (corner, 0.90 * w, lamp + 0.03), (f, 0.50 * w, lamp - 0.01)],
            HEADLIGHT, mirror=True)  # fmt: skip
    b.paint(
        [(f, 0.60 * w, 0.31), (f, 0.68 * w, 0.31), (f, 0.68 * w, 0.38), (f, 0.60 * w, 0.38)],
        STEEL,
        mirror=True,
        fine=True,
    )
    corner = -half + 0.12
    b.paint([(r, 0.50 * w, tail - 0.13), (corner, 0.93 * w, tail - 0.15), (corner, 0.90 * w, tail), (r, 0.58 * w, tail)],
            TAIL, mirror=True)  # fmt: skip
    b.paint(
        [(r, -0.26, tail - 0.22), (r, 0.26, tail - 0.22), (r, 0.26, tail - 0.11), (r, -0.26, tail - 0.11)],
        PLATE,
    )
    b.paint([(r, -0.80 * w, 0.25), (r, 0.80 * w, 0.25), (r, 0.78 * w, 0.40), (r, -0.78 * w, 0.40)], BLACK)
    b.paint(
        [(r, -0.84 * w, 0.515), (r, 0.84 * w, 0.515), (r, 0.84 * w, 0.53), (r, -0.84 * w, 0.53)],
        DARK,
        fine=True,
    )


def paint_sides(b: ModelBuilder, doors: tuple[float, ...], w: float, low: float, belt: float) -> None:
    """Paint joints of doors, and handles, on both sides of a body; ``doors``: where the joints are, from the rear."""
    for x in doors:
        b.paint([(x - 0.008, w, low + 0.12), (x + 0.008, w, low + 0.12), (x + 0.008, 0.97 * w, belt - 0.04), (x - 0.008, 0.97 * w, belt - 0.04)],
                DARK, mirror=True, fine=True)  # fmt: skip
    for x in doors[:-1]:
        b.paint([(x + 0.06, w, belt - 0.15), (x + 0.24, w, belt - 0.15), (x + 0.24, w, belt - 0.12), (x + 0.06, w, belt - 0.12)],
                BLACK, mirror=True, fine=True)  # fmt: skip


def _cabin(
    b: ModelBuilder,
    x: tuple[float, float],
    rake: tuple[float, float],
    w: float,
    belt: float,
    height: float,
    pillars: int,
) -> None:
    """Add a cabin with windows and mirrors; ``x``: its range at the belt line; ``rake``: how far rear and front lean in."""
    x0, x1 = x
    rise = height - belt
    t0, t1, upper = x0 + 0.82 * rake[0], x1 - 0.82 * rake[1], 0.77 * w
    r0, r1, roof = x0 + rake[0] + 0.12, x1 - rake[1] - 0.16, 0.65 * w
    # well within the body's upper edge: a narrower shoulder than a pixel would be seen here and hidden there
    sill = 0.85 * w
    z1 = belt + 0.84 * rise

    def level(a: float, c: float, y: float, z: float) -> list[Point]:
        return [(a, -0.92 * y, z), (c, -y, z), (c, y, z), (a, 0.92 * y, z)]  # narrower at the rear

    b.loft([level(x0, x1, sill, belt - 0.03), level(t0, t1, upper, z1), level(r0, r1, roof, height)], PAINT)

    def at(s: float, t: float, side: float, wide: float = 1.0) -> Point:
        a, c = x0 + t * (t0 - x0), x1 + t * (t1 - x1)
        return (
            a + s * (c - a),
            side * wide * (0.92 + 0.08 * s) * (sill + t * (upper - sill)),
            belt - 0.03 + t * (z1 - belt + 0.03),
        )

    rear = 0.07 if rake[0] < 0.6 else 0.10
    b.paint(
        [at(rear, 0.13, 1), at(0.97, 0.13, 1), at(0.945, 0.93, 1), at(rear + 0.03, 0.93, 1)],
        GLASS,
        mirror=True,
    )
    for k in range(1, pillars + 1):
        s = rear + (0.95 - rear) * (0.10 + 0.84 * k / (pillars + 1))
        b.paint(
            [at(s - 0.018, 0.13, 1), at(s + 0.018, 0.13, 1), at(s + 0.016, 0.93, 1), at(s - 0.016, 0.93, 1)],
            BLACK,
            mirror=True,
        )
    b.paint([at(1, 0.08, -1, 0.9), at(1, 0.08, 1, 0.9), at(1, 0.95, 1, 0.9), at(1, 0.95, -1, 0.9)], GLASS)
    b.paint([at(0, 0.14, -1, 0.86), at(0, 0.14, 1, 0.86), at(0, 0.93, 1, 0.86), at(0, 0.93, -1, 0.86)], GLASS)
    for side in (-1.0, 1.0):
        y = (side * 0.93 * w, side * (0.93 * w + 0.17))
        b.box((x1 - 0.42, x1 - 0.30), (min(y), max(y)), (belt + 0.02, belt + 0.14), PAINT)


def car_model(
    size: tuple[float, float, float],
    *,
    hood: float,
    boot: float,
    belt: float,
    rake: tuple[float, float],
    wheel: float,
    pillars: int = 1,
) -> Model:
    """Build a car; ``hood`` and ``boot``: lengths ahead of and behind the cabin."""
    length, width, height = size
    b = ModelBuilder()
    half, w, low = length / 2, width / 2, 0.22
    front, rear = half - 0.80 * wheel - 0.56, -half + 0.80 * wheel + 0.50
    nose = belt - 0.17
    b.loft(
        [
            ring(-half, low + 0.16, 0.52, belt - 0.14, (0.74 * w, 0.80 * w, 0.70 * w)),
            # shoulders slope: flat ones would be seen edge-on, from a camera as high as they are
            ring(-half + 0.20, low, belt - 0.13, belt - 0.02, (0.91 * w, 0.985 * w, 0.87 * w)),
            ring(half - hood, low, belt - 0.11, belt, (0.92 * w, w, 0.89 * w)),
            ring(half - 0.34, low, nose - 0.10, nose + 0.05, (0.90 * w, 0.975 * w, 0.82 * w)),
            ring(half, low + 0.10, 0.50, nose - 0.12, (0.66 * w, 0.74 * w, 0.62 * w)),
        ],
        PAINT,
    )
    for x in (front, rear):
        b.paint(wheel_arch(x, 0.97 * w, wheel, low), DARK, mirror=True)
    b.paint(
        [
            (rear, 0.93 * w, low),
            (front, 0.93 * w, low),
            (front, 0.95 * w, low + 0.09),
            (rear, 0.95 * w, low + 0.09),
        ],
        BLACK,
        mirror=True,
    )
    cabin = (-half + boot, half - hood)
    middle = 0.5 * (cabin[0] + cabin[1]) - 0.05
    paint_sides(b, (rear + 0.30, middle, cabin[1] - 0.10), w, low, belt)
    _ends(b, half, w, {"lamp": nose - 0.10, "tail": belt - 0.13})
    _cabin(b, cabin, rake, w, belt, height, pillars)
    b.wheel(front, wheel, 0.97 * w)
    b.wheel(rear, wheel, 0.97 * w)
    return b.build(*size)


def car_door_model(size: tuple[float, float, float]) -> Model:
    """Build an open car door; its hinge is at its front, its window above the belt line."""
    length, width, height = size
    b = ModelBuilder()
    half, thick = 0.5 * length, 0.5 * width
    b.box((-half, half), (-thick, thick), (0.30, 0.88), PAINT)
    b.loft([[(-half + 0.03, y, 0.88), (half - 0.02, y, 0.88), (half - 0.32, y, height), (-half + 0.05, y, height)]
            for y in (-0.3 * thick, 0.3 * thick)], GLASS)  # fmt: skip
    return b.build(*size)
