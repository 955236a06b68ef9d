"""Every crossing test in every weather: what no protocol asks for."""

from __future__ import annotations

from dataclasses import replace

from pedcross_env.scenario.suites.cell import Goal, Provenance, Suite
from pedcross_env.scenario.suites.euro_ncap import STANDARD_CROSSINGS, crossing_cells, turning_cells
from pedcross_env.weather import WEATHERS

__all__ = ["weather_matrix"]


def weather_matrix() -> Suite:
    """Build the suite."""
    crossings = [cell for cell in crossing_cells() if cell.id.split("/")[0] in STANDARD_CROSSINGS]
    turns = [cell for cell in turning_cells() if cell.layer == "standard"]
    source = Provenance(
        document="pedcross, after Euro NCAP 2026", clause="its crossing and turning cells in each weather",
        certainty="own", note="no protocol tests in bad weather; avoidance may be beyond physics on snow and ice",
    )  # fmt: skip
    return Suite(
        name="weather-matrix",
        version="2",
        title="Euro NCAP's standard crossings and turns in every weather preset",
        source="pedcross: beyond any protocol",
        simplified=("Headlights are as the weather wants them.",),
        cells=tuple(
            replace(
                cell,
                id=f"{cell.id}/{name}",
                weather=name,
                layer="beyond",
                load_kg=None,
                goal=Goal(kind="no-contact"),
                provenance=source,
            )
            for cell in (*crossings, *turns)
            for name in WEATHERS
        ),
    )
