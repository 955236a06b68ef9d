"""The ground's profiles across and along the street, as running integrals, and the grain of its surface."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pedcross_env.scenario.street import StreetSpec

__all__ = [
    "ACROSS_TEXEL_M",
    "ALONG_MARGIN_M",
    "ALONG_TEXEL_M",
    "GROUND_TEXEL_M",
    "across_profiles",
    "along_profiles",
    "grain_integral",
]

ACROSS_TEXEL_M, ALONG_TEXEL_M, GROUND_TEXEL_M = 0.01, 0.05, 0.025
ALONG_MARGIN_M = 100.0  # by which tables along the street reach beyond its start
FORECOURT_M = 1.0  # paved beyond the line of the facades, to fronts that stand back


@lru_cache(maxsize=1)
def grain_integral() -> np.ndarray:
    """Return (513, 513) float32 running sums along x and y of the tiled grain: fine noise, stains and patches, mean 0."""
    rng = np.random.default_rng(20_240)
    size = 512
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :])
    grain = np.zeros((size, size))
    # stones of a centimetre average out over a texel of 2.5: stronger fine grain would be events that no road makes
    for amplitude, cut, floor in ((0.06, 0.6, 0.2), (0.035, 0.10, 0.02), (0.045, 0.010, 0.002)):
        spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
        band = np.exp(-((frequency / cut) ** 2)) * (1 - np.exp(-((frequency / floor) ** 2)))
        layer = np.fft.irfft2(spectrum * band, s=(size, size))
        grain += amplitude * layer / layer.std()
    grain = np.clip(grain - grain.mean(), -0.5, 0.7)
    grain -= grain.mean()
    return np.ascontiguousarray(
        np.pad(grain.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0))), dtype=np.float32
    )


def _integral(profile: np.ndarray, texel: float, middle: int) -> np.ndarray:
    """Running integral in texels (float32), zero in the middle, where precision matters most."""
    total = np.concatenate([np.zeros((1, profile.shape[1])), np.cumsum(profile, axis=0)])
    return np.ascontiguousarray(total - total[middle], dtype=np.float32)


def across_profiles(street: StreetSpec) -> tuple[np.ndarray, np.ndarray, float]:
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
    kerbstone, walk = d - kerb < 0.18, d < street.facade_y_m + FORECOURT_M
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


def along_profiles(street: StreetSpec) -> np.ndarray:
    """Profiles along the street: dashes (3 m of 9), zebras, stop lines (right-hand traffic: both approaches)."""
    count = round((street.end_x_m - street.start_x_m + 400.0) / ALONG_TEXEL_M)
    x = street.start_x_m - ALONG_MARGIN_M + (np.arange(count) + 0.5) * ALONG_TEXEL_M
    profile = np.zeros((count, 3))
    profile[:, 0] = (x % 9.0) < 3.0
    for crossing in street.crosswalks:
        half = 0.5 * crossing.width_m
        profile[np.abs(x - crossing.x_m) < half + 1.6, 0] = 0.0
        profile[np.abs(x - crossing.x_m) < half, 1] = 1.0
    return np.ascontiguousarray(np.concatenate([np.zeros((1, 3)), np.cumsum(profile, axis=0)]))
