"""Events come in order, and are those of pixels followed one by one, however many there are and however they crowd."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from dvs_movies import STEP_NS, config, f32, smooth_sequence

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.sensors import _event_order, _fire_kernels
from pedcross_env.sensors._event_order import in_order, write_in_order
from pedcross_env.sensors.dvs import initial_state, step, step_labelled


def keys_of(name: str) -> np.ndarray:
    rng = np.random.default_rng(3)
    spread = rng.integers(0, 700 << 32, 60_000, np.uint64)
    return {
        "none": spread[:0],
        "few": spread[:100],
        "many": spread,
        "close together": spread & np.uint64(2**32 - 1),
        "all the same": np.full(60_000, 12_345_678_901, np.uint64),
        "most in one row": np.concatenate([spread[:20_000], spread[20_000:] % np.uint64(2**32)]),
        "each in its own row": np.arange(60_000, dtype=np.uint64)[::-1] << np.uint64(32),
        "far apart": spread << np.uint64(20),
        "the largest lower halves": spread | np.uint64(0xFFFFFFF0),
        "equal ones": np.repeat(spread[:6_000], 10),
        "of one pixel at one moment": np.full(60_000, 4, np.uint64),
        "within a microsecond": (spread & np.uint64(2**20 - 1))
        | (rng.integers(0, 1000, 60_000, np.uint64) << np.uint64(20)),
        "at both ends": (spread & np.uint64(2**20 - 1))
        | (rng.integers(0, 2, 60_000, np.uint64) * np.uint64(3_333_332 << 20)),
        "denser and denser": np.sqrt(rng.random(60_000) * 2.0**84).astype(np.uint64),
        "mostly early": (rng.random(60_000) ** 4 * 2.0**42).astype(np.uint64),
    }[name]


KEYS = ["none", "few", "many", "close together", "most in one row", "each in its own row", "far apart",
        "the largest lower halves", "equal ones", "all the same", "within a microsecond", "at both ends",
        "denser and denser", "mostly early", "of one pixel at one moment"]  # fmt: skip


@pytest.mark.parametrize("name", KEYS)
def test_keys_are_sorted(name: str) -> None:
    keys = keys_of(name)
    np.testing.assert_array_equal(in_order(keys.copy()), np.sort(keys))


@pytest.mark.parametrize("name", KEYS)
def test_keys_are_written_in_order(name: str) -> None:
    keys = keys_of(name)
    events = np.empty(keys.size, EVENT_DTYPE)
    write_in_order(keys.copy(), 20, 300, 5, events)
    ordered = np.sort(keys).astype(object)
    expected = [(key >> 3 & 0x1FFFF) % 300 for key in ordered]
    assert events["x"].tolist() == expected
    assert events["y"].tolist() == [(key >> 3 & 0x1FFFF) // 300 for key in ordered]
    assert events["t"].tolist() == [5 + (key >> 20) for key in ordered]
    assert events["pol"].tolist() == [bool(key & 4) for key in ordered]


@pytest.mark.parametrize("name", ["many", "close together", "denser and denser", "all the same"])
def test_it_does_not_matter_how_far_beyond_the_keys_their_bound_lies(name: str) -> None:
    keys = keys_of(name)
    for span in (int(keys.max()) + 1, int(keys.max()) + 12_345_678_901, 2**45, 2**62):
        np.testing.assert_array_equal(in_order(keys.copy(), span), np.sort(keys))


def test_many_keys_are_dealt_into_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the cases above would all be NumPy's sort against itself. Keys not spread evenly take two goes."""
    deal, collect = _event_order._deal, _event_order._collect
    dealt, collected = dict.fromkeys(KEYS, 0), dict.fromkeys(KEYS, 0)
    for name in KEYS:

        def count_deals(*arrays: np.ndarray, name: str = name) -> int:
            dealt[name] += 1
            return int(deal(*arrays))

        def count_keys(*arrays: np.ndarray, name: str = name) -> int:
            number = int(collect(*arrays))
            collected[name] += number
            return number

        monkeypatch.setattr(_event_order, "_deal", count_deals)
        monkeypatch.setattr(_event_order, "_collect", count_keys)
        in_order(keys_of(name))
    once = {"many", "close together", "the largest lower halves", "within a microsecond"}
    twice = {"equal ones", "denser and denser"}
    given_up = {
        "of one pixel at one moment",
        "all the same",
        "most in one row",
        "at both ends",
        "mostly early",
    }
    assert {name for name in KEYS if collected[name] == 60_000} == once | twice
    assert dealt == {name: (name in once | given_up) + 2 * (name in twice) for name in KEYS}


def scalar_events(
    before: np.ndarray, after: np.ndarray, reference: np.ndarray, threshold: float
) -> np.ndarray:
    """Each pixel by itself: thresholds from its reference on, each at its own time, sorted by (t, y, x, pol)."""
    found = []
    for (y, x), level in np.ndenumerate(reference):
        start, end, step_size = float(before[y, x]), float(after[y, x]), f32(threshold)
        number = int((after[y, x] - level) / step_size)
        signed = float(step_size) if number > 0 else -float(step_size)
        pace = STEP_NS / (end - start) if number and (end - start) * number > 0 else 0.0
        t = (signed - (start - float(level))) * pace
        for _ in range(abs(number)):
            found.append((x, y, int(min(max(t, 0.0), STEP_NS - 1.0)), number > 0))
            t += signed * pace
    events = np.array(found, EVENT_DTYPE)
    return events[np.lexsort((events["pol"], events["x"], events["y"], events["t"]))]


@pytest.mark.parametrize("threshold", [0.01, 0.02, 0.3])
def test_events_equal_those_of_pixels_followed_one_by_one(threshold: float) -> None:
    """To the byte, in order and in full, where there are too many for the room first made as where there are few."""
    movie, camera = 2 * smooth_sequence(6, frames=4, shape=(60, 91)), config(threshold)
    state = initial_state(movie[0], 0, camera, 0)
    numbers, most = [], 0
    for k, frame in enumerate(movie[1:]):
        expected = scalar_events(movie[k], frame, state.reference, threshold)
        expected["t"] += k * STEP_NS
        _, labelled, _ = step_labelled(state, frame, (k + 1) * STEP_NS, camera)
        state, events = step(state, frame, (k + 1) * STEP_NS, camera)
        assert events.tobytes() == expected.tobytes()
        assert labelled.tobytes() == expected.tobytes()
        numbers.append(len(events))
        most = max(most, np.unique(events[["x", "y"]], return_counts=True)[1].max())
    assert max(numbers) > {0.01: 6 * 60 * 91, 0.02: _event_order._FEW, 0.3: 0}[threshold]
    assert threshold > 0.01 or most > _fire_kernels.LADDER


@pytest.mark.parametrize("width", [1, 2, 3, 255, 256, 257, 1000, 65_535])
def test_pixels_are_named_in_pictures_of_any_width(width: int) -> None:
    height = max(1, 3_000 // width)
    camera = config(0.1)
    state = initial_state(np.zeros((height, width), f32), 0, camera, 0)
    _, events = step(state, np.full((height, width), 0.15, f32), STEP_NS, camera)
    y, x = np.divmod(np.arange(height * width), width)
    np.testing.assert_array_equal(events["x"], x)
    np.testing.assert_array_equal(events["y"], y)


SHAPE = (97, 301)


def pair_of(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Two frames whose events come spread over the interval or otherwise."""
    rng = np.random.default_rng(8)
    noise, dark = rng.uniform(-1, 1, SHAPE).astype(f32), np.zeros(SHAPE, f32)
    return {
        "spread": (noise, np.roll(noise, 1, axis=1)),
        "at a few moments": (dark, dark + f32(0.5)),
        "late": (dark, (0.2 + 4 * rng.random(SHAPE) ** 8).astype(f32)),
        "many of a pixel": (dark, 6 * noise),
    }[name]


@pytest.mark.parametrize(
    ("step_ns", "more"),
    [
        (1, {}), (17, {}), (40_000, {}), (STEP_NS, {}), (10**12, {}), (STEP_NS, {"refractory_ns": 20_000}),
        (STEP_NS, {"shot_hz": 200.0, "leak_hz": 5.0}), (STEP_NS, {"model": "carla"}), (STEP_NS, {"model": "v2e"}),
        (STEP_NS, {"bus_events_per_s": 1e7}),
    ],
    ids=str,
)  # fmt: skip
@pytest.mark.parametrize("name", ["spread", "at a few moments", "late", "many of a pixel"])
def test_events_are_those_that_numpy_sorts(
    name: str, step_ns: int, more: dict, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, after = pair_of(name)
    camera = replace(config(0.05), **more)
    state = initial_state(before, 7, camera, 0)
    _, events, labels = step_labelled(state, after, 7 + step_ns, camera)
    after_state, unlabelled = step(state, after, 7 + step_ns, camera)
    few = _event_order._FEW
    monkeypatch.setattr(_event_order, "_FEW", 1 << 62)
    _, expected, expected_labels = step_labelled(state, after, 7 + step_ns, camera)
    assert len(expected) > few or more
    assert events.tobytes() == unlabelled.tobytes() == expected.tobytes()
    same_state, unordered = step(state, after, 7 + step_ns, camera, ordered=False)
    pixel = unordered["y"].astype(int) * SHAPE[1] + unordered["x"]
    by_pixel = unordered[np.argsort(pixel, kind="stable")]  # a pixel's own are in order
    assert (np.diff(by_pixel["t"])[np.diff(np.sort(pixel)) == 0] >= 0).all()
    assert np.sort(unordered, order=["t", "y", "x", "pol"]).tobytes() == expected.tobytes()
    assert same_state.reference.tobytes() == after_state.reference.tobytes()
    assert (unordered.tobytes() == expected.tobytes()) == (
        camera.bus_events_per_s is not None or len(expected) == 0
    )
    np.testing.assert_array_equal(labels, expected_labels)
