"""Pictures for people: text, panels and plots on an RGB canvas, and the files and windows they go to."""

from __future__ import annotations

import functools
import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from eval.store import prepare_folder
from pedcross_env.errors import ConfigError

__all__ = [
    "BACKGROUND", "DEPTH_M", "DIM", "INK", "PANEL", "Screen", "StoppedByUser", "VideoFile", "Window", "blank",
    "depth_colours", "fit", "open_screen", "text", "text_width",
]  # fmt: skip

Colour = tuple[int, int, int]
BACKGROUND: Colour = (18, 20, 24)
PANEL: Colour = (30, 33, 39)
INK: Colour = (236, 238, 242)
DIM: Colour = (150, 156, 166)
DEPTH_M = (2.0, 120.0)
VIDEO_SUFFIXES = {".mp4": "mp4v", ".avi": "MJPG"}


def blank(width: int, height: int, colour: Colour = BACKGROUND) -> np.ndarray:
    """(height, width, 3) uint8 of one colour."""
    return np.full((height, width, 3), colour, np.uint8)


@functools.lru_cache(maxsize=1024)
def _glyphs(words: str, size: int, bold: bool) -> np.ndarray:
    """Coverage of a line of text, (H, W, 1) float32 in 0..1, its baseline at the same height for every text."""
    from PIL import Image, ImageDraw

    font = _font(size, bold)
    ascent, descent = font.getmetrics()
    width = max(1, math.ceil(font.getlength(words)))
    image = Image.new("L", (width, ascent + descent))
    ImageDraw.Draw(image).text((0, 0), words, fill=255, font=font)
    return np.asarray(image, np.float32)[..., None] / 255


@functools.cache
def _font(size: int, bold: bool) -> Any:
    import matplotlib
    from PIL import ImageFont

    # DejaVu comes with matplotlib: the same letters on every machine.
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


def text_width(words: str, size: int, *, bold: bool = False) -> int:
    """Width of a line of text in pixels."""
    return _glyphs(words, size, bold).shape[1] if words else 0


def text(
    canvas: np.ndarray,
    words: str,
    at: tuple[int, int],
    size: int = 15,
    colour: Colour = INK,
    *,
    bold: bool = False,
    align: str = "left",
) -> None:
    """Write a line of text onto ``canvas``, in place; what does not fit on it is cut off.

    Args:
        canvas: (H, W, 3) uint8.
        words: One line.
        at: (x, y) of its upper left corner; of its upper right or middle with ``align`` "right" or "centre".
        size: Of the font in pixels.
        colour: RGB.
        bold: Which cut.
        align: "left", "centre" or "right".
    """
    if not words:
        return
    cover = _glyphs(words, size, bold)
    height, width = cover.shape[:2]
    x = at[0] - {"left": 0, "centre": width // 2, "right": width}[align]
    x0, y0 = max(0, x), max(0, at[1])
    x1, y1 = min(canvas.shape[1], x + width), min(canvas.shape[0], at[1] + height)
    if x1 <= x0 or y1 <= y0:
        return
    part = canvas[y0:y1, x0:x1]
    share = cover[y0 - at[1] : y1 - at[1], x0 - x : x1 - x]
    part[:] = (part * (1 - share) + np.array(colour, np.float32) * share + 0.5).astype(np.uint8)


def fit(canvas: np.ndarray, picture: np.ndarray, box: tuple[int, int, int, int]) -> tuple[int, int, float]:
    """Put a picture as large as it goes into a box (x, y, width, height) of the canvas, in the middle, in place.

    Returns:
        (x, y) of its upper left corner and by how much it was scaled.
    """
    x, y, width, height = box
    scale = min(width / picture.shape[1], height / picture.shape[0])
    w, h = max(1, round(picture.shape[1] * scale)), max(1, round(picture.shape[0] * scale))
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    x0, y0 = x + (width - w) // 2, y + (height - h) // 2
    canvas[y : y + height, x : x + width] = PANEL
    canvas[y0 : y0 + h, x0 : x0 + w] = cv2.resize(picture, (w, h), interpolation=way)
    return x0, y0, scale


def depth_colours(depth: np.ndarray) -> np.ndarray:
    """Depth in colours, 2 m red to 120 m blue, logarithmic; the sky is black.

    Args:
        depth: (H, W) float, metres, inf for sky.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    low, high = (math.log(d) for d in DEPTH_M)
    share = (np.log(np.clip(depth, *DEPTH_M)) - low) / (high - low)
    colours = cv2.applyColorMap((255 * (1 - share)).astype(np.uint8), cv2.COLORMAP_TURBO)[..., ::-1]
    return np.where(np.isinf(depth)[..., None], 0, np.asarray(colours)).astype(np.uint8)


class StoppedByUser(Exception):
    """The window was closed."""


class Screen(Protocol):
    """Where pictures go, one after another, all of one size."""

    def show(self, picture: np.ndarray) -> None:
        """Take the next (H, W, 3) uint8 RGB picture."""
        ...


class VideoFile:
    """A video, there whole or not at all; made by ``open_screen``."""

    def __init__(self, path: Path, fps: float) -> None:
        if path.suffix.lower() not in VIDEO_SUFFIXES:
            raise ConfigError(
                f"{path}: videos are written as {' or '.join(VIDEO_SUFFIXES)}; choose one of them."
            )
        prepare_folder(path.parent)
        self.path, self._fps = path, fps
        self._temporary = path.with_name(f".{os.getpid()}-{path.name}")
        self._writer: cv2.VideoWriter | None = None
        self._shape: tuple[int, ...] = ()

    def show(self, picture: np.ndarray) -> None:
        """Append a picture; an odd last row or column, which codecs refuse, is left out."""
        height, width = picture.shape[0] // 2 * 2, picture.shape[1] // 2 * 2
        if self._writer is None:
            code = cv2.VideoWriter.fourcc(*VIDEO_SUFFIXES[self.path.suffix.lower()])
            self._writer = cv2.VideoWriter(str(self._temporary), code, self._fps, (width, height))
            self._shape = picture.shape
            if not self._writer.isOpened():
                raise ConfigError(
                    f"{self.path}: OpenCV cannot write {width}x{height} as {self.path.suffix}; try .avi, or a folder "
                    "with free space."
                )
        if picture.shape != self._shape:
            raise ValueError(f"a picture of {picture.shape} in a video of {self._shape}.")
        self._writer.write(np.ascontiguousarray(picture[:height, :width, ::-1]))

    def close(self, *, keep: bool) -> None:
        """Finish the file, or throw it away."""
        if self._writer is not None:
            self._writer.release()
            if keep:
                os.replace(self._temporary, self.path)
        self._temporary.unlink(missing_ok=True)


class Window:
    """A window on the screen; space pauses, Q, escape or closing it ends. Made by ``open_screen``.

    pygame (which highway-env brings along) opens it, for OpenCV's headless build has no windows.
    """

    def __init__(self, title: str, fps: float) -> None:
        self._title, self._fps = title, fps
        self._surface: Any = None
        has_display = sys.platform in ("darwin", "win32") or any(
            os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
        )
        if not has_display:
            raise ConfigError(
                "there is no display to open a window on; leave out --window to write a video instead."
            )
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        try:
            import pygame
        except ImportError as error:
            raise ConfigError(
                "a window needs pygame: pip install pygame-ce, or leave out --window."
            ) from error
        self._pygame = pygame

    def show(self, picture: np.ndarray) -> None:
        """Show a picture, at the pace of real time at most.

        Raises:
            StoppedByUser: When the window is closed.
        """
        pygame = self._pygame
        if self._surface is None:
            try:
                pygame.display.init()
                self._surface = pygame.display.set_mode(picture.shape[1::-1])
            except pygame.error as error:
                raise ConfigError(f"no window can be opened ({error}); leave out --window.") from error
            pygame.display.set_caption(self._title)
            self._clock = pygame.time.Clock()
        # The surface's array is (W, H, 3).
        pygame.surfarray.blit_array(self._surface, picture.swapaxes(0, 1))
        pygame.display.flip()
        paused = False
        while True:
            for event in pygame.event.get():
                if event.type == pygame.QUIT:
                    raise StoppedByUser
                if event.type == pygame.KEYDOWN and event.key in (pygame.K_q, pygame.K_ESCAPE):
                    raise StoppedByUser
                if event.type == pygame.KEYDOWN and event.key == pygame.K_SPACE:
                    paused = not paused
            self._clock.tick(self._fps)
            if not paused:
                return

    def close(self) -> None:
        """Close the window."""
        if self._surface is not None:
            self._pygame.display.quit()


@contextmanager
def open_screen(path: Path | None, fps: float, *, window: str | None = None) -> Iterator[Screen]:
    """Open a window called ``window``, or the video file ``path``, for the block.

    A file stays if the block ends well or is interrupted, and goes where an error ends it.

    Raises:
        ConfigError: Where there is no display, or the file cannot be written.
    """
    if window is not None:
        shown = Window(window, fps)
        try:
            yield shown
        finally:
            shown.close()
        return
    if path is None:
        raise ConfigError("neither a window nor a file to write to; give one of them.")
    file = VideoFile(path, fps)
    try:
        yield file
    except KeyboardInterrupt:  # what was filmed so far can be watched
        file.close(keep=True)
        raise
    except BaseException:
        file.close(keep=False)
        raise
    file.close(keep=True)
