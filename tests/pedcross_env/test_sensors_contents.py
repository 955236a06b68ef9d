"""The package's table of contents."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

from pedcross_env import sensors


def test_every_name_of_the_table_is_public_where_it_lives() -> None:
    for module, names in sensors._MODULES.items():
        home = importlib.import_module(f"pedcross_env.sensors.{module}")
        for name in names:
            assert name in home.__all__
            assert getattr(sensors, name) is getattr(home, name)
    assert sorted(sensors._HOME) == sorted(sensors.__all__) == dir(sensors)


def test_an_unknown_name_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="stepp"):
        _ = sensors.stepp


def test_settings_and_events_load_no_kernels() -> None:
    code = (
        "import sys; from pedcross_env.sensors import DvsConfig, dvs_preset, event_counts; dvs_preset('gen4');"
        "sys.exit('numba' in sys.modules and 1)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
