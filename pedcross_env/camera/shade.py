"""Shade of the houses: on the ground, and on what stands and moves in it."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.scene import LEVELS, NODES
from pedcross_env.camera.kernels.shade import shade_heights, sunlit_actors, sunlit_shares
from pedcross_env.camera.kernels.shadows import MAX_EDGES
from pedcross_env.camera.light import Light
from pedcross_env.camera.scenery import Scenery, sun_shear
from pedcross_env.contracts import StaticClass

__all__ = ["Shade"]

RANGE_M = 160.0  # beyond it the ground between the houses is lower than a pixel
OVERLAP_M = 0.3  # of the shadows of neighbours: a seam between two soft edges would be light
PENUMBRA = 2 * math.tan(math.radians(0.2666))  # of the sun's disc, per metre of way
ANGLE_SLACK = 1e-3  # sine below which the sun grazes along a wall
TO_SUN, DARK = 0.0, 1.0
CLEARANCE_M = 0.05


class Shade:
    """What the houses of one street shade under one sun.

    A house is solid, so a ray from a point of the street enters it through a wall that faces that point: the walls turned
    away from the sun cast all of its shadow. Things above ground are lit by the share of their height that the sun reaches; on
    facades the edge of the shade is seen.

    Args:
        scenery: The street's standing things.
        light: With a sun that shines, or without: then nothing is shaded.

    Attributes:
        walls: Those that shade, and the sun, as kernels.shade takes them.
        groups: (G,) shares of the static groups that the sun reaches.
        panels: (P,) of facades: 0, 1, or between where the edge of the shade crosses one.
        edges: (P, NODES + LEVELS) float32: how high up the shade reaches at places evenly along each, m; the shares of it
            above the shade at heights evenly up it.
        props: (R,) of furniture; roofs rise above all shade.
    """

    def __init__(self, scenery: Scenery, light: Light) -> None:
        x, y, rise = (float(v) for v in light.sun_direction)
        across = math.hypot(x, y)
        self._walls = np.zeros((0, 5))
        self._sun = np.array([1.0, 0.0, 1.0])
        if light.sun_lx[1] > 0 and across > 1e-6:
            self._sun = np.array([x / across, y / across, rise / across])
            self._walls = _casting(scenery.panels, self._sun)
        self.walls = self._walls, self._sun
        self._polygons, self._info = _on_ground(self._walls, sun_shear(light.sun_direction))
        groups, props = scenery.groups, scenery.props
        crowned = groups[:, 7] >= 0
        half = np.where(crowned, np.abs(groups[:, 11]), groups[:, 5])
        middle, rises = (np.where(crowned, groups[:, k], groups[:, n]) for k, n in ((10, 4), (12, 5)))
        self.groups = self._shares(
            np.stack([groups[:, 2], groups[:, 3], middle - rises, middle + rises, half], axis=1)
        )
        heights = self._on_panels(scenery.panels)
        top = np.maximum(scenery.panels[:, 7, None], 0.1)
        self.panels = (1.0 - np.clip(heights / top, 0.0, 1.0)).mean(axis=1)
        levels, step = top * np.linspace(0.0, 1.0, LEVELS), top / (LEVELS - 1)
        above = [np.clip(0.5 + (level[:, None] - heights) / step, 0, 1).mean(axis=1) for level in levels.T]
        self.edges = np.ascontiguousarray(
            np.concatenate([heights, np.stack(above, axis=1)], axis=1), np.float32
        )
        self.props = np.where(props.idents[:, 0] == StaticClass.BUILDING, 1.0, self.on_actors(props.numbers))

    def near(self, low: np.ndarray, size_m: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the shadows on the ground around a square: (W, MAX_EDGES, 3) and (W, 8) float32 of kernels.ground_light.

        Args:
            low: (2,) its corner of least x and y.
            size_m: Of its sides.
        """
        info, seen = self._info, np.ones(len(self._info), bool)
        for k in range(2):
            seen &= (info[:, 2 * k] < low[k] + size_m + RANGE_M) & (info[:, 2 * k + 1] > low[k] - RANGE_M)
        return self._polygons[seen], info[seen]

    def on_actors(self, numbers: np.ndarray) -> np.ndarray:
        """Return the shares of actors that the sun reaches: (N,).

        Args:
            numbers: (N, 14) as kernels.scene.
        """
        shares = np.ones(len(numbers))
        if len(self._walls):
            sunlit_actors(self._walls, self._sun, numbers, shares)
        return shares

    def _shares(self, places: np.ndarray) -> np.ndarray:
        shares = np.ones(len(places))
        if len(self._walls):
            sunlit_shares(self._walls, self._sun, places, shares)
        return shares

    def _on_panels(self, panels: np.ndarray) -> np.ndarray:
        edges = np.full((len(panels), NODES), -1.0, np.float32)
        if len(self._walls):
            step = panels[:, 6, None] * np.linspace(0.0, 1.0, NODES)
            # from just before the front, so that it does not shade itself
            x = panels[:, 0, None] + panels[:, 3, None] * step + CLEARANCE_M * panels[:, 4, None]
            y = panels[:, 1, None] + panels[:, 4, None] * step - CLEARANCE_M * panels[:, 3, None]
            places = np.stack([x, y, np.broadcast_to(panels[:, 2, None], x.shape)], axis=-1)
            shade_heights(self._walls, self._sun, places.reshape(-1, 3), OVERLAP_M, edges.reshape(-1))
        return edges


def _casting(panels: np.ndarray, sun: np.ndarray) -> np.ndarray:
    """(W, 5) ends and height of the walls turned away from the sun; one that stands on a lower wall reaches to the ground."""
    # a panel is seen from the right-hand side of its axis
    outward = panels[:, 4] * sun[0] - panels[:, 3] * sun[1]
    away = panels[outward < -ANGLE_SLACK]
    ends = away[:, :2] + away[:, 3:5] * away[:, 6, None]
    return np.ascontiguousarray(
        np.concatenate([away[:, :2], ends, (away[:, 2] + away[:, 7])[:, None]], axis=1)
    )


def _on_ground(walls: np.ndarray, shear: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Shadows of walls as polygons: inward normals and offsets; their boxes, edges, softness, strength and target."""
    polygons, info = np.zeros((len(walls), MAX_EDGES, 3), np.float32), np.zeros((len(walls), 8), np.float32)
    for k, (x0, y0, x1, y1, height) in enumerate(walls):
        along = np.array([x1 - x0, y1 - y0]) * OVERLAP_M / math.hypot(x1 - x0, y1 - y0)
        foot = np.array([[x0, y0], [x1, y1]]) + along * np.array([[-1.0], [1.0]])
        corners = np.concatenate([foot, foot[::-1] + height * np.array(shear)])
        soft = 0.5 * PENUMBRA * height * math.hypot(1.0, *shear)
        edges = np.roll(corners, -1, axis=0) - corners
        inward = np.stack([-edges[:, 1], edges[:, 0]], axis=1)
        inward /= np.hypot(inward[:, 0], inward[:, 1])[:, None]
        inward *= np.sign(inward[0] @ (corners[2] - corners[0]))  # whichever way round the corners run
        polygons[k, :4, :2], polygons[k, :4, 2] = inward, -(inward * corners).sum(axis=1)
        (x_low, y_low), (x_high, y_high) = corners.min(axis=0) - soft, corners.max(axis=0) + soft
        info[k] = x_low, x_high, y_low, y_high, 4, soft, DARK, TO_SUN
    return polygons, info
