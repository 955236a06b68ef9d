"""Which seeds to play: all as they come, or those where braking decides the outcome."""

from __future__ import annotations

from dataclasses import replace

from agents import AebPolicy, make_control
from eval.episodes import ControlSource, play, summarise_trace
from eval.jobs import EnvFactory
from pedcross_env.config import EnvConfig
from pedcross_env.errors import ConfigError

__all__ = ["decisive_seeds"]

SEARCHED_PER_EPISODE = 50


def decisive_seeds(
    config: EnvConfig, weather: str, *, first: int, hit: int, free: int, env_factory: EnvFactory
) -> tuple[int, ...]:
    """The first seeds whose crossing hits an ego that never brakes, and the first in which nobody crosses.

    No detector takes part in the choice, and no camera: a seed takes some milliseconds. Crossings that a steady ego
    misses anyway are passed over: on them every detector scores alike, however bad.

    Args:
        config: Of the environment; its modalities are not rendered.
        weather: In which the ego is tried; crossings are the same in every other.
        first: The lowest seed.
        hit: How many crossings that end in a collision.
        free: How many drives without a crossing.
        env_factory: Builds the environment.

    Returns:
        (hit + free,) seeds, ascending.

    Raises:
        ConfigError: Where 50 seeds for each one wanted have too few of either.
    """
    env = env_factory(replace(config, modalities=()))
    source, policy = ControlSource(make_control("never")), AebPolicy()
    crossings: list[int] = []
    empty: list[int] = []
    seeds = range(first, first + SEARCHED_PER_EPISODE * (hit + free))
    for seed in seeds:
        if len(crossings) == hit and len(empty) == free:
            break
        row = summarise_trace(play(env, source, policy, seed=seed, weather=weather))
        if row["is_crossing"] and row["collision"] and len(crossings) < hit:
            crossings.append(seed)
        elif not row["is_crossing"] and len(empty) < free:
            empty.append(seed)
    env.close()
    if len(crossings) < hit or len(empty) < free:
        raise ConfigError(
            f"of the seeds {seeds[0]} to {seeds[-1]}, {len(crossings)} have a crossing that hits an ego which never "
            f"brakes and {len(empty)} nobody who crosses; {hit} and {free} are asked for. Ask for fewer, or change "
            "traffic.crossing_share."
        )
    return tuple(sorted(crossings + empty))
