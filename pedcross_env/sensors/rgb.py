"""The RGB camera: automatic exposure with its lag, photon and read noise, clipping, gamma, 8 bit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pedcross_env.config import RgbConfig, require
from pedcross_env.contracts import Frame
from pedcross_env.hashing import child_key, seed_key
from pedcross_env.sensors import _rgb_kernels as kernels

__all__ = ["RgbState", "expose", "exposure_time_s", "initial_rgb_state", "metered_white"]

_MID_GREY = 0.18  # where the logarithmic mean is put, as a share of white
_BRIGHT = 0.9  # where the bright percentile is put
_BRIGHT_SHARE = 0.005  # of the picture that may be brighter than the bright percentile
_METER_STEP_PX = 4
_BLOOM_CELL_AT_450_PX = 4
_METER_FLOOR_CD_M2 = 1e-3  # darker than what the camera can see counts as this


def _srgb_table() -> np.ndarray:
    """8-bit sRGB code (IEC 61966-2-1) of each value of a 12-bit converter."""
    linear = np.arange(kernels.ADC_MAX + 1) / kernels.ADC_MAX
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * coded).astype(np.uint8)


_SRGB = _srgb_table()


@dataclass(frozen=True, slots=True)
class RgbState:
    """What the camera remembers between frames.

    Attributes:
        white_cd_m2: Luminance of white that the exposure has settled on, None before the first frame.
        frame: Number of frames taken, part of the noise's key.
    """

    white_cd_m2: float | None
    frame: int


def initial_rgb_state(config: RgbConfig) -> RgbState:
    """Return the state before the first frame; an automatic exposure adapts to that one at once."""
    return RgbState(white_cd_m2=config.fixed_white_cd_m2 if config.exposure == "fixed" else None, frame=0)


def metered_white(luminance: np.ndarray, config: RgbConfig) -> float:
    """Luminance of white that the exposure meter asks for, cd/m2.

    Half way, in logarithms, between two wishes: the logarithmic mean at mid-grey (18 % of white), which a
    bright sky hardly moves, and the brightest half per cent just below white, which keeps highlights.

    Args:
        luminance: (H, W) float32, cd/m2.
        config: Gives the darkest white, where the gain ends.
    """
    sample = luminance[_METER_STEP_PX // 2 :: _METER_STEP_PX, _METER_STEP_PX // 2 :: _METER_STEP_PX].ravel()
    if sample.size == 0:
        sample = luminance.ravel()
    sample = np.maximum(sample, np.float32(_METER_FLOOR_CD_M2))
    rank = min(sample.size - 1, int((1 - _BRIGHT_SHARE) * sample.size))
    bright = float(np.partition(sample, rank)[rank])
    white_of_mean = math.exp(kernels.mean_log(sample)) / _MID_GREY
    white = math.sqrt(white_of_mean * bright / _BRIGHT)
    return max(white, config.base_white_cd_m2 / config.max_gain)


def exposure_time_s(state: RgbState, config: RgbConfig) -> float:
    """How long the shutter will be open for the next frame (streaks, blur); longest before the first."""
    if state.white_cd_m2 is None:
        return config.longest_exposure_s
    return config.longest_exposure_s * min(1.0, config.base_white_cd_m2 / state.white_cd_m2)


def expose(
    state: RgbState, frame: Frame, dt_s: float, config: RgbConfig, seed: int
) -> tuple[RgbState, np.ndarray]:
    """Take a picture.

    The exposure was decided by the frames before, as in a real camera; this frame decides the next one's.
    Electrons at white: full_well_e / gain with gain = max(1, base_white / white). Each value gets noise of
    variance electrons + read_noise_e ** 2 from a hash of (seed, frame, pixel), then a 12-bit converter that
    clips at white, then sRGB. Before that, saturated pixels spill the share ``bloom`` of what exceeds two whites over
    those around them (within ten pixels at a width of 450).

    Args:
        state: Unchanged.
        frame: With radiance.
        dt_s: Time since the last picture, 0 or more.
        config: The camera.
        seed: Of the noise.

    Returns:
        The new state and (H, W, 3) uint8, RGB.

    Raises:
        ConfigError: For a frame without radiance, or a negative ``dt_s``.
    """
    if frame.radiance is None:
        require(False, "frame.radiance", None, "(3, H, W) float32: render the full frame, not luminance only")
    require(dt_s >= 0, "dt_s", dt_s, "0 or more")
    metered = (
        metered_white(frame.luminance, config) if config.exposure == "auto" else config.fixed_white_cd_m2
    )
    white = metered if state.white_cd_m2 is None else state.white_cd_m2
    well_e = config.full_well_e * min(1.0, white / config.base_white_cd_m2)
    image = np.empty((*frame.luminance.shape, 3), np.uint8)
    radiance = np.ascontiguousarray(frame.radiance, np.float32)
    cell, glow, lit = _bloom(radiance, white, config)
    key = int(child_key(seed_key(seed), state.frame))
    kernels.develop(
        radiance, np.float32(well_e / white), np.float32(well_e),
        np.float32(config.read_noise_e**2), config.noise, np.uint32(key & 0xFFFFFFFF), np.uint32(key >> 32),
        _SRGB, glow, lit, cell, image.reshape(len(image), -1),
    )  # fmt: skip
    share = 1.0 - math.exp(-dt_s / config.adaptation_s) if config.adaptation_s > 0 else 1.0
    following = math.exp(math.log(white) + share * (math.log(metered) - math.log(white)))
    return RgbState(white_cd_m2=following, frame=state.frame + 1), image


def _bloom(radiance: np.ndarray, white: float, config: RgbConfig) -> tuple[int, np.ndarray, np.ndarray]:
    """What saturated pixels spill: cell size in pixels, (3, rows of cells, W) and which rows have any; or no rows."""
    height, width = radiance.shape[1:]
    cell = max(2, round(_BLOOM_CELL_AT_450_PX * width / 450))
    if config.bloom > 0:
        rows, columns = -(-height // cell), -(-width // cell)
        cells, glow = (np.empty((3, rows, n), np.float32) for n in (columns, width))
        work, lit = np.empty((3, max(width, rows)), np.float32), np.empty(rows, np.bool_)
        if kernels.bloom(radiance, np.float32(white), np.float32(config.bloom), cell, work, cells, glow, lit):
            return cell, glow, lit
    return cell, np.empty((3, 0, 0), np.float32), np.empty(0, np.bool_)
