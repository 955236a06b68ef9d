"""Every detector and every control on the same seeded episodes, in parallel, completed where stopped."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from agents import CONTROLS, AebConfig, make_control
from eval.cameras import COMPACT_CAMERA
from eval.detectors import DetectorSpec, load_detector, resolve_detectors
from eval.jobs import EnvFactory, Job, Loader, make_env, play_jobs
from eval.provenance import provenance
from eval.seeds import decisive_seeds
from eval.store import RowLog, prepare_folder, write_json, write_rows
from pedcross_env.config import CameraConfig, EgoConfig, EnvConfig, LabelConfig, TrafficConfig, require
from pedcross_env.contracts import Modality
from pedcross_env.errors import unknown_name
from pedcross_env.scenario.suites import Cell, suite
from pedcross_env.source import source_digest
from pedcross_env.warmup import COMPILING, compile_kernels

__all__ = ["EvaluateConfig", "EvaluateReport", "check_weathers", "evaluate"]

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class EvaluateConfig:
    """Settings of ``pedcross evaluate``: drive each detector through the same crossings."""

    out: Path
    """Results folder; a run that was stopped is completed there."""
    detectors: tuple[str, ...] = ()
    """Names of shipped checkpoints or paths; empty: all shipped ones."""
    controls: tuple[str, ...] = tuple(CONTROLS)
    """References without a network."""
    weathers: tuple[str, ...] = ("clear", "rain", "storm", "fog")
    """Each seed is played in each of them: the same crossing, another weather."""
    episodes: int = 20
    """Seeds per weather."""
    hit_share: float | None = None
    """Of the episodes, this share are crossings that hit an ego which never brakes, the others drives without a
    crossing; the seeds between are passed over. Not given: every seed from the first one on, whatever it holds."""
    suite: str = ""
    """Play the cells of this suite instead of random crossings; ``pedcross suites`` lists them."""
    cells: tuple[str, ...] = ("*",)
    """Which of its cells: ids or patterns such as "CPNA-*/night"."""
    cell_seeds: int = 1
    """Seeds per cell: they change looks alone."""
    seed: int = 0
    """First episode seed; recorded datasets begin at one million."""
    threshold: float | None = None
    """When detectors brake; not given: the braking threshold stored with each checkpoint."""
    extra_thresholds: tuple[float, ...] = ()
    """Further operating points for every detector, for the curve of collisions against false braking."""
    workers: int = 0
    """Processes; 0: one per core, 1: none beside this one."""
    aeb: AebConfig = field(default_factory=AebConfig)
    """Its threshold is replaced by the detector's."""
    traffic: TrafficConfig = field(default_factory=TrafficConfig)
    camera: CameraConfig = COMPACT_CAMERA
    """The one that the detectors were trained with; default: the shipped networks'."""
    ego: EgoConfig = field(default_factory=EgoConfig)
    label: LabelConfig = field(default_factory=LabelConfig)

    def __post_init__(self) -> None:
        require(self.episodes >= 1, "episodes", self.episodes, "1 or more")
        require(self.seed >= 0, "seed", self.seed, "0 or more")
        require(self.workers >= 0, "workers", self.workers, "0 or more")
        require(len(self.weathers) > 0, "weathers", self.weathers, "at least one preset")
        for name in ("weathers", "controls", "detectors"):
            values = getattr(self, name)
            require(len(set(values)) == len(values), name, values, "without repeats")
        for control in self.controls:
            if control not in CONTROLS:
                raise unknown_name("control", control, CONTROLS)
        require(self.cell_seeds >= 1, "cell_seeds", self.cell_seeds, "1 or more")
        require(bool(self.suite) or self.cells == ("*",), "cells", self.cells, "given with a suite only")
        self.chosen_cells()
        if self.hit_share is not None:
            require(0 <= self.hit_share <= 1, "hit_share", self.hit_share, "0 to 1")
            require(not self.suite, "hit_share", self.hit_share, "given without a suite only")
        for value in (*self.extra_thresholds, *([] if self.threshold is None else [self.threshold])):
            require(0 < value <= 1, "threshold", value, "above 0, at most 1")

    def chosen_cells(self) -> tuple[Cell, ...]:
        """Return the suite's cells that are asked for, in its order; none without a suite.

        Raises:
            ConfigError: For an unknown suite, or a pattern that no cell fits; names the nearest.
        """
        if not self.suite:
            return ()
        own = suite(self.suite)
        for pattern in self.cells:
            if not any(fnmatchcase(cell.id, pattern) for cell in own.cells):
                own.cell(pattern)
        return tuple(c for c in own.cells if any(fnmatchcase(c.id, pattern) for pattern in self.cells))


@dataclass(frozen=True, slots=True)
class EvaluateReport:
    """What a call of ``evaluate`` did; ``rows`` are all rows of this evaluation, old and new."""

    rows: list[dict[str, Any]]
    played: int
    already_there: int
    other_setups: int


def evaluate(
    config: EvaluateConfig,
    progress: Progress = lambda done, total, what: None,
    *,
    specs: Sequence[DetectorSpec] | None = None,
    env_factory: EnvFactory = make_env,
    loader: Loader = load_detector,
) -> EvaluateReport:
    """Play what is missing and write ``episodes.parquet`` and ``evaluate.json`` to ``config.out``.

    Args:
        config: Settings.
        progress: Called with (episodes done, in all, what was last).
        specs: Detectors, where they are no checkpoints; default: resolved from ``config.detectors``.
        env_factory: Builds an environment; must be importable by name for more than one worker.
        loader: Builds a detector from ``DetectorSpec.path``; as ``env_factory``.

    Returns:
        The rows; rows in the folder that came from another setup (weights, thresholds, camera, ...) stay in
        the log but are neither used nor returned.

    Raises:
        ConfigError: For unknown names or a folder that cannot be written.
        DataError: For a damaged log, or a worker that died.
    """
    if env_factory is make_env:
        check_weathers(config.weathers)
    specs = resolve_detectors(config.detectors) if specs is None else list(specs)
    prepare_folder(config.out)
    seeds = _seeds(config, env_factory)
    jobs = list(_jobs(config, specs, seeds))
    log = RowLog(config.out / "episodes.jsonl")
    wanted = {job.key for job in jobs}
    stored = log.read()
    rows = {_row_key(row): row for row in stored if _row_key(row) in wanted}
    log.rewrite(stored)
    todo = [job for job in jobs if job.key not in rows]
    already = len(rows)
    compiles = env_factory is make_env and any(job.env.modalities for job in todo)
    progress(already, len(jobs), COMPILING if compiles else "")
    if compiles:  # once here, not once in every worker
        compile_kernels()
    for row in play_jobs(todo, config.workers or os.cpu_count() or 1, env_factory, loader):
        log.append(row)
        rows[_row_key(row)] = row
        what = row["cell"] or row["weather"]
        progress(len(rows), len(jobs), f"{row['detector']}, {what}, seed {row['seed']}")
    ordered = [rows[job.key] for job in jobs]
    write_rows(config.out / "episodes.parquet", ordered)
    write_json(config.out / "evaluate.json", _provenance(config, specs) | {"seeds": list(seeds)})
    return EvaluateReport(ordered, len(todo), already, len(stored) - already)


def check_weathers(names: Sequence[str]) -> None:
    """Raise ConfigError for a weather that is not known."""
    from pedcross_env.weather import weather_by_name

    for name in names:
        weather_by_name(name)


def _seeds(config: EvaluateConfig, env_factory: EnvFactory) -> tuple[int, ...]:
    """The episodes' seeds, the same in every weather and for every source; none of a suite."""
    if config.suite:
        return ()
    if config.hit_share is None:
        return tuple(range(config.seed, config.seed + config.episodes))
    hit = round(config.hit_share * config.episodes)
    return decisive_seeds(
        _env_config(config, ()), config.weathers[0], first=config.seed, hit=hit, free=config.episodes - hit,
        env_factory=env_factory,
    )  # fmt: skip


def _env_config(config: EvaluateConfig, modalities: tuple[Modality, ...]) -> EnvConfig:
    return EnvConfig(
        modalities=modalities, weather=config.weathers[:1], camera=config.camera, ego=config.ego,
        traffic=config.traffic, label=config.label,
    )  # fmt: skip


def _jobs(config: EvaluateConfig, specs: Sequence[DetectorSpec], seeds: Sequence[int]) -> Iterator[Job]:
    """Controls first: they are quick and everything is read against them."""
    for name in config.controls:
        spec = DetectorSpec(
            name=name, path="", modality="none", threshold=make_control(name).threshold,
            braking_threshold=make_control(name).threshold, fingerprint=name,
        )  # fmt: skip
        yield from _episodes(config, spec, seeds, "control", spec.braking_threshold, main=True)
    for spec in specs:
        main = config.threshold if config.threshold is not None else spec.braking_threshold
        for threshold in dict.fromkeys((main, *config.extra_thresholds)):
            yield from _episodes(config, spec, seeds, "detector", threshold, main=threshold == main)


def _episodes(
    config: EvaluateConfig,
    spec: DetectorSpec,
    seeds: Sequence[int],
    kind: str,
    threshold: float,
    *,
    main: bool,
) -> Iterator[Job]:
    aeb = dataclasses.replace(config.aeb, threshold=threshold)
    modalities: Any = () if kind == "control" else (spec.modality,)
    env = _env_config(config, modalities)
    # The weather is given with each reset, so the config's own plays no part in what a row depends on.
    facts = [
        source_digest("pedcross_env", "perception", "agents"),
        spec.fingerprint,
        dataclasses.asdict(aeb),
        dataclasses.asdict(env) | {"weather": None},
    ]
    if config.suite:
        facts.append([config.suite, suite(config.suite).version])
    setup = hashlib.sha256(json.dumps(facts, sort_keys=True, default=str).encode()).hexdigest()[:16]
    for cell in config.chosen_cells():
        for seed in range(config.seed, config.seed + config.cell_seeds):
            yield Job(
                name=spec.name, kind=kind, path=spec.path, modality=spec.modality, threshold=threshold,
                main=main, weather=cell.weather, seed=seed, aeb=aeb, env=env, setup=setup, suite=config.suite,
                cell=cell.id,
            )  # fmt: skip
    for weather in () if config.suite else config.weathers:
        for seed in seeds:
            yield Job(
                name=spec.name, kind=kind, path=spec.path, modality=spec.modality, threshold=threshold,
                main=main, weather=weather, seed=seed, aeb=aeb, env=env, setup=setup,
            )  # fmt: skip


def _row_key(row: dict[str, Any]) -> tuple[Any, ...]:
    return row["detector"], row["threshold"], row["weather"], row["seed"], row["setup"], row.get("cell", "")


def _provenance(config: EvaluateConfig, specs: Sequence[DetectorSpec]) -> dict[str, Any]:
    settings = json.loads(json.dumps(dataclasses.asdict(config), default=str))
    return provenance() | {
        "settings": settings,
        "controls": {name: make_control(name).note for name in config.controls},
        "detectors": [dataclasses.asdict(spec) for spec in specs],
    }
