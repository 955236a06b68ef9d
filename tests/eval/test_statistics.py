import math

import numpy as np
import pytest
from scipy import stats

from eval import metrics
from eval.statistics import clustered_bootstrap, mcnemar_exact, poisson_exact_interval, wilson_interval


def mean_of(x):
    return lambda w: float(np.average(x, weights=w))


@pytest.mark.parametrize(("k", "n"), [(0, 10), (3, 10), (10, 10), (1, 1), (250, 1000)])
def test_wilson_agrees_with_scipy(k, n):
    reference = stats.binomtest(k, n).proportion_ci(0.95, method="wilson")
    assert wilson_interval(k, n) == pytest.approx((reference.low, reference.high), abs=1e-12)


def test_wilson_without_trials_is_nan():
    assert all(math.isnan(x) for x in wilson_interval(0, 0))


def test_wilson_refuses_more_successes_than_trials():
    with pytest.raises(ValueError, match="trials"):
        wilson_interval(3, 2)


def test_poisson_interval_has_the_tabled_bounds():
    # Garwood's table: 0 events -> (0, 3.689), 5 events -> (1.623, 11.668)
    assert poisson_exact_interval(0, 1.0) == pytest.approx((0.0, 3.689), abs=1e-3)
    assert poisson_exact_interval(5, 1.0) == pytest.approx((1.623, 11.668), abs=1e-3)
    assert poisson_exact_interval(5, 2.0) == pytest.approx((1.623 / 2, 11.668 / 2), abs=1e-3)


def test_poisson_bounds_have_tails_of_one_in_forty():
    low, high = poisson_exact_interval(7, 1.0)
    assert stats.poisson.sf(6, low) == pytest.approx(0.025)
    assert stats.poisson.cdf(7, high) == pytest.approx(0.025)


def test_poisson_without_exposure_is_nan():
    assert all(math.isnan(x) for x in poisson_exact_interval(0, 0.0))


@pytest.mark.parametrize(("b", "c"), [(0, 0), (5, 0), (1, 9), (6, 6), (12, 3)])
def test_mcnemar_is_the_binomial_test_of_discordant_pairs(b, c):
    expected = stats.binomtest(b, b + c).pvalue if b + c else 1.0
    assert mcnemar_exact(b, c) == pytest.approx(expected)
    assert mcnemar_exact(b, c) == mcnemar_exact(c, b)


def test_bootstrap_of_a_mean_matches_the_normal_interval():
    x = np.random.default_rng(0).normal(size=400)
    low, high = clustered_bootstrap(mean_of(x), np.arange(400), seed=1, resamples=2000)
    half = 1.96 * x.std() / 20
    assert (low, high) == pytest.approx((x.mean() - half, x.mean() + half), abs=0.015)


def test_copies_inside_a_cluster_do_not_narrow_the_interval():
    x = np.random.default_rng(0).normal(size=50)
    copies = np.repeat(x, 20)
    clusters = np.repeat(np.arange(50), 20)
    alone = clustered_bootstrap(mean_of(x), np.arange(50), seed=1)
    clustered = clustered_bootstrap(mean_of(copies), clusters, seed=1)
    naive = clustered_bootstrap(mean_of(copies), np.arange(1000), seed=1)
    assert clustered == pytest.approx(alone)
    assert naive[1] - naive[0] < 0.5 * (clustered[1] - clustered[0])


def test_bootstrap_same_seed_same_interval_and_it_covers_the_auroc():
    rng = np.random.default_rng(2)
    labels = rng.integers(0, 2, 300)
    scores = labels * 0.3 + rng.random(300)
    videos = np.repeat(np.arange(30), 10)

    def weighted_auroc(weights):
        return metrics.auroc(labels, scores, weights)

    def interval(seed):
        return clustered_bootstrap(
            lambda w: metrics.auroc(labels, scores, w), videos, seed=seed, resamples=300
        )

    assert interval(0) == interval(0) != interval(1)
    assert interval(0).low < metrics.auroc(labels, scores) < interval(0).high


def test_one_cluster_or_undefined_draws_give_nan():
    assert all(math.isnan(x) for x in clustered_bootstrap(lambda w: 1.0, ["a"] * 5, seed=0))
    assert all(math.isnan(x) for x in clustered_bootstrap(lambda w: math.nan, ["a", "b"], seed=0))
