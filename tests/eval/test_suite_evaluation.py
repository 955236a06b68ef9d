"""A suite driven by the controls, and what the protocols say of it."""

import math

import pytest

from eval.closed_loop import EvaluateConfig, evaluate
from eval.report import build_report
from eval.summary import summarise
from eval.verdicts import by_scenario, judge, rate
from pedcross_env.errors import ConfigError
from pedcross_env.scenario.suites import suite


def run(out, name, cells, controls=("never", "always", "oracle"), **settings):
    config = EvaluateConfig(out=out, suite=name, cells=cells, controls=controls, workers=1, **settings)
    return evaluate(config, specs=[]).rows


def of(rows, detector, cell):
    return next(row for row in rows if row["detector"] == detector and row["cell"] == cell)


@pytest.fixture(scope="module")
def r152(tmp_path_factory):
    return run(tmp_path_factory.mktemp("out"), "un-r152", ("PED-50/20", "PED-50/60", "PED-50/42/01"))


def test_who_never_brakes_fails_every_cell_at_full_speed_and_who_always_brakes_none(r152):
    assert len(r152) == 9
    for cell, speed in (("PED-50/20", 20), ("PED-50/60", 60), ("PED-50/42/01", 42)):
        never, always = of(r152, "never", cell), of(r152, "always", cell)
        assert (never["passed"], never["outcome"]) == (False, "collision")
        assert 3.6 * never["impact_speed_mps"] == pytest.approx(speed)
        assert (always["passed"], always["points"]) == (True, 1.0)
        assert never["suite"] == "un-r152"


def test_a_laden_car_that_always_brakes_takes_longer_to_stop(tmp_path):
    rows = run(tmp_path, "un-r152", ("PED-50/60*",), controls=("always",))
    light, heavy = (of(rows, "always", cell) for cell in ("PED-50/60", "PED-50/60/laden"))
    assert light["peak_deceleration_mps2"] == pytest.approx(0.85 * 9.81)  # the road's friction, not 9 m/s2
    assert heavy["peak_deceleration_mps2"] == pytest.approx(9.0 * 1500 / 1950)  # the brakes' force
    assert light["peak_demand_mps2"] == heavy["peak_demand_mps2"] == pytest.approx(9.0)
    assert heavy["distance_km"] > light["distance_km"]
    assert heavy["passed"]


def test_a_stopped_run_is_completed(tmp_path):
    first = run(tmp_path, "un-r152", ("PED-50/20",))
    config = EvaluateConfig(
        out=tmp_path, suite="un-r152", cells=("PED-50/2*",), controls=("never", "always", "oracle"), workers=1
    )
    report = evaluate(config, specs=[])
    assert (report.already_there, report.played) == (3, 21)  # 20 and 25 by both tables in both loads
    assert first[0]["wall_s"] in [row["wall_s"] for row in report.rows]  # not played again


def test_the_summary_tells_cells_of_one_weather_and_seed_apart(r152):
    never = next(row for row in summarise(r152) if row["detector"] == "always")
    assert (never["crossings"], never["never_collisions"], never["avoided"]) == (3, 3, 3)


def test_scenarios_sum_up_their_cells(r152):
    rows = {(row["detector"], row["scenario"]): row for row in by_scenario(r152)}
    plain = rows["never", "PED-50"]
    assert (plain["episodes"], plain["passed"], plain["points"]) == (2, 0, 0.0)
    assert plain["worst_impact_kmh"] == pytest.approx(60)
    assert plain["fastest_passed_kmh"] == 0.0
    assert rows["always", "PED-50"]["fastest_passed_kmh"] == pytest.approx(60)
    assert rows["always", "PED-50/01"]["episodes"] == 1


def test_braking_for_who_stands_or_walks_in_the_lane_is_not_false_and_between_parked_cars_it_is(tmp_path):
    rows = run(
        tmp_path, "fmvss-127", ("PED-STANDING-25/30", "PED-ALONG-25/30", "FALSE-*"), ("always", "never")
    )
    for cell in ("FALSE-GAP/80", "FALSE-PLATE/80"):
        for_nobody = of(rows, "always", cell)
        assert (for_nobody["passed"], for_nobody["false_braking"], for_nobody["outcome"]) == (
            False,
            True,
            "timeout",
        )
        assert of(rows, "never", cell)["passed"]
        assert of(rows, "never", cell)["outcome"] == "passed"
    assert not of(rows, "never", "PED-STANDING-25/30")["passed"]
    assert not of(rows, "never", "PED-ALONG-25/30")["false_braking"]


def row(impact_kmh=None, **facts):
    hit = impact_kmh is not None
    speed = impact_kmh / 3.6 if hit else math.nan
    return {
        "collision": hit,
        "impact_speed_mps": speed,
        "peak_deceleration_mps2": 0.0,
        "peak_demand_mps2": 9.0,
        "brake_ttc_s": math.nan,
    } | facts


@pytest.mark.parametrize(
    ("name", "cell", "episode", "passed", "points", "certain"),
    [
        ("euro-ncap-2026", "CPFA-50/60", row(), True, 1.0, True),
        ("euro-ncap-2026", "CPFA-50/60", row(10.0), False, 0.75, True),
        ("euro-ncap-2026", "CPFA-50/60", row(20.1), False, 0.25, True),
        ("euro-ncap-2026", "CPFA-50/60", row(30.1), False, 0.0, True),
        ("euro-ncap-2026", "CPFA-50/40", row(9.0), False, 0.75, False),
        ("euro-ncap-2026", "CPFA-50/40", row(), True, 1.0, True),
        ("euro-ncap-2026", "CPFA-50/40", row(19.9), False, 0.5, False),
        ("euro-ncap-2026", "CPFA-50/40", row(20.1), False, 0.0, False),
        ("euro-ncap-2026", "CPFA-50/10", row(10.0), False, 0.0, False),
        ("euro-ncap-2026", "CPLA-10/20", row(12.6), False, 0.0, False),
        ("euro-ncap-2026", "CPLA-10/20", row(12.4), True, 1.0, False),
        ("euro-ncap-2026", "CPNA-75/20/ped3", row(19.5), False, 0.0, True),
        ("euro-ncap-2026", "CPNA-75/20/ped3", row(18.0), True, 1.0, True),
        ("euro-ncap-2026", "CPLA-25/50/warning", row(50.0, brake_ttc_s=1.71), True, 1.0, True),
        ("euro-ncap-2026", "CPLA-25/50/warning", row(brake_ttc_s=1.69), False, 0.0, True),
        ("euro-ncap-2026", "CPLA-25/50/warning", row(50.0), False, 0.0, True),
        ("euro-ncap-2026", "CPTAfs-50/20", row(1.0), False, 0.0, True),
        ("euro-ncap-2026", "CPFA-90/60", row(29.9), True, 1.0, True),
        ("euro-ncap-2026", "CPFA-90/60", row(30.1), False, 0.0, True),
        ("euro-ncap-2026", "CPNA-25/60/ped+3", row(29.9), True, 1.0, True),
        ("euro-ncap-2026", "CPNA-25/60/ped-2", row(29.9), False, 0.25, True),
        ("euro-ncap-2026", "CPLA-50/60", row(14.9), False, 0.75, True),
        ("euro-ncap-2026", "CPLA-50/60", row(15.1), False, 0.5, True),
        ("un-r152", "PED-50/60", row(45.0), True, 1.0, True),
        ("un-r152", "PED-50/60/01", row(45.0), False, 0.0, True),
        ("un-r152", "PED-50/30", row(0.5), False, 0.0, True),
        ("un-r152", "PED-50/30", row(peak_demand_mps2=4.9), False, 0.0, True),
        ("un-r152", "PED-50/30", row(peak_demand_mps2=5.0), True, 1.0, True),
        ("un-r152", "PED-50/60/laden", row(45.0, peak_demand_mps2=4.9), False, 0.0, True),
        ("fmvss-127", "PED-RIGHT-50/60", row(0.5), False, 0.0, True),
        ("fmvss-127", "FALSE-GAP/80", row(peak_deceleration_mps2=2.4), True, 1.0, True),
        ("fmvss-127", "FALSE-GAP/80", row(peak_deceleration_mps2=2.5), False, 0.0, True),
    ],
)
def test_verdicts_are_the_protocols(name, cell, episode, passed, points, certain):
    verdict = judge(suite(name).cell(cell), episode)
    assert (verdict["passed"], verdict["points"], verdict["verdict_certain"]) == (passed, points, certain)


def test_the_rating_is_the_protocols() -> None:
    ncap = suite("euro-ncap-2026")
    assert sum(share.worth for share in ncap.rating) == pytest.approx(
        9.0
    )  # 8 standard, 1 extended, 1 robustness
    rated = [cell for share in ncap.rating for cell in share.cells]
    assert sorted(rated) == sorted(c.id for c in ncap.cells if c.layer in ("standard", "extended"))

    def of_points(points):
        rows = [
            {"detector": "a", "threshold": 0.5, "main": True, "cell": c.id, "points": points(c)}
            for c in ncap.cells
        ]
        return {row["group"]: row["points"] for row in rate(ncap, rows)}

    assert sum(of_points(lambda cell: 1.0).values()) == pytest.approx(9.0)
    assert sum(of_points(lambda cell: 0.0).values()) == 0.0
    half = of_points(lambda cell: 0.5)
    assert half["CPNCO night, standard"] == 0.5  # in proportion
    assert half["CPNA day, extended"] == pytest.approx(0.5 * 0.0625)
    assert of_points(lambda cell: 0.49)["CPNA day, extended"] == 0.0  # in steps
    assert of_points(lambda cell: 0.76)["CPNA day, extended"] == pytest.approx(0.75 * 0.0625)
    slow = of_points(lambda cell: float(cell.ego_kmh <= 30))
    assert slow["CPFA day, standard"] == pytest.approx(0.5 * 3 / 6)


def test_nobody_wins_points_without_braking() -> None:
    for cell in suite("euro-ncap-2026").cells:
        if cell.goal.kind == "points":
            assert judge(cell, row(cell.ego_kmh))["points"] == 0.0, cell.id
            assert judge(cell, row(0.5 * cell.ego_kmh))["points"] > 0.0, cell.id


def test_what_was_not_played_wholly_is_not_rated() -> None:
    ncap = suite("euro-ncap-2026")
    rows = [
        {"detector": "a", "threshold": 0.5, "main": True, "cell": f"CPFA-50/{speed}", "points": 1.0}
        for speed in (10, 20, 30, 40, 50, 60)
    ]
    (one,) = rate(ncap, rows)
    assert (one["group"], one["points"], one["cells"]) == ("CPFA day, standard", 0.5, 6)
    assert rate(ncap, rows[1:]) == []
    assert rate(suite("fmvss-127"), rows) == []


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"suite": "r152"}, "Did you mean 'un-r152'"),
        ({"suite": "un-r152", "cells": ("PED-51/20",)}, "Did you mean 'PED-50/20'"),
        ({"cells": ("PED-50/20",)}, "given with a suite only"),
        ({"suite": "un-r152", "cell_seeds": 0}, "cell_seeds = 0"),
    ],
)
def test_unknown_suites_and_cells_are_refused_by_name(tmp_path, settings, message):
    with pytest.raises(ConfigError, match=message):
        EvaluateConfig(out=tmp_path, **settings)


def test_the_report_says_what_the_protocol_says(tmp_path):
    run(tmp_path, "un-r152", ("PED-50/20", "PED-50/60"), controls=("never", "always"))
    page = build_report(tmp_path).read_text()
    section = page.split("What the protocols say")[1].split("<h2>")[0]
    assert "<td>PED-50</td><td>0 / 2<br><small>impact 60</small></td><td>2 / 2</td>" in section
    assert "pedcross suites un-r152" in section
    assert "PED-50/20, PED-50/60 of the suite un-r152, 1 seed each" in page
