"""Models of vehicles and street furniture: convex bodies with painted faces, and the registries that hold them.

A model added with ``register_vehicle`` or ``register_prop`` is drawn by the same kernels as those that ship. Registries live
in a process: workers get a model by importing the module that registers it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pedcross_env.camera.kernels.scene import REACH, REACH_M
from pedcross_env.config import require
from pedcross_env.errors import unknown_name
from pedcross_env.scenario.scenario import VEHICLE_MODELS
from pedcross_env.scenario.sizes import VEHICLE_SIZES, Size

__all__ = [
    "DARK", "GLASS", "HEADLIGHT", "PAINT", "PLATE", "RIM", "TAIL", "TRIM", "TYRE", "Face", "Model", "ModelBuilder", "Point",
    "add_material", "material_table", "model_index", "plane_of", "register_prop_model", "register_vehicle", "registered",
    "registered_models", "ring",
]  # fmt: skip

Point = tuple[float, float, float]
Face = tuple[tuple[int, ...], int, int]
"""Corners, material, and 0 if it bounds its part, 1 if it is painted on it, 2 if painted and seen near by only."""
CORNERS_AT_MOST, FACES_AT_MOST = 20, 96  # of a face, and of a part: what the kernels have room for
FLAT_M = 1e-9  # what rounding leaves of corners in one plane
PAINTED, FINE = 1, 2  # face details: always there; only near by

# albedo r, g, b, gloss, emission kind (0 none, 1 headlight, 2 tail and brake light)
_MATERIALS: list[tuple[float, float, float, float, float]] = [
    (0.00, 0.00, 0.00, 1.0, 0),  # 0 paint: colour from the actor's seed
    (0.008, 0.010, 0.011, 0.95, 0),  # 1 glass
    (0.020, 0.020, 0.022, 0.15, 0),  # 2 tyre
    (0.21, 0.215, 0.22, 0.6, 0),  # 3 rim
    (0.030, 0.030, 0.033, 0.4, 0),  # 4 trim, grille
    (0.45, 0.46, 0.48, 1.5, 1),  # 5 headlight
    (0.25, 0.012, 0.012, 1.0, 2),  # 6 tail light
    (0.55, 0.55, 0.52, 0.3, 0),  # 7 number plate
    (0.010, 0.010, 0.010, 0.0, 0),  # 8 wheel arch, underside
]
PAINT, GLASS, TYRE, RIM, TRIM, HEADLIGHT, TAIL, PLATE, DARK = range(9)


def add_material(red: float, green: float, blue: float, gloss: float = 0.1) -> int:
    """Add a surface and return its number.

    Args:
        red: Albedo, linear, 0 to 1.
        green: As red.
        blue: As red.
        gloss: Of its reflection: 0 matt, 1 like car paint.
    """
    for name, value in (("red", red), ("green", green), ("blue", blue)):
        require(0 <= value <= 1, f"add_material {name}", value, "an albedo, 0 to 1")
    require(0 <= gloss <= 2, "add_material gloss", gloss, "0 to 2")
    surface = (red, green, blue, gloss, 0.0)
    if surface not in _MATERIALS:
        _MATERIALS.append(surface)
    return _MATERIALS.index(surface)


def material_table() -> np.ndarray:
    """Return (M, 5) albedo r, g, b, gloss, emission kind."""
    return np.array(_MATERIALS)


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """A body of convex parts, made by ``ModelBuilder.build``; each is only equal to itself.

    Attributes:
        size: Length, width, height it is modelled at; actors of other sizes scale it.
        points: Corners in metres: x ahead, y left, z up, the origin on the ground under its middle.
        parts: For each convex part its faces.
    """

    size: Size
    points: tuple[Point, ...]
    parts: tuple[tuple[Face, ...], ...]


class ModelBuilder:
    """Collects a model's points, convex parts and what is painted on them; faces are turned outwards by themselves."""

    def __init__(self) -> None:
        self._points: list[Point] = []
        self._parts: list[list[tuple[list[int], int, int]]] = []
        self._middles: list[np.ndarray] = []

    def _outwards(self, corners: list[int], middle: np.ndarray) -> list[int]:
        points = [self._points[i] for i in corners]
        at = [sum(values) / len(points) for values in zip(*points, strict=True)]
        outwards = sum(n * (a - m) for n, a, m in zip(_normal(points), at, middle.tolist(), strict=True))
        return corners if outwards >= 0 else corners[::-1]

    def _flat(self, corners: list[int], middle: np.ndarray) -> list[list[int]]:
        """Split a face into triangles unless it is flat, in the way that bulges outwards.

        Seen nearly edge-on, a part of a twisted face is turned towards the camera and another away from it: that would be drawn
        with less than no coverage.
        """
        face = self._outwards(corners, middle)
        if len(face) < 4 or _bulge([self._points[i] for i in face]) <= FLAT_M:
            return [face]
        fans = []
        for turn in range(len(face)):
            first, *rest = face[turn:] + face[:turn]
            fans.append([[first, p, q] for p, q in pairwise(rest)])
        return min(fans, key=lambda fan: self._rise(fan, face))

    def _rise(self, fan: list[list[int]], face: list[int]) -> float:
        """How far corners of a face rise above the triangles it is split into: 0 where they are convex."""
        points = np.array([self._points[i] for i in face])
        planes = [plane_of([self._points[i] for i in triangle]) for triangle in fan]
        return max(float((points @ plane[:3] - plane[3]).max()) for plane in planes)

    def loft(self, rings: Sequence[Sequence[Point]], material: int, caps: int | None = None) -> None:
        """Add a convex part between rings of equally many corners, each closed by a cap at either end.

        Faces that are not flat become triangles.

        Args:
            rings: Two or more, in order along the part.
            material: Of the faces between the rings.
            caps: Of the first and last ring, if another.
        """
        n = len(rings[0])
        require(len(rings) >= 2 and all(len(r) == n for r in rings), "loft rings", [len(r) for r in rings],
                "two or more rings of equally many corners")  # fmt: skip
        base = len(self._points)
        for ring in rings:
            self._points += [(float(x), float(y), float(z)) for x, y, z in ring]
        middle = np.mean(self._points[base:], axis=0)
        ends = material if caps is None else caps
        faces = [(list(range(base, base + n)), ends, 0)]
        faces.append((list(range(base + (len(rings) - 1) * n, base + len(rings) * n)), ends, 0))
        for k in range(len(rings) - 1):
            a, b = base + k * n, base + (k + 1) * n
            faces += [([a + i, a + (i + 1) % n, b + (i + 1) % n, b + i], material, 0) for i in range(n)]
        self._parts.append([(flat, m, d) for f, m, d in faces for flat in self._flat(f, middle)])
        self._middles.append(middle)

    def box(
        self, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], material: int
    ) -> None:
        """Add a box between the given limits."""
        self.loft([[(x[0], a, b) for a, b in ((y[0], z[0]), (y[1], z[0]), (y[1], z[1]), (y[0], z[1]))],
                   [(x[1], a, b) for a, b in ((y[0], z[0]), (y[1], z[0]), (y[1], z[1]), (y[0], z[1]))]], material)  # fmt: skip

    def pole(
        self, x: float, y: float, z: tuple[float, float], radius: float, material: int, sides: int = 6
    ) -> None:
        """Add an upright prism."""
        turn = [2 * np.pi * k / sides for k in range(sides)]
        self.loft([[(x + radius * np.cos(t), y + radius * np.sin(t), h) for t in turn] for h in z], material)

    def paint(
        self, corners: Sequence[Point], material: int, *, mirror: bool = False, fine: bool = False
    ) -> None:
        """Paint a flat polygon on the last part.

        Args:
            corners: In order round it.
            material: Its surface.
            mirror: Paint it on the other side (-y) too.
            fine: Leave it out where its lines would be much thinner than a pixel.
        """
        require(bool(self._parts), "paint", "nothing to paint on", "called after loft, box, pole or wheel")
        shapes = [list(corners)] + ([[(x, -y, z) for x, y, z in corners]] if mirror else [])
        for shape in shapes:
            base = len(self._points)
            self._points += [(float(x), float(y), float(z)) for x, y, z in shape]
            face = self._outwards(list(range(base, base + len(shape))), self._middles[-1])
            self._parts[-1].append((face, material, FINE if fine else PAINTED))

    def wheel(self, x: float, radius: float, half_width: float, thick: float = 0.22) -> None:
        """Add a wheel on either side, its outer face at +-``half_width``."""
        turn = np.arange(12) * np.pi / 6
        for side in (-1.0, 1.0):
            inner, outer = side * (half_width - thick), side * half_width
            self.loft(
                [
                    [(x + radius * np.cos(a), y, radius + radius * np.sin(a)) for a in turn]
                    for y in (inner, outer)
                ],
                TYRE,
            )
            self.disc(x, outer, radius, 0.66 * radius, RIM)
            for k in range(5):
                a = 2 * np.pi * k / 5 + 0.3
                spoke = [(x + s * radius * np.cos(a + t), outer, radius + s * radius * np.sin(a + t))
                         for s, t in ((0.22, 0.0), (0.56, -0.38), (0.56, 0.38))]  # fmt: skip
                self.paint(spoke, DARK, fine=True)

    def disc(self, x: float, y: float, z: float, radius: float, material: int) -> None:
        """Paint a disc that faces sideways."""
        turn = np.arange(12) * np.pi / 6
        self.paint([(x + radius * np.cos(a), y, z + radius * np.sin(a)) for a in turn], material)

    def build(self, length_m: float, width_m: float, height_m: float) -> Model:
        """Return the model.

        Args:
            length_m: Along x, that of the box which is seen as the actor's size.
            width_m: Along y.
            height_m: Along z.

        Raises:
            ConfigError: If it has no part, more faces than the kernels have room for, or reaches far out of its size.
        """
        require(bool(self._parts), "model", "no parts", "built of one part or more")
        for faces in self._parts:
            require(
                len(faces) <= FACES_AT_MOST,
                "faces of a part",
                len(faces),
                f"at most {FACES_AT_MOST}: split it",
            )
            corners = max(len(face[0]) for face in faces)
            require(corners <= CORNERS_AT_MOST, "corners of a face", corners, f"at most {CORNERS_AT_MOST}")
        reach = max(math.dist(point, (0.0, 0.0, 0.5 * height_m)) for point in self._points)
        most = REACH * math.hypot(length_m, width_m, height_m) + REACH_M
        require(reach <= most, "model's reach from the middle of its size (m)", reach,
                f"at most {most:.2f} for {length_m} x {width_m} x {height_m} m: beyond it nothing is drawn; give it its true size")  # fmt: skip
        parts = tuple(tuple((tuple(f), m, d) for f, m, d in part) for part in self._parts)
        return Model(Size(length_m, width_m, height_m), tuple(self._points), parts)


_VEHICLES: dict[str, Model] = {}
_PROPS: dict[str, Model] = {}


def _add(kind: str, registry: dict[str, Model], name: str, model: Model) -> None:
    require(bool(name) and name not in registry, f"{kind} name", name, f"new; taken: {', '.join(registry)}")
    registry[name] = model


def register_vehicle(name: str, model: Model) -> None:
    """Add a vehicle model, for ``VehicleSpec(model=name)``.

    Args:
        name: A new name.
        model: Its body; its size is also its footprint in contact tests.

    Raises:
        ConfigError: If the name is taken.
    """
    _add("vehicle model", _VEHICLES, name, model)
    if name not in VEHICLE_MODELS:
        VEHICLE_MODELS.append(name)
        VEHICLE_SIZES[name] = model.size


def register_prop_model(name: str, model: Model) -> None:
    """Add the body of a piece of street furniture; see camera.props.register_prop for where it stands."""
    _add("prop", _PROPS, name, model)


def registered() -> tuple[str, ...]:
    """Return the names of all models: vehicles, then props."""
    return (*VEHICLE_MODELS, *_PROPS)


def registered_models() -> tuple[Model, ...]:
    """Return all models in the order of ``registered``."""
    return (*(_VEHICLES[name] for name in VEHICLE_MODELS), *_PROPS.values())


def model_index(name: str) -> tuple[int, Size]:
    """Return a model's number in the order of ``registered`` and its size.

    Raises:
        ConfigError: If there is no such vehicle or prop.
    """
    names = registered()
    if name not in names:
        raise unknown_name("model", name, names)
    return names.index(name), (_VEHICLES.get(name) or _PROPS[name]).size


def _normal(corners: Sequence[Point]) -> Point:
    """Return Newell's normal of a face, as long as twice its area; in plain Python: faces are small and there are thousands."""
    terms = [
        (y * w - z * v, z * u - x * w, x * v - y * u)
        for (x, y, z), (u, v, w) in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    x, y, z = (sum(values) for values in zip(*terms, strict=True))
    return x, y, z


def plane_of(corners: Sequence[Point]) -> np.ndarray:
    """Return Newell's normal of a face and its product with the first corner."""
    normal = np.array(_normal(corners))
    return np.array([*normal, normal @ np.array(corners[0])])


def _bulge(corners: Sequence[Point]) -> float:
    """How far a face's corners lie off its plane, metres."""
    normal = np.array(_normal(corners))
    heights = np.array(corners) @ normal
    return float((heights.max() - heights.min()) / max(np.sqrt(normal @ normal), FLAT_M))


def ring(x: float, low: float, mid: float, top: float, widths: tuple[float, float, float]) -> list[Point]:
    """Cross-section of a body: half widths at its lower edge, its widest line and its upper edge."""
    a, b, c = widths
    return [(x, -a, low), (x, -b, mid), (x, -c, top), (x, c, top), (x, b, mid), (x, a, low)]
