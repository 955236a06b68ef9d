"""One moment of an episode as one picture: both cameras, depth, the street from above, p(crossing), the car."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from eval.canvas import BACKGROUND, DIM, INK, PANEL, blank, depth_colours, fit, text, text_width
from eval.samples import paint_events
from pedcross_env.contracts import Outcome

__all__ = ["SIZE", "Scene", "draw_dashboard"]

SIZE = (1280, 748)
Colour = tuple[int, int, int]
GREEN: Colour = (64, 178, 110)
AMBER: Colour = (240, 176, 58)
RED: Colour = (226, 68, 62)
BLUE: Colour = (96, 156, 240)
SHADE: Colour = (52, 74, 62)
GAP, LEFT, VIEW, ABOVE = 12, 12, (512, 291), (208, 626)
ROWS = (72, 397)
"""Upper edges of the two rows of views; titles stand above them."""
HEAD, FOOT_Y = 44, 706
LEGEND_STEP = 14


@dataclass(frozen=True, slots=True)
class Scene:
    """What there is to see at one moment.

    Attributes:
        rgb: (H, W, 3) uint8.
        dvs: (H, W, 2) uint8, events ON, OFF of the last step.
        depth: (H, W) float, metres.
        above: (H', W', 3) uint8, the street from above.
        boxes: Pedestrians in the picture: (left, top, right, bottom) in pixels, and whether it is one who crosses.
        title: What drives, in which episode and weather.
        threshold: p from which on the car brakes.
        duration_s: Of the whole episode, the plot's width.
    """

    rgb: np.ndarray
    dvs: np.ndarray
    depth: np.ndarray
    above: np.ndarray
    boxes: Sequence[tuple[tuple[float, float, float, float], bool]]
    title: str
    threshold: float
    duration_s: float


def draw_dashboard(
    scene: Scene, infos: Sequence[Mapping[str, Any]], probabilities: Sequence[float]
) -> np.ndarray:
    """Draw a moment.

    Args:
        scene: Pictures of it.
        infos: Of all steps since the reset; the last is this moment's.
        probabilities: p(crossing) decided on all infos but the last; nan where there was none.

    Returns:
        (748, 1280, 3) uint8 RGB.
    """
    canvas, info = blank(*SIZE), infos[-1]
    _header(canvas, scene.title, info)
    second = LEFT + VIEW[0] + GAP
    x, y, scale = _view(
        canvas, scene.rgb, (LEFT, ROWS[0]), "RGB camera", f"{scene.rgb.shape[1]} x {scene.rgb.shape[0]}"
    )
    for box, crosses in scene.boxes:
        _outline(canvas, box, (x, y), scale, AMBER if crosses else DIM)
    events = int(scene.dvs.sum(dtype=np.int64))
    _view(
        canvas, paint_events(scene.dvs), (second, ROWS[0]), "Event camera", f"{events:,} events in this step"
    )
    _view(canvas, depth_colours(scene.depth), (LEFT, ROWS[1]), "Depth", "2 m red ... 120 m blue")
    above_x = second + VIEW[0] + GAP
    text(canvas, "From above", (above_x, HEAD + 6), 14, INK, bold=True)
    fit(canvas, scene.above, (above_x, ROWS[0], *ABOVE))
    _probability(canvas, (second, ROWS[1], VIEW[0], 176), scene, infos, probabilities)
    _tiles(canvas, (second, ROWS[1] + 188, VIEW[0], 103), info)
    _legend(canvas)
    if info["outcome"] != Outcome.RUNNING:
        _banner(canvas, info)
    return canvas


def _header(canvas: np.ndarray, title: str, info: Mapping[str, Any]) -> None:
    canvas[:HEAD] = PANEL
    text(canvas, "pedcross", (LEFT, 11), 18, BLUE, bold=True)
    text(canvas, title, (LEFT + 108, 13), 15, INK)
    text(canvas, f"{info['time_s']:5.2f} s", (SIZE[0] - GAP, 11), 18, INK, bold=True, align="right")


def _view(
    canvas: np.ndarray, picture: np.ndarray, at: tuple[int, int], title: str, note: str
) -> tuple[int, int, float]:
    text(canvas, title, (at[0], at[1] - 22), 14, INK, bold=True)
    text(canvas, note, (at[0] + VIEW[0], at[1] - 21), 13, DIM, align="right")
    return fit(canvas, picture, (*at, *VIEW))


def _outline(
    canvas: np.ndarray,
    box: tuple[float, float, float, float],
    at: tuple[int, int],
    scale: float,
    colour: Colour,
) -> None:
    left, top, right, bottom = (round(scale * v) for v in box)
    corner, other = (at[0] + left - 1, at[1] + top - 1), (at[0] + right + 1, at[1] + bottom + 1)
    cv2.rectangle(canvas, corner, other, colour, 1, cv2.LINE_AA)


def _probability(
    canvas: np.ndarray,
    box: tuple[int, int, int, int],
    scene: Scene,
    infos: Sequence[Mapping[str, Any]],
    probabilities: Sequence[float],
) -> None:
    """p(crossing) over time above the label's shade, with the threshold and when the brake acts."""
    x, y, width, height = box
    text(canvas, "p(crossing)", (x, y - 22), 14, INK, bold=True)
    p = next((v for v in reversed(probabilities) if not math.isnan(v)), math.nan)
    told = "not yet: its window fills" if math.isnan(p) else f"{p:.2f}"
    text(canvas, told, (x + text_width("p(crossing)", 14, bold=True) + 10, y - 22), 14, AMBER, bold=True)
    text(canvas, "brake", (x + width, y - 21), 13, RED, align="right")
    text(
        canvas, "label: crossing    ", (x + width - text_width("brake", 13), y - 21), 13, GREEN, align="right"
    )
    canvas[y : y + height, x : x + width] = PANEL
    left, top, right, bottom = x + 34, y + 10, x + width - 10, y + height - 24

    def column(time_s: float) -> int:
        return left + round((right - left) * min(1.0, time_s / scene.duration_s))

    def row(value: float) -> int:
        return bottom - round((bottom - top) * value)

    for before, after in itertools.pairwise(infos):
        a, b = column(before["time_s"]), max(column(before["time_s"]) + 1, column(after["time_s"]))
        if before["crossing"]:
            canvas[top:bottom, a:b] = SHADE
        if after["demand_mps2"] < 0:
            canvas[bottom - 5 : bottom, a:b] = RED
    for value in (0.0, 0.5, 1.0):
        canvas[row(value), left:right] = (62, 67, 76)
        text(canvas, f"{value:g}", (left - 8, row(value) - 8), 12, DIM, align="right")
    for second in range(0, math.floor(scene.duration_s) + 1, max(1, round(scene.duration_s / 10))):
        words = f"{second} s" if second == 0 else f"{second}"
        text(canvas, words, (column(second), bottom + 4), 12, DIM, align="centre")
    at = row(scene.threshold)
    for a in range(left, right, 10):
        canvas[at, a : min(a + 5, right)] = AMBER
    points = [
        (column(info["time_s"]), row(value))
        for info, value in zip(infos, probabilities, strict=False)
        if not math.isnan(value)
    ]
    if points:
        cv2.polylines(canvas, [np.array(points, np.int32)], False, INK, 2, cv2.LINE_AA)
        cv2.circle(canvas, points[-1], 3, AMBER, -1, cv2.LINE_AA)


def _tiles(canvas: np.ndarray, box: tuple[int, int, int, int], info: Mapping[str, Any]) -> None:
    """Speed, brake, time to contact and distance."""
    x, y, width, height = box
    brake, colour = _brake(info)
    ttc, distance = info["ttc_s"], info["distance_m"]
    crossing = "crosses" if info["crossing"] else "none crosses"
    hidden = info["crossing"] and 0 <= info["visible_fraction"] < 0.05
    tiles = (
        ("speed", f"{3.6 * info['speed_mps']:.0f}", "km/h", INK),
        ("brake", brake, f"{info['acceleration_mps2']:+.1f} m/s²", colour),
        ("time to contact", f"{ttc:.1f}" if math.isfinite(ttc) else "–", "s", RED if ttc < 1.5 else INK),
        ("pedestrian", f"{distance:.0f} m" if math.isfinite(distance) else "–",
         "hidden" if hidden else crossing, AMBER if info["crossing"] else INK),
    )  # fmt: skip
    step = (width + GAP) // len(tiles)
    for k, (name, value, unit, ink) in enumerate(tiles):
        a = x + k * step
        canvas[y : y + height, a : a + step - GAP] = PANEL
        text(canvas, name, (a + 10, y + 8), 13, DIM)
        text(canvas, value, (a + 10, y + 28), 32 if len(value) < 5 else 22, ink, bold=True)
        text(canvas, unit, (a + 10, y + 74), 14, DIM)


def _brake(info: Mapping[str, Any]) -> tuple[str, Colour]:
    """What the brake does: the demand may be there before it acts."""
    if info["demand_mps2"] < 0 and info["speed_mps"] < 0.1:
        return "holds", RED
    if info["acceleration_mps2"] < -0.2:
        return "brakes", RED
    if info["demand_mps2"] < 0:
        return "builds up", AMBER
    return "open", GREEN


def _legend(canvas: np.ndarray) -> None:
    items = (
        ((20, 90, 200), "brighter (ON)"), ((205, 45, 40), "darker (OFF)"), (AMBER, "crossing pedestrian, threshold"),
        (DIM, "other pedestrians"), ((64, 132, 214), "ego, from above"), ((232, 120, 36), "pedestrians, from above"),
    )  # fmt: skip
    x = LEFT
    for colour, words in items:
        canvas[FOOT_Y + 5 : FOOT_Y + 15, x : x + 10] = colour
        text(canvas, words, (x + 16, FOOT_Y), 13, DIM)
        x += 16 + text_width(words, 13) + 2 * LEGEND_STEP


def _banner(canvas: np.ndarray, info: Mapping[str, Any]) -> None:
    """How it ended, across the middle of the two upper views."""
    outcome = Outcome(info["outcome"])
    words, colour = {
        Outcome.COLLISION: (f"collision at {3.6 * info['impact_speed_mps']:.0f} km/h", RED),
        Outcome.PASSED: ("passed, no contact", GREEN),
        Outcome.TIMEOUT: ("time is over, no contact", GREEN),
    }[outcome]
    width, height = text_width(words, 34, bold=True) + 64, 64
    x, y = LEFT + VIEW[0] + GAP // 2 - width // 2, ROWS[0] + VIEW[1] // 2 - height // 2
    canvas[y - 2 : y + height + 2, x - 2 : x + width + 2] = BACKGROUND
    canvas[y : y + height, x : x + width] = colour
    text(canvas, words, (x + width // 2, y + 10), 34, (255, 255, 255), bold=True, align="centre")
