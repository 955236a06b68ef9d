"""Intervals and tests for counts, rates and clustered rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

__all__ = ["Interval", "clustered_bootstrap", "mcnemar_exact", "poisson_exact_interval", "wilson_interval"]


class Interval(NamedTuple):
    """Bounds of a confidence interval; nan where there is nothing to bound."""

    low: float
    high: float


def _check_confidence(confidence: float) -> None:
    if not 0 < confidence < 1:
        raise ValueError(f"confidence = {confidence!r} must be between 0 and 1, e.g. 0.95.")


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> Interval:
    """Wilson's score interval of a proportion (Wilson 1927); (nan, nan) without trials.

    Raises:
        ValueError: Unless 0 <= successes <= trials.
    """
    _check_confidence(confidence)
    if not 0 <= successes <= trials:
        raise ValueError(f"successes = {successes} must be between 0 and trials = {trials}.")
    if trials == 0:
        return Interval(math.nan, math.nan)
    z = float(stats.norm.ppf(0.5 + confidence / 2))
    share = successes / trials
    scale = 1 + z * z / trials
    centre = (share + z * z / (2 * trials)) / scale
    half = z / scale * math.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    # At the ends the bound is exact; the formula misses it by rounding.
    return Interval(0.0 if successes == 0 else centre - half, 1.0 if successes == trials else centre + half)


def poisson_exact_interval(events: int, exposure: float, confidence: float = 0.95) -> Interval:
    """Exact interval of a Poisson rate per unit of exposure (Garwood 1936); (nan, nan) without exposure."""
    _check_confidence(confidence)
    if events < 0 or exposure < 0:
        raise ValueError(f"events = {events} and exposure = {exposure} must not be negative.")
    if exposure == 0:
        return Interval(math.nan, math.nan)
    tail = (1 - confidence) / 2
    low = 0.0 if events == 0 else float(stats.chi2.ppf(tail, 2 * events)) / 2
    return Interval(low / exposure, float(stats.chi2.ppf(1 - tail, 2 * events + 2)) / 2 / exposure)


def mcnemar_exact(only_first: int, only_second: int) -> float:
    """Two-sided exact McNemar test: p-value of the discordant pairs under a fair coin; 1 without any."""
    if only_first < 0 or only_second < 0:
        raise ValueError(f"discordant counts must not be negative: {only_first}, {only_second}.")
    discordant = only_first + only_second
    if discordant == 0:
        return 1.0
    return min(1.0, 2 * float(stats.binom.cdf(min(only_first, only_second), discordant, 0.5)))


def clustered_bootstrap(
    statistic: Callable[[np.ndarray], float],
    clusters: Sequence[object] | np.ndarray,
    *,
    seed: int,
    resamples: int = 1000,
    confidence: float = 0.95,
) -> Interval:
    """Percentile interval of a statistic whose rows come in clusters, such as the clips of a video.

    Whole clusters are drawn with replacement, so rows of one video never count as independent.

    Args:
        statistic: From weights (N,), how often each row was drawn, to a number; nan where undefined.
        clusters: (N,) cluster of each row.
        seed: Of the draws.
        resamples: Number of draws. Undefined ones (nan, e.g. one class drawn) are left out.
        confidence: Of the interval.

    Returns:
        The interval; (nan, nan) with fewer than two clusters, or if over half of the draws are undefined.
    """
    _check_confidence(confidence)
    names, index = np.unique(np.asarray(clusters), return_inverse=True)
    if len(names) < 2:
        return Interval(math.nan, math.nan)
    rng = np.random.default_rng(seed)
    values = np.empty(resamples)
    for i in range(resamples):
        drawn = np.bincount(rng.integers(len(names), size=len(names)), minlength=len(names))
        values[i] = statistic(drawn[index].astype(np.float64))
    values = values[~np.isnan(values)]
    if values.size * 2 < resamples:
        return Interval(math.nan, math.nan)
    low, high = np.quantile(values, [(1 - confidence) / 2, (1 + confidence) / 2])
    return Interval(float(low), float(high))
