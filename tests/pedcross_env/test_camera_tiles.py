"""Parts of the picture rendered alone: the same light as in the whole picture, and refused where that cannot be."""

import numpy as np
import pytest
from camera_scenes import NIGHT, pedestrian, renderer, snapshot, vehicle

from pedcross_env.camera import Renderer, Tile
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import ACTOR_DTYPE
from pedcross_env.errors import ConfigError
from pedcross_env.weather import Weather

CLOUDY = Weather(cloudiness=0.6)
ACTORS = (
    vehicle(2, 14.0, 1.75, yaw=np.pi),
    vehicle(3, 9.0, -4.6),
    pedestrian(4, 20.0, -2.0),
    pedestrian(5, 30.0, 3.0),
)
TILES = (
    Tile(0, 96, 225, 32),
    Tile(0, 0, 61, 96),
    Tile(61, 0, 40, 96),
    Tile(101, 0, 24, 50),
    Tile(101, 50, 24, 46),
    Tile(125, 0, 100, 96),
)


@pytest.mark.parametrize("yaw", [0.0, 0.03])
def test_tiles_show_what_the_whole_picture_shows(yaw: float) -> None:
    camera = renderer(CLOUDY, width_px=225, height_px=128)
    scene = snapshot(*ACTORS, x=2.0, pitch=0.01, yaw=yaw)
    whole = camera.render(scene, luminance_only=True).luminance
    together = np.full_like(whole, np.nan)
    for tile, part in zip(TILES, camera.tiles(scene, TILES), strict=True):
        together[tile.place] = part
    apart = np.abs(np.log(together) - np.log(whole))
    assert apart.max() < 0.1
    assert np.quantile(apart, 0.98) < 1e-4
    assert camera.render(scene, luminance_only=True).luminance.tobytes() == whole.tobytes()


@pytest.mark.parametrize(
    "weather", [NIGHT, Weather(wetness=0.3), Weather(sun_altitude_deg=6.0, sun_azimuth_deg=0.0)]
)
def test_tiles_are_refused_where_light_reaches_other_parts(weather: Weather) -> None:
    camera, scene = renderer(weather, width_px=112, height_px=64), snapshot()
    assert not camera.by_tiles(scene.ego)
    with pytest.raises(ConfigError, match="call render"):
        camera.tiles(scene, [Tile(0, 0, 112, 64)])


def test_a_lens_that_bends_has_no_tiles() -> None:
    bent = renderer(CLOUDY, lens="brown", distortion=(-0.2, 0.05), width_px=112, height_px=64)
    assert not bent.by_tiles(snapshot().ego)
    assert not Renderer(CameraConfig()).by_tiles(np.zeros((), ACTOR_DTYPE))  # nothing is loaded
