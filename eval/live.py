"""``pedcross play``: one episode to watch, in a window or as a video."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from agents import CONTROLS, AebConfig, braking_policy, make_control
from eval.canvas import StoppedByUser, open_screen
from eval.dashboard import Scene, draw_dashboard
from eval.episodes import ControlSource, DetectorSource, Source, Trace, play
from eval.jobs import make_env, make_suite_env
from pedcross_env.config import EgoConfig, EnvConfig, TrafficConfig, camera_preset, require
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError, unknown_name
from pedcross_env.scenario.suites import suite
from pedcross_env.weather import weather_by_name

__all__ = ["PlayConfig", "PlayReport", "play_live"]

HOLD_S = 1.5
"""How long the last picture, with the outcome, stays."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayConfig:
    """Settings of ``pedcross play``."""

    driver: str = "oracle"
    """Where p(crossing) comes from: a control (oracle, never, always, random), a shipped network, a checkpoint's folder
    or module:factory of your own."""
    weather: str = ""
    """A preset; `pedcross weathers` lists them; empty: clear, or the weather of a suite's cell."""
    seed: int = 0
    """Of the episode; the same seed in another weather is the same crossing."""
    suite: str = ""
    """Play a cell of this suite instead of a random crossing; `pedcross suites` lists them."""
    cell: str = ""
    """Which one, e.g. CPNCO-50/40; `pedcross suites NAME` lists them."""
    out: Path = Path("out/play.mp4")
    """The video, .mp4 or .avi."""
    window: bool = False
    """Show it on the screen instead of writing a video: space pauses, Q ends."""
    slow_motion: float = 1.0
    """How many times slower than real time it is shown."""
    camera: str = ""
    """A camera preset; empty: "default", or "compact" for networks, which were trained with it."""
    boxes: bool = True
    """Outline pedestrians in the RGB picture (from the truth, not from the detector)."""
    threshold: float | None = None
    """When to brake; not given: the driver's own."""
    aeb: AebConfig = field(default_factory=AebConfig)
    """Its threshold is replaced by the driver's."""
    traffic: TrafficConfig = field(default_factory=TrafficConfig)
    ego: EgoConfig = field(default_factory=EgoConfig)

    def __post_init__(self) -> None:
        if self.weather:
            weather_by_name(self.weather)
        require(
            bool(self.suite) or not self.cell,
            "cell",
            self.cell,
            "given with a suite, e.g. suite = 'euro-ncap-2026'",
        )
        require(
            not self.suite or not self.weather,
            "weather",
            self.weather,
            "left out for a suite: its cells have theirs",
        )
        if self.suite:
            own = suite(self.suite)
            require(bool(self.cell), "cell", self.cell, f"given for a suite, e.g. {own.cells[0].id}")
            own.cell(self.cell)
        require(self.seed >= 0, "seed", self.seed, "0 or more")
        require(0.05 <= self.slow_motion <= 100, "slow_motion", self.slow_motion, "0.05 to 100")
        if self.camera:
            camera_preset(self.camera)
        if self.threshold is not None:
            require(0 < self.threshold <= 1, "threshold", self.threshold, "above 0, at most 1")


@dataclass(frozen=True, slots=True)
class PlayReport:
    """How the episode went.

    Attributes:
        trace: All of it; ends early where the user closed the window.
        outcome: Outcome's value; "running" where it was stopped.
        path: The video, None for a window.
    """

    trace: Trace
    outcome: str
    path: Path | None


def _driver(config: PlayConfig) -> tuple[Source, float, str]:
    """Where p comes from, the threshold to brake at, and the camera preset it wants."""
    if config.driver in CONTROLS:
        control = make_control(config.driver)
        return ControlSource(control), control.threshold, "default"
    from eval.detectors import load_detector, resolve_detectors
    from perception.checkpoint import list_shipped

    known = (*CONTROLS, *list_shipped())
    if config.driver not in known and ":" not in config.driver and not Path(config.driver).is_dir():
        raise ConfigError(
            f"{unknown_name('driver', config.driver, known)} Or give the folder of a checkpoint, or 'module:factory'."
        )
    (spec,) = resolve_detectors([config.driver])
    return DetectorSource(load_detector(spec.path)), spec.braking_threshold, "compact"


def play_live(
    config: PlayConfig, progress: Callable[[int, int, str], None] = lambda done, total, what: None
) -> PlayReport:
    """Play an episode and show it.

    Args:
        config: Settings.
        progress: Called with (steps done, steps at most, what is going on).

    Raises:
        ConfigError: For unknown names, no display, or a file that cannot be written.
    """
    source, threshold, camera = _driver(config)
    threshold = threshold if config.threshold is None else config.threshold
    release = config.aeb.release_threshold
    policy = braking_policy(
        config.driver,
        dataclasses.replace(
            config.aeb,
            threshold=threshold,
            release_threshold=None if release is None else min(release, threshold),
        ),
    )
    weather = config.weather or "clear"
    env_config = EnvConfig(
        weather=(weather,),
        camera=camera_preset(config.camera or camera),
        traffic=config.traffic,
        ego=config.ego,
    )
    env = make_suite_env(env_config, config.suite) if config.suite else make_env(env_config)
    hz = env_config.world.policy_hz
    what = f"{config.suite} {config.cell}" if config.suite else f"episode {config.seed}"
    title = f"{config.driver} drives   ·   {what}"
    path = None if config.window else config.out
    watched: list[Trace] = []
    try:
        with open_screen(path, hz / config.slow_motion, window=title if config.window else None) as screen:

            def watch(trace: Trace, observation: Mapping[str, np.ndarray]) -> None:
                watched[:] = [trace]
                world: Any = env.unwrapped
                duration_s = float(world.world.scenario.duration_s)
                told = f"{title}   ·   {trace.infos[0]['weather']}"
                scene = _scene(world, observation, told, threshold, duration_s, config.boxes)
                picture = draw_dashboard(scene, trace.infos, trace.probabilities)
                ended = trace.infos[-1]["outcome"] != Outcome.RUNNING
                for _ in range(1 + (math.ceil(HOLD_S * hz / config.slow_motion) if ended else 0)):
                    screen.show(picture)
                done, most = len(trace.actions), math.ceil(duration_s * hz)
                progress(most if ended else done, most, str(trace.infos[-1]["outcome"]))

            play(env, source, policy, seed=config.seed, weather=weather, cell=config.cell, watch=watch)
    except StoppedByUser:
        pass
    finally:
        env.close()
    trace = watched[0] if watched else Trace()
    return PlayReport(trace, str(trace.infos[-1]["outcome"]) if trace.infos else Outcome.RUNNING.value, path)


def _scene(
    env: Any,
    observation: Mapping[str, np.ndarray],
    title: str,
    threshold: float,
    duration_s: float,
    boxes: bool,
) -> Scene:
    truth = env.truth()
    crossing = set(env.world.crossing_ids())
    outlined = [
        (person.visible_box, person.actor_id in crossing)
        for person in truth.pedestrians
        if boxes and person.visible_box is not None
    ]
    return Scene(
        rgb=observation["rgb"], dvs=observation["dvs"], depth=truth.depth, above=env.birds_eye(), boxes=outlined,
        title=title, threshold=threshold, duration_s=duration_s,
    )  # fmt: skip
