"""User-CPU milliseconds per frame of the event camera at 450 x 256."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from pedcross_env.sensors.dvs import DvsState, initial_state, log_luminance, step, step_counts
from pedcross_env.sensors.dvs_config import DvsConfig

SHAPE = (256, 450)
FRAMES = 60
STEP_NS = 3_333_333


def moving_scene(shift_px_per_frame: float) -> list[np.ndarray]:
    """Smooth log-luminance texture of three octaves, sliding sideways."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.float64)
    rng = np.random.default_rng(0)
    waves = [(rng.normal(0, f), rng.normal(0, f), rng.uniform(0, 6.3)) for f in np.geomspace(0.02, 0.5, 24)]
    frames = []
    for k in range(FRAMES):
        total = sum(np.sin(a * (x + k * shift_px_per_frame) + b * y + c) for a, b, c in waves)
        frames.append((0.3 * np.asarray(total)).astype(np.float32))
    return frames


def milliseconds(
    run: Callable[[DvsState, np.ndarray, int], DvsState], frames: list[np.ndarray], config: DvsConfig
) -> float:
    best = np.inf
    for _ in range(5):
        state = initial_state(frames[0], 0, config, seed=1)
        start = time.process_time()
        for k, frame in enumerate(frames[1:], 1):
            state = run(state, frame, k * STEP_NS)
        best = min(best, (time.process_time() - start) / (len(frames) - 1))
    return 1e3 * float(best)


def main() -> None:
    scenes = {"full motion": moving_scene(1.0), "static": [moving_scene(0.0)[0]] * FRAMES}
    configs = {
        "clean": DvsConfig(shot_hz=0.0),
        "C = .05": DvsConfig(positive_threshold=0.05, negative_threshold=0.05, shot_hz=0.0),
        "noisy": DvsConfig(sigma_threshold=0.03, shot_hz=10.0, leak_hz=0.1, cutoff_hz=30.0),
    }
    for scene, frames in scenes.items():
        for label, config in configs.items():
            totals: list[int] = []
            counts = np.zeros((*SHAPE, 2), np.uint8)

            def events(state: DvsState, frame: np.ndarray, t: int, config: DvsConfig = config) -> DvsState:
                state, found = step(state, frame, t, config)
                totals.append(found.size)  # noqa: B023
                return state

            def only_counts(
                state: DvsState, frame: np.ndarray, t: int, config: DvsConfig = config
            ) -> DvsState:
                return step_counts(state, frame, t, config, counts)  # noqa: B023

            ms = milliseconds(events, frames, config), milliseconds(only_counts, frames, config)
            times = f"step {ms[0]:.2f} ms  step_counts {ms[1]:.2f} ms"
            print(f"{scene:12s} {label:8s} {times}  {np.mean(totals):.0f} events")
    luminance = np.exp(scenes["full motion"][0])
    log_luminance(luminance, 0.01)
    start = time.process_time()
    for _ in range(200):
        log_luminance(luminance, 0.01)
    print(f"log_luminance {(time.process_time() - start) / 200 * 1e3:.2f} ms")


if __name__ == "__main__":
    main()
