"""Clouds: which directions of the sky they cover, as a texture of directions.

A layer of fractal noise above the street, seen in perspective, is cut at the height that leaves the weather's cloudiness
covered. The texture belongs to directions, not to places: clouds are too far away to move while a street is driven along, and
a view that does not turn sees the same sky in every picture. The mean light of the sky is what it is without clouds.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

__all__ = ["CLOUD_COLUMNS", "CLOUD_ROWS", "cloud_texture", "directions"]

CLOUD_ROWS, CLOUD_COLUMNS = (
    160,
    1024,
)  # over the sine of the elevation, 0 to 1, and over the diamond angle, 0 to 4
LATTICE = 128  # of the noise, periodic
OCTAVES = 6
SKIES = 8  # of different shapes: making one takes a twentieth of a second
CURVE = 0.12  # keeps the layer's horizon finite, as the earth's curvature does
SOFTNESS = 0.22  # of a cloud's edge, in standard deviations of the noise
HAZE_SINE = 0.07  # below this elevation clouds drown in the horizon's haze


def directions() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors of the texture's nodes: x, y, z, each (CLOUD_ROWS, CLOUD_COLUMNS).

    The diamond angle is y / (|x| + |y|) where x >= 0 and 2 minus that elsewhere, modulo 4: an angle without trigonometry.
    """
    sine = np.linspace(0.0, 1.0, CLOUD_ROWS)[:, None]
    angle = (np.arange(CLOUD_COLUMNS) * 4.0 / CLOUD_COLUMNS)[None, :]
    turned = np.where(angle > 3.0, angle - 4.0, angle)
    y = np.where(turned > 1.0, 2.0 - turned, turned)
    x = np.where(turned > 1.0, np.abs(y) - 1.0, 1.0 - np.abs(y))
    length = np.sqrt(x * x + y * y)
    cosine = np.sqrt(1.0 - sine * sine)
    return x / length * cosine, y / length * cosine, sine + 0.0 * x


def _noise(x: np.ndarray, y: np.ndarray, lattice: np.ndarray) -> np.ndarray:
    """Value noise with the smoothest cubic between lattice points."""
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    s, t = x - i, y - j
    s, t = s * s * (3.0 - 2.0 * s), t * t * (3.0 - 2.0 * t)
    i, j = i % LATTICE, j % LATTICE
    k, m = (i + 1) % LATTICE, (j + 1) % LATTICE
    i, k = LATTICE * i, LATTICE * k
    corner = lattice.ravel().take
    low, high = corner(i + j), corner(i + m)
    low += s * (corner(k + j) - low)
    high += s * (corner(k + m) - high)
    return np.asarray(low + t * (high - low))


@lru_cache(maxsize=SKIES)
def _layer(shape: int) -> tuple[np.ndarray, np.ndarray]:
    """Fractal noise of the layer (unit variance) and a finer one for the clouds' own shading."""
    rng = np.random.default_rng([shape, 77])
    dx, dy, dz = directions()
    x, y = dx / (dz + CURVE), dy / (dz + CURVE)
    # one step of the texture along the elevation, in units of the layer: finer noise would alias
    step = 1.0 / (CLOUD_ROWS * (dz + CURVE) ** 2)
    total, fine = np.zeros_like(x), np.zeros_like(x)
    scale, weight = 0.9, 1.0
    for octave in range(OCTAVES):
        shown = np.clip(1.5 - 2.0 * scale * step, 0.0, 1.0)
        lattice, (along, across) = rng.random((LATTICE, LATTICE)) - 0.5, rng.random(2) * LATTICE
        value = weight * shown * _noise(x * scale + along, y * scale * 1.25 + across, lattice)
        total += value
        if octave >= 1:
            fine += value
        scale, weight = 2.07 * scale, 0.52 * weight
    return total / total.std(), fine / fine.std()


def _smooth(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


@lru_cache(maxsize=8 * SKIES)
def _texture(cloudiness: float, shape: int) -> np.ndarray:
    out = np.zeros((2, CLOUD_ROWS, CLOUD_COLUMNS), np.float32)
    out[0] = 1.0
    if cloudiness <= 0:
        return out
    layer, fine = _layer(shape)
    low, high = float(layer.min()) - 1.0, float(layer.max()) + 1.0
    sample = layer[::2, ::3]
    for _ in range(16):  # rows are even in the sine: a plain mean weighs directions by solid angle
        cut = 0.5 * (low + high)
        covered = float(_smooth((sample - cut) / SOFTNESS + 0.5).mean())
        low, high = (cut, high) if covered > cloudiness else (low, cut)
    cover = _smooth((layer - cut) / SOFTNESS + 0.5)
    thick = _smooth((layer - cut) / 2.5)
    # Sunlit rims outshine the blue, thick middles are darker; a closed cover has soft bellies and rifts.
    contrast = 1.3 * (1.0 - 0.75 * cloudiness)
    shade = contrast * (cover - cloudiness) - 0.35 * cover * (thick - thick.mean())
    shade += 0.09 * cover * fine * (0.4 + 0.6 * cloudiness)
    dz = directions()[2]
    haze = dz * dz / (dz * dz + HAZE_SINE * HAZE_SINE)
    shade = haze * (shade - shade.mean())
    shade -= haze * (shade.mean() / haze.mean())
    out[0] = np.maximum(1.0 + shade, 0.15)
    out[0] /= out[0].mean()
    out[1] = haze * (cover - cloudiness)
    out.setflags(write=False)
    return out


def cloud_texture(cloudiness: float, seed: int) -> np.ndarray:
    """Return what clouds make of the sky's light, (2, CLOUD_ROWS, CLOUD_COLUMNS) float32.

    Args:
        cloudiness: Covered share of the sky, 0 to 1.
        seed: Of their shapes.

    Returns:
        The factor of the luminance, its mean over the upper half of all directions 1, and by how much more than the mean
        of the sky a direction is covered, -cloudiness to 1 - cloudiness.
    """
    return _texture(float(cloudiness), int(seed) % SKIES)
