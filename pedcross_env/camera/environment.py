"""Light and air as the kernels' vector, and beams, in camera coordinates."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels import lighting as at
from pedcross_env.camera.light import BEAM_TINT, Light
from pedcross_env.camera.pinhole import CameraPose
from pedcross_env.contracts import ActorKind
from pedcross_env.weather.weather import Weather

__all__ = ["beam_place", "constant_environment", "environment", "others_beams"]

BEAM_HEIGHT_M = 0.65


def constant_environment(light: Light, weather: Weather) -> np.ndarray:
    """Return (ENV_SIZE,) with what does not depend on the camera."""
    env = np.zeros(at.ENV_SIZE)
    for offset, value in (
        (at.ENV_SUN, light.sun_lx), (at.ENV_SKY, light.sky_lx), (at.ENV_BOUNCE, light.bounce_lx), (at.ENV_AIR, light.horizon),
        (at.ENV_ZENITH, light.zenith), (at.ENV_LAMP, light.lamp_lx), (at.ENV_WINDOW, light.window), (at.ENV_BEAM_TINT, BEAM_TINT),
    ):  # fmt: skip
        env[offset : offset + 3] = value
    env[at.ENV_BETA], env[at.ENV_WET] = weather.extinction_per_m, weather.wetness
    env[at.ENV_SNOW] = weather.snow_cover
    return env


def environment(constant: np.ndarray, pose: CameraPose, ego: np.ndarray, light: Light) -> np.ndarray:
    """Return the vector for a camera: the sun's and the vertical direction, the ego's own beam.

    Args:
        constant: From ``constant_environment``.
        pose: The camera.
        ego: One ACTOR_DTYPE record.
        light: Gives the sun's direction and whether beams are on.
    """
    env = constant.copy()
    env[at.ENV_SUN_DIRECTION : at.ENV_SUN_DIRECTION + 3] = pose.turned(light.sun_direction.tolist())
    env[at.ENV_UP : at.ENV_UP + 3] = pose.rotation[:, 2]
    if light.beam_on or float(ego["headlight"]) > 0:
        env[at.ENV_BEAM] = 1.0
        env[at.ENV_BEAM_POSITION : at.ENV_BEAM_POSITION + 12] = beam_place(pose, ego)
    return env


def others_beams(pose: CameraPose, actors: np.ndarray, light: Light) -> np.ndarray:
    """Return (B, 13) beams of the vehicles that shine: place as ``beam_place``, strength."""
    if not light.beam_on:
        return np.zeros((0, 13))
    shining = actors[(actors["kind"] == ActorKind.VEHICLE) & (actors["headlight"] > 0)]
    return np.array([[*beam_place(pose, a), float(a["headlight"])] for a in shining]).reshape(-1, 13)


def beam_place(pose: CameraPose, vehicle: np.ndarray) -> np.ndarray:
    """Return (12,) of a vehicle's headlights: position, forward, left and up in camera coordinates."""
    yaw, pitch = float(vehicle["yaw"]), float(vehicle["pitch"])
    c, s, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    forward, left, upright = (cp * c, cp * s, -sp), (-s, c, 0.0), (sp * c, sp * s, cp)
    ahead = 0.5 * float(vehicle["length"])
    place = [
        float(vehicle[axis]) + ahead * forward[k] + BEAM_HEIGHT_M * upright[k] - float(pose.origin[k])
        for k, axis in enumerate("xyz")
    ]
    return np.concatenate([pose.turned(axis) for axis in (place, forward, left, upright)])
