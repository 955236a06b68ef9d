"""The page on extending the street, run as it is printed, in a process of its own: registries are global."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from pedcross_env.camera.models import ModelBuilder, registered
from pedcross_env.camera.props import PropKind, register_prop
from pedcross_env.camera.scenery.buildings import BuildingKind, register_building
from pedcross_env.errors import ConfigError

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"

CHECK = """
import numpy as np
from camera_scenes import snapshot, vehicle
from pedcross_env.camera import Renderer
from pedcross_env.camera.models import model_index
from pedcross_env.camera.scenery import scenery_of
from pedcross_env.config import CameraConfig
from pedcross_env.scenario import VEHICLE_MODELS
from pedcross_env.scenario.sizes import vehicle_size
from pedcross_env.weather.weather import Weather

size = vehicle_size("pod")
camera = Renderer(CameraConfig())
camera.load(scenario.street, Weather())
size_of = {"length": size.length_m, "width": size.width_m, "height": size.height_m}
pod = vehicle(4, 14.0, -4.6, model=VEHICLE_MODELS.index("pod"), **size_of)
frame = camera.render(snapshot(pod))
seen = frame.instance == 4
assert 12.0 < frame.depth[seen].min() < 13.5, frame.depth[seen].min()
rows = np.flatnonzero(seen.any(axis=1))
tall = size.height_m * CameraConfig().focal_px / 13.0
assert 0.75 * tall < len(rows) < 1.15 * tall, (len(rows), tall)
props = scenery_of(scenario.street).props
assert (props.numbers[:, 5] == model_index("hydrant")[0]).any()
assert scenery_of(scenario.street).panels[:, 7].max() > 28.0  # no other house is as high

make_env().close()
"""


def blocks():
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)


def test_the_page_does_what_it_says(tmp_path):
    own, scenario, worker = blocks()
    (tmp_path / "my_street.py").write_text(own)
    script = tmp_path / "run.py"
    script.write_text("import my_street\n" + scenario + worker + CHECK)
    root = PAGE.parents[1]
    path = ":".join([str(tmp_path), str(root), str(root / "tests" / "pedcross_env")])
    run = subprocess.run(
        [sys.executable, str(script)], env={"PYTHONPATH": path, "PATH": "", "HOME": str(Path.home())},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr[-2000:]


def test_a_taken_name_is_refused():
    with pytest.raises(ConfigError, match="taken"):
        register_building("office", BuildingKind(share=1.0, walls=((0.3, 0.3, 0.3),)))


def test_furniture_that_people_would_walk_through_is_refused():
    wall = ModelBuilder()
    wall.box((-0.5, 0.5), (-1.0, 1.0), (0.0, 1.0), 4)
    with pytest.raises(ConfigError, match="at most"):
        register_prop("wall", wall.build(1.0, 2.0, 1.0), PropKind(place="facade", per_100_m=1.0))
    assert "wall" not in registered()


def test_a_part_with_too_many_faces_is_refused():
    many = ModelBuilder()
    many.loft([[(x, y, 0.1 * k) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))] for k in range(30)], 4)
    with pytest.raises(ConfigError, match="faces of a part"):
        many.build(2.0, 2.0, 2.0)
