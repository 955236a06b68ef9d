"""Glare: what lens and windscreen scatter of the sun and of lamps onto the rest of the picture.

It is optics, so every sensor behind the lens sees it. The strength is that of a clean automotive camera behind a clean
windscreen: k = 3 (cd/m2)/lx deg2, where the eye's is 10 (Stiles and Holladay; CIE 146:2002). From half a degree
outwards this scatters 3 % of the light, a usual veiling glare index (ISO 9358).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pedcross_env.camera.kernels.glare import add_sun_disc, add_veil, gather_sources, sky_share
from pedcross_env.camera.light import LUMA, Light
from pedcross_env.camera.pinhole import CameraPose

__all__ = ["GLARE_LX_DEG2", "Glare"]

GLARE_LX_DEG2 = 3.0
SUN_RADIUS_RAD = math.radians(0.266)
BRIGHTER = 3.0  # than white paper in the scene's light: what is worth its own veil
LAMPS_LX, BEAM_LX = 15.0, 15.0  # light of lamps and headlights that white paper may have at night
STEP_AT_450_PX = 8
CORE_STEPS = 1.25
BORDER = 0.15  # of the image's width, over which a source that leaves the view loses its hold on the lens
OUTSIDE = 0.25  # of the image's width beyond its border, over which the sun loses its hold on the lens


@dataclass(slots=True)
class _Work:
    sources: np.ndarray
    nodes: np.ndarray
    line: np.ndarray
    top: np.ndarray


class Glare:
    """Adds the sun's disc and the veils of sun and lamps to pictures of one size.

    Nothing is done where the weather has neither a sun before the lens nor lamps: such pictures cost nothing.

    Args:
        width_px: Columns.
        height_px: Rows.
    """

    def __init__(self, width_px: int, height_px: int) -> None:
        self._step = max(4, round(STEP_AT_450_PX * width_px / 450))
        self._sunny = self._lamps = False
        self._sun_direction, self._sun_lx = [0.0, 0.0, 0.0], np.zeros(3)
        self._threshold = math.inf
        rows, columns = height_px // self._step + 2, width_px // self._step + 2
        cells = (rows + 1) * (columns + 1)
        self._work = _Work(
            np.zeros((cells + 1, 5)), np.zeros((3, rows, columns), np.float32), np.zeros(columns, np.float32),
            np.zeros(width_px, np.float32),
        )  # fmt: skip

    def load(self, light: Light) -> None:
        """Take a weather's light, without lightning, so that a flash does not change what counts as bright."""
        self._sun_direction, self._sun_lx = light.sun_direction.tolist(), light.sun_lx
        self._sunny = bool(light.sun_lx.sum() > 0)
        street = bool(light.lamp_lx.sum() > 0)
        self._lamps = street or light.beam_on
        day = (light.sky_lx + max(0.0, light.sun_direction[2]) * light.sun_lx) * LUMA
        white = (float(day.sum()) + LAMPS_LX * street + BEAM_LX * light.beam_on) / math.pi
        self._threshold = BRIGHTER * white

    def add(self, out: np.ndarray, luminance: np.ndarray, alpha: np.ndarray, pose: CameraPose) -> None:
        """Add glare in place, of the light of ``load``: none before it.

        Args:
            out: (C, H, W) radiance, C = 3, or C = 1: ``luminance`` itself.
            luminance: (H, W).
            alpha: (H, W) share of each pixel that objects cover, the ground and the sky left out.
            pose: Of the camera.
        """
        sun = self._sun(alpha, pose)
        if sun is None and not self._lamps:
            return
        work, count = self._work, 0
        if self._lamps:
            threshold, border = np.float32(self._threshold), BORDER * pose.width_px
            count = gather_sources(out, luminance, threshold, 2 * self._step, border, work.top, work.sources)
        if sun is not None:
            work.sources[count] = sun
            if len(out) == 1:
                work.sources[count, 2] = float((sun[2:] * LUMA).sum())
            count += 1
        if count:
            strength = GLARE_LX_DEG2 * math.radians(1.0) ** 2
            add_veil(
                out, luminance, work.sources, count, strength, CORE_STEPS * self._step, self._step, work.nodes, work.line
            )  # fmt: skip
        if sun is not None:
            radiance = self._sun_lx / (math.pi * SUN_RADIUS_RAD**2)
            add_sun_disc(out, luminance, alpha, sun[0], sun[1], SUN_RADIUS_RAD * pose.focal_px, radiance)

    def dazzled(self, pose: CameraPose) -> bool:
        """Whether there can be any glare: lamps, an own beam, or the sun before the lens."""
        return self._lamps or self._sun_place(pose)[2] > 0

    def _sun(self, alpha: np.ndarray, pose: CameraPose) -> np.ndarray | None:
        """Column, row and light of the sun as a source, or None where it does not shine into the lens."""
        column, row, share = self._sun_place(pose)
        if share > 0:
            share *= sky_share(alpha, column, row, SUN_RADIUS_RAD * pose.focal_px)
        if share <= 0:
            return None
        return np.array([column, row, *(share * pose.focal_px**2 * self._sun_lx)])

    def _sun_place(self, pose: CameraPose) -> tuple[float, float, float]:
        """Column and row of the sun, and which share of its light the lens would catch, were nothing before it."""
        if not self._sunny:
            return 0.0, 0.0, 0.0
        right, down, ahead = pose.turned(self._sun_direction)
        if ahead <= 0.05:
            return 0.0, 0.0, 0.0
        column, row = pose.cx + pose.focal_px * right / ahead, pose.cy + pose.focal_px * down / ahead
        outside = max(-column, column - pose.width_px, -row, row - pose.height_px, 0.0)
        return column, row, max(0.0, 1.0 - outside / (OUTSIDE * pose.width_px))
