"""UN Regulation No. 152: the pedestrian test at the speeds of both its tables."""

from __future__ import annotations

from pedcross_env.scenario.suites.cell import Cell, Goal, Provenance, Suite

__all__ = ["un_r152"]

_DOCUMENT = "UN Regulation No. 152 (AEBS for M1 and N1), requirements for pedestrians, laden"
ORIGINAL = {20: 0, 25: 0, 30: 0, 35: 20, 40: 25, 45: 30, 50: 35, 55: 40, 60: 45}
"""Ego speed to the highest impact speed allowed, km/h: original version."""
SERIES_01 = {20: 0, 25: 0, 30: 0, 35: 0, 40: 0, 42: 10, 45: 15, 50: 25, 55: 30, 60: 35}
"""The same in the 01 series of amendments."""


def un_r152() -> Suite:
    """Build the suite."""
    cells = []
    for suffix, clause, table in (("", "original", ORIGINAL), ("/01", "01 series", SERIES_01)):
        for speed, limit in table.items():
            goal = Goal(kind="impact-speed", limit=limit) if limit else Goal(kind="no-contact")
            cells.append(
                Cell(
                    id=f"PED-50/{speed}{suffix}",
                    kind="crossing",
                    ego_kmh=speed,
                    child=True,
                    goal=goal,
                    provenance=Provenance(
                        document=_DOCUMENT,
                        clause=f"table of highest impact speeds, {clause}",
                        certainty="secondary",
                        note="impact point, start and run-up are Euro NCAP's for CPNA-50",
                    ),
                )
            )
    return Suite(
        name="un-r152",
        version="1",
        title="UN R152, a child crossing from the near side, by both tables of impact speeds",
        source=_DOCUMENT,
        simplified=(
            "One load: the regulation has tables for masses in running order and laden.",
            "The demanded deceleration of 5 m/s2 is not judged, the impact speed is.",
            "The tests for false reactions are not here.",
        ),
        cells=tuple(cells),
    )
