import csv
import math

import cv2
import numpy as np
import pytest

from eval.decimation import METHODS, DecimationConfig, Original, decimate, measure_loss, run_decimation
from pedcross_env.config import CameraConfig
from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.sensors.events import carla_image


def original(*rows, shape=(8, 8), pedestrian=()):
    events = np.array(list(rows), EVENT_DTYPE)
    mask = np.zeros(shape, bool)
    for y, x in pedestrian:
        mask[y, x] = True
    return Original(events, carla_image(events, shape), mask, "test")


def test_a_lonely_event_survives_as_an_event_and_drowns_in_an_average():
    # One event in a cell of 4x4: the area's mean is a sixteenth of it, and no centre of a target pixel is at (0, 0).
    lonely = original((0, 0, 1, True), pedestrian=[(0, 0)])
    losses = {name: measure_loss(lonely, name, small) for name, small in decimate(lonely, (2, 2)).items()}
    assert losses["events"].kept == losses["events"].pedestrian_kept == 1
    assert (losses["events"].invalid, losses["events"].strength) == (0, 1)
    assert losses["area"].kept == losses["nearest"].kept == 0
    assert losses["area"].strength == pytest.approx(1 / 16, abs=0.003)
    assert losses["area"].invalid == 1
    assert losses["nearest"].active == 0
    assert math.isnan(losses["nearest"].strength)


def test_two_polarities_in_one_cell_cost_one_of_them():
    mixed = original((0, 0, 1, True), (1, 0, 2, False))
    small = decimate(mixed, (4, 4))
    assert measure_loss(mixed, "events", small["events"]).kept == 0.5
    assert small["area"][0, 0, [0, 2]].all()  # red and blue at once: no polarity
    assert measure_loss(mixed, "area", small["area"]).invalid == 1


def test_the_same_size_loses_nothing_by_any_method():
    whole = original((0, 0, 1, True), (1, 0, 2, False), (5, 6, 2, False), pedestrian=[(6, 5)])
    for name, small in decimate(whole, (8, 8)).items():
        np.testing.assert_array_equal(small, whole.picture)
        loss = measure_loss(whole, name, small)
        assert (loss.kept, loss.pedestrian_kept, loss.active, loss.invalid) == (1, 1, 3, 0)


def test_the_command_draws_the_figure_and_counts_each_method(tmp_path):
    camera = CameraConfig(width_px=160, height_px=60, horizontal_fov_deg=90)
    config = DecimationConfig(out=tmp_path, weather="clear", camera=camera, width_px=45, height_px=26)
    found, losses = run_decimation(config)
    assert [loss.method for loss in losses] == list(METHODS)
    assert found.events.size > 0
    assert found.pedestrian.any()
    by_method = {loss.method: loss for loss in losses}
    assert by_method["events"].kept == max(loss.kept for loss in losses)
    assert by_method["events"].invalid == by_method["nearest"].invalid == 0 < by_method["area"].invalid
    figure = cv2.imread(str(tmp_path / "decimation.png"))
    assert figure.shape[1] > 1000
    with (tmp_path / "decimation.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["kept"]) for row in rows] == [loss.kept for loss in losses]
