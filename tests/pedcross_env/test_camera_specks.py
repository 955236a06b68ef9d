"""No specks where parts of a body meet: pixels against the same picture of sixteen samples each."""

import numpy as np
import pytest
from camera_scenes import pedestrian, renderer, snapshot

SAMPLES = 4  # along each side of a pixel
MOST = 3.0  # what a speck may stand out by, in shares of what is there


def crowd(away, batch):
    """Eight people of different looks, pose and heading, side by side."""
    people = []
    for k in range(8):
        model, height = ((k + batch) % 3, 1.5) if k % 4 == 3 else (0, 1.72)
        looks = {"seed": 8 * batch + k, "model": model, "height": height, "yaw": 0.8 * k + batch}
        gait = {"speed": 1.3, "gait_stride": 1.4, "gait_phase": 0.17 * k + 0.07 * batch}
        people.append(pedestrian(10 + k, away, -1.75 + (k - 3.5) * 0.13 * away, **looks, **gait))
    return snapshot(*people)


def around(plane):
    h, w = plane.shape
    steps = [(dy, dx) for dy in (0, 1, 2) for dx in (0, 1, 2) if (dy, dx) != (1, 1)]
    return np.stack([plane[dy : h - 2 + dy, dx : w - 2 + dx] for dy, dx in steps])


def stands_out(picture, reference, ids):
    """By how much of it pixels within one actor miss the reference that are brighter or darker than all around them."""
    inner, expected = picture[1:-1, 1:-1], reference[1:-1, 1:-1]
    near, near_expected = around(picture), around(reference)
    within = (ids[1:-1, 1:-1] >= 10) & (around(ids) == ids[1:-1, 1:-1]).all(axis=0)
    bright = (inner > 1.15 * near.max(axis=0)) & (expected <= 1.05 * near_expected.max(axis=0))
    dark = (1.15 * inner < near.min(axis=0)) & (1.05 * expected >= near_expected.min(axis=0))
    off = np.abs(inner - expected) / np.maximum(expected, np.median(near, axis=0))
    return off[within & (bright | dark)]


@pytest.mark.parametrize("away", [6.0, 9.0, 13.0])
def test_nothing_that_is_covered_shows_where_limbs_meet(away):
    seen = renderer()
    fine = renderer(width_px=450 * SAMPLES, height_px=256 * SAMPLES)
    for batch in range(12):
        frame = seen.render(crowd(away, batch))
        many = fine.render(crowd(away, batch), luminance_only=True).luminance
        reference = many.reshape(256, SAMPLES, 450, SAMPLES).mean(axis=(1, 3))
        specks = stands_out(frame.luminance, reference, frame.instance)
        assert specks.max(initial=0.0) < MOST
