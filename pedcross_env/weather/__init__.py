"""Weather: physical quantities, presets, precipitation."""

from pedcross_env.weather.precipitation import Precipitation
from pedcross_env.weather.presets import BAD_WEATHERS, WEATHERS, weather_by_name, weather_names
from pedcross_env.weather.weather import Weather

__all__ = ["BAD_WEATHERS", "Precipitation", "WEATHERS", "Weather", "weather_by_name", "weather_names"]
