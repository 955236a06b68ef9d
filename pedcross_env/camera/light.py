"""Light of sun, sky, street lamps and headlights, from the weather."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pedcross_env.weather.weather import Weather

__all__ = [
    "BEAM_TAN_H",
    "BEAM_TAN_V",
    "Light",
    "flashed",
    "high_beam_table",
    "light_of",
    "low_beam_table",
    "sky_illuminance_lx",
    "sun_illuminance_lx",
]

LUMA = np.array([0.2126, 0.7152, 0.0722])
BEAM_TAN_H = (-0.9, 0.9)  # range of the beam table, tangent of the angle to the left of the axis
BEAM_TAN_V = (-0.35, 0.25)  # tangent of the angle above the axis
BEAM_SHAPE = (121, 181)  # rows (vertical), columns (horizontal)


def _tint(red: float, green: float, blue: float) -> np.ndarray:
    """Return a colour of luminance 1."""
    colour = np.array([red, green, blue])
    return colour / float((colour * LUMA).sum())


LAMP_TINT = _tint(1.0, 0.80, 0.52)  # warm LED, about 3000 K
BEAM_TINT = _tint(1.0, 0.96, 0.88)
WINDOW_TINT = _tint(1.0, 0.78, 0.45)
FLASH_TINT = _tint(0.92, 0.98, 1.15)


@dataclass(frozen=True, slots=True)
class Light:
    """Everything the kernels need to know of light, RGB triples in lx or cd/m2.

    Attributes:
        sun_direction: (3,) world, towards the sun.
        sun_lx: (3,) on a surface facing the sun.
        sky_lx: (3,) on a horizontal surface, from the sky.
        bounce_lx: (3,) on a surface facing down, from the ground.
        zenith: (3,) sky radiance overhead.
        horizon: (3,) sky radiance at the horizon, which is the fog's airlight.
        airlight: Luminance of ``horizon``.
        lamp_lx: (3,) tint of lamps, luminance 1, or 0 if they are off.
        window: (3,) radiance of a lit window, 0 by day.
        beam_on: Whether headlights may shine.
    """

    sun_direction: np.ndarray
    sun_lx: np.ndarray
    sky_lx: np.ndarray
    bounce_lx: np.ndarray
    zenith: np.ndarray
    horizon: np.ndarray
    airlight: float
    lamp_lx: np.ndarray
    window: np.ndarray
    beam_on: bool


def sun_illuminance_lx(altitude_deg: float, cloudiness: float) -> float:
    """Direct normal illuminance: 127.5 klx exp(-c / sin(altitude)).

    c is .21 for a clear and .80 for a partly covered sky (IES daylight calculation, 1984); between them c is
    linear in the cloudiness, and from half cover on the disc fades to nothing.
    """
    sine = math.sin(math.radians(altitude_deg))
    if sine <= 0:
        return 0.0
    extinction = 0.21 + (0.80 - 0.21) * min(1.0, 2 * cloudiness)
    disc = min(1.0, max(0.0, 2.0 - 2.0 * cloudiness))
    return 127_500.0 * math.exp(-extinction / max(sine, 0.02)) * disc


def sky_illuminance_lx(altitude_deg: float, cloudiness: float) -> float:
    """Horizontal illuminance from the sky without the sun.

    Clear .8 + 15.5 sqrt(sin h), overcast .3 + 21 sin h klx (IES, 1984); in twilight it falls exponentially to 3 lx at
    -6 degrees; .3 lx of urban sky glow remain at night.
    """
    glow = 0.3 * (1 + cloudiness)
    if altitude_deg >= 0:
        sine = math.sin(math.radians(altitude_deg))
        clear, covered = 800 + 15_500 * math.sqrt(sine), 300 + 21_000 * sine
        return glow + clear + (covered - clear) * cloudiness
    return glow + (800 - 500 * cloudiness) * math.exp(0.93 * altitude_deg)


def light_of(weather: Weather) -> Light:
    """Return the light of a weather."""
    altitude, azimuth = math.radians(weather.sun_altitude_deg), math.radians(weather.sun_azimuth_deg)
    direction = np.array(
        [math.cos(altitude) * math.cos(azimuth), math.cos(altitude) * math.sin(azimuth), math.sin(altitude)]
    )
    cloud = weather.cloudiness
    fog = 1 - math.exp(
        -weather.extinction_per_m * 150.0
    )  # share of the sun's beam scattered by a 150 m layer
    direct = sun_illuminance_lx(weather.sun_altitude_deg, cloud)
    sky = sky_illuminance_lx(weather.sun_altitude_deg, cloud) + 0.6 * fog * direct * max(0.0, direction[2])
    direct *= 1 - fog
    low = max(0.0, 1 - max(0.0, weather.sun_altitude_deg) / 25.0) ** 2
    grey = 1 - (1 - cloud) * (1 - fog)
    sun_tint = _tint(1.0, 0.96 - 0.26 * low, 0.88 - 0.5 * low)
    sky_tint = _tint(*(np.array([0.57, 0.785, 1.17]) * (1 - grey) + np.array([0.97, 1.0, 1.03]) * grey))
    if weather.night:
        sky_tint = _tint(*(np.array([0.75, 0.85, 1.1]) * (1 - grey) + np.array([1.0, 0.93, 0.85]) * grey))
    warm = (
        low * (1 - grey) if weather.sun_altitude_deg > -6 else 0.0
    )  # a low sun reddens the haze it shines through
    haze_tint = _tint(*(0.45 * sky_tint + 0.55 * np.array([1.0, 1.0 - 0.22 * warm, 1.0 - 0.55 * warm])))
    mean = sky / math.pi
    total = sky + direct * max(0.0, direction[2])
    # a clear sky brightens towards the horizon, an overcast one darkens (CIE: zenith three times the horizon)
    zenith = mean * (0.72 * (1 - grey) + 1.15 * grey)
    horizon = mean * (1.9 * (1 - grey) + 0.85 * grey)
    lamps = LAMP_TINT if weather.street_lamps else np.zeros(3)
    if weather.street_lamps and weather.sun_altitude_deg < 0:
        horizon += 0.3 * fog + 0.02  # light of the lamps scattered by the air
    return Light(
        sun_direction=direction,
        sun_lx=direct * sun_tint,
        sky_lx=sky * sky_tint,
        bounce_lx=(0.18 + 0.57 * weather.snow_cover) * total * _tint(1.0, 0.97, 0.92),
        zenith=zenith * sky_tint,
        horizon=horizon * haze_tint,
        airlight=float(horizon),
        lamp_lx=lamps,
        window=(25.0 * WINDOW_TINT if weather.sun_altitude_deg < 2 else np.zeros(3)),
        beam_on=weather.headlights,
    )


def flashed(light: Light, flash_lx: float) -> Light:
    """Return ``light`` with lightning that adds ``flash_lx`` to the ground, evenly from all of the clouded sky."""
    if flash_lx <= 0:
        return light
    flash = flash_lx * FLASH_TINT
    return replace(
        light,
        sky_lx=light.sky_lx + flash,
        bounce_lx=light.bounce_lx + 0.18 * flash,
        zenith=light.zenith + flash / math.pi,
        horizon=light.horizon + flash / math.pi,
        airlight=light.airlight + flash_lx / math.pi,
    )


def low_beam_table() -> np.ndarray:
    """Return a low beam for right-hand traffic, both lamps together.

    A hot spot right below the cut-off, a wide foreground, the cut-off at -0.57 degrees on the left (1 % down), rising by
    15 degrees to the right until +1.5 degrees, and stray light above (shape of UN R112's class B points).

    Returns:
        (rows, columns) float32 candela over tan(elevation) in BEAM_TAN_V and tan(angle to the left) in BEAM_TAN_H.
    """
    rows, columns = BEAM_SHAPE
    elevation = np.degrees(np.arctan(np.linspace(*BEAM_TAN_V, rows)))[:, None]
    right = -np.degrees(np.arctan(np.linspace(*BEAM_TAN_H, columns)))[None, :]
    cut = -0.57 + np.clip(right * math.tan(math.radians(15)), 0.0, 2.0)
    below = 1 / (1 + np.exp(np.clip((elevation - cut) / 0.18, -60, 60)))
    hot = 26_000 * np.exp(-(((right - 1.5) / 5.5) ** 2) - ((elevation + 1.0) / 1.5) ** 2)
    wide = 7_500 * np.exp(-((right / 21.0) ** 2)) * np.exp(np.minimum(0.0, elevation + 1.5) / 4.5)
    stray = 300 * np.exp(-((right / 25.0) ** 2)) * np.exp(-np.maximum(0.0, elevation) / 5.0)
    return np.ascontiguousarray(((hot + wide) * below + stray) * _table_edge(), dtype=np.float32)


def high_beam_table() -> np.ndarray:
    """Return a high beam, both lamps together: a round hot spot on the axis over a wide, flat foreground.

    Each lamp gives 45,000 cd at most; UN R112 demands 40,500 of its class B (paragraph 6.3). Its values to the side, taken
    here as half of that at 2.6 and 5,100 at 5.2 degrees, are from memory and not checked.

    Returns:
        Candela over the same angles as low_beam_table.
    """
    rows, columns = BEAM_SHAPE
    elevation = np.degrees(np.arctan(np.linspace(*BEAM_TAN_V, rows)))[:, None]
    right = -np.degrees(np.arctan(np.linspace(*BEAM_TAN_H, columns)))[None, :]
    hot = 72_000 * np.exp(-((right / 4.2) ** 2) - (elevation / 2.2) ** 2)
    wide = 18_000 * np.exp(-((right / 14.0) ** 2) - ((elevation + 0.5) / 4.0) ** 2)
    return np.ascontiguousarray((hot + wide) * _table_edge(), dtype=np.float32)


def _table_edge() -> np.ndarray:
    """Fade towards the tables' borders: (rows, columns)."""
    rows, columns = BEAM_SHAPE
    across, up = np.linspace(*BEAM_TAN_H, columns)[None, :], np.linspace(*BEAM_TAN_V, rows)[:, None]
    edge: np.ndarray = np.clip((BEAM_TAN_H[1] - np.abs(across)) / 0.2, 0, 1)
    edge = edge * np.clip((BEAM_TAN_V[1] - up) / 0.08, 0, 1)
    return edge * np.clip((up - BEAM_TAN_V[0]) / 0.08, 0, 1)
