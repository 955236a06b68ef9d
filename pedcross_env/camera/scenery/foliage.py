"""Textures of crowns: leaves in three dimensions, seen from the side."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pedcross_env.camera.kernels.crown import BORDER, TEXTURE_CHANNELS, splat_leaves
from pedcross_env.camera.kernels.jit import LANES

__all__ = ["BARE", "COLUMNAR", "CONIFERS", "ROUND", "CrownTextures", "crown_textures"]

SIZE, LEVELS = 256, 5  # texels along a side of the finest textures; how many there are, each half as fine
MOST = 32_000  # of the sums along a row: over all rows they stay whole numbers of 24 bits
ROUND, COLUMNAR, CONIFERS, BARE = (0, 1, 2), (3,), (4,), (5, 6)
"""Which textures belong to a species."""


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.sqrt((vectors**2).sum(axis=1)), 1e-9)[:, None]


def _leafy(
    rng: np.random.Generator, lobes: np.ndarray, count: int, leaf: tuple[float, float], flat: float = 1.0
) -> np.ndarray:
    """Leaves on the skins of overlapping spheres, far ones first; see ``splat_leaves`` for the columns.

    Args:
        rng: Of this crown.
        lobes: (L, 4) centre (right, down, away) and radius, the texture reaching from -1 to 1.
        count: How many leaves.
        leaf: Half length, half width in texels.
        flat: How much lower than wide the lobes are drawn.
    """
    area = lobes[:, 3] ** 2
    own = lobes[rng.choice(len(lobes), count, p=area / area.sum())]
    out = _unit(rng.normal(size=(count, 3)))
    ragged = rng.random(count) ** 0.25 * (1 + 0.13 * rng.normal(size=count))
    place = own[:, :3] + out * (own[:, 3] * ragged)[:, None] * np.array([1.0, flat, 1.0])
    # what other lobes cover lies in the shade
    dx, dy, dz = (place[:, None, k] - lobes[None, :, k] for k in range(3))
    gap = np.sqrt(dx * dx + dy * dy + dz * dz) - lobes[None, :, 3]
    buried = np.clip(-gap, 0, 0.25).sum(axis=1) - np.clip(own[:, 3] * (1 - ragged), 0, 0.25)
    tone = np.exp2(-3.2 * np.clip(buried, 0, 1)) * (0.88 - 0.30 * out[:, 1]) * (0.62 + 0.42 * ragged)
    tone *= rng.uniform(0.72, 1.28, count)
    normal = _unit(0.75 * out + 0.35 * _unit(place) + 0.55 * rng.normal(size=(count, 3)))
    keep = np.flatnonzero((np.abs(place[:, 0]) < 0.97) & (np.abs(place[:, 1]) < 0.97))
    keep = keep[np.argsort(-place[keep, 2], kind="stable")]
    length, width = leaf
    scale = rng.uniform(0.7, 1.3, count)
    table = np.stack(
        [0.5 * SIZE * (place[:, 0] + 1), 0.5 * SIZE * (place[:, 1] + 1), length * scale, width * scale,
         rng.uniform(0, math.pi, count), tone, normal[:, 0], normal[:, 1]], axis=1,
    )  # fmt: skip
    return np.ascontiguousarray(table[keep])


def _lobes(
    rng: np.random.Generator, count: int, spread: tuple[float, float], radius: tuple[float, float]
) -> np.ndarray:
    """Spheres on an ellipsoid (half width, half height), even over its directions."""
    turns = (np.arange(count) + rng.uniform(0.2, 0.8, count)) / count
    angle, rise = 2.39996 * np.arange(count) + rng.uniform(0, 0.6, count), 2 * turns - 1
    ring = np.sqrt(np.maximum(0, 1 - rise**2))
    reach = rng.uniform(0.75, 1.0, count)
    centre = np.stack(
        [ring * np.cos(angle) * spread[0], rise * spread[1], ring * np.sin(angle) * spread[0]], axis=1
    )
    return np.column_stack([centre * reach[:, None], rng.uniform(*radius, count)])


def _round(rng: np.random.Generator) -> np.ndarray:
    lobes = _lobes(rng, 14, (0.72, 0.66), (0.19, 0.36))
    lobes = np.concatenate([lobes, [[0.0, 0.05, 0.0, 0.46]]])
    return _leafy(rng, lobes, 7000, (3.6, 2.1))


def _columnar(rng: np.random.Generator) -> np.ndarray:
    lobes = _lobes(rng, 22, (0.45, 0.80), (0.26, 0.36))
    lobes[:, 0] *= np.sqrt(np.clip(1.12 - (lobes[:, 1] - 0.2) ** 2, 0.1, 1))
    return _leafy(rng, lobes, 8000, (3.8, 1.7), 0.55)


def _conifer(rng: np.random.Generator) -> np.ndarray:
    """Whorls of drooping boughs, wider from the tip down."""
    count = 9000
    t = rng.random(count) ** 0.55
    angle = rng.uniform(0, 2 * math.pi, count)
    saw = (t * 11.0 + 0.35 * np.sin(3 * angle)) % 1.0
    radius = 0.93 * t * (0.66 + 0.34 * saw) * rng.random(count) ** 0.22
    place = np.stack([radius * np.cos(angle), -0.97 + 1.92 * t + 0.05 * saw, radius * np.sin(angle)], axis=1)
    inner = radius / (0.93 * np.maximum(t, 0.02))
    tone = (0.30 + 0.70 * inner**1.5) * (1.08 - 0.45 * saw) * rng.uniform(0.75, 1.25, count)
    out = np.stack([np.cos(angle), np.full(count, -0.45), np.sin(angle)], axis=1)
    normal = _unit(out + 0.5 * rng.normal(size=(count, 3)))
    droop = np.where(place[:, 0] > 0, 1, -1) * rng.uniform(0.2, 0.9, count)
    order = np.argsort(-place[:, 2], kind="stable")
    table = np.stack(
        [0.5 * SIZE * (place[:, 0] + 1), 0.5 * SIZE * (place[:, 1] + 1), rng.uniform(3.5, 6.0, count), np.full(count, 1.2),
         droop, tone, normal[:, 0], normal[:, 1]], axis=1,
    )  # fmt: skip
    return np.ascontiguousarray(table[order])


def _bare(rng: np.random.Generator) -> np.ndarray:
    """Branches that fork, ever thinner."""
    strokes: list[list[float]] = []

    def grow(x: float, y: float, angle: float, length: float, width: float, level: int) -> None:
        bend = rng.uniform(-0.12, 0.12)
        for k in range(3):
            step = length / 3
            nx, ny = x + step * math.sin(angle), y - step * math.cos(angle)
            thick = width * (1 - 0.12 * k)
            strokes.append(
                [0.5 * SIZE * (0.5 * (x + nx) + 1), 0.5 * SIZE * (0.5 * (y + ny) + 1), 0.25 * SIZE * step * 1.25,
                 max(0.55, thick), angle + 0.5 * math.pi, rng.uniform(0.8, 1.2), 0.3 * rng.uniform(-1, 1), -0.2]
            )  # fmt: skip
            x, y, angle = nx, ny, angle + bend
            if level < 5 and k > 0:
                turn = rng.uniform(0.35, 0.75) * (1 if (k + level) % 2 else -1)
                grow(x, y, angle + turn, length * rng.uniform(0.6, 0.78), width * 0.58, level + 1)
        if level < 5:
            grow(x, y, angle - bend, length * rng.uniform(0.62, 0.8), width * 0.66, level + 1)

    for angle in (-0.75, -0.4, -0.05, 0.3, 0.7):
        grow(0.0, 0.98, angle + rng.uniform(-0.1, 0.1), 0.60, 3.0, 1)
    return np.array(strokes)


def _halved(images: np.ndarray) -> np.ndarray:
    """(S, N / 2, N / 2, C) means of every two by two texels."""
    rows = images[:, 0::2] + images[:, 1::2]
    return np.asarray(0.25 * (rows[:, :, 0::2] + rows[:, :, 1::2]))


def _running_sums(images: np.ndarray) -> np.ndarray:
    """(S, N, C * M) sums of the texels left of each corner of theirs, channel by channel in each row; M is N in whole vectors."""
    count, texels, _, channels = images.shape
    nodes, first = texels + 2 * BORDER + 1, BORDER + 1
    sums = np.zeros((count, nodes, channels, nodes + -nodes % LANES))
    inner = sums[:, first : first + texels]
    np.cumsum(images.transpose(0, 1, 3, 2), axis=3, out=inner[..., first : first + texels])
    inner[..., first + texels :] = inner[..., first + texels - 1, None]
    return sums.reshape(count, nodes, -1)


def _bounds(sums: np.ndarray) -> np.ndarray:
    """(S, N, 2) nodes between which the cover's sums along each row rise; N and 0 where they do not."""
    n = sums.shape[1]
    cover = sums[:, :, :n]  # the first channel
    rises, full = cover > 0, cover < cover[:, :, -1:]
    return np.stack([np.where(rises.any(axis=2), rises.argmax(axis=2) - 1, n), full.sum(axis=2)], axis=2)


class CrownTextures(NamedTuple):
    """All crowns, LEVELS times, ever coarser; N = texels along a side + 2 BORDER + 1, half as many texels each time.

    Attributes:
        sums: Each (S, N, 5 * M) float32, M being N in whole vectors: per crown, row of texels, channel and column the running sums,
            down and along, of the cover, the tone, and the tone times the leaf's normal to the right, downwards and away. Row and
            column BORDER are the texture's edge. They are whole numbers that float32 holds exactly, and so their differences.
        units: What 1 stands for in each.
        bounds: Each (S, N, 2) int64, the columns between which the leaves of a row lie.
        gaps: (S,) share of a crown's middle that no leaf or branch covers.
    """

    sums: tuple[np.ndarray, ...]
    units: tuple[float, ...]
    bounds: tuple[np.ndarray, ...]
    gaps: np.ndarray


@lru_cache(maxsize=1)
def crown_textures() -> CrownTextures:
    """Return all crowns."""
    makers = (_round, _round, _round, _columnar, _conifer, _bare, _bare)
    images = np.zeros((len(makers), SIZE, SIZE, TEXTURE_CHANNELS), np.float32)
    rngs = np.random.default_rng(31_415).spawn(len(makers))
    for image, make, rng in zip(images, makers, rngs, strict=True):
        splat_leaves(make(rng), image)
    means, sums, units, bounds = images.astype(np.float64), [], [], []
    for level in range(LEVELS):
        means = _halved(means) if level else means
        exact = _running_sums(means)
        unit = float(max(exact.max(), -exact.min())) / MOST
        bounds.append(_bounds(exact))
        whole = np.rint(np.divide(exact, unit, out=exact), out=exact)
        sums.append(np.cumsum(whole, axis=1, out=whole).astype(np.float32))
        units.append(unit)
    middle = slice(SIZE // 4, SIZE - SIZE // 4)
    gaps = 1.0 - images[:, middle, middle, 0].mean(axis=(1, 2), dtype=np.float64)
    return CrownTextures(tuple(sums), tuple(units), tuple(bounds), gaps)
