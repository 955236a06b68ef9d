"""What is drawn of a vehicle is as large as what is touched of it, and has its lamps where its ends are."""

import numpy as np
import pytest

from pedcross_env.camera.model_table import model_table
from pedcross_env.camera.models import HEADLIGHT, TAIL
from pedcross_env.scenario.scenario import VEHICLE_MODELS
from pedcross_env.scenario.sizes import VEHICLE_SIZES

SHIPPED = [name for name in VEHICLE_SIZES if name in VEHICLE_MODELS[:10]]
MOTOR_VEHICLES = ["hatchback", "sedan", "suv", "van", "bus", "truck", "motorcycle"]
MIRRORS_M = 0.22  # beyond the width, which is counted without them, on either side


def points_of(name: str, *, material: int | None = None) -> np.ndarray:
    """(N, 3) corners of a model, or of its faces of one material."""
    table = model_table()
    k = VEHICLE_MODELS.index(name)
    points = table.points[table.model_points[k] : table.model_points[k + 1]]
    if material is None:
        return points
    first, last = (int(table.part_faces[table.model_parts[k + i]]) for i in (0, 1))
    faces = [f for f in range(first, last) if table.face_material[f] == material]
    corners = [c for f in faces for c in table.face_corners[table.face_start[f] : table.face_start[f + 1]]]
    return points[corners]


@pytest.mark.parametrize("name", SHIPPED)
def test_a_model_is_built_at_the_size_of_its_footprint(name: str) -> None:
    size = VEHICLE_SIZES[name]
    assert tuple(model_table().nominal[VEHICLE_MODELS.index(name)]) == tuple(size)
    low, high = points_of(name).min(axis=0), points_of(name).max(axis=0)
    assert high[0] - low[0] == pytest.approx(size.length_m, abs=0.15)
    assert size.width_m - 0.05 <= high[1] - low[1] <= size.width_m + 2 * MIRRORS_M
    if name != "cyclist":  # the rider is drawn by the riders' own code
        assert high[2] == pytest.approx(size.height_m, abs=0.05)


@pytest.mark.parametrize("name", MOTOR_VEHICLES)
def test_lamps_are_at_the_ends_they_belong_to(name: str) -> None:
    half = 0.5 * VEHICLE_SIZES[name].length_m
    for material, end in ((TAIL, -half), (HEADLIGHT, half)):
        lamps = points_of(name, material=material)
        assert len(lamps) >= 3
        assert np.abs(lamps[:, 0] - end).max() < 0.6
