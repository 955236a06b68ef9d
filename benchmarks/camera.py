"""Frames of the camera per second of user CPU time on one thread: clear, fog, night, wet, luminance only, and 1600x600.

Run: python benchmarks/camera.py [seconds per line]
"""

import math
import os
import sys
import time

import numpy as np

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ACTOR_DTYPE, ActorKind, Snapshot
from pedcross_env.scenario.street import Crosswalk, StreetSpec
from pedcross_env.weather.weather import Weather

STREET = StreetSpec(crosswalks=(Crosswalk(x_m=22.0),), seed=3)
NIGHT = {"sun_altitude_deg": -30.0, "street_lamps": True, "headlights": True}
WEATHERS = {
    "clear": Weather(),
    "fog 60 m": Weather(visibility_m=60.0, cloudiness=1.0),
    "night": Weather(**NIGHT),
    "wet, rain 20 mm/h": Weather(wetness=1.0, rain_mm_h=20.0, cloudiness=1.0),
    "wet night": Weather(**NIGHT, wetness=1.0, rain_mm_h=20.0),
}


def actor(**values: float) -> np.ndarray:
    record = np.zeros((), ACTOR_DTYPE)
    for name, value in values.items():
        record[name] = value
    return record


def car(ident: int, x: float, y: float, lights: float, **values: float) -> np.ndarray:
    size = {"length": 4.5, "width": 1.8, "height": 1.5}
    return actor(
        id=ident, kind=ActorKind.VEHICLE, x=x, y=y, headlight=lights, seed=ident, **{**size, **values}
    )


def scene(x: float, lights: float) -> Snapshot:
    """Four cars and two pedestrians, as in the comparison that the targets come from."""
    person = {"kind": ActorKind.PEDESTRIAN, "length": 0.5, "width": 0.5, "gait_stride": 1.4}
    others = [
        car(10, 16.0, -4.6, 0.0),
        car(11, 24.0, 4.6, 0.0, yaw=math.pi, model=1),
        car(12, 48.0, 1.75, lights, yaw=math.pi, model=2),
        car(13, 60.0, -1.75, lights, model=1),
        actor(id=20, x=22.0, y=-2.5, yaw=math.pi / 2, height=1.75, seed=1, gait_phase=0.1 + x, **person),
        actor(
            id=21, x=21.0, y=3.0, yaw=-math.pi / 2, height=1.3, seed=2, model=1, gait_phase=0.4 + x, **person
        ),
    ]
    return Snapshot(0.0, car(1, x, -1.75, lights), np.array(others, ACTOR_DTYPE))


def measure(camera: Renderer, weather: Weather, luminance_only: bool, seconds: float) -> float:
    camera.load(STREET, weather)
    scenes = [scene(0.33 * k, float(weather.headlights)) for k in range(20)]
    camera.render(scenes[0], luminance_only=luminance_only)
    frames, start = 0, os.times().user
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        for snapshot in scenes:
            camera.render(snapshot, luminance_only=luminance_only)
        frames += len(scenes)
    return frames / (os.times().user - start)


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
    start = os.times().user
    small, large = Renderer(CameraConfig()), Renderer(CameraConfig(width_px=1600, height_px=600))
    small.load(STREET, WEATHERS["wet night"])
    small.render(scene(0.0, 1.0))
    print(f"first frame (compiling where there is no cache): {os.times().user - start:.1f} s")
    for name, weather in WEATHERS.items():
        full, alone = (measure(small, weather, only, seconds) for only in (False, True))
        print(
            f"450x256 {name:18s} {full:6.0f} frames/s with colour, depth and ids; {alone:6.0f} luminance only"
        )
    print(f"1600x600 clear {measure(large, WEATHERS['clear'], False, seconds):14.0f} frames/s")


if __name__ == "__main__":
    main()
