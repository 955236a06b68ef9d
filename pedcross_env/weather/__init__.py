"""Weather: physical quantities, presets, CARLA's parameters; precipitation is a module of its own."""

from pedcross_env.weather.presets import BAD_WEATHERS, WEATHERS, weather_by_name, weather_names
from pedcross_env.weather.weather import Weather

__all__ = ["BAD_WEATHERS", "WEATHERS", "Weather", "weather_by_name", "weather_names"]
