"""Clouds: which directions of the sky they cover, as a texture of directions.

A layer of fractal noise above the street, seen in perspective, is cut at the thickness that leaves the weather's cloudiness
covered; few clouds have flat bases and rise above them, a closed cover is flat. The texture belongs to directions, not to places: clouds are too far away to move while a street is driven along, and
a view that does not turn sees the same sky in every picture. The mean light of the sky is what it is without clouds.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pedcross_env.camera.kernels.cumulus import look_at_clouds

__all__ = ["CLOUD_COLUMNS", "CLOUD_ROWS", "cloud_texture", "directions"]

CLOUD_ROWS = 256  # over the sine of the elevation, 0 to 1
CLOUD_COLUMNS = 1536  # over the diamond angle, 0 to 4
SKIES = 8  # of different shapes: making one takes a tenth of a second
TILE = 512  # of the noise, periodic
WIDE, FINE = 12.0, 3.0  # what the tiles of the layer and of its billows span, in heights of the clouds' base
BILLOWS = 0.45  # how strong they are, in standard deviations of the layer
RISE = 0.16  # of a cloud's top per root of its thickness
CURVE = 0.12  # keeps the layer's horizon finite, as the earth's curvature does
RIFTS = -2.8  # thickness below which even a closed cover has some
SOFTNESS = 0.3  # of a cloud's edge, in standard deviations of the layer
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


def _field(rng: np.random.Generator, span: float, longest: float, roughness: float) -> np.ndarray:
    """Return tiled noise (TILE, TILE) float32 of unit variance: nothing is longer than ``longest``, what is shorter is fainter.

    Args:
        rng: Source of it.
        span: Length of the tile.
        longest: Wavelength of the largest shapes.
        roughness: Power of the wavelength that amplitudes follow.
    """
    frequency = (
        np.hypot(np.fft.fftfreq(TILE)[:, None], np.fft.rfftfreq(TILE)[None, :]) * TILE * longest / span
    )
    spectrum = np.fft.rfft2(rng.standard_normal((TILE, TILE)))
    spectrum *= np.minimum(frequency, 1.0) ** 3 / np.maximum(frequency, 1.0) ** roughness
    field = np.fft.irfft2(spectrum, s=(TILE, TILE))
    return np.asarray(field / field.std(), np.float32)


@lru_cache(maxsize=SKIES)
def _layer(shape: int) -> tuple[np.ndarray, np.ndarray]:
    """Thickness of the layer and its billows, round ones that meet in creases, both tiled."""
    rng = np.random.default_rng([shape, 77])
    base = _field(rng, WIDE, 2.0, 2.6)
    billows = np.abs(_field(rng, FINE, 0.6, 2.3))
    billows = billows.mean() - billows
    return base, np.asarray(billows / billows.std(), np.float32)


@lru_cache(maxsize=3 * SKIES)
def _texture(cloudiness: float, shape: int) -> np.ndarray:
    out = np.zeros((2, CLOUD_ROWS, CLOUD_COLUMNS), np.float32)
    out[0] = 1.0
    if cloudiness <= 0:
        return out
    base, detail = _layer(shape)
    rays = directions()
    some = [np.ascontiguousarray(axis[::4, ::6]) for axis in rays]
    rise = RISE * (1.0 - cloudiness)

    def look(axes: list[np.ndarray], cut: float) -> np.ndarray:
        seen = np.zeros((*axes[0].shape, 3), np.float32)
        lengths = WIDE, FINE, BILLOWS, cut, SOFTNESS, rise, CURVE, 1.0 / CLOUD_ROWS
        look_at_clouds(*axes, base, detail, lengths, seen)
        return np.moveaxis(seen, 2, 0)

    low, high = RIFTS, 6.0
    for _ in range(12):  # rows are even in the sine: a plain mean weighs directions by solid angle
        cut = 0.5 * (low + high)
        low, high = (cut, high) if float(look(some, cut)[0].mean()) > cloudiness else (low, cut)
    cover, tall, thick = look([np.ascontiguousarray(axis) for axis in rays], cut)
    # Sunlit tops and rims outshine the blue, thick middles seen from below are darker; a closed cover has soft bellies and rifts.
    contrast = 1.3 * (1.0 - 0.75 * cloudiness)
    shade = contrast * (0.72 * cover + 0.8 * tall) - 0.6 * thick
    dz = rays[2]
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
