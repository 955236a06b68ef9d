"""The scenes that the camera's benchmarks look at: one of known content, and what the sampler makes."""

from __future__ import annotations

import math

import numpy as np

from pedcross_env.config import EgoConfig, LabelConfig, TrafficConfig, WorldConfig
from pedcross_env.contracts import ACTOR_DTYPE, ActorKind, Snapshot
from pedcross_env.scenario.sampler import sample_crossing
from pedcross_env.scenario.street import Crosswalk, StreetSpec
from pedcross_env.world import World

__all__ = ["car", "generated_drive", "reference_scene", "reference_street", "walker"]

EGO_MPS = 10.0
STRIDE_M = 1.4


def reference_street(seed: int = 3) -> StreetSpec:
    """A street with one crosswalk; what stands beside it follows from the seed."""
    return StreetSpec(crosswalks=(Crosswalk(x_m=22.0),), seed=seed)


def _actor(**values: float) -> np.ndarray:
    record = np.zeros((), ACTOR_DTYPE)
    for name, value in values.items():
        record[name] = value
    return record


def car(ident: int, x: float, y: float, lights: float, **values: float) -> np.ndarray:
    size = {"length": 4.5, "width": 1.8, "height": 1.5}
    return _actor(
        id=ident, kind=ActorKind.VEHICLE, x=x, y=y, headlight=lights, **{"seed": ident, **size, **values}
    )


def walker(ident: int, x: float, y: float, time_s: float, speed_mps: float, **values: float) -> np.ndarray:
    return _actor(
        id=ident, kind=ActorKind.PEDESTRIAN, x=x, y=y + speed_mps * time_s, length=0.5, width=0.5,
        yaw=math.copysign(math.pi / 2, speed_mps), speed=abs(speed_mps), gait_stride=STRIDE_M,
        gait_phase=0.1 * ident + abs(speed_mps) * time_s / STRIDE_M, **values,
    )  # fmt: skip


def reference_scene(time_s: float, *, lights: float = 0.0, seed: int = 0, start_m: float = 0.0) -> Snapshot:
    """Four cars (two parked, one ahead, one oncoming) and two pedestrians who cross, as in the comparison of renderers.

    Args:
        time_s: Of the moment; the ego drives at 10 m/s, the car ahead at 8, the oncoming one at 9.
        lights: 1 with low beams on.
        seed: Of paints and clothes.
        start_m: Where the ego is at time 0.
    """
    k = 100 * seed
    others = [
        car(10, 16.0, -4.6, 0.0, seed=k + 10),
        car(11, 24.0, 4.6, 0.0, seed=k + 11, yaw=math.pi, model=1),
        car(12, 48.0 - 9.0 * time_s, 1.75, lights, seed=k + 12, yaw=math.pi, model=2, speed=9.0),
        car(13, 60.0 + 8.0 * time_s, -1.75, lights, seed=k + 13, model=1, speed=8.0),
        walker(20, 22.0, -2.5, time_s, 1.4, height=1.75, seed=k + 1),
        walker(21, 21.0, 3.0, time_s, -1.2, height=1.3, seed=k + 2, model=1),
    ]
    ego = car(1, start_m + EGO_MPS * time_s, -1.75, lights, speed=EGO_MPS)
    return Snapshot(time_s, ego, np.array(others, ACTOR_DTYPE))


def generated_drive(seed: int, frames: int, *, headlights: bool = False) -> tuple[StreetSpec, list[Snapshot]]:
    """Play an episode of the sampler without braking: its street and the snapshots of its policy steps."""
    ego = EgoConfig()
    scenario = sample_crossing(seed, TrafficConfig(), ego)
    world = World(
        scenario, ego=ego, world=WorldConfig(), label=LabelConfig(), friction=0.85, headlights=headlights
    )
    moments = []
    while len(moments) < frames and world.outcome == "running":
        moments.append(world.snapshot(world.time_s))
        world.step(0.0)
    return scenario.street, moments
