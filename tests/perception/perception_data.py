"""Tiny frame folders made on the spot: a bright block that moves (label 1) or stands still (label 0)."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

SIDE_PX = 32


def block_video(seed: int, frames: int, first_positive: int | None) -> tuple[np.ndarray, np.ndarray]:
    """Return RGB (n, 32, 32, 3) uint8 and labels: a red block appears while label is 1, a blue one else."""
    rng = np.random.default_rng(seed)
    images = rng.integers(0, 40, (frames, SIDE_PX, SIDE_PX, 3), dtype=np.uint8)
    labels = np.zeros(frames, np.uint8)
    if first_positive is not None:
        labels[first_positive:] = 1
    for i, label in enumerate(labels):
        x = int(rng.integers(4, 20))
        images[i, 12:22, x : x + 8, 0 if label else 2] = 255
    return images, labels


def write_video(folder: Path, images: np.ndarray, labels: np.ndarray, suffix: str = ".png") -> None:
    folder.mkdir(parents=True)
    for i, (image, label) in enumerate(zip(images, labels, strict=True)):
        assert cv2.imwrite(str(folder / f"{i:03d}-{label}{suffix}"), image[..., ::-1])


def write_dataset(root: Path, videos: int = 14, frames: int = 10, modality: str = "rgb") -> Path:
    for i in range(videos):
        write_video(root / f"dataset_{modality}" / f"video_{i:02d}", *block_video(i, frames, frames // 2))
    return root
