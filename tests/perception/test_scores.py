"""Thresholds are chosen as they say."""

import numpy as np
import pytest

from perception.scores import braking_threshold


@pytest.mark.parametrize("rate", [0.0, 0.01, 0.1])
def test_braking_threshold_is_the_lowest_with_so_few_false_alarms(rate):
    rng = np.random.default_rng(0)
    labels = rng.random(500) < 0.3
    p = np.where(labels, rng.beta(4, 2, 500), rng.beta(2, 4, 500))
    threshold = braking_threshold(labels.astype(int), p, rate)
    negatives = p[~labels]
    assert np.mean(negatives >= threshold) <= rate
    lower = negatives[negatives < threshold].max()
    assert np.mean(negatives >= lower) > rate


def test_no_negatives_no_threshold():
    assert np.isnan(braking_threshold(np.ones(3), np.array([0.1, 0.2, 0.3])))
