"""Rows of text for the report's tables."""

from __future__ import annotations

import math
from typing import Any

from eval.report.format import DASH, count, interval, kmh, number, p_value, percent, percent_interval
from eval.report.paper import paper_energy, paper_score
from eval.report.results import Results
from eval.verdicts import by_scenario

__all__ = [
    "checkpoint_table",
    "closed_loop_tables",
    "offline_table",
    "pair_table",
    "strata_table",
    "verdict_table",
]

Row = dict[str, Any]


def _last(value: float) -> float:
    """Sort key that puts nan last."""
    return math.inf if math.isnan(value) else value


def offline_table(results: Results) -> list[Row]:
    """One row per subset and detector, within a subset the best AUROC first."""
    about = {name: detector["about"] for name, detector in results.detectors().items()}
    rows = []
    for row in sorted(results.offline, key=lambda r: (r["subset"], _last(-r["auroc"]), r["detector"])):
        facts = about.get(row["detector"], {})
        printed = paper_score(facts.get("model", ""), facts.get("frames", 0), row["subset"], row["modality"])
        lost = [
            f"{row[key]} {text}"
            for key, text in (
                ("damaged_images", "damaged images"),
                ("short_videos", "videos too short"),
                ("lost_clips", "clips left out"),
            )
            if row[key]
        ]
        rows.append(
            {
                "subset": row["subset"],
                "detector": row["detector"],
                "auroc": number(row["auroc"], 3),
                "auroc_interval": interval(row["auroc_low"], row["auroc_high"], 3),
                "auprc": number(row["auprc"], 3),
                "f_score": percent(row["f_score"]),
                "threshold": number(row["threshold"], 2),
                "ece": number(row["ece"], 2),
                "clips": f"{row['clips']:,}",
                "positives": f"{row['positives']:,} in {row['positive_videos']} of {row['videos']} videos",
                "paper": DASH if printed is None else f"{printed[0]:.3f} / {printed[1]:.0f} %",
                "note": "; ".join([row["note"], *lost] if row["note"] else lost),
            }
        )
    return rows


def strata_table(results: Results) -> Row:
    """AUROC by speed and by distance: one column per stratum, one row per detector; empty without a manifest."""
    if not results.strata:
        return {}
    detectors = list(dict.fromkeys(row["detector"] for row in results.strata))
    cells: dict[str, list[Row]] = {name: [] for name in detectors}
    for row in results.strata:
        cells[row["detector"]].append(
            {
                "auroc": number(row["auroc"]),
                "note": f"{interval(row['auroc_low'], row['auroc_high'])} {row['positives']}".strip(),
            }
        )
    columns = [_stratum(row) for row in results.strata if row["detector"] == detectors[0]]
    return {"columns": columns, "rows": [{"detector": name, "cells": cells[name]} for name in detectors]}


def _stratum(row: Row) -> str:
    scale, unit = (3.6, "km/h") if row["by"] == "speed_mps" else (1.0, "m")
    low, high = (f"{scale * row[end]:.0f}" for end in ("from", "to"))
    if row["from"] == 0:
        return f"below {high} {unit}"
    return f"from {low} {unit}" if math.isinf(row["to"]) else f"{low} to {high} {unit}"


def closed_loop_tables(results: Results) -> list[Row]:
    """One table per weather group: controls first, then detectors, fewest collisions first."""
    tables = []
    for group in results.groups():
        rows = results.main(group)
        controls = [row for row in rows if row["kind"] == "control"]
        detectors = [row for row in rows if row["kind"] != "control"]
        detectors.sort(key=lambda r: (_last(r["collision_rate"]), _last(r["false_rate"]), r["detector"]))
        weathers = dict.fromkeys(
            r["weather"] for r in results.episodes if r["detector"] == rows[0]["detector"] and _in(r, group)
        )
        tables.append(
            {
                "group": group,
                "weathers": ", ".join(weathers),
                "crossings": rows[0]["crossings"],
                "free": rows[0]["free_episodes"],
                "rows": [_closed_loop_row(row) for row in controls + detectors],
            }
        )
    return tables


def _in(row: Row, group: str) -> bool:
    from eval.summary import group_of

    return group_of(row["weather"]) == group


def _closed_loop_row(row: Row) -> Row:
    mean, median = kmh(row["impact_mean_mps"]), kmh(row["impact_median_mps"])
    caused = f", caused {row['caused']}" if row["caused"] else ""
    avoided = f"{row['avoided']} of {row['never_collisions']}{caused}" if row["never_collisions"] else DASH
    is_never = row["detector"] == "never"
    return {
        "detector": row["detector"],
        "kind": row["kind"],
        "collisions": f"{row['collisions']} / {row['crossings']}",
        "rate": percent(row["collision_rate"]),
        "rate_interval": percent_interval(row["collision_low"], row["collision_high"]),
        "avoided": DASH if is_never else avoided,
        "p": DASH if is_never else p_value(row["mcnemar_p"]),
        "impact": DASH if mean == DASH else f"{mean} / {median}",
        "false": f"{row['false_braking']} / {row['free_episodes']}",
        "false_interval": percent_interval(row["false_low"], row["false_high"]),
        "per_km": number(row["false_per_km"], 1),
        "per_km_interval": interval(row["false_per_km_low"], row["false_per_km_high"], 1),
        "delay": number(row["brake_delay_median_s"], 2),
        "free_speed": kmh(row["free_speed_mps"]),
        "ms": DASH if row["kind"] == "control" else number(row["detector_ms"], 1),
    }


def pair_table(results: Results) -> list[Row]:
    """Pairs of detectors, the clearest difference first."""
    return [
        {
            "group": row["group"],
            "first": row["first"],
            "second": row["second"],
            "pairs": row["pairs"],
            "only_first": row["only_first"],
            "only_second": row["only_second"],
            "p": p_value(row["p"]),
        }
        for row in sorted(results.pairs, key=lambda r: (r["p"], r["group"], r["first"], r["second"]))
    ]


def verdict_table(results: Results) -> Row | None:
    """What a suite's protocol says of each source, by scenario; None where no suite was driven."""
    rows = [row for row in results.episodes if row.get("suite") and row["main"]]
    if not rows:
        return None
    sources = list(dict.fromkeys(row["detector"] for row in rows))
    by_cell = {(row["scenario"], row["detector"]): row for row in by_scenario(rows)}
    scenarios = list(dict.fromkeys(scenario for scenario, _ in by_cell))
    totals = [[row for row in rows if row["detector"] == name] for name in sources]
    return {
        "sources": sources,
        "rows": [
            {"scenario": scenario, "cells": [_verdict_cell(by_cell[scenario, name]) for name in sources]}
            for scenario in scenarios
        ],
        "total": [
            {
                "passed": f"{sum(bool(row['passed']) for row in own)} / {len(own)}",
                "note": percent(sum(row["points"] for row in own) / len(own)),
            }
            for own in totals
        ],
        "uncertain": sum(not row["verdict_certain"] for row in rows),
        "judged": len(rows),
    }


def _verdict_cell(row: Row) -> Row:
    notes = []
    if 0 < row["passed"] < row["episodes"] and row["fastest_passed_kmh"]:
        notes.append(f"to {row['fastest_passed_kmh']:.0f} km/h")
    if row["worst_impact_kmh"]:
        notes.append(f"impact {row['worst_impact_kmh']:.0f}")
    return {"passed": f"{row['passed']} / {row['episodes']}", "note": ", ".join(notes)}


def checkpoint_table(results: Results) -> list[Row]:
    """What each detector is and what a clip costs it."""
    rows = []
    for name, detector in sorted(results.detectors().items()):
        about = detector["about"]
        measured = [row for row in results.offline if row["detector"] == name]
        energy = [row["energy_mj"] for row in measured if not math.isnan(row["energy_mj"])]
        printed = paper_energy(about.get("model", ""), about.get("frames", 0))
        preprocess = about.get("preprocess", {})
        size = f"{preprocess['width_px']}×{preprocess['height_px']}" if preprocess else DASH
        metrics, kept_apart = about.get("metrics") or {}, detector.get("test_videos") or ()
        rows.append(
            {
                "detector": name,
                "model": about.get("model", DASH),
                "input": f"{detector['modality']}, {about.get('frames', DASH)} frames of {size}",
                "width": about.get("width", DASH),
                "parameters": count(measured[0]["parameters"] if measured else None),
                "bytes": f"{about['size_bytes'] / 1e6:.2f} MB" if "size_bytes" in about else DASH,
                "energy": f"{sum(energy) / len(energy):.3g}" if energy else DASH,
                "paper_energy": DASH if printed is None else f"{printed:g}",
                "ms_per_clip": number(measured[0]["ms_per_clip"], 1) if measured else DASH,
                "validation_auroc": number(metrics.get("validation_auroc"), 3),
                "test_auroc": number(metrics.get("test_auroc"), 3),
                "test_videos": f"{len(kept_apart)} videos" if kept_apart else "",
                "recipe": f"{about.get('recipe') or DASH}, seed {about.get('seed', DASH)}",
                "data": about.get("fingerprint") or DASH,
                "command": about.get("command") or DASH,
                "weights": detector["fingerprint"],
            }
        )
    return rows
