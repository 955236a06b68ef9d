"""Everything a results folder holds, read once; what is absent is empty."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from eval.store import read_json, read_rows
from eval.summary import compare, summarise
from pedcross_env.errors import DataError

__all__ = ["SUBSET_GROUPS", "Results", "read_results"]

Row = dict[str, Any]

SUBSET_GROUPS = {"default": "clear", "weather": "bad"}
"""Recorded subset to the weather group of the closed loop that it is set against."""


@dataclass(frozen=True, slots=True)
class Results:
    """What ``benchmark`` and ``evaluate`` left.

    Attributes:
        folder: Where it came from.
        clips: Rows of clips.parquet.
        offline: Rows of offline.parquet.
        strata: Rows of strata.parquet.
        episodes: Rows of episodes.parquet.
        closed_loop: ``summarise`` of them.
        pairs: ``compare`` of them.
        benchmark: Provenance of the offline part, or None.
        evaluate: Provenance of the closed loop, or None.
        samples: Facts of the sample frames.
    """

    folder: Path
    clips: list[Row]
    offline: list[Row]
    strata: list[Row]
    episodes: list[Row]
    closed_loop: list[Row]
    pairs: list[Row]
    benchmark: Row | None
    evaluate: Row | None
    samples: list[Row]

    def detectors(self) -> dict[str, Row]:
        """Name to what is known of each detector, of both parts."""
        found: dict[str, Row] = {}
        for part in (self.benchmark, self.evaluate):
            for detector in (part or {}).get("detectors", []):
                found.setdefault(detector["name"], detector)
        return found

    def main(self, group: str) -> list[Row]:
        """Closed-loop rows of a weather group at each source's main threshold."""
        return [row for row in self.closed_loop if row["group"] == group and row["main"]]

    def groups(self) -> list[str]:
        """Weather groups, clear first, then bad, then others."""
        order = {"clear": 0, "bad": 1}
        names = dict.fromkeys(row["group"] for row in self.closed_loop)
        return sorted(names, key=lambda name: (order.get(name, 2), name))


def read_results(folder: Path) -> Results:
    """Read a results folder.

    Raises:
        DataError: If it holds neither offline nor closed-loop results, or a file is damaged.
    """
    offline, episodes = read_rows(folder / "offline.parquet"), read_rows(folder / "episodes.parquet")
    if not offline and not episodes:
        raise DataError(
            f"{folder} holds no results (offline.parquet, episodes.parquet); "
            "run 'pedcross benchmark' or 'pedcross evaluate' with this --out first."
        )
    return Results(
        folder=folder,
        clips=read_rows(folder / "clips.parquet"),
        offline=offline,
        strata=read_rows(folder / "strata.parquet"),
        episodes=episodes,
        closed_loop=summarise(episodes),
        pairs=compare(episodes),
        benchmark=read_json(folder / "benchmark.json"),
        evaluate=read_json(folder / "evaluate.json"),
        samples=read_json(folder / "samples" / "samples.json") or [],
    )
