"""What a protocol says of an episode: its cell's goal, judged on the episode's row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pedcross_env.scenario.suites.cell import Cell, Suite

__all__ = ["VERDICT_KEYS", "by_scenario", "judge", "rate"]

SLOWED_KMH = 1.0
"""From here on an impact counts as slowed; the protocol names no number."""

_ROUNDING_KMH = 1e-6
VERDICT_KEYS = ("goal", "passed", "points", "verdict_certain")

Row = dict[str, Any]


def judge(cell: Cell, row: Mapping[str, Any]) -> Row:
    """Judge an episode.

    Args:
        cell: What was played.
        row: Of ``eval.episodes.summarise_trace``.

    Returns:
        ``goal``: in words; ``passed``: whether it is reached, for points whether all are won; ``points``: 0 to 1 of
        the cell; ``verdict_certain``: whether the protocol states this rule for this cell, see the cell's provenance.
    """
    goal, hit = cell.goal, bool(row["collision"])
    demanded = float(row["peak_demand_mps2"]) >= goal.least_demand_mps2
    impact_kmh = 3.6 * float(row["impact_speed_mps"]) if hit else 0.0
    if goal.kind == "points":
        if cell.kind == "along":  # both go the same way: the protocol counts their relative speed
            impact_kmh = max(0.0, impact_kmh - cell.pedestrian_kmh)
        points = next((won for limit, won in goal.points if impact_kmh <= limit + _ROUNDING_KMH), 0.0)
        points = (points if hit else 1.0) * demanded
        certain = goal.certain or not hit
        return _verdict(cell, points == 1.0, points, certain)
    if goal.kind == "impact-speed":
        passed = impact_kmh <= goal.limit + _ROUNDING_KMH
    elif goal.kind == "speed-reduction":
        passed = impact_kmh <= cell.ego_kmh - SLOWED_KMH
    elif goal.kind == "reaction":
        passed = float(row["brake_ttc_s"]) >= goal.limit  # nan, never braked, is not
    elif goal.kind == "no-braking":
        passed = not hit and float(row["peak_deceleration_mps2"]) < goal.limit
    else:
        passed = not hit
    passed &= demanded
    return _verdict(cell, passed, float(passed), goal.certain)


def _verdict(cell: Cell, passed: bool, points: float, certain: bool) -> Row:
    return {"goal": str(cell.goal), "passed": passed, "points": points, "verdict_certain": certain}


def by_scenario(rows: Sequence[Row]) -> list[Row]:
    """Sum up the verdicts of each source by scenario: cells of one scenario, impact point and variant.

    Args:
        rows: Of ``eval.closed_loop.evaluate`` on a suite.

    Returns:
        Rows with detector, threshold, main, scenario (a cell's id without its speed), episodes, passed, points (their
        sum), uncertain (how many verdicts), worst_impact_kmh (0: no contact) and fastest_passed_kmh: up to which ego
        speed all episodes passed, 0 for none.
    """
    groups: dict[tuple[str, float, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["detector"], row["threshold"], _scenario(row["cell"])), []).append(row)
    found = []
    for (detector, threshold, scenario), own in groups.items():
        failed = [row["initial_speed_mps"] for row in own if not row["passed"]]
        slower = [
            row["initial_speed_mps"] for row in own if row["initial_speed_mps"] < min(failed, default=1e9)
        ]
        impacts = [row["impact_speed_mps"] for row in own if row["collision"]]
        found.append(
            {
                "detector": detector,
                "threshold": threshold,
                "main": own[0]["main"],
                "scenario": scenario,
                "episodes": len(own),
                "passed": sum(bool(row["passed"]) for row in own),
                "points": float(sum(row["points"] for row in own)),
                "uncertain": sum(not row["verdict_certain"] for row in own),
                "worst_impact_kmh": 3.6 * max(impacts, default=0.0),
                "fastest_passed_kmh": 3.6 * max(slower, default=0.0),
            }
        )
    return found


def rate(suite: Suite, rows: Sequence[Row]) -> list[Row]:
    """Add up the verdicts of each source as the protocol does, over the groups that were played wholly.

    Args:
        suite: That was played.
        rows: Of ``eval.closed_loop.evaluate`` on it; the seeds of a cell are averaged.

    Returns:
        Rows with detector, threshold, main, group, cells, points (won) and worth (to be won).
    """
    sources: dict[tuple[str, float, bool], dict[str, list[float]]] = {}
    for row in rows:
        own = sources.setdefault((row["detector"], row["threshold"], row["main"]), {})
        own.setdefault(row["cell"], []).append(float(row["points"]))
    found = []
    for (detector, threshold, main), own in sources.items():
        for share in suite.rating:
            if all(cell in own for cell in share.cells):
                mean = sum(sum(own[cell]) / len(own[cell]) for cell in share.cells) / len(share.cells)
                found.append(
                    {"detector": detector, "threshold": threshold, "main": main, "group": share.name,
                     "cells": len(share.cells), "points": share.won(mean), "worth": share.worth}
                )  # fmt: skip
    return found


def _scenario(cell_id: str) -> str:
    parts = cell_id.split("/")
    return "/".join([parts[0], *parts[2:]])
