"""Rain and snow before the lens: drops that exist in the world, drawn as the streaks an exposure makes of them.

Space is cut into cells that fall with the drops of one size class. Which drops a cell holds follows from
a hash of the seed and the cell's place, so every camera, at every time, sees the same drops, wherever it
stands: nothing is simulated and nothing has to be remembered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from pedcross_env._optics_kernels import LENSES, coefficients
from pedcross_env.config import require
from pedcross_env.contracts import Frame
from pedcross_env.hashing import child_key, seed_key
from pedcross_env.optics import undistort
from pedcross_env.weather import _rain_kernels as kernels
from pedcross_env.weather.weather import Weather

__all__ = [
    "Pose", "Precipitation", "drop_density_per_m3_mm", "fall_speed_mps", "flake_density_per_m3_mm", "flake_speed_mps",
]  # fmt: skip

_SMALLEST_MM = 0.4
_LARGEST_MM = 6.0  # larger drops break up
_CLASSES = 14
_SMALLEST_FLAKE_MM, _LARGEST_FLAKE_MM = 1.0, 16.0
_FLAKE_MM, _FLAKE_POWER = 2.295, 3 / 2.078  # size of a flake over that of the drop it melts to
_FLAKE_WHITE = 0.9  # share of the light around it that a flake scatters on
_FLAKE_MIN_WIDTH_PX = 0.5
_SWAY_M = 0.04
# Luminance towards the lamp per lx: a white sphere sends 2/3 of a white card's, a drop a twentieth of that, a flake,
# between whose crystals light passes, about a third.
_SPHERE_SCATTER = _FLAKE_WHITE * 2 / 3 / math.pi
_FLAKE_SCATTER, _DROP_SCATTER = _SPHERE_SCATTER / 3, _SPHERE_SCATTER / 20
_BEAM_SPANS = np.array([-0.9, 0.9, -0.35, 0.25])  # of the beam tables: camera.light.BEAM_TAN_H, BEAM_TAN_V
_NEAREST_M = 0.4  # nearer drops are blurred away, or do not pass the windscreen
_MIN_WIDTH_PX = 0.35  # narrower streaks are left to the extinction
_MIN_WIDTH_AT_PX = 800.0  # for pictures wider than this the least width grows in proportion
_BRIGHTNESS = 0.95  # of the wide field that a drop refracts into the lens (Garg and Nayar, 2007)
_SAMPLE_STEP_PX = 8


class Pose(Protocol):
    """What rain must know of a camera: place, world-to-camera rotation (x right, y down, z ahead), optics, lens."""

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
    @property
    def lens(self) -> str: ...  # noqa: D102
    @property
    def distortion(self) -> tuple[float, ...]: ...  # noqa: D102


def drop_density_per_m3_mm(diameter_mm: float, rain_mm_h: float) -> float:
    """Drops per m3 and mm of diameter: 8000 exp(-4.1 R^-0.21 D) (Marshall and Palmer, 1948)."""
    return 8000.0 * math.exp(-_slope_per_mm(rain_mm_h) * diameter_mm) if rain_mm_h > 0 else 0.0


def fall_speed_mps(diameter_mm: float) -> float:
    """Terminal speed of a drop: 9.65 - 10.3 exp(-0.6 D) (Atlas et al., 1973)."""
    return 9.65 - 10.3 * math.exp(-0.6 * diameter_mm)


def _slope_per_mm(rain_mm_h: float) -> float:
    return 4.1 * rain_mm_h**-0.21


def flake_density_per_m3_mm(diameter_mm: float, snow_mm_h: float) -> float:
    """Flakes per m3 and mm of diameter.

    Gunn and Marshall (1958): 3800 R^-0.87 exp(-2.55 R^-0.48 d) over the diameter d of the melted drop. A flake of
    diameter D has the density 0.178 D^-0.922 g/cm3 (Brandes et al., 2007), hence D = 2.295 d^1.444.
    """
    return math.exp(_log_flake_density(diameter_mm, snow_mm_h)) if snow_mm_h > 0 and diameter_mm > 0 else 0.0


def _log_flake_density(diameter_mm: float, snow_mm_h: float) -> float:
    melted_mm = (diameter_mm / _FLAKE_MM) ** (1 / _FLAKE_POWER)
    stretch = melted_mm / (_FLAKE_POWER * diameter_mm)
    return math.log(3800.0 * snow_mm_h**-0.87 * stretch) - 2.55 * snow_mm_h**-0.48 * melted_mm


def flake_speed_mps(diameter_mm: float) -> float:
    """Fall speed of an aggregate: 0.8 D^0.16 (Locatelli and Hobbs, 1974)."""
    return 0.8 * diameter_mm**0.16


@dataclass(frozen=True, slots=True)
class _Drops:
    """Classes of sizes (K,): range, number per m3, speed, slope of the density within the class; and their looks."""

    low_mm: np.ndarray
    high_mm: np.ndarray
    per_m3: np.ndarray
    speed_mps: np.ndarray
    slope_per_mm: np.ndarray
    brightness: float
    scatter: float
    least_px: float
    sway_m: float
    key: np.uint64


def _raindrops(rain_mm_h: float, key: np.uint64) -> _Drops:
    edges = np.linspace(_SMALLEST_MM, _LARGEST_MM, _CLASSES + 1)
    low, high = edges[:-1].copy(), edges[1:].copy()
    slope = _slope_per_mm(rain_mm_h)
    below = np.array([math.exp(-slope * edge) for edge in edges])
    # Mean diameter of the class: all its drops fall at one speed, as its cells do. In a trace of rain the density of
    # large drops is less than a number can tell: only its ratio across the class is used.
    steep = np.exp(-slope * (high - low))
    mean_mm = low + 1.0 / slope - (high - low) * steep / (1.0 - steep)
    return _Drops(
        low, high, 8000.0 / slope * (below[:-1] - below[1:]), np.array([fall_speed_mps(d) for d in mean_mm]),
        np.full(_CLASSES, slope), _BRIGHTNESS, _DROP_SCATTER, _MIN_WIDTH_PX, 0.0, key,
    )  # fmt: skip


def _flakes(snow_mm_h: float, key: np.uint64) -> _Drops:
    edges = np.geomspace(_SMALLEST_FLAKE_MM, _LARGEST_FLAKE_MM, _CLASSES + 1)
    low, high = edges[:-1].copy(), edges[1:].copy()
    # Within a class the density is taken as exponential between its edges; in a trace of snow that of large flakes is
    # less than a number can tell, its logarithm is not.
    log_density = np.array([_log_flake_density(edge, snow_mm_h) for edge in edges])
    slope = -np.diff(log_density) / (high - low)
    number = -np.exp(log_density[:-1]) * np.expm1(np.diff(log_density)) / slope
    speed = np.array([flake_speed_mps(d) for d in np.sqrt(low * high)])
    return _Drops(
        low, high, number, speed, slope, _FLAKE_WHITE, _FLAKE_SCATTER, _FLAKE_MIN_WIDTH_PX, _SWAY_M, key
    )  # fmt: skip


@lru_cache(maxsize=16)
def _optics(
    focal_px: float, cx: float, cy: float, size_px: tuple[int, int], lens: str, distortion: tuple[float, ...]
) -> tuple[float, float, float, float, float, int, np.ndarray]:
    """What the kernels must know of a camera's optics, see _rain_kernels.draw_rain."""
    width, height = size_px
    columns, rows = (np.linspace(0.0, n, 33) for n in size_px)
    edge_x = np.concatenate([columns, columns, np.zeros(33), np.full(33, float(width))])
    edge_y = np.concatenate([np.zeros(33), np.full(33, float(height)), rows, rows])
    x, y = undistort(lens, distortion, (edge_x - cx) / focal_px, (edge_y - cy) / focal_px)
    return (
        focal_px,
        cx,
        cy,
        float(np.abs(x).max()),
        float(np.abs(y).max()),
        LENSES.index(lens),
        coefficients(distortion),
    )


class Precipitation:
    """The rain and the snow of one episode.

    Args:
        weather: Its rates and wind; without rain and snow nothing is ever drawn.
        seed: Of the places of drops and flakes.
    """

    def __init__(self, weather: Weather, seed: int) -> None:
        key = seed_key(seed)
        self._wind_mps, self._rain = weather.wind_mps, weather.rain_mm_h > 0
        self._kinds: list[_Drops] = []
        if weather.rain_mm_h > 0:
            self._kinds.append(_raindrops(weather.rain_mm_h, key))
        if weather.snow_mm_h > 0:
            self._kinds.append(_flakes(weather.snow_mm_h, child_key(key, 0x5E0)))

    @property
    def falls(self) -> bool:
        """Whether there is any."""
        return bool(self._kinds)

    @property
    def streaks_per_s(self) -> float:
        """How many of its diameters a drop of 2 mm, or without rain a flake of 5 mm, falls in a second."""
        if self._rain:
            return fall_speed_mps(2.0) / 2e-3
        return flake_speed_mps(5.0) / 5e-3 if self.falls else 0.0

    def draw(
        self,
        frame: Frame,
        pose: Pose,
        time_s: float,
        exposure_s: float,
        ego_velocity_mps: float,
        depth: np.ndarray | None = None,
        beam: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> int:
        """Draw the drops and flakes that cross the view during an exposure centred on ``time_s``, in place.

        A drop of diameter D at depth z is a streak D f / z wide and as long as its motion relative to the
        camera. It covers each pixel under it for the share width / (width + length) of the exposure
        (Garg and Nayar), so long exposures make long and faint streaks. Its brightness is 0.95 of
        the mean of the horizon sky's and the picture's luminance. Flakes, which sway as they fall, are drawn
        alike, with 0.9 of that mean. What is some pixels wide is a soft disc on its way, out of focus where it is near.
        Consecutive exposures that touch leave no gaps, so an event camera should pass the time between two renders.

        The lens bends streaks as it bends the scene: their ends and widths go through its formulas.

        What is narrower than a fraction of a pixel is left to the extinction; a drop that comes nearer fades in.

        Args:
            frame: Its luminance and, if there, its radiance are changed.
            pose: Of the camera at ``time_s``.
            time_s: Time since reset.
            exposure_s: 0 or more.
            ego_velocity_mps: Speed of the camera along its optical axis.
            depth: (H, W) float32 used where the frame has none, such as that of the last full frame; without
                both, nothing hides the rain.
            beam: Candela table and place of the ego's headlights, see Renderer.own_beam.

        Returns:
            How many streaks were drawn.
        """
        require(exposure_s >= 0, "exposure_s", exposure_s, "0 or more")
        if not self._kinds:
            return 0
        depth = frame.depth if frame.depth is not None else depth
        no_depth, no_radiance = np.empty((0, 0), np.float32), np.empty((0, 0, 0), np.float32)
        sample = frame.luminance[
            _SAMPLE_STEP_PX // 2 :: _SAMPLE_STEP_PX, _SAMPLE_STEP_PX // 2 :: _SAMPLE_STEP_PX
        ]
        around = float(np.mean(sample, dtype=np.float64)) if sample.size else frame.airlight
        coarse = max(1.0, pose.width_px / _MIN_WIDTH_AT_PX)
        size = (int(pose.width_px), int(pose.height_px))
        optics = _optics(
            float(pose.focal_px), float(pose.cx), float(pose.cy), size, pose.lens, tuple(pose.distortion)
        )
        table, place = (np.empty((0, 0), np.float32), np.empty(0)) if beam is None else beam
        drawn = 0
        for kind in self._kinds:
            drawn += int(
                kernels.draw_rain(
                    frame.luminance,
                    no_radiance if frame.radiance is None else frame.radiance,
                    no_depth if depth is None else depth,
                    np.ascontiguousarray(pose.origin, np.float64),
                    np.ascontiguousarray(pose.rotation, np.float64),
                    optics,
                    float(time_s), float(exposure_s), float(ego_velocity_mps), float(self._wind_mps),
                    kind.low_mm, kind.high_mm, kind.per_m3, kind.speed_mps, kind.slope_per_mm,
                    kind.least_px * coarse, _NEAREST_M, np.float32(kind.brightness * 0.5 * (frame.airlight + around)),
                    (kind.scatter, table, _BEAM_SPANS, place), kind.sway_m, kind.key,
                )
            )  # fmt: skip
        return drawn
