"""The environment that plays the cells of a suite."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from pedcross_env.config import EgoConfig, EnvConfig
from pedcross_env.env import CrossingEnv, View
from pedcross_env.scenario import Scenario, suites
from pedcross_env.scenario.suites import Cell
from pedcross_env.weather import Weather

__all__ = ["SuiteEnv"]


class SuiteEnv(CrossingEnv):
    """Play a cell of a suite, e.g. ``gymnasium.make("pedcross/Suite-v0", suite="fmvss-127", cell="PED-RIGHT-50/40")``.

    Observation, action, reward and ``info`` are those of CrossingEnv; ``info["scenario"]`` is the cell's id. A seed
    changes looks and sensor noise alone: houses, clothes, paint. Weather, headlights and load are the cell's, whatever
    the config says; the reset option ``weather`` overrides the weather. The reset option ``cell`` plays another cell of
    the suite once.

    Args:
        suite: Name of a suite; see ``pedcross_env.scenario.suites`` or ``pedcross suites``.
        cell: Id of a cell; None: the cell whose place in the suite is the episode's seed modulo their number.
        config: As CrossingEnv's.
        render_mode: As CrossingEnv's.
        view: As CrossingEnv's.

    Raises:
        ConfigError: For an unknown suite or cell; names the nearest.
    """

    OPTIONS = ("cell", "weather")

    def __init__(
        self,
        suite: str,
        cell: str | None = None,
        config: EnvConfig | Mapping[str, Any] | None = None,
        *,
        render_mode: str | None = None,
        view: View = "driver",
    ) -> None:
        self._suite = suites.suite(suite)
        self._fixed = None if cell is None else self._suite.cell(cell)
        self._cell = self._fixed if self._fixed is not None else self._suite.cells[0]
        super().__init__(config, render_mode=render_mode, view=view)

    @property
    def cell(self) -> Cell:
        """The cell of the running episode, the next one before the first."""
        return self._cell

    def _begin(self, options: Mapping[str, Any]) -> None:
        if options.get("cell") is not None:
            self._cell = self._suite.cell(options["cell"])
        elif self._fixed is not None:
            self._cell = self._fixed
        else:
            self._cell = self._suite.cells[self._episode_seed % len(self._suite.cells)]

    def _draw_scenario(self) -> Scenario:
        return self._cell.scenario(self.config.ego, seed=self._episode_seed)

    def _episode_ego(self) -> EgoConfig:
        cell, ego = self._cell, self.config.ego
        headlights = ego.headlights if cell.headlights == "auto" else cell.headlights
        load_kg = ego.load_kg if cell.load_kg is None else cell.load_kg
        return dataclasses.replace(ego, headlights=headlights, load_kg=load_kg)

    def _choose_weather(self, asked: object, rng: np.random.Generator) -> Weather:
        return super()._choose_weather(self._cell.weather if asked is None else asked, rng)
