"""What is seen on the sky besides its gradient: clouds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pedcross_env.camera.clouds import cloud_texture
from pedcross_env.camera.kernels.clouds import add_clouds
from pedcross_env.camera.light import LUMA, Light
from pedcross_env.camera.pinhole import CameraPose
from pedcross_env.config import CameraConfig
from pedcross_env.weather.weather import Weather

__all__ = ["Sky"]

NODE_RAD = 0.006  # between nodes at which clouds are computed, at least two pixels
SUN_SHARE = 0.6  # of the sun's own colour in that of clouds
CLOUDLESS = np.zeros((2, 0, 0), np.float32)


@dataclass(slots=True)
class _Nodes:
    """What clouds add, (C, rows, columns), from where to where in each row that is known, and for which view and light."""

    values: np.ndarray
    known: np.ndarray
    rotation: bytes = b""
    light: Light | None = None

    def turn(self, rotation: np.ndarray, light: Light | None) -> None:
        """Forget what was known of another view or light."""
        view = rotation.tobytes()
        if view != self.rotation or light is not self.light:
            self.known[:] = 0
            self.rotation, self.light = view, light


class Sky:
    """A weather's clouds in pictures of one camera.

    Args:
        camera: A pinhole.
    """

    def __init__(self, camera: CameraConfig) -> None:
        self._step = max(2, int(NODE_RAD * camera.focal_px))
        rows, columns = camera.height_px // self._step + 2, (camera.width_px // self._step + 1) * self._step
        # clouds are infinitely far: what the nodes hold lasts until the view turns or the light changes
        self._nodes = {
            c: _Nodes(np.zeros((c, rows, columns), np.float32), np.zeros((rows, 2), np.int32)) for c in (1, 3)
        }
        self._work = np.zeros(8)
        self._free = np.zeros(camera.width_px, np.float32)
        self._texture = CLOUDLESS
        self._white = np.ones(3)

    def load(self, weather: Weather, light: Light, seed: int) -> None:
        """Take a weather's cloudiness and the colour that its sun gives to clouds; their shapes follow from ``seed``."""
        sun = float((light.sun_lx * LUMA).sum())
        self._white = np.ones(3) if sun <= 0 else (1 - SUN_SHARE) + SUN_SHARE * light.sun_lx / sun
        self._texture = cloud_texture(weather.cloudiness, seed) if weather.cloudiness > 0 else CLOUDLESS
        for nodes in self._nodes.values():
            nodes.light = None

    def clouds(self, channels: int, rotation: np.ndarray, light: Light) -> tuple[Any, ...]:
        """What kernels.clouds adds them from, for pictures of one or three ``channels``."""
        nodes = self._nodes[channels]
        nodes.turn(rotation, light)
        return self._texture, self._white, self._step, nodes.values, nodes.known, self._work

    def add_clouds(
        self, out: np.ndarray, alpha: np.ndarray, pose: CameraPose, env: np.ndarray, light: Light
    ) -> None:
        """Add them in place; see kernels.clouds."""
        if len(self._texture[0]) == 0:
            return
        optics = (pose.focal_px, pose.cx, pose.cy)
        clouds = self.clouds(len(out), pose.rotation, light)
        add_clouds(out, alpha, pose.rotation, env, optics, clouds, self._free)
