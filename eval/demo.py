"""The whole way once, small: record, score, drive, report."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from eval.cameras import COMPACT_CAMERA
from eval.closed_loop import EvaluateConfig, check_weathers, evaluate
from eval.offline import BenchmarkConfig, benchmark
from eval.progress import bar
from eval.report import build_report
from eval.samples import capture_samples
from eval.store import prepare_folder
from pedcross_env.config import EnvConfig, require
from pedcross_env.recorder import GenerateConfig, generate

__all__ = ["DemoConfig", "capture_for", "run_demo"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DemoConfig:
    """Settings of ``pedcross demo``; a stopped demo goes on where it was."""

    out: Path = Path("out/demo")
    """Recorded videos go to out/data, results and report.html to out."""
    videos: int = 6
    """Recorded per subset, for the offline scores."""
    episodes: int = 8
    """Driven per weather and source."""
    hit_share: float = 0.75
    """Of the episodes are crossings that hit a car which never brakes, see ``EvaluateConfig``; nobody crosses in the
    others."""
    weathers: tuple[str, ...] = ("clear", "rain", "fog")
    detectors: tuple[str, ...] = ()
    """Names of shipped checkpoints or paths; empty: all shipped ones."""
    seed: int = 0
    """Of videos and episodes; the shipped networks were trained on others."""
    workers: int = 0
    """Processes; 0: one per core."""

    def __post_init__(self) -> None:
        require(self.videos >= 1, "videos", self.videos, "1 or more")
        require(self.episodes >= 1, "episodes", self.episodes, "1 or more")


def run_demo(config: DemoConfig, console: Console) -> Path:
    """Record, score, drive and report; returns the report's path.

    Raises:
        ConfigError: For unknown names or a folder that cannot be written.
        DataError: For damaged files of an earlier run.
    """
    from eval.detectors import resolve_detectors

    begin_s = time.perf_counter()
    # A wrong name should not cost minutes of recording first.
    check_weathers(config.weathers)
    resolve_detectors(config.detectors)
    prepare_folder(config.out)
    data = config.out / "data"
    record = GenerateConfig(
        out=data,
        videos=config.videos,
        seed=config.seed,
        workers=config.workers,
        camera=COMPACT_CAMERA,
    )
    with bar("recording videos ", console) as progress:
        generate(record, progress)
    with bar("scoring clips    ", console) as progress:
        benchmark(BenchmarkConfig(data=data, out=config.out, detectors=config.detectors), progress)
    drive = EvaluateConfig(
        out=config.out,
        detectors=config.detectors,
        weathers=config.weathers,
        episodes=config.episodes,
        hit_share=config.hit_share,
        seed=config.seed,
        workers=config.workers,
    )
    with bar("driving episodes ", console) as progress:
        evaluate(drive, progress)
    capture_for(drive)
    report = build_report(config.out)
    console.print(f"finished in {(time.perf_counter() - begin_s) / 60:.1f} min", highlight=False)
    return report


def capture_for(config: EvaluateConfig) -> None:
    """Write the report's sample frames of an evaluation, unless they are there."""
    folder = config.out / "samples"
    wanted = [folder / f"{weather}_{kind}.png" for weather in config.weathers for kind in ("rgb", "dvs")]
    if not all(path.exists() for path in wanted):
        # The full picture: the one that detectors drive with may be too small for the eye.
        scene = EnvConfig(traffic=config.traffic)
        capture_samples(folder, config.weathers, scene, seed=config.seed)
