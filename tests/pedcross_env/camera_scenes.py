"""Small hand-made scenes that the camera's tests share."""

import math

import numpy as np

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ACTOR_DTYPE, ActorKind, Snapshot
from pedcross_env.scenario.street import Crosswalk, StreetSpec
from pedcross_env.weather.weather import Weather

STREET = StreetSpec(crosswalks=(Crosswalk(x_m=22.0),), seed=5)
NIGHT = Weather(sun_altitude_deg=-30.0, street_lamps=True, headlights=True, wetness=0.5)


def record(**values):
    actor = np.zeros((), ACTOR_DTYPE)
    for name, value in values.items():
        actor[name] = value
    return actor


def vehicle(ident, x, y, **values):
    return record(
        **{
            "id": ident,
            "kind": ActorKind.VEHICLE,
            "x": x,
            "y": y,
            "length": 4.5,
            "width": 1.8,
            "height": 1.5,
            **values,
        }
    )


def pedestrian(ident, x, y, **values):
    return record(
        **{
            "id": ident,
            "kind": ActorKind.PEDESTRIAN,
            "x": x,
            "y": y,
            "length": 0.5,
            "width": 0.5,
            "height": 1.75,
            "yaw": math.pi / 2,
            **values,
        }
    )


def snapshot(*actors, x=0.0, pitch=0.0, yaw=0.0, headlight=0.0):
    ego = vehicle(1, x, -1.75, pitch=pitch, yaw=yaw, headlight=headlight)
    return Snapshot(0.0, ego, np.array(list(actors), ACTOR_DTYPE))


def renderer(weather=None, **camera):
    made = Renderer(CameraConfig(**camera))
    made.load(STREET, weather or Weather())
    return made
