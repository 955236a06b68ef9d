"""Clips in memory: every frame is read and preprocessed once, as 8-bit small images."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from pedcross_env.errors import ConfigError, DataError
from perception.data.frames import Video, read_frame
from perception.data.windows import window_labels, window_starts
from perception.preprocess import Preprocess

__all__ = ["ClipDataset", "load_video"]

OnError = Literal["raise", "skip"]


def _cache_file(cache_dir: Path, video: Video, preprocess: Preprocess) -> Path:
    facts = [(p.name, s.st_size, s.st_mtime_ns) for p in video.paths for s in (p.stat(),)]
    key = json.dumps(["v1", video.subset, video.name, preprocess.to_dict(), facts], sort_keys=True)
    return cache_dir / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.npy"


def load_video(
    video: Video,
    preprocess: Preprocess,
    *,
    cache_dir: Path | None = None,
    on_error: OnError = "raise",
    workers: int = 2,
) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Read and shrink all frames of one video.

    Args:
        video: Its modality must be the preprocessing's.
        preprocess: As the network's.
        cache_dir: Where small images are kept between runs; None: nowhere. Names, sizes, times of the
            files and the preprocessing make the key.
        on_error: "skip" leaves out damaged images and returns their errors.
        workers: Threads that decode.

    Returns:
        (n, h, w, C) uint8; which frames they are, (n,) indices into the video; errors of frames left out.

    Raises:
        DataError: For a damaged image with on_error="raise"; names the file.
    """
    if video.modality != preprocess.modality:
        raise ConfigError(
            f"video {video.name!r} is {video.modality}, the preprocessing is for {preprocess.modality}."
        )
    if on_error not in ("raise", "skip"):
        raise ConfigError(f"on_error = {on_error!r} is not allowed: 'raise' or 'skip'.")
    cache = None
    if cache_dir is not None:
        cache = _cache_file(cache_dir, video, preprocess)
        if cache.exists():
            images = np.load(cache, allow_pickle=False)
            return images, np.arange(len(images)), []

    def read(path: Path) -> np.ndarray | DataError:
        try:
            return preprocess.shrink(read_frame(path, video.modality))
        except DataError as error:
            return error

    with ThreadPoolExecutor(workers) as pool:
        results = list(pool.map(read, video.paths))
    errors = [result for result in results if isinstance(result, DataError)]
    if errors and on_error == "raise":
        raise errors[0]
    kept = np.array([i for i, result in enumerate(results) if not isinstance(result, DataError)], np.int64)
    shape = (0, preprocess.height_px, preprocess.width_px, preprocess.channels)
    images = np.stack([results[i] for i in kept]) if len(kept) else np.zeros(shape, np.uint8)
    if cache is not None and not errors:
        cache.parent.mkdir(parents=True, exist_ok=True)
        partial = cache.with_suffix(f".{os.getpid()}.tmp")
        with partial.open("wb") as file:
            np.save(file, images)
        partial.replace(cache)
    return images, kept, [str(error) for error in errors]


@dataclass(frozen=True, slots=True)
class ClipDataset:
    """Windows over videos in memory.

    Attributes:
        images: Per video, (n, h, w, C) uint8.
        video_names: Per video, "<subset>/<name>".
        frames: T.
        index: (M, 2) int64: video, first frame of each window.
        labels: (M,) uint8.
        too_short: Names of videos with fewer than T frames; they give no window.
        errors: What was left out with on_error="skip".
    """

    images: tuple[np.ndarray, ...]
    video_names: tuple[str, ...]
    frames: int
    index: np.ndarray
    labels: np.ndarray
    too_short: tuple[str, ...]
    errors: tuple[str, ...]

    @classmethod
    def from_videos(
        cls,
        videos: Sequence[Video],
        preprocess: Preprocess,
        *,
        frames: int,
        overlap: int,
        cache_dir: Path | None = None,
        on_error: OnError = "raise",
    ) -> ClipDataset:
        """Load videos and cut windows of ``frames`` that share ``overlap`` frames with the next."""
        images: list[np.ndarray] = []
        index: list[np.ndarray] = []
        labels: list[np.ndarray] = []
        names: list[str] = []
        short: list[str] = []
        errors: list[str] = []
        for video in videos:
            name = f"{video.subset}/{video.name}"
            array, kept, lost = load_video(video, preprocess, cache_dir=cache_dir, on_error=on_error)
            errors += lost
            starts = window_starts(len(array), frames, overlap)
            if len(starts) == 0:
                short.append(name)
                continue
            index.append(np.stack([np.full(len(starts), len(images)), starts], axis=1))
            labels.append(window_labels(video.labels[kept], starts, frames))
            images.append(array)
            names.append(name)
        return cls(
            tuple(images), tuple(names), frames,
            np.concatenate(index).astype(np.int64) if index else np.zeros((0, 2), np.int64),
            np.concatenate(labels) if labels else np.zeros(0, np.uint8),
            tuple(short), tuple(errors),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.index)

    def clips(self, indices: np.ndarray) -> np.ndarray:
        """Return windows as (B, T, h, w, C) uint8; feed them to ``Preprocess.normalise``."""
        return np.stack([self.images[v][s : s + self.frames] for v, s in self.index[indices]])
