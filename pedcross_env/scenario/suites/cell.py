"""A cell: one test of a protocol, from which a scenario follows; a suite: a named, versioned list of cells."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Literal

from pedcross_env.config import EgoConfig, require
from pedcross_env.errors import ConfigError, nearest, unknown_name
from pedcross_env.scenario.scenario import Scenario

__all__ = ["Cell", "Goal", "Kind", "Provenance", "Share", "Suite"]

Kind = Literal["crossing", "along", "standing", "group", "gap", "plate"]
KINDS: tuple[Kind, ...] = ("crossing", "along", "standing", "group", "gap", "plate")
NOBODY: tuple[Kind, ...] = ("gap", "plate")
"""Kinds in which there is nobody to brake for."""
Certainty = Literal["primary", "secondary", "memory", "own"]
CERTAINTIES: tuple[Certainty, ...] = ("primary", "secondary", "memory", "own")


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Where a cell's numbers come from.

    Attributes:
        document: Name of the source.
        clause: Where in it, or which of its tables.
        certainty: "primary": the document itself was read; "secondary": a transcription of it; "memory": written from
            memory, to be checked; "own": this project's choice.
        note: What of the cell is less certain than that, or simplified.
    """

    document: str
    clause: str
    certainty: Certainty
    note: str = ""

    def __post_init__(self) -> None:
        if self.certainty not in CERTAINTIES:
            raise unknown_name("certainty", self.certainty, CERTAINTIES)


@dataclass(frozen=True, slots=True, kw_only=True)
class Goal:
    """What a cell asks of the car.

    Attributes:
        kind: "no-contact"; "impact-speed" (at most ``limit``, km/h); "points" (by impact speed: ``points``);
            "speed-reduction" (any before the contact); "reaction" (brakes at a time to contact of ``limit`` s or more);
            "no-braking" (decelerates by less than ``limit``, m/s2).
        limit: See there.
        points: For "points": (highest impact speed in km/h, points), ascending; faster gives none.
        least_demand_mps2: Besides, the strongest braking demanded must be this or more.
        certain: Whether the source states this rule for this cell.
    """

    kind: Literal["no-contact", "impact-speed", "points", "speed-reduction", "reaction", "no-braking"]
    limit: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    least_demand_mps2: float = 0.0
    certain: bool = True

    def __str__(self) -> str:
        """For tables."""
        text = {
            "no-contact": "no contact",
            "impact-speed": f"impact <= {self.limit:g} km/h",
            "points": "points by impact speed",
            "speed-reduction": "some speed reduction",
            "reaction": f"reacts at TTC >= {self.limit:g} s",
            "no-braking": f"brakes < {self.limit / 9.81:.2f} g",
        }[self.kind]
        text += f", demands >= {self.least_demand_mps2:g} m/s2" if self.least_demand_mps2 else ""
        return text if self.certain else text + " (uncertain)"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One test: who walks how, where the ego's front would meet it, in what light, and what counts as passed.

    The timing follows: an ego that never brakes meets the pedestrian at ``impact_share`` of its width.

    Attributes:
        id: Unique in its suite: scenario-impact point/ego km/h, then /night and the like.
        kind: "crossing"; "along": walks ahead in the lane; "standing" in the lane; "group": three who cross one after
            the other; "gap": nobody, two parked cars to drive between; "plate": nobody, a steel plate to drive over.
        ego_kmh: Speed of the ego.
        pedestrian_kmh: Speed of the pedestrian, 0 for who stands.
        impact_share: Place of the first contact on the ego's width, 0 its near (right) side.
        far_side: Whether it comes from the left.
        child: A child of 1.15 m, else an adult of 1.8 m (Euro NCAP's dummies).
        obstructed: By a small car and an SUV parked before its path.
        start_m: Where it starts, to the side of the ego's middle.
        run_up_m: Over which it speeds up; 0: within 0.3 s.
        heading_deg: By how much its path deviates from the perpendicular, positive: with the ego's direction.
        turn: Of the ego, at an intersection; the pedestrian crosses the street turned into.
        turn_radius_m: Of that turn.
        ttc_s: Time to the contact at the start, lengthened for those who need more for their way unless ``strict``.
        strict: Whether ``ttc_s`` may not be lengthened.
        trigger_s: Instead of by the clock it sets off when the ego would arrive in so many seconds; 0: by the clock.
        weather: Name of a weather.
        headlights: Of the ego; "auto": as the weather wants.
        load_kg: Of the ego, beyond its mass in running order; None: as its config says.
        layer: "standard", "extended", "robustness", "false activation" or "beyond".
        goal: What is asked.
        provenance: Where it comes from.
    """

    id: str
    kind: Kind
    ego_kmh: float
    pedestrian_kmh: float = 5.0
    impact_share: float = 0.5
    far_side: bool = False
    child: bool = False
    obstructed: bool = False
    start_m: float = 4.0
    run_up_m: float = 1.0
    heading_deg: float = 0.0
    turn: Literal["", "left", "right"] = ""
    turn_radius_m: float = 9.0
    ttc_s: float = 4.0
    strict: bool = False
    trigger_s: float = 0.0
    weather: str = "clear"
    headlights: Literal["auto", "low", "high"] = "auto"
    load_kg: float | None = None
    layer: str = "standard"
    goal: Goal = field(default_factory=lambda: Goal(kind="no-contact"))
    provenance: Provenance

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise unknown_name("Cell.kind", self.kind, KINDS)
        if self.turn not in ("", "left", "right"):
            raise unknown_name("Cell.turn", self.turn, ("left", "right"))
        name = f"Cell({self.id!r})"
        require(0 < self.ego_kmh <= 140, f"{name}.ego_kmh", self.ego_kmh, "above 0, at most 140, e.g. 40")
        low = 0.0 if self.kind in ("standing", *NOBODY) else 0.1
        require(
            low <= self.pedestrian_kmh <= 36, f"{name}.pedestrian_kmh", self.pedestrian_kmh,
            f"{low:g} to 36, e.g. 5",
        )  # fmt: skip
        require(0 <= self.impact_share <= 1, f"{name}.impact_share", self.impact_share, "0 to 1, e.g. 0.5")
        require(0 < self.start_m <= 12, f"{name}.start_m", self.start_m, "above 0, at most 12 m, e.g. 4")
        require(0 <= self.run_up_m < self.start_m, f"{name}.run_up_m", self.run_up_m,
                f"0 to less than start_m ({self.start_m:g}), e.g. 1")  # fmt: skip
        require(abs(self.heading_deg) <= 45, f"{name}.heading_deg", self.heading_deg, "-45 to 45")
        require(0.5 <= self.ttc_s <= 30, f"{name}.ttc_s", self.ttc_s, "0.5 to 30 s, e.g. 4")
        require(0 <= self.trigger_s <= 30, f"{name}.trigger_s", self.trigger_s, "0 (none) to 30 s")
        load_kg = self.load_kg
        require(load_kg is None or 0 <= load_kg <= 5000, f"{name}.load_kg", load_kg, "0 to 5000, or None")
        require(5 <= self.turn_radius_m <= 20, f"{name}.turn_radius_m", self.turn_radius_m, "5 to 20 m")
        require(
            not self.turn or (self.kind == "crossing" and not self.obstructed), f"{name}.turn", self.turn,
            "'' unless kind is 'crossing' without obstruction",
        )  # fmt: skip
        if self.kind == "along":
            require(
                self.ego_kmh > self.pedestrian_kmh, f"{name}.ego_kmh", self.ego_kmh,
                f"above pedestrian_kmh ({self.pedestrian_kmh:g}), whom it could not reach",
            )  # fmt: skip

    @property
    def hits(self) -> bool:
        """Whether an ego that never brakes touches somebody."""
        return self.kind not in NOBODY

    @property
    def ego_mps(self) -> float:
        """Speed of the ego."""
        return self.ego_kmh / 3.6

    def scenario(self, ego: EgoConfig | None = None, *, seed: int = 0) -> Scenario:
        """Build the cell's scenario.

        Args:
            ego: Its length and width enter the timing.
            seed: Of looks alone: houses, clothes, paint.

        Raises:
            ConfigError: For a timing that cannot be.
        """
        from pedcross_env.scenario.suites.build import build_scenario

        return build_scenario(self, ego if ego is not None else EgoConfig(), seed)


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """What a group of cells is worth in the protocol's rating.

    Attributes:
        name: Of the group.
        cells: Ids of the group's cells in which it is won.
        worth: Points of the rating, for all cells' points.
        steps: (mean of the cells' points, share of ``worth`` won from there on), ascending; empty: in proportion.
    """

    name: str
    cells: tuple[str, ...]
    worth: float
    steps: tuple[tuple[float, float], ...] = ()

    def won(self, mean_points: float) -> float:
        """Points of the rating for a mean of the cells' points, 0 to 1."""
        if not self.steps:
            return self.worth * mean_points
        return self.worth * max((won for least, won in self.steps if mean_points >= least), default=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Suite:
    """A named, versioned list of cells.

    Attributes:
        name: As the command line has it.
        version: Goes up when a cell's scenario or goal changes.
        title: One line.
        source: What it transcribes.
        simplified: What of the protocol is missing or different here, one sentence each.
        cells: In the order of tables.
        rating: How the protocol adds up the cells' points; empty where it has no such rule.
    """

    name: str
    version: str
    title: str
    source: str
    simplified: tuple[str, ...]
    cells: tuple[Cell, ...]
    rating: tuple[Share, ...] = ()

    def __post_init__(self) -> None:
        ids = [cell.id for cell in self.cells]
        twice = sorted(name for name, count in Counter(ids).items() if count > 1)
        require(not twice, f"Suite({self.name!r}).cells", twice, "cells with ids of their own")
        require(len(ids) > 0, f"Suite({self.name!r}).cells", (), "at least one cell")
        for share in self.rating:
            known = len(share.cells) > 0 and set(share.cells) <= set(ids)
            require(known, f"Suite({self.name!r}).rating", share.name, "of one cell or more of the suite")

    def cell(self, cell_id: str) -> Cell:
        """Return the cell called ``cell_id``.

        Raises:
            ConfigError: For an unknown one; names the nearest.
        """
        for cell in self.cells:
            if cell.id == cell_id:
                return cell
        by_low = {cell.id.lower(): cell.id for cell in self.cells}
        if str(cell_id).lower() in by_low:
            close: str | None = by_low[str(cell_id).lower()]
        else:
            found = nearest(str(cell_id), by_low)
            close = by_low[found] if found else None
        hint = f" Did you mean {close!r}?" if close else ""
        raise ConfigError(
            f"unknown cell {cell_id!r} of suite {self.name!r}.{hint} It has {len(self.cells)} cells, e.g. "
            f"{self.cells[0].id!r}; 'pedcross suites {self.name}' lists them."
        )
