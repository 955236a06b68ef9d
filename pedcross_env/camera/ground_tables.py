"""What the general ground kernel reads: the profiles, paint and place of a street of any layout."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pedcross_env.camera.kernels.street_profile import L_CROSSED, L_CURVE, L_HIGH, L_SIDE, LAYOUT_SIZE
from pedcross_env.camera.scenery import (
    ACROSS_TEXEL_M,
    ALONG_MARGIN_M,
    ALONG_TEXEL_M,
    GROUND_TEXEL_M,
    grain_integral,
    scenery_of,
)
from pedcross_env.camera.snow import snowed
from pedcross_env.scenario.layout import side_street
from pedcross_env.scenario.street import StreetSpec

__all__ = ["GroundTables", "ground_tables"]

STOP_GAP_M, STOP_WIDTH_M = 1.2, 0.4


@dataclass(frozen=True, slots=True)
class GroundTables:
    """What ``kernels.street_profile`` reads.

    Attributes:
        layout: (LAYOUT_SIZE,).
        tables: (along, low, high, grain, side along, side low, paint, plain).
    """

    layout: np.ndarray
    tables: tuple[np.ndarray, ...]


def _stop_lines(street: StreetSpec) -> np.ndarray:
    """(M, 6) rectangles of paint on the approaches' own lanes: main or side street, s range, d range, strength."""
    crossing = street.intersection
    if crossing is None or not crossing.stop_lines:
        return np.zeros((0, 6))
    rows = []
    for which, own, other, middle in (
        (0.0, street, crossing.kerb_m, crossing.x_m),
        (1.0, side_street(street), street.kerb_y_m, 0.0),
    ):
        away = other + crossing.corner_radius_m + crossing.crosswalk_width_m + STOP_GAP_M
        lanes = own.lanes_per_direction * own.lane_width_m
        rows.append([which, middle - away - STOP_WIDTH_M, middle - away, -lanes + 0.1, -0.1, 1.0])
        rows.append([which, middle + away, middle + away + STOP_WIDTH_M, 0.1, lanes - 0.1, 1.0])
    return np.array(rows)


def _albedo(low: np.ndarray, across_low_m: float, low_m: float, high_m: float) -> np.ndarray:
    """Mean albedo (3,) of the carriageway between two distances left of the centre line."""
    i, j = (round((d - across_low_m) / ACROSS_TEXEL_M) for d in (low_m, high_m))
    return (low[j, 1:4] - low[i, 1:4]) / np.float32(j - i)


@lru_cache(maxsize=8)
def ground_tables(street: StreetSpec, snow_cover: float = 0.0) -> GroundTables:
    """Return what the general ground kernel needs of a street of any layout, under lying snow where there is some."""
    straight = street.straightened()
    main = scenery_of(straight)
    crossing = street.intersection
    other, side = (straight, main) if crossing is None else (side_street(street), None)
    side = main if side is not None else scenery_of(other)
    layout = np.zeros(LAYOUT_SIZE)
    layout[:7] = (
        street.kerb_y_m, street.kerb_height_m, street.start_x_m - ALONG_MARGIN_M, ALONG_TEXEL_M, main.across_low,
        ACROSS_TEXEL_M, GROUND_TEXEL_M,
    )  # fmt: skip
    turn = street.turn_rad
    layout[L_CURVE : L_CURVE + 5] = (
        street.curvature_per_m, street.curve_start_x_m, street.curve_length_m, math.sin(turn), math.cos(turn),
    )  # fmt: skip
    if crossing is not None:
        layout[L_CROSSED : L_CROSSED + 4] = 1.0, crossing.x_m, crossing.kerb_m, crossing.corner_radius_m
    layout[L_SIDE : L_SIDE + 2] = other.start_x_m - ALONG_MARGIN_M, side.across_low
    # the street with the wider sidewalk paves the corners: what it has beyond its fronts is behind houses
    wide, scenery = (straight, main) if straight.sidewalk_width_m >= other.sidewalk_width_m else (other, side)
    layout[L_HIGH : L_HIGH + 2] = scenery.across_low, wide.kerb_y_m
    low, high, side_low = (
        snowed(table, own.across_low, ACROSS_TEXEL_M, spec, snow_cover)
        for table, own, spec in (
            (main.low, main, straight),
            (scenery.high, scenery, wide),
            (side.low, side, other),
        )
    )
    lanes = street.lanes_per_direction * street.lane_width_m
    gutter = street.kerb_y_m - 0.28, street.kerb_y_m - 0.02
    plain = np.stack([_albedo(low, main.across_low, *span) for span in ((-lanes, lanes), gutter)])
    paint = _stop_lines(street)
    paint[:, 5] *= 1.0 - snow_cover
    tables = (
        main.along, low, high, grain_integral(), side.along, side_low, paint, np.ascontiguousarray(plain, dtype=np.float32),
    )  # fmt: skip
    return GroundTables(layout, tables)
