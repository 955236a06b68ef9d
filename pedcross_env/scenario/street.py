"""The street's geometry, shared by the world that drives on it and the camera that paints it."""

from __future__ import annotations

from dataclasses import dataclass

from pedcross_env.config import require

__all__ = ["Crosswalk", "StreetSpec"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Crosswalk:
    """A zebra crossing over the whole carriageway."""

    x_m: float  # of its middle
    width_m: float = 4.0  # along x

    def __post_init__(self) -> None:
        require(1 <= self.width_m <= 20, "Crosswalk.width_m", self.width_m, "1 to 20")


@dataclass(frozen=True, slots=True, kw_only=True)
class StreetSpec:
    """A straight two-way street along x, its centre line at y = 0, right-hand traffic.

    From the middle outwards on both sides: lanes, a parking strip (may be 0 wide), kerb, sidewalk, facades.
    Vehicles heading +x drive at y < 0.
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

    def __post_init__(self) -> None:
        require(
            self.end_x_m - self.start_x_m >= 50,
            "StreetSpec length",
            self.end_x_m - self.start_x_m,
            "50 m or more",
        )
        require(2.5 <= self.lane_width_m <= 5, "lane_width_m", self.lane_width_m, "2.5 to 5")
        require(1 <= self.lanes_per_direction <= 3, "lanes_per_direction", self.lanes_per_direction, "1 to 3")
        require(0 <= self.parking_width_m <= 4, "parking_width_m", self.parking_width_m, "0 to 4")
        require(1 <= self.sidewalk_width_m <= 10, "sidewalk_width_m", self.sidewalk_width_m, "1 to 10")
        require(0 <= self.kerb_height_m <= 0.3, "kerb_height_m", self.kerb_height_m, "0 to 0.3")
        for crosswalk in self.crosswalks:
            require(
                self.start_x_m < crosswalk.x_m < self.end_x_m, "Crosswalk.x_m", crosswalk.x_m, "on the street"
            )

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
