"""The street's geometry, shared by the world that drives on it and the camera that paints it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from pedcross_env.config import require

__all__ = ["Crosswalk", "Intersection", "SteelPlate", "StreetSpec"]

BEHIND_FRONTS_M = 14.0  # depth of the houses, which have to fit inside a curve
LEAST_CURVATURE_PER_M = 1e-6  # over a curve of 100 m the street strays 5 mm


@dataclass(frozen=True, slots=True, kw_only=True)
class Crosswalk:
    """A zebra crossing over the whole carriageway."""

    x_m: float  # of its middle, along the street
    width_m: float = 4.0  # along x

    def __post_init__(self) -> None:
        require(1 <= self.width_m <= 20, "Crosswalk.width_m", self.width_m, "1 to 20")


@dataclass(frozen=True, slots=True, kw_only=True)
class SteelPlate:
    """A plate over a trench in the carriageway, which all drive over: it is seen, and touches nobody."""

    x_m: float  # of its middle, along the street
    y_m: float
    length_m: float = 3.7  # along x
    width_m: float = 2.4
    height_m: float = 0.025

    def __post_init__(self) -> None:
        require(0.5 <= self.length_m <= 20, "SteelPlate.length_m", self.length_m, "0.5 to 20")
        require(0.5 <= self.width_m <= 20, "SteelPlate.width_m", self.width_m, "0.5 to 20")
        require(0.005 <= self.height_m <= 0.1, "SteelPlate.height_m", self.height_m, "0.005 to 0.1")


@dataclass(frozen=True, slots=True, kw_only=True)
class Intersection:
    """A side street that crosses at right angles; zebras and stop lines on all four arms."""

    x_m: float  # of its middle, along the main street
    lane_width_m: float = 3.25
    lanes_per_direction: int = 1
    parking_width_m: float = 0.0
    sidewalk_width_m: float = 3.0
    corner_radius_m: float = 6.0  # of the kerb
    crosswalk_width_m: float = 3.5  # 0: none
    stop_lines: bool = True
    length_m: float = 80.0  # of either arm of the side street, from the middle to the houses that close it

    def __post_init__(self) -> None:
        require(2.5 <= self.lane_width_m <= 5, "Intersection.lane_width_m", self.lane_width_m, "2.5 to 5")
        require(
            1 <= self.lanes_per_direction <= 3,
            "Intersection.lanes_per_direction", self.lanes_per_direction, "1 to 3",
        )  # fmt: skip
        require(
            0 <= self.parking_width_m <= 4, "Intersection.parking_width_m", self.parking_width_m, "0 to 4"
        )
        require(
            1 <= self.sidewalk_width_m <= 10,
            "Intersection.sidewalk_width_m", self.sidewalk_width_m, "1 to 10",
        )  # fmt: skip
        require(
            0.5 <= self.corner_radius_m <= 15,
            "Intersection.corner_radius_m", self.corner_radius_m, "0.5 to 15",
        )  # fmt: skip
        require(
            self.crosswalk_width_m == 0 or 1 <= self.crosswalk_width_m <= 10,
            "Intersection.crosswalk_width_m", self.crosswalk_width_m, "0 (none) or 1 to 10",
        )  # fmt: skip
        require(60 <= self.length_m <= 200, "Intersection.length_m", self.length_m, "60 to 200")

    @property
    def kerb_m(self) -> float:
        """Half the side street's carriageway, parking strips included."""
        return self.lanes_per_direction * self.lane_width_m + self.parking_width_m

    @property
    def facade_m(self) -> float:
        """Distance of the side street's house fronts from its centre line."""
        return self.kerb_m + self.sidewalk_width_m


@dataclass(frozen=True, slots=True, kw_only=True)
class StreetSpec:
    """A two-way street along x, its centre line at y = 0, right-hand traffic; it may bend or be crossed.

    From the middle outwards on both sides: lanes, a parking strip (may be 0 wide), kerb, sidewalk, facades; plates lie
    on the carriageway. Vehicles heading +x drive at y < 0. Where the street bends, x of its zebras is read as distance
    along the centre; people and vehicles are always placed in the world's coordinates: ``scenario.layout.to_world``
    converts.
    """

    start_x_m: float = -60.0
    end_x_m: float = 240.0
    lane_width_m: float = 3.5
    lanes_per_direction: int = 1
    parking_width_m: float = 2.2
    sidewalk_width_m: float = 3.5
    kerb_height_m: float = 0.12
    crosswalks: tuple[Crosswalk, ...] = ()
    seed: int = 0  # of all that is only looks: facades, trees, surfaces
    curvature_per_m: float = 0.0  # of the centre line's arc, 1 / radius; positive to the left
    curve_start_x_m: float = 40.0  # straight up to here
    curve_length_m: float = 60.0  # of the arc; straight again beyond it
    intersection: Intersection | None = None
    plates: tuple[SteelPlate, ...] = ()

    def __post_init__(self) -> None:
        require(
            self.end_x_m - self.start_x_m >= 50,
            "StreetSpec length",
            self.end_x_m - self.start_x_m,
            "50 m or more",
        )
        ends = (self.start_x_m, self.end_x_m)
        require(all(abs(x) <= 10_000 for x in ends), "start_x_m, end_x_m", ends, "within +-10000 m")
        require(2.5 <= self.lane_width_m <= 5, "lane_width_m", self.lane_width_m, "2.5 to 5")
        require(1 <= self.lanes_per_direction <= 3, "lanes_per_direction", self.lanes_per_direction, "1 to 3")
        require(0 <= self.parking_width_m <= 4, "parking_width_m", self.parking_width_m, "0 to 4")
        require(1 <= self.sidewalk_width_m <= 10, "sidewalk_width_m", self.sidewalk_width_m, "1 to 10")
        require(0 <= self.kerb_height_m <= 0.3, "kerb_height_m", self.kerb_height_m, "0 to 0.3")
        for crosswalk in self.crosswalks:
            require(
                self.start_x_m < crosswalk.x_m < self.end_x_m, "Crosswalk.x_m", crosswalk.x_m, "on the street"
            )
        for plate in self.plates:
            edge = abs(plate.y_m) + 0.5 * plate.width_m
            require(
                self.start_x_m < plate.x_m < self.end_x_m and edge <= self.kerb_y_m,
                "SteelPlate x_m, y_m", (plate.x_m, plate.y_m),
                f"within the carriageway, which ends at {self.kerb_y_m:g} m: e.g. y_m = {self.ego_lane_y_m:g}",
            )  # fmt: skip
        self._check_curve()
        self._check_intersection()

    def _check_curve(self) -> None:
        if self.curvature_per_m == 0:
            return
        tightest = 1 / (self.facade_y_m + BEHIND_FRONTS_M)
        require(
            math.isfinite(self.curvature_per_m) and abs(self.curvature_per_m) <= tightest,
            "curvature_per_m", self.curvature_per_m,
            f"within +-{tightest:.4f}, so that houses fit inside the curve",
        )  # fmt: skip
        require(
            abs(self.curvature_per_m) >= LEAST_CURVATURE_PER_M,
            "curvature_per_m", self.curvature_per_m,
            f"0 for a straight street, or at least {LEAST_CURVATURE_PER_M:g} either way (a radius of 1,000 km)",
        )  # fmt: skip
        require(self.curve_length_m > 0, "curve_length_m", self.curve_length_m, "positive")
        require(
            self.turn_rad <= 2.1,
            "curve_length_m * curvature_per_m", self.turn_rad,
            "at most 2.1 rad, so that the street does not meet itself: shorten curve_length_m",
        )  # fmt: skip

    def _check_intersection(self) -> None:
        crossing = self.intersection
        if crossing is None:
            return
        clear = crossing.facade_m + crossing.corner_radius_m + crossing.crosswalk_width_m + 12.0
        require(
            self.start_x_m + clear <= crossing.x_m <= self.end_x_m - clear,
            "Intersection.x_m", crossing.x_m, f"at least {clear:g} m from the street's ends",
        )  # fmt: skip
        require(
            self.curvature_per_m == 0 or crossing.x_m + clear <= self.curve_start_x_m,
            "Intersection.x_m", crossing.x_m,
            f"at least {clear:g} m before curve_start_x_m ({self.curve_start_x_m:g})",
        )  # fmt: skip

    @property
    def straight(self) -> bool:
        """Whether the street neither bends nor is crossed."""
        return self.curvature_per_m == 0 and self.intersection is None

    @property
    def turn_rad(self) -> float:
        """By how much the street bends in all, without its sign."""
        return abs(self.curvature_per_m) * self.curve_length_m

    @property
    def kerb_y_m(self) -> float:
        """Half the carriageway's width, parking strips included."""
        return self.lanes_per_direction * self.lane_width_m + self.parking_width_m

    @property
    def facade_y_m(self) -> float:
        """Distance of the house fronts from the centre line."""
        return self.kerb_y_m + self.sidewalk_width_m

    @property
    def ego_lane_y_m(self) -> float:
        """Lateral position of the ego's lane (the one nearest the kerb)."""
        return -(self.lanes_per_direction - 0.5) * self.lane_width_m

    def straightened(self) -> StreetSpec:
        """Return the main street unrolled: no bend, no side street, the zebras of its arms kept."""
        return replace(self, curvature_per_m=0.0, intersection=None, crosswalks=self.all_crosswalks)

    @property
    def all_crosswalks(self) -> tuple[Crosswalk, ...]:
        """Zebras over the main street, those at the intersection included."""
        crossing = self.intersection
        if crossing is None or crossing.crosswalk_width_m == 0:
            return self.crosswalks
        away = crossing.kerb_m + crossing.corner_radius_m + 0.5 * crossing.crosswalk_width_m
        arms = tuple(
            Crosswalk(x_m=crossing.x_m + sign * away, width_m=crossing.crosswalk_width_m) for sign in (-1, 1)
        )
        return self.crosswalks + arms
