"""Euro NCAP's pedestrian tests of 2026, at every speed and impact point, and their robustness layer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

from pedcross_env.scenario.suites.cell import Cell, Goal, Provenance, Suite

__all__ = ["POINTS", "STANDARD_CROSSINGS", "crossing_cells", "euro_ncap_2026", "turning_cells"]

SPEEDS_KMH = (10, 20, 30, 40, 50, 60)
POINTS = ((0.0, 1.0), (10.0, 0.75), (20.0, 0.5), (30.0, 0.25))
"""Share of a cell's points up to an impact speed in km/h; faster gives none."""
SCORE = "points by impact speed are stated for 60 km/h; elsewhere avoidance alone is certain"
STANDARD_CROSSINGS = ("CPFA-50", "CPNA-25", "CPNA-75", "CPNCO-50")
"""The crossing scenarios at their own impact points."""
_DOCUMENT = "Euro NCAP AEB/LSS VRU test protocol v4.5.1 and the 2026 split (Safe Driving, Crash Avoidance)"


def _from(clause: str, note: str = "") -> Provenance:
    return Provenance(document=_DOCUMENT, clause=clause, certainty="secondary", note=note)


def _points(ego_kmh: float) -> Goal:
    return Goal(kind="points", points=POINTS, certain=ego_kmh == 60)


def _impacts(
    cell: Cell, scenario: str, standard: tuple[int, ...], extended: tuple[int, ...]
) -> Iterator[Cell]:
    """The cell at all its speeds and impact points."""
    for percent in (*standard, *extended):
        for speed in SPEEDS_KMH:
            yield replace(
                cell, id=f"{scenario}-{percent}/{speed}", ego_kmh=speed, impact_share=percent / 100,
                layer="standard" if percent in standard else "extended", goal=_points(speed),
            )  # fmt: skip


def crossing_cells() -> list[Cell]:
    """CPFA, CPNA and CPNCO by day, at standard and extended impact points."""
    far = Cell(id="", kind="crossing", ego_kmh=10, pedestrian_kmh=8, far_side=True, start_m=6.0, run_up_m=1.5,
               provenance=_from("CPFA", SCORE))  # fmt: skip
    near = Cell(id="", kind="crossing", ego_kmh=10, provenance=_from("CPNA", SCORE))
    child = Cell(
        id="", kind="crossing", ego_kmh=10, child=True, obstructed=True, provenance=_from("CPNCO", SCORE)
    )
    return [
        *_impacts(far, "CPFA", (50,), (10, 25, 75, 90)),
        *_impacts(near, "CPNA", (25, 50, 75), (10, 90)),
        *_impacts(child, "CPNCO", (50,), (25, 75)),
    ]


def turning_cells() -> list[Cell]:
    """CPTA: the ego turns, the pedestrian crosses the street turned into, coming from either side."""
    note = "which way the pedestrian walks at which speed is from memory: both are here"
    turns: tuple[tuple[str, Literal["left", "right"], tuple[tuple[int, float], ...]], ...] = (
        ("CPTA-far", "left", ((10, 9.0), (15, 11.75), (20, 14.75))),
        ("CPTA-near", "right", ((10, 8.0),)),
    )
    cells = []
    for scenario, turn, speeds in turns:
        for speed, radius in speeds:
            for way in ("", "/opposite"):  # with the ego's first direction, or against it
                from_left = (turn == "left") is (way == "")
                cells.append(
                    Cell(
                        id=f"{scenario}-50/{speed}{way}",
                        kind="crossing",
                        ego_kmh=speed,
                        turn=turn,
                        turn_radius_m=radius,
                        far_side=from_left,
                        start_m=6.0 if from_left else 4.0,
                        goal=Goal(kind="no-contact"),
                        provenance=_from("CPTA", note),
                    )
                )
    return cells


def _along_cells() -> Iterator[Cell]:
    for percent in (50, 10, 25, 75):
        for speed in (20, 30, 40, 50, 60):
            yield Cell(
                id=f"CPLA-{percent}/{speed}",
                kind="along",
                ego_kmh=speed,
                impact_share=percent / 100,
                layer="standard" if percent == 50 else "extended",
                goal=_points(speed),
                provenance=_from("CPLA, AEB", SCORE),
            )
    for speed in (50, 60, 70, 80):
        yield Cell(
            id=f"CPLA-25/{speed}/warning", kind="along", ego_kmh=speed, impact_share=0.25,
            goal=Goal(kind="reaction", limit=1.7),
            provenance=_from("CPLA, FCW", "the protocol asks for a warning; here the first braking counts as one"),
        )  # fmt: skip


def _robustness(standard: list[Cell]) -> Iterator[Cell]:
    note = "to which cells the layer belongs is this project's choice: every standard crossing; timed anew"
    for cell in standard:
        base = replace(cell, layer="robustness", provenance=_from("robustness layer", note))
        yield replace(base, id=f"{cell.id}/ped+3", pedestrian_kmh=cell.pedestrian_kmh + 3)
        yield replace(base, id=f"{cell.id}/ped-2", pedestrian_kmh=cell.pedestrian_kmh - 2)
        yield replace(base, id=f"{cell.id}/start-25", start_m=0.75 * cell.start_m)
        for angle in (20, -20):
            yield replace(base, id=f"{cell.id}/heading{angle:+d}", heading_deg=angle)


def euro_ncap_2026() -> Suite:
    """Build the suite."""
    crossings = crossing_cells()
    standard = [cell for cell in crossings if cell.layer == "standard"]
    named = [cell for cell in standard if cell.id.split("/")[0] in STANDARD_CROSSINGS]
    along = list(_along_cells())
    dark = [cell for cell in (*standard, *along) if cell.layer == "standard" and not cell.obstructed]
    night = [
        replace(
            cell,
            id=f"{cell.id}/night",
            weather="night_unlit",
            headlights="low",
            provenance=replace(
                cell.provenance,
                note="which scenarios have a night is from memory; 1 lux is taken as unlit, low beam",
            ),
        )
        for cell in dark
    ]
    slow = Cell(
        id="CPNA-75/20/ped3", kind="crossing", ego_kmh=20, pedestrian_kmh=3, impact_share=0.75, layer="robustness",
        goal=Goal(kind="speed-reduction"), provenance=_from("robustness layer"),
    )  # fmt: skip
    return Suite(
        name="euro-ncap-2026",
        version="1",
        title="Euro NCAP 2026, pedestrians: crossing, along, turning; day, night, robustness",
        source=_DOCUMENT,
        simplified=(
            "CPRA (reversing) is missing: the ego has no reverse gear and no camera to the rear.",
            "The test begins 4 s before the contact, earlier where the pedestrian needs longer for its way.",
            "A street with houses stands for the proving ground; dummies are people of the dummies' heights.",
            "A child's footprint is the adult dummy's, scaled by its height (0.38 x 0.32 m instead of 0.71 x 0.30 m).",
            "CPTA: quarter circles of the stated radii without clothoids; the contact is on the straight beyond.",
            "CPLA-25 asks for a warning; the first braking stands for it.",
            "The bonus for steering away and the weights that make stars of cells are not here.",
        ),
        cells=(*crossings, *along, *turning_cells(), *night, *_robustness(named), slow),
    )
