"""Vehicles and pedestrians as tables of primitives in local coordinates; the kernels know none of their names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

__all__ = ["BODY_CAPSULES", "MATERIALS", "PAINTS", "VehicleTable", "vehicle_table"]

# material: albedo r, g, b, gloss, emission kind (0 none, 1 headlight, 2 tail and brake light)
MATERIALS = np.array(
    [
        [0.00, 0.00, 0.00, 1.0, 0],  # 0 paint: colour from the actor's seed
        [0.015, 0.017, 0.02, 1.6, 0],  # 1 glass
        [0.020, 0.020, 0.022, 0.15, 0],  # 2 tyre
        [0.30, 0.31, 0.32, 0.8, 0],  # 3 rim
        [0.035, 0.035, 0.038, 0.4, 0],  # 4 trim, grille
        [0.45, 0.46, 0.48, 1.5, 1],  # 5 headlight
        [0.25, 0.012, 0.012, 1.0, 2],  # 6 tail light
        [0.55, 0.55, 0.52, 0.3, 0],  # 7 number plate
        [0.012, 0.012, 0.012, 0.0, 0],  # 8 wheel arch, underside
    ]
)
PAINT, GLASS, TYRE, RIM, TRIM, HEADLIGHT, TAIL, PLATE, DARK = range(9)

PAINTS = np.array(
    [
        [0.62, 0.62, 0.60], [0.30, 0.31, 0.33], [0.06, 0.06, 0.065], [0.015, 0.016, 0.018], [0.03, 0.07, 0.22],
        [0.36, 0.02, 0.02], [0.10, 0.16, 0.24], [0.42, 0.40, 0.36], [0.03, 0.12, 0.07], [0.50, 0.24, 0.03],
        [0.14, 0.14, 0.15], [0.20, 0.05, 0.06],
    ]
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class VehicleTable:
    """All vehicle models, concatenated.

    Attributes:
        points: (V, 3) corners in metres at the nominal size, origin on the ground under the centre.
        model_points: (M + 1,) where a model's points start.
        model_parts: (M + 1,) where a model's polyhedra start.
        part_faces: (P + 1,) where a polyhedron's faces start.
        face_start: (F + 1,) where a face's corners start.
        face_corners: (K,) indices relative to the model's first point.
        face_material: (F,).
        face_detail: (F,) 1 where the face is painted on its polyhedron.
        nominal: (M, 3) length, width, height.
    """

    points: np.ndarray
    model_points: np.ndarray
    model_parts: np.ndarray
    part_faces: np.ndarray
    face_start: np.ndarray
    face_corners: np.ndarray
    face_material: np.ndarray
    face_detail: np.ndarray
    nominal: np.ndarray


class _Builder:
    """Collects one vehicle's points, polyhedra and painted details."""

    def __init__(self) -> None:
        self.points: list[tuple[float, float, float]] = []
        self.parts: list[list[tuple[list[int], int, int]]] = []

    def prism(
        self, profile: list[tuple[float, float, float]], material: int, side: int | None = None
    ) -> None:
        """Extrude a side profile [(x, z, half width)], counter-clockwise seen from the right (x ahead, z up)."""
        base, n = len(self.points), len(profile)
        self.points += [(x, -w, z) for x, z, w in profile] + [(x, w, z) for x, z, w in profile]
        faces = [
            (list(range(base, base + n)), material if side is None else side, 0),
            (list(range(base + 2 * n - 1, base + n - 1, -1)), material if side is None else side, 0),
        ]
        for i in range(n):
            j = (i + 1) % n
            faces.append(([base + j, base + i, base + n + i, base + n + j], material, 0))
        self.parts.append(faces)

    def paint(self, corners: list[tuple[float, float, float]], material: int, mirror: bool = False) -> None:
        """Paint a polygon on the last polyhedron, and its mirror image on the other side."""
        shapes = [corners]
        if mirror:
            shapes.append([(x, -y, z) for x, y, z in reversed(corners)])
        for shape in shapes:
            base = len(self.points)
            self.points += shape
            self.parts[-1].append((list(range(base, base + len(shape))), material, 1))

    def wheel(self, x: float, radius: float, half_width: float, thick: float = 0.22) -> None:
        """Add a wheel on either side."""
        angles = np.arange(12) * np.pi / 6
        for side in (-1, 1):
            base = len(self.points)
            outer = side * half_width
            for y in (outer if side < 0 else outer - thick, outer + thick if side < 0 else outer):
                self.points += [(x + radius * np.cos(a), y, radius + radius * np.sin(a)) for a in angles]
            faces = [
                (list(range(base, base + 12)), TYRE, 0),
                (list(range(base + 23, base + 11, -1)), TYRE, 0),
            ]
            faces += [
                ([base + (i + 1) % 12, base + i, base + 12 + i, base + 12 + (i + 1) % 12], TYRE, 0)
                for i in range(12)
            ]
            self.parts.append(faces)
            disc = [
                (x + 0.62 * radius * np.cos(a), outer, radius + 0.62 * radius * np.sin(a)) for a in angles
            ]
            self.paint(disc if side < 0 else disc[::-1], RIM)


def _car(
    length: float,
    width: float,
    height: float,
    hood: float,
    boot: float,
    belt: float,
    rake: tuple[float, float],
    wheel: float,
) -> _Builder:
    """Build a car: body, cabin with glass, wheels, lights. ``hood``/``boot``: lengths ahead of and behind the cabin."""
    b = _Builder()
    half, w = length / 2, width / 2
    low, hood_z = 0.24, belt - 0.10
    b.prism(
        [(-half + 0.12, low, w * 0.96), (half - 0.14, low, w * 0.94), (half, low + 0.16, w * 0.86), (half - 0.03, hood_z - 0.14, w * 0.86),
         (half - 0.22, hood_z, w * 0.90), (half - hood, belt, w * 0.97), (-half + boot, belt, w * 0.97), (-half + 0.06, belt - 0.05, w * 0.92),
         (-half, low + 0.2, w * 0.9)],
        PAINT,
    )  # fmt: skip
    front, rear = half - 0.79 * wheel - 0.55, -half + 0.79 * wheel + 0.52
    for x in (front, rear):  # wheel arches
        angles = np.linspace(0, np.pi, 8)
        arch = [
            (x + 1.18 * wheel * np.cos(a), -w * 0.955, max(low, wheel + 1.18 * wheel * np.sin(a)))
            for a in angles
        ]
        arch = [(x + 1.18 * wheel, -w * 0.955, low), *arch, (x - 1.18 * wheel, -w * 0.955, low)]
        b.paint(arch, DARK, mirror=True)
    b.paint(
        [
            (-half + 0.3, -w * 0.962, low),
            (half - 0.3, -w * 0.962, low),
            (half - 0.3, -w * 0.962, low + 0.07),
            (-half + 0.3, -w * 0.962, low + 0.07),
        ],
        TRIM,
        mirror=True,
    )
    fx, bx = half + 0.001, -half - 0.001
    b.paint(
        [
            (fx, -w * 0.52, 0.56),
            (fx, w * 0.52, 0.56),
            (fx - 0.02, w * 0.52, 0.68),
            (fx - 0.02, -w * 0.52, 0.68),
        ],
        TRIM,
    )
    b.paint([(fx, -w * 0.66, 0.28), (fx, w * 0.66, 0.28), (fx, w * 0.6, 0.42), (fx, -w * 0.6, 0.42)], TRIM)
    b.paint([(fx, -0.26, 0.44), (fx, 0.26, 0.44), (fx, 0.26, 0.55), (fx, -0.26, 0.55)], PLATE)
    b.paint(
        [
            (fx - 0.01, w * 0.56, 0.58),
            (fx - 0.02, w * 0.84, 0.60),
            (fx - 0.03, w * 0.84, 0.73),
            (fx - 0.03, w * 0.56, 0.70),
        ],
        HEADLIGHT,
        mirror=True,
    )
    b.paint([(bx, -0.26, 0.50), (bx, -0.26, 0.62), (bx, 0.26, 0.62), (bx, 0.26, 0.50)], PLATE)
    b.paint(
        [
            (bx + 0.03, w * 0.56, belt - 0.28),
            (bx + 0.05, w * 0.56, belt - 0.10),
            (bx + 0.05, w * 0.88, belt - 0.10),
            (bx + 0.03, w * 0.88, belt - 0.28),
        ],
        TAIL,
        mirror=True,
    )
    b.paint([(bx, -w * 0.85, 0.30), (bx, -w * 0.85, 0.42), (bx, w * 0.85, 0.42), (bx, w * 0.85, 0.30)], TRIM)
    x0, x1 = -half + boot, half - hood  # cabin at the belt line
    t0, t1, roof = x0 + rake[0], x1 - rake[1], w * 0.74
    b.prism(
        [(x0, belt - 0.02, w * 0.95), (x1, belt - 0.02, w * 0.95), (t1, height - 0.03, roof), (0.5 * (t0 + t1), height, roof),
         (t0, height - 0.05, roof)],
        PAINT,
    )  # fmt: skip

    def at(s: float, t: float, side: float) -> tuple[float, float, float]:
        """Point on the cabin's side: s along from the rear, t up."""
        a0, a1 = x0 + t * (t0 - x0), x1 + t * (t1 - x1)
        return (
            a0 + s * (a1 - a0),
            side * (w * 0.95 + t * (roof - w * 0.95)),
            belt - 0.02 + t * (height - 0.05 - belt + 0.02),
        )

    for s0, s1 in ((0.08, 0.48), (0.52, 0.93)):
        b.paint([at(s0, 0.1, -1), at(s1, 0.1, -1), at(s1, 0.84, -1), at(s0, 0.84, -1)], GLASS, mirror=True)
    for s, flip in ((1.0, False), (0.0, True)):
        pane = [at(s, 0.08, -1), at(s, 0.08, 1), at(s, 0.9, 1), at(s, 0.9, -1)]
        pane = [(x, y * 0.9, z) for x, y, z in pane]
        b.paint(pane[::-1] if flip else pane, GLASS)
    b.wheel(front, wheel, w * 0.97)
    b.wheel(rear, wheel, w * 0.97)
    return b


def _box_vehicle(
    length: float, width: float, height: float, wheel: float, panes: int, nose: float
) -> _Builder:
    """Build a van or a bus: one body with glass, wheels and lights."""
    b = _Builder()
    half, w, low = length / 2, width / 2, 0.32
    belt = 0.58 * height if panes < 4 else 0.42 * height
    b.prism(
        [(-half, low, w), (half, low, w), (half, belt * (0.75 if nose > 0.3 else 1.0), w), (half - nose * 0.5, belt, w),
         (half - nose, height - 0.1, w * 0.93), (half - nose - 0.25, height, w * 0.9), (-half + 0.1, height, w * 0.9), (-half, height - 0.1, w * 0.93)],
        PAINT,
    )  # fmt: skip
    front, rear = half - (1.0 if panes < 4 else 2.4), -half + (1.0 if panes < 4 else 2.6)
    for x in (front, rear):
        angles = np.linspace(0, np.pi, 8)
        arch = [(x + 1.18 * wheel, -w - 0.002, low)] + [
            (x + 1.18 * wheel * np.cos(a), -w - 0.002, max(low, wheel * (1 + 1.18 * np.sin(a))))
            for a in angles
        ]
        b.paint([*arch, (x - 1.18 * wheel, -w - 0.002, low)], DARK, mirror=True)
    top = height - 0.42
    start = half - nose - 1.1 if panes < 4 else -half + 0.4
    step = 1.0 if panes < 4 else (length - nose - 0.9) / panes
    for k in range(panes):
        a = start - 1.15 * k if panes < 4 else start + k * step
        b.paint(
            [
                (a, -w * 1.002, belt),
                (a + step * 0.93, -w * 1.002, belt),
                (a + step * 0.93, -w * 0.955, top),
                (a, -w * 0.955, top),
            ],
            GLASS,
            mirror=True,
        )
    f0, f1 = half - nose * 0.55, half - nose * 0.97
    b.paint(
        [
            (f0 + 0.01, -w * 0.9, belt + 0.06),
            (f0 + 0.01, w * 0.9, belt + 0.06),
            (f1 + 0.01, w * 0.84, height - 0.25),
            (f1 + 0.01, -w * 0.84, height - 0.25),
        ],
        GLASS,
    )
    r = -half - 0.002
    b.paint(
        [(r, -w * 0.8, belt + 0.1), (r, -w * 0.76, top), (r, w * 0.76, top), (r, w * 0.8, belt + 0.1)], GLASS
    )
    b.paint(
        [(r, w * 0.72, 0.75), (r, w * 0.72, 1.25), (r, w * 0.95, 1.25), (r, w * 0.95, 0.75)],
        TAIL,
        mirror=True,
    )
    b.paint([(r, -0.26, 0.6), (r, -0.26, 0.72), (r, 0.26, 0.72), (r, 0.26, 0.6)], PLATE)
    fx = half + 0.002
    b.paint(
        [(fx, w * 0.58, 0.68), (fx, w * 0.92, 0.68), (fx, w * 0.92, 0.86), (fx, w * 0.58, 0.86)],
        HEADLIGHT,
        mirror=True,
    )
    b.paint([(fx, -w * 0.5, 0.55), (fx, w * 0.5, 0.55), (fx, w * 0.5, 0.84), (fx, -w * 0.5, 0.84)], TRIM)
    b.wheel(front, wheel, w * 0.99, 0.26)
    b.wheel(rear, wheel, w * 0.99, 0.26)
    return b


@lru_cache(maxsize=1)
def vehicle_table() -> VehicleTable:
    """Build the table of all vehicle models, in the order of ``VEHICLE_MODELS``."""
    nominal = [(4.1, 1.75, 1.48), (4.7, 1.82, 1.45), (4.6, 1.88, 1.68), (5.2, 2.0, 2.2), (11.5, 2.5, 3.1)]
    models = [
        _car(*nominal[0], hood=1.05, boot=0.04, belt=0.92, rake=(0.45, 0.75), wheel=0.31),
        _car(*nominal[1], hood=1.25, boot=0.75, belt=0.92, rake=(0.70, 0.85), wheel=0.32),
        _car(*nominal[2], hood=1.15, boot=0.04, belt=1.06, rake=(0.40, 0.65), wheel=0.36),
        _box_vehicle(*nominal[3], wheel=0.34, panes=2, nose=0.9),
        _box_vehicle(*nominal[4], wheel=0.48, panes=8, nose=0.25),
    ]
    points: list[tuple[float, float, float]] = []
    model_points, model_parts, part_faces, face_start = [0], [0], [0], [0]
    corners: list[int] = []
    material: list[int] = []
    detail: list[int] = []
    for model in models:
        points += model.points
        for part in model.parts:
            for face, surface, painted in part:
                corners += face
                face_start.append(len(corners))
                material.append(surface)
                detail.append(painted)
            part_faces.append(len(material))
        model_points.append(len(points))
        model_parts.append(len(part_faces) - 1)
    as_int = lambda values: np.array(values, np.int64)  # noqa: E731
    return VehicleTable(
        np.array(points), as_int(model_points), as_int(model_parts), as_int(part_faces), as_int(face_start),
        as_int(corners), as_int(material), as_int(detail), np.array(nominal),
    )  # fmt: skip


# joints of the posed body (kernels.pose): indices into its array
(PELVIS, CHEST, NECK, HEAD, CROWN, L_SHOULDER, L_ELBOW, L_WRIST, L_HIP, L_KNEE, L_ANKLE, L_TOE, R_SHOULDER, R_ELBOW,
 R_WRIST, R_HIP, R_KNEE, R_ANKLE, R_TOE, L_BELLY, R_BELLY, L_CHEST, R_CHEST, NAPE, L_HAND, R_HAND, BAG_LOW, BAG_HIGH) = range(28)  # fmt: skip

# slots of clothing: 0 skin, 1 hair, 2 top, 3 trousers, 4 shoes, 5 lower sleeve, 6 coat tail (only with a coat), 7 bag (some)
# capsule: joint, joint, radius, radius (shares of the height), slot
BODY_CAPSULES = np.array(
    [
        [L_BELLY, L_CHEST, 0.058, 0.066, 2], [R_BELLY, R_CHEST, 0.058, 0.066, 2], [PELVIS, CHEST, 0.066, 0.068, 2],
        [L_HIP, R_HIP, 0.056, 0.056, 3], [L_SHOULDER, R_SHOULDER, 0.038, 0.038, 2], [CHEST, NECK, 0.050, 0.028, 2],
        [NECK, HEAD, 0.029, 0.030, 0], [HEAD, CROWN, 0.040, 0.044, 0], [NAPE, CROWN, 0.040, 0.0485, 1],
        [L_SHOULDER, L_ELBOW, 0.030, 0.025, 2], [R_SHOULDER, R_ELBOW, 0.030, 0.025, 2],
        [L_ELBOW, L_WRIST, 0.0235, 0.018, 5], [R_ELBOW, R_WRIST, 0.0235, 0.018, 5],
        [L_WRIST, L_HAND, 0.017, 0.014, 0], [R_WRIST, R_HAND, 0.017, 0.014, 0],
        [L_HIP, L_KNEE, 0.050, 0.034, 3], [R_HIP, R_KNEE, 0.050, 0.034, 3],
        [L_KNEE, L_ANKLE, 0.032, 0.023, 3], [R_KNEE, R_ANKLE, 0.032, 0.023, 3],
        [L_ANKLE, L_TOE, 0.022, 0.017, 4], [R_ANKLE, R_TOE, 0.022, 0.017, 4],
        [L_HIP, L_KNEE, 0.060, 0.036, 6], [R_HIP, R_KNEE, 0.060, 0.036, 6], [BAG_LOW, BAG_HIGH, 0.055, 0.045, 7],
    ]
)  # fmt: skip
SKINS = np.array(
    [[0.50, 0.30, 0.20], [0.42, 0.24, 0.15], [0.30, 0.16, 0.09], [0.16, 0.08, 0.045], [0.09, 0.045, 0.025]]
)
HAIRS = np.array(
    [
        [0.012, 0.010, 0.009],
        [0.04, 0.022, 0.012],
        [0.10, 0.055, 0.025],
        [0.30, 0.20, 0.09],
        [0.32, 0.31, 0.30],
    ]
)
TOPS = np.array(
    [[0.03, 0.03, 0.035], [0.08, 0.085, 0.10], [0.02, 0.05, 0.14], [0.35, 0.03, 0.03], [0.55, 0.53, 0.50], [0.50, 0.16, 0.03],
     [0.04, 0.16, 0.08], [0.52, 0.40, 0.05], [0.14, 0.10, 0.07], [0.10, 0.20, 0.35]]
)  # fmt: skip
TROUSERS = np.array(
    [
        [0.02, 0.03, 0.07],
        [0.015, 0.015, 0.017],
        [0.05, 0.08, 0.17],
        [0.22, 0.17, 0.11],
        [0.07, 0.07, 0.075],
        [0.06, 0.065, 0.03],
    ]
)
SHOES = np.array([[0.02, 0.018, 0.016], [0.5, 0.5, 0.48], [0.09, 0.045, 0.02], [0.25, 0.03, 0.03]])


def clothing(seed: int, model: int) -> np.ndarray:
    """Draw a pedestrian's colours from its seed.

    Returns:
        (8, 4): albedo r, g, b and whether the slot is worn, for each slot of ``BODY_CAPSULES``.
    """
    rng = np.random.default_rng([seed & 0xFFFFFFFF, model, 77])
    skin = SKINS[rng.integers(len(SKINS))]
    hair = HAIRS[rng.integers(len(HAIRS) - 1)] if model != 2 else HAIRS[-1]
    tone = rng.uniform(0.8, 1.2)
    top, trousers, shoes = (t[rng.integers(len(t))] for t in (TOPS, TROUSERS, SHOES))
    coat, bag, short = rng.random() < (0.25 if model != 1 else 0.1), rng.random() < 0.3, rng.random() < 0.25
    bag_colour = TOPS[rng.integers(len(TOPS))] * 0.8
    slots = np.zeros((8, 4))
    for k, colour in enumerate(
        (
            skin,
            hair,
            top * tone,
            trousers * tone,
            shoes,
            skin if short and not coat else top * tone,
            top * tone,
            bag_colour,
        )
    ):
        slots[k, :3], slots[k, 3] = np.clip(colour, 0.008, 0.7), 1.0
    slots[6, 3], slots[7, 3] = float(coat), float(bag)
    return slots
