"""From episode rows to the numbers of the closed-loop table, with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from eval.statistics import clustered_bootstrap, mcnemar_exact, poisson_exact_interval, wilson_interval
from pedcross_env.weather import BAD_WEATHERS

__all__ = ["GROUPS", "compare", "group_of", "summarise"]

Row = dict[str, Any]

GROUPS = ("clear", "bad")
"""The two groups of the paper; any other weather is a group of its own."""


def group_of(weather: str) -> str:
    """Return "bad" for the weathers of the paper's Weather subset, else the weather's own name."""
    return "bad" if weather in BAD_WEATHERS else weather


def summarise(rows: Sequence[Row], *, seed: int = 0) -> list[Row]:
    """One row per detector, threshold and weather group.

    Args:
        rows: Of ``eval.closed_loop.evaluate``.
        seed: Of the bootstrap.

    Returns:
        Rows in the order of ``rows``: sources, then groups. Rates are nan where they have no denominator.
        Avoided, caused and ``mcnemar_p`` compare crossing episodes with "never" on the same seed and weather.
    """
    never = {_episode(row): row for row in rows if row["detector"] == "never"}
    keys = dict.fromkeys((row["detector"], row["threshold"], group_of(row["weather"])) for row in rows)
    result = []
    for detector, threshold, group in keys:
        own = [
            row
            for row in rows
            if (row["detector"], row["threshold"], group_of(row["weather"])) == (detector, threshold, group)
        ]
        facts = {key: own[0][key] for key in ("detector", "kind", "modality", "threshold", "main")}
        facts |= {"group": group, "episodes": len(own)} | _collisions(own, never, seed)
        result.append(facts | _false_braking(own) | _driving(own))
    return result


def _episode(row: Row) -> tuple[str, str, int]:
    """What was played, whoever drove."""
    return row.get("cell", ""), row["weather"], row["seed"]


def _cluster(row: Row) -> Any:
    """Episodes that are not independent: one seed in several weathers, one cell with several seeds."""
    return row.get("cell") or row["seed"]


def _collisions(rows: Sequence[Row], never: dict[tuple[str, str, int], Row], seed: int) -> Row:
    crossing = [row for row in rows if row["is_crossing"]]
    hits = [row for row in crossing if row["collision"]]
    speeds = np.array([row["impact_speed_mps"] for row in hits])
    low, high = wilson_interval(len(hits), len(crossing))
    speed_interval = clustered_bootstrap(
        lambda w: float(np.average(speeds, weights=w)), [_cluster(row) for row in hits], seed=seed
    )  # fmt: skip
    pairs = [(row, never[_episode(row)]) for row in crossing if _episode(row) in never]
    avoided = sum(base["collision"] and not row["collision"] for row, base in pairs)
    caused = sum(row["collision"] and not base["collision"] for row, base in pairs)
    slower = [base["impact_speed_mps"] - row["impact_speed_mps"]
              for row, base in pairs if row["collision"] and base["collision"]]  # fmt: skip
    return {
        "crossings": len(crossing),
        "collisions": len(hits),
        "collision_rate": _ratio(len(hits), len(crossing)),
        "collision_low": low,
        "collision_high": high,
        "other_collisions": sum(row["collision"] for row in rows if not row["is_crossing"]),
        "impact_mean_mps": _mean(speeds),
        "impact_low_mps": speed_interval.low,
        "impact_high_mps": speed_interval.high,
        "impact_median_mps": float(np.median(speeds)) if speeds.size else float("nan"),
        "never_collisions": sum(base["collision"] for _, base in pairs),
        "avoided": avoided,
        "caused": caused,
        "mitigation_mps": _mean(np.array(slower)),
        "mcnemar_p": mcnemar_exact(avoided, caused) if pairs else float("nan"),
        "brake_delay_median_s": _median([row["brake_delay_s"] for row in crossing]),
    }


def _false_braking(rows: Sequence[Row]) -> Row:
    free = [row for row in rows if not row["is_crossing"]]
    false = sum(row["false_braking"] for row in free)
    events, distance_km = (
        sum(row["false_brake_events"] for row in rows),
        sum(row["distance_km"] for row in rows),
    )
    low, high = wilson_interval(false, len(free))
    per_km_low, per_km_high = poisson_exact_interval(events, distance_km)
    return {
        "free_episodes": len(free),
        "false_braking": false,
        "false_rate": _ratio(false, len(free)),
        "false_low": low,
        "false_high": high,
        "false_events": events,
        "distance_km": distance_km,
        "false_per_km": _ratio(events, distance_km),
        "false_per_km_low": per_km_low,
        "false_per_km_high": per_km_high,
    }


def _driving(rows: Sequence[Row]) -> Row:
    free = [row for row in rows if not row["is_crossing"]]
    duration_s = sum(row["duration_s"] for row in free)
    return {
        "free_speed_mps": _ratio(1000 * sum(row["distance_km"] for row in free), duration_s),
        "detector_ms": _mean(np.array([row["detector_ms_mean"] for row in rows])),
        "wall_s": sum(row["wall_s"] for row in rows),
        "simulated_s": sum(row["duration_s"] for row in rows),
    }


def compare(rows: Sequence[Row]) -> list[Row]:
    """Every pair of detectors at their main threshold: discordant crossing episodes and the exact McNemar p.

    Returns:
        Rows with first, second, group, pairs, p, and only_first, only_second: collisions of one alone.
    """
    main = [row for row in rows if row["main"] and row["is_crossing"] and row["kind"] == "detector"]
    names = list(dict.fromkeys(row["detector"] for row in main))
    result = []
    for group in dict.fromkeys(group_of(row["weather"]) for row in main):
        hit = {
            (row["detector"], *_episode(row)): bool(row["collision"])
            for row in main
            if group_of(row["weather"]) == group
        }
        for i, first in enumerate(names):
            for second in names[i + 1 :]:
                both = [
                    (hit[k], hit[(second, *k[1:])]) for k in hit if k[0] == first and (second, *k[1:]) in hit
                ]
                only_first = sum(a and not b for a, b in both)
                only_second = sum(b and not a for a, b in both)
                facts = {"first": first, "second": second, "group": group, "pairs": len(both)}
                facts |= {"only_first": only_first, "only_second": only_second}
                result.append(facts | {"p": mcnemar_exact(only_first, only_second)})
    return result


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0 else float("nan")


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if values.size else float("nan")


def _median(values: Sequence[float]) -> float:
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else float("nan")
