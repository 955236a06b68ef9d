import numpy as np
import pytest
from sklearn import metrics as sk

from eval import metrics

TINY = 1e-12


def sample(n=400, seed=0, ties=False):
    rng = np.random.default_rng(seed)
    labels = (rng.random(n) < 0.3).astype(int)
    scores = np.clip(0.3 * labels + 0.7 * rng.random(n), 0, 1)
    return labels, np.round(scores, 1) if ties else scores


@pytest.mark.parametrize("ties", [False, True])
def test_areas_agree_with_scikit_learn(ties):
    labels, scores = sample(ties=ties)
    assert metrics.auroc(labels, scores) == pytest.approx(sk.roc_auc_score(labels, scores), abs=TINY)
    assert metrics.auprc(labels, scores) == pytest.approx(
        sk.average_precision_score(labels, scores), abs=1e-12
    )


@pytest.mark.parametrize("ties", [False, True])
def test_integer_weights_are_repeated_rows(ties):
    labels, scores = sample(ties=ties)
    weights = np.random.default_rng(1).integers(0, 4, labels.size)
    repeated = np.repeat(labels, weights), np.repeat(scores, weights)
    assert metrics.auroc(labels, scores, weights) == pytest.approx(sk.roc_auc_score(*repeated), abs=TINY)
    assert metrics.auprc(labels, scores, weights) == pytest.approx(
        sk.average_precision_score(*repeated), abs=1e-12
    )
    assert metrics.f_score(labels, scores, 0.5, weights) == pytest.approx(
        sk.f1_score(repeated[0], repeated[1] >= 0.5)
    )


def test_auroc_by_hand():
    assert metrics.auroc(np.array([0, 0, 1, 1]), np.array([0.1, 0.4, 0.35, 0.8])) == 0.75
    assert metrics.auroc(np.array([0, 1]), np.array([0.5, 0.5])) == 0.5


@pytest.mark.parametrize("labels", [[0, 0, 0], [1, 1, 1], []])
def test_one_class_is_nan_never_zero(labels):
    y, s = np.array(labels, dtype=int), np.linspace(0.1, 0.9, len(labels))
    assert np.isnan(metrics.auroc(y, s))
    assert np.isnan(metrics.auprc(y, s))
    assert np.isnan(metrics.best_f1_threshold(y, s)).all()
    assert all(a.size == 0 for a in metrics.roc_points(y, s))


def test_f_score_is_nan_without_positives_and_zero_where_all_are_missed():
    assert np.isnan(metrics.f_score(np.zeros(4, int), np.full(4, 0.9), 0.5))
    assert metrics.f_score(np.array([0, 1, 1]), np.zeros(3), 0.5) == 0.0


@pytest.mark.parametrize("ties", [False, True])
def test_best_f1_is_the_best_over_all_thresholds(ties):
    labels, scores = sample(ties=ties)
    threshold, f1 = metrics.best_f1_threshold(labels, scores)
    assert f1 == pytest.approx(max(sk.f1_score(labels, scores >= t) for t in np.unique(scores)))
    assert f1 == pytest.approx(metrics.f_score(labels, scores, threshold))


def test_confusion_counts_everything_once():
    labels, scores = sample()
    counts = metrics.confusion(labels, scores, 0.5)
    tn, fp, fn, tp = sk.confusion_matrix(labels, scores >= 0.5).ravel()
    assert counts == (tp, fp, fn, tn)


def test_roc_points_run_from_corner_to_corner():
    false, true, thresholds = metrics.roc_points(*sample(ties=True))
    assert (false[0], true[0], false[-1], true[-1]) == (0, 0, 1, 1)
    assert (np.diff(thresholds) < 0).all()
    assert sk.auc(false, true) == pytest.approx(metrics.auroc(*sample(ties=True)))


def test_brier_agrees_with_scikit_learn():
    labels, scores = sample()
    assert metrics.brier(labels, scores) == pytest.approx(sk.brier_score_loss(labels, scores))
    assert np.isnan(metrics.brier(np.empty(0, int), np.empty(0)))


def test_calibration_error_by_hand():
    # p = .9 is right in 8 of 10, p = .1 in 2 of 10: each bin is off by .1
    labels = np.array([1] * 8 + [0] * 2 + [1] * 2 + [0] * 8)
    p = np.array([0.9] * 10 + [0.1] * 10)
    assert metrics.expected_calibration_error(labels, p) == pytest.approx(0.1)
    assert metrics.expected_calibration_error(np.array([1, 0]), np.array([1.0, 0.0])) == 0.0


@pytest.mark.parametrize(
    ("labels", "scores", "message"),
    [([0, 1], [0.5], "equal length"), ([0, 1], [0.5, np.nan], "nan"), ([0, 2], [0.5, 0.5], "0 or 1")],
)
def test_bad_input_is_named(labels, scores, message):
    with pytest.raises(ValueError, match=message):
        metrics.auroc(np.array(labels), np.array(scores))
