"""A part of the picture, seen by a camera with a shifted principal point, looks as it does in the whole."""

import math

import numpy as np
import pytest
from camera_scenes import STREET, pedestrian, snapshot, vehicle

from pedcross_env.camera import Renderer
from pedcross_env.config import CameraConfig
from pedcross_env.weather.weather import Weather

WIDTH, HEIGHT = 225, 128
CLEAR = {
    "cloudiness": 0.0
}  # clouds are computed at places some pixels apart, counted from the picture's corner
ACTORS = (
    vehicle(2, 14.0, 1.75, yaw=math.pi),
    vehicle(3, 9.0, -4.6),
    vehicle(4, 17.0, -4.6),
    vehicle(5, 24.0, 4.7),
    pedestrian(6, 13.0, -2.0),
    pedestrian(7, 9.0, 1.0),
    pedestrian(8, 22.0, -2.2, yaw=0.7),
)


def seen_by(camera: CameraConfig, sun: dict[str, float]) -> np.ndarray:
    """(H, W) luminance."""
    view = Renderer(camera)
    view.load(STREET, Weather(**CLEAR, **sun))
    return view.render(snapshot(*ACTORS, x=1.0), luminance_only=True).luminance


def part(left: int, top: int, width: int, height: int) -> CameraConfig:
    """The camera that sees a part of what CameraConfig(width_px=WIDTH, height_px=HEIGHT) sees."""
    focal = CameraConfig(width_px=WIDTH, height_px=HEIGHT).focal_px
    return CameraConfig(
        width_px=width, height_px=height, horizontal_fov_deg=2.0 * math.degrees(math.atan(0.5 * width / focal)),
        principal_point=((0.5 * WIDTH - left) / width, (0.5 * HEIGHT - top) / height),
    )  # fmt: skip


@pytest.mark.parametrize(
    "sun",
    [
        {"sun_altitude_deg": 40.0, "sun_azimuth_deg": 60.0},
        {"sun_altitude_deg": 25.0, "sun_azimuth_deg": 130.0},
        {"sun_altitude_deg": 60.0, "sun_azimuth_deg": 200.0},
    ],
)
def test_a_part_looks_as_in_the_whole(sun):
    whole = seen_by(CameraConfig(width_px=WIDTH, height_px=HEIGHT), sun)
    apart = []
    for left, top, width, height in ((40, 40, 100, 88), (60, 50, 70, 60), (95, 30, 60, 98), (75, 44, 47, 84)):
        alone = seen_by(part(left, top, width, height), sun)
        apart.append(np.abs(np.log(alone) - np.log(whole[top : top + height, left : left + width])).ravel())
    apart = np.concatenate(apart)
    assert apart.max() < 3e-3
    assert np.quantile(apart, 0.999) < 2e-4
