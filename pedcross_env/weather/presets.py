"""Named weathers, and weathers from physical quantities or CARLA's parameters."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from pedcross_env.config import from_mapping, require
from pedcross_env.errors import ConfigError, unknown_name
from pedcross_env.weather.carla import CARLA_WEATHERS, CarlaWeather, to_physical
from pedcross_env.weather.road import rain_film_mm, road_friction, snow_cover_of_rate, wetness_of_film
from pedcross_env.weather.weather import Weather

__all__ = [
    "BAD_WEATHERS", "WEATHERS", "as_weather", "make_weather", "register_weather", "weather_by_name", "weather_names",
]  # fmt: skip

_NIGHT_DEG = -30.0
_QUANTITIES = tuple(field.name for field in dataclasses.fields(Weather))
_ROAD = ("water_film_mm", "wetness", "snow_cover", "friction")  # follow from the others where not given


def make_weather(base: Weather | None = None, **quantities: Any) -> Weather:
    """Build a weather whose road follows from its rain, snow and ice.

    Args:
        base: Where quantities come from that are not given; a clear day without it.
        **quantities: Fields of Weather. Where not given, the water film is what the rain keeps on the road (or the
            base's, if more), wetness follows from the film, the snow cover from the snowfall, and friction from
            film, snow and ice.

    Raises:
        ConfigError: For an unknown quantity (names the nearest) or a value out of range.
    """
    for name in quantities:
        if name not in _QUANTITIES:
            raise unknown_name("quantity of Weather", name, _QUANTITIES)
    start = base if base is not None else Weather()
    values = {name: getattr(start, name) for name in _QUANTITIES if name not in _ROAD}
    values["name"] = "custom"
    values |= quantities
    require(values["rain_mm_h"] >= 0, "rain_mm_h", values["rain_mm_h"], "0 to 300")
    require(values["snow_mm_h"] >= 0, "snow_mm_h", values["snow_mm_h"], "0 to 50")
    film = max(rain_film_mm(values["rain_mm_h"]), start.water_film_mm if base is not None else 0.0)
    film = values.setdefault("water_film_mm", film)
    values.setdefault("wetness", wetness_of_film(film))
    values.setdefault("snow_cover", max(snow_cover_of_rate(values["snow_mm_h"]), start.snow_cover))
    values.setdefault("friction", road_friction(film, values["snow_cover"], values["ice_cover"]))
    return Weather(**values)


_NIGHT: dict[str, Any] = {"sun_altitude_deg": _NIGHT_DEG, "headlights": True}
_LAMPS: dict[str, Any] = {"street_lamps": True}

_PRESETS = (
    make_weather(name="clear", cloudiness=0.05),
    make_weather(name="cloudy", cloudiness=0.9, wind_mps=3.0),
    # The sun low behind the car, at 4 degrees to the street: half of it lies in the houses' long shade.
    make_weather(name="sunset", cloudiness=0.1, sun_altitude_deg=6.0, sun_azimuth_deg=176.0),
    # Straight over the end of the street: glare.
    make_weather(name="low_sun", cloudiness=0.05, sun_altitude_deg=7.0, sun_azimuth_deg=3.0),
    # Out of the dark into the sun; whoever crosses stands in the light, or in front of it.
    make_weather(name="tunnel_exit", cloudiness=0.05, tunnel_exit_m=30.0, headlights=True),
    make_weather(name="rain", cloudiness=0.95, rain_mm_h=12.0, wind_mps=4.0, headlights=True),
    # Violent rain under thunderclouds; the visibility is that of mist and spray, rain comes on top.
    make_weather(name="storm", cloudiness=1.0, rain_mm_h=60.0, wind_mps=15.0, sun_altitude_deg=12.0,
                 visibility_m=800.0, headlights=True),
    make_weather(name="thunderstorm", cloudiness=1.0, rain_mm_h=40.0, wind_mps=10.0, sun_altitude_deg=4.0,
                 visibility_m=1200.0, headlights=True, lightning_per_min=15.0),
    make_weather(name="snow", cloudiness=1.0, snow_mm_h=2.0, wind_mps=2.0, sun_altitude_deg=20.0, headlights=True),
    make_weather(name="ice", cloudiness=0.2, ice_cover=1.0, sun_altitude_deg=15.0, wetness=0.3),
    make_weather(name="fog", cloudiness=0.9, visibility_m=80.0, water_film_mm=0.03, headlights=True),
    make_weather(name="fog_light", cloudiness=0.7, visibility_m=700.0, water_film_mm=0.01),
    make_weather(name="fog_moderate", cloudiness=0.8, visibility_m=300.0, water_film_mm=0.02, headlights=True),
    make_weather(name="fog_thick", cloudiness=0.9, visibility_m=120.0, water_film_mm=0.03, headlights=True),
    make_weather(name="fog_dense", cloudiness=1.0, visibility_m=40.0, water_film_mm=0.05, wind_mps=0.5,
                 headlights=True),
    make_weather(name="night", cloudiness=0.3, **_NIGHT, **_LAMPS),
    make_weather(name="night_unlit", cloudiness=0.3, **_NIGHT),
    make_weather(name="rain_night", cloudiness=0.95, rain_mm_h=12.0, wind_mps=4.0, **_NIGHT, **_LAMPS),
    make_weather(name="fog_night", cloudiness=0.9, visibility_m=80.0, water_film_mm=0.03, **_NIGHT, **_LAMPS),
    make_weather(name="snow_night", cloudiness=1.0, snow_mm_h=2.0, wind_mps=2.0, **_NIGHT, **_LAMPS),
    make_weather(name="thunderstorm_night", cloudiness=1.0, rain_mm_h=40.0, wind_mps=10.0, visibility_m=1200.0,
                 lightning_per_min=15.0, **_NIGHT, **_LAMPS),
)  # fmt: skip

WEATHERS: Mapping[str, Weather] = MappingProxyType({weather.name: weather for weather in _PRESETS})
"""Our presets by name; CARLA's are reached through weather_by_name. Fogs are named after the classes of the
Highways handbooks: light 500 to 1000 m of visibility, moderate 200 to 500, thick 50 to 200, dense below 50."""

BAD_WEATHERS: tuple[str, ...] = ("rain", "storm", "fog")
"""The weathers of the paper's "Weather" subset."""

_OWN: dict[str, Weather] = {}  # a user's, by name


def weather_names() -> tuple[str, ...]:
    """Every name weather_by_name accepts: our presets, CARLA's, then those a user registered."""
    return (*WEATHERS, *CARLA_WEATHERS, *_OWN)


def weather_by_name(name: str) -> Weather:
    """Return the weather called ``name``: a preset of ours ("fog"), of CARLA ("HardRainNight") or a user's.

    Raises:
        ConfigError: For an unknown name; names the nearest one.
    """
    if name in WEATHERS:
        return WEATHERS[name]
    if name in CARLA_WEATHERS:
        return to_physical(CARLA_WEATHERS[name], name=name)
    if name in _OWN:
        return _OWN[name]
    raise unknown_name("weather", name, weather_names())


def register_weather(weather: Weather) -> None:
    """Make ``weather`` known by its name, in this process; other processes are given the Weather itself.

    Raises:
        ConfigError: If another weather has that name already.
    """
    known = weather.name in weather_names()
    if known and weather_by_name(weather.name) != weather:
        raise ConfigError(
            f"weather name {weather.name!r} is taken; allowed: a name that no other weather has."
        )
    if not known:
        _OWN[weather.name] = weather


def as_weather(what: str | Weather | CarlaWeather | Mapping[str, Any]) -> Weather:
    """Turn whatever stands for a weather into one.

    Args:
        what: A name; a Weather; CARLA's parameters; or a mapping of physical quantities (see make_weather), which
            ``"preset": name`` may start from, or ``{"carla": {...}}`` with CARLA's parameters.

    Raises:
        ConfigError: For an unknown name, key or type, or a value out of range.
    """
    if isinstance(what, Weather):
        return what
    if isinstance(what, CarlaWeather):
        return to_physical(what)
    if isinstance(what, str):
        return weather_by_name(what)
    if not isinstance(what, Mapping):
        raise ConfigError(
            f"weather is a {type(what).__name__}; allowed: a name, a Weather, CarlaWeather or a mapping of quantities."
        )
    if "carla" in what:
        rest = {key: value for key, value in what.items() if key != "carla"}
        require(set(rest) <= {"name"}, "keys beside 'carla'", sorted(rest), "none, or 'name'")
        return to_physical(from_mapping(CarlaWeather, what["carla"]), **rest)
    quantities = dict(what)
    preset = quantities.pop("preset", None)
    return make_weather(None if preset is None else weather_by_name(preset), **quantities)
