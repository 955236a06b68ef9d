"""CPU milliseconds per 450 x 256 frame of the event camera, and of v2e on the same frames where it is installed.

    python benchmarks/dvs.py [--repeats 5]

A texture slides sideways by a pixel per frame, 3 1/3 ms apart ("full motion"), or stands still. Three ways are timed:
``step_counts`` counts the events per pixel and polarity, as the environment does unless raw events are asked for;
``step(..., ordered=False)`` makes them in any order; ``step`` makes them sorted by time. The bar is met where one that
makes events meets it; which one does is told. Least of several passes of the process's CPU time, what the system
spends on fresh memory included; one thread.

v2e (github.com/SensorsINI/v2e) is used if ``import v2ecore`` works: install it and its dependencies beside this
package. It gets the same frames as 8-bit grey, on one thread of the CPU, and makes its (N, 4) float32 events.
"""

from __future__ import annotations

import argparse
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from machine import cpu_name, cpu_s

from pedcross_env.sensors import DvsConfig, dvs_preset, initial_state, log_luminance, step, step_counts
from pedcross_env.sensors.dvs import DvsState

SHAPE = (256, 450)
FRAMES = 60
STEP_NS = 3_333_333


@dataclass(frozen=True)
class Case:
    """One row of the table."""

    scene: str
    camera: str
    bar_ms: float


CASES = [
    Case("full motion", "clean", 0.9), Case("full motion", "C = .05", 2.0), Case("full motion", "noisy", 1.5),
    Case("static", "clean", 0.25), Case("static", "noisy", 1.5),
    Case("full motion", "davis346", np.nan), Case("full motion", "gen4", np.nan),
]  # fmt: skip
CAMERAS = {
    "clean": dvs_preset("default", shot_hz=0.0),
    "C = .05": DvsConfig(positive_threshold=0.05, negative_threshold=0.05, shot_hz=0.0),
    "noisy": dvs_preset("noisy", positive_threshold=0.3, negative_threshold=0.3),
    "davis346": dvs_preset("davis346", bus_events_per_s=None),
    "gen4": dvs_preset("gen4", bus_events_per_s=None),
}


def moving_scene(shift_px_per_frame: float) -> list[np.ndarray]:
    """Smooth texture of three octaves in ln(light), -2 to 2, sliding sideways."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.float64)
    rng = np.random.default_rng(0)
    waves = [(rng.normal(0, f), rng.normal(0, f), rng.uniform(0, 6.3)) for f in np.geomspace(0.02, 0.5, 24)]
    frames = []
    for k in range(FRAMES):
        total = sum(np.sin(a * (x + k * shift_px_per_frame) + b * y + c) for a, b, c in waves)
        frames.append((0.3 * np.asarray(total)).astype(np.float32))
    return frames


def milliseconds(play: Callable[[], Iterator[None]], repeats: int) -> float:
    """Least CPU time per frame; the first frame, which only starts the camera, is not counted."""
    best = np.inf
    for _ in range(repeats):
        run = play()
        next(run)
        start = cpu_s()
        frames = sum(1 for _ in run)
        best = min(best, (cpu_s() - start) / frames)
    return 1e3 * float(best)


def ours(
    frames: list[np.ndarray], config: DvsConfig, found: list[int] | None, *, ordered: bool = True
) -> Iterator[None]:
    """Play the frames; with ``found``, make events and note their number, else count them."""
    counts = np.zeros((*SHAPE, 2), np.uint8)
    state: DvsState = initial_state(frames[0], 0, config, seed=1)
    yield
    for k, frame in enumerate(frames[1:], 1):
        if found is None:
            state = step_counts(state, frame, k * STEP_NS, config, counts)
        else:
            state, events = step(state, frame, k * STEP_NS, config, ordered=ordered)
            found.append(events.size)
        yield


def theirs(frames: list[np.ndarray], config: DvsConfig) -> Iterator[None]:
    """Play the frames, as 8-bit grey of the same contrasts, to v2e."""
    from v2ecore.emulator import EventEmulator  # type: ignore[import-not-found,unused-ignore]

    emulator = EventEmulator(
        pos_thres=config.positive_threshold, neg_thres=config.negative_threshold, sigma_thres=config.sigma_threshold,
        cutoff_hz=config.cutoff_hz, leak_rate_hz=config.leak_hz, shot_noise_rate_hz=config.shot_hz,
        refractory_period_s=config.refractory_ns * 1e-9, seed=1, device="cpu", output_width=SHAPE[1],
        output_height=SHAPE[0],
    )  # fmt: skip
    grey = [np.clip(np.rint(np.exp(frame + 3.4)), 0, 255).astype(np.float32) for frame in frames]
    emulator.generate_events(grey[0], 0.0)
    yield
    for k, frame in enumerate(grey[1:], 1):
        emulator.generate_events(frame, k * STEP_NS * 1e-9)
        yield


def verdict(unordered_ms: float, ordered_ms: float, bar_ms: float) -> str:
    """Which way of making events meets the bar."""
    if ordered_ms <= bar_ms:
        return "reached in order"
    return "reached in any order" if unordered_ms <= bar_ms else "MISSED"


def v2e_is_here() -> bool:
    try:
        import torch
        import v2ecore.emulator  # type: ignore[import-not-found,unused-ignore]  # noqa: F401
    except ImportError as error:
        print(f"v2e is not installed ({error}); our figures alone.")
        return False
    torch.set_num_threads(1)
    logging.disable(logging.WARNING)
    return True


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=5, help="passes over 60 frames; the least counts")
    repeats = parser.parse_args().repeats
    print(f"CPU: {cpu_name()}; {SHAPE[1]}x{SHAPE[0]}, CPU ms per frame")
    with_v2e = v2e_is_here()
    scenes = {"full motion": moving_scene(1.0), "static": [moving_scene(0.0)[0]] * FRAMES}
    titles = ("events", "counts", "any order", "step", "bar", "v2e", "v2e/step")
    print(
        f"{'scene':12s} {'camera':9s}" + "".join(f"{title:>10s}" for title in titles[: 7 if with_v2e else 5])
    )
    for case in CASES:
        frames, config = scenes[case.scene], CAMERAS[case.camera]
        found: list[int] = []
        counting = milliseconds(lambda f=frames, c=config: ours(f, c, None), repeats)
        unordered = milliseconds(lambda f=frames, c=config: ours(f, c, [], ordered=False), repeats)
        stepping = milliseconds(lambda f=frames, c=config, n=found: ours(f, c, n), repeats)
        row = f"{case.scene:12s} {case.camera:9s}{np.mean(found):10.0f}"
        row += "".join(f"{ms:10.2f}" for ms in (counting, unordered, stepping, case.bar_ms))
        if with_v2e:
            v2e = milliseconds(lambda f=frames, c=config: theirs(f, c), 2)
            row += f"{v2e:10.1f}{v2e / stepping:10.1f}"
        print(row + ("" if np.isnan(case.bar_ms) else f"  {verdict(unordered, stepping, case.bar_ms)}"))
    luminance = np.exp(scenes["full motion"][0])
    best = np.inf
    for _ in range(200):
        start = cpu_s()
        log_luminance(luminance, 0.01)
        best = min(best, cpu_s() - start)
    print(f"ln(luminance), once per frame before: {1e3 * best:.2f} ms")


if __name__ == "__main__":
    main()
