"""Named weathers: presets of our own and CARLA's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from pedcross_env.errors import unknown_name
from pedcross_env.weather.carla import CARLA_WEATHERS, to_physical
from pedcross_env.weather.road import friction_of_film, rain_film_mm, wetness_of_film
from pedcross_env.weather.weather import Weather

__all__ = ["BAD_WEATHERS", "WEATHERS", "weather_by_name", "weather_names"]

_NIGHT_DEG = -30.0


def _preset(
    name: str,
    *,
    cloudiness: float,
    sun_altitude_deg: float = 45.0,
    sun_azimuth_deg: float = 60.0,
    visibility_m: float = math.inf,
    rain_mm_h: float = 0.0,
    damp_mm: float = 0.0,
    wind_mps: float = 1.0,
    street_lamps: bool = False,
    headlights: bool = False,
) -> Weather:
    """Build a weather whose road follows from its rain (or, without rain, from a dampness in mm)."""
    film_mm = max(rain_film_mm(rain_mm_h), damp_mm)
    return Weather(
        name=name,
        visibility_m=visibility_m,
        rain_mm_h=rain_mm_h,
        water_film_mm=film_mm,
        wetness=wetness_of_film(film_mm),
        cloudiness=cloudiness,
        wind_mps=wind_mps,
        sun_altitude_deg=sun_altitude_deg,
        sun_azimuth_deg=sun_azimuth_deg,
        street_lamps=street_lamps,
        headlights=headlights,
        friction=friction_of_film(film_mm),
    )


_PRESETS = (
    _preset("clear", cloudiness=0.05),
    _preset("cloudy", cloudiness=0.9, wind_mps=3.0),
    # The sun low and nearly ahead: glare, long shadows.
    _preset("sunset", cloudiness=0.1, sun_altitude_deg=6.0, sun_azimuth_deg=20.0),
    _preset("rain", cloudiness=0.95, rain_mm_h=12.0, wind_mps=4.0, headlights=True),
    # Violent rain under thunderclouds; the visibility is that of mist and spray, rain comes on top.
    _preset("storm", cloudiness=1.0, rain_mm_h=60.0, wind_mps=15.0, sun_altitude_deg=12.0,
            visibility_m=800.0, headlights=True),
    _preset("fog", cloudiness=0.9, visibility_m=80.0, damp_mm=0.03, headlights=True),
    _preset("fog_light", cloudiness=0.7, visibility_m=700.0, damp_mm=0.01),
    _preset("fog_dense", cloudiness=1.0, visibility_m=40.0, damp_mm=0.05, wind_mps=0.5, headlights=True),
    _preset("night", cloudiness=0.3, sun_altitude_deg=_NIGHT_DEG, street_lamps=True, headlights=True),
    _preset("night_unlit", cloudiness=0.3, sun_altitude_deg=_NIGHT_DEG, headlights=True),
    _preset("rain_night", cloudiness=0.95, rain_mm_h=12.0, wind_mps=4.0, sun_altitude_deg=_NIGHT_DEG,
            street_lamps=True, headlights=True),
    _preset("fog_night", cloudiness=0.9, visibility_m=80.0, damp_mm=0.03, sun_altitude_deg=_NIGHT_DEG,
            street_lamps=True, headlights=True),
)  # fmt: skip

WEATHERS: Mapping[str, Weather] = MappingProxyType({weather.name: weather for weather in _PRESETS})
"""Our presets by name; CARLA's are reached through weather_by_name."""

BAD_WEATHERS: tuple[str, ...] = ("rain", "storm", "fog")
"""The weathers of the paper's "Weather" subset."""


def weather_names() -> tuple[str, ...]:
    """Every name weather_by_name accepts: our presets, then CARLA's."""
    return (*WEATHERS, *CARLA_WEATHERS)


def weather_by_name(name: str) -> Weather:
    """Return the weather called ``name``: a preset of ours ("fog") or of CARLA ("HardRainNight").

    Raises:
        ConfigError: For an unknown name; names the nearest one.
    """
    if name in WEATHERS:
        return WEATHERS[name]
    if name in CARLA_WEATHERS:
        return to_physical(CARLA_WEATHERS[name], name=name)
    raise unknown_name("weather", name, weather_names())
