"""From the world to what the sensors deliver: renders, weather in front of the lens, RGB and events."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pedcross_env.camera import CameraPose, Renderer, camera_pose
from pedcross_env.camera.truth import Truth, truth_of
from pedcross_env.config import EnvConfig
from pedcross_env.contracts import EVENT_DTYPE, Frame
from pedcross_env.flow import image_flow_px
from pedcross_env.scenario import Scenario
from pedcross_env.sensors import dvs, rgb
from pedcross_env.weather import Lightning, Precipitation, Weather
from pedcross_env.world import World

__all__ = ["Sight", "Vision"]

LIGHT_STEP = 0.3  # change of the logarithm of the sky's light by lightning between two renders
LIGHT_GRID_S = 0.25e-3


@dataclass(frozen=True, slots=True)
class Sight:
    """What the sensors delivered for one policy step.

    Attributes:
        rgb: (H, W, 3) uint8 or None.
        counts: (H, W, 2) uint8 events ON, OFF of the step, saturating, or None.
        events: (N,) EVENT_DTYPE or None.
        frame: The full render at the end of the step (with depth and ids), None where none was needed.
        subframes: Luminance renders of the step.
        flow_px: Bound on the image motion between two of them; nan without the event camera.
    """

    rgb: np.ndarray | None
    counts: np.ndarray | None
    events: np.ndarray | None
    frame: Frame | None
    subframes: int
    flow_px: float


class Vision:
    """The camera and the sensors behind it, for the modalities asked for.

    A modality that is not asked for costs nothing; the event camera alone renders luminance only.
    """

    def __init__(self, config: EnvConfig) -> None:
        self._config = config
        self._renderer = Renderer(config.camera)
        self._scenario: Scenario | None = None

    def reset(self, world: World, weather: Weather, *, weather_seed: int, sensor_seed: int) -> Sight:
        """Load the street, look at it once and return the first sight (no events yet)."""
        self._world = world
        self._scenario = world.scenario
        self._renderer.load(world.scenario.street, weather)
        self._precipitation = Precipitation(weather, weather_seed)
        self._lightning = Lightning(weather, weather_seed)
        self._sensor_seed = sensor_seed
        self._frame_index = 0
        self._depth: np.ndarray | None = None
        self._rgb_state = rgb.initial_rgb_state(self._config.rgb)
        config = self._config
        frame = self.render(0.0) if "rgb" in config.modalities else None
        counts = events = None
        if "dvs" in config.modalities:
            shape = (config.camera.height_px, config.camera.width_px, 2)
            counts = np.zeros(shape, np.uint8)
            events = np.empty(0, EVENT_DTYPE) if config.return_events else None
            log_frame = self._log_luminance(0.0, 1.0 / config.world.policy_hz)
            self._dvs_state = dvs.initial_state(log_frame, 0, config.dvs, sensor_seed)
        flow = 0.0 if "dvs" in config.modalities else math.nan
        return Sight(self._expose(frame, 0.0), counts, events, frame, 0, flow)

    def render(self, time_s: float) -> Frame:
        """Render everything (radiance, depth, ids) at a time within the last policy step, rain included.

        Rain, snow and lightning are those of the RGB camera's exposure, which ends then.
        """
        exposure_s = rgb.exposure_time_s(self._rgb_state, self._config.rgb)
        frame = self._full(time_s, self._lightning.mean_lx(time_s - exposure_s, time_s))
        self._depth = frame.depth
        self._rain(frame, self._pose(time_s), time_s, exposure_s)
        return frame

    def look(self, start_s: float, end_s: float) -> Sight:
        """Sense the policy step from ``start_s`` to ``end_s``."""
        config = self._config
        counts = events = None
        subframes, flow = 0, math.nan
        if "dvs" in config.modalities:
            times, flow = self._plan(start_s, end_s)
            subframes = len(times)
            counts, events = self._sense_events(start_s, times)
        frame = self._exposed(start_s, end_s) if "rgb" in config.modalities else None
        return Sight(self._expose(frame, end_s - start_s), counts, events, frame, subframes, flow)

    def _full(self, time_s: float, flash_lx: float) -> Frame:
        return self._renderer.render(self._world.snapshot(time_s), flash_lx=flash_lx)

    def _pose(self, time_s: float) -> CameraPose:
        return camera_pose(self._config.camera, self._world.snapshot(time_s).ego)

    def _exposed(self, start_s: float, end_s: float) -> Frame:
        """What reaches the RGB sensor during its exposure, not before ``start_s``; depth and ids of its end."""
        frame = self.render(end_s)
        samples = self._config.rgb.motion_blur_samples
        exposure_s = min(rgb.exposure_time_s(self._rgb_state, self._config.rgb), end_s - start_s)
        if samples == 1 or frame.radiance is None:
            return frame
        part_s = exposure_s / samples
        radiance, luminance = np.zeros_like(frame.radiance), np.zeros_like(frame.luminance)
        for k in range(samples):
            at = end_s - exposure_s + (k + 0.5) * part_s
            part = self._full(at, self._lightning.mean_lx(at - 0.5 * part_s, at + 0.5 * part_s))
            self._rain(part, self._pose(at), at, part_s)
            radiance += part.radiance
            luminance += part.luminance
        share = np.float32(1.0 / samples)
        return replace(frame, radiance=radiance * share, luminance=luminance * share)

    def truth(self, frame: Frame | None, time_s: float, from_s: float | None = None) -> Truth:
        """All that is known of the picture at ``time_s``, with the flow back to ``from_s`` if given; changes no state.

        ``frame`` is its full render; None renders it.
        """
        snapshot = self._world.snapshot(time_s)
        frame = self._full(time_s, 0.0) if frame is None else frame
        return truth_of(
            frame, snapshot, self._renderer, None if from_s is None else self._world.snapshot(from_s)
        )

    def visible_fraction(self, actor_id: int, frame: Frame, time_s: float) -> float:
        """Share of an actor's silhouette that ``frame``, the full render at ``time_s``, shows."""
        return self._renderer.visible_fraction(frame, self._world.snapshot(time_s), actor_id)

    def expose_once(self, time_s: float) -> np.ndarray:
        """Take a picture with a fresh automatic exposure, for people; changes no sensor's state."""
        state = rgb.initial_rgb_state(self._config.rgb)
        return rgb.expose(state, self.render(time_s), 0.0, self._config.rgb, self._sensor_seed)[1]

    def _expose(self, frame: Frame | None, dt_s: float) -> np.ndarray | None:
        if frame is None:
            return None
        seed = self._sensor_seed + self._frame_index
        self._frame_index += 1
        self._rgb_state, image = rgb.expose(self._rgb_state, frame, dt_s, self._config.rgb, seed)
        return image

    def _plan(self, start_s: float, end_s: float) -> tuple[list[float], float]:
        """Times of the event camera's renders and the largest image motion between two of them.

        They are spread so that the image's motion, and the change of the light where lightning strikes, is the same
        between any two.
        """
        before, after = self._world.snapshot(start_s), self._world.snapshot(end_s)
        flow = image_flow_px(self._config.camera, self._world.scenario.street, before, after)
        steps = flow / self._config.dvs.max_flow_px
        cap = self._config.dvs.max_subframes
        if self._lightning.dark(start_s, end_s):
            count = max(1, math.ceil(steps))
            count = count if cap is None else min(count, cap)
            times = [start_s + k * (end_s - start_s) / count for k in range(1, count)]
            return [*times, end_s], flow / count
        grid = np.linspace(start_s, end_s, max(2, round((end_s - start_s) / LIGHT_GRID_S)))
        light = np.array([self._lightning.light_lx(float(t)) for t in grid]) + self._renderer.sky_lx
        changes = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(np.log(light))))]) / LIGHT_STEP
        progress = changes + steps * (grid - start_s) / (end_s - start_s)
        count = max(1, math.ceil(progress[-1]))
        count = count if cap is None else min(count, cap)
        inner = np.interp(progress[-1] * np.arange(1, count) / count, progress, grid)
        times = [float(t) for t in inner] + [end_s]
        longest = max(np.diff([start_s, *times])) / (end_s - start_s)
        return times, float(flow * longest)

    def _sense_events(self, start_s: float, times: list[float]) -> tuple[np.ndarray, np.ndarray | None]:
        config = self._config
        counts = np.zeros((config.camera.height_px, config.camera.width_px, 2), np.uint8)
        parts: list[np.ndarray] = []
        for before_s, time_s in zip([start_s, *times], times, strict=False):
            log_frame = self._log_luminance(time_s, time_s - before_s)
            time_ns = round(time_s * 1e9)
            if config.return_events:
                self._dvs_state, events = dvs.step(self._dvs_state, log_frame, time_ns, config.dvs)
                parts.append(events)
            else:
                self._dvs_state = dvs.step_counts(self._dvs_state, log_frame, time_ns, config.dvs, counts)
        if not config.return_events:
            return counts, None
        events = np.concatenate(parts)
        dvs.add_counts(counts, events)
        return counts, events

    def _log_luminance(self, time_s: float, interval_s: float) -> np.ndarray:
        # Streaks are drawn as long as the drop falls between two renders: no gaps, hence no aliasing.
        snapshot = self._world.snapshot(time_s)
        flash_lx = self._lightning.light_lx(time_s)
        frame = self._renderer.render(snapshot, luminance_only=True, flash_lx=flash_lx)
        self._rain(frame, camera_pose(self._config.camera, snapshot.ego), time_s, interval_s)
        return dvs.log_luminance(frame.luminance, self._config.dvs.log_floor_cd_m2)

    def _rain(self, frame: Frame, pose: CameraPose, time_s: float, exposure_s: float) -> None:
        self._precipitation.draw(
            frame, pose, time_s, exposure_s, self._world.ego.speed_mps, depth=self._depth,
            beam=self._renderer.own_beam(self._world.snapshot(time_s)),
        )  # fmt: skip
