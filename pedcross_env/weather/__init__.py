"""Weather: physical quantities, presets, precipitation."""

from pedcross_env.weather.carla import CarlaWeather
from pedcross_env.weather.lightning import Lightning
from pedcross_env.weather.precipitation import Precipitation
from pedcross_env.weather.presets import (
    BAD_WEATHERS,
    WEATHERS,
    as_weather,
    make_weather,
    register_weather,
    weather_by_name,
    weather_names,
)
from pedcross_env.weather.weather import Weather
from pedcross_env.weather.windscreen import Windscreen

__all__ = [
    "BAD_WEATHERS", "CarlaWeather", "Lightning", "Precipitation", "WEATHERS", "Weather", "Windscreen", "as_weather",
    "make_weather", "register_weather", "weather_by_name", "weather_names",
]  # fmt: skip
