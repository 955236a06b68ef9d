"""highway-env's roads, lanes and vehicles; its environments are registered as ever, but loaded when one is made.

They import pandas and matplotlib, half a second of every process that looks at a street.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import Any

import gymnasium

__all__ = ["AbstractLane", "IDMVehicle", "LineType", "Road", "RoadNetwork", "Vehicle"]

_LATER = ("highway_env.envs", "highway_env.envs.common", "highway_env.envs.common.abstract")


def _import_without_environments() -> None:
    """Import the package while a class of the same name stands in for the only one it takes from its environments.

    It registers them, and that class, by their names: what is registered is what always is. A version that takes more
    from them is imported whole.
    """
    stand_ins = {name: ModuleType(name) for name in _LATER}
    home = stand_ins[_LATER[-1]]
    home.MultiAgentWrapper = type("MultiAgentWrapper", (gymnasium.Wrapper,), {"__module__": home.__name__})  # type: ignore[attr-defined]
    sys.modules.update(stand_ins)
    try:
        package = importlib.import_module("highway_env")
    except ImportError:
        return
    finally:
        for name in _LATER:
            del sys.modules[name]

    def load(name: str) -> Any:
        if name == "envs":
            return importlib.import_module("highway_env.envs")
        raise AttributeError(f"module 'highway_env' has no attribute {name!r}")

    package.__getattr__ = load  # type: ignore[method-assign]


if "highway_env" not in sys.modules:
    _import_without_environments()

from highway_env.road.lane import AbstractLane, LineType  # noqa: E402
from highway_env.road.road import Road, RoadNetwork  # noqa: E402
from highway_env.vehicle.behavior import IDMVehicle  # noqa: E402
from highway_env.vehicle.kinematics import Vehicle  # noqa: E402
