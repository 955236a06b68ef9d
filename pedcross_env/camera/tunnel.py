"""The end of a tunnel: the street is dark up to its exit and as bright as ever beyond it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pedcross_env.camera.kernels.tunnel import enclose
from pedcross_env.camera.light import LUMA, Light
from pedcross_env.camera.pinhole import CameraPose
from pedcross_env.camera.scenery import Scenery
from pedcross_env.contracts import StaticClass
from pedcross_env.errors import ConfigError
from pedcross_env.scenario.street import StreetSpec

__all__ = ["TUNNEL_LX", "Tunnel", "cleared", "require_straight"]

TUNNEL_LX = 75.0  # of the lamps: some 2 to 6 cd/m2 on the road, an interior zone of CIE 88:2004
HEIGHT_M = 5.2
WALL_ALBEDO, CEILING_ALBEDO = 0.45, 0.2
INSET_M = 0.3  # from the house fronts, which the walls hide


def require_straight(street: StreetSpec) -> None:
    """Refuse a tunnel around a street that bends or crosses another.

    Raises:
        ConfigError: Names the remedy.
    """
    if not street.straight:
        raise ConfigError(
            "weather.tunnel_exit_m is set and the street bends or crosses another: tunnels are straight; "
            "take a straight street, or weather.tunnel_exit_m = -inf (a weather without a tunnel)."
        )


def cleared(scenery: Scenery, exit_m: float) -> Scenery:
    """Return ``scenery`` without the trees and posts that would stand inside."""
    keep = scenery.groups[:, 2] > exit_m + 1.5 if len(scenery.groups) else np.zeros(0, bool)
    lamps = scenery.lamps[scenery.lamps[:, 0] > exit_m] if len(scenery.lamps) else scenery.lamps
    crowns = scenery.tree_shadows[scenery.tree_shadows[:, 0] > exit_m + 1.5]
    return replace(
        scenery, groups=np.ascontiguousarray(scenery.groups[keep]), lamps=lamps, tree_shadows=crowns
    )  # fmt: skip


class Tunnel:
    """Encloses the carriageway and its sidewalks for all x below the exit.

    Lamps light it evenly; daylight comes in as the portal is seen from the road and the walls (the ceiling as the road),
    see kernels.tunnel.daylight_share. What is inside keeps its shading and is dimmed as a whole.

    Args:
        street: A straight one.
        exit_m: x of the portal.
    """

    def __init__(self, street: StreetSpec, exit_m: float) -> None:
        wall = street.facade_y_m - INSET_M
        self._shape = (float(exit_m), -wall, wall, HEIGHT_M)

    def enclose(
        self,
        out: np.ndarray,
        luminance: np.ndarray,
        depth: np.ndarray,
        ids: np.ndarray,
        pose: CameraPose,
        light: Light,
    ) -> None:
        """Change a finished picture in place; see kernels.tunnel."""
        outside = float(
            (light.sky_lx * LUMA).sum() + max(0.0, light.sun_direction[2]) * (light.sun_lx * LUMA).sum()
        )
        lit = (max(outside, TUNNEL_LX), TUNNEL_LX, WALL_ALBEDO, CEILING_ALBEDO, float(StaticClass.BUILDING))
        optics = (pose.focal_px, pose.cx, pose.cy)
        enclose(out, luminance, depth, ids, pose.rotation, pose.origin, optics, self._shape, lit)
