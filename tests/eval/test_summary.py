import math

import pytest
from test_closed_loop import run, spec

from eval.statistics import poisson_exact_interval, wilson_interval
from eval.summary import compare, group_of, summarise


def by(rows, detector, group, threshold=None):
    found = [r for r in rows if r["detector"] == detector and r["group"] == group]
    if threshold is not None:
        found = [r for r in found if r["threshold"] == threshold]
    assert len(found) == 1
    return found[0]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    names = ("sharp", "blind", "jumpy")
    return run(tmp_path_factory.mktemp("out"), names, weathers=("clear", "rain"), episodes=6).rows


def test_groups_are_the_papers_subsets():
    assert [group_of(w) for w in ("clear", "rain", "storm", "fog", "night")] == [
        "clear",
        "bad",
        "bad",
        "bad",
        "night",
    ]


def test_collision_rate_counts_crossing_episodes_only(rows):
    table = summarise(rows)
    for name, hits in (("never", 3), ("blind", 3), ("sharp", 0), ("oracle", 0), ("always", 0)):
        row = by(table, name, "clear")
        assert (row["crossings"], row["collisions"]) == (3, hits)
        assert (row["collision_low"], row["collision_high"]) == wilson_interval(hits, 3)


def test_avoided_and_caused_are_against_never_on_the_same_episode(rows):
    sharp = by(summarise(rows), "sharp", "clear")
    assert (sharp["never_collisions"], sharp["avoided"], sharp["caused"]) == (3, 3, 0)
    assert sharp["mcnemar_p"] == pytest.approx(2 * 0.5**3)
    wet = by(summarise(rows), "sharp", "bad")
    assert (wet["avoided"], wet["caused"]) == (0, 0)
    # from 1.03 s on 1 m/s2 over 29.67 m: v^2 = 100 - 2 * 29.67
    assert wet["impact_mean_mps"] == pytest.approx(math.sqrt(100 - 2 * 29.67), abs=0.05)
    assert wet["mitigation_mps"] == pytest.approx(10 - wet["impact_mean_mps"])


def test_false_braking_is_per_free_episode_and_per_km(rows):
    jumpy = by(summarise(rows), "jumpy", "clear")
    assert (jumpy["free_episodes"], jumpy["false_braking"], jumpy["false_events"]) == (3, 3, 3)
    assert jumpy["false_per_km"] == pytest.approx(3 / jumpy["distance_km"])
    bounds = poisson_exact_interval(3, jumpy["distance_km"])
    assert (jumpy["false_per_km_low"], jumpy["false_per_km_high"]) == bounds


def test_always_braking_shows_in_the_speed_without_crossings(rows):
    table = summarise(rows)
    assert by(table, "never", "clear")["free_speed_mps"] == pytest.approx(10.0)
    assert by(table, "always", "clear")["free_speed_mps"] < 1.0


def test_rates_without_a_denominator_are_nan(tmp_path):
    table = summarise([row for row in run(tmp_path).rows if not row["is_crossing"]])
    assert math.isnan(by(table, "sharp", "clear")["collision_rate"])
    assert math.isnan(by(table, "sharp", "clear")["impact_mean_mps"])


def test_detectors_are_compared_pairwise_on_the_same_episodes(rows):
    pairs = {(r["first"], r["second"], r["group"]): r for r in compare(rows)}
    assert len(pairs) == 3 * 2
    row = pairs["sharp", "blind", "clear"]
    assert (row["pairs"], row["only_first"], row["only_second"]) == (3, 0, 3)
    assert row["p"] == pytest.approx(0.25)


def test_operating_points_are_rows_of_their_own(tmp_path):
    table = summarise(run(tmp_path, specs=[spec("sharp")], extra_thresholds=(0.9,)).rows)
    assert by(table, "sharp", "clear", 0.5)["main"]
    assert not by(table, "sharp", "clear", 0.9)["main"]
