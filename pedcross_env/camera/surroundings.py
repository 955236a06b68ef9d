"""How near standing things come to the road, and where shadows fall: what bounds the motion in the picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pedcross_env.camera.kernels.scene import ROOF_KIND
from pedcross_env.camera.layers import Border
from pedcross_env.camera.light import Light
from pedcross_env.camera.scenery import Scenery, sun_shear

__all__ = ["Surroundings", "surroundings_of"]

CLEAR_M = 1.0  # how far from the ends of walls layers part
_ALONG = np.linspace(0.0, 1.0, 5)[:, None]  # of a capsule, where its reach is taken


class Surroundings(NamedTuple):
    """What stands beside a straight road.

    Attributes:
        left_y_m: Nothing that stands above the ground reaches from the left to the right of this.
        right_y_m: The same from the right.
        roofs: (N, 3) from and to along x, and y, of roofs.
        ends: (M, 2) x and y where walls end.
        shadow_per_m: How far a shadow falls per metre of height, along x and y; None without sun.
    """

    left_y_m: float
    right_y_m: float
    roofs: np.ndarray
    ends: np.ndarray
    shadow_per_m: tuple[float, float] | None

    def border(self, x_m: float) -> Border:
        """Return a border across the street at a place along it, or a little beyond where it would cut through a roof."""
        return Border(self._between_roofs(x_m, -1), self._between_roofs(x_m, 1))

    def _between_roofs(self, x_m: float, side: int) -> float:
        """World x, ``CLEAR_M`` beyond the end of what would be cut: where houses touch, colours change within a pixel."""
        roofs = self.roofs[self.roofs[:, 2] * side > 0]
        cut = roofs[(roofs[:, 0] + 2 * CLEAR_M < x_m) & (x_m < roofs[:, 1] + CLEAR_M)]
        x_m = float(cut[:, 1].max(initial=x_m - CLEAR_M)) + CLEAR_M
        ends = self.ends[(self.ends[:, 1] * side > 0) & (np.abs(self.ends[:, 0] - x_m) < CLEAR_M), 0]
        return float(ends.max(initial=x_m - CLEAR_M)) + CLEAR_M


def _beside(panels: np.ndarray) -> np.ndarray:
    """Which walls stand beside a straight road: not those across its ends."""
    along = panels[np.abs(panels[:, 3]) > 0.5]
    tips = np.concatenate([along[:, 0], along[:, 0] + along[:, 3] * along[:, 6]])
    low, high = tips.min(initial=np.inf), tips.max(initial=-np.inf)
    return np.asarray((panels[:, 0] > low - CLEAR_M) & (panels[:, 0] < high + CLEAR_M))


def surroundings_of(scenery: Scenery, light: Light) -> Surroundings:
    """Measure a street's scenery under a light."""
    capsules, crowns, props, panels = scenery.capsules, scenery.groups, scenery.props.numbers, scenery.panels
    crowns = crowns[crowns[:, 7] >= 0]
    panels = panels[_beside(panels)]
    sine, cosine = np.abs(np.sin(props[:, 3])), np.abs(np.cos(props[:, 3]))
    middles = [
        (capsules[:, 1] + _ALONG * (capsules[:, 4] - capsules[:, 1])).reshape(-1), crowns[:, 9], props[:, 1],
        panels[:, 1], panels[:, 1] + panels[:, 4] * panels[:, 6],
    ]  # fmt: skip
    reaches = [
        (capsules[:, 6] + _ALONG * (capsules[:, 7] - capsules[:, 6])).reshape(-1), np.abs(crowns[:, 11]),
        0.5 * (sine * props[:, 6] + cosine * props[:, 7]), np.zeros(len(panels)), np.zeros(len(panels)),
    ]  # fmt: skip
    y, reach = np.concatenate(middles), np.concatenate(reaches)
    left, right = (y - reach)[y > 0], (y + reach)[y <= 0]
    shear = sun_shear(light.sun_direction) if light.sun_lx.sum() > 0 else None
    roofs = props[scenery.props.idents[:, 1] == ROOF_KIND]
    half = 0.5 * (np.abs(np.cos(roofs[:, 3])) * roofs[:, 6] + np.abs(np.sin(roofs[:, 3])) * roofs[:, 7])
    spans = np.stack([roofs[:, 0] - half, roofs[:, 0] + half, roofs[:, 1]], axis=1)
    ends = np.concatenate([panels[:, :2], panels[:, :2] + panels[:, 6:7] * panels[:, 3:5]])
    return Surroundings(left.min(initial=np.inf), right.max(initial=-np.inf), spans, ends, shear)
