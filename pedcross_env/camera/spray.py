"""Spray that the wheels of moving vehicles throw up from a wet road.

Puffs hang where they were thrown, spread and thin out while the vehicle drives on: which there are follows from the places on
its way that its rear has passed, so that every camera and every sub-frame sees the same. How dense spray is has been measured
for trucks at motorway speeds more than for cars in town; the dependence on speed and film is a stated choice.
"""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.camera.kernels.spray import add_puffs
from pedcross_env.camera.light import Light
from pedcross_env.camera.pinhole import CameraPose
from pedcross_env.contracts import ActorKind, Snapshot
from pedcross_env.weather.weather import Weather

__all__ = ["Spray", "spray_thickness"]

SLOWEST_MPS = 4.0  # below it wheels throw nothing that hangs
FULL_MPS = 22.0
THICKEST = 0.45  # optical depth of a car's puff at FULL_MPS on a soaked road
FILM_MM = 0.3  # at which 1 - 1/e of the spray is there
HEAVY_M, HEAVIER = 2.3, 2.5  # higher vehicles throw so much more
SPACING_M, LIFE_S, BORN_S = 1.0, 0.8, 0.06
RADIUS_M, SPREADS_MPS = 0.3, 1.1
HEIGHT_M, RISES_MPS = 0.3, 0.5
RANGE_M, NEAR_M = 90.0, 2.0  # puffs fade out towards the lens: it is not driven through as a wall
WHITE = 0.9  # of the light around them that droplets send back
TOWARDS_LAMP = 0.1  # of a white surface's, back to the headlights


def spray_thickness(speed_mps: float, film_mm: float, height_m: float = 1.5) -> float:
    """Optical depth of one fresh puff: rises with the speed squared beyond 4 m/s and saturates with the water film."""
    if speed_mps <= SLOWEST_MPS or film_mm <= 0:
        return 0.0
    share = (speed_mps - SLOWEST_MPS) / (FULL_MPS - SLOWEST_MPS)
    heavy = HEAVIER if height_m > HEAVY_M else 1.0
    return THICKEST * heavy * min(1.5, share * share) * (1.0 - math.exp(-film_mm / FILM_MM))


class Spray:
    """The spray of one weather; without water on the road there is none.

    Args:
        weather: Its film.
        width_px: Columns of the pictures.
    """

    def __init__(self, weather: Weather, width_px: int) -> None:
        self._film_mm = weather.water_film_mm
        self._line = np.zeros(width_px, np.float32)

    def add(
        self,
        out: np.ndarray,
        luminance: np.ndarray,
        depth: np.ndarray,
        snapshot: Snapshot,
        pose: CameraPose,
        light: Light,
        head: tuple[np.ndarray, np.ndarray, float],
    ) -> None:
        """Add it to a finished picture, in place.

        Args:
            out: (3, H, W) radiance, or no planes where luminance is all that is wanted.
            luminance: (H, W).
            depth: (H, W) metres.
            snapshot: Whose vehicles throw it.
            pose: Of the camera.
            light: Around.
            head: The kernels' environment, beam tables and extinction per metre.
        """
        if self._film_mm <= 0:
            return
        vehicles = snapshot.actors[snapshot.actors["kind"] == ActorKind.VEHICLE]
        found = [self._of(actor, pose) for actor in vehicles[vehicles["speed"] > SLOWEST_MPS]]
        puffs = np.concatenate([np.zeros((0, 8)), *found])
        if len(puffs) == 0:
            return
        table = np.ascontiguousarray(puffs[np.argsort(-puffs[:, 2], kind="stable")])
        table[:, 5:] = WHITE * light.horizon
        env, beams, beta = head
        optics = (pose.focal_px, pose.cx, pose.cy)
        add_puffs(out, luminance, depth, table, env, beams, TOWARDS_LAMP / math.pi, beta, optics, self._line)

    def _of(self, actor: np.ndarray, pose: CameraPose) -> np.ndarray:
        """A vehicle's puffs, (N, 8): camera coordinates, radius, optical depth; three columns for light."""
        speed, width = float(actor["speed"]), float(actor["width"])
        fresh = spray_thickness(speed, self._film_mm, float(actor["height"]))
        away = math.hypot(float(actor["x"]) - pose.origin[0], float(actor["y"]) - pose.origin[1])
        ahead = sum(
            float(pose.rotation[2, k]) * (float(actor[axis]) - pose.origin[k]) for k, axis in enumerate("xyz")
        )
        if fresh <= 0 or away > RANGE_M + 20 or ahead < -speed * LIFE_S - float(actor["length"]):
            return np.zeros((0, 8))
        yaw = float(actor["yaw"])
        c, s = math.cos(yaw), math.sin(yaw)
        along = float(actor["x"]) * c + float(actor["y"]) * s
        across = float(actor["y"]) * c - float(actor["x"]) * s
        rear = along - 0.45 * float(actor["length"])
        first = math.ceil((rear - speed * LIFE_S) / SPACING_M)
        number = np.arange(first, math.floor(rear / SPACING_M) + 1)
        age = (rear - number * SPACING_M) / speed
        one, two, three = _chances(number, int(actor["id"]))
        left = 1.0 - age / LIFE_S
        side = across + np.where(number % 2 == 1, 0.36, -0.36) * width + 0.3 * (two - 0.5)
        x = number * SPACING_M * c - side * s - pose.origin[0]
        y = number * SPACING_M * s + side * c - pose.origin[1]
        z = float(actor["z"]) + HEIGHT_M + RISES_MPS * age * (0.5 + three) - pose.origin[2]
        puffs = np.zeros((len(number), 8))
        for k in range(3):
            puffs[:, k] = pose.rotation[k, 0] * x + pose.rotation[k, 1] * y + pose.rotation[k, 2] * z
        depth = puffs[:, 2]
        puffs[:, 3] = RADIUS_M + SPREADS_MPS * age
        puffs[:, 4] = fresh * np.minimum(1.0, age / BORN_S) * left * left * (0.6 + 0.8 * one)
        puffs[:, 4] *= np.clip((depth - 0.3) / NEAR_M, 0.0, 1.0) * np.clip((RANGE_M - depth) / 20.0, 0.0, 1.0)
        return puffs[puffs[:, 4] > 1e-4]


def _chances(number: np.ndarray, ident: int) -> list[np.ndarray]:
    """Three numbers in [0, 1) for each puff of a vehicle, from a hash (constants: Wellons' lowbias32)."""
    chances = []
    for k in range(3):
        h = ((number.astype(np.int64) * 3 + k) ^ (ident * 0x9E3779B1)).astype(np.uint64) & np.uint64(
            0xFFFFFFFF
        )
        for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
            h = ((h ^ (h >> np.uint64(shift))) * np.uint64(factor)) & np.uint64(0xFFFFFFFF)
        chances.append((h ^ (h >> np.uint64(16))) / 2.0**32)
    return chances
