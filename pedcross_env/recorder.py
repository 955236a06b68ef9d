"""Episodes to a dataset in the paper's layout, in parallel, resumable file by file.

    <root>/<subset>_<modality>/<video>/<frame>-<label>.<jpg|png>     images
    <root>/manifest/<subset>-<video>.parquet                         one row per frame, written last
    <root>/manifest.parquet                                          all of them together
    <root>/dataset.json                                              settings and versions

The layout is that of Sakhai et al. (Zenodo 10.5281/zenodo.11409259): RGB as JPG, DVS as PNG, the label in
the name. A video counts as recorded when its manifest and all files named there exist; anything less is
recorded again, and only the files that are missing are written.
"""

from __future__ import annotations

import dataclasses
import json
import multiprocessing
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pedcross_env import __version__
from pedcross_env.config import CameraConfig, DvsConfig, EnvConfig, TrafficConfig, require
from pedcross_env.contracts import INFO_KEYS, MODALITIES, Modality
from pedcross_env.errors import ConfigError, DataError, unknown_name
from pedcross_env.sensors.event_files import write_events
from pedcross_env.sensors.events import counts_to_png
from pedcross_env.source import source_digest
from pedcross_env.warmup import COMPILING, compile_kernels
from pedcross_env.weather import BAD_WEATHERS

__all__ = ["SUBSETS", "GenerateConfig", "GenerateReport", "generate", "recording_actions"]

SUBSETS: dict[str, tuple[str, ...]] = {"default": ("clear",), "weather": BAD_WEATHERS}
"""Subset to the weathers drawn for its videos; the paper's two."""

SUFFIX: dict[Modality, str] = {"rgb": "jpg", "dvs": "png"}
SEEDS_PER_SUBSET = 1_000_000
NOT_COMPARED = ("out", "workers", "videos")  # a dataset may grow, anywhere, by any number of processes


@dataclass(frozen=True, slots=True, kw_only=True)
class GenerateConfig:
    """Settings of ``pedcross generate``."""

    out: Path
    """Root of the dataset; an existing one with the same settings is completed."""
    videos: int = 20
    """Per subset."""
    subsets: tuple[str, ...] = ("default", "weather")
    modalities: tuple[Modality, ...] = MODALITIES
    seed: int = 0
    """Episode seeds are derived from it; no two subsets share one."""
    events: bool = False
    """Also write each video's raw events as npz."""
    event_causes: bool = False
    """Beside them, what made each event (an actor's id, a StaticClass or an EventCause) as <video>_causes.npy."""
    jpeg_quality: int = 92
    """Of the RGB images, 1 to 100; low ones add the artefacts of a compressed stream."""
    workers: int = 0
    """Processes; 0: one per core."""
    traffic: TrafficConfig = field(default_factory=TrafficConfig)
    camera: CameraConfig = field(default_factory=CameraConfig)
    dvs: DvsConfig = field(default_factory=lambda: DvsConfig(max_subframes=None))
    """Unlike while driving, its renders have no cap: the image never moves by more than a pixel between two."""

    def __post_init__(self) -> None:
        require(self.videos >= 1, "videos", self.videos, "1 or more")
        require(self.videos < SEEDS_PER_SUBSET, "videos", self.videos, f"below {SEEDS_PER_SUBSET}")
        require(len(self.subsets) > 0, "subsets", self.subsets, f"some of {', '.join(SUBSETS)}")
        require(len(self.modalities) > 0, "modalities", self.modalities, f"some of {', '.join(MODALITIES)}")
        require(
            not self.events or "dvs" in self.modalities,
            "events",
            self.events,
            "False unless 'dvs' is recorded",
        )
        require(
            not self.event_causes or self.events, "event_causes", True, "False unless events are recorded"
        )
        require(1 <= self.jpeg_quality <= 100, "jpeg_quality", self.jpeg_quality, "1 to 100")
        require(self.workers >= 0, "workers", self.workers, "0 or more")
        require(self.seed >= 0, "seed", self.seed, "0 or more")
        for subset in self.subsets:
            if subset not in SUBSETS:
                raise unknown_name("subset", subset, SUBSETS)


@dataclass(frozen=True, slots=True)
class GenerateReport:
    """What a call of ``generate`` did."""

    root: Path
    recorded: int
    already_there: int
    frames: int
    positive_frames: int


@dataclass(frozen=True, slots=True, kw_only=True)
class _Video:
    root: Path
    subset: str
    name: str
    seed: int
    weather: str

    @property
    def manifest(self) -> Path:
        return self.root / "manifest" / f"{self.subset}-{self.name}.parquet"

    def folder(self, modality: str) -> Path:
        return self.root / f"{self.subset}_{modality}" / self.name


def generate(
    config: GenerateConfig, progress: Callable[[int, int, str], None] = lambda done, total, what: None
) -> GenerateReport:
    """Record what is missing of the dataset.

    Args:
        config: Settings.
        progress: Called with (videos done, videos in all, name of the last) as they finish.

    Raises:
        ConfigError: If ``config.out`` cannot be written, or holds a dataset with other settings.
    """
    _prepare_root(config)
    videos = list(_videos(config))
    todo = [video for video in videos if not _is_complete(video)]
    progress(len(videos) - len(todo), len(videos), COMPILING if todo else "")
    if todo:
        compile_kernels()
    # Spawned workers see the same bytes as this process would: nothing is inherited but the arguments.
    context = multiprocessing.get_context("spawn")
    workers = min(config.workers or os.cpu_count() or 1, max(1, len(todo)))
    if todo:
        with ProcessPoolExecutor(workers, mp_context=context) as pool:
            futures = {pool.submit(_record, config, video): video for video in todo}
            try:
                for done, future in enumerate(as_completed(futures), start=len(videos) - len(todo) + 1):
                    future.result()
                    progress(done, len(videos), f"{futures[future].subset}/{futures[future].name}")
            except BaseException:
                pool.shutdown(wait=True, cancel_futures=True)
                raise
    table = pa.concat_tables([pq.read_table(video.manifest) for video in videos])
    _replace(config.out / "manifest.parquet", lambda path: pq.write_table(table, path))
    labels = table.column("crossing").to_numpy()
    return GenerateReport(config.out, len(todo), len(videos) - len(todo), len(labels), int(labels.sum()))


def recording_actions(seed: int, steps: int, policy_hz: int) -> np.ndarray:
    """How the ego drives while it is recorded: (steps,) actions in -1..1, blind to the scene.

    A driver who brakes for pedestrians would let a network read the label from the image motion; this one
    holds its speed, brakes and accelerates at random times, whether or not somebody crosses.
    """
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(11,)))
    actions = np.zeros(steps)
    begin = 0
    while begin < steps:
        length = max(1, int(rng.uniform(0.5, 3.0) * policy_hz))
        kind = rng.random()
        strength = -rng.uniform(0.1, 1.0) if kind < 0.25 else rng.uniform(0.1, 0.7) if kind < 0.45 else 0.0
        actions[begin : begin + length] = strength
        begin += length
    return actions


def _prepare_root(config: GenerateConfig) -> None:
    settings = {
        "format": 1,
        "version": __version__,
        "source": source_digest(),
        "settings": _plain({k: v for k, v in dataclasses.asdict(config).items() if k not in NOT_COMPARED}),
    }
    path = config.out / "dataset.json"
    try:
        (config.out / "manifest").mkdir(parents=True, exist_ok=True)
        if path.exists():
            existing = json.loads(path.read_text())
            if existing.get("settings") == settings["settings"] and existing != settings:
                raise ConfigError(
                    f"{config.out} holds a dataset made by other code of pedcross ({_difference(existing, settings)}): "
                    "what would be added may differ from its pictures; choose another folder or delete it."
                )
            if existing != settings:
                raise ConfigError(
                    f"{config.out} holds a dataset made with other settings ({_difference(existing, settings)}); "
                    "choose another folder, the same settings, or delete it."
                )
        else:
            _replace(path, lambda temporary: Path(temporary).write_text(json.dumps(settings, indent=1)))
    except OSError as error:
        raise ConfigError(
            f"out = {config.out} cannot be written ({error.strerror}); choose a writable folder."
        ) from error
    except json.JSONDecodeError as error:
        raise DataError(f"{path} is damaged ({error}); delete it to have it written again.") from error


def _difference(existing: Any, wanted: Any, at: str = "") -> str:
    if isinstance(existing, dict) and isinstance(wanted, dict):
        for key in sorted(existing.keys() | wanted.keys()):
            if existing.get(key) != wanted.get(key):
                return _difference(existing.get(key), wanted.get(key), f"{at}.{key}".lstrip("."))
    return f"{at}: {existing!r} there, {wanted!r} asked for"


def _plain(value: Any) -> Any:
    return json.loads(json.dumps(value, default=str))


def _videos(config: GenerateConfig) -> Iterator[_Video]:
    for subset in config.subsets:
        first = config.seed + SEEDS_PER_SUBSET * (1 + list(SUBSETS).index(subset))
        weathers = SUBSETS[subset]
        for index in range(config.videos):
            weather = weathers[index % len(weathers)]
            yield _Video(
                root=config.out,
                subset=subset,
                name=f"video_{index:04d}",
                seed=first + index,
                weather=weather,
            )


def _is_complete(video: _Video) -> bool:
    if not video.manifest.exists():
        return False
    try:
        table = pq.read_table(video.manifest)
    except (pa.ArrowInvalid, OSError):
        return False
    names = [column for column in (*MODALITIES, "events", "event_causes") if column in table.column_names]
    return all(
        (video.root / path).is_file() for name in names for path in set(table.column(name).to_pylist())
    )


def _record(config: GenerateConfig, video: _Video) -> None:
    """Play one episode and write the files that are missing, its manifest last."""
    from pedcross_env.env import CrossingEnv

    cv2.setNumThreads(1)
    env_config = EnvConfig(
        modalities=config.modalities,
        weather=(video.weather,),
        return_events=config.events,
        label_events=config.event_causes,
        traffic=config.traffic,
        camera=config.camera,
        dvs=config.dvs,
    )
    env = CrossingEnv(env_config)
    for modality in config.modalities:
        video.folder(modality).mkdir(parents=True, exist_ok=True)
        for leftover in video.folder(modality).glob(".*"):  # of a process killed while it wrote
            leftover.unlink()
    observation, info = env.reset(seed=video.seed)
    steps = int(config.traffic.duration_s * env_config.world.policy_hz) + 1
    actions = recording_actions(video.seed, steps, env_config.world.policy_hz)
    rows: list[dict[str, Any]] = []
    events: list[np.ndarray] = []
    causes: list[np.ndarray] = []
    for frame, action in enumerate(actions):
        observation, _, terminated, truncated, info = env.step(np.array([action], np.float32))
        rows.append(_write_frame(config, video, frame, observation, info))
        events.append(info.pop("events", np.empty(0)))
        causes.append(info.pop("event_causes", np.empty(0)))
        if terminated or truncated:
            break
    env.close()
    if config.events:
        path = video.root / f"{video.subset}_events" / f"{video.name}.npz"
        path.parent.mkdir(exist_ok=True)
        shape = config.camera.height_px, config.camera.width_px
        write_events(path, np.concatenate(events), shape=shape)
        if config.event_causes:
            beside = path.with_name(f"{video.name}_causes.npy")
            _replace(beside, lambda temporary: _save_array(temporary, np.concatenate(causes)))
            rows = [row | {"event_causes": str(beside.relative_to(video.root))} for row in rows]
        rows = [row | {"events": str(path.relative_to(video.root))} for row in rows]
    _replace(video.manifest, lambda temporary: pq.write_table(pa.Table.from_pylist(rows), temporary))


def _save_array(path: Path, array: np.ndarray) -> None:
    with path.open("wb") as file:  # np.save appends a suffix to names
        np.save(file, array)


def _write_frame(
    config: GenerateConfig,
    video: _Video,
    frame: int,
    observation: dict[str, np.ndarray],
    info: dict[str, Any],
) -> dict[str, Any]:
    row: dict[str, Any] = {
        "subset": video.subset,
        "video": video.name,
        "frame": frame,
        "version": __version__,
    }
    row |= {key: info[key] for key in INFO_KEYS}
    for modality in config.modalities:
        path = video.folder(modality) / f"{frame}-{info['crossing']}.{SUFFIX[modality]}"
        if not path.is_file():
            if modality == "rgb":
                image, options = observation["rgb"], [cv2.IMWRITE_JPEG_QUALITY, config.jpeg_quality]
            else:
                image, options = counts_to_png(observation["dvs"]), [cv2.IMWRITE_PNG_COMPRESSION, 3]
            ok, data = cv2.imencode(path.suffix, np.ascontiguousarray(image[..., ::-1]), options)
            if not ok:
                raise DataError(f"{path}: the image could not be encoded.")
            _replace(path, lambda temporary, data=data: Path(temporary).write_bytes(data.tobytes()))  # type: ignore[misc]
        row[modality] = str(path.relative_to(video.root))
    return row


def _replace(path: Path, write: Callable[[Any], object]) -> None:
    """Write a file so that it is there whole or not at all, whenever the process is stopped."""
    temporary = path.with_name(f".{os.getpid()}-{path.name}")
    try:
        write(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
