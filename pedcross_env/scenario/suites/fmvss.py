"""FMVSS No. 127: the pedestrian tests of the US rule for automatic emergency braking."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pedcross_env.scenario.suites.cell import Cell, Goal, Provenance, Suite

__all__ = ["fmvss_127"]

_DOCUMENT = "49 CFR 571.127 (FMVSS No. 127), final rule of May 2024"
_LIGHTS = (("/low", "low"), ("/high", "high"))
_FALSE_BRAKING_MPS2 = 0.25 * 9.81


def _row(clause: str, note: str = "steps of 10 km/h and the ends of the stated range") -> Provenance:
    return Provenance(document=_DOCUMENT, clause=clause, certainty="primary", note=note)


def _speeds(cell: Cell, name: str, speeds: tuple[int, ...], *, dark: bool) -> Iterator[Cell]:
    for speed in speeds:
        day = replace(cell, id=f"{name}/{speed}", ego_kmh=speed)
        yield day
        for suffix, beam in _LIGHTS if dark else ():
            yield replace(day, id=day.id + suffix, weather="night_unlit", headlights=beam)  # type: ignore[arg-type]


def fmvss_127() -> Suite:
    """Build the suite."""
    to_60 = (10, 20, 30, 40, 50, 60)
    base = Cell(
        id="", kind="crossing", ego_kmh=10, strict=True, provenance=_row("crossing from the right, 25 %")
    )
    right_50 = replace(base, provenance=_row("crossing from the right, 50 %"))
    left_50 = replace(
        base, far_side=True, pedestrian_kmh=8, start_m=6.0, run_up_m=1.5,
        provenance=_row("crossing from the left, 50 %"),
    )  # fmt: skip
    child = replace(
        base, child=True, obstructed=True, provenance=_row("crossing from the right, obstructed, 50 %")
    )
    standing = replace(
        base, kind="standing", pedestrian_kmh=0, impact_share=0.25, provenance=_row("stationary, 25 %")
    )
    along = replace(base, kind="along", impact_share=0.25, provenance=_row("along the path, 25 %"))
    gap = Cell(
        id="FALSE-GAP/80", kind="gap", ego_kmh=80, layer="false activation",
        goal=Goal(kind="no-braking", limit=_FALSE_BRAKING_MPS2),
        provenance=Provenance(
            document=_DOCUMENT, clause="false activation, between parked vehicles", certainty="memory",
            note="the limit of 0.25 g is from the rule; the gap of 4.5 m is from memory, 80 km/h is that of the plate",
        ),
    )  # fmt: skip
    plate = replace(
        gap, id="FALSE-PLATE/80", kind="plate",
        provenance=Provenance(
            document=_DOCUMENT, clause="false activation, steel trench plate", certainty="secondary",
            note="2.4 x 3.7 m, 25 mm high, at 80 km/h; that its short side faces the ego is from memory",
        ),
    )  # fmt: skip
    return Suite(
        name="fmvss-127",
        version="2",
        title="FMVSS 127, pedestrians: crossing, obstructed, standing, along; day, low and high beam; false activation",
        source=_DOCUMENT,
        simplified=(
            "The rule holds at any speed within its ranges; cells are their ends and steps of 10 km/h between.",
            "Dark is an unlit night with the beam of the cell (at most 0.2 lux are asked for).",
            "Run-ups are Euro NCAP's; a street with houses and sidewalks stands for the proving ground.",
        ),
        cells=(
            *_speeds(replace(base, impact_share=0.25), "PED-RIGHT-25", to_60, dark=False),
            *_speeds(right_50, "PED-RIGHT-50", to_60, dark=True),
            *_speeds(left_50, "PED-LEFT-50", to_60, dark=False),
            *_speeds(child, "PED-OBSTRUCTED-50", to_60[:-1], dark=False),
            *_speeds(standing, "PED-STANDING-25", (10, 20, 30, 40, 50, 55), dark=True),
            *_speeds(along, "PED-ALONG-25", (10, 20, 30, 40, 50, 60, 65), dark=True),
            gap,
            plate,
        ),
    )
