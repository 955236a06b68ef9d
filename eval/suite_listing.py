"""Suites and their cells as tables for people."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from pedcross_env.scenario.suites import suite, suite_names
from pedcross_env.scenario.suites.cell import Cell

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["describe", "print_suite", "print_suites"]


def describe(cell: Cell) -> str:
    """What happens in a cell, in a line."""
    if cell.kind == "gap":
        return "between two parked cars"
    if cell.kind == "plate":
        return "over a steel plate"
    who = "child" if cell.child else "adult"
    if cell.kind == "standing":
        return f"{who} stands in the lane, {cell.impact_share:.0%} of the width"
    if cell.kind == "along":
        return f"{who} walks ahead at {cell.pedestrian_kmh:g} km/h, {cell.impact_share:.0%}"
    parts = [
        f"{who if cell.kind == 'crossing' else 'three'} from the {'left' if cell.far_side else 'right'} at "
        f"{cell.pedestrian_kmh:g} km/h, {cell.impact_share:.0%}"
    ]
    parts += ["behind parked cars"] if cell.obstructed else []
    parts += [f"ego turns {cell.turn}, radius {cell.turn_radius_m:g} m"] if cell.turn else []
    parts += [f"path turned by {cell.heading_deg:+g} deg"] if cell.heading_deg else []
    parts += [f"sets off at TTC {cell.trigger_s:g} s"] if cell.trigger_s else []
    return ", ".join(parts)


def print_suites(console: Console) -> None:
    """Print all suites: how many cells, where they come from, how certain."""
    table = _table(("suite", "v", "cells", "what", "certainty"))
    for name in suite_names():
        one = suite(name)
        certainty = ", ".join(dict.fromkeys(cell.provenance.certainty for cell in one.cells))
        table.add_row(name, one.version, str(len(one.cells)), one.title, certainty)
    console.print(table)
    console.print("pedcross suites SUITE lists the cells of one.", highlight=False)


def print_suite(name: str, console: Console) -> None:
    """Print one suite: its source, its cells, what it simplifies."""
    one = suite(name)
    say = lambda text: console.print(text, highlight=False, markup=False, soft_wrap=True)  # noqa: E731
    say(f"{one.name}, version {one.version}: {one.title}")
    say(f"source: {one.source}")
    table = _table(("cell", "ego km/h", "what", "light", "layer", "goal"))
    for cell in one.cells:
        light = cell.weather if cell.headlights == "auto" else f"{cell.weather}, {cell.headlights} beam"
        table.add_row(cell.id, f"{cell.ego_kmh:g}", describe(cell), light, cell.layer, str(cell.goal))
    console.print(table)
    say("where the cells come from:")
    origins = Counter(cell.provenance for cell in one.cells)
    for origin, count in origins.items():
        note = f"; {origin.note}" if origin.note else ""
        say(f"- {count} cells: {origin.clause} [{origin.certainty}]{note}")
    say("simplified or missing:")
    for sentence in one.simplified:
        say(f"- {sentence}")


def _table(head: tuple[str, ...]):  # type: ignore[no-untyped-def]
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for index, name in enumerate(head):
        table.add_column(name, no_wrap=index == 0)
    return table
