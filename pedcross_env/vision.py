"""From the world to what the sensors deliver: renders, weather in front of the lens, RGB and events."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pedcross_env.camera import Renderer
from pedcross_env.camera.truth import Truth, truth_of
from pedcross_env.config import EnvConfig
from pedcross_env.contracts import Frame, Snapshot
from pedcross_env.event_vision import EventVision, Sensed
from pedcross_env.sensors import rgb
from pedcross_env.view import View
from pedcross_env.weather import Weather
from pedcross_env.world import World

__all__ = ["Sight", "Vision"]


@dataclass(frozen=True, slots=True)
class Sight:
    """What the sensors delivered for one policy step.

    Attributes:
        rgb: (H, W, 3) uint8 or None.
        sensed: What the event camera delivered, or None.
        frame: The full render at the end of the step (with depth and ids), None where none was needed.
    """

    rgb: np.ndarray | None
    sensed: Sensed | None
    frame: Frame | None

    @property
    def counts(self) -> np.ndarray | None:
        """(H, W, 2) uint8 events ON, OFF of the step, saturating, or None."""
        return None if self.sensed is None else self.sensed.counts

    @property
    def events(self) -> np.ndarray | None:
        """(N,) EVENT_DTYPE or None."""
        return None if self.sensed is None else self.sensed.events

    @property
    def causes(self) -> np.ndarray | None:
        """(N,) int32: what made the events, or None."""
        return None if self.sensed is None else self.sensed.causes

    @property
    def subframes(self) -> int:
        """Instants of the step at which luminance was rendered."""
        return 0 if self.sensed is None else self.sensed.instants

    @property
    def renders(self) -> int:
        """Number of luminance renders for the events of the step, each of the scene or of a layer of it."""
        return 0 if self.sensed is None else self.sensed.renders

    @property
    def streak(self) -> float:
        """Bound on a drop's fall between two of them, in its diameters; nan without the event camera."""
        return math.nan if self.sensed is None else self.sensed.streak

    @property
    def flow_px(self) -> float:
        """Bound on the image motion between two of them; nan without the event camera."""
        return math.nan if self.sensed is None else self.sensed.flow_px


class Vision:
    """The camera and the sensors behind it, for the modalities asked for.

    A modality that is not asked for costs nothing; the event camera alone renders luminance only.
    """

    def __init__(self, config: EnvConfig) -> None:
        self._config = config
        self._renderer = Renderer(config.camera)

    def reset(self, world: World, weather: Weather, *, weather_seed: int, sensor_seed: int) -> Sight:
        """Load the street, look at it once and return the first sight (no events yet)."""
        config = self._config
        self._world = world
        self._view = View(config, self._renderer, world, weather, weather_seed)
        self._sensor_seed = sensor_seed
        self._frame_index = 0
        self._depth: np.ndarray | None = None
        self._rgb_state = rgb.initial_rgb_state(config.rgb)
        frame = self.render(world.snapshot(0.0)) if "rgb" in config.modalities else None
        self._events = EventVision(config, self._view, sensor_seed) if "dvs" in config.modalities else None
        sensed = self._events.nothing() if self._events is not None else None
        return Sight(self._expose(frame, 0.0), sensed, frame)

    @property
    def memory(self) -> Any:
        """All that the next look depends on, besides world and weather."""
        events = None if self._events is None else self._events.memory
        return self._sensor_seed, self._frame_index, self._depth, self._rgb_state, events, self._view.memory

    def resume(self, world: World, weather: Weather, *, weather_seed: int, memory: Any) -> None:
        """Go on where another vision of the same config left off."""
        config = self._config
        self._world = world
        self._sensor_seed, self._frame_index, self._depth, self._rgb_state, events, seen = memory
        self._view = View(config, self._renderer, world, weather, weather_seed, seen)
        self._events = None
        if events is not None:
            self._events = EventVision(config, self._view, self._sensor_seed, events)

    def render(self, snapshot: Snapshot) -> Frame:
        """Render everything (radiance, depth, ids) at a moment within the last policy step, rain included.

        Rain, snow and lightning are those of the RGB camera's exposure, which ends then.
        """
        exposure_s = rgb.exposure_time_s(self._rgb_state, self._config.rgb)
        frame = self._part(snapshot, snapshot.time_s - exposure_s, snapshot.time_s)
        self._depth = frame.depth
        return frame

    def look(self, start_s: float, end_s: float) -> Sight:
        """Sense the policy step from ``start_s`` to ``end_s``."""
        before, after = self._world.snapshots((start_s, end_s))
        self._view.drive()
        sensed = self._events.look(before, after, self._depth) if self._events is not None else None
        frame = self._exposed(start_s, after) if "rgb" in self._config.modalities else None
        return Sight(self._expose(frame, end_s - start_s), sensed, frame)

    def _part(self, snapshot: Snapshot, from_s: float, to_s: float) -> Frame:
        """One render for the exposure between two times."""
        frame = self._view.render(snapshot, self._view.lightning.mean_lx(from_s, to_s))
        self._view.precipitate(frame, snapshot, to_s - from_s)
        return frame

    def _exposed(self, start_s: float, after: Snapshot) -> Frame:
        """What reaches the RGB sensor during its exposure, not before ``start_s``; depth and ids of its end."""
        frame, end_s = self.render(after), after.time_s
        samples = self._config.rgb.motion_blur_samples
        exposure_s = min(rgb.exposure_time_s(self._rgb_state, self._config.rgb), end_s - start_s)
        if samples == 1 or frame.radiance is None:
            return frame
        part_s = exposure_s / samples
        radiance, luminance = np.zeros_like(frame.radiance), np.zeros_like(frame.luminance)
        for k in range(samples):
            at = end_s - exposure_s + (k + 0.5) * part_s
            part = self._part(self._world.snapshot(at), at - 0.5 * part_s, at + 0.5 * part_s)
            radiance += part.radiance
            luminance += part.luminance
        share = np.float32(1.0 / samples)
        return replace(frame, radiance=radiance * share, luminance=luminance * share)

    def truth(self, frame: Frame | None, time_s: float, from_s: float | None = None) -> Truth:
        """All that is known of the picture at ``time_s``, with the flow back to ``from_s`` if given; changes no state.

        ``frame`` is its full render; None renders it.
        """
        snapshot = self._world.snapshot(time_s)
        frame = self._view.render(snapshot, 0.0) if frame is None else frame
        return truth_of(
            frame, snapshot, self._renderer, None if from_s is None else self._world.snapshot(from_s)
        )

    def visible_fraction(self, actor_id: int, frame: Frame, time_s: float) -> float:
        """Share of an actor's silhouette that ``frame``, the full render at ``time_s``, shows."""
        return self._renderer.visible_fraction(frame, self._world.snapshot(time_s), actor_id)

    def expose_once(self, time_s: float) -> np.ndarray:
        """Take a picture with a fresh automatic exposure, for people; changes no sensor's state."""
        state = rgb.initial_rgb_state(self._config.rgb)
        return rgb.expose(
            state, self.render(self._world.snapshot(time_s)), 0.0, self._config.rgb, self._sensor_seed
        )[1]

    def _expose(self, frame: Frame | None, dt_s: float) -> np.ndarray | None:
        if frame is None:
            return None
        seed = self._sensor_seed + self._frame_index
        self._frame_index += 1
        self._rgb_state, image = rgb.expose(self._rgb_state, frame, dt_s, self._config.rgb, seed)
        return image
