"""Weather: physical quantities, presets, precipitation."""

from pedcross_env.weather.weather import Weather

__all__ = ["Weather"]
