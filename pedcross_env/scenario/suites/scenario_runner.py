"""The four pedestrian scenarios of CARLA's ScenarioRunner, which the Leaderboard's routes are made of."""

from __future__ import annotations

from dataclasses import replace

from pedcross_env.scenario.suites.cell import Cell, Provenance, Suite

__all__ = ["scenario_runner"]

_DOCUMENT = "CARLA ScenarioRunner, srunner/scenarios"
_OWN_SPEEDS = "ego speeds are this project's: there the route's agent chooses them"


def _from(clause: str) -> Provenance:
    return Provenance(document=_DOCUMENT, clause=clause, certainty="primary", note=_OWN_SPEEDS)


def scenario_runner() -> Suite:
    """Build the suite."""
    base = Cell(
        id="", kind="crossing", ego_kmh=30, pedestrian_kmh=7.2, run_up_m=0.0, trigger_s=2.1, obstructed=True,
        provenance=_from("DynamicObjectCrossing: 2.0 m/s, reaction 2.1 s"),
    )  # fmt: skip
    parked = replace(
        base, trigger_s=2.15, provenance=_from("ParkingCrossingPedestrian: 2.0 m/s, reaction 2.15 s")
    )
    group = replace(
        base, kind="group", trigger_s=3.5, obstructed=False, far_side=True,
        provenance=_from("PedestrianCrossing: three, 1.3 to 2.0 m/s, reaction 3.5 s, idle 0 to 1.5 s"),
    )  # fmt: skip
    turning = replace(
        base, pedestrian_kmh=6.48, trigger_s=2.2, obstructed=False, turn="right", turn_radius_m=8.0,
        provenance=_from("VehicleTurningRoutePedestrian: 1.8 m/s, reaction 2.2 s"),
    )  # fmt: skip
    cells = [
        replace(cell, id=f"{name}-50/{speed}", ego_kmh=speed)
        for name, cell, speeds in (
            ("DynamicObjectCrossing", base, (20, 30, 40, 50)),
            ("ParkingCrossingPedestrian", parked, (20, 30, 40, 50)),
            ("PedestrianCrossing", group, (20, 30, 40, 50)),
            ("VehicleTurningRoutePedestrian", turning, (10, 15, 20)),
        )
        for speed in speeds
    ]
    return Suite(
        name="scenario-runner",
        version="1",
        title="CARLA ScenarioRunner's pedestrians, who set off when the ego would arrive in their reaction time",
        source=_DOCUMENT,
        simplified=(
            "The pedestrian starts where an ego that holds its speed meets it at 50 % of its width.",
            "The second condition, the nearest trigger of 6 or 12 m, is left out: it acts on egos that creep.",
            "Kerbside blockers (a vending machine, a bus stop) are the two parked cars of CPNCO.",
        ),
        cells=tuple(cells),
    )
