"""Euro NCAP's pedestrian tests of 2026: every speed and impact point, by day and night, and their robustness layer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Literal

from pedcross_env.scenario.suites.cell import Cell, Goal, Provenance, Share, Suite

__all__ = ["POINTS", "STANDARD_CROSSINGS", "crossing_cells", "euro_ncap_2026", "turning_cells"]

SPEEDS_KMH = (10, 20, 30, 40, 50, 60)
POINTS = ((0.0, 1.0), (10.0, 0.75), (20.0, 0.5), (30.0, 0.25))
"""Share of a cell's points up to an impact speed in km/h; faster gives none."""
NOT_RED = ((30.0, 1.0),)
"""The same where any colour but red is enough: extended impact points, and part of the robustness layer."""
STANDARD_CROSSINGS = ("CPFA-50", "CPNA-25", "CPNA-75", "CPNCO-50")
"""The crossing scenarios at their own impact points."""
GROUPS = (
    ("CPLA day", 1.0), ("CPLA night", 1.0), ("CPTAfs CPTAns day", 1.0), ("CPTAfo CPTAno day", 1.0), ("CPNA day", 0.5),
    ("CPNA night", 0.5), ("CPFA day", 0.5), ("CPFA night", 0.5), ("CPNCO day", 1.0), ("CPNCO night", 1.0),
)  # fmt: skip
"""What is rated together, and its points in the standard range (3.2); the extended range has an eighth of them."""
EXTENDED_STEPS = ((0.5, 0.5), (0.75, 0.75), (1.0, 1.0))
TEST_LOAD_KG = 125.0
"""200 kg beyond the kerb mass, in which no driver is counted; 75 kg of them are the driver's in running order."""
_DOCUMENT = "Euro NCAP Crash Avoidance, Frontal Collisions, protocol v1.1 (October 2025)"
_SCORE = "the bands of impact speeds are stated for 60 km/h; below, that red begins at half the speed is our choice"
_SPLIT = "which impact points are standard is from a transcription: the text that was read has lost the cells' colours"
_PLACES = "start and run-up are v4.5.1's: they are in the figures"


def _from(clause: str, *notes: str) -> Provenance:
    return Provenance(document=_DOCUMENT, clause=clause, certainty="primary", note="; ".join(notes))


def _points(ego_kmh: float, layer: str, *, relative_kmh: float | None = None) -> Goal:
    """Bands of a cell's test speed, relative to the pedestrian's; below 60 km/h red begins at half of it, as at 60."""
    bands: tuple[tuple[float, float], ...] = NOT_RED if layer == "extended" else POINTS
    if ego_kmh < 60:
        red_from = 0.5 * (ego_kmh if relative_kmh is None else relative_kmh)
        below = [limit for limit, _ in bands if limit < red_from]
        bands = tuple((min(limit, red_from), won) for limit, won in bands[: len(below) + 1])
    return Goal(kind="points", points=bands, certain=ego_kmh == 60)


def _impacts(
    cell: Cell, scenario: str, standard: tuple[int, ...], extended: tuple[int, ...]
) -> Iterator[Cell]:
    """The cell at all its speeds and impact points."""
    for percent in (*standard, *extended):
        layer = "standard" if percent in standard else "extended"
        for speed in SPEEDS_KMH:
            yield replace(
                cell, id=f"{scenario}-{percent}/{speed}", ego_kmh=speed, impact_share=percent / 100, layer=layer,
                load_kg=TEST_LOAD_KG, goal=_points(speed, layer),
            )  # fmt: skip


def crossing_cells() -> list[Cell]:
    """CPFA, CPNA and CPNCO by day, at standard and extended impact points."""
    notes = (_SCORE, _SPLIT, _PLACES)
    far = Cell(id="", kind="crossing", ego_kmh=10, pedestrian_kmh=8, far_side=True, start_m=6.0, run_up_m=1.5,
               provenance=_from("3.2.3.1 CPFA", *notes))  # fmt: skip
    near = Cell(id="", kind="crossing", ego_kmh=10, provenance=_from("3.2.3.1 CPNA", *notes))
    child = Cell(id="", kind="crossing", ego_kmh=10, child=True, obstructed=True,
                 provenance=_from("3.2.3.1 CPNCO, appendix B", *notes))  # fmt: skip
    return [
        *_impacts(far, "CPFA", (50,), (10, 25, 75, 90)),
        *_impacts(near, "CPNA", (25, 50, 75), (10, 90)),
        *_impacts(child, "CPNCO", (50,), (25, 75)),
    ]


def turning_cells() -> list[Cell]:
    """CPTA at 50 %: who crosses the street that the ego turns into walks as the ego drove, or against it."""
    found: list[Cell] = []
    turns: tuple[tuple[str, Literal["left", "right"], tuple[tuple[int, float], ...]], ...] = (
        ("f", "left", ((10, 9.0), (15, 11.75), (20, 14.75), (25, 14.75))),
        ("n", "right", ((10, 8.0),)),
    )
    for towards, turn, speeds in turns:
        for way in ("s", "o"):  # the same direction as the ego before its turn, or the opposite one
            from_left = (turn == "left") is (way == "s")
            for speed, radius in speeds:
                found.append(
                    Cell(
                        id=f"CPTA{towards}{way}-50/{speed}", kind="crossing", ego_kmh=speed, turn=turn,
                        turn_radius_m=radius, far_side=from_left, start_m=6.0 if from_left else 4.0,
                        layer="extended" if speed == 25 else "standard", load_kg=TEST_LOAD_KG,
                        goal=Goal(kind="no-contact"), provenance=_from("3.2.2.1 CPTA, 1.2.4", _PLACES),
                    )
                )  # fmt: skip
    return found


def _turning_beside(cells: Iterable[Cell]) -> Iterator[Cell]:
    """The turns at the other impact points."""
    for cell in cells:
        for percent in (10, 25, 75, 90):
            yield replace(
                cell, id=cell.id.replace("-50/", f"-{percent}/"), impact_share=percent / 100, layer="extended",
                provenance=_from("3.2.2.1 CPTA, 1.2.4", _SPLIT, _PLACES),
            )  # fmt: skip


def _along_cells() -> Iterator[Cell]:
    for percent in (50, 10, 25, 75):
        layer = "standard" if percent == 50 else "extended"
        for speed in SPEEDS_KMH:
            yield Cell(
                id=f"CPLA-{percent}/{speed}", kind="along", ego_kmh=speed, impact_share=percent / 100, layer=layer,
                load_kg=TEST_LOAD_KG, goal=_points(speed, layer, relative_kmh=speed - 5),
                provenance=_from("3.2.1.1 CPLA, AEB; relative impact speed", _SCORE, _SPLIT),
            )  # fmt: skip
    note = "the protocol asks for a warning; here the first braking counts as one"
    for speed in (50, 60, 70, 80):
        yield Cell(
            id=f"CPLA-25/{speed}/warning", kind="along", ego_kmh=speed, impact_share=0.25, load_kg=TEST_LOAD_KG,
            goal=Goal(kind="reaction", limit=1.7), provenance=_from("3.2.1.1 CPLA, FCW", note, _SPLIT),
        )  # fmt: skip


def _robustness(crossings: Iterable[Cell], turns: Iterable[Cell]) -> Iterator[Cell]:
    """Speed, initial position and heading of the target varied (5.2.1.3), of the standard cells by day."""
    source = _from("5.2.1.3 robustness layers", "timed anew, so that the impact point stays", _SCORE)
    for cell in crossings:
        base = replace(cell, layer="robustness", provenance=source)
        not_red = _points(cell.ego_kmh, "extended")
        faster, slower = cell.pedestrian_kmh + 3, cell.pedestrian_kmh - 2
        yield replace(base, id=f"{cell.id}/ped+3", pedestrian_kmh=faster, goal=not_red)
        yield replace(base, id=f"{cell.id}/ped-2", pedestrian_kmh=slower)
        yield replace(base, id=f"{cell.id}/start-25", start_m=0.75 * cell.start_m, goal=not_red)
        for angle in (20, -20):
            yield replace(base, id=f"{cell.id}/heading{angle:+d}", heading_deg=angle)
    for cell in turns:
        base = replace(cell, layer="robustness", provenance=source)
        yield replace(base, id=f"{cell.id}/ped+3", pedestrian_kmh=cell.pedestrian_kmh + 3)
        yield replace(base, id=f"{cell.id}/start-25", start_m=0.75 * cell.start_m)


def _at_night(cells: Iterable[Cell]) -> Iterator[Cell]:
    note = "low beam, as for cars without automatic high beam; an unlit street stands for 1 lux"
    for cell in cells:
        origin = replace(cell.provenance, note="; ".join(filter(None, (cell.provenance.note, note))))
        yield replace(cell, id=f"{cell.id}/night", weather="night_unlit", headlights="low", provenance=origin)


def _rating(cells: Iterable[Cell]) -> Iterator[Share]:
    """Points of the standard and the extended range (3.2, 5.3)."""
    for group, worth in GROUPS:
        *scenarios, light = group.split()
        own = [
            cell for cell in cells
            if cell.id.split("-")[0] in scenarios and (cell.weather == "night_unlit") is (light == "night")
        ]  # fmt: skip
        for layer, share, steps in (("standard", 1.0, ()), ("extended", 0.125, EXTENDED_STEPS)):
            ids = tuple(cell.id for cell in own if cell.layer == layer)
            yield Share(name=f"{group}, {layer}", cells=ids, worth=share * worth, steps=steps)


def euro_ncap_2026() -> Suite:
    """Build the suite."""
    crossings, turns, along = crossing_cells(), turning_cells(), list(_along_cells())
    named = [cell for cell in crossings if cell.id.split("/")[0] in STANDARD_CROSSINGS]
    slow = Cell(
        id="CPNA-75/20/ped3", kind="crossing", ego_kmh=20, pedestrian_kmh=3, impact_share=0.75, layer="robustness",
        load_kg=TEST_LOAD_KG, goal=Goal(kind="speed-reduction"), provenance=_from("5.1 general requirements", _PLACES),
    )  # fmt: skip
    cells = (
        *crossings,
        *along,
        *turns,
        *_turning_beside(turns),
        *_at_night((*crossings, *along)),
        *_robustness(named, [cell for cell in turns if cell.layer == "standard"]),
        slow,
        *_at_night([slow]),
    )
    return Suite(
        name="euro-ncap-2026",
        version="2",
        title="Euro NCAP 2026, pedestrians: crossing, along, turning; day, night, robustness",
        source=_DOCUMENT,
        simplified=(
            "CPRA (reversing) is missing: the ego has no reverse gear and no camera to the rear.",
            "The test begins 4 s before the contact, earlier where the pedestrian needs longer for its way.",
            "A street with houses stands for the proving ground, its friction of 0.85 for a peak of 0.9 or more; "
            "dummies are people of the dummies' heights.",
            "A child's footprint is the adult dummy's, scaled by its height (0.38 x 0.32 m instead of 0.71 x 0.30 m).",
            "CPTA: quarter circles of the stated radii without clothoids; the contact is on the straight beyond.",
            "CPLA-25 asks for a warning; the first braking stands for it.",
            "Of the robustness layer the target's speed, position and heading are here; weather is the weather matrix.",
            "The rating has the standard and the extended range; of the robustness layers' points too little is here.",
            "The bonus for steering away is not here.",
        ),
        cells=cells,
        rating=tuple(_rating(cells)),
    )
