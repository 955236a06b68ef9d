"""Lenses that distort: where a ray's picture falls, and the resampling of a pinhole's picture to a lens's.

The street is drawn by a pinhole (straight edges stay straight, so coverage stays exact) whose picture is large enough to hold
all that the lens sees; every pixel of the lens is then the mean over its footprint in that picture. Between the
pinhole's pixels radiance is interpolated linearly, which blurs by up to half a pixel; depth and ids are taken from
the nearest pixel. A lens costs the larger render and the resampling: about twice a frame for a dashcam's
k1 = -0.3, ten times for a fisheye of 116 degrees.

The formulas are those of pedcross_env.optics.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from pedcross_env.camera.kernels.resample import resample
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import Frame
from pedcross_env.errors import ConfigError
from pedcross_env.optics import undistort

__all__ = ["Lens", "lens_of"]

_LARGEST_PX = 4096
_MOST_SAMPLES = 6  # of a pixel, along each of its sides
_SLACK_PX = 0.3  # samples may be this much farther apart than a pixel: linear interpolation reaches two


@dataclasses.dataclass(frozen=True, slots=True)
class Lens:
    """How a pinhole's picture becomes the lens's.

    Attributes:
        view: The pinhole that has to be rendered, on the same mount.
        places: (6, H, W) float32: column and row in its picture of each pixel's centre (continuous), and how these change
            along the pixel's width (2) and height (2).
        samples: (2, H, W) uint8 how many samples a pixel takes along its width and its height.
        nearest: (H, W) int32 index into the flattened picture.
    """

    view: CameraConfig
    places: np.ndarray
    samples: np.ndarray
    nearest: np.ndarray

    def apply(self, frame: Frame) -> Frame:
        """Return the lens's picture of what ``frame``, a render by ``view``, shows."""
        shape = self.nearest.shape
        if frame.radiance is None or frame.depth is None or frame.instance is None:
            luminance = np.empty((1, *shape), np.float32)
            resample(frame.luminance[None], self.places, self.samples, luminance)
            return Frame(luminance[0], None, None, None, frame.airlight)
        radiance = np.empty((3, *shape), np.float32)
        resample(frame.radiance, self.places, self.samples, radiance)
        luminance = np.float32(0.2126) * radiance[0]
        luminance += np.float32(0.7152) * radiance[1]
        luminance += np.float32(0.0722) * radiance[2]
        depth, instance = (plane.reshape(-1)[self.nearest] for plane in (frame.depth, frame.instance))
        return Frame(luminance, radiance, depth, instance, frame.airlight)


def lens_of(config: CameraConfig) -> Lens | None:
    """Prepare the resampling of ``config``'s lens, None for a pinhole.

    Raises:
        ConfigError: Where the picture holds pixels no ray reaches (the distortion folds), or more than 150 degrees.
    """
    if config.lens == "pinhole":
        return None
    w, h, f = config.width_px, config.height_px, config.focal_px
    cx, cy = config.principal_point[0] * w, config.principal_point[1] * h
    # corners of all pixels: the rays at the edges are what the pinhole must hold
    rows, columns = np.mgrid[0 : h + 1, 0 : w + 1].astype(np.float64)
    x, y = undistort(config.lens, config.distortion, (columns - cx) / f, (rows - cy) / f)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ConfigError(
            f"distortion = {config.distortion} is not allowed for lens = {config.lens!r} and horizontal_fov_deg = "
            f"{config.horizontal_fov_deg}: no ray reaches the picture's corners; use smaller coefficients or a narrower view."
        )
    left, right, above, below = (float(np.abs(e).max()) for e in (x[:, 0], x[:, -1], y[0], y[-1]))
    half_w, half_h = max(float(np.abs(x).max()), left, right), max(float(np.abs(y).max()), above, below)
    focal = min(f, 0.5 * (_LARGEST_PX - 8) / max(half_w, half_h))
    wide, tall = 2 * (math.ceil(half_w * focal) + 2), 2 * (math.ceil(half_h * focal) + 2)
    fov_deg = 2 * math.degrees(math.atan(0.5 * wide / focal))
    if fov_deg > 150:
        raise ConfigError(
            f"lens = {config.lens!r} with horizontal_fov_deg = {config.horizontal_fov_deg} sees {fov_deg:.0f} degrees; allowed: 150."
        )
    view = dataclasses.replace(
        config, width_px=max(16, wide), height_px=max(16, tall), horizontal_fov_deg=fov_deg, principal_point=(0.5, 0.5),
        lens="pinhole", distortion=(),
    )  # fmt: skip
    u, v = 0.5 * view.width_px + view.focal_px * x, 0.5 * view.height_px + view.focal_px * y
    places = np.empty((6, h, w), np.float32)
    for k, plane in enumerate((u, v)):
        a, b, c, d = plane[:-1, :-1], plane[:-1, 1:], plane[1:, :-1], plane[1:, 1:]
        places[k] = 0.25 * (a + b + c + d)
        places[2 + k] = 0.5 * (b + d - a - c)
        places[4 + k] = 0.5 * (c + d - a - b)
    lengths = np.sqrt(np.stack([places[2] ** 2 + places[3] ** 2, places[4] ** 2 + places[5] ** 2]))
    samples = np.clip(np.ceil(lengths - _SLACK_PX), 1, _MOST_SAMPLES).astype(np.uint8)
    column = np.clip(np.floor(places[0]), 0, view.width_px - 1).astype(np.int32)
    row = np.clip(np.floor(places[1]), 0, view.height_px - 1).astype(np.int32)
    return Lens(view, places, samples, row * np.int32(view.width_px) + column)
