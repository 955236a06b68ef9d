"""Weather as physical quantities. Presets and CARLA's parameters are mapped to these in sibling modules."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pedcross_env.config import require

__all__ = ["Weather"]

_SNOW_PER_M = (5.42e-5 * 550 + 5.4958776) / (1000 * 10 / math.log(10))


@dataclass(frozen=True, slots=True, kw_only=True)
class Weather:
    """The state of air, sky and road, in physical units.

    Attributes:
        name: For tables.
        visibility_m: Meteorological optical range of the fog alone (5 % contrast), inf without fog.
        rain_mm_h: Rain rate.
        snow_mm_h: Snow rate, water equivalent.
        snow_cover: 0..1, share of the ground that lying snow hides.
        ice_cover: 0..1, share of the road under clear ice, which is slippery and not seen.
        lightning_per_min: Mean number of flashes per minute.
        water_film_mm: Water on the road; 0 is dry.
        wetness: 0..1, how dark and glossy the road's surface is.
        cloudiness: 0..1, covered share of the sky.
        wind_mps: Wind along +y.
        sun_altitude_deg: -90..90; below -6 it is night.
        sun_azimuth_deg: Direction to the sun, from +x towards +y; -360..360.
        street_lamps: Whether street lamps are lit.
        tunnel_exit_m: Where along a straight street a tunnel ends from which the ego comes; -inf: there is none.
        headlights: Whether cars, the ego too, have their low beams on.
        friction: Highest braking deceleration over g.
    """

    name: str = "custom"
    visibility_m: float = math.inf
    rain_mm_h: float = 0.0
    snow_mm_h: float = 0.0
    snow_cover: float = 0.0
    ice_cover: float = 0.0
    lightning_per_min: float = 0.0
    water_film_mm: float = 0.0
    wetness: float = 0.0
    cloudiness: float = 0.05
    wind_mps: float = 1.0
    sun_altitude_deg: float = 45.0
    sun_azimuth_deg: float = 60.0
    street_lamps: bool = False
    tunnel_exit_m: float = -math.inf
    headlights: bool = False
    friction: float = 0.85

    def __post_init__(self) -> None:
        require(self.visibility_m >= 5, "visibility_m", self.visibility_m, "5 or more (inf: no fog)")
        require(0 <= self.rain_mm_h <= 300, "rain_mm_h", self.rain_mm_h, "0 to 300")
        require(0 <= self.snow_mm_h <= 50, "snow_mm_h", self.snow_mm_h, "0 to 50")
        require(0 <= self.snow_cover <= 1, "snow_cover", self.snow_cover, "0 to 1")
        require(0 <= self.ice_cover <= 1, "ice_cover", self.ice_cover, "0 to 1")
        rate = self.lightning_per_min
        require(0 <= rate <= 120, "lightning_per_min", rate, "0 to 120")
        require(0 <= self.water_film_mm <= 20, "water_film_mm", self.water_film_mm, "0 to 20")
        require(0 <= self.wetness <= 1, "wetness", self.wetness, "0 to 1")
        require(0 <= self.cloudiness <= 1, "cloudiness", self.cloudiness, "0 to 1")
        require(abs(self.wind_mps) <= 60, "wind_mps", self.wind_mps, "-60 to 60")
        require(-90 <= self.sun_altitude_deg <= 90, "sun_altitude_deg", self.sun_altitude_deg, "-90 to 90")
        require(abs(self.sun_azimuth_deg) <= 360, "sun_azimuth_deg", self.sun_azimuth_deg, "-360 to 360")
        require(
            self.tunnel_exit_m < 1e4, "tunnel_exit_m", self.tunnel_exit_m, "below 10,000 (-inf: no tunnel)"
        )
        require(0.03 <= self.friction <= 1.2, "friction", self.friction, "0.03 to 1.2")

    @property
    def night(self) -> bool:
        """Whether the sun is more than 6 degrees below the horizon (end of civil twilight)."""
        return self.sun_altitude_deg < -6

    @property
    def extinction_per_m(self) -> float:
        """Extinction of fog, rain and snow together.

        Fog: 3.0 / visibility (Koschmieder at 5 % contrast). Rain: 0.312 R^0.67 per km. Snow: that of dry snow for
        light of 550 nm in ITU-R P.1814, 5.53 S^1.38 dB per km.
        """
        rain = 0.312e-3 * self.rain_mm_h**0.67
        return 3.0 / self.visibility_m + rain + _SNOW_PER_M * self.snow_mm_h**1.38
