"""Drops on the windscreen and the wiper: an option, for cameras behind the glass.

The glass is a hand's breadth before the lens and far out of focus: a drop is a soft disc through which the scene is
seen small and upside down, and the blade a soft dark band. Drops strike at the rate that the rain's law and the drive
prescribe; which they are follows from a hash of the seed, the place on the glass and the amount of rain so far, so that
both cameras and all sub-frames see the same. The only memory is how fast the car drove in the last seconds.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.config import WindscreenConfig
from pedcross_env.contracts import Frame
from pedcross_env.hashing import child_key, seed_key
from pedcross_env.weather import _windscreen_kernels as kernels
from pedcross_env.weather.precipitation import Pose, fall_speed_mps
from pedcross_env.weather.weather import Weather

__all__ = ["Windscreen", "drops_per_m2_s", "wiper_period_s"]

_DISTANCE_M = 0.10  # from the lens to the glass
_APERTURE_M = 0.002  # of the lens
_SMALLEST_MM, _LARGEST_MM = 0.8, 5.0  # smaller drops leave no mark that the lens resolves
_RAKE = math.sin(math.radians(35.0))  # of the glass, from the way
_PIVOT_M = (-0.25, 0.55)  # of the blade: right of and below the optical axis
_MOST_RAD = math.radians(60.0)
_SWEEP_S = 0.40  # of the blade, one way
_BLADE_HALF_M, _BLADE_ALBEDO = 0.006, 0.05
_LIFETIME_S = 6.0  # of a drop that nothing wipes
_FALLS_MPS = 0.004  # of large drops on the glass, at town speeds
_RISES_FROM_MPS, _RISES = 14.0, 0.002  # the wind of faster driving lifts them
_KEPT_S = 12.0  # how much of the drive is remembered
_COARSE_ROWS, _COARSE_COLUMNS = 12, 20


def drops_per_m2_s(rain_mm_h: float, speed_mps: float) -> float:
    """Drops of 0.8 mm and more that strike a square metre of windscreen in a second.

    Marshall and Palmer's number times the speed across the glass: what falls, on its slope, and what is driven into.
    """
    if rain_mm_h <= 0:
        return 0.0
    slope = _slope(rain_mm_h)
    number = 8000.0 / slope * math.exp(-slope * _SMALLEST_MM)
    fall = fall_speed_mps(_SMALLEST_MM + 1.0 / slope) * math.sqrt(1.0 - _RAKE * _RAKE)
    return number * (fall + _RAKE * max(0.0, speed_mps))


def wiper_period_s(rain_mm_h: float) -> float:
    """Seconds from one sweep to the next: 8 in drizzle, 4, 2, 1 as a driver would set it; a stated choice."""
    for most_mm_h, period_s in ((1.0, 8.0), (4.0, 4.0), (10.0, 2.0)):
        if rain_mm_h <= most_mm_h:
            return period_s
    return 1.0


def _slope(rain_mm_h: float) -> float:
    return 4.1 * rain_mm_h**-0.21


class Windscreen:
    """The glass of one episode.

    Args:
        weather: Its rain; without rain nothing is ever drawn.
        config: Whether there are drops and a wiper.
        seed: Of the drops and of the wiper's phase.
        memory: Of another one, which it continues: (N, 3) time, drops per m2 since the start, metres run by large ones.
    """

    def __init__(
        self, weather: Weather, config: WindscreenConfig, seed: int, memory: np.ndarray | None = None
    ) -> None:
        self.wet = config.drops and weather.rain_mm_h > 0
        self._rain = weather.rain_mm_h
        self._key = child_key(seed_key(seed), 0xD20B)
        period = wiper_period_s(self._rain) if config.wiper == "auto" else 0.0
        phase = period * (int(self._key) % 997) / 997
        self._wiper = (period, _SWEEP_S, phase, _MOST_RAD)
        self._drive = np.zeros((0, 3)) if memory is None else memory

    @property
    def memory(self) -> np.ndarray:
        """(N, 3): all that the next picture depends on, besides its time."""
        return self._drive

    def drive(self, time_s: float, speed_mps: float) -> None:
        """Go on to a time at a speed; the glass was driven at the first of them before."""
        if not self.wet:
            return
        rate = drops_per_m2_s(self._rain, speed_mps)
        wind = speed_mps - _RISES_FROM_MPS
        run = min(0.02, _RISES * wind) if wind > 0 else -_FALLS_MPS
        if len(self._drive) == 0:
            before = time_s - _KEPT_S
            self._drive = np.array([[before, 0.0, 0.0], [time_s, rate * _KEPT_S, run * _KEPT_S]])
            return
        last_s, struck, ran = self._drive[-1]
        taken = time_s - last_s
        if taken > 0:
            more = [[time_s, struck + rate * taken, ran + run * taken]]
            first = max(0, int(np.searchsorted(self._drive[:, 0], time_s - _KEPT_S)) - 1)
            self._drive = np.concatenate([self._drive[first:], more])

    def blade_angle(self, time_s: float) -> float | None:
        """Where the blade is, radians from the upright to the right; None while it rests."""
        period, sweep, phase, most = self._wiper
        if period <= 0:
            return None
        age = (time_s - phase) % period
        return None if age >= 2.0 * sweep else -most * math.cos(math.pi * age / sweep)

    def draw(self, frame: Frame, pose: Pose, time_s: float) -> int:
        """Draw drops and blade over a picture, in place; return how many drops.

        Args:
            frame: Its luminance and, if there, its radiance are changed.
            pose: Gives the optics.
            time_s: At most that of the last ``drive``.
        """
        if not self.wet or len(self._drive) == 0:
            return 0
        per_m = pose.focal_px / _DISTANCE_M
        blur = max(0.75, 0.5 * _APERTURE_M * per_m)
        optics = (per_m, float(pose.cx), float(pose.cy), blur)
        drive = tuple(np.ascontiguousarray(self._drive[:, k]) for k in range(3))
        sizes = (_SMALLEST_MM, _slope(self._rain), _LARGEST_MM)
        angle = self.blade_angle(time_s)
        drawn = 0
        for planes in (frame.luminance[None], frame.radiance):
            if planes is None:
                continue
            coarse = np.empty((len(planes), _COARSE_ROWS, _COARSE_COLUMNS))
            for c in range(len(planes)):
                kernels.coarse_picture(planes[c], coarse[c])
            drawn = kernels.draw_drops(
                planes,
                coarse,
                optics,
                sizes,
                drive,
                self._wiper,
                _PIVOT_M,
                _LIFETIME_S,
                float(time_s),
                self._key,
            )
            if angle is not None:
                kernels.draw_blade(planes, optics, angle, _PIVOT_M, _BLADE_HALF_M, _BLADE_ALBEDO)
        return drawn
