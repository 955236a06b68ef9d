"""Presets, CARLA's parameters and the road under them."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pedcross_env.errors import ConfigError
from pedcross_env.weather import (
    BAD_WEATHERS,
    WEATHERS,
    Weather,
    as_weather,
    make_weather,
    register_weather,
    weather_by_name,
    weather_names,
)  # fmt: skip
from pedcross_env.weather.carla import CARLA_WEATHERS, CarlaWeather, to_physical
from pedcross_env.weather.road import friction_of_film, rain_film_mm, road_friction, wetness_of_film

percent = st.floats(0, 100)
share = st.floats(0, 1)


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
    assert weather.friction == road_friction(weather.water_film_mm, weather.snow_cover, weather.ice_cover)
    assert weather.wetness >= wetness_of_film(weather.water_film_mm)
    assert (weather.snow_cover > 0) == (weather.snow_mm_h > 0)
    assert weather.headlights or not weather.night
    assert not weather.street_lamps or weather.sun_altitude_deg < 0
    assert weather.rain_mm_h <= 2.5 or weather.cloudiness > 0.5
    if weather.rain_mm_h > 50:
        assert weather.headlights


def test_friction_runs_from_dry_asphalt_to_wet_ice() -> None:
    assert road_friction() == 0.85
    assert road_friction(snow_cover=1.0) == pytest.approx(0.25)
    assert road_friction(2.0, snow_cover=0.5, ice_cover=1.0) == pytest.approx(0.10)


@given(share, share, st.floats(0, 5), share)
def test_more_snow_or_ice_never_grips_better(one: float, other: float, film_mm: float, rest: float) -> None:
    less, more = sorted((one, other))
    assert road_friction(film_mm, more, rest) <= road_friction(film_mm, less, rest) + 1e-12
    assert road_friction(film_mm, rest, more) <= road_friction(film_mm, rest, less) + 1e-12


def test_friction_has_the_values_of_wet_roads() -> None:
    assert [friction_of_film(film) for film in (0, 0.2, 1, 2, 5)] == [0.85, 0.65, 0.55, 0.5, 0.5]


def test_presets_lie_in_the_classes_they_are_named_after() -> None:
    assert 7.6 < WEATHERS["rain"].rain_mm_h <= 50 < WEATHERS["storm"].rain_mm_h
    assert WEATHERS["fog_dense"].visibility_m < 50 < WEATHERS["fog"].visibility_m < 200
    assert 50 <= WEATHERS["fog_thick"].visibility_m < 200 <= WEATHERS["fog_moderate"].visibility_m < 500
    assert 500 <= WEATHERS["fog_light"].visibility_m <= 1000
    assert all(weather.lightning_per_min > 0 for name, weather in WEATHERS.items() if "thunder" in name)
    nights = {name for name, weather in WEATHERS.items() if weather.night}
    assert nights == {
        "night", "night_unlit", "rain_night", "fog_night", "snow_night", "thunderstorm_night"
    }  # fmt: skip
    assert {name for name in nights if not WEATHERS[name].street_lamps} == {"night_unlit"}


def test_worse_weather_brakes_longer_and_sees_less() -> None:
    order = [
        WEATHERS[name] for name in ("clear", "fog_light", "fog_moderate", "fog_thick", "fog", "fog_dense")
    ]
    assert [w.extinction_per_m for w in order] == sorted(w.extinction_per_m for w in order)
    frictions = [WEATHERS[name].friction for name in ("ice", "snow", "storm", "rain", "clear")]
    assert frictions == sorted(set(frictions))


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


def test_snow_hides_what_the_recommendation_says() -> None:
    """ITU-R P.1814, dry snow: 5.53 dB per km at 1 mm/h, with the power 1.38 of the rate."""
    decibels_per_km = 10 / math.log(10) * 1000 * Weather(snow_mm_h=1.0).extinction_per_m
    assert decibels_per_km == pytest.approx(5.53, abs=0.01)
    ratio = Weather(snow_mm_h=3.0).extinction_per_m / Weather(snow_mm_h=1.0).extinction_per_m
    assert ratio == pytest.approx(3.0**1.38)


def test_the_road_follows_from_quantities_given_directly() -> None:
    assert make_weather(rain_mm_h=30.0).water_film_mm == rain_film_mm(30.0)
    assert make_weather(rain_mm_h=30.0).friction == road_friction(rain_film_mm(30.0))
    assert make_weather(snow_mm_h=3.0).friction < 0.4
    assert make_weather(rain_mm_h=30.0, friction=0.7).friction == 0.7
    assert make_weather(WEATHERS["rain"], visibility_m=90.0).friction == WEATHERS["rain"].friction


def test_a_weather_may_be_a_name_an_object_quantities_or_carlas_parameters() -> None:
    assert as_weather("fog") is WEATHERS["fog"]
    assert as_weather(WEATHERS["fog"]) is WEATHERS["fog"]
    night = as_weather({"preset": "night", "visibility_m": 120.0, "name": "misty night"})
    assert (night.night, night.street_lamps, night.visibility_m, night.name) == (
        True,
        True,
        120.0,
        "misty night",
    )
    carla = CarlaWeather(precipitation=60, sun_altitude_angle=15)
    assert as_weather(carla) == as_weather({"carla": {"precipitation": 60, "sun_altitude_angle": 15}})
    with pytest.raises(ConfigError, match="'rain_mm_h'"):
        as_weather({"rain_mmh": 3.0})
    with pytest.raises(ConfigError, match="precipitation"):
        as_weather({"carla": {"precipitatio": 3.0}})
    with pytest.raises(ConfigError, match="int"):
        as_weather(3)  # type: ignore[arg-type]


def test_a_weather_of_ones_own_has_a_name_that_no_other_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pedcross_env.weather.presets._OWN", {})
    drizzle = make_weather(name="drizzle", rain_mm_h=0.5, cloudiness=1.0)
    register_weather(drizzle)
    register_weather(drizzle)
    assert weather_by_name("drizzle") is drizzle
    assert "drizzle" in weather_names()
    for taken in ("drizzle", "fog", "ClearNoon"):
        with pytest.raises(ConfigError, match="taken"):
            register_weather(make_weather(name=taken, rain_mm_h=1.0))


# The members of carla.WeatherParameters (LibCarla's carla/rpc/WeatherParameters.h): what a whole record holds.
CARLAS_PARAMETERS = (
    "cloudiness", "precipitation", "precipitation_deposits", "wind_intensity", "sun_azimuth_angle",
    "sun_altitude_angle", "fog_density", "fog_distance", "fog_falloff", "wetness", "scattering_intensity",
    "mie_scattering_scale", "rayleigh_scattering_scale", "dust_storm",
)  # fmt: skip
CARLAS_PRESETS = (
    "ClearNoon", "CloudyNoon", "WetNoon", "WetCloudyNoon", "SoftRainNoon", "MidRainyNoon", "HardRainNoon",
    "ClearSunset", "CloudySunset", "WetSunset", "WetCloudySunset", "SoftRainSunset", "MidRainSunset", "HardRainSunset",
    "ClearNight", "CloudyNight", "WetNight", "WetCloudyNight", "SoftRainNight", "MidRainyNight",
    "HardRainNight", "DustStorm",
)  # fmt: skip


def test_all_of_carlas_parameters_and_presets_are_known() -> None:
    assert {field.name for field in dataclasses.fields(CarlaWeather)} == set(CARLAS_PARAMETERS)
    assert set(CARLA_WEATHERS) == set(CARLAS_PRESETS)
    for carla in CARLA_WEATHERS.values():
        record = {name: getattr(carla, name) for name in CARLAS_PARAMETERS}
        assert as_weather({"carla": record}) == to_physical(carla)


def test_dirt_in_the_air_is_haze() -> None:
    reach = [
        to_physical(CarlaWeather(mie_scattering_scale=mie)).visibility_m
        for mie in (0.0, 0.03, 0.06, 0.3, 1.0)
    ]
    assert reach[0] == reach[1] == math.inf
    assert reach == sorted(reach, reverse=True)
    assert reach[2] == pytest.approx(20_000.0)
    with pytest.raises(ConfigError, match="mie_scattering_scale"):
        CarlaWeather(mie_scattering_scale=-0.1)
