"""Lying snow: a street's profile across it, whitened."""

from __future__ import annotations

import numpy as np

from pedcross_env.scenario.street import StreetSpec

__all__ = ["SNOW_ALBEDO", "snowed"]

SNOW_ALBEDO = np.array([0.76, 0.78, 0.80])  # a day old, slightly soiled; fresh snow has up to 0.9
TRACK_SHARE = 0.45  # of the snow that stays where wheels run
TRACK_M, TRACK_HALF_M = 0.75, 0.22  # from the middle of a lane, half width


def snowed(
    integral: np.ndarray, across_low_m: float, texel_m: float, street: StreetSpec, cover: float
) -> np.ndarray:
    """Return the running integrals of a profile of which lying snow hides the share ``cover``, less in wheel tracks.

    Args:
        integral: (M, 8) running integrals of cover, r, g, b and markings, see scenery.Scenery.
        across_low_m: y of the first row.
        texel_m: Between rows.
        street: Gives the lanes.
        cover: 0 to 1.
    """
    if cover <= 0:
        return integral
    profile = np.diff(integral.astype(np.float64), axis=0)
    d = np.abs(across_low_m + (np.arange(len(profile)) + 0.5) * texel_m)
    from_middle = np.abs(d % street.lane_width_m - 0.5 * street.lane_width_m)
    driven = (d < street.lanes_per_direction * street.lane_width_m) & (
        np.abs(from_middle - TRACK_M) < TRACK_HALF_M
    )
    share = np.where(driven, TRACK_SHARE * cover, cover)[:, None]
    profile[:, 1:4] = (1 - share) * profile[:, 1:4] + share * SNOW_ALBEDO * profile[:, :1]
    profile[:, 4:] *= 1 - share
    total = np.concatenate([np.zeros((1, profile.shape[1])), np.cumsum(profile, axis=0)])
    return np.ascontiguousarray(total - total[len(total) // 2], dtype=np.float32)
