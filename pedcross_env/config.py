"""Everything that can be set: frozen dataclasses, validated across fields, strict about unknown keys."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

from pedcross_env.camera_config import CAMERA_PRESETS, CameraConfig, camera_preset
from pedcross_env.contracts import MODALITIES, Modality
from pedcross_env.errors import ConfigError, require, unknown_name
from pedcross_env.sensors.dvs_config import DvsConfig, dvs_preset

__all__ = [
    "BehaviourConfig", "CAMERA_PRESETS", "CameraConfig", "DvsConfig", "EgoConfig", "EnvConfig", "LabelConfig",
    "RewardConfig", "RgbConfig", "TrafficConfig", "WindscreenConfig", "WorldConfig", "camera_preset",
    "from_mapping", "require",
]  # fmt: skip

T = TypeVar("T")


def _nested_dataclass(annotation: Any) -> type | None:
    candidates = typing.get_args(annotation) if isinstance(annotation, types.UnionType) else (annotation,)
    return next((c for c in candidates if dataclasses.is_dataclass(c) and isinstance(c, type)), None)


def from_mapping(cls: type[T], values: Mapping[str, Any]) -> T:
    """Build the config ``cls`` from a (nested) mapping.

    Args:
        cls: A dataclass of this package.
        values: Field names to values; nested dataclasses may be mappings; lists become tuples.

    Raises:
        ConfigError: For an unknown key (names the nearest one), or a value that ``cls`` refuses.
    """
    hints = typing.get_type_hints(cls)
    known = {f.name: hints[f.name] for f in dataclasses.fields(cls) if f.init}  # type: ignore[arg-type]
    arguments: dict[str, Any] = {}
    for key, value in values.items():
        if key not in known:
            raise unknown_name(f"key for {cls.__name__}", key, known)
        nested = _nested_dataclass(known[key])
        named = isinstance(value, str) or (isinstance(value, Mapping) and "preset" in value)
        if named and nested in (CameraConfig, DvsConfig):
            preset = camera_preset if nested is CameraConfig else dvs_preset
            value = _by_preset(preset, {"preset": value} if isinstance(value, str) else value)
        elif nested is not None and isinstance(value, Mapping):
            value = from_mapping(nested, value)
        arguments[key] = tuple(value) if isinstance(value, list) else value
    try:
        return cls(**arguments)
    except TypeError as error:
        raise ConfigError(f"{cls.__name__}: {error}") from error


def _by_preset(preset: Callable[..., Any], values: Mapping[str, Any]) -> Any:
    changes = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items() if k != "preset"}
    return preset(str(values["preset"]), **changes)


@dataclass(frozen=True, slots=True, kw_only=True)
class RgbConfig:
    """Exposure, noise and quantisation of the RGB camera.

    "White" is the luminance that just fills the 8-bit range. Down to ``base_white_cd_m2`` the shutter sets it;
    in darker scenes the shutter stays at its longest and amplification makes up for the missing light.
    """

    exposure: Literal["auto", "fixed"] = "auto"
    fixed_white_cd_m2: float = 0.0  # luminance of white if exposure is "fixed"
    adaptation_s: float = 0.25  # time constant of the automatic exposure
    full_well_e: float = 9000.0  # electrons at white at gain 1
    max_gain: float = 64.0  # strongest amplification
    base_white_cd_m2: float = 400.0  # luminance of white at the longest exposure and gain 1
    longest_exposure_s: float = 1 / 60
    read_noise_e: float = 3.0
    noise: bool = True
    bloom: float = 0.04  # share of what is beyond saturation that spills over its neighbours; 0: none
    motion_blur_samples: int = 1  # renders averaged over the exposure, each as dear as a frame; 1: no blur

    def __post_init__(self) -> None:
        if self.exposure not in ("auto", "fixed"):
            raise unknown_name("exposure", self.exposure, ("auto", "fixed"))
        require(self.adaptation_s >= 0, "adaptation_s", self.adaptation_s, "0 (follows at once) or more")
        require(self.full_well_e > 0, "full_well_e", self.full_well_e, "positive")
        require(self.max_gain >= 1, "max_gain", self.max_gain, "1 or more")
        require(self.base_white_cd_m2 > 0, "base_white_cd_m2", self.base_white_cd_m2, "positive")
        require(self.longest_exposure_s > 0, "longest_exposure_s", self.longest_exposure_s, "positive")
        require(0 <= self.bloom <= 1, "bloom", self.bloom, "0 to 1")
        samples = self.motion_blur_samples
        require(1 <= samples <= 64, "motion_blur_samples", samples, "1 (none) to 64")
        require(self.read_noise_e >= 0, "read_noise_e", self.read_noise_e, "0 or more")
        if self.exposure == "fixed":
            darkest = self.base_white_cd_m2 / self.max_gain
            require(self.fixed_white_cd_m2 >= darkest, "fixed_white_cd_m2", self.fixed_white_cd_m2,
                    f"base_white_cd_m2 / max_gain ({darkest:g}) or more")  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class EgoConfig:
    """The ego car's size, its actuators and its headlights.

    A demand takes effect after ``latency_s``; then the acceleration follows at ``jerk_mps3`` at most, and braking
    builds up at ``strongest_braking_mps2 / build_up_s`` at most. Braking ends at friction * g, at which ABS holds the
    wheels, and at standstill. With ``steering`` the action has a second number; else the ego keeps to its lane.
    Brakes and motor have the force for the strongest accelerations at ``mass_kg``; a load takes its share of them, but
    none of what the road bears, which grows with the weight.
    Ranges usual for emergency braking: latency 0.1 to 0.3 s, build-up 0.2 to 0.4 s, jerk 25 to 35 m/s3.
    """

    length_m: float = 4.5
    width_m: float = 1.8
    height_m: float = 1.5
    max_acceleration_mps2: float = 3.0  # at action +1
    max_deceleration_mps2: float = 9.0  # at action -1
    latency_s: float = 0.15
    jerk_mps3: float = 30.0
    build_up_s: float = 0.3  # from no braking to max_deceleration_mps2
    mass_kg: float = 1500.0  # in running order, the driver included
    load_kg: float = 0.0  # beyond that: passengers, luggage
    abs: bool = True  # without it wheels lock where more is demanded than the road bears
    locked_share: float = 0.75  # of the road's friction that locked wheels have
    steering: bool = False  # whether actions steer
    wheelbase_m: float = 2.7
    max_steer_rad: float = 0.6  # of the front wheels, at action +-1
    steer_rate_radps: float = 0.6
    steer_latency_s: float = 0.1
    headlights: Literal["auto", "low", "high"] = (
        "auto"  # low beams where the weather wants them, or always on
    )

    def __post_init__(self) -> None:
        if self.headlights not in ("auto", "low", "high"):
            raise unknown_name("headlights", self.headlights, ("auto", "low", "high"))
        for name in (
            "length_m",
            "width_m",
            "height_m",
            "max_acceleration_mps2",
            "max_deceleration_mps2",
            "jerk_mps3",
            "wheelbase_m",
            "steer_rate_radps",
            "mass_kg",
        ):
            require(0 < getattr(self, name) < math.inf, name, getattr(self, name), "positive and finite")
        for name in ("latency_s", "steer_latency_s", "build_up_s"):
            require(0 <= getattr(self, name) <= 2, name, getattr(self, name), "0 to 2")
        require(
            0 <= self.load_kg <= self.mass_kg,
            "load_kg",
            self.load_kg,
            f"0 to mass_kg ({self.mass_kg:g}), e.g. 300",
        )
        require(0 < self.locked_share <= 1, "locked_share", self.locked_share, "above 0, at most 1")
        require(0 < self.max_steer_rad <= 1.2, "max_steer_rad", self.max_steer_rad, "above 0, at most 1.2")
        require(
            self.wheelbase_m < self.length_m, "wheelbase_m", self.wheelbase_m,
            f"less than length_m ({self.length_m})",
        )  # fmt: skip

    @property
    def strongest_braking_mps2(self) -> float:
        """What the brakes can do with the load, on a road that bears it."""
        return self.max_deceleration_mps2 * self.mass_kg / (self.mass_kg + self.load_kg)

    @property
    def strongest_acceleration_mps2(self) -> float:
        """What the motor can do with the load."""
        return self.max_acceleration_mps2 * self.mass_kg / (self.mass_kg + self.load_kg)


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldConfig:
    """Clock rates."""

    policy_hz: int = 30
    tick_hz: int = 120

    def __post_init__(self) -> None:
        require(
            1 <= self.policy_hz <= 1000 and self.policy_hz % 1 == 0,
            "policy_hz", self.policy_hz, "a whole number from 1 to 1000, e.g. 30",
        )  # fmt: skip
        require(
            self.policy_hz <= self.tick_hz <= 10_000 and self.tick_hz % self.policy_hz == 0,
            "tick_hz", self.tick_hz,
            f"a multiple of policy_hz ({self.policy_hz}), at most 10000, e.g. {4 * self.policy_hz}",
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviourConfig:
    """How people cross, and what else there is that looks like a danger: shares of episodes, each drawn by itself.

    All that makes a crossing more than a walk straight over: who hesitates steps down, stops for up to 1.5 s and
    goes on; who stops midway stands on the carriageway for up to 2.5 s; who turns back comes at most to the middle
    of the ego's lane and misses an ego that holds its speed; who yields waits for a gap it accepts,
    at the kerb or, midway, at the edge of the ego's lane, so it reacts to the ego and is not timed to be hit. Groups
    have one to four people by ``group_sizes``; with ``both_sides`` one more comes from the other side.

    Hard negatives: a cyclist rides at the edge of either lane, some just beside the ego's path; a door of a parked
    car opens as the ego comes; with ``intersection`` a side street lies before the meeting point and oncoming cars
    turn across the ego's lane; with ``leader`` a car drives ahead of the ego, hides the meeting point and passes it
    before the others step out. With ``curve`` the street bends, unless it is crossed. What bystanders do, by weight:
    walk along the house fronts or along the kerb, walk up and stop, stand at the kerb, stand.
    """

    hesitates: float = 0.08
    stops_midway: float = 0.05
    turns_back: float = 0.05
    yields: float = 0.0
    yields_midway: float = 0.0
    group_sizes: tuple[float, float, float, float] = (0.7, 0.22, 0.05, 0.03)
    both_sides: float = 0.08
    cyclist: float = 0.25
    door: float = 0.1
    intersection: float = 0.0
    curve: float = 0.0
    leader: float = 0.0
    walking_along: float = 0.25
    along_kerb: float = 0.15
    walks_up: float = 0.25
    kerb_standing: float = 0.15
    standing: float = 0.2

    def __post_init__(self) -> None:
        weights = ("walking_along", "along_kerb", "walks_up", "kerb_standing", "standing")
        for item in dataclasses.fields(self):
            if item.name not in ("group_sizes", *weights):
                value = getattr(self, item.name)
                require(0 <= value <= 1, f"behaviour.{item.name}", value, "a share, 0 to 1")
        for names, values in ((("group_sizes",), self.group_sizes), (weights, self.bystanders)):
            require(
                all(0 <= w < math.inf for w in values) and 0 < sum(values) < math.inf,
                f"behaviour {', '.join(names)}", values, "weights, 0 or more, not all 0",
            )  # fmt: skip
        require(len(self.group_sizes) == 4, "behaviour.group_sizes", self.group_sizes, "four weights")
        ways = sum(self.ways)
        what = "behaviour hesitates + stops_midway + turns_back + yields + yields_midway"
        require(ways <= 1, what, ways, "at most 1")

    @property
    def ways(self) -> tuple[float, float, float, float, float]:
        """Shares of how people cross, in the order of the fields; the rest walks straight on."""
        return self.hesitates, self.stops_midway, self.turns_back, self.yields, self.yields_midway

    @property
    def bystanders(self) -> tuple[float, ...]:
        """Weights of what bystanders do, in the order of the fields."""
        return (self.walking_along, self.along_kerb, self.walks_up, self.kerb_standing, self.standing)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrafficConfig:
    """What random crossings are drawn from; see scenario.sampler for the distributions."""

    crossing_share: float = 0.5  # of episodes in which somebody crosses the ego's path
    duration_s: float = 10.0
    ego_speed_mps: tuple[float, float] = (5.6, 13.9)  # 20-50 km/h
    max_bystanders: int = 4
    max_oncoming: int = 2
    parked_share: float = 0.5  # of parking bays that are taken
    behaviour: BehaviourConfig = field(default_factory=BehaviourConfig)

    def __post_init__(self) -> None:
        require(0 <= self.crossing_share <= 1, "crossing_share", self.crossing_share, "0 to 1")
        require(1 <= self.duration_s <= 120, "duration_s", self.duration_s, "1 to 120")
        low, high = self.ego_speed_mps
        require(
            0 < low <= high <= 40,
            "ego_speed_mps",
            self.ego_speed_mps,
            "(low, high) with 0 < low <= high <= 40, e.g. (5.6, 13.9)",
        )
        require(0 <= self.max_bystanders <= 100, "max_bystanders", self.max_bystanders, "0 to 100")
        require(0 <= self.max_oncoming <= 20, "max_oncoming", self.max_oncoming, "0 to 20")
        require(0 <= self.parked_share <= 1, "parked_share", self.parked_share, "0 to 1")


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelConfig:
    """When a frame counts as positive, and when holding the speed counts as a conflict."""

    range_m: float = 40.0  # crossings farther ahead are not labelled: an adult there is 17 of 256 px tall
    conflict_horizon_s: float = 4.0
    conflict_margin_m: float = 0.3  # added around the ego

    def __post_init__(self) -> None:
        require(0 < self.range_m <= 1000, "range_m", self.range_m, "above 0, at most 1000")
        horizon_s = self.conflict_horizon_s
        require(0 < horizon_s <= 60, "conflict_horizon_s", horizon_s, "above 0, at most 60")
        require(0 <= self.conflict_margin_m <= 5, "conflict_margin_m", self.conflict_margin_m, "0 to 5")


@dataclass(frozen=True, slots=True, kw_only=True)
class RewardConfig:
    """Weights of the reward's terms, 0 or more; ``pedcross_env.reward.reward_terms`` says what each one weighs."""

    progress_per_m: float = 0.01
    passed: float = 0.0
    collision: float = 5.0
    collision_per_mps: float = 0.5
    off_road: float = 5.0
    discomfort_per_mps2: float = 0.002
    jerk_per_mps3: float = 0.0
    false_braking_per_mps2: float = 0.0
    proximity: float = 0.0
    proximity_s: float = 1.5  # times to contact below it count
    time_per_s: float = 0.0

    def __post_init__(self) -> None:
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            require(0 <= value < math.inf, f"reward.{item.name}", value, "finite, 0 or more")
        require(self.proximity_s > 0, "reward.proximity_s", self.proximity_s, "positive")


@dataclass(frozen=True, slots=True, kw_only=True)
class WindscreenConfig:
    """What rain leaves on the glass before the camera; both cameras see it. See weather.windscreen."""

    drops: bool = False  # drops that strike the glass, stick, run, and are wiped off
    wiper: Literal["auto", "off"] = (
        "auto"  # as fast as the rain asks for, or none: drops run off by themselves
    )

    def __post_init__(self) -> None:
        if self.wiper not in ("auto", "off"):
            raise unknown_name("wiper", self.wiper, ("auto", "off"))


@dataclass(frozen=True, slots=True, kw_only=True)
class EnvConfig:
    """All settings of the environment."""

    modalities: tuple[Modality, ...] = ("rgb", "dvs")
    # One is drawn per episode; names, or what else pedcross_env.weather.as_weather takes.
    weather: tuple[Any, ...] = ("clear",)
    return_events: bool = False
    actions: Literal["continuous", "discrete"] = "continuous"
    # Of discrete actions: shares of the strongest acceleration (below 0 of the strongest braking), and, where the
    # ego steers, of the largest steering angle; action = index of the first * number of the second + its index.
    demand_levels: tuple[float, ...] = (-1.0, -0.5, -0.2, 0.0, 0.5)
    steer_levels: tuple[float, ...] = (-0.2, 0.0, 0.2)
    label_events: bool = False  # add what made each event to info; costs about a full render per sub-frame
    camera: CameraConfig = field(default_factory=CameraConfig)
    rgb: RgbConfig = field(default_factory=RgbConfig)
    dvs: DvsConfig = field(default_factory=DvsConfig)
    windscreen: WindscreenConfig = field(default_factory=WindscreenConfig)
    ego: EgoConfig = field(default_factory=EgoConfig)
    world: WorldConfig = field(default_factory=WorldConfig)
    traffic: TrafficConfig = field(default_factory=TrafficConfig)
    label: LabelConfig = field(default_factory=LabelConfig)
    reward: RewardConfig = field(default_factory=RewardConfig)

    def __post_init__(self) -> None:
        for modality in self.modalities:
            if modality not in MODALITIES:
                raise unknown_name("modality", modality, MODALITIES)
        if self.actions not in ("continuous", "discrete"):
            raise unknown_name("actions", self.actions, ("continuous", "discrete"))
        for name in ("demand_levels", "steer_levels"):
            levels = getattr(self, name)
            require(
                len(levels) > 0 and all(-1 <= level <= 1 for level in levels),
                name, levels, "one number or more from -1 to 1",
            )  # fmt: skip
        require(
            len(set(self.modalities)) == len(self.modalities),
            "modalities",
            self.modalities,
            "without repeats",
        )
        require(not isinstance(self.weather, (str, Mapping)) and len(self.weather) > 0, "weather", self.weather,
                "a non-empty tuple of weathers, e.g. ('clear',)")  # fmt: skip
        require(not self.return_events or "dvs" in self.modalities, "return_events", self.return_events,
                "False unless modalities contain 'dvs'")  # fmt: skip
        require(not self.label_events or self.return_events, "label_events", self.label_events,
                "False unless return_events is True")  # fmt: skip
