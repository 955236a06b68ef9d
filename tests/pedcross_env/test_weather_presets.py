"""Presets, CARLA's parameters and the road under them."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pedcross_env.errors import ConfigError
from pedcross_env.weather import BAD_WEATHERS, WEATHERS, Weather, weather_by_name, weather_names
from pedcross_env.weather.carla import CARLA_WEATHERS, CarlaWeather, to_physical
from pedcross_env.weather.road import friction_of_film, rain_film_mm, wetness_of_film

percent = st.floats(0, 100)


def test_every_name_gives_the_weather_of_that_name() -> None:
    assert len(set(weather_names())) == len(weather_names()) == len(WEATHERS) + len(CARLA_WEATHERS)
    for name in weather_names():
        assert weather_by_name(name).name == name
    assert set(BAD_WEATHERS) <= set(WEATHERS)


def test_an_unknown_name_gets_the_nearest() -> None:
    with pytest.raises(ConfigError, match="'fog_dense'"):
        weather_by_name("fog_dens")


@pytest.mark.parametrize("name", weather_names())
def test_presets_are_physically_consistent(name: str) -> None:
    weather = weather_by_name(name)
    assert weather.water_film_mm >= rain_film_mm(weather.rain_mm_h)
    assert weather.friction == friction_of_film(weather.water_film_mm)
    assert weather.wetness >= wetness_of_film(weather.water_film_mm)
    assert weather.headlights or not weather.night
    assert not weather.street_lamps or weather.sun_altitude_deg < 0
    assert weather.rain_mm_h <= 2.5 or weather.cloudiness > 0.5
    if weather.rain_mm_h > 50:
        assert weather.headlights


def test_friction_has_the_values_of_wet_roads() -> None:
    assert [friction_of_film(film) for film in (0, 0.2, 1, 2, 5)] == [0.85, 0.65, 0.55, 0.5, 0.5]


def test_presets_lie_in_the_classes_they_are_named_after() -> None:
    assert 7.6 < WEATHERS["rain"].rain_mm_h <= 50 < WEATHERS["storm"].rain_mm_h
    assert WEATHERS["fog_dense"].visibility_m < 50 < WEATHERS["fog"].visibility_m < 200
    assert 500 <= WEATHERS["fog_light"].visibility_m <= 1000
    nights = {name for name, weather in WEATHERS.items() if weather.night}
    assert nights == {"night", "night_unlit", "rain_night", "fog_night"}
    assert {name for name in nights if not WEATHERS[name].street_lamps} == {"night_unlit"}


def test_worse_weather_brakes_longer_and_sees_less() -> None:
    order = [WEATHERS[name] for name in ("clear", "fog_light", "fog", "fog_dense")]
    assert [w.extinction_per_m for w in order] == sorted(w.extinction_per_m for w in order)
    assert WEATHERS["storm"].friction < WEATHERS["rain"].friction < WEATHERS["clear"].friction


@given(st.floats(5, 1e5), st.floats(5, 1e5), st.floats(0, 300), st.floats(0, 300))
def test_more_fog_or_rain_is_more_extinction(near_m: float, far_m: float, less: float, more: float) -> None:
    near_m, far_m, less, more = min(near_m, far_m), max(near_m, far_m), min(less, more), max(less, more)
    thin = Weather(visibility_m=far_m, rain_mm_h=less).extinction_per_m
    assert Weather(visibility_m=near_m, rain_mm_h=less).extinction_per_m >= thin
    assert Weather(visibility_m=far_m, rain_mm_h=more).extinction_per_m >= thin


RISES = {
    "cloudiness": ("cloudiness", 1),
    "precipitation": ("rain_mm_h", 1),
    "precipitation_deposits": ("water_film_mm", 1),
    "wind_intensity": ("wind_mps", 1),
    "fog_density": ("visibility_m", -1),
    "dust_storm": ("visibility_m", -1),
    "fog_distance": ("visibility_m", 1),
    "wetness": ("wetness", 1),
}


@pytest.mark.parametrize("parameter", RISES)
@given(percent, percent, st.fixed_dictionaries(dict.fromkeys(RISES, percent)))
def test_carlas_parameters_map_monotonically(parameter: str, one: float, other: float, rest: dict) -> None:
    less, more = (to_physical(CarlaWeather(**(rest | {parameter: value}))) for value in sorted((one, other)))
    field, sign = RISES[parameter]
    assert sign * getattr(more, field) >= sign * getattr(less, field)
    if parameter in ("precipitation", "precipitation_deposits", "wetness"):
        assert more.friction <= less.friction
        assert more.wetness >= less.wetness


def test_carlas_parameters_reach_the_ends_of_their_ranges() -> None:
    dry, wet = to_physical(CarlaWeather()), to_physical(CarlaWeather(precipitation=100, fog_density=100))
    assert (dry.rain_mm_h, dry.water_film_mm, dry.extinction_per_m) == (0, 0, 0)
    assert dry.friction == 0.85
    assert wet.rain_mm_h == pytest.approx(50)
    assert wet.visibility_m == pytest.approx(100)


def test_carlas_names_mean_what_they_say() -> None:
    rain = {name: weather_by_name(name).rain_mm_h for name in CARLA_WEATHERS}
    assert 0 == rain["WetNoon"] < rain["SoftRainNoon"] <= 2.5 < rain["MidRainyNoon"] < rain["HardRainNoon"]
    for name in CARLA_WEATHERS:
        weather = weather_by_name(name)
        assert weather.night == name.endswith("Night")
        assert (weather.rain_mm_h > 0) == ("Rain" in name)
        if name.startswith("Clear"):
            assert weather.visibility_m > 1000
            assert weather.friction == 0.85


def test_carla_presets_differ_between_noon_and_sunset_in_the_sun_alone() -> None:
    noon, sunset = CARLA_WEATHERS["HardRainNoon"], CARLA_WEATHERS["HardRainSunset"]
    assert dataclasses.replace(sunset, sun_altitude_angle=noon.sun_altitude_angle) == noon
    assert (noon.sun_altitude_angle, sunset.sun_altitude_angle) == (45, 15)


def test_values_out_of_range_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"CarlaWeather\.fog_density = 101"):
        CarlaWeather(fog_density=101)
    with pytest.raises(ConfigError, match="finite"):
        CarlaWeather(wetness=float("nan"))
