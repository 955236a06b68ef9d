"""The page on the event camera: its code runs as printed, its names and figures are those of the package."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.sensors.dvs_config import DVS_MODELS, DVS_PRESETS

PAGE = (Path(__file__).parents[2] / "docs" / "event-camera.md").read_text(encoding="utf-8")


def test_the_pages_code_runs_as_printed(capsys) -> None:
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(block, names)
    events, signal = names["events"], names["signal"]
    assert isinstance(events, np.ndarray)
    assert isinstance(signal, np.ndarray)
    assert events.dtype == EVENT_DTYPE
    assert 0 < len(signal) <= len(events)
    assert int(capsys.readouterr().out.split()[0]) > 1_000


def test_the_page_knows_all_models_and_cameras() -> None:
    for name in (*DVS_MODELS, *DVS_PRESETS):
        assert f"`{name}`" in PAGE, name


def test_the_pages_figures_are_the_presets() -> None:
    for name in ("dvs128", "davis346", "gen4"):
        cells = next(line for line in PAGE.splitlines() if line.startswith(f"| `{name}`")).split("|")
        numbers = [float(re.match(r"[\d.]+", cell.strip()).group()) for cell in cells[2:9]]  # type: ignore[union-attr]
        preset = DVS_PRESETS[name]
        pole = preset.cutoff_hz / 1e3
        expected = [
            preset.positive_threshold, preset.sigma_threshold, pole, preset.leak_hz, preset.shot_hz,
            preset.refractory_ns * 1e-6, preset.bus_events_per_s / 1e6,  # type: ignore[operator]
        ]  # fmt: skip
        assert np.allclose(numbers, expected), name
