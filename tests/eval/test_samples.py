import json

import cv2
import numpy as np

from eval.samples import capture_samples, paint_events
from pedcross_env.config import CameraConfig, EnvConfig

SMALL = EnvConfig(camera=CameraConfig(width_px=96, height_px=54))


def test_both_cameras_show_the_same_crossing_in_each_weather(tmp_path):
    samples = capture_samples(tmp_path, ("clear", "fog"), SMALL)
    assert [s["weather"] for s in samples] == ["clear", "fog"]
    assert samples[0]["seed"] == samples[1]["seed"]
    assert samples[0]["distance_m"] == samples[1]["distance_m"]
    assert 8 <= samples[0]["distance_m"] <= 13
    assert samples[0]["visible_fraction"] >= 0.9  # of the soonest of all, a cyclist hides nearly half
    contrast = {}
    for weather in ("clear", "fog"):
        for kind in ("rgb", "dvs"):
            image = cv2.imread(str(tmp_path / f"{weather}_{kind}.png"))
            assert image.shape == (54, 96, 3)
            contrast[weather, kind] = image.std()
    assert contrast["fog", "rgb"] < contrast["clear", "rgb"]
    assert json.loads((tmp_path / "samples.json").read_text()) == samples


def test_events_are_painted_by_polarity_on_white():
    counts = np.zeros((1, 3, 2), np.uint8)
    counts[0, 1, 0], counts[0, 2, 1] = 9, 9
    none, on, off = paint_events(counts)[0].tolist()
    assert none == [255, 255, 255]
    assert on[2] > on[0]  # blue
    assert off[0] > off[2]  # red
