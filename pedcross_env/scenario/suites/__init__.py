"""Suites of cells: the tests by which cars are rated, as scenarios.

``suite(name)`` gives one; ``SUITES`` names all without building them.
"""

from __future__ import annotations

import importlib
from functools import cache

from pedcross_env.errors import unknown_name
from pedcross_env.scenario.suites.cell import Cell, Goal, Provenance, Suite

__all__ = ["SUITES", "Cell", "Goal", "Provenance", "Suite", "register_suite", "suite", "suite_names"]

SUITES: dict[str, str] = {
    "euro-ncap-2026": "pedcross_env.scenario.suites.euro_ncap:euro_ncap_2026",
    "fmvss-127": "pedcross_env.scenario.suites.fmvss:fmvss_127",
    "un-r152": "pedcross_env.scenario.suites.un_r152:un_r152",
    "scenario-runner": "pedcross_env.scenario.suites.scenario_runner:scenario_runner",
    "weather-matrix": "pedcross_env.scenario.suites.weather_matrix:weather_matrix",
}
"""Name to "module:function without arguments that builds the suite"."""

_OWN: dict[str, Suite] = {}


def suite_names() -> tuple[str, ...]:
    """Return every name ``suite`` accepts."""
    return (*SUITES, *_OWN)


def suite(name: str) -> Suite:
    """Return the suite called ``name``.

    Raises:
        ConfigError: For an unknown one; names the nearest.
    """
    if name in _OWN:
        return _OWN[name]
    if name not in SUITES:
        raise unknown_name("suite", name, suite_names())
    return _built(SUITES[name])


@cache
def _built(place: str) -> Suite:
    module, _, function = place.partition(":")
    made: Suite = getattr(importlib.import_module(module), function)()
    return made


def register_suite(own: Suite) -> None:
    """Make a user's suite known by its name, in this process.

    Raises:
        ConfigError: If another suite has that name.
    """
    from pedcross_env.config import require

    taken = own.name in SUITES or _OWN.get(own.name, own) != own
    require(not taken, "Suite.name", own.name, "a name that no other suite has")
    _OWN[own.name] = own
