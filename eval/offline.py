"""Scores on recorded clips: one tidy row per clip, one table row per detector and subset."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from eval import metrics
from eval.detectors import DetectorSpec, load_detector, resolve_detectors
from eval.provenance import provenance
from eval.statistics import clustered_bootstrap
from eval.store import prepare_folder, write_json, write_rows
from eval.strata import strata
from pedcross_env.config import require
from pedcross_env.errors import ConfigError, DataError, unknown_name

__all__ = ["BenchmarkConfig", "BenchmarkReport", "benchmark", "score_table"]

Loader = Callable[[str], Any]
Progress = Callable[[int, int, str], None]
BATCH = 16
EXAMPLE_CLIPS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchmarkConfig:
    """Settings of ``pedcross benchmark``: score detectors on recorded videos."""

    data: Path
    """Root of a dataset: <subset>_<modality>/<video>/<frame>-<label>.<jpg|png>."""
    out: Path
    """Results folder."""
    detectors: tuple[str, ...] = ()
    """Names of shipped checkpoints or paths; empty: all shipped ones."""
    subsets: tuple[str, ...] = ()
    """Empty: all that the root has for a detector's modality."""
    split: Literal["all", "test"] = "all"
    """test: only the videos that a checkpoint's own training kept apart (same root as the training)."""
    stride: int = 3
    """Frames between the starts of two clips; 1 as in the paper's training, T for clips without overlap."""
    on_error: Literal["raise", "skip"] = "raise"
    """What to do with a damaged image: stop, or leave out the clips that hold it and count them."""
    resamples: int = 1000
    """Draws of the bootstrap over videos."""
    seed: int = 0
    """Of the bootstrap."""

    def __post_init__(self) -> None:
        require(self.stride >= 1, "stride", self.stride, "1 or more")
        require(self.resamples >= 1, "resamples", self.resamples, "1 or more")
        if self.split not in ("all", "test"):
            raise unknown_name("split", self.split, ("all", "test"))
        if self.on_error not in ("raise", "skip"):
            raise unknown_name("on_error", self.on_error, ("raise", "skip"))


@dataclass(frozen=True, slots=True)
class BenchmarkReport:
    """What a call of ``benchmark`` found.

    Attributes:
        clips: One row per clip: detector, subset, modality, video, start_frame, frames, label, p.
        table: One row per detector and subset, see ``score_table``.
        strata: AUROC by speed and distance, see ``eval.strata``; empty for data without a manifest.
    """

    clips: list[dict[str, Any]]
    table: list[dict[str, Any]]
    strata: list[dict[str, Any]]


@dataclass(slots=True)
class _Tally:
    """What of a subset could not be used, and one clip of each video to measure spikes on."""

    damaged_images: int = 0
    short_videos: int = 0
    lost_clips: int = 0
    first_error: str = ""
    example_clips: list[np.ndarray] = field(default_factory=list)

    def counts(self) -> dict[str, Any]:
        """Everything but the clips."""
        return {
            "damaged_images": self.damaged_images,
            "short_videos": self.short_videos,
            "lost_clips": self.lost_clips,
            "first_error": self.first_error,
        }


def benchmark(
    config: BenchmarkConfig,
    progress: Progress = lambda done, total, what: None,
    *,
    specs: Sequence[DetectorSpec] | None = None,
    loader: Loader = load_detector,
) -> BenchmarkReport:
    """Score detectors and write ``clips.parquet``, ``offline.parquet``, ``strata.parquet``, ``benchmark.json``.

    Args:
        config: Settings.
        progress: Called with (videos done, in all, what was last).
        specs: Detectors, where they are no checkpoints; default: resolved from ``config.detectors``.
        loader: Builds a detector from ``DetectorSpec.path``.

    Raises:
        ConfigError: For unknown names or a folder that cannot be written.
        DataError: For missing data, and for damaged images unless they are skipped.
    """
    specs = resolve_detectors(config.detectors) if specs is None else list(specs)
    work = [
        (spec, subset, _videos(config, spec, subset)) for spec in specs for subset in _subsets(config, spec)
    ]
    prepare_folder(config.out)
    total, done = sum(len(videos) for *_, videos in work), 0
    progress(0, total, "")
    clips: list[dict[str, Any]] = []
    table: list[dict[str, Any]] = []
    detector: Any = None
    loaded = ""
    for spec, subset, videos in work:
        if loaded != spec.name:
            detector, loaded = loader(spec.path), spec.name
        tally, rows, begin_s = _Tally(), [], time.perf_counter()
        for video in videos:
            rows += list(_score_video(config, spec, subset, detector, video, tally))
            done += 1
            progress(done, total, f"{spec.name}, {subset}/{video.name}")
        spent_ms = 1e3 * (time.perf_counter() - begin_s) / len(rows) if rows else float("nan")
        clips += rows
        scores = score_table(rows, spec, subset, config) | _energy(detector, tally.example_clips)
        table.append(scores | tally.counts() | {"ms_per_clip": spent_ms})
    by_stratum = strata(clips, config.data / "manifest.parquet", seed=config.seed)
    write_rows(config.out / "clips.parquet", clips)
    write_rows(config.out / "offline.parquet", table)
    write_rows(config.out / "strata.parquet", by_stratum)
    write_json(config.out / "benchmark.json", _provenance(config, specs))
    return BenchmarkReport(clips, table, by_stratum)


def score_table(
    rows: Sequence[dict[str, Any]], spec: DetectorSpec, subset: str, config: BenchmarkConfig
) -> dict[str, Any]:
    """One row of the offline table from the clips of one detector and subset.

    Undefined scores are nan and ``note`` says why. The interval of the AUROC is a bootstrap over videos.
    """
    labels = np.array([row["label"] for row in rows], dtype=np.int64)
    p = np.array([row["p"] for row in rows], dtype=np.float64)
    videos = np.array([row["video"] for row in rows], dtype=str)
    positives = int(labels.sum())
    interval = clustered_bootstrap(
        lambda weights: metrics.auroc(labels, p, weights),
        videos,
        seed=config.seed,
        resamples=config.resamples,
    )
    note = ""
    if not labels.size:
        note = "no clip could be cut"
    elif positives in (0, labels.size):
        note = f"one class only: all {labels.size} clips are {'positive' if positives else 'negative'}"
    elif np.isnan(interval.low):
        note = "too few videos for an interval"
    return {
        "detector": spec.name,
        "subset": subset,
        "modality": spec.modality,
        "clips": int(labels.size),
        "positives": positives,
        "videos": len(set(videos.tolist())),
        "positive_videos": len(set(videos[labels == 1].tolist())),
        "auroc": metrics.auroc(labels, p),
        "auroc_low": interval.low,
        "auroc_high": interval.high,
        "auprc": metrics.auprc(labels, p),
        "f_score": metrics.f_score(labels, p, spec.threshold),
        "threshold": spec.threshold,
        "brier": metrics.brier(labels, p),
        "ece": metrics.expected_calibration_error(labels, p),
        "note": note,
    }


def _energy(detector: Any, clips: Sequence[np.ndarray]) -> dict[str, Any]:
    """Mean energy of a clip, where the detector is a network of ours; nan where it cannot be counted."""
    network, preprocess = getattr(detector, "network", None), getattr(detector, "preprocess", None)
    if network is None or preprocess is None or not clips:
        return {"energy_mj": float("nan"), "macs": float("nan"), "acs": float("nan"), "parameters": None}
    from perception.energy import count_energy
    from perception.streaming import clip_tensor

    small = [np.stack([preprocess.shrink(image) for image in clip]) for clip in clips]
    counted = [count_energy(network, clip_tensor(clip[None], preprocess)) for clip in small]
    return {
        "energy_mj": float(np.mean([energy.millijoules for energy in counted])),
        "macs": float(np.mean([energy.macs for energy in counted])),
        "acs": float(np.mean([energy.acs for energy in counted])),
        "parameters": sum(parameter.numel() for parameter in network.parameters()),
    }


def _subsets(config: BenchmarkConfig, spec: DetectorSpec) -> list[str]:
    ending = f"_{spec.modality}"
    if not config.data.is_dir():
        raise DataError(f"data = {config.data} is not a folder; 'pedcross generate' records one.")
    found = sorted(path.name.removesuffix(ending) for path in config.data.glob(f"*{ending}") if path.is_dir())
    if not found:
        raise DataError(f"data = {config.data} has no folder *{ending}, which {spec.name} needs.")
    for subset in config.subsets:
        if subset not in found:
            raise unknown_name(f"{spec.modality} subset of {config.data}", subset, found)
    return list(config.subsets) or found


def _videos(config: BenchmarkConfig, spec: DetectorSpec, subset: str) -> list[Any]:
    from perception.data.frames import FrameFolder

    videos = list(FrameFolder.open(config.data, subset, spec.modality).videos)  # type: ignore[arg-type]
    if config.split == "all":
        return videos
    if not spec.test_videos:
        raise ConfigError(f"{spec.name} does not say which videos its training kept apart; use --split all.")
    kept = [video for video in videos if f"{subset}/{video.name}" in spec.test_videos]
    if not kept:
        raise DataError(f"{config.data} has none of {spec.name}'s test videos in {subset!r}.")
    return kept


def _score_video(
    config: BenchmarkConfig, spec: DetectorSpec, subset: str, detector: Any, video: Any, tally: _Tally
) -> Iterator[dict[str, Any]]:
    from perception.data.windows import window_labels

    frames = int(detector.frames)
    images = _read_images(config, video, tally)
    starts = np.arange(0, len(images) - frames + 1, config.stride)
    if not len(starts):
        tally.short_videos += 1
        return
    labels = window_labels(video.labels, starts, frames)
    # A clip must be what its length says: no damaged image and no gap in the frame numbers inside.
    whole = [
        i
        for i, s in enumerate(starts)
        if all(image is not None for image in images[s : s + frames])
        and video.numbers[s + frames - 1] - video.numbers[s] == frames - 1
    ]
    tally.lost_clips += len(starts) - len(whole)
    for begin in range(0, len(whole), BATCH):
        batch = whole[begin : begin + BATCH]
        clips = np.array([images[starts[i] : starts[i] + frames] for i in batch], dtype=np.uint8)
        if begin == 0 and len(tally.example_clips) < EXAMPLE_CLIPS:
            tally.example_clips.append(clips[len(clips) // 2])
        p = np.asarray(detector.predict(clips), dtype=np.float64)
        if p.shape != (len(batch),) or np.isnan(p).any():
            raise DataError(f"{spec.name} returned {p!r} for {len(batch)} clips of {subset}/{video.name}.")
        for i, value in zip(batch, p, strict=True):
            yield {
                "detector": spec.name,
                "subset": subset,
                "modality": spec.modality,
                "video": video.name,
                "start_frame": int(video.numbers[starts[i]]),
                "frames": frames,
                "label": int(labels[i]),
                "p": float(value),
            }


def _read_images(config: BenchmarkConfig, video: Any, tally: _Tally) -> list[np.ndarray | None]:
    from perception.data.frames import read_frame

    images: list[np.ndarray | None] = []
    for path in video.paths:
        try:
            images.append(read_frame(path, video.modality))
        except DataError as error:
            if config.on_error == "raise":
                raise DataError(f"{error} Or leave its clips out, counted: --on-error skip.") from error
            tally.damaged_images += 1
            tally.first_error = tally.first_error or str(error)
            images.append(None)
    return images


def _was_trained_on(config: BenchmarkConfig, spec: DetectorSpec) -> bool:
    """Whether the checkpoint's training read the same frames, by their fingerprint."""
    subsets = (spec.about.get("training") or {}).get("subsets") or ()
    fingerprint = spec.about.get("fingerprint")
    if not fingerprint or not all((config.data / f"{s}_{spec.modality}").is_dir() for s in subsets):
        return False
    from perception.data.frames import FrameFolder
    from perception.data.frames import fingerprint as fingerprint_of

    folders = [FrameFolder.open(config.data, subset, spec.modality) for subset in subsets]  # type: ignore[arg-type]
    return fingerprint_of(folders) == fingerprint


def _provenance(config: BenchmarkConfig, specs: Sequence[DetectorSpec]) -> dict[str, Any]:
    seen = [spec.name for spec in specs if config.split == "all" and _was_trained_on(config, spec)]
    return provenance() | {
        "trained_on_this_data": seen,
        "settings": json.loads(json.dumps(dataclasses.asdict(config), default=str)),
        "detectors": [dataclasses.asdict(spec) for spec in specs],
    }
