"""Representations over fixed windows, and their resizing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import ConfigError, DataError
from pedcross_env.sensors.events import event_counts
from pedcross_env.sensors.representations import (
    REPRESENTATIONS,
    event_windows,
    histogram,
    represent,
    time_surface,
    voxel_grid,
    window,
)
from pedcross_env.sensors.resizing import nearest, pool, rescale_events

SHAPE = (3, 4)
START, END = 1000, 2000
NOTHING = np.empty(0, EVENT_DTYPE)


def events(*rows: tuple[int, int, int, bool]) -> np.ndarray:
    return np.array(list(rows), EVENT_DTYPE)


def random_events(seed: int, count: int = 200, shape: tuple[int, int] = SHAPE) -> np.ndarray:
    rng = np.random.default_rng(seed)
    out = np.empty(count, EVENT_DTYPE)
    out["x"], out["y"] = rng.integers(0, shape[1], count), rng.integers(0, shape[0], count)
    out["t"] = np.sort(rng.integers(START - 300, END + 300, count))
    out["pol"] = rng.random(count) < 0.5
    return out


@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_no_events_give_silence_of_the_full_shape(name: str) -> None:
    out = represent(name, NOTHING, SHAPE, START, END)
    assert not out.any()
    assert out.shape == represent(name, random_events(0), SHAPE, START, END).shape


@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_a_single_event_marks_its_pixel_and_no_other(name: str) -> None:
    out = represent(name, events((3, 1, 1500, False)), SHAPE, START, END)
    rows, columns = (0, 1) if name in ("carla", "paper") else (out.ndim - 2, out.ndim - 1)
    where = np.nonzero(out)
    assert set(where[rows]) == {1}
    assert set(where[columns]) == {3}


@pytest.mark.parametrize("name", REPRESENTATIONS)
@pytest.mark.parametrize(("t", "inside"), [(START - 1, False), (START, True), (END - 1, True), (END, False)])
def test_a_window_holds_its_start_and_not_its_end(name: str, t: int, inside: bool) -> None:
    assert represent(name, events((0, 0, t, True)), SHAPE, START, END).any() == inside


@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_input_is_left_as_it_was(name: str) -> None:
    given_events = random_events(3)
    before = given_events.tobytes()
    represent(name, given_events, SHAPE, START, END)
    assert given_events.tobytes() == before


@pytest.mark.parametrize("name", REPRESENTATIONS)
def test_bad_windows_times_places_and_names_are_refused(name: str) -> None:
    with pytest.raises(ConfigError, match="later than start_ns = 1000"):
        represent(name, NOTHING, SHAPE, START, START)
    with pytest.raises(DataError, match="outside the shape"):
        represent(name, events((3, 0, START, True)), (4, 3), START, END)
    with pytest.raises(DataError, match="EVENT_DTYPE"):
        represent(name, np.zeros(3), SHAPE, START, END)
    with pytest.raises(ConfigError, match="Did you mean"):
        represent(name[:-1] + "z", NOTHING, SHAPE, START, END)


@pytest.mark.parametrize("name", sorted(set(REPRESENTATIONS) - {"carla"}))
def test_what_only_adds_up_takes_events_in_any_order(name: str) -> None:
    given_events = random_events(6)
    shuffled = np.random.default_rng(1).permutation(given_events)
    expected = represent(name, given_events, SHAPE, START, END)
    np.testing.assert_allclose(represent(name, shuffled, SHAPE, START, END), expected, atol=1e-5)


def test_who_asks_for_the_last_event_needs_them_in_order() -> None:
    back = events((0, 0, START + 2, True), (0, 0, START + 1, True))
    for refusing in (window, lambda *given: represent("carla", given[0], SHAPE, *given[1:])):
        with pytest.raises(DataError, match=f"event 1 is at {START + 1} ns"):
            refusing(back, START, END)


@given(st.integers(0, 2**32 - 1), st.integers(1, 700))
@settings(max_examples=25, deadline=None)
def test_windows_end_to_end_use_each_event_once(seed: int, length: int) -> None:
    given_events = random_events(seed)
    spans = event_windows(START, END, length)
    parts = [window(given_events, *span) for span in spans]
    covered = given_events[(given_events["t"] >= START) & (given_events["t"] < START + length * len(spans))]
    np.testing.assert_array_equal(np.concatenate([NOTHING, *parts]), covered)


def test_histogram_does_not_saturate_and_agrees_with_counts() -> None:
    many = np.concatenate([events((1, 1, START, False))] * 300)
    assert histogram(many, SHAPE, START, END)[1, 1, 1] == 300
    some = random_events(1)
    expected = np.moveaxis(event_counts(window(some, START, END), SHAPE), 2, 0)
    np.testing.assert_array_equal(histogram(some, SHAPE, START, END), expected)


def test_voxel_grid_is_the_published_formula() -> None:
    given_events, bins = random_events(2), 4
    expected = np.zeros((bins, *SHAPE))
    for event in given_events:
        if START <= event["t"] < END:
            tau = (bins - 1) * (int(event["t"]) - START) / (END - START)
            for b in range(bins):
                share = max(0.0, 1 - abs(b - tau))
                expected[b, event["y"], event["x"]] += share if event["pol"] else -share
    np.testing.assert_allclose(voxel_grid(given_events, SHAPE, START, END, bins), expected, atol=1e-6)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
@settings(max_examples=25, deadline=None)
def test_a_voxel_grid_adds_up_to_the_signed_count(seed: int, bins: int) -> None:
    given_events = random_events(seed)
    counts = histogram(given_events, SHAPE, START, END)
    grid = voxel_grid(given_events, SHAPE, START, END, bins)
    np.testing.assert_allclose(grid.sum(axis=0), counts[0] - counts[1], atol=1e-4)
    apart = voxel_grid(given_events, SHAPE, START, END, bins, polarities=True)
    np.testing.assert_allclose(apart.sum(axis=1), counts, atol=1e-4)
    np.testing.assert_allclose(apart[0] - apart[1], grid, atol=1e-5)


def test_voxels_at_a_bins_moment_fall_into_it_whole() -> None:
    grid = voxel_grid(events((0, 0, START, True), (1, 0, START + 500, False)), SHAPE, START, END, bins=3)
    assert grid[:, 0, 0].tolist() == [1, 0, 0]
    assert grid[:, 0, 1].tolist() == [0, -1, 0]


def test_time_surface_remembers_the_last_event_alone() -> None:
    surface = time_surface(events((2, 1, 1100, True), (2, 1, 1900, True)), SHAPE, START, END, tau_ns=50.0)
    assert surface[0, 1, 2] == pytest.approx(math.exp(-2))
    assert np.count_nonzero(surface) == 1


@given(st.integers(0, 2**32 - 1), st.integers(1, 11), st.integers(1, 13))
@settings(max_examples=40, deadline=None)
def test_sum_pooling_counts_what_rescaled_events_count(seed: int, height: int, width: int) -> None:
    source, target = (11, 13), (height, width)
    given_events = random_events(seed, shape=source)
    counts = event_counts(given_events, source)
    pooled = pool(counts, target, "sum", axes=(0, 1))
    np.testing.assert_array_equal(pooled, event_counts(rescale_events(given_events, source, target), target))
    assert pooled.sum() == given_events.size
    # Every event leaves a trace as strong as the strongest of its cell.
    np.testing.assert_array_equal(pool(counts, target, "max", axes=(0, 1)) > 0, pooled > 0)


def test_max_pooling_keeps_the_value_farthest_from_zero() -> None:
    voxels = np.array([[[-3.0, 1.0, 0.0, 0.5], [2.0, 0.0, 0.0, -0.25]]], np.float32)
    assert pool(voxels, (1, 2), "max").tolist() == [[[-3.0, 0.5]]]
    assert pool(voxels, (1, 2), "sum").tolist() == [[[0.0, 0.25]]]


def test_pooling_to_the_same_size_changes_nothing() -> None:
    image = np.arange(12, dtype=np.uint8).reshape(SHAPE)
    for how in ("max", "sum"):
        np.testing.assert_array_equal(pool(image, SHAPE, how), image)
    np.testing.assert_array_equal(nearest(image, SHAPE), image)


def test_nearest_takes_the_pixel_under_the_centre() -> None:
    row = np.arange(9)[None]
    assert nearest(row, (1, 3)).tolist() == [[1, 4, 7]]
    assert nearest(row[:, :2], (2, 4)).tolist() == [[0, 0, 1, 1]] * 2
    assert nearest(np.zeros((4, 6, 2)), (2, 3), axes=(0, 1)).shape == (2, 3, 2)


def test_pooling_refuses_to_enlarge_and_names_the_remedy() -> None:
    with pytest.raises(ConfigError, match=r"nearest\(\)"):
        pool(np.zeros(SHAPE), (4, 4), "max")
    with pytest.raises(ConfigError, match="at most the source's"):
        rescale_events(NOTHING, SHAPE, (4, 4))
    with pytest.raises(ConfigError, match="Allowed: max, sum"):
        pool(np.zeros(SHAPE), (1, 1), "mean")  # type: ignore[arg-type]
