"""What random crossings are like, measured on the world itself and set beside JAAD's."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from eval import jaad
from eval.jaad import Video, read_videos
from eval.store import prepare_folder
from pedcross_env.config import (
    CAMERA_PRESETS,
    EgoConfig,
    LabelConfig,
    TrafficConfig,
    WorldConfig,
    camera_preset,
    require,
)
from pedcross_env.contracts import Outcome
from pedcross_env.errors import unknown_name
from pedcross_env.scenario.layout import carriageway_m
from pedcross_env.scenario.sampler import sample_crossing
from pedcross_env.world import World

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Measured", "ScenariosConfig", "compare", "draw_histograms", "measure", "run_scenarios"]

DRY_FRICTION = 0.85
BEFORE_S = 1.0  # before a crossing begins, as JAAD looks at who looks and stands
LOOKS_RAD = 0.35  # a head turned by more looks for traffic
STANDS_MPS = 0.1
STEPPED_OUT_M = 0.1  # farther from the kerb a crossing began before
PERCENTILES = (5, 50, 95)


@dataclass(frozen=True, slots=True, kw_only=True)
class ScenariosConfig:
    """Settings of ``pedcross scenarios``."""

    out: Path = Path("out/scenarios")
    """scenarios.png goes there."""
    episodes: int = 200
    seed: int = 0
    """Of the first episode."""
    camera: str = "pie"
    """Preset in whose picture boxes are measured; "pie" is a dashcam much as JAAD's."""
    jaad: Path | None = None
    """JAAD's folder of annotations, to measure those too."""
    traffic: TrafficConfig = dataclasses.field(default_factory=TrafficConfig)

    def __post_init__(self) -> None:
        require(self.episodes >= 1, "episodes", self.episodes, "1 or more")
        require(self.seed >= 0, "seed", self.seed, "0 or more")
        if self.camera not in CAMERA_PRESETS:
            raise unknown_name("camera preset", self.camera, CAMERA_PRESETS)


@dataclass(frozen=True, slots=True)
class Measured:
    """Figures of many episodes with an ego that holds its speed; arrays have one entry per episode or onset.

    Attributes:
        positive_share: (E,) of the frames of each episode.
        hit: (E,) whether the ego hit somebody.
        onset_ttc_s: (O,) until the ego's front is at who begins to cross in view.
        onset_distance_m: (O,).
        onset_height_px: (O,) height of its box, of 1080 rows.
        looking: (O,) whether it turned its head in the second before.
        standing: (O,) whether it stood then.
        crossing_s: (C,) how long full crossings take from kerb to kerb.
    """

    positive_share: np.ndarray
    hit: np.ndarray
    onset_ttc_s: np.ndarray
    onset_distance_m: np.ndarray
    onset_height_px: np.ndarray
    looking: np.ndarray
    standing: np.ndarray
    crossing_s: np.ndarray


def measure(config: ScenariosConfig, progress: Callable[[int, int, str], None] | None = None) -> Measured:
    """Drive the episodes without braking and without cameras."""
    camera, ego = camera_preset(config.camera), EgoConfig()
    scale_px = camera.focal_px * 1080.0 / camera.height_px
    rows: dict[str, list[float]] = {field.name: [] for field in dataclasses.fields(Measured)}
    for k in range(config.episodes):
        scenario = sample_crossing(config.seed + k, config.traffic, ego)
        world = World(
            scenario, ego=ego, world=WorldConfig(), label=LabelConfig(), friction=DRY_FRICTION, camera=camera
        )
        _drive(world, scale_px, camera.mount_x_m, rows)
        if progress is not None:
            progress(k + 1, config.episodes, scenario.name)
    return Measured(**{name: np.array(values, dtype=np.float64) for name, values in rows.items()})


def _drive(world: World, scale_px: float, mount_x_m: float, rows: dict[str, list[float]]) -> None:
    frames = positive = 0
    crossing: set[int] = set()
    recent: list[np.ndarray] = []
    step_s, street = 1.0 / WorldConfig().policy_hz, world.scenario.street
    while world.outcome is Outcome.RUNNING:
        world.step(0.0)
        now, shot = set(world.crossing_ids()), world.snapshot(world.time_s)
        for ident in sorted(now - crossing):
            index = int(np.flatnonzero(shot.actors["id"] == ident)[0])
            person = shot.actors[index]
            dx, dy = (float(person[k] - shot.ego[k]) for k in ("x", "y"))
            heading = float(shot.ego["yaw"])
            along = dx * math.cos(heading) + dy * math.sin(heading)
            gap = max(0.0, along - 0.5 * float(shot.ego["length"]))
            before = recent[-1][index] if recent else person
            begins = frames > 0 and float(carriageway_m(street, before["x"], before["y"])) <= STEPPED_OUT_M
            if begins:  # who comes into the label's range already crossing began unseen
                rows["onset_ttc_s"].append(gap / max(world.ego.speed_mps, 0.1))
                rows["onset_distance_m"].append(gap)
                rows["onset_height_px"].append(
                    scale_px * float(person["height"]) / max(along - mount_x_m, 1.0)
                )
                past = np.array([actors[index] for actors in recent])
                rows["looking"].append(float((np.abs(past["head_yaw"]) > LOOKS_RAD).any()))
                rows["standing"].append(float((past["speed"] < STANDS_MPS).any()))
        crossing |= now
        recent = [*recent[-round(BEFORE_S / step_s) + 1 :], shot.actors]
        frames, positive = frames + 1, positive + bool(now)
    rows["positive_share"].append(positive / frames)
    rows["hit"].append(float(world.outcome is Outcome.COLLISION))
    rows["crossing_s"].extend(world.full_crossings_s())


Row = tuple[str, str, str, str]


def compare(measured: Measured, videos: list[Video] | None = None) -> list[Row]:
    """Rows of a table: what, ours, JAAD as published, the JAAD files at hand."""
    ours, crossed = measured, measured.positive_share > 0
    heights = np.array([h for video in videos or () for h in video.onset_heights_px])
    shares = np.array([len(v.positive) / v.frames for v in videos or ()])
    published = "/".join(f"{v:.0f}" for v in jaad.ONSET_HEIGHT_PX)
    rows: list[Row] = [
        ("episodes, videos", f"{len(crossed)}", "346", f"{len(shares)}"),
        ("with a crossing", _mean(crossed), f"{jaad.POSITIVE_VIDEOS:.0%}", _mean(shares > 0)),
        ("positive frames", _mean(ours.positive_share), "", _mean(shares)),
        ("  of those with a crossing", _mean(ours.positive_share[crossed]), "", _mean(shares[shares > 0])),
        ("box at onset, px of 1080", _spread(ours.onset_height_px, 0), published, _spread(heights, 0)),
        ("time to contact at onset, s", _spread(ours.onset_ttc_s, 1), "", ""),
        ("distance at onset, m", _spread(ours.onset_distance_m, 0), "", ""),
        ("looks in the second before", _mean(ours.looking), f"{jaad.LOOKING:.0%}", ""),
        ("stands in the second before", _mean(ours.standing), f"{jaad.STANDING:.0%}", ""),
        ("full crossing, s", _spread(ours.crossing_s, 1), f"-/{jaad.CROSSING_S}/-", ""),
        ("hit by who never brakes", _mean(ours.hit), "", ""),
    ]  # fmt: skip
    return rows if videos else [(*row[:3], "") for row in rows]


def _mean(values: np.ndarray) -> str:
    return f"{values.mean():.0%}" if len(values) else "none"


def _spread(values: np.ndarray, digits: int) -> str:
    """5th percentile, median, 95th."""
    if not len(values):
        return "none"
    return "/".join(f"{v:.{digits}f}" for v in np.percentile(values, PERCENTILES))


def draw_histograms(measured: Measured, out: Path) -> Path:
    """Write scenarios.png: times, heights and shares, with JAAD's range where it is known."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    prepare_folder(out)
    figure = Figure(figsize=(11.0, 3.4), layout="constrained", dpi=120)
    FigureCanvasAgg(figure)
    ttc, height, share = figure.subplots(1, 3)
    _histogram(ttc, measured.onset_ttc_s, "time to contact at onset, s", np.arange(0.0, 8.1, 0.5))
    _histogram(
        height, measured.onset_height_px, "box height at onset, px of 1080", np.arange(0.0, 640.1, 40.0)
    )
    low, middle, high = jaad.ONSET_HEIGHT_PX
    height.axvspan(low, high, color="tab:orange", alpha=0.15, label="JAAD, 5 to 95 %")
    height.axvline(middle, color="tab:orange", label="JAAD, median")
    height.legend(frameon=False, fontsize=8)
    crossing = measured.positive_share[measured.positive_share > 0]
    _histogram(share, crossing, "positive frames, where somebody crosses", np.arange(0.0, 1.01, 0.1))
    share.set_ylabel("episodes")
    path = out / "scenarios.png"
    figure.savefig(path)
    return path


def _histogram(axes: Axes, values: np.ndarray, label: str, bins: np.ndarray) -> None:
    axes.hist(np.clip(values, bins[0], bins[-1]), bins=list(bins), color="tab:blue", alpha=0.8)
    axes.set_xlabel(label)
    axes.set_ylabel("onsets")
    axes.spines[["top", "right"]].set_visible(False)


def run_scenarios(
    config: ScenariosConfig, progress: Callable[[int, int, str], None] | None = None
) -> tuple[list[Row], Path]:
    """Measure, compare and draw; returns the table's rows and the figure."""
    videos = read_videos(config.jaad) if config.jaad is not None else None
    measured = measure(config, progress)
    return compare(measured, videos), draw_histograms(measured, config.out)
