"""What resizing does to event frames: the decimation appendix of the paper, drawn and counted.

The paper shrank its DVS pictures to 450x256 by interpolation and found the pedestrian hard to see afterwards, whatever
the method. Here the same is done to a picture of ours, beside giving the events themselves the coarse addresses
("events"). Source: Sakhai et al., appendix "A note on DVS frames decimation".
"""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from eval.samples import find_moment
from eval.store import prepare_folder
from pedcross_env.config import CameraConfig, EnvConfig, camera_preset, require
from pedcross_env.contracts import ActorKind
from pedcross_env.env import CrossingEnv
from pedcross_env.errors import DataError
from pedcross_env.sensors.events import carla_image
from pedcross_env.sensors.resizing import nearest, rescale_events
from pedcross_env.weather import as_weather

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["METHODS", "DecimationConfig", "Loss", "Original", "decimate", "measure_loss", "run_decimation"]

Shape = tuple[int, int]
SETTLING_STEPS = 4
HALF = 128
"""A polarity weaker than half of full colour counts as lost: a network may still see it, an eye does not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DecimationConfig:
    """Settings of ``pedcross decimation``."""

    out: Path = Path("out/decimation")
    """decimation.png and decimation.csv go there."""
    weather: str = "rain"
    seed: int = 0
    """The first of 60 episodes that are searched for a crossing nearby."""
    width_px: int = 450
    height_px: int = 256
    camera: CameraConfig = dataclasses.field(default_factory=lambda: camera_preset("carla"))
    """Of the original: the paper's were recorded at 1600x600."""

    def __post_init__(self) -> None:
        as_weather(self.weather)
        require(self.seed >= 0, "seed", self.seed, "0 or more")
        require(
            1 <= self.width_px <= self.camera.width_px,
            "width_px",
            self.width_px,
            f"1 to {self.camera.width_px}",
        )
        require(
            1 <= self.height_px <= self.camera.height_px,
            "height_px",
            self.height_px,
            f"1 to {self.camera.height_px}",
        )


@dataclass(frozen=True, slots=True)
class Original:
    """A picture before it is resized.

    Attributes:
        events: (N,) EVENT_DTYPE of one policy step.
        picture: (H, W, 3) uint8 RGB, CARLA's picture of them.
        pedestrian: (H, W) bool, where pedestrians are seen at the end of the step.
        title: What it shows.
    """

    events: np.ndarray
    picture: np.ndarray
    pedestrian: np.ndarray
    title: str


@dataclass(frozen=True, slots=True)
class Loss:
    """What a method left of the original.

    Attributes:
        method: Its name.
        kept: Share of the original's active pixels whose polarity the pixel now in their place shows at half of full
            colour or more.
        pedestrian_kept: The same of those on pedestrians; nan where there are none.
        active: Pixels of the result that are not black.
        invalid: Share of them that show no polarity: fainter than half, or both at once.
        strength: Their mean brightness, 1 for full colour.
    """

    method: str
    kept: float
    pedestrian_kept: float
    active: int
    invalid: float
    strength: float


def _interpolated(flag: int) -> Callable[[Original, Shape], np.ndarray]:
    def resize(original: Original, shape: Shape) -> np.ndarray:
        return np.asarray(cv2.resize(original.picture, shape[::-1], interpolation=flag))

    return resize


METHODS: Mapping[str, Callable[[Original, Shape], np.ndarray]] = MappingProxyType(
    {
        "nearest": lambda original, shape: nearest(original.picture, shape, axes=(0, 1)),
        "bilinear": _interpolated(cv2.INTER_LINEAR),
        "area": _interpolated(cv2.INTER_AREA),
        "bicubic": _interpolated(cv2.INTER_CUBIC),
        "events": lambda original, shape: carla_image(
            rescale_events(original.events, original.pedestrian.shape, shape), shape
        ),
    }
)
"""Name to function of (original, (height, width)) giving an (h, w, 3) uint8 picture."""


def decimate(original: Original, shape: Shape) -> dict[str, np.ndarray]:
    """The original by every method, name to (h, w, 3) uint8."""
    return {name: method(original, shape) for name, method in METHODS.items()}


def measure_loss(original: Original, name: str, small: np.ndarray) -> Loss:
    """Hold a smaller picture against the original, see Loss."""
    source, target = original.picture.shape, small.shape
    rows, columns = np.nonzero(original.picture.any(axis=2))
    channel = np.where(original.picture[rows, columns, 2] > 0, 2, 0)
    shown = small[rows * target[0] // source[0], columns * target[1] // source[1], channel] >= HALF
    on_pedestrian = original.pedestrian[rows, columns]
    strongest = small.max(axis=2)
    active = strongest > 0
    weaker = np.minimum(small[..., 0], small[..., 2])
    return Loss(
        method=name,
        kept=_mean(shown),
        pedestrian_kept=_mean(shown[on_pedestrian]),
        active=int(active.sum()),
        invalid=_mean((strongest < HALF)[active] | (weaker > 0)[active]),
        strength=_mean(strongest[active] / 255.0),
    )


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if values.size else float("nan")


def capture(config: DecimationConfig) -> Original:
    """Record the original: the first moment at which a pedestrian crosses 8 to 13 m ahead.

    Raises:
        DataError: Where none of 60 episodes has such a moment.
    """
    env_config = EnvConfig(
        modalities=("dvs",), weather=(config.weather,), return_events=True, camera=config.camera
    )
    moment = find_moment(env_config, config.weather, config.seed, CrossingEnv)
    if moment is None:
        raise DataError(
            f"no pedestrian crosses nearby in the 60 episodes from seed {config.seed}; try another seed."
        )
    seed, steps = moment
    env = CrossingEnv(env_config)
    env.reset(seed=seed)
    for _ in range(steps - SETTLING_STEPS):
        env.world.step(0.0)  # the camera stays shut: nothing is rendered
    for _ in range(min(steps, SETTLING_STEPS)):
        *_, info = env.step(np.zeros(1, np.float32))
    truth = env.truth()
    actors = env.world.snapshot(env.world.time_s).actors
    people = actors["id"][actors["kind"] == ActorKind.PEDESTRIAN]
    shape = config.camera.height_px, config.camera.width_px
    return Original(
        events=info["events"],
        picture=carla_image(info["events"], shape),
        pedestrian=np.isin(truth.instance, people),
        title=f"{config.weather}, episode {seed}, {info['distance_m']:.0f} m ahead",
    )


def run_decimation(config: DecimationConfig) -> tuple[Original, list[Loss]]:
    """Capture, decimate, measure; write ``decimation.png`` and ``decimation.csv`` to ``config.out``."""
    prepare_folder(config.out)
    original = capture(config)
    pictures = decimate(original, (config.height_px, config.width_px))
    losses = [measure_loss(original, name, picture) for name, picture in pictures.items()]
    _draw(original, pictures, losses, config.out / "decimation.png")
    with (config.out / "decimation.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [field.name for field in dataclasses.fields(Loss)])
        writer.writeheader()
        writer.writerows(dataclasses.asdict(loss) for loss in losses)
    return original, losses


def _draw(original: Original, pictures: Mapping[str, np.ndarray], losses: list[Loss], path: Path) -> None:
    """The original on top; below, each method whole and close up around the pedestrians."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(16, 11.5), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    columns = len(pictures)
    grid = figure.add_gridspec(3, columns, height_ratios=(2.1, 0.72, 1.25))
    height, width = original.picture.shape[:2]
    box = _close_up(original.pedestrian)
    top, left, bottom, right = box
    whole = figure.add_subplot(grid[0, : columns - 1])
    _show(whole, original.picture, f"original, {width}x{height}: {original.events.size:,} events")
    whole.add_patch(_frame(left, top, right - left, bottom - top))
    crop = original.picture[top:bottom, left:right]
    _show(figure.add_subplot(grid[0, columns - 1]), crop, "original, close up")
    for k, ((name, small), loss) in enumerate(zip(pictures.items(), losses, strict=True)):
        scale = small.shape[0] / height, small.shape[1] / width
        rows = slice(int(top * scale[0]), max(int(top * scale[0]) + 1, int(bottom * scale[0])))
        cols = slice(int(left * scale[1]), max(int(left * scale[1]) + 1, int(right * scale[1])))
        title = "events given coarse addresses" if name == "events" else name
        _show(
            figure.add_subplot(grid[1, k]),
            small,
            f"{title}, {small.shape[1]}x{small.shape[0]}",
            width / height,
        )
        text = (
            f"kept: {100 * loss.kept:.0f} % of events' pixels,\n{100 * loss.pedestrian_kept:.0f} % on pedestrians\n"
            f"no valid colour: {100 * loss.invalid:.0f} %"
        )
        _show(figure.add_subplot(grid[2, k]), small[rows, cols], text, (right - left) / (bottom - top))
    figure.suptitle(f"Decimation of an event frame ({original.title}); ON blue, OFF red", fontsize=15)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def _show(axis: Axes, picture: np.ndarray, title: str, aspect: float | None = None) -> None:
    """Show pixels as they are; ``aspect`` (width : height) undoes what non-square decimation squeezed."""
    ratio: Any = "equal" if aspect is None else picture.shape[1] / picture.shape[0] / aspect
    axis.imshow(picture, interpolation="nearest", aspect=ratio)
    axis.set_title(title, fontsize=11)
    axis.set_axis_off()


def _frame(x: int, y: int, width: int, height: int) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((x, y), width, height, fill=False, edgecolor="yellow", linewidth=1.2)


def _close_up(mask: np.ndarray) -> tuple[int, int, int, int]:
    """(top, left, bottom, right) around the largest group of a mask, with a margin; the middle where it is empty."""
    height, width = mask.shape
    count, _, boxes, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    if count > 1:
        left, top, w, h, _ = boxes[1 + int(np.argmax(boxes[1:, 4]))]
    else:
        left, top, w, h = width // 3, height // 3, width // 3, height // 3
    margin = max(4, h // 4)
    return (
        max(0, int(top) - margin), max(0, int(left) - margin),
        min(height, int(top + h) + margin), min(width, int(left + w) + margin),
    )  # fmt: skip
