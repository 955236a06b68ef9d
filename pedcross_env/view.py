"""What the camera looks at: the street, its actors at a moment, and the weather between them and the lens."""

from __future__ import annotations

from typing import Any

import numpy as np

from pedcross_env.camera import Renderer, camera_pose
from pedcross_env.config import EnvConfig
from pedcross_env.contracts import Frame, Snapshot
from pedcross_env.weather import Lightning, Precipitation, Weather, Windscreen
from pedcross_env.world import World

__all__ = ["View"]


class View:
    """One episode seen by one camera.

    Attributes:
        world: Gives the poses.
        camera: The camera.
        renderer: Loaded with the street.
        lightning: Its light is the renders' ``flash_lx``.
    """

    def __init__(
        self, config: EnvConfig, renderer: Renderer, world: World, weather: Weather, weather_seed: int,
        memory: Any = None,
    ) -> None:  # fmt: skip
        camera = config.camera
        self.world, self.camera, self.renderer = world, camera, renderer
        renderer.load(world.scenario.street, weather)
        self._precipitation = Precipitation(weather, weather_seed)
        self.lightning = Lightning(weather, weather_seed)
        self._windscreen = Windscreen(weather, config.windscreen, weather_seed, memory)
        if memory is None:
            self.drive()

    @property
    def streaks_per_s(self) -> float:
        """Diameters that a drop or flake falls in a second; 0 where nothing falls."""
        return self._precipitation.streaks_per_s

    @property
    def memory(self) -> Any:
        """All that the next picture depends on, besides world and weather."""
        return self._windscreen.memory

    def drive(self) -> None:
        """Follow the world to its present time: rain strikes the windscreen on the way."""
        self._windscreen.drive(self.world.time_s, self.world.ego.speed_mps)

    def render(self, snapshot: Snapshot, flash_lx: float) -> Frame:
        """Render everything at one moment: radiance, depth and ids, without precipitation."""
        return self.renderer.render(snapshot, flash_lx=flash_lx)

    def luminance(self, snapshot: Snapshot, flash_lx: float) -> Frame:
        """Render luminance alone at one moment, without precipitation."""
        return self.renderer.render(snapshot, luminance_only=True, flash_lx=flash_lx)

    def by_layers(self, before: Snapshot, after: Snapshot) -> bool:
        """Whether parts of the scene can be rendered apart from one moment to the other: see Renderer.by_layers.

        Not in falling rain or snow, either, nor while lightning strikes.
        """
        still = not self._precipitation.falls and self.lightning.dark(before.time_s, after.time_s)
        return still and all(self.renderer.by_layers(snapshot.ego) for snapshot in (before, after))

    def precipitate(
        self, frame: Frame, snapshot: Snapshot, exposure_s: float, depth: np.ndarray | None = None
    ) -> None:
        """Draw the rain and the snow of an exposure centred on ``snapshot`` into ``frame``, and drops on the glass."""
        if not self._precipitation.falls:
            return
        pose = camera_pose(self.camera, snapshot.ego)
        self._precipitation.draw(
            frame, pose, snapshot.time_s, exposure_s, self.world.ego.speed_mps,
            depth=depth, beam=self.renderer.own_beam(snapshot),
        )  # fmt: skip
        self._windscreen.draw(frame, pose, snapshot.time_s)
