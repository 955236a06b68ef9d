"""Street lamps: where they stand, what they look like, and their light on ground and fronts."""

from __future__ import annotations

import numpy as np

from pedcross_env.camera.kernels.lighting import lamp_candela
from pedcross_env.scenario.street import StreetSpec

__all__ = ["MAP_STEP_M", "LAMP_HEIGHT_M", "LAMP_SPACING_M", "lamp_maps", "lamp_places", "lamp_post"]

MAP_STEP_M = 0.5
LAMP_SPACING_M, LAMP_HEIGHT_M = 26.0, 7.0
STEEL = (0.16, 0.165, 0.17)


def lamp_places(street: StreetSpec) -> list[tuple[float, float, float, float]]:
    """Return x and y of every post, y of its light, and its side, staggered along both kerbs."""
    places = []
    for side in (-1, 1):
        y = side * (street.kerb_y_m + 0.45)
        start = street.start_x_m + (0.5 * LAMP_SPACING_M if side > 0 else 2.0)
        count = int(np.ceil((street.end_x_m - start) / LAMP_SPACING_M))
        places += [(start + k * LAMP_SPACING_M, y, y - side * 1.5, float(side)) for k in range(count)]
    return places


def lamp_post(x: float, y: float, head_y: float, side: float, base: float) -> list[list[float]]:
    """Return the capsules of one lamp: post, arm, head and the shining glass under it."""
    top = base + LAMP_HEIGHT_M
    parts = [
        ((x, y, base), (x, y, base + 0.9), 0.09, 0.085, 0.0),
        ((x, y, base + 0.9), (x, y, top - 0.15), 0.065, 0.05, 0.0),
        ((x, y, top - 0.15), (x, head_y, top + 0.05), 0.045, 0.04, 0.0),
        ((x, head_y + side * 0.25, top + 0.02), (x, head_y - side * 0.25, top + 0.06), 0.085, 0.07, 0.0),
        ((x, head_y + side * 0.2, top - 0.04), (x, head_y - side * 0.2, top), 0.06, 0.05, 1.0),
    ]
    return [[*a, *b, r0, r1, *STEEL, shines] for a, b, r0, r1, shines in parts]


def lamp_maps(street: StreetSpec, lamps: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Illuminance of all street lamps on the ground and on the fronts, for tint 1."""
    x = np.arange(street.start_x_m - 30.0, street.end_x_m + 60.0, MAP_STEP_M)
    y = np.arange(-street.facade_y_m - 14.0, street.facade_y_m + 14.0, MAP_STEP_M)
    z = np.arange(0.0, 12.0, MAP_STEP_M)
    candela = np.array([lamp_candela(c) for c in np.linspace(0, 1, 257)])

    def intensity(cosine: np.ndarray) -> np.ndarray:
        return np.interp(cosine, np.linspace(0, 1, 257), candela)

    ground, fronts = np.zeros((len(y), len(x))), np.zeros((2, len(z), len(x)))
    for lx, ly, lz in lamps:
        near = np.flatnonzero(np.abs(x - lx) < 40)
        dx = x[near][None, :] - lx
        r2 = dx**2 + (y[:, None] - ly) ** 2 + lz**2
        cosine = lz / np.sqrt(r2)
        ground[:, near] += intensity(cosine) * cosine / r2
        for k, side in enumerate((-1, 1)):
            dy, dz = side * street.facade_y_m - ly, lz - z[:, None]
            r2 = dx**2 + dy**2 + dz**2
            fronts[k][:, near] += intensity(np.maximum(0, dz) / np.sqrt(r2)) * abs(dy) / np.sqrt(r2) / r2
    return (
        ground.astype(np.float32),
        np.array([x[0], y[0], MAP_STEP_M]),
        fronts.astype(np.float32),
        np.array([x[0], MAP_STEP_M]),
    )
