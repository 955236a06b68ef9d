"""Rain before the lens: drops that exist in the world, drawn as the streaks an exposure makes of them.

Space is cut into cells that fall with the drops of one size class. Which drops a cell holds follows from
a hash of the seed and the cell's place, so every camera, at every time, sees the same drops, wherever it
stands: nothing is simulated and nothing has to be remembered.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from pedcross_env.config import require
from pedcross_env.contracts import Frame
from pedcross_env.hashing import seed_key
from pedcross_env.weather import _rain_kernels as kernels
from pedcross_env.weather.weather import Weather

__all__ = ["Pose", "Precipitation", "drop_density_per_m3_mm", "fall_speed_mps"]

_SMALLEST_MM = 0.4
_LARGEST_MM = 6.0  # larger drops break up
_CLASSES = 14
_NEAREST_M = 0.4  # nearer drops are blurred away, or do not pass the windscreen
_MIN_WIDTH_PX = 0.35  # narrower streaks are left to the extinction
_MIN_WIDTH_AT_PX = 800.0  # for pictures wider than this the least width grows in proportion
_BRIGHTNESS = 0.95  # of the wide field that a drop refracts into the lens (Garg and Nayar, 2007)
_SAMPLE_STEP_PX = 8


class Pose(Protocol):
    """What rain must know of a camera: place, world-to-camera rotation (x right, y down, z ahead), optics."""

    @property
    def origin(self) -> np.ndarray: ...  # noqa: D102
    @property
    def rotation(self) -> np.ndarray: ...  # noqa: D102
    @property
    def focal_px(self) -> float: ...  # noqa: D102
    @property
    def cx(self) -> float: ...  # noqa: D102
    @property
    def cy(self) -> float: ...  # noqa: D102
    @property
    def width_px(self) -> int: ...  # noqa: D102
    @property
    def height_px(self) -> int: ...  # noqa: D102


def drop_density_per_m3_mm(diameter_mm: float, rain_mm_h: float) -> float:
    """Drops per m3 and mm of diameter: 8000 exp(-4.1 R^-0.21 D) (Marshall and Palmer, 1948)."""
    return 8000.0 * math.exp(-_slope_per_mm(rain_mm_h) * diameter_mm) if rain_mm_h > 0 else 0.0


def fall_speed_mps(diameter_mm: float) -> float:
    """Terminal speed of a drop: 9.65 - 10.3 exp(-0.6 D) (Atlas et al., 1973)."""
    return 9.65 - 10.3 * math.exp(-0.6 * diameter_mm)


def _slope_per_mm(rain_mm_h: float) -> float:
    return 4.1 * rain_mm_h**-0.21


class Precipitation:
    """The rain of one episode.

    Args:
        weather: Its rain rate and wind; without rain nothing is ever drawn.
        seed: Of the drops' places.
    """

    def __init__(self, weather: Weather, seed: int) -> None:
        self._key = seed_key(seed)
        self._rate_mm_h = weather.rain_mm_h
        self._wind_mps = weather.wind_mps
        edges = np.linspace(_SMALLEST_MM, _LARGEST_MM, _CLASSES + 1)
        self._low_mm, self._high_mm = edges[:-1].copy(), edges[1:].copy()
        if self._rate_mm_h > 0:
            slope = _slope_per_mm(self._rate_mm_h)
            below = np.array([math.exp(-slope * edge) for edge in edges])
            self._slope_per_mm = slope
            self._per_m3 = 8000.0 / slope * (below[:-1] - below[1:])
            # Mean diameter of the class: all its drops fall at one speed, as its cells do.
            shares = self._low_mm * below[:-1] - self._high_mm * below[1:]
            mean_mm = shares / (below[:-1] - below[1:]) + 1.0 / slope
            self._speed_mps = np.array([fall_speed_mps(d) for d in mean_mm])

    def draw(
        self,
        frame: Frame,
        pose: Pose,
        time_s: float,
        exposure_s: float,
        ego_velocity_mps: float,
        depth: np.ndarray | None = None,
    ) -> int:
        """Draw the drops that cross the view during an exposure centred on ``time_s``, in place.

        A drop of diameter D at depth z is a streak D f / z wide and as long as its motion relative to the
        camera. It covers each pixel under it for the share width / (width + length) of the exposure
        (Garg and Nayar), so long exposures make long and faint streaks. Its brightness is 0.95 of
        the mean of the horizon sky's and the picture's luminance. Consecutive exposures that touch
        leave no gaps, so an event camera should pass the time between two renders.

        Args:
            frame: Its luminance and, if there, its radiance are changed.
            pose: Of the camera at ``time_s``.
            time_s: Time since reset.
            exposure_s: 0 or more.
            ego_velocity_mps: Speed of the camera along its optical axis.
            depth: (H, W) float32 used where the frame has none, such as that of the last full frame; without
                both, nothing hides the rain.

        Returns:
            How many streaks were drawn.
        """
        require(exposure_s >= 0, "exposure_s", exposure_s, "0 or more")
        if self._rate_mm_h == 0:
            return 0
        depth = frame.depth if frame.depth is not None else depth
        no_depth, no_radiance = np.empty((0, 0), np.float32), np.empty((0, 0, 0), np.float32)
        sample = frame.luminance[
            _SAMPLE_STEP_PX // 2 :: _SAMPLE_STEP_PX, _SAMPLE_STEP_PX // 2 :: _SAMPLE_STEP_PX
        ]
        around = float(np.mean(sample, dtype=np.float64)) if sample.size else frame.airlight
        least_px = _MIN_WIDTH_PX * max(1.0, pose.width_px / _MIN_WIDTH_AT_PX)
        return int(
            kernels.draw_rain(
                frame.luminance,
                no_radiance if frame.radiance is None else frame.radiance,
                no_depth if depth is None else depth,
                np.ascontiguousarray(pose.origin, np.float64),
                np.ascontiguousarray(pose.rotation, np.float64),
                float(pose.focal_px), float(pose.cx), float(pose.cy),
                float(time_s), float(exposure_s), float(ego_velocity_mps), float(self._wind_mps),
                self._low_mm, self._high_mm, self._per_m3, self._speed_mps, self._slope_per_mm,
                least_px, _NEAREST_M, np.float32(_BRIGHTNESS * 0.5 * (frame.airlight + around)), self._key,
            )
        )  # fmt: skip
