"""A street's standing things as tables: houses, trees, lamps, furniture, the ground's profiles; cached per street."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pedcross_env.camera.models import registered
from pedcross_env.camera.props import FURNITURE
from pedcross_env.camera.scenery.buildings import BUILDINGS, building_rows
from pedcross_env.camera.scenery.ends import closing_rows
from pedcross_env.camera.scenery.foliage import crown_textures
from pedcross_env.camera.scenery.furniture import Props, standing_things
from pedcross_env.camera.scenery.lamps import lamp_maps
from pedcross_env.camera.scenery.profiles import (
    ACROSS_TEXEL_M,
    ALONG_MARGIN_M,
    ALONG_TEXEL_M,
    GROUND_TEXEL_M,
    across_profiles,
    along_profiles,
    grain_integral,
)
from pedcross_env.camera.scenery.shadows import sun_shear, tree_shadow_capsules
from pedcross_env.scenario.street import StreetSpec

__all__ = [
    "ACROSS_TEXEL_M", "ALONG_MARGIN_M", "ALONG_TEXEL_M", "GROUND_TEXEL_M", "Props", "Scenery", "crown_textures", "grain_integral", "scenery_of",
    "sun_shear", "tree_shadow_capsules",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Scenery:
    """Static tables of one street.

    Attributes:
        panels: (P, PANEL_SIZE) facades, see kernels.facade.
        capsules: (K, CAPSULE_SIZE) world coordinates.
        groups: (G, GROUP_SIZE) what belongs together, see trees.GROUP_SIZE.
        lamps: (L, 3) positions.
        ground_lamp_map: (rows over y, columns over x) lx at 1 tint, and its frame (start x, start y, step).
        front_lamp_maps: (2, rows over height, columns over x) on the right and the left fronts.
        map_frame: (start x, step) of the latter.
        along: (N, 3) running integrals along x of dashes, zebra and stop lines.
        low: (M, 8) running integrals across the road: cover, r, g, b, lines, dash, zebra, stop.
        high: (M, 8) the same beyond the kerbs.
        across_low: y of the first row of ``low`` and ``high``.
        tree_shadows: (S, 7) of crowns and furniture: centre, half width, half height, strength, softness.
        props: Furniture and roofs.
    """

    panels: np.ndarray
    capsules: np.ndarray
    groups: np.ndarray
    lamps: np.ndarray
    ground_lamp_map: np.ndarray
    ground_frame: np.ndarray
    front_lamp_maps: np.ndarray
    map_frame: np.ndarray
    along: np.ndarray
    low: np.ndarray
    high: np.ndarray
    across_low: float
    tree_shadows: np.ndarray
    props: Props


def scenery_of(street: StreetSpec, *, loose: bool = True) -> Scenery:
    """Build (or recall) the tables of a street; everything that is only looks follows from ``street.seed``.

    Args:
        street: A straight one.
        loose: Whether there may be gardens between houses, fronts that stand back, and houses across the ends.
    """
    return _built(street, loose, (registered(), tuple(FURNITURE), tuple(BUILDINGS)))


@lru_cache(maxsize=8)
def _built(street: StreetSpec, loose: bool, registries: object) -> Scenery:
    """Build a street; what was registered in between makes it another one."""
    house_rng, furniture_rng = np.random.default_rng([street.seed & 0xFFFFFFFF, 11]).spawn(2)
    rows = building_rows(street, house_rng, loose)
    things = standing_things(street, rows, furniture_rng)
    panels = np.concatenate([rows.panels, closing_rows(rows.panels, street)]) if loose else rows.panels
    low, high, across_low = across_profiles(street)
    ground, ground_frame, fronts, map_frame = lamp_maps(street, things.lamps)
    return Scenery(
        panels, things.capsules, things.groups, things.lamps, ground, ground_frame, fronts, map_frame, along_profiles(street),
        low, high, across_low, things.shadows, things.props,
    )  # fmt: skip
