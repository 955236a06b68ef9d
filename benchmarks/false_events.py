"""False events: how far the event camera's events are from those of the same renderer at 64 samples a pixel.

The ego drives at 10 m/s. At 1 kHz the picture is rendered (luminance only) at 450x256, and at 8x8 the pixels with the
mean over each 8x8 block: the reference. Both go through the event camera's ideal rule (threshold 0.2, no spread, no
noise, no refractory period). Per pixel and 5 ms bin, a and b are the sums of the events' signs:

    mismatch = sum |a - b| / sum |b|,    event ratio = all events of the picture / all of the reference.

Both are also given by what the pixel shows in the middle of the bin.

Run: python benchmarks/false_events.py [--seeds 5] [--seconds 0.1] [--weather clear] [--picture DIR]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scenes import reference_scene, reference_street

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig, DvsConfig
from pedcross_env.contracts import StaticClass
from pedcross_env.scenario.street import StreetSpec
from pedcross_env.sensors import dvs
from pedcross_env.weather import weather_by_name

SAMPLES = 8  # along each side of a pixel
STEP_S, BIN_STEPS = 0.001, 5
CLASSES = ("sky", "ground", "building", "vegetation", "furniture", "vehicle", "pedestrian")
EVENTS = DvsConfig(positive_threshold=0.2, negative_threshold=0.2, shot_hz=0.0)


@dataclass
class Tally:
    """Sums over pixels and bins, each (classes,): |a - b|, |b|, events of the picture and of the reference."""

    difference: np.ndarray = field(default_factory=lambda: np.zeros(len(CLASSES)))
    signed: np.ndarray = field(default_factory=lambda: np.zeros(len(CLASSES)))
    ours: np.ndarray = field(default_factory=lambda: np.zeros(len(CLASSES)))
    theirs: np.ndarray = field(default_factory=lambda: np.zeros(len(CLASSES)))

    def __iadd__(self, other: Tally) -> Tally:
        for name in ("difference", "signed", "ours", "theirs"):
            getattr(self, name).__iadd__(getattr(other, name))
        return self

    def line(self, name: str, part: slice | int = slice(None)) -> str:
        difference, signed, ours, theirs = (
            float(np.sum(values[part])) for values in (self.difference, self.signed, self.ours, self.theirs)
        )
        if theirs == 0:
            return f"{name:12s} no events in the reference, {ours:.0f} in the picture"
        share = 100 * difference / max(1.0, float(self.difference.sum()))
        return (
            f"{name:12s} mismatch {difference / max(1.0, signed):5.3f}  event ratio {ours / theirs:5.3f}  "
            f"events {theirs:8.0f}  share of all mismatch {share:3.0f} %"
        )


class Camera:
    """An event camera without noise on one renderer, whose counts are taken bin by bin."""

    def __init__(self, config: CameraConfig, samples: int, street: StreetSpec, weather: str) -> None:
        self._samples = samples
        self.renderer = Renderer(config)
        self.renderer.load(street, weather_by_name(weather))
        self._shape = (config.height_px // samples, config.width_px // samples)
        self._state: dvs.DvsState | None = None
        self.taken = np.zeros((*self._shape, 2), np.int32)

    def see(self, time_s: float, scene: object) -> None:
        luminance = self.renderer.render(scene, luminance_only=True).luminance  # type: ignore[arg-type]
        if self._samples > 1:
            h, w = self._shape
            blocks = luminance.reshape(h, self._samples, w, self._samples)
            luminance = blocks.mean(axis=(1, 3), dtype=np.float64).astype(np.float32)
        log_frame = dvs.log_luminance(luminance, EVENTS.log_floor_cd_m2)
        time_ns = round(time_s * 1e9)
        if self._state is None:
            self._state = dvs.initial_state(log_frame, time_ns, EVENTS, 0)
            return
        counts = np.zeros((*self._shape, 2), np.uint16)
        self._state = dvs.step_counts(self._state, log_frame, time_ns, EVENTS, counts)
        self.taken += counts

    def take(self) -> np.ndarray:
        taken, self.taken = self.taken, np.zeros_like(self.taken)
        return taken


def classes_of(instance: np.ndarray, pedestrians: np.ndarray) -> np.ndarray:
    """(H, W) index into CLASSES."""
    classes = np.where(instance > 0, CLASSES.index("vehicle"), -instance)
    classes[np.isin(instance, pedestrians)] = CLASSES.index("pedestrian")
    return classes


def drive(seed: int, seconds: float, weather: str, start_m: float, picture: Path | None) -> Tally:
    config = CameraConfig()
    fine = CameraConfig(width_px=SAMPLES * config.width_px, height_px=SAMPLES * config.height_px)
    street = reference_street(seed)
    plain, reference = Camera(config, 1, street, weather), Camera(fine, SAMPLES, street, weather)
    lights = float(weather_by_name(weather).headlights)
    tally, error = Tally(), np.zeros((config.height_px, config.width_px))
    steps = round(seconds / STEP_S)
    classes = np.zeros(error.shape, np.int64)
    for step in range(steps + 1):
        scene = reference_scene(step * STEP_S, lights=lights, seed=seed, start_m=start_m)
        for camera in (plain, reference):
            camera.see(step * STEP_S, scene)
        if step % BIN_STEPS == (BIN_STEPS + 1) // 2:
            people = scene.actors["id"][scene.actors["kind"] == 2]
            instance = plain.renderer.render(scene).instance
            assert instance is not None
            classes = classes_of(instance, people)
        if step and step % BIN_STEPS == 0:
            a, b = plain.take(), reference.take()
            signed = [c[..., 0].astype(np.int64) - c[..., 1] for c in (a, b)]
            difference = np.abs(signed[0] - signed[1])
            error += difference
            tally += Tally(*(
                np.bincount(classes.ravel(), weights=values.ravel(), minlength=len(CLASSES))
                for values in (difference, np.abs(signed[1]), a.sum(-1), b.sum(-1))
            ))  # fmt: skip
    if picture is not None:
        _show(picture / f"false_events_{weather}_{seed}.png", error, steps // BIN_STEPS)
    return tally


def _show(path: Path, error: np.ndarray, bins: int) -> None:
    import cv2

    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.clip(255 * error / (0.2 * bins), 0, 255).astype(np.uint8))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=0.1)
    parser.add_argument("--start-m", type=float, default=0.0)
    parser.add_argument("--weather", default="clear")
    parser.add_argument("--picture", type=Path, default=None, help="folder for maps of where the mismatch is")
    args = parser.parse_args()
    assert len(StaticClass) == 5
    total = Tally()
    begin = time.process_time()
    for seed in range(args.first_seed, args.first_seed + args.seeds):
        tally = drive(seed, args.seconds, args.weather, args.start_m, args.picture)
        print(tally.line(f"seed {seed}"), flush=True)
        total += tally
    for index, name in enumerate(CLASSES):
        print(total.line(name, index))
    print(total.line("all"))
    print(f"bar: mismatch <= .20, event ratio .97 to 1.05  ({time.process_time() - begin:.0f} s of CPU time)")


if __name__ == "__main__":
    main()
