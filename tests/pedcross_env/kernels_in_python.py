"""Run the environment with its kernels as plain Python; print which are given memory that they write by two ways.

Kernels are compiled as if what they write could be reached by one of their arguments alone (see kernels.jit). Where
that is wrong, so may be what they compute, and no picture need show it. Run as a script: kernels are compiled, or not,
when they are imported.
"""

from __future__ import annotations

import functools
import inspect
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np

AS_COMPILED = "splat_leaves"  # the leaves of crowns: an entry, and half a minute in Python
MOST_CALLS = 200  # that are watched from each place
WRAPPING = ("int32", "int64", "uint8", "uint16", "uint32", "uint64")

compiled_njit = numba.njit
shared: set[tuple[str, str, str]] = set()
never_called: set[str] = set()


class Wrapping:
    """An integer type of NumPy whose conversions wrap around as in compiled code."""

    def __init__(self, name: str) -> None:
        self.dtype = np.dtype(name)

    def __call__(self, value: Any) -> Any:
        if isinstance(value, int):
            value = np.int64((value + (1 << 63)) % (1 << 64) - (1 << 63))
        return np.asarray(value).astype(self.dtype)[()]


def arrays_in(value: Any, name: str) -> Iterator[tuple[str, np.ndarray]]:
    if isinstance(value, np.ndarray) and value.size > 0:
        yield name, value
    elif isinstance(value, tuple):
        for k, part in enumerate(value):
            yield from arrays_in(part, f"{name}[{k}]")


def watched(function: Callable[..., Any]) -> Callable[..., Any]:
    """Note pairs of arguments that share memory of which the function changes some."""
    own_name = f"{function.__module__}.{function.__name__}"
    names = list(inspect.signature(function).parameters)
    calls: Counter[tuple[str, int]] = Counter()
    never_called.add(own_name)

    @functools.wraps(function)
    def call(*arguments: Any) -> Any:
        never_called.discard(own_name)
        caller = sys._getframe(1)
        place = caller.f_code.co_name, caller.f_lineno
        calls[place] += 1
        if calls[place] > MOST_CALLS:
            return function(*arguments)
        given = [
            part for name, value in zip(names, arguments, strict=True) for part in arrays_in(value, name)
        ]
        pairs = [
            (first, second)
            for k, first in enumerate(given)
            for second in given[k + 1 :]
            if np.may_share_memory(first[1], second[1]) and np.shares_memory(first[1], second[1])
        ]
        before = [(first[1].tobytes(), second[1].tobytes()) for first, second in pairs]
        result = function(*arguments)
        for (first, second), was in zip(pairs, before, strict=True):
            if (first[1].tobytes(), second[1].tobytes()) != was:
                shared.add((own_name, first[0], second[0]))
        return result

    return call


def python_njit(*plain: Any, **options: Any) -> Any:
    """In the place of numba.njit: watch kernels, leave all else as it is."""

    def decorate(function: Callable[..., Any]) -> Any:
        if function.__name__ == AS_COMPILED:
            return compiled_njit(**options)(function)
        if options.get("no_cpython_wrapper"):
            return watched(function)
        python = functools.wraps(function)(lambda *arguments: function(*arguments))
        python._cache = SimpleNamespace(_cache_file=SimpleNamespace(_source_stamp=None))
        return python

    return decorate(plain[0]) if plain else decorate


def behaving(**shares: float) -> dict[str, Any]:
    return {"behaviour": shares, "crossing_share": 1.0, "max_oncoming": 3}


def cases() -> list[dict[str, Any]]:
    """Configurations that together call every kernel."""
    from pedcross_env.weather import Weather

    dark = {"sun_altitude_deg": -30.0, "street_lamps": True, "headlights": True, "cloudiness": 0.0}
    wet = {"rain_mm_h": 50.0, "wetness": 1.0, "water_film_mm": 1.0}
    rain = Weather(**wet, headlights=True, cloudiness=0.0)  # few clouds: in Python they take long
    return [
        {"weather": (Weather(cloudiness=0.0),), "traffic": behaving(cyclist=1.0),
         "dvs": {"max_subframes": 10, "max_flow_px": 0.1, "shot_hz": 300.0}},
        {"weather": (Weather(**dark),), "traffic": behaving(intersection=1.0), "dvs": "v2e", "rgb": {"noise": False}},
        {"weather": (rain,), "traffic": behaving(leader=1.0), "windscreen": {"drops": True},
         "return_events": True, "label_events": True, "dvs": {"max_subframes": 2}},
        {"weather": (Weather(snow_mm_h=2.0, snow_cover=0.5, visibility_m=300.0, **dark),),
         "traffic": behaving(curve=1.0, cyclist=1.0), "dvs": "carla"},
        {"weather": (Weather(cloudiness=0.0),), "modalities": ("rgb",),
         "camera": {"horizontal_fov_deg": 15.0, "yaw_deg": -15.0}},
        {"weather": (Weather(tunnel_exit_m=40.0),), "dvs": {"max_subframes": 2, "leak_hz": 0.1}},
        {"weather": (Weather(cloudiness=0.5, sun_altitude_deg=5.0, sun_azimuth_deg=0.0),), "camera": {"roll_deg": 2.0},
         "dvs": {"max_subframes": 2, "leak_hz": 0.1, "shot_hz": 300.0, "cutoff_hz": 100.0, "refractory_ns": 1_000_000}},
    ]  # fmt: skip


def main() -> None:
    np.seterr(all="ignore")  # hashes overflow
    numba.njit = python_njit
    from pedcross_env.camera.scenery.foliage import crown_textures
    from pedcross_env.env import CrossingEnv

    crown_textures()
    wrapping = SimpleNamespace(**{**vars(np), **{name: Wrapping(name) for name in WRAPPING}})
    for name, module in list(sys.modules.items()):
        if name.startswith("pedcross_env.") and hasattr(module, "np") and _has_kernels(module):
            module.np = wrapping
    for case in cases():
        camera = {"width_px": 64, "height_px": 36, **case.get("camera", {})}
        env = CrossingEnv({**case, "camera": camera})
        env.reset(seed=1)
        env.step(np.zeros(1, np.float32))
    print(json.dumps({"shared": sorted(shared), "never called": sorted(never_called)}))


def _has_kernels(module: Any) -> bool:
    return any(getattr(value, "__wrapped__", None) is not None for value in vars(module).values())


if __name__ == "__main__":
    main()
