"""Episodes as jobs that any process can play: what to play, and the pool that plays them."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any

import gymnasium

from agents import AebConfig, braking_policy, make_control
from eval.episodes import ControlSource, DetectorSource, Source, play, summarise_trace
from eval.verdicts import judge
from pedcross_env.config import EnvConfig
from pedcross_env.errors import DataError
from pedcross_env.scenario.suites import suite

__all__ = ["EnvFactory", "Job", "Loader", "make_env", "make_suite_env", "play_jobs"]

EnvFactory = Callable[[EnvConfig], gymnasium.Env[Any, Any]]
Loader = Callable[[str], Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One episode; small enough to be sent to a worker by the thousand."""

    name: str
    kind: str  # "detector" or "control"
    path: str  # of the checkpoint; empty for controls
    modality: str
    threshold: float
    main: bool  # False for the extra operating points
    weather: str
    seed: int
    aeb: AebConfig
    env: EnvConfig
    setup: str
    suite: str = ""  # where a cell of a suite is played
    cell: str = ""

    @property
    def key(self) -> tuple[Any, ...]:
        """What makes a row this job's and no other's."""
        return self.name, self.threshold, self.weather, self.seed, self.setup, self.cell


def make_env(config: EnvConfig) -> gymnasium.Env[Any, Any]:
    """The environment by its registered id, so that a worker needs no import of its own."""
    return gymnasium.make("pedcross_env:pedcross/Crossing-v0", config=config, disable_env_checker=True)


def make_suite_env(config: EnvConfig, suite: str) -> gymnasium.Env[Any, Any]:
    """The environment of a suite by its registered id."""
    return gymnasium.make(
        "pedcross_env:pedcross/Suite-v0", suite=suite, config=config, disable_env_checker=True
    )


class _Player:
    """Plays jobs, keeping the last environments and detectors it built."""

    def __init__(self, env_factory: EnvFactory, loader: Loader) -> None:
        self._env_factory, self._loader = env_factory, loader
        self._envs: dict[str, gymnasium.Env[Any, Any]] = {}
        self._detectors: dict[str, Any] = {}

    def __call__(self, job: Job) -> dict[str, Any]:
        env_key = job.suite + repr(job.env)
        if env_key not in self._envs:
            made = make_suite_env(job.env, job.suite) if job.suite else self._env_factory(job.env)
            self._envs[env_key] = made
        trace = play(
            self._envs[env_key], self._source(job), braking_policy(job.name, job.aeb), seed=job.seed,
            weather=job.weather, cell=job.cell,
        )  # fmt: skip
        row = {
            "detector": job.name,
            "kind": job.kind,
            "modality": job.modality,
            "threshold": job.threshold,
            "main": job.main,
            "weather": job.weather,
            "seed": job.seed,
            "setup": job.setup,
            "suite": job.suite,
            "cell": job.cell,
            **summarise_trace(trace),
        }
        if job.suite:
            row |= judge(suite(job.suite).cell(job.cell), row)
        return row

    def _source(self, job: Job) -> Source:
        if job.kind == "control":
            return ControlSource(make_control(job.name))
        if job.path not in self._detectors:
            self._detectors[job.path] = self._loader(job.path)
        return DetectorSource(self._detectors[job.path])


_player: _Player | None = None


def _start_worker(env_factory: EnvFactory, loader: Loader) -> None:
    global _player
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent stops the pool
    os.environ["OMP_NUM_THREADS"] = "1"  # workers share the cores: one thread each
    _one_torch_thread()
    _player = _Player(env_factory, loader)


def _one_torch_thread() -> None:
    import torch

    torch.set_num_threads(1)


def _play_in_worker(job: Job) -> dict[str, Any]:
    if _player is None:
        raise RuntimeError("the worker was not started by _start_worker.")
    return _player(job)


def play_jobs(
    jobs: Sequence[Job], workers: int, env_factory: EnvFactory, loader: Loader
) -> Iterator[dict[str, Any]]:
    """Play jobs and yield their rows as they finish, in any order.

    Args:
        jobs: What to play.
        workers: Processes; with 1 everything runs in this one.
        env_factory: Importable by name where there is more than one worker.
        loader: As ``env_factory``; builds a detector from a job's path.

    Raises:
        DataError: If a worker process dies.
    """
    if not jobs:
        return
    if workers == 1:
        player = _Player(env_factory, loader)
        for job in jobs:
            yield player(job)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        min(workers, len(jobs)), mp_context=context, initializer=_start_worker, initargs=(env_factory, loader)
    ) as pool:
        futures = [pool.submit(_play_in_worker, job) for job in jobs]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BrokenProcessPool as error:
            raise DataError(
                "a worker process died, most likely for lack of memory; "
                f"try --workers {max(1, workers // 2)}. "
                "What was finished is kept: the same command goes on from there."
            ) from error
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
