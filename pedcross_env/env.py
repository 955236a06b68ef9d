"""The Gymnasium environment: a street, a crossing, weather, two cameras and a brake."""

from __future__ import annotations

import math
import pickle
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces

from pedcross_env.birds_eye import draw_birds_eye
from pedcross_env.camera.truth import Truth
from pedcross_env.config import EgoConfig, EnvConfig, from_mapping
from pedcross_env.contracts import Outcome
from pedcross_env.errors import ConfigError, unknown_name
from pedcross_env.reward import reward_terms
from pedcross_env.scenario import Scenario
from pedcross_env.scenario.sampler import sample_crossing
from pedcross_env.vision import Sight, Vision
from pedcross_env.weather import Weather, as_weather
from pedcross_env.world import World

__all__ = ["CrossingEnv", "EpisodeState"]

View = Literal["driver", "birds_eye"]
VIEWS: tuple[View, ...] = ("driver", "birds_eye")


@dataclass(frozen=True, slots=True)
class EpisodeState:
    """A moment of an episode, made by ``CrossingEnv.save_state``; pickle it to keep or to send it.

    Attributes:
        config: Of the environment.
        payload: World, weather, sensors and random generator. Load only what you saved yourself: it is a pickle.
    """

    config: EnvConfig
    payload: bytes


class CrossingEnv(gymnasium.Env[dict[str, np.ndarray], np.ndarray]):
    """Drive towards a place where somebody may cross, and brake.

    Observation, a flat Dict with the modalities asked for:
        rgb: (H, W, 3) uint8.
        dvs: (H, W, 2) uint8, ON and OFF events per pixel since the last step, clipped at 255.
        ego: (3,) float32: speed in m/s, acceleration in m/s2, brake pressure 0..1.

    Action, Box(-1, 1, (1,)): demanded longitudinal acceleration; -1 is the strongest braking, 0 holds the
    speed, +1 the strongest acceleration. Latency, build-up and the road's friction act on it. With
    ``ego.steering`` it is Box(-1, 1, (2,)): the second number is the share of the largest steering angle, to the left
    positive, and who leaves the carriageway has ended the episode. With ``actions="discrete"`` it is Discrete(n) over
    the config's levels.

    Reward: a sum of terms, documented in ``pedcross_env.reward`` and weighted by RewardConfig; by default progress
    minus collision minus discomfort (and leaving the road). ``reward_terms`` has those of the last step.

    Terminated by a collision, by passing the finish or by leaving the road; truncated when the scenario's time is over.
    ``info`` has the keys of ``pedcross_env.contracts.INFO_KEYS`` on every step.

    Seeding: ``reset(seed=s)`` plays episode ``s``, bit for bit, in any process; ``reset()`` draws a new
    episode, whose ``info["episode_seed"]`` replays it. Scene, behaviour, weather and sensor noise have
    streams of their own, so the same seed in another weather is the same crossing.

    Options of ``reset``: ``weather`` (a preset's name, a Weather, CARLA's parameters or a mapping of physical
    quantities, see ``pedcross_env.weather.as_weather``) and ``scenario`` (a Scenario), for this episode alone.

    Args:
        config: An EnvConfig, or a nested mapping of its fields.
        render_mode: None or "rgb_array".
        view: What ``render`` shows: the driver's view, or the scene from above.

    Raises:
        ConfigError: For an unknown key, name or option, or a value out of range; names the nearest.
    """

    OPTIONS: tuple[str, ...] = ("scenario", "weather")
    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012 - Gymnasium's interface

    def __init__(
        self,
        config: EnvConfig | Mapping[str, Any] | None = None,
        *,
        render_mode: str | None = None,
        view: View = "driver",
    ) -> None:
        if not isinstance(config, EnvConfig):
            config = from_mapping(EnvConfig, config or {})
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise unknown_name("render_mode", render_mode, self.metadata["render_modes"])
        if view not in VIEWS:
            raise unknown_name("view", view, VIEWS)
        self.config = config
        self.render_mode = render_mode
        self._view = view
        self._weathers = [as_weather(item) for item in config.weather]
        self._vision: Vision | None = Vision(config) if config.modalities else None
        self._world: World | None = None
        self.observation_space = _observation_space(config)
        self._sight: Sight | None = None
        self._closed = False
        self._actions = _action_table(config)
        self.action_space: Any = spaces.Box(-1.0, 1.0, (2 if config.ego.steering else 1,), np.float32)
        if config.actions == "discrete":
            self.action_space = spaces.Discrete(len(self._actions))
        self.reward_terms: dict[str, float] = {}

    @property
    def world(self) -> World:
        """The world of the running episode.

        Raises:
            ConfigError: Before the first reset.
        """
        self._check_open()
        if self._world is None:
            raise ConfigError("the environment has no episode yet: call reset() first.")
        return self._world

    def _check_open(self) -> None:
        if self._closed:
            raise ConfigError("the environment is closed: make a new one.")

    @property
    def sight(self) -> Sight | None:
        """What the sensors last delivered, with depth and instance ids where RGB was rendered."""
        return self._sight

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Begin an episode; see the class for seeding and options."""
        self._check_open()
        super().reset(seed=seed)
        options = options or {}
        for key in options:
            if key not in self.OPTIONS:
                raise unknown_name("reset option", key, self.OPTIONS)
        self._episode_seed = int(self.np_random.integers(2**31)) if seed is None else int(seed)
        # One child per stream: what one of them draws never shifts another.
        weather_stream, rain_stream, sensor_stream = np.random.SeedSequence(
            self._episode_seed, spawn_key=(7,)
        ).spawn(3)
        self._begin(options)
        self.weather = self._choose_weather(options.get("weather"), np.random.default_rng(weather_stream))
        scenario = options.get("scenario")
        if scenario is None:
            scenario = self._draw_scenario()
        elif not isinstance(scenario, Scenario):
            raise ConfigError(
                f"reset option 'scenario' is a {type(scenario).__name__}; allowed: a pedcross_env.scenario.Scenario."
            )
        self._world = World(
            scenario,
            ego=self._episode_ego(),
            world=self.config.world,
            label=self.config.label,
            friction=self.weather.friction,
            camera=self.config.camera,
            headlights=self.weather.headlights,
        )
        self._seeds = (_seed_of(rain_stream), _seed_of(sensor_stream))
        self.reward_terms = {}
        self._sight = self._open_eyes(self._vision)
        return self._observation(), self._info()

    def step(self, action: np.ndarray) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        """Drive one policy step (1/30 s by default)."""
        demand, steer = self._wanted(action)
        ego = self.config.ego
        demand *= ego.max_acceleration_mps2 if demand > 0 else ego.max_deceleration_mps2
        world = self.world
        start_s, start_m, start_mps2 = world.time_s, world.front_m, world.ego.acceleration_mps2
        world.step(demand, steer)
        if self._vision is not None:
            self._sight = self._vision.look(start_s, world.time_s)
        outcome, info = world.outcome, self._info()
        self.reward_terms = reward_terms(
            self.config.reward, world, info, driven_m=world.front_m - start_m,
            acceleration_before_mps2=start_mps2, step_s=world.time_s - start_s,
        )  # fmt: skip
        reward = float(sum(self.reward_terms.values()))
        terminated = outcome in (Outcome.COLLISION, Outcome.PASSED, Outcome.OFF_ROAD)
        return self._observation(), reward, terminated, outcome is Outcome.TIMEOUT, info

    def _wanted(self, action: Any) -> tuple[float, float]:
        """(demand, steering) as shares, of an action."""
        if self.config.actions == "discrete":
            if not self.action_space.contains(action):
                raise ConfigError(
                    f"action {action!r} is not allowed: whole numbers from 0 to {len(self._actions) - 1}."
                )
            return self._actions[int(action)]
        values = np.clip(np.asarray(action, dtype=np.float64).reshape(-1), -1.0, 1.0)
        count = 2 if self.config.ego.steering else 1
        if len(values) != count:
            raise ConfigError(f"action {action!r} has {len(values)} numbers; allowed: {count}.")
        if np.isnan(values).any():
            raise ConfigError("action is nan; allowed: numbers from -1 (full braking) to 1.")
        return float(values[0]), float(values[1]) if count == 2 else 0.0

    def save_state(self) -> EpisodeState:
        """Keep this moment; it costs about a millisecond and the size of what the sensors remember.

        Raises:
            ConfigError: Before the first reset.
        """
        memory = None if self._vision is None else self._vision.memory
        kept = (self.world, self.weather, self._episode_seed, self._seeds, self.np_random, memory, self._sight,
                self.reward_terms)  # fmt: skip
        return EpisodeState(self.config, pickle.dumps(kept, protocol=pickle.HIGHEST_PROTOCOL))

    def load_state(self, state: EpisodeState) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Go back, or over, to a moment that was kept: what follows is the same, bit for bit.

        Args:
            state: From this or another environment of the same config, in any process; it can be loaded again.

        Returns:
            Observation and info of that moment.

        Raises:
            ConfigError: For a state of another config.
        """
        self._check_open()
        if state.config != self.config:
            raise ConfigError("the state is of an environment of another config: make one with state.config.")
        world, weather, seed, seeds, generator, memory, sight, terms = pickle.loads(state.payload)
        self._world, self.weather, self._episode_seed, self._seeds = world, weather, seed, seeds
        self.np_random, self._sight, self.reward_terms = generator, sight, terms
        if self._vision is not None:
            self._vision.resume(world, weather, weather_seed=seeds[0], memory=memory)
        return self._observation(), self._info()

    def close(self) -> None:
        """Let go of the episode and of the camera's memory; no process, thread, window or file is held besides."""
        self._world, self._sight, self._vision, self._closed = None, None, None, True
        super().close()

    def render(self) -> np.ndarray | None:
        """Return the view chosen at construction, (H, W, 3) uint8, or None without a render mode."""
        if self.render_mode is None:
            gymnasium.logger.warn(
                "render() without a render mode; make the environment with render_mode='rgb_array'."
            )
            return None
        return self.birds_eye() if self._view == "birds_eye" else self.driver_view()

    def driver_view(self) -> np.ndarray:
        """What the ego's camera sees, (H, W, 3) uint8, whatever the modalities."""
        if self._sight is not None and self._sight.rgb is not None:
            return self._sight.rgb
        if self._vision is None:
            vision = Vision(self.config)
            self._open_eyes(vision)
        else:
            vision = self._vision
        return vision.expose_once(self.world.time_s)

    def truth(self, *, flow: bool = False) -> Truth:
        """What the camera's picture shows, known without looking, whatever the modalities.

        Depth in metres, instance ids, class per pixel, and for every pedestrian its box, its visible box, which
        fraction is visible and which is beyond the picture's edges; see ``pedcross_env.camera.truth``.

        Args:
            flow: Whether to add the optical flow back to the previous step's picture: for each pixel, where its
                surface was then, relative to where it is now, (H, W, 2) pixels.

        Raises:
            ConfigError: Before the first reset; for the flow, before the first step.
        """
        world = self.world
        if flow and world.time_s == 0:
            raise ConfigError("truth(flow=True) looks back to the previous picture: call step() first.")
        vision = self._vision
        if vision is None:
            vision = Vision(self.config)
            self._open_eyes(vision)
        before = world.time_s - 1.0 / self.config.world.policy_hz if flow else None
        return vision.truth(None if self._sight is None else self._sight.frame, world.time_s, before)

    def birds_eye(self) -> np.ndarray:
        """The scene from above, (H, W, 3) uint8, the ego driving upwards."""
        world = self.world
        return draw_birds_eye(world.scenario, world.snapshot(world.time_s))

    def _open_eyes(self, vision: Vision | None) -> Sight | None:
        if vision is None:
            return None
        rain_seed, sensor_seed = self._seeds
        return vision.reset(self.world, self.weather, weather_seed=rain_seed, sensor_seed=sensor_seed)

    def _begin(self, options: Mapping[str, Any]) -> None:
        """Hook of subclasses: an episode begins, ``_episode_seed`` is known."""

    def _draw_scenario(self) -> Scenario:
        """Hook of subclasses: the scenario of ``_episode_seed``."""
        return sample_crossing(self._episode_seed, self.config.traffic, self.config.ego)

    def _episode_ego(self) -> EgoConfig:
        """Hook of subclasses: the ego of the episode; its size is the config's."""
        return self.config.ego

    def _choose_weather(self, asked: object, rng: np.random.Generator) -> Weather:
        drawn = self._weathers[int(rng.integers(len(self._weathers)))]
        return drawn if asked is None else as_weather(asked)  # type: ignore[arg-type]

    def _observation(self) -> dict[str, np.ndarray]:
        ego = self.world.ego
        observation = {"ego": np.array([ego.speed_mps, ego.acceleration_mps2, ego.brake], np.float32)}
        sight = self._sight
        if sight is not None and sight.rgb is not None:
            observation["rgb"] = sight.rgb
        if sight is not None and sight.counts is not None:
            observation["dvs"] = sight.counts
        return observation

    def _info(self) -> dict[str, Any]:
        sight = self._sight
        info: dict[str, Any] = {
            **self.world.facts(),
            "episode_seed": self._episode_seed,
            "scenario": self.world.scenario.name,
            "weather": self.weather.name,
            "visible_fraction": self._visible_fraction(),
            "subframes": sight.subframes if sight is not None else 0,
            "renders": sight.renders if sight is not None else 0,
            "flow_px": sight.flow_px if sight is not None else math.nan,
            "streak": sight.streak if sight is not None else math.nan,
        }
        if math.isnan(info["crossing_in_s"]):
            info["crossing_in_s"] = math.inf
        for key in ("visible_fraction", "flow_px", "streak", "impact_speed_mps"):
            info[key] = -1.0 if math.isnan(info[key]) else info[key]
        if self.config.return_events and sight is not None:
            info["events"] = sight.events
        if self.config.label_events and sight is not None:
            info["event_causes"] = sight.causes
        return info

    def _visible_fraction(self) -> float:
        crossing = self.world.crossing_ids()
        if not crossing or self._vision is None or self._sight is None or self._sight.frame is None:
            return math.nan
        return self._vision.visible_fraction(crossing[0], self._sight.frame, self.world.time_s)


def _seed_of(stream: np.random.SeedSequence) -> int:
    return int(stream.generate_state(1, np.uint32)[0])


def _action_table(config: EnvConfig) -> list[tuple[float, float]]:
    """(demand, steering) of each discrete action."""
    steers = config.steer_levels if config.ego.steering else (0.0,)
    return [(float(demand), float(steer)) for demand in config.demand_levels for steer in steers]


def _observation_space(config: EnvConfig) -> Any:
    height, width = config.camera.height_px, config.camera.width_px
    low = np.array([0.0, -30.0, 0.0], np.float32)
    high = np.array([60.0, 30.0, 1.0], np.float32)
    members: dict[str, spaces.Space[Any]] = {"ego": spaces.Box(low, high, dtype=np.float32)}
    if "rgb" in config.modalities:
        members["rgb"] = spaces.Box(0, 255, (height, width, 3), np.uint8)
    if "dvs" in config.modalities:
        members["dvs"] = spaces.Box(0, 255, (height, width, 2), np.uint8)
    return spaces.Dict(members)
