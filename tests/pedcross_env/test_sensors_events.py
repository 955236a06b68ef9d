"""Representations of events."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError
from pedcross_env.sensors.events import carla_image, counts_to_png, event_counts, grey_frame, png_to_counts

SHAPE = (3, 4)


def events(*rows: tuple[int, int, int, bool]) -> np.ndarray:
    return np.array(list(rows), EVENT_DTYPE)


def test_counts_tell_pixels_and_polarities_apart() -> None:
    counts = event_counts(events((3, 0, 1, True), (3, 0, 2, True), (3, 0, 3, False), (0, 2, 4, False)), SHAPE)
    expected = np.zeros((3, 4, 2), np.uint8)
    expected[0, 3] = 2, 1
    expected[2, 0] = 0, 1
    np.testing.assert_array_equal(counts, expected)
    assert counts.dtype == np.uint8


def test_counts_saturate() -> None:
    assert event_counts(np.concatenate([events((1, 1, 0, True))] * 300), SHAPE)[1, 1].tolist() == [255, 0]


def test_the_last_event_paints_the_pixel() -> None:
    image = carla_image(events((1, 1, 1, True), (2, 1, 1, True), (2, 1, 2, False)), SHAPE)
    assert image[1, 1].tolist() == [0, 0, 255]
    assert image[1, 2].tolist() == [255, 0, 0]
    assert image.sum() == 510


def test_no_events_are_legal() -> None:
    nothing = np.empty(0, EVENT_DTYPE)
    assert not event_counts(nothing, SHAPE).any()
    assert not carla_image(nothing, SHAPE).any()
    assert not grey_frame(event_counts(nothing, SHAPE)).any()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_png_gives_counts_up_to_128_back_exactly(seed: int) -> None:
    counts = np.random.default_rng(seed).integers(0, 129, (5, 7, 2)).astype(np.uint8)
    np.testing.assert_array_equal(png_to_counts(counts_to_png(counts)), counts)


def test_png_cuts_larger_counts_to_128_and_shows_one_event_clearly() -> None:
    counts = np.array([[[200, 0], [0, 1]]], np.uint8)
    image = counts_to_png(counts)
    assert image.tolist() == [[[0, 0, 255], [128, 0, 0]]]
    assert png_to_counts(image).tolist() == [[[128, 0], [0, 1]]]


def test_a_damaged_picture_is_refused() -> None:
    image = counts_to_png(np.ones((4, 4, 2), np.uint8))
    for channel, value in ((0, 77), (1, 3)):
        damaged = image.copy()
        damaged[0, 0, channel] = value
        with pytest.raises(DataError, match="resized or saved with losses"):
            png_to_counts(damaged)


def test_grey_frame_shows_the_majority() -> None:
    counts = np.array([[[0, 0], [1, 0], [0, 1], [2, 2], [1, 5]]], np.uint8)
    assert grey_frame(counts).tolist() == [[0, 29, 76, 29, 76]]


def test_events_outside_the_shape_are_refused() -> None:
    with pytest.raises(DataError, match="width"):
        event_counts(events((3, 0, 0, True)), (4, 3))


def test_reading_events_loads_no_kernels() -> None:
    code = "import sys, pedcross_env, pedcross_env.sensors.events; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
