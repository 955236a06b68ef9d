"""A street's standing things as tables: facades, trees, lamps, the ground's profiles; cached per street."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pedcross_env.camera.kernels.facade import PANEL_SIZE
from pedcross_env.camera.kernels.lighting import lamp_candela
from pedcross_env.contracts import StaticClass
from pedcross_env.scenario.street import StreetSpec

__all__ = ["CAPSULE_SIZE", "GROUND_TEXEL_M", "Scenery", "grain_integral", "scenery_of"]

CAPSULE_SIZE = 12  # ends (6), radii (2), albedo (3), 1 where it shines as a street lamp
ACROSS_TEXEL_M, ALONG_TEXEL_M, GROUND_TEXEL_M = 0.01, 0.05, 0.025
MAP_STEP_M = 0.5
LAMP_SPACING_M, LAMP_HEIGHT_M = 26.0, 7.0
WALLS = np.array(
    [[0.42, 0.38, 0.31], [0.36, 0.20, 0.15], [0.48, 0.46, 0.42], [0.30, 0.29, 0.29], [0.44, 0.33, 0.21], [0.28, 0.17, 0.12],
     [0.40, 0.36, 0.36], [0.33, 0.36, 0.37], [0.50, 0.42, 0.30]]
)  # fmt: skip
LEAVES = np.array(
    [[0.060, 0.115, 0.028], [0.075, 0.120, 0.030], [0.050, 0.095, 0.030], [0.095, 0.120, 0.032]]
)


House = tuple[int, float, float, float, float, np.ndarray]  # side, x range, front y, height, wall


@dataclass(frozen=True, slots=True)
class Scenery:
    """Static tables of one street.

    Attributes:
        panels: (P, PANEL_SIZE) facades, see kernels.facade.
        capsules: (K, CAPSULE_SIZE) world coordinates.
        groups: (G, 7) capsule range, bounding sphere (x, y, z, r), StaticClass.
        lamps: (L, 3) positions.
        ground_lamp_map: (rows over y, columns over x) lx at 1 tint, and its frame (start x, start y, step).
        front_lamp_maps: (2, rows over height, columns over x) on the right and the left fronts.
        map_frame: (start x, step) of the latter.
        along: (N, 3) running integrals along x of dashes, zebra and stop lines.
        low: (M, 8) running integrals across the road: cover, r, g, b, lines, dash, zebra, stop.
        high: (M, 8) the same beyond the kerbs.
        across_low: y of the first row of ``low`` and ``high``.
        tree_shadows: (S, 4) crown centre (x, y, z) and radius.
    """

    panels: np.ndarray
    capsules: np.ndarray
    groups: np.ndarray
    lamps: np.ndarray
    ground_lamp_map: np.ndarray
    ground_frame: np.ndarray
    front_lamp_maps: np.ndarray
    map_frame: np.ndarray
    along: np.ndarray
    low: np.ndarray
    high: np.ndarray
    across_low: float
    tree_shadows: np.ndarray


@lru_cache(maxsize=1)
def grain_integral() -> np.ndarray:
    """Return (513, 512) float32 running sums along x of the tiled grain: fine noise, stains and patches, mean 0."""
    rng = np.random.default_rng(20_240)
    size = 512
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :])
    grain = np.zeros((size, size))
    for amplitude, cut, floor in ((0.12, 0.6, 0.2), (0.035, 0.10, 0.02), (0.045, 0.010, 0.002)):
        spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
        band = np.exp(-((frequency / cut) ** 2)) * (1 - np.exp(-((frequency / floor) ** 2)))
        layer = np.fft.irfft2(spectrum * band, s=(size, size))
        grain += amplitude * layer / layer.std()
    grain = np.clip(grain - grain.mean(), -0.5, 0.7)
    grain -= grain.mean()
    return np.ascontiguousarray(
        np.concatenate([np.zeros((1, size)), np.cumsum(grain, axis=0)]), dtype=np.float32
    )


def _panel(
    x: float, y: float, z: float, ax: float, ay: float, length: float, height: float, wall: np.ndarray
) -> np.ndarray:
    """Return a plain wall; see kernels.facade for what the numbers are."""
    panel = np.zeros(PANEL_SIZE)
    panel[:8] = x, y, z, ax, ay, 0.0, length, height
    panel[8:11] = wall
    panel[12], panel[17], panel[18], panel[24] = 3.0, z, 1.25, 1.0
    panel[26:29] = float(y > 0), x, ax
    return panel


def _side_wall(
    side: int, x: float, facing: float, front: float, height: float, wall: np.ndarray, neighbour: House | None
) -> list[np.ndarray]:
    """Return the visible parts of a side wall: above the neighbour, and in front of it."""
    deep = 12.0

    def strip(near: float, far: float, base: float, top: float) -> np.ndarray:
        start = near if (facing > 0) == (side > 0) else far
        return _panel(x, start, base, 0.0, facing, abs(far - near), top - base, 0.92 * wall)

    if neighbour is None:
        return [strip(front, front + side * deep, 0.0, height)]
    parts = []
    next_front, next_height = neighbour[3], neighbour[4]
    if height > next_height:
        parts.append(strip(front, front + side * deep, next_height, height))
    if side * (next_front - front) > 0.01:
        parts.append(strip(front, next_front, 0.0, min(height, next_height)))
    return parts


def _buildings(street: StreetSpec, rng: np.random.Generator) -> np.ndarray:
    """Rows of houses on both sides: ground floor, storeys, cornice, and side walls."""
    panels: list[np.ndarray] = []
    houses: list[House] = []
    for side in (-1, 1):
        x = street.start_x_m - 20.0
        while x < street.end_x_m + 40.0:
            length, storeys = rng.uniform(9, 24), int(rng.integers(2, 6))
            storey, ground = rng.uniform(2.9, 3.4), rng.uniform(3.4, 4.2)
            wall = WALLS[rng.integers(len(WALLS))] * rng.uniform(0.8, 1.15)
            front = side * (street.facade_y_m + (rng.uniform(0.2, 1.0) if rng.random() < 0.4 else 0.0))
            seed = int(rng.integers(1, 30_000))
            bays = max(2, round(length / rng.uniform(2.4, 3.4)))
            # the outward normal is axis x up: it points at the street on either side
            along = float(side)
            start = x if along > 0 else x + length
            height = ground + storeys * storey
            share = (rng.uniform(0.36, 0.55), rng.uniform(0.45, 0.6))
            shop = (rng.uniform(0.5, 0.85), rng.uniform(0.5, 0.68))
            panel = _panel(start, front, 0.0, along, 0.0, length, height + 0.5, wall)
            panel[11:17] = length / bays, storey, *share, 0.25, seed
            panel[19:22] = ground, length / max(1, bays // 2), shop[0]
            panel[22:26] = 0.12 * ground, (0.12 + shop[1]) * ground, rng.uniform(0.6, 1.0), height
            panels.append(panel)
            houses.append((side, x, x + length, front, height + 0.4, wall))
            x += length + (rng.uniform(2, 5) if rng.random() < 0.12 else 0.0)
    for i, (side, x0, x1, front, height, wall) in enumerate(houses):
        before = houses[i - 1] if i > 0 and houses[i - 1][0] == side else None
        after = houses[i + 1] if i + 1 < len(houses) and houses[i + 1][0] == side else None
        panels += _side_wall(
            side, x0, -1.0, front, height, wall, before if before and x0 - before[2] < 0.5 else None
        )
        panels += _side_wall(
            side, x1, 1.0, front, height, wall, after if after and after[1] - x1 < 0.5 else None
        )
    return np.array(panels)


def _tree(
    x: float, y: float, base: float, rng: np.random.Generator
) -> tuple[list[list[float]], tuple[float, float, float, float]]:
    """Trunk, branches and a crown of many leafy blobs; returns capsules and the crown's sphere."""
    height, crown = rng.uniform(5.5, 8.0), rng.uniform(1.5, 2.2)
    bark, leaf = [0.075, 0.055, 0.040], LEAVES[rng.integers(len(LEAVES))] * rng.uniform(0.8, 1.25)
    fork = height - 1.7 * crown
    parts = [[x, y, base, x, y, base + fork, 0.15, 0.10, *bark, 0.0]]
    centre = np.array([x, y, base + height - crown])
    for k in range(34):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        radius = crown * rng.uniform(0.20, 0.36)
        spread = (crown - 0.55 * radius) * (rng.uniform(0.35, 1.0) ** 0.5)
        p = centre + direction * spread * np.array([1.0, 1.0, 0.88])
        tone = rng.uniform(0.72, 1.3) * (0.8 + 0.25 * direction[2]) * (0.85 if k % 3 == 0 else 1.0)
        parts.append([*p, *p, radius, radius, *(leaf * tone), 0.0])
    for _ in range(4):
        tip = centre + rng.normal(0, 0.35, 3) * crown
        parts.append([x, y, base + fork - 0.1, *tip, 0.075, 0.03, *bark, 0.0])
    return parts, (*centre, crown)


def _furniture(
    street: StreetSpec, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    capsules: list[list[float]] = []
    groups, lamps, crowns = [], [], []
    z = street.kerb_height_m
    steel = [0.16, 0.165, 0.17]
    for side in (-1, 1):
        y = side * (street.kerb_y_m + 0.45)
        x = street.start_x_m + (0.5 * LAMP_SPACING_M if side > 0 else 2.0)
        while x < street.end_x_m:
            first = len(capsules)
            head_y = y - side * 1.5
            capsules.append([x, y, z, x, y, z + LAMP_HEIGHT_M - 0.15, 0.075, 0.05, *steel, 0.0])
            capsules.append(
                [
                    x,
                    y,
                    z + LAMP_HEIGHT_M - 0.15,
                    x,
                    head_y,
                    z + LAMP_HEIGHT_M + 0.05,
                    0.045,
                    0.04,
                    *steel,
                    0.0,
                ]
            )
            capsules.append(
                [
                    x,
                    head_y + side * 0.25,
                    z + LAMP_HEIGHT_M + 0.02,
                    x,
                    head_y - side * 0.25,
                    z + LAMP_HEIGHT_M + 0.06,
                    0.085,
                    0.07,
                    *steel,
                    0.0,
                ]
            )
            capsules.append(
                [
                    x,
                    head_y + side * 0.2,
                    z + LAMP_HEIGHT_M - 0.04,
                    x,
                    head_y - side * 0.2,
                    z + LAMP_HEIGHT_M,
                    0.06,
                    0.05,
                    *steel,
                    1.0,
                ]
            )
            groups.append([first, len(capsules), x, 0.5 * (y + head_y), z + 3.6, 4.0, StaticClass.FURNITURE])
            lamps.append([x, head_y, z + LAMP_HEIGHT_M - 0.05])
            x += LAMP_SPACING_M
        x = street.start_x_m + rng.uniform(4, 12)
        while x < street.end_x_m:
            near_zebra = any(abs(x - c.x_m) < 0.5 * c.width_m + 5.0 for c in street.crosswalks)
            near_lamp = any(abs(x - lamp[0]) < 2.6 and lamp[1] * side > 0 for lamp in lamps)
            if not near_zebra and not near_lamp:
                first = len(capsules)
                parts, crown = _tree(x, side * (street.kerb_y_m + 0.9), z, rng)
                capsules += parts
                groups.append(
                    [
                        first,
                        len(capsules),
                        crown[0],
                        crown[1],
                        0.5 * (crown[2] + crown[3]) + 0.1,
                        0.5 * (crown[2] + crown[3]) + 0.6,
                        StaticClass.VEGETATION,
                    ]
                )
                crowns.append(crown)
            x += rng.uniform(9, 17)
    return np.array(capsules), np.array(groups, np.float64), np.array(lamps), np.array(crowns).reshape(-1, 4)


def _integral(profile: np.ndarray, texel: float, middle: int) -> np.ndarray:
    """Running integral in texels (float32), zero in the middle, where precision matters most."""
    total = np.concatenate([np.zeros((1, profile.shape[1])), np.cumsum(profile, axis=0)])
    return np.ascontiguousarray(total - total[middle], dtype=np.float32)


def _across(street: StreetSpec) -> tuple[np.ndarray, np.ndarray, float]:
    """Profiles across the street, below and above the kerb."""
    reach = street.facade_y_m + 25.0
    count = 2 * round(reach / ACROSS_TEXEL_M)
    y = (np.arange(count) + 0.5) * ACROSS_TEXEL_M - 0.5 * count * ACROSS_TEXEL_M
    d = np.abs(y)
    kerb, lanes = street.kerb_y_m, street.lanes_per_direction * street.lane_width_m
    low, high = np.zeros((count, 8)), np.zeros((count, 8))
    road = d < kerb
    low[:, 0] = road
    wear = 1 + 0.10 * np.exp(-((((d % street.lane_width_m) - 0.5 * street.lane_width_m - 0.75) / 0.25) ** 2))
    wear += 0.10 * np.exp(-((((d % street.lane_width_m) - 0.5 * street.lane_width_m + 0.75) / 0.25) ** 2))
    asphalt = np.array([0.088, 0.089, 0.092])
    gutter = (d > kerb - 0.3) & road
    parking = (d > lanes) & road
    for c in range(3):
        low[:, 1 + c] = np.where(road, asphalt[c] * wear, 0.0)
        low[parking, 1 + c] = asphalt[c] * 1.22
        low[gutter, 1 + c] = 0.15
    low[:, 4] = (
        (np.abs(d - lanes) < 0.06) & (street.parking_width_m > 0.3)
        if street.parking_width_m > 0.3
        else np.abs(d - lanes + 0.3) < 0.06
    )
    dash = d < 0.06
    for lane in range(1, street.lanes_per_direction):
        dash |= np.abs(d - lane * street.lane_width_m) < 0.06
    low[:, 5] = dash
    low[:, 6] = road & (d < kerb - 0.25) & ((y % 1.0) < 0.5)
    low[:, 7] = road & (d < lanes - 0.1)
    kerbstone, walk = d - kerb < 0.18, d < street.facade_y_m
    slab = ((d - kerb - 0.18) % 0.5) < 0.012
    outside = ~road
    for c, (stone, pave, grass) in enumerate(
        zip((0.34, 0.335, 0.32), (0.255, 0.245, 0.225), (0.055, 0.085, 0.03), strict=True)
    ):
        value = np.where(kerbstone, stone, np.where(walk, np.where(slab, 0.6 * pave, pave), grass))
        high[:, 1 + c] = np.where(outside, value, 0.0)
    high[:, 0] = outside
    middle = count // 2
    return (
        _integral(low, ACROSS_TEXEL_M, middle),
        _integral(high, ACROSS_TEXEL_M, middle),
        -0.5 * count * ACROSS_TEXEL_M,
    )


def _along(street: StreetSpec) -> np.ndarray:
    """Profiles along the street: dashes (3 m of 9), zebras, stop lines (right-hand traffic: both approaches)."""
    count = round((street.end_x_m - street.start_x_m + 400.0) / ALONG_TEXEL_M)
    x = street.start_x_m - 100.0 + (np.arange(count) + 0.5) * ALONG_TEXEL_M
    profile = np.zeros((count, 3))
    profile[:, 0] = (x % 9.0) < 3.0
    for crossing in street.crosswalks:
        half = 0.5 * crossing.width_m
        profile[np.abs(x - crossing.x_m) < half + 1.6, 0] = 0.0
        profile[np.abs(x - crossing.x_m) < half, 1] = 1.0
    return np.ascontiguousarray(np.concatenate([np.zeros((1, 3)), np.cumsum(profile, axis=0)]))


def _lamp_maps(
    street: StreetSpec, lamps: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
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


@lru_cache(maxsize=8)
def scenery_of(street: StreetSpec) -> Scenery:
    """Build (or recall) the tables of a street; everything that is only looks follows from ``street.seed``."""
    house_rng, furniture_rng = np.random.default_rng([street.seed & 0xFFFFFFFF, 11]).spawn(2)
    capsules, groups, lamps, crowns = _furniture(street, furniture_rng)
    low, high, across_low = _across(street)
    ground, ground_frame, fronts, map_frame = _lamp_maps(street, lamps)
    return Scenery(
        _buildings(street, house_rng), capsules, groups, lamps, ground, ground_frame, fronts, map_frame, _along(street), low, high,
        across_low, crowns,
    )  # fmt: skip


def sun_shear(direction: np.ndarray) -> tuple[float, float]:
    """Return how far a shadow falls per metre of height, along x and y; bounded for a low sun."""
    rise = max(0.08, float(direction[2]))
    return -float(direction[0]) / rise, -float(direction[1]) / rise


def tree_shadow_capsules(crowns: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Shadows of crowns on the ground: (S, 9) capsules of kernels.ground."""
    shear_x, shear_y = sun_shear(direction)
    out = np.zeros((len(crowns), 9))
    for k, (x, y, z, r) in enumerate(crowns):
        out[k, 0], out[k, 1] = x + shear_x * (z - 0.5 * r), y + shear_y * (z - 0.5 * r)
        out[k, 2], out[k, 3] = shear_x * r, shear_y * r
        out[k, 4] = 1 / max(1e-6, math.hypot(out[k, 2], out[k, 3]) ** 2)
        out[k, 5:9] = 0.8 * r, 1.1, 0.8, 0
    return out
