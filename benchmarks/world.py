"""Policy steps per CPU-second of the world without cameras, beside highway-env's own environments, in one run.

    python benchmarks/world.py [--seconds 3] [--repeats 3]

Ours is stepped through ``CrossingEnv`` with no camera: 30 Hz, 120 Hz ticks, 5 vehicles and 5 pedestrians that all
move, contact and facts of every step included. highway-env's run as they are made by default. All are played without
rendering, episodes one after the other with their resets counted, in alternation; the best of the repeats counts.
"""

import argparse
import math
import time
import warnings
from collections.abc import Callable

import gymnasium
import highway_env  # noqa: F401 - registers its environments
import numpy as np
from machine import cpu_name

from pedcross_env.env import CrossingEnv
from pedcross_env.scenario import Leg, PedestrianSpec, Scenario, StreetSpec, VehicleSpec

BAR = 1500.0


def busy_street(vehicles: int = 5, pedestrians: int = 5) -> Scenario:
    """A street on which everybody moves for 20 s and nobody is hit."""
    street = StreetSpec()
    lane = street.ego_lane_y_m
    with_us = [VehicleSpec(x_m=30.0 + 30 * k, y_m=lane, speed_mps=9.0) for k in range((vehicles + 1) // 2)]
    oncoming = [
        VehicleSpec(x_m=60.0 + 35 * k, y_m=-lane, yaw_rad=math.pi, speed_mps=9.0)
        for k in range(vehicles // 2)
    ]
    people = []
    for k in range(pedestrians):
        y = (-1) ** k * (street.kerb_y_m + 1.0)
        leg = Leg(to_x_m=50.0 + 10 * k, to_y_m=y, speed_mps=1.4)
        people.append(PedestrianSpec(behaviour="walking_along", x_m=15.0 + 10 * k, y_m=y, legs=(leg,)))
    return Scenario(
        name="busy", street=street, ego_speed_mps=8.0, duration_s=20.0, finish_x_m=300.0,
        vehicles=(*with_us, *oncoming), pedestrians=tuple(people),
    )  # fmt: skip


def ours(scenario: Scenario) -> tuple[Callable[[float], float], int]:
    env, action = CrossingEnv({"modalities": ()}), np.zeros(1, np.float32)
    ticks = env.config.world.tick_hz // env.config.world.policy_hz
    return lambda seconds: rate(env, action, seconds, options={"scenario": scenario}), ticks


def theirs(name: str) -> tuple[Callable[[float], float], int]:
    env = gymnasium.make(name).unwrapped
    space, action = env.action_space, None
    if isinstance(space, gymnasium.spaces.Discrete):
        action = next(k for k, v in env.action_type.actions.items() if v == "IDLE")  # type: ignore[attr-defined]
    else:
        action = np.zeros(space.shape, np.float32)
    env.reset(seed=0)
    settings = env.unwrapped.config  # type: ignore[attr-defined]
    print(
        f"{name}: {settings['policy_frequency']} Hz policy, {settings['simulation_frequency']} Hz simulation, "
        f"{len(env.road.vehicles)} vehicles"
    )  # type: ignore[attr-defined]
    ticks = settings["simulation_frequency"] // settings["policy_frequency"]
    return lambda seconds: rate(env, action, seconds), ticks


def rate(env: gymnasium.Env, action: object, seconds: float, **reset: object) -> float:
    steps, seed, begin = 0, 0, time.process_time()
    while time.process_time() - begin < seconds:
        env.reset(seed=seed, **reset)  # type: ignore[arg-type]
        seed, over = seed + 1, False
        while not over:
            *_, terminated, truncated, _ = env.step(action)
            steps, over = steps + 1, terminated or truncated
    return steps / (time.process_time() - begin)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    cases = {
        "pedcross, 5 vehicles + 5 pedestrians": ours(busy_street()),
        "pedcross, nobody else": ours(busy_street(0, 0)),
        "highway-fast-v0": theirs("highway-fast-v0"),
        "intersection-v1": theirs("intersection-v1"),
    }
    best = dict.fromkeys(cases, 0.0)
    for _ in range(arguments.repeats):
        for name, (run, _) in cases.items():
            best[name] = max(best[name], run(arguments.seconds))
    mine = best["pedcross, 5 vehicles + 5 pedestrians"]
    print(f"CPU: {cpu_name()}; one process, policy steps per CPU-second (bar for the first: {BAR:.0f})")
    for name, found in best.items():
        ticks = cases[name][1]
        by_tick = mine * cases["pedcross, 5 vehicles + 5 pedestrians"][1] / (found * ticks)
        print(f"{name:38s} {found:8.0f} of {ticks:2d} ticks; pedcross with 5 + 5 is {mine / found:6.1f} x as fast by "
              f"steps, {by_tick:6.1f} x by ticks")  # fmt: skip


if __name__ == "__main__":
    main()
