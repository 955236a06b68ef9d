"""Frames of a video file or of a folder of pictures, one after another, as RGB."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pedcross_env.errors import ConfigError, DataError

__all__ = ["PICTURE_SUFFIXES", "VideoSource", "open_source"]

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")


@dataclass(frozen=True, slots=True)
class VideoSource:
    """Where frames come from.

    Attributes:
        path: Of the video or the folder.
        fps: Frames per second of what was filmed.
        count: Number of frames; a video's header may be wrong by some.
        shape: (height, width).
        pictures: The folder's files in order; empty for a video.
    """

    path: Path
    fps: float
    count: int
    shape: tuple[int, int]
    pictures: tuple[Path, ...] = ()

    def frames(self, start: int = 0) -> Iterator[np.ndarray]:
        """Yield (H, W, 3) uint8 RGB frames from the ``start``-th on.

        Raises:
            DataError: For a picture that cannot be read or has another size.
        """
        if self.pictures:
            for picture in self.pictures[start:]:
                frame = _read_picture(picture)
                if frame.shape[:2] != self.shape:
                    raise DataError(
                        f"{picture} is {frame.shape[1]}x{frame.shape[0]}, the first picture {self.shape[1]}x"
                        f"{self.shape[0]}; the frames of one video must have one size: remove or resize it."
                    )
                yield frame
            return
        video = cv2.VideoCapture(str(self.path))
        try:
            # Decoding what is skipped is slow but exact; seeking lands on key frames.
            for _ in range(start):
                if not video.grab():
                    return
            while True:
                ok, frame = video.read()
                if not ok:
                    return
                yield np.ascontiguousarray(frame[..., ::-1])
        finally:
            video.release()


def open_source(path: Path, fps: float | None) -> VideoSource:
    """Look at a video or a folder.

    Args:
        path: Of a file that OpenCV reads, or a folder of pictures, taken in order of the numbers in their names.
        fps: Frames per second; None: as the video says. Required for a folder.

    Raises:
        DataError: For a path that is missing, holds no frames or cannot be read.
        ConfigError: Where the rate is not known.
    """
    if not path.exists():
        raise DataError(f"{path} does not exist; give a video or a folder of pictures.")
    return _open_folder(path, fps) if path.is_dir() else _open_video(path, fps)


def _open_folder(path: Path, fps: float | None) -> VideoSource:
    pictures = sorted((p for p in path.iterdir() if p.suffix.lower() in PICTURE_SUFFIXES), key=_natural)
    if not pictures:
        raise DataError(f"{path} holds no pictures; read are {', '.join(PICTURE_SUFFIXES)}.")
    if fps is None:
        raise ConfigError(
            f"{path} is a folder of pictures: how fast were they taken? Give --fps, e.g. --fps 30."
        )
    height, width = _read_picture(pictures[0]).shape[:2]
    return VideoSource(path, fps, len(pictures), (height, width), tuple(pictures))


def _natural(path: Path) -> tuple[list[int | str], str]:
    """Sort frame10 behind frame9."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.name)], path.name


def _read_picture(path: Path) -> np.ndarray:
    frame = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if frame is None:
        raise DataError(
            f"{path} ({path.stat().st_size} bytes) is no picture that OpenCV reads; remove or mend it."
        )
    return np.ascontiguousarray(frame[..., ::-1])


def _open_video(path: Path, fps: float | None) -> VideoSource:
    size = path.stat().st_size
    if size == 0:
        raise DataError(f"{path} is empty; copy or record it again.")
    video = cv2.VideoCapture(str(path))
    try:
        ok, frame = video.read() if video.isOpened() else (False, None)
        if not ok or frame is None:
            raise DataError(
                f"{path} ({size} bytes) is no video that OpenCV reads, or damaged; convert it, e.g. to H.264 in .mp4."
            )
        told = video.get(cv2.CAP_PROP_FPS)
        count = video.get(cv2.CAP_PROP_FRAME_COUNT)
    finally:
        video.release()
    if fps is None and not (math.isfinite(told) and 0 < told <= 100_000):
        raise ConfigError(f"{path} does not say how many frames a second it has; give --fps.")
    number = int(count) if math.isfinite(count) and 0 < count < 1e9 else 0
    return VideoSource(path, told if fps is None else fps, number, (frame.shape[0], frame.shape[1]))
