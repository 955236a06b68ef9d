"""Compile all kernels before many processes need them, so that it is done once and can be announced."""

from __future__ import annotations

import numpy as np

from pedcross_env.config import CameraConfig, EnvConfig

__all__ = ["COMPILING", "compile_kernels"]

COMPILING = "compiling kernels (up to a minute, once per installation)"


def compile_kernels(*, layouts: bool = False) -> None:
    """Run every kernel on small pictures: by day, in rain and at night; about a second once all are cached.

    Args:
        layouts: Also those for streets that bend or cross and for rolled cameras: a quarter of a minute more.
    """
    from pedcross_env.camera import Renderer
    from pedcross_env.contracts import ACTOR_DTYPE, ActorKind, Snapshot
    from pedcross_env.env import CrossingEnv
    from pedcross_env.scenario.street import StreetSpec
    from pedcross_env.weather.weather import Weather

    camera = CameraConfig(width_px=32, height_px=32)
    for return_events in (False, True):
        env = CrossingEnv(EnvConfig(weather=("rain_night",), return_events=return_events, camera=camera))
        env.reset(seed=0)
        env.step(np.zeros(1, np.float32))
        env.driver_view()
        env.reset(seed=0, options={"weather": "tunnel_exit"})
        env.close()
    if layouts:
        ego = np.zeros((), ACTOR_DTYPE)
        ego["id"], ego["kind"] = 1, ActorKind.VEHICLE
        renderer = Renderer(CameraConfig(width_px=32, height_px=32, roll_deg=1.0))
        renderer.load(StreetSpec(), Weather(wetness=0.5, street_lamps=True, headlights=True))
        renderer.render(Snapshot(0.0, ego, np.zeros(0, ACTOR_DTYPE)))
