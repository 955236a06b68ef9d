"""The vehicles that ship, registered on import; two-wheelers are modelled in camera.two_wheelers."""

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
    add_material,
    register_vehicle,
    ring,
)  # fmt: skip
from pedcross_env.camera.two_wheelers import BLACK, STEEL, bicycle_model, motorcycle_model
from pedcross_env.scenario.sizes import VEHICLE_SIZES

__all__ = ["PAINTS"]

PAINTS = np.array(
    [
        [0.62, 0.62, 0.60], [0.66, 0.66, 0.65], [0.30, 0.31, 0.33], [0.36, 0.37, 0.38], [0.13, 0.135, 0.14], [0.07, 0.07, 0.075],
        [0.018, 0.019, 0.021], [0.022, 0.024, 0.028], [0.03, 0.07, 0.22], [0.05, 0.09, 0.15], [0.10, 0.16, 0.24], [0.36, 0.02, 0.02],
        [0.20, 0.03, 0.04], [0.42, 0.40, 0.36], [0.03, 0.10, 0.07], [0.50, 0.30, 0.03],
    ]
)  # fmt: skip
"""Colours of paint, about as often as they are seen: white, grey and black first."""

CANVAS = add_material(0.50, 0.50, 0.49, 0.1)


def _arch(x: float, y: float, radius: float, low: float) -> list[Point]:
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


def _sides(b: ModelBuilder, doors: tuple[float, ...], w: float, low: float, belt: float) -> None:
    """Paint joints of doors, handles and a sill on both sides of a body."""
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
    sill = (
        0.85 * w
    )  # well within the body's upper edge: a narrower shoulder than a pixel would be seen here and hidden there
    z1 = belt + 0.84 * rise

    def ring(a: float, c: float, y: float, z: float) -> list[Point]:
        return [(a, -0.92 * y, z), (c, -y, z), (c, y, z), (a, 0.92 * y, z)]  # narrower at the rear

    b.loft([ring(x0, x1, sill, belt - 0.03), ring(t0, t1, upper, z1), ring(r0, r1, roof, height)], PAINT)

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


def _car(
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
        b.paint(_arch(x, 0.97 * w, wheel, low), DARK, mirror=True)
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
    _sides(b, (rear + 0.30, middle, cabin[1] - 0.10), w, low, belt)
    _ends(b, half, w, {"lamp": nose - 0.10, "tail": belt - 0.13})
    _cabin(b, cabin, rake, w, belt, height, pillars)
    b.wheel(front, wheel, 0.97 * w)
    b.wheel(rear, wheel, 0.97 * w)
    return b.build(*size)


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


def _van(size: tuple[float, float, float]) -> Model:
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
    b.paint(_arch(front, 0.985 * w, wheel, low), DARK, mirror=True)
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
        b.paint(_arch(x, 0.985 * w, wheel, low), DARK, mirror=True)
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
    _sides(b, (rear + 0.6, half - 2.25, half - 1.05), w, low, glass - 0.1)
    _square_rear(b, half, w)
    for side in (-1.0, 1.0):
        y = (side * w, side * (w + 0.18))
        b.box((half - 1.25, half - 1.12), (min(y), max(y)), (glass + 0.02, glass + 0.30), BLACK)
    b.wheel(front, wheel, 0.97 * w, 0.24)
    b.wheel(rear, wheel, 0.97 * w, 0.24)
    return b.build(*size)


def _bus(size: tuple[float, float, float]) -> Model:
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
        b.paint(_arch(x, 0.99 * w, wheel, low), DARK, mirror=True)
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


def _truck(size: tuple[float, float, float]) -> Model:
    """A box truck: cab, cargo box, chassis."""
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
    b.paint(_arch(half - 1.05, 0.955 * w, 0.45, 0.42), DARK, mirror=True)
    _square_front(b, half, 0.9 * w, 0.66)
    b.wheel(half - 1.05, 0.45, 0.96 * w, 0.28)
    b.wheel(-half + 1.3, 0.45, 0.98 * w, 0.45)
    return b.build(*size)


def _door(size: tuple[float, float, float]) -> Model:
    """An open car door; its hinge is at its front, its window above the belt line."""
    length, width, height = size
    b = ModelBuilder()
    half, thick = 0.5 * length, 0.5 * width
    b.box((-half, half), (-thick, thick), (0.30, 0.88), PAINT)
    b.loft([[(-half + 0.03, y, 0.88), (half - 0.02, y, 0.88), (half - 0.32, y, height), (-half + 0.05, y, height)]
            for y in (-0.3 * thick, 0.3 * thick)], GLASS)  # fmt: skip
    return b.build(*size)


register_vehicle(
    "hatchback",
    _car(VEHICLE_SIZES["hatchback"], hood=1.02, boot=0.15, belt=0.94, rake=(0.42, 0.80), wheel=0.31),
)
register_vehicle(
    "sedan", _car(VEHICLE_SIZES["sedan"], hood=1.28, boot=0.72, belt=0.93, rake=(0.72, 0.92), wheel=0.32)
)
register_vehicle(
    "suv",
    _car(VEHICLE_SIZES["suv"], hood=1.16, boot=0.15, belt=1.07, rake=(0.36, 0.72), wheel=0.36, pillars=2),
)
register_vehicle("van", _van(VEHICLE_SIZES["van"]))
register_vehicle("bus", _bus(VEHICLE_SIZES["bus"]))
register_vehicle("truck", _truck(VEHICLE_SIZES["truck"]))
register_vehicle("motorcycle", motorcycle_model(VEHICLE_SIZES["motorcycle"]))
register_vehicle("bicycle", bicycle_model(VEHICLE_SIZES["bicycle"]))
register_vehicle("cyclist", bicycle_model(VEHICLE_SIZES["cyclist"]))  # who rides it is drawn by camera.riders
register_vehicle("car_door", _door(VEHICLE_SIZES["car_door"]))
