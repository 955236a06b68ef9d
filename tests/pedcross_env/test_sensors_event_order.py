"""Events come in order, and are those of pixels followed one by one, however many there are and however they crowd."""

from __future__ import annotations

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
    }[name]


KEYS = ["none", "few", "many", "close together", "most in one row", "each in its own row", "far apart",
        "the largest lower halves", "equal ones", "all the same"]  # fmt: skip


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


def test_many_keys_are_dealt_into_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the cases above would all be NumPy's sort against itself."""
    dealt = []
    deal = _event_order._deal
    monkeypatch.setattr(_event_order, "_deal", lambda *arrays: (dealt.append(arrays[0].size), deal(*arrays)))
    for name in ("few", "many", "close together", "each in its own row", "most in one row", "far apart"):
        in_order(keys_of(name))
    assert dealt == [60_000, 60_000, 60_000]


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
