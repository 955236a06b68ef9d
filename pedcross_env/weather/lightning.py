"""Lightning: when it flashes and how bright the sky is then, as functions of seed and time."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from pedcross_env.config import require
from pedcross_env.hashing import child_key, seed_key
from pedcross_env.weather.weather import Weather

__all__ = ["Lightning"]

_SLOT_S = 2.0  # flashes are drawn slot by slot
_LONGEST_S = 4.0  # no flash shines longer
_MEAN_STROKES = 4.0
_GAP_S, _GAP_SPREAD = 0.060, 0.6  # geometric mean and log-deviation of the time between strokes
_NEAREST_KM, _FARTHEST_KM = 1.5, 12.0
_FIRST_LX_KM2 = 18_000.0  # at 1 km: 2.3e9 W of visible light, 100 lm/W, spread over a sphere
_NEXT_SHARE = 0.25
_RISE_S, _FALL_S = 0.3e-3, 1.5e-3
_GLOW_SHARE, _GLOW_S = 0.06, 0.050  # continuing current after each stroke


class _Stroke(NamedTuple):
    start_s: float
    peak_lx: float


class Lightning:
    """The flashes of one episode; nothing is stored but the seed.

    A flash is a first stroke and, on average, three more through the same channel, some 60 ms apart (geometric mean;
    Rakov and Uman, 2003). A stroke's light rises within 0.3 ms and falls within 1.5 ms, which is what scattering in
    the cloud makes of it, and the continuing current glows for some 50 ms. The peak follows from 2.3e9 W of light in
    the first and a quarter of it in later strokes (Guo and Krider, 1982), at distances spread evenly over the area
    from 1.5 to 12 km: 125 to 8000 lx on the ground.

    Args:
        weather: Its rate of flashes; with 0 all light is 0.
        seed: Of their times, distances and strokes.
    """

    def __init__(self, weather: Weather, seed: int) -> None:
        self._rate_per_s = weather.lightning_per_min / 60.0
        self._key = int(child_key(seed_key(seed), 0x11647))
        self._slot = lru_cache(maxsize=64)(self._draw)

    def light_lx(self, time_s: float) -> float:
        """Illuminance of flashes on the ground at one moment."""
        if self._rate_per_s == 0:
            return 0.0
        return sum(s.peak_lx * _pulse(time_s - s.start_s) for s in self._strokes(time_s, time_s))

    def mean_lx(self, start_s: float, end_s: float) -> float:
        """Mean illuminance over an exposure; at one moment where it has no length.

        Raises:
            ConfigError: For an exposure that ends before it starts.
        """
        require(end_s >= start_s, "end_s", end_s, f"start_s ({start_s}) or later")
        if self._rate_per_s == 0:
            return 0.0
        if end_s == start_s:
            return self.light_lx(end_s)
        total = 0.0
        for stroke in self._strokes(start_s, end_s):
            before, after = _energy(start_s - stroke.start_s), _energy(end_s - stroke.start_s)
            total += stroke.peak_lx * (after - before)
        return total / (end_s - start_s)

    def dark(self, start_s: float, end_s: float) -> bool:
        """Whether no flash shines between two times."""
        return self._rate_per_s == 0 or not self._strokes(start_s, end_s)

    def _strokes(self, start_s: float, end_s: float) -> list[_Stroke]:
        first, last = math.floor((start_s - _LONGEST_S) / _SLOT_S), math.floor(end_s / _SLOT_S)
        strokes = [stroke for slot in range(first, last + 1) for stroke in self._slot(slot)]
        # After ten time constants of the glow a stroke's light is less than any camera can tell.
        return [s for s in strokes if start_s - 10 * _GLOW_S < s.start_s < end_s]

    def _draw(self, slot: int) -> tuple[_Stroke, ...]:
        rng = np.random.default_rng([self._key, slot & 0xFFFFFFFFFFFFFFFF])
        strokes: list[_Stroke] = []
        for _ in range(int(rng.poisson(self._rate_per_s * _SLOT_S))):
            time_s = (slot + float(rng.random())) * _SLOT_S
            end_s = time_s + _LONGEST_S - 10 * _GLOW_S
            share = float(rng.random())
            squared_km2 = _NEAREST_KM**2 + share * (_FARTHEST_KM**2 - _NEAREST_KM**2)
            peak = _FIRST_LX_KM2 / squared_km2
            for k in range(int(rng.geometric(1.0 / _MEAN_STROKES))):
                strength = peak if k == 0 else _NEXT_SHARE * peak * float(rng.uniform(0.4, 1.6))
                if time_s < end_s:
                    strokes.append(_Stroke(time_s, strength))
                time_s += _GAP_S * math.exp(_GAP_SPREAD * float(rng.standard_normal()))
        return tuple(strokes)


# A pulse is (1 - e^(-t/rise)) (e^(-t/fall) + share e^(-t/glow)): differences of exponentials, integrable.
_TERMS = tuple(
    (sign * share, 1.0 / (1.0 / fall + rate))
    for share, fall in ((1.0, _FALL_S), (_GLOW_SHARE, _GLOW_S))
    for sign, rate in ((1.0, 0.0), (-1.0, 1.0 / _RISE_S))
)


def _pulse(age_s: float) -> float:
    return sum(share * math.exp(-age_s / tau) for share, tau in _TERMS) if age_s > 0 else 0.0


def _energy(age_s: float) -> float:
    """Integral of the pulse up to ``age_s``."""
    return sum(share * tau * (1.0 - math.exp(-age_s / tau)) for share, tau in _TERMS) if age_s > 0 else 0.0
