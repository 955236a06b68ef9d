"""Scores of probabilities against labels. One class only gives nan, never 0.

All functions take (N,) arrays; ``weights`` (N,) repeats a row that many times, which is how the clustered
bootstrap resamples without copying.
"""

from __future__ import annotations

import numpy as np

__all__ = [
    "auprc",
    "auroc",
    "best_f1_threshold",
    "brier",
    "confusion",
    "expected_calibration_error",
    "f_score",
    "roc_points",
]


def _checked(
    labels: np.ndarray, scores: np.ndarray, weights: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    y, s = np.asarray(labels), np.asarray(scores, dtype=np.float64)
    if y.ndim != 1 or y.shape != s.shape:
        raise ValueError(
            f"labels {y.shape} and scores {s.shape} must be one-dimensional and of equal length."
        )
    if np.isnan(s).any():
        raise ValueError(f"{int(np.isnan(s).sum())} of {s.size} scores are nan.")
    if not np.isin(y, (0, 1)).all():
        raise ValueError(f"labels must be 0 or 1, found {np.unique(y)[:5].tolist()}.")
    w = np.ones(s.shape) if weights is None else np.asarray(weights, dtype=np.float64)
    if w.shape != s.shape:
        raise ValueError(f"weights {w.shape} must have the shape of the scores {s.shape}.")
    return y.astype(bool), s, w


def _cumulated(y: np.ndarray, s: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Weights of true and false positives with each distinct score as threshold, from the highest."""
    order = np.argsort(-s, kind="stable")
    s, y, w = s[order], y[order], w[order]
    last_of_tie = np.flatnonzero(np.append(np.diff(s) != 0, True)) if s.size else np.empty(0, dtype=np.intp)
    true, false = np.cumsum(w * y), np.cumsum(w * ~y)
    return true[last_of_tie], false[last_of_tie], s[last_of_tie]


def auroc(labels: np.ndarray, scores: np.ndarray, weights: np.ndarray | None = None) -> float:
    """Area under the ROC curve: the chance that a positive scores above a negative, ties counting half.

    Returns:
        In [0, 1]; nan where a class is missing (or has no weight).
    """
    y, s, w = _checked(labels, scores, weights)
    true, false, _ = _cumulated(y, s, w)
    if not true.size or true[-1] <= 0 or false[-1] <= 0:
        return float("nan")
    twice_area = np.sum(np.diff(false, prepend=0.0) * (true + np.append(0.0, true[:-1])))
    return float(twice_area / (2 * true[-1] * false[-1]))


def auprc(labels: np.ndarray, scores: np.ndarray, weights: np.ndarray | None = None) -> float:
    """Average precision: precision summed over the steps of recall; nan where a class is missing."""
    y, s, w = _checked(labels, scores, weights)
    true, false, _ = _cumulated(y, s, w)
    if not true.size or true[-1] <= 0 or false[-1] <= 0:
        return float("nan")
    gained = np.diff(np.append(0.0, true))
    selected = true + false
    precision = np.divide(true, selected, out=np.zeros_like(true), where=selected > 0)
    return float(np.sum(gained * precision) / true[-1])


def roc_points(labels: np.ndarray, scores: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return false and true positive rates and thresholds, (K+1,) each; empty with one class."""
    y, s, w = _checked(labels, scores, None)
    true, false, thresholds = _cumulated(y, s, w)
    if not true.size or true[-1] <= 0 or false[-1] <= 0:
        return np.empty(0), np.empty(0), np.empty(0)
    return np.append(0.0, false / false[-1]), np.append(0.0, true / true[-1]), np.append(np.inf, thresholds)


def confusion(
    labels: np.ndarray, scores: np.ndarray, threshold: float, weights: np.ndarray | None = None
) -> tuple[float, float, float, float]:
    """Return true positives, false positives, false negatives, true negatives of ``scores >= threshold``."""
    y, s, w = _checked(labels, scores, weights)
    alarm = s >= threshold
    true, false = float(w[alarm & y].sum()), float(w[alarm & ~y].sum())
    return true, false, float(w[~alarm & y].sum()), float(w[~alarm & ~y].sum())


def f_score(
    labels: np.ndarray, scores: np.ndarray, threshold: float, weights: np.ndarray | None = None
) -> float:
    """F1 of ``scores >= threshold``: 2 TP / (2 TP + FP + FN).

    Returns:
        In [0, 1]; nan without positives, for which F1 says nothing. 0 is a true 0: positives, none found.
    """
    true, false, missed, _ = confusion(labels, scores, threshold, weights)
    return float("nan") if true + missed <= 0 else 2 * true / (2 * true + false + missed)


def best_f1_threshold(labels: np.ndarray, scores: np.ndarray) -> tuple[float, float]:
    """Return (threshold, F1) where F1 is highest, the highest such threshold; (nan, nan) with one class.

    Choose it on validation data: on the test set it is an optimistic bound.
    """
    y, s, w = _checked(labels, scores, None)
    true, false, thresholds = _cumulated(y, s, w)
    if not true.size or true[-1] <= 0 or false[-1] <= 0:
        return float("nan"), float("nan")
    f1 = 2 * true / (true + false + true[-1])
    best = int(np.argmax(f1))
    return float(thresholds[best]), float(f1[best])


def brier(labels: np.ndarray, probabilities: np.ndarray) -> float:
    """Mean squared difference of probability and label; nan without rows."""
    y, p, _ = _checked(labels, probabilities, None)
    return float(np.mean((p - y) ** 2)) if p.size else float("nan")


def expected_calibration_error(labels: np.ndarray, probabilities: np.ndarray, bins: int = 10) -> float:
    """Mean distance of stated probability and observed share over equal bins, weighted by their counts."""
    y, p, _ = _checked(labels, probabilities, None)
    if not p.size:
        return float("nan")
    if p.min() < 0 or p.max() > 1:
        raise ValueError("probabilities must be in [0, 1].")
    index = np.minimum((p * bins).astype(int), bins - 1)
    gap = np.abs(
        np.bincount(index, weights=p, minlength=bins) - np.bincount(index, weights=y, minlength=bins)
    )
    return float(gap.sum() / p.size)
