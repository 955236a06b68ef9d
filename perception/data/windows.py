"""Windows of T frames, their labels, and the split by video."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from sklearn.model_selection import train_test_split

from pedcross_env.errors import ConfigError, DataError
from perception.data.frames import Video

__all__ = ["Part", "split_by_video", "window_labels", "window_starts"]

Part = Literal["train", "validation", "test"]


def window_starts(frames_in_video: int, frames: int, overlap: int) -> np.ndarray:
    """Return the first frames of all windows: range(0, N - T + 1, T - overlap), empty where N < T.

    Raises:
        ConfigError: Unless frames >= 1 and 0 <= overlap < frames.
    """
    if frames < 1 or not 0 <= overlap < frames:
        raise ConfigError(
            f"frames = {frames}, overlap = {overlap}: must be frames >= 1, 0 <= overlap < frames."
        )
    return np.arange(0, frames_in_video - frames + 1, frames - overlap)


def window_labels(labels: np.ndarray, starts: np.ndarray, frames: int) -> np.ndarray:
    """Return (M,) uint8: the maximum of each window's frame labels (1 if any frame crosses)."""
    if len(starts) == 0:
        return np.zeros(0, np.uint8)
    return np.lib.stride_tricks.sliding_window_view(labels, frames)[starts].max(axis=1).astype(np.uint8)


def split_by_video(
    videos: Sequence[Video], seed: int = 42, test: float = 0.15, val: float = 0.15, *, stratify: bool = False
) -> dict[Part, list[Video]]:
    """Split as the paper does, whole videos at a time, whatever the order given.

    Videos of one name in several subsets (the same crossing in other weather) stay together.

    Args:
        videos: Any order.
        seed: ``random_state`` of both draws.
        test, val: Shares; val is of what the test leaves.
        stratify: Keep the share of videos with a crossing in every part (the paper does not).

    Raises:
        DataError: Where a part would be empty, or a class has too few videos to stratify.
    """
    names = sorted({video.name for video in videos})
    positive = {video.name for video in videos if video.labels.any()}

    def draw(pool: list[str], share: float) -> tuple[list[str], list[str]]:
        kinds = [name in positive for name in pool] if stratify else None
        try:
            kept, drawn = train_test_split(pool, test_size=share, random_state=seed, stratify=kinds)
        except ValueError as error:
            raise DataError(
                f"{len(names)} videos cannot be split into train, validation and test: {error}"
            ) from error
        return kept, drawn

    rest, test_names = draw(names, test)
    train_names, val_names = draw(rest, val)
    part_of: dict[str, Part] = {}
    for part, members in zip(get_args(Part), (train_names, val_names, test_names), strict=True):
        part_of.update(dict.fromkeys(members, part))
    parts: dict[Part, list[Video]] = {"train": [], "validation": [], "test": []}
    for video in sorted(videos, key=lambda v: (v.subset, v.name)):
        parts[part_of[video.name]].append(video)
    return parts
