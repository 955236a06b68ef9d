"""``pedcross events``: what an event camera would have made of a video.

What a video can and cannot give, whatever emulates the camera:

- Between two frames the logarithm of light is taken to run straight, pixel by pixel: there is no network here that
  makes up frames. Events are timed within that line to the nanosecond, but an edge that moved by several pixels
  between two frames fires where it was and where it is, not in between. Film fast, or move slowly.
- 8-bit frames hold no light beyond white and little below black: there are no events where the picture is saturated,
  and compression's blocks and the exposure control make events that no real sensor would have.
"""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Literal

import cv2
import numpy as np

from eval.canvas import DIM, INK, PANEL, blank, fit, open_screen, text
from eval.samples import paint_events
from eval.store import prepare_folder
from eval.video_source import VideoSource, open_source
from pedcross_env.config import require
from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError, unknown_name
from pedcross_env.sensors.dvs import initial_state, step
from pedcross_env.sensors.dvs_config import DVS_PRESETS, DvsConfig, dvs_preset
from pedcross_env.sensors.event_files import write_events
from pedcross_env.sensors.events import counts_to_png, event_counts
from pedcross_env.sensors.intensity import log_image
from pedcross_env.sensors.representations import represent
from pedcross_env.sensors.representations import window as select

__all__ = ["VideoEventsConfig", "VideoEventsReport", "make_events"]

FileFormat = Literal["npz", "h5", "aedat4"]
FrameFormat = Literal["counts", "carla", "paper", "none"]
HEAD = 34
LARGEST_SIDE = 960
"""Pixels across of each half of the side-by-side video."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VideoEventsConfig:
    """Settings of ``pedcross events``."""

    video: Path
    """A file that OpenCV reads, or a folder of pictures."""
    out: Path = Path("out/events")
    """events.npz (or .h5, .aedat4), frames/ and side_by_side.mp4 go there."""
    camera: str = "default"
    """The event camera: default, ideal, clean, noisy, carla, v2e, v2e_clean, v2e_noisy, dvs128, davis346 or gen4."""
    threshold: float | None = None
    """Change of the logarithm of light that makes an event, ON and OFF; not given: the camera's."""
    fps: float | None = None
    """Frames per second when it was filmed; not given: as the video says. Slow-motion footage says less."""
    slow_motion: int = 1
    """Event frames per frame of the video, each over its part of the time: the side-by-side video is so much slower.
    Within a frame light runs straight in its logarithm: nothing is made up in between."""
    width_px: int | None = None
    """Shrink frames to this width first; not given: as they are."""
    start_s: float = 0.0
    """Where in the video to begin."""
    duration_s: float | None = None
    """How much of it to take; not given: all."""
    file: FileFormat = "npz"
    """Of the events; npz keeps nanoseconds, the others cut times down to microseconds."""
    frames: FrameFormat = "counts"
    """PNG per event frame: counts (lossless), carla (last event's colour), paper (one channel), or none."""
    side_by_side: bool = True
    """Whether to write the video."""
    seed: int = 0
    """Of the pixels' differences and the noise."""

    def __post_init__(self) -> None:
        if self.camera not in DVS_PRESETS:
            raise unknown_name("event camera preset", self.camera, DVS_PRESETS)
        require(1 <= self.slow_motion <= 1000, "slow_motion", self.slow_motion, "1 to 1000")
        require(self.start_s >= 0, "start_s", self.start_s, "0 or more")
        require(self.seed >= 0, "seed", self.seed, "0 or more")
        if self.fps is not None:
            require(0 < self.fps <= 1e5, "fps", self.fps, "above 0, at most 100000")
        if self.duration_s is not None:
            require(self.duration_s > 0, "duration_s", self.duration_s, "positive")
        if self.width_px is not None:
            require(8 <= self.width_px <= 8192, "width_px", self.width_px, "8 to 8192")
        self.dvs  # noqa: B018 - refuses a threshold out of range

    @property
    def dvs(self) -> DvsConfig:
        """The event camera's settings."""
        if self.threshold is None:
            return dvs_preset(self.camera)
        return dvs_preset(self.camera, positive_threshold=self.threshold, negative_threshold=self.threshold)


@dataclass(frozen=True, slots=True)
class VideoEventsReport:
    """What a call of ``make_events`` wrote.

    Attributes:
        source: What it read.
        frames: Number of frames used.
        events: Number of events.
        on: How many of them are ON.
        shape: (height, width) of the event camera.
        span_s: Time from the first to the last frame.
        camera_s: User-CPU seconds the emulator took (logarithm and events), without reading and drawing.
        path: Of the events' file.
        video: The side-by-side video or None.
    """

    source: VideoSource
    frames: int
    events: int
    on: int
    shape: tuple[int, int]
    span_s: float
    camera_s: float
    path: Path
    video: Path | None


class _Store:
    """Events on disk as they come: a long video's do not fit into memory."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / f".{os.getpid()}-events"
        self._file: IO[bytes] = self._path.open("wb")
        self.count = self.on = 0

    def add(self, events: np.ndarray) -> None:
        self._file.write(events.tobytes())
        self.count += events.size
        self.on += int(np.count_nonzero(events["pol"]))

    def write(self, path: Path, shape: tuple[int, int]) -> None:
        self._file.close()
        events = np.memmap(self._path, EVENT_DTYPE, "r") if self.count else np.empty(0, EVENT_DTYPE)
        write_events(path, events, shape=shape, round_times=path.suffix != ".npz")

    def delete(self) -> None:
        self._file.close()
        self._path.unlink(missing_ok=True)


def make_events(
    config: VideoEventsConfig, progress: Callable[[int, int, str], None] = lambda done, total, what: None
) -> VideoEventsReport:
    """Write the events of a video, its event frames, and a video of both side by side.

    Args:
        config: Settings.
        progress: Called with (frames done, in all, what is going on).

    Raises:
        DataError: For a video that is missing, unreadable, or has fewer than two frames in the part asked for.
        ConfigError: For an unknown frame rate or a folder that cannot be written.
    """
    source = open_source(config.video, config.fps)
    prepare_folder(config.out)
    folder = config.out / "frames"
    if config.frames != "none":
        prepare_folder(folder)
        for old in folder.glob("*.png"):  # of an earlier, longer run
            old.unlink()
    first = round(config.start_s * source.fps)
    expected = max(0, source.count - first)
    if config.duration_s is not None:
        expected = min(expected, round(config.duration_s * source.fps) + 1) if source.count else 0
    video = config.out / "side_by_side.mp4" if config.side_by_side else None
    path = config.out / f"events.{config.file}"
    store = _Store(config.out)
    try:
        if video is None:
            frames, shape, camera_s = _run(config, source, first, expected, store, None, progress)
        else:
            with open_screen(video, source.fps) as screen:
                frames, shape, camera_s = _run(config, source, first, expected, store, screen.show, progress)
        store.write(path, shape)
        return VideoEventsReport(
            source, frames, store.count, store.on, shape, (frames - 1) / source.fps, camera_s, path, video
        )
    finally:
        store.delete()


def _run(
    config: VideoEventsConfig,
    source: VideoSource,
    first: int,
    expected: int,
    store: _Store,
    show: Callable[[np.ndarray], None] | None,
    progress: Callable[[int, int, str], None],
) -> tuple[int, tuple[int, int], float]:
    """Emulate frame by frame: (number of frames, shape, user-CPU seconds of the emulator)."""
    dvs, frames = config.dvs, _taken(config, source, first)
    picture = next(frames, None)
    if picture is None:
        raise DataError(
            f"{source.path} has no frame at {config.start_s:g} s; it ends after {source.count / source.fps:.2f} s."
        )
    shape = picture.shape[0], picture.shape[1]
    state = initial_state(log_image(picture, dvs), 0, dvs, config.seed)
    camera_s, number = 0.0, 1
    for picture in frames:
        begin_s = time.process_time()
        start_ns, end_ns = (round(k * 1e9 / source.fps) for k in (number - 1, number))
        state, events = step(state, log_image(picture, dvs), end_ns, dvs)
        camera_s += time.process_time() - begin_s
        # CARLA's rounding may reach the next frame's time by some ns; the last window takes them in.
        events["t"] = np.minimum(events["t"], end_ns - 1)
        store.add(events)
        edges = [
            start_ns + (end_ns - start_ns) * k // config.slow_motion for k in range(config.slow_motion + 1)
        ]
        for part, window in enumerate(itertools.pairwise(edges)):
            _write_frame(config, events, shape, window, (number - 1) * config.slow_motion + part)
            if show is not None:
                show(_side_by_side(picture, events, shape, window, config))
        number += 1
        progress(number, max(expected, number), f"{store.count:,} events")
    if number < 2:
        raise DataError(
            f"{source.path}: one frame alone gives no events; at least two are needed in the part chosen."
        )
    return number, shape, camera_s


def _taken(config: VideoEventsConfig, source: VideoSource, first: int) -> Iterator[np.ndarray]:
    """The frames asked for, in the size asked for."""
    stop = None if config.duration_s is None else round(config.duration_s * source.fps) + 1
    for frame in itertools.islice(source.frames(first), stop):
        if config.width_px is None or config.width_px == frame.shape[1]:
            yield frame
        else:
            height = max(1, round(frame.shape[0] * config.width_px / frame.shape[1]))
            way = cv2.INTER_AREA if config.width_px < frame.shape[1] else cv2.INTER_LINEAR
            yield np.asarray(cv2.resize(frame, (config.width_px, height), interpolation=way))


def _write_frame(
    config: VideoEventsConfig,
    events: np.ndarray,
    shape: tuple[int, int],
    window: tuple[int, int],
    number: int,
) -> None:
    if config.frames == "none":
        return
    if config.frames == "counts":
        image = counts_to_png(event_counts(select(events, *window), shape))
    else:
        image = represent(config.frames, events, shape, *window)
    path = config.out / "frames" / f"{number:06d}.png"
    bgr = np.ascontiguousarray(image[..., ::-1]) if image.ndim == 3 else image
    if not cv2.imwrite(str(path), bgr, [cv2.IMWRITE_PNG_COMPRESSION, 3]):
        raise OSError(28, "the picture could not be written; is there space left?", str(path))


def _side_by_side(
    picture: np.ndarray,
    events: np.ndarray,
    shape: tuple[int, int],
    window: tuple[int, int],
    config: VideoEventsConfig,
) -> np.ndarray:
    """The frame at the window's end (of its frame interval) beside the window's events."""
    scale = min(1.0, LARGEST_SIDE / shape[1])
    height, width = round(shape[0] * scale), round(shape[1] * scale)
    canvas = blank(2 * width, height + HEAD, PANEL)
    inside = select(events, *window)
    fit(canvas, picture, (0, HEAD, width, height))
    fit(canvas, paint_events(event_counts(inside, shape)), (width, HEAD, width, height))
    text(canvas, f"{window[1] * 1e-9 + config.start_s:.3f} s", (10, 8), 15, INK, bold=True)
    told = f"{config.camera}, {inside.size:,} events in {(window[1] - window[0]) * 1e-6:.1f} ms"
    text(canvas, told, (width + 10, 8), 15, INK, bold=True)
    text(canvas, "ON blue   OFF red", (2 * width - 10, 9), 13, DIM, align="right")
    return canvas
