"""Compile all kernels before many processes need them, so that it is done once and can be announced."""

from __future__ import annotations

import numpy as np

from pedcross_env.config import CameraConfig, EnvConfig

__all__ = ["COMPILING", "compile_kernels"]

COMPILING = "compiling kernels (up to a minute, once per installation)"


def compile_kernels() -> None:
    """Run every kernel on small pictures: by day, in rain and at night; about a second once all are cached."""
    from pedcross_env.env import CrossingEnv

    camera = CameraConfig(width_px=32, height_px=32)
    for return_events in (False, True):
        env = CrossingEnv(EnvConfig(weather=("rain_night",), return_events=return_events, camera=camera))
        env.reset(seed=0)
        env.step(np.zeros(1, np.float32))
        env.driver_view()
        env.close()
