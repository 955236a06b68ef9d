"""CARLA's weather parameters, its presets, and what they mean in physical units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

from pedcross_env.config import require
from pedcross_env.weather.road import rain_film_mm, road_friction, wetness_of_film
from pedcross_env.weather.weather import Weather

__all__ = ["CARLA_WEATHERS", "CarlaWeather", "to_physical"]

_PERCENTS = (
    "cloudiness", "precipitation", "precipitation_deposits", "wind_intensity", "fog_density", "wetness",
    "dust_storm",
)  # fmt: skip

_CLEAREST_M = 20_000.0  # visibility of clean air with a trace of haze
_THICKEST_M = 100.0  # at 100 % of fog density; CARLA's rainy nights, which have it, must stay drivable
_FOG_START_M = 50.0  # a fog that begins this far away counts 1/e: pedestrians matter nearer than that
_CLEAN_MIE = 0.03  # that every preset of CARLA's has
_FULL_RAIN_MM_H = 50.0  # upper end of "heavy"
_FULL_FILM_MM = 2.0
_DAMP_FILM_MM = 0.1  # what 100 % wetness without deposits is worth
_FULL_WIND_MPS = 20.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CarlaWeather:
    """CARLA's WeatherParameters (0.9.16), 0 to 100 each but the sun's angles in degrees and fog's distance.

    All fourteen are taken, so that a whole record of CARLA's can be given. Two have no counterpart here and change
    nothing: ``scattering_intensity`` scales the light in CARLA's volumetric fog, which ours has by its physics, and
    ``rayleigh_scattering_scale`` the colour of its sky, which ours takes from the sun's altitude.
    """

    cloudiness: float = 0.0
    precipitation: float = 0.0
    precipitation_deposits: float = 0.0
    wind_intensity: float = 0.0
    sun_azimuth_angle: float = -1.0
    sun_altitude_angle: float = 45.0
    fog_density: float = 0.0
    fog_distance: float = 0.0  # where the fog begins, m
    fog_falloff: float = 0.0  # how fast it thins with height; at the height of a car it changes nothing
    wetness: float = 0.0
    scattering_intensity: float = 1.0
    mie_scattering_scale: float = 0.03  # light scattered by pollen and dirt in the air: haze
    rayleigh_scattering_scale: float = 0.0331
    dust_storm: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            require(math.isfinite(value), f"CarlaWeather.{field.name}", value, "finite")
        for name in _PERCENTS:
            require(0 <= getattr(self, name) <= 100, f"CarlaWeather.{name}", getattr(self, name), "0 to 100")
        altitude = self.sun_altitude_angle
        require(-90 <= altitude <= 90, "CarlaWeather.sun_altitude_angle", altitude, "-90 to 90")
        scales = ("scattering_intensity", "mie_scattering_scale", "rayleigh_scattering_scale")
        for name in ("fog_distance", "fog_falloff", *scales):
            require(getattr(self, name) >= 0, f"CarlaWeather.{name}", getattr(self, name), "0 or more")


def _haze_per_m(percent: float) -> float:
    """Extinction of fog or dust: visibility falls geometrically from 20 km to 100 m; 0 % is none."""
    if percent == 0:
        return 0.0
    return 3.0 / (_CLEAREST_M * (_THICKEST_M / _CLEAREST_M) ** (percent / 100))


def to_physical(carla: CarlaWeather, name: str = "carla") -> Weather:
    """Translate CARLA's parameters; CARLA documents no units, so each function here is a stated choice.

    All are monotone. Rain: 50 (p/100)^3 mm/h (30 % light, 60 % moderate to heavy, 100 % the end of heavy).
    Water film: the larger of 2 (deposits/100)^2 mm and what the rain keeps on the road, plus 0.1 mm at
    full wetness; wetness and friction follow from it. Wind: 20 m/s at 100 %. Fog: visibility from 20 km
    down to 100 m, geometrically in the density, its extinction times exp(-distance / 50 m); dust likewise,
    added; Mie scattering beyond that of CARLA's clean air, 0.03, adds the haze of 20 km each time over. CARLA's
    y axis points right, ours left: the sun's azimuth changes sign. Street lamps burn when the sun is 6 degrees
    below the horizon; headlights then too, in rain above 2.5 mm/h and below 500 m of visibility.
    """
    rain_mm_h = _FULL_RAIN_MM_H * (carla.precipitation / 100) ** 3
    standing_mm = _FULL_FILM_MM * (carla.precipitation_deposits / 100) ** 2
    film_mm = max(standing_mm, rain_film_mm(rain_mm_h)) + _DAMP_FILM_MM * carla.wetness / 100
    fog_per_m = _haze_per_m(carla.fog_density) * math.exp(-carla.fog_distance / _FOG_START_M)
    dirt = max(0.0, carla.mie_scattering_scale / _CLEAN_MIE - 1.0)
    haze_per_m = fog_per_m + _haze_per_m(carla.dust_storm) + dirt * 3.0 / _CLEAREST_M
    visibility_m = 3.0 / haze_per_m if haze_per_m > 0 else math.inf
    night = carla.sun_altitude_angle < -6
    return Weather(
        name=name,
        visibility_m=visibility_m,
        rain_mm_h=rain_mm_h,
        water_film_mm=film_mm,
        wetness=max(carla.wetness / 100, wetness_of_film(film_mm)),
        cloudiness=carla.cloudiness / 100,
        wind_mps=_FULL_WIND_MPS * carla.wind_intensity / 100,
        sun_altitude_deg=carla.sun_altitude_angle,
        sun_azimuth_deg=-carla.sun_azimuth_angle,
        street_lamps=night,
        headlights=night or rain_mm_h > 2.5 or visibility_m < 500,
        friction=road_friction(film_mm),
    )


def _day(sky: tuple[float, float, float, float], fog_density: float, altitude: float) -> CarlaWeather:
    cloudiness, rain, deposits, wind = sky
    return CarlaWeather(
        cloudiness=cloudiness, precipitation=rain, precipitation_deposits=deposits, wind_intensity=wind,
        fog_density=fog_density, fog_distance=0.75, fog_falloff=0.1, sun_altitude_angle=altitude,
    )  # fmt: skip


def _night(
    sky: tuple[float, float, float, float],
    wetness: float = 0.0,
    fog: tuple[float, float, float] = (60.0, 0.75, 0.1),
) -> CarlaWeather:
    cloudiness, rain, deposits, wind = sky
    density, distance, falloff = fog
    return CarlaWeather(
        cloudiness=cloudiness, precipitation=rain, precipitation_deposits=deposits, wind_intensity=wind,
        fog_density=density, fog_distance=distance, fog_falloff=falloff, wetness=wetness,
        sun_altitude_angle=-90.0,
    )  # fmt: skip


# (cloudiness, precipitation, deposits, wind) and fog density; the sun stands at 45 or 15 degrees.
_DAYS = {
    ("ClearNoon", "ClearSunset"): ((5, 0, 0, 10), 2),
    ("CloudyNoon", "CloudySunset"): ((60, 0, 0, 10), 3),
    ("WetNoon", "WetSunset"): ((5, 0, 50, 10), 3),
    ("WetCloudyNoon", "WetCloudySunset"): ((60, 0, 50, 10), 3),
    ("SoftRainNoon", "SoftRainSunset"): ((20, 30, 50, 30), 3),
    ("MidRainyNoon", "MidRainSunset"): ((60, 60, 60, 60), 3),
    ("HardRainNoon", "HardRainSunset"): ((100, 100, 90, 100), 7),
}
_CLEAR_NIGHT_FOG = (60.0, 75.0, 1.0)

CARLA_WEATHERS: Mapping[str, CarlaWeather] = MappingProxyType(
    {
        name: _day(sky, fog_density, altitude)
        for names, (sky, fog_density) in _DAYS.items()
        for name, altitude in zip(names, (45.0, 15.0), strict=True)
    }
    | {
        "ClearNight": _night((5, 0, 0, 10), 0, _CLEAR_NIGHT_FOG),
        "WetNight": _night((5, 0, 50, 10), 60, _CLEAR_NIGHT_FOG),
        "CloudyNight": _night((60, 0, 0, 10)),
        "WetCloudyNight": _night((60, 0, 50, 10), 60),
        "SoftRainNight": _night((60, 30, 50, 30), 60),
        "MidRainyNight": _night((80, 60, 60, 60), 80),
        "HardRainNight": _night((100, 100, 90, 100), 100, (100.0, 0.75, 0.1)),
        "DustStorm": CarlaWeather(
            cloudiness=100, wind_intensity=100, sun_altitude_angle=45, fog_density=2, fog_distance=0.75,
            fog_falloff=0.1, dust_storm=100,
        ),
    }
)  # fmt: skip
"""CARLA's named presets."""
