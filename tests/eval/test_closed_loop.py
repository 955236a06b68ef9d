import dataclasses
import json
import math

import numpy as np
import pytest
from fake_world import FakeDetector, FakeEnv

from agents import CONTROLS, AebConfig, HumanDriver
from eval.closed_loop import EvaluateConfig, evaluate
from eval.detectors import DetectorSpec
from eval.episodes import false_braking_steps
from eval.store import read_rows
from pedcross_env.contracts import check_info
from pedcross_env.errors import ConfigError, DataError

VOLATILE = ("wall_s", "detector_ms_mean", "detector_ms_p95")


def spec(name, **changes):
    base = DetectorSpec(
        name=name,
        path=name,
        modality="rgb",
        threshold=0.5,
        braking_threshold=0.5,
        fingerprint=f"weights of {name}",
    )
    return dataclasses.replace(base, **changes)


def config(out, **changes):
    return EvaluateConfig(**({"out": out, "weathers": ("clear",), "episodes": 4, "workers": 1} | changes))


def run(out, names=("sharp",), progress=lambda *_: None, specs=None, **changes):
    return evaluate(
        config(out, **changes), progress, specs=[spec(n) for n in names] if specs is None else specs,
        env_factory=FakeEnv, loader=FakeDetector,
    )  # fmt: skip


def select(report, name):
    return [row for row in report.rows if row["detector"] == name]


def test_the_fake_world_speaks_the_contract():
    env = FakeEnv(dataclasses.make_dataclass("C", ["modalities"])(()))
    _, info = env.reset(seed=0, options={"weather": "clear"})
    check_info(info)


def test_never_hits_every_crossing_at_full_speed_and_oracle_and_a_sharp_detector_none(tmp_path):
    report = run(tmp_path, ("sharp", "blind"))
    for name in ("never", "blind"):
        crossing = [row for row in select(report, name) if row["is_crossing"]]
        assert [row["outcome"] for row in crossing] == ["collision", "collision"]
        assert [row["impact_speed_mps"] for row in crossing] == [10.0, 10.0]
    for name in ("oracle", "sharp", "always"):
        assert not any(row["collision"] for row in select(report, name))
        assert all(math.isnan(row["impact_speed_mps"]) for row in select(report, name))


def test_a_person_brakes_a_reaction_time_after_the_label(tmp_path):
    report = run(tmp_path, names=(), specs=[], controls=("oracle", "human"), episodes=20)
    crossing = [row for row in select(report, "human") if row["is_crossing"]]
    oracle = {row["seed"]: row for row in select(report, "oracle")}
    late = []
    for row in crossing:
        driver = HumanDriver()
        driver.reset(row["seed"])
        assert 0 <= row["brake_delay_s"] - driver.reaction_s <= 1 / 30 + 1e-6
        late.append(row["first_brake_s"] - oracle[row["seed"]]["first_brake_s"])
        # 1 s to the label, the reaction time, then 80 % of 9 m/s2 from 10 m/s: does it stop within 40 m?
        stops_m = 10.0 * (1.0 + driver.reaction_s) + 50.0 / 7.2
        assert row["collision"] == (stops_m > 40.0)
    assert min(late) > 0.4


def test_all_sources_play_the_same_episodes(tmp_path):
    report = run(tmp_path, weathers=("clear", "rain"))
    suites = {
        name: [
            (r["weather"], r["seed"], r["is_crossing"], r["initial_speed_mps"]) for r in select(report, name)
        ]
        for name in ("oracle", "human", "never", "always", "random", "sharp")
    }
    assert len({tuple(suite) for suite in suites.values()}) == 1
    assert [row["is_crossing"] for row in select(report, "never")][:4] == [True, False, True, False]


def test_weather_acts_on_the_same_crossing(tmp_path):
    report = run(tmp_path, weathers=("clear", "rain"))
    outcome = {(r["weather"], r["seed"]): r["collision"] for r in select(report, "sharp")}
    assert not outcome["clear", 0]
    assert outcome["rain", 0]  # 1 m/s2 is too little: 10 m/s needs 50 m


def test_a_detector_is_not_heard_before_its_window_is_full(tmp_path):
    hasty = run(tmp_path, ("hasty",), controls=("never",))
    # "hasty" cries in its first two frames, before it has seen the three that its clips have
    assert all(math.isnan(row["first_brake_s"]) for row in select(hasty, "hasty"))


def test_brake_times_follow_from_the_label(tmp_path):
    row = select(run(tmp_path), "sharp")[0]
    assert row["first_label_s"] == pytest.approx(1.0)
    assert row["first_brake_s"] == pytest.approx(1.0 + 1 / 30)  # the second frame in a row
    assert row["brake_delay_s"] == pytest.approx(1 / 30)
    assert row["label_distance_m"] == pytest.approx(30.0)
    assert row["peak_deceleration_mps2"] == pytest.approx(9.0)
    assert row["stopped"]


def test_controls_cost_no_rendering_and_detectors_see_only_their_modality(tmp_path):
    seen = []

    def factory(env_config):
        seen.append(env_config.modalities)
        return FakeEnv(env_config)

    evaluate(config(tmp_path), specs=[spec("sharp")], env_factory=factory, loader=FakeDetector)
    assert seen == [(), ("rgb",)]


def test_false_braking_is_braking_for_nobody(tmp_path):
    report = run(tmp_path, ("sharp", "jumpy"))
    assert not any(row["false_braking"] for row in select(report, "sharp") + select(report, "never"))
    jumpy = select(report, "jumpy")
    # Frames 6-12 are before 0.4 s; somebody steps out at 1 s in even seeds, so braking is excused there.
    assert [row["false_braking"] for row in jumpy] == [False, True, False, True]
    assert [row["false_brake_events"] for row in jumpy] == [0, 1, 0, 1]
    assert [row["false_braking"] for row in select(report, "always")] == [False, True, False, True]


def test_false_braking_by_hand():
    time_s = np.arange(0, 6, 0.5)
    label = (time_s >= 2) & (time_s < 3)
    crossing_in = np.where(time_s < 2, 2 - time_s, np.where(time_s < 3, 0.0, np.inf))
    hard, soft = np.full(time_s.shape, -2.5), np.full(time_s.shape, -2.4)
    #           0, .5 too early | 1 .. 2.5 soon or labelled | 3, 3.5 just after | later
    expected = [True] * 2 + [False] * 6 + [True] * 4
    assert false_braking_steps(time_s, hard, label, crossing_in).tolist() == expected
    assert not false_braking_steps(time_s, soft, label, crossing_in).any()


def test_a_rerun_plays_only_what_is_missing(tmp_path):
    first = run(tmp_path, episodes=2)
    sources = len(CONTROLS) + 1
    assert (first.played, first.already_there) == (2 * sources, 0)
    again = run(tmp_path, episodes=2)
    assert (again.played, again.already_there) == (0, 2 * sources)
    more = run(tmp_path, ("sharp", "blind"), episodes=3)
    assert (more.played, more.already_there) == (sources + 3, 2 * sources)
    assert len({(r["detector"], r["seed"]) for r in more.rows}) == len(more.rows) == 3 * (sources + 1)
    assert read_rows(tmp_path / "episodes.parquet")[0].keys() == more.rows[0].keys()


def test_a_stopped_run_is_completed_and_equals_an_unbroken_one(tmp_path):
    def stop(done, total, what):
        if done == 7:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "broken", progress=stop)
    log = tmp_path / "broken" / "episodes.jsonl"
    assert len(log.read_text().splitlines()) == 7
    log.write_text(log.read_text()[:-20])  # killed while writing the seventh row
    resumed = run(tmp_path / "broken")
    assert (resumed.played, resumed.already_there) == (4 * (len(CONTROLS) + 1) - 6, 6)
    steady = run(tmp_path / "whole")

    def comparable(rows):
        return [json.dumps({k: v for k, v in row.items() if k not in VOLATILE}) for row in rows]

    assert comparable(resumed.rows) == comparable(steady.rows)


def test_rows_of_other_weights_or_settings_are_not_reused(tmp_path):
    run(tmp_path, episodes=1)
    retrained = run(tmp_path, episodes=1, specs=[spec("sharp", fingerprint="other weights")])
    assert (retrained.played, retrained.already_there, retrained.other_setups) == (
        1,
        len(CONTROLS),
        1,
    )
    slower = run(tmp_path, episodes=1, aeb=AebConfig(consecutive_frames=5))
    assert slower.played == len(CONTROLS) + 1


def test_two_workers_give_the_rows_of_one(tmp_path):
    alone, pool = run(tmp_path / "one", episodes=2), run(tmp_path / "two", episodes=2, workers=2)
    for a, b in zip(alone.rows, pool.rows, strict=True):
        for key in a.keys() - set(VOLATILE):
            assert a[key] == b[key] or (math.isnan(a[key]) and math.isnan(b[key])), key


def test_progress_counts_to_the_end(tmp_path):
    calls = []
    run(tmp_path, episodes=1, progress=lambda done, total, what: calls.append((done, total)))
    total = len(CONTROLS) + 1
    assert calls == [(i, total) for i in range(total + 1)]


class OnlyOneInFourHits(FakeEnv):
    """Of the crossings, those of seeds 2, 6, 10, ... are over before a steady ego arrives."""

    def _label(self):
        return super()._label() and (self.seed % 4 == 0 or self._time() < 3.0)


def chosen_seeds(out, **changes):
    report = evaluate(
        config(out, **changes), specs=[spec("sharp")], env_factory=OnlyOneInFourHits, loader=FakeDetector
    )
    return report, sorted({row["seed"] for row in report.rows})


def test_crossings_that_a_steady_ego_misses_are_passed_over(tmp_path):
    report, seeds = chosen_seeds(tmp_path, episodes=5, hit_share=0.6, seed=1, weathers=("clear", "rain"))
    assert seeds == [1, 3, 4, 8, 12]
    never = [row for row in report.rows if row["detector"] == "never"]
    assert [row["collision"] for row in never] == 2 * [False, False, True, True, True]
    assert json.loads((tmp_path / "evaluate.json").read_text())["seeds"] == seeds


def test_without_a_share_every_seed_is_played(tmp_path):
    assert chosen_seeds(tmp_path, episodes=5)[1] == [0, 1, 2, 3, 4]


def test_a_share_that_the_traffic_does_not_have_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="seeds 0 to 99, 0 have a crossing that hits"):
        evaluate(
            config(tmp_path, episodes=2, hit_share=1.0),
            specs=[],
            env_factory=EmptyStreet,
            loader=FakeDetector,
        )


class EmptyStreet(FakeEnv):
    def _crosses(self):
        return False


def test_extra_thresholds_are_marked_as_operating_points(tmp_path):
    report = run(tmp_path, episodes=1, extra_thresholds=(0.5, 0.9))
    assert [(r["threshold"], r["main"]) for r in select(report, "sharp")] == [(0.5, True), (0.9, False)]


def test_a_detector_that_returns_nan_stops_the_run(tmp_path):
    with pytest.raises(DataError, match="p_crossing = nan"):
        run(tmp_path, ("broken",))


def test_a_log_damaged_in_the_middle_is_an_error(tmp_path):
    run(tmp_path, episodes=1)
    log = tmp_path / "episodes.jsonl"
    lines = log.read_text().splitlines()
    log.write_text("\n".join([lines[0][:30], *lines[1:]]) + "\n")
    with pytest.raises(DataError, match="line 1"):
        run(tmp_path, episodes=1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [({"controls": ("oracel",)}, "Did you mean 'oracle'"), ({"episodes": 0}, "episodes"),
     ({"threshold": 1.5}, "threshold"), ({"weathers": ()}, "weathers"),
     ({"weathers": ("clear", "clear")}, "repeats"), ({"hit_share": 1.5}, "hit_share"),
     ({"hit_share": 0.5, "suite": "un-r152"}, "without a suite")],
)  # fmt: skip
def test_settings_that_cannot_work_are_named(tmp_path, changes, message):
    with pytest.raises(ConfigError, match=message):
        config(tmp_path, **changes)


def test_an_unwritable_folder_is_named_before_anything_is_played(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="cannot be written"):
        run(tmp_path / "file" / "out")
