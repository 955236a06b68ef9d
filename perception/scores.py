"""Scores of p(crossing) against labels, as training reports them."""

from __future__ import annotations

import numpy as np
from sklearn.metrics import average_precision_score, f1_score, precision_recall_curve, roc_auc_score

__all__ = ["best_f1_threshold", "braking_threshold", "score"]


def best_f1_threshold(labels: np.ndarray, probabilities: np.ndarray) -> float:
    """Return the threshold of the best F1 (p >= threshold is positive); the highest of several."""
    precision, recall, thresholds = precision_recall_curve(labels, probabilities)
    f1 = 2 * precision * recall / np.maximum(precision + recall, 1e-12)
    f1 = f1[:-1]
    return float(thresholds[np.flatnonzero(f1 == f1.max())[-1]])


def braking_threshold(labels: np.ndarray, probabilities: np.ndarray, false_alarms: float = 0.01) -> float:
    """Return the lowest threshold at which at most a share ``false_alarms`` of the negatives is at or above it.

    The best F1 counts a missed clip and a false alarm alike; a car that brakes sees thirty windows a second, nearly
    all of them negative, and must not stop for a tenth of them. nan without negatives.
    """
    negatives = np.sort(probabilities[labels == 0])
    if not negatives.size:
        return float("nan")
    allowed = int(false_alarms * negatives.size)
    return float(np.nextafter(negatives[negatives.size - 1 - allowed], np.inf))


def score(labels: np.ndarray, probabilities: np.ndarray, threshold: float, prefix: str) -> dict[str, float]:
    """Return AUROC, average precision, F1 at ``threshold``, Brier score and counts; nan where undefined.

    Args:
        labels: (M,) 0 or 1.
        probabilities: (M,) in [0, 1], not rounded.
        threshold: Chosen on other data.
        prefix: Of the keys, e.g. "test".
    """
    both = 0 < labels.sum() < len(labels)
    positive = labels.any()
    values = {
        "auroc": float(roc_auc_score(labels, probabilities)) if both else float("nan"),
        "average_precision": (
            float(average_precision_score(labels, probabilities)) if positive else float("nan")
        ),
        "f1": float(f1_score(labels, probabilities >= threshold)) if positive else float("nan"),
        "brier": float(np.mean((probabilities - labels) ** 2)) if len(labels) else float("nan"),
        "clips": len(labels),
        "positives": int(labels.sum()),
    }
    return {f"{prefix}_{key}": value for key, value in values.items()}
