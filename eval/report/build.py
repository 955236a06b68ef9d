"""Put the page together: read, compute, draw, render."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from eval.report.figures import FIGURES
from eval.report.results import Results, read_results
from eval.report.tables import (
    checkpoint_table,
    closed_loop_tables,
    offline_table,
    pair_table,
    strata_table,
    verdict_table,
)
from eval.report.words import choice_of_crossings, group_title, played_seeds, summary_sentences, warnings
from pedcross_env.errors import ConfigError

__all__ = ["ReportConfig", "build_report"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportConfig:
    """Settings of ``pedcross report``."""

    out: Path
    """Results folder of ``benchmark`` and ``evaluate``; report.html is written there."""


def build_report(out: Path) -> Path:
    """Write ``report.html`` from whatever ``out`` holds; one file, nothing loaded from elsewhere.

    Args:
        out: Results folder.

    Returns:
        The page's path.

    Raises:
        DataError: If there are no results, or a file is damaged.
        ConfigError: If the page cannot be written.
    """
    results = read_results(out)
    environment = Environment(
        loader=PackageLoader("eval", "report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    drawn = {name: draw(results) for name, draw in FIGURES.items()}
    figures = {name: _data_uri(svg.encode(), "image/svg+xml") if svg else "" for name, svg in drawn.items()}
    page = environment.get_template("report.html.j2").render(
        summary=summary_sentences(results),
        warnings=warnings(results),
        samples=_samples(results),
        offline=offline_table(results),
        strata=strata_table(results),
        loops=closed_loop_tables(results),
        pairs=pair_table(results),
        verdicts=verdict_table(results),
        checkpoints=checkpoint_table(results),
        controls=(results.evaluate or {}).get("controls", {}),
        benchmark=results.benchmark,
        evaluate=results.evaluate,
        played=played_seeds(results),
        chosen=choice_of_crossings(results),
        figures=figures,
        group_title=group_title,
    )
    path = out / "report.html"
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path} cannot be written: {error.strerror}. Choose another folder.") from error
    return path


def _samples(results: Results) -> list[dict[str, Any]]:
    """Sample frames whose two images exist."""
    found = []
    for sample in results.samples:
        images = {m: results.folder / "samples" / f"{sample['weather']}_{m}.png" for m in ("rgb", "dvs")}
        if all(path.exists() for path in images.values()):
            found.append(
                sample | {m: _data_uri(path.read_bytes(), "image/png") for m, path in images.items()}
            )
    return found


def _data_uri(data: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
