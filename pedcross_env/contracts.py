"""What the rooms agree on: records, keys and closed sets. No behaviour beyond them.

Axes: x forward along the street, y to the left, z up (ISO 8855), metres, radians; yaw turns from x to y.
Images are (H, W[, C]), row 0 on top; clips are (T, H, W, C) per clip and (T, N, C, H, W) inside networks.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import Any, Literal, get_args

import numpy as np

__all__ = [
    "ACTOR_DTYPE", "EVENT_DTYPE", "INFO_KEYS", "ActorKind", "EventCause", "Frame", "Modality", "MODALITIES", "Outcome",
    "Snapshot", "StaticClass",
]  # fmt: skip

Modality = Literal["rgb", "dvs"]
MODALITIES: tuple[Modality, ...] = get_args(Modality)

EVENT_DTYPE = np.dtype([("x", "<u2"), ("y", "<u2"), ("t", "<i8"), ("pol", "?")])
"""One event: column, row, time in nanoseconds, True for ON (CARLA's 13-byte record)."""


class ActorKind(IntEnum):
    """What an actor is."""

    VEHICLE = 1
    PEDESTRIAN = 2


class StaticClass(IntEnum):
    """Values of the instance image where no actor is seen; actors have their positive id."""

    SKY = 0
    GROUND = -1
    BUILDING = -2
    VEGETATION = -3
    FURNITURE = -4


class EventCause(IntEnum):
    """What made an event, where it is not an actor (its positive id) or a StaticClass; -200 and below is noise."""

    SIGNAL = -100  # a change of light that nobody traced
    PRECIPITATION = -101  # a drop's streak or a flake
    LIGHTNING = -102
    LEAK = -200  # of the pixel's reference
    SHOT_NOISE = -201
    HOT_PIXEL = -202


ACTOR_DTYPE = np.dtype(
    [
        ("id", "<i4"),  # positive, unique in the episode; the ego is 1
        ("kind", "<i4"),  # ActorKind
        ("model", "<i4"),  # index into VEHICLE_MODELS or PEDESTRIAN_MODELS of pedcross_env.scenario
        ("seed", "<i8"),  # appearance: colours, clothing
        ("x", "<f8"),
        ("y", "<f8"),
        ("z", "<f8"),  # of the ground under it
        ("yaw", "<f8"),
        ("pitch", "<f8"),  # nose down positive
        ("speed", "<f8"),  # m/s along yaw
        ("length", "<f8"),
        ("width", "<f8"),
        ("height", "<f8"),
        ("gait_phase", "<f8"),  # walking cycles (two steps) since the start, continuous
        ("gait_stride", "<f8"),  # length of one cycle, m; 0 = standing
        ("head_yaw", "<f8"),  # relative to the body
        ("brake_light", "<f8"),  # 0..1
        ("accessory", "<i4"),  # index into ACCESSORIES of pedcross_env.scenario; 0: what the seed gives
        ("headlight", "<f8"),  # 0 off, 1 low beam, 2 (of the ego) high beam
    ]
)
"""One actor at one moment. (x, y) is the centre of its footprint."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything that moves, at one time.

    Attributes:
        time_s: Time since reset.
        ego: One ACTOR_DTYPE record (a 0-d structured array).
        actors: (N,) ACTOR_DTYPE, the others, always in the same order within an episode.
    """

    time_s: float
    ego: np.ndarray
    actors: np.ndarray


@dataclass(slots=True)
class Frame:
    """What a camera without a sensor would see.

    Attributes:
        luminance: (H, W) float32, cd/m2.
        radiance: (3, H, W) float32 linear RGB planes (Rec. 709 primaries) in cd/m2, or None if only
            luminance was asked for; luminance = 0.2126 R + 0.7152 G + 0.0722 B.
        depth: (H, W) float32, metres along the optical axis, inf for sky; None for luminance only.
        instance: (H, W) int32, actor id or StaticClass; None for luminance only.
        airlight: Luminance of the fog and of the horizon sky, cd/m2 (what rain streaks scatter).
    """

    luminance: np.ndarray
    radiance: np.ndarray | None
    depth: np.ndarray | None
    instance: np.ndarray | None
    airlight: float


class Outcome(StrEnum):
    """How an episode stands or ended; a closed set."""

    RUNNING = "running"
    COLLISION = "collision"
    PASSED = "passed"  # the ego drove through without contact
    TIMEOUT = "timeout"  # the clock ran out without contact (the ego stands or creeps)
    OFF_ROAD = "off_road"  # an ego that steers left the carriageway


INFO_KEYS: dict[str, type] = {
    "time_s": float,
    "episode_seed": int,
    "scenario": str,
    "weather": str,
    "crossing": int,  # the frame's label, 0 or 1
    "crossing_in_s": float,  # until a pedestrian steps onto the carriageway; 0 while crossing; inf: never
    "visible_fraction": float,  # of the nearest crossing pedestrian, from instance ids; -1: none or not rendered
    "conflict": bool,  # holding its speed, the ego would touch a pedestrian within the conflict horizon
    "ttc_s": float,  # time to that contact; inf without one
    "drac_mps2": float,  # constant deceleration that would just avoid it; 0 without one
    "pet_s": float,  # smallest post-encroachment time so far; inf: nobody's way was crossed yet
    "distance_m": float,  # from the ego's front to the nearest crossing pedestrian ahead; inf: none
    "speed_mps": float,
    "acceleration_mps2": float,
    "demand_mps2": float,  # what the action asked for
    "position_m": float,  # of the ego's front along its way
    "impact_speed_mps": float,  # -1 without collision
    "collided_with": int,  # actor id, 0: none
    "outcome": str,  # Outcome
    "subframes": int,  # instants of this step at which luminance was rendered for the events
    "renders": int,  # luminance renders for them: of the scene, or of its layers, of which far ones need fewer
    "flow_px": float,  # bound on image motion between two of them; -1 without dvs
    "streak": float,  # bound on a raindrop's fall between two of them, in its diameters; -1 without dvs
}
"""Keys and types of every step's info. ``events`` (EVENT_DTYPE) and ``event_causes`` ((N,) int32: an actor's id, a
StaticClass or an EventCause for each) are added where asked for.

No value is nan, which equals nothing, not even itself: infos of twin episodes compare equal.
"""


def check_info(info: dict[str, Any]) -> None:
    """Raise ValueError where ``info`` lacks a key or holds another type than INFO_KEYS says."""
    for key, kind in INFO_KEYS.items():
        if key not in info:
            raise ValueError(f"info lacks {key!r}; required: {', '.join(INFO_KEYS)}")
        if not isinstance(info[key], kind):
            raise ValueError(f"info[{key!r}] is {info[key]!r}, expected {kind.__name__}")
