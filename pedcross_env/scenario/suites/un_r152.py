"""UN Regulation No. 152: the pedestrian test at the speeds of both its tables, in both loads."""

from __future__ import annotations

from pedcross_env.scenario.suites.cell import Cell, Goal, Provenance, Suite

__all__ = ["un_r152"]

_DOCUMENT = "UN Regulation No. 152 (AEBS for M1 and N1), requirements for pedestrians"
ORIGINAL = {20: 0, 25: 0, 30: 0, 35: 20, 40: 25, 45: 30, 50: 35, 55: 40, 60: 45}
"""Ego speed to the highest impact speed allowed, km/h: original version."""
SERIES_01 = {20: 0, 25: 0, 30: 0, 35: 0, 40: 0, 42: 10, 45: 15, 50: 25, 55: 30, 60: 35}
"""The same in the 01 series of amendments."""
LEAST_DEMAND_MPS2 = 5.0
LADEN_KG = 450.0
"""From running order to the maximum mass: usual for a car of 1.5 t."""


def un_r152() -> Suite:
    """Build the suite."""
    cells = []
    for suffix, clause, table in (("", "original", ORIGINAL), ("/01", "01 series", SERIES_01)):
        source = Provenance(
            document=_DOCUMENT, clause=f"table of highest impact speeds, {clause}", certainty="secondary",
            note="both loads have the same limits; start and run-up are Euro NCAP's for CPNA-50",
        )  # fmt: skip
        for load, load_kg in (("", 0.0), ("/laden", LADEN_KG)):
            for speed, limit in table.items():
                goal = Goal(
                    kind="impact-speed" if limit else "no-contact",
                    limit=limit,
                    least_demand_mps2=LEAST_DEMAND_MPS2,
                )
                cells.append(
                    Cell(
                        id=f"PED-50/{speed}{suffix}{load}", kind="crossing", ego_kmh=speed, child=True, load_kg=load_kg,
                        goal=goal, provenance=source,
                    )
                )  # fmt: skip
    return Suite(
        name="un-r152",
        version="2",
        title="UN R152, a child crossing from the near side, by both tables of impact speeds, unladen and laden",
        source=_DOCUMENT,
        simplified=(
            f"Laden is {LADEN_KG:g} kg more, which the brakes' force has to stop too; the regulation has the car's "
            "maximum mass.",
            "The demand of 5 m/s2 is judged by the strongest braking that was demanded.",
            "The tests for false reactions are not here.",
        ),
        cells=tuple(cells),
    )
