"""Sensors: pure functions, their state an argument; usable without the environment.

- rgb: exposure, noise and quantisation of the RGB camera
- dvs: the event camera; dvs_state: what it remembers; dvs_config: its settings and presets
- intensity: the logarithms it compares
- causes: what events are put down to
- events: what is made of events: counts, images
- representations: events of a fixed window as an array: counts, voxel grid, time surface, pictures
- event_files: reading and writing npz, DSEC's HDF5, AEDAT4; reading Prophesee's DAT and RAW, and ROS 2 bags
- resizing: smaller event frames that keep events: pooling, nearest neighbours

Each module stands alone, and names are loaded when they are asked for: reading events loads no kernels.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pedcross_env.sensors.causes import blame, edge_owner, is_noise
    from pedcross_env.sensors.dvs import DvsState, add_counts, initial_state, step, step_counts, step_labelled
    from pedcross_env.sensors.dvs_config import DVS_PRESETS, DvsConfig, dvs_preset
    from pedcross_env.sensors.event_files import FORMATS, Recording, read_events, write_events
    from pedcross_env.sensors.events import (
        carla_image,
        counts_to_png,
        event_counts,
        grey_frame,
        png_to_counts,
    )
    from pedcross_env.sensors.intensity import carla_log, lin_log, log_image, log_luminance, srgb_luminance
    from pedcross_env.sensors.representations import (
        REPRESENTATIONS,
        event_windows,
        histogram,
        represent,
        time_surface,
        voxel_grid,
        window,
    )
    from pedcross_env.sensors.resizing import nearest, pool, rescale_events

_MODULES = {
    "causes": ("blame", "edge_owner", "is_noise"),
    "dvs": ("DvsState", "add_counts", "initial_state", "step", "step_counts", "step_labelled"),
    "dvs_config": ("DVS_PRESETS", "DvsConfig", "dvs_preset"),
    "event_files": ("FORMATS", "Recording", "read_events", "write_events"),
    "events": ("carla_image", "counts_to_png", "event_counts", "grey_frame", "png_to_counts"),
    "intensity": ("carla_log", "lin_log", "log_image", "log_luminance", "srgb_luminance"),
    "representations": (
        "REPRESENTATIONS", "event_windows", "histogram", "represent", "time_surface", "voxel_grid", "window",
    ),
    "resizing": ("nearest", "pool", "rescale_events"),
}  # fmt: skip
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "DVS_PRESETS", "FORMATS", "REPRESENTATIONS", "DvsConfig", "DvsState", "Recording", "add_counts", "blame",
    "carla_image", "carla_log", "counts_to_png", "dvs_preset", "edge_owner", "event_counts", "event_windows",
    "grey_frame", "histogram", "initial_state", "is_noise", "lin_log", "log_image", "log_luminance", "nearest",
    "png_to_counts", "pool", "read_events", "represent", "rescale_events", "srgb_luminance", "step",
    "step_counts", "step_labelled", "time_surface", "voxel_grid", "window", "write_events",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
