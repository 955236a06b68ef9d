"""Policy steps of the environment per CPU-second, one process, after warm-up, at 450x256.

    python benchmarks/environment.py [--steps 150]

Real time is 30 steps per second. The first rows have bars; "instants" are those of a step at which what is nearest is
rendered for the events, with the image motion between two of them that was reached ("px", the largest). The last
columns tell where a step's CPU time goes: renders for events, the RGB render, and all else (world, event camera, RGB
sensor, precipitation, Python).
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from machine import cpu_name

from pedcross_env.env import CrossingEnv
from pedcross_env.weather import Weather

HEAVY_RAIN = Weather(name="heavy rain", rain_mm_h=50.0, wetness=1.0, water_film_mm=1.0, cloudiness=1.0)


@dataclass(frozen=True)
class Case:
    """One row of the table."""

    name: str
    settings: dict[str, Any] = field(default_factory=dict)
    bar: float | None = None  # times real time


CASES = [
    Case("clear, at most 10 renders", bar=1.4),
    Case("clear, 10 m/s, never above 1 px",
         {"traffic": {"ego_speed_mps": (10.0, 10.0)}, "dvs": {"max_subframes": None}}, 0.6),
    Case("50 mm/h, at most 10 renders", {"weather": (HEAVY_RAIN,)}, 0.5),
    Case("no camera", {"modalities": ()}),
    Case("rgb alone", {"modalities": ("rgb",)}),
    Case("dvs alone", {"modalities": ("dvs",)}),
    Case("clear, raw events", {"return_events": True}),
    Case("clear, labelled events", {"return_events": True, "label_events": True}),
    Case("clear, davis346", {"dvs": "davis346"}),
    Case("fog", {"weather": ("fog",)}),
    Case("rain", {"weather": ("rain",)}),
    Case("night", {"weather": ("night",)}),
]  # fmt: skip


@dataclass
class Spent:
    """CPU seconds and numbers, summed over steps."""

    steps: int = 0
    all_s: float = 0.0
    events_s: float = 0.0
    rgb_s: float = 0.0
    instants: int = 0
    most_px: float = 0.0


def watch_renders(env: CrossingEnv, spent: Spent) -> None:
    """Note how long the environment's renders take."""
    if env._vision is None:
        return
    renderer = env._vision._renderer
    render, layers = renderer.render, renderer.layers

    def timed(snapshot: Any, *, luminance_only: bool = False, flash_lx: float = 0.0) -> Any:
        start = time.process_time()
        frame = render(snapshot, luminance_only=luminance_only, flash_lx=flash_lx)
        name = "events_s" if luminance_only else "rgb_s"
        setattr(spent, name, getattr(spent, name) + time.process_time() - start)
        return frame

    def timed_layers(*arguments: Any, **options: Any) -> Any:
        start = time.process_time()
        seen = layers(*arguments, **options)
        spent.events_s += time.process_time() - start
        return seen

    renderer.render, renderer.layers = timed, timed_layers  # type: ignore[method-assign]


def drive(case: Case, steps: int) -> Spent:
    env, hold, spent = CrossingEnv(case.settings), np.zeros(1, np.float32), Spent()
    env.reset(seed=0)
    for _ in range(5):
        env.step(hold)
    watch_renders(env, spent)
    seed = 0
    while spent.steps < steps:
        seed += 1
        before = spent.events_s, spent.rgb_s
        env.reset(seed=seed)
        spent.events_s, spent.rgb_s = before
        begin, over = time.process_time(), False
        while not over and spent.steps < steps:
            *_, terminated, truncated, info = env.step(hold)
            over = terminated or truncated
            spent.steps += 1
            spent.instants += info["subframes"]
            spent.most_px = max(spent.most_px, info["flow_px"])
        spent.all_s += time.process_time() - begin
    return spent


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--steps", type=int, default=150, help="policy steps per row")
    parser.add_argument("--bars", action="store_true", help="only the rows that have a bar")
    arguments = parser.parse_args()
    print(f"CPU: {cpu_name()}; 450x256, {arguments.steps} steps each; CPU ms per step at the right")
    titles = ("real time", "bar", "instants", "px", "step", "for events", "rgb", "else")
    print(f"{'':32s}" + "".join(f"{title:>11s}" for title in titles))
    for case in CASES:
        if arguments.bars and case.bar is None:
            continue
        spent = drive(case, arguments.steps)
        ms = [1e3 * t / spent.steps for t in (spent.all_s, spent.events_s, spent.rgb_s)]
        bar = "" if case.bar is None else f"{case.bar:.1f}"
        numbers = (
            1e3 / 30 / ms[0],
            bar,
            spent.instants / spent.steps,
            spent.most_px,
            *ms,
            ms[0] - ms[1] - ms[2],
        )
        cells = (f"{n:>11s}" if isinstance(n, str) else f"{n:11.2f}" for n in numbers)
        print(f"{case.name:32s}" + "".join(cells))


if __name__ == "__main__":
    main()
