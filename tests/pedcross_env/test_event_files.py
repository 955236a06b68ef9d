"""Files of events: exact round trips, errors that say where, and the choice of the format."""

from __future__ import annotations

import sqlite3
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import ConfigError, DataError
from pedcross_env.sensors.event_files import FORMATS, read_events, write_events

SHAPE = (48, 64)
SUFFIXES = (".npz", ".h5", ".aedat4")
US_SUFFIXES = (".h5", ".aedat4")
BAG = Path(__file__).parents[3] / "shared/realdata/events/test_events_1.db3"
DV_FILE = Path(__file__).parents[1] / "data/dv_processing.aedat4"


def make_events(count: int, seed: int = 0, start_us: int = 1_700_000_000_000_000) -> np.ndarray:
    rng = np.random.default_rng(seed)
    events = np.empty(count, EVENT_DTYPE)
    events["x"], events["y"] = rng.integers(0, SHAPE[1], count), rng.integers(0, SHAPE[0], count)
    events["t"] = 1000 * (start_us + np.sort(rng.integers(0, 50_000, count)))
    events["pol"] = rng.random(count) < 0.5
    return events


@pytest.fixture(autouse=True)
def _libraries(request: pytest.FixtureRequest) -> None:
    if any(".h5" in str(value) for value in getattr(request.node, "callspec", _NoParameters).params.values()):
        pytest.importorskip("hdf5plugin", reason="DSEC's files need the extra 'events'")


class _NoParameters:
    params: dict[str, object] = {}  # noqa: RUF012


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("count", [0, 1, 20_000])  # none, one, several packets
def test_what_is_written_is_read_back_exactly(tmp_path: Path, suffix: str, count: int) -> None:
    events, path = make_events(count), tmp_path / f"e{suffix}"
    write_events(path, events, shape=SHAPE)
    back = read_events(path)
    np.testing.assert_array_equal(back.events, events)
    assert back.events.dtype == EVENT_DTYPE
    assert (back.shape, back.skipped) == (SHAPE, 0)
    assert suffix in FORMATS[back.format].suffixes
    assert list(tmp_path.iterdir()) == [path]


def test_npz_keeps_nanoseconds(tmp_path: Path) -> None:
    events = make_events(50)
    events["t"] += np.arange(50)
    write_events(tmp_path / "e.npz", events)
    back = read_events(tmp_path / "e.npz")
    np.testing.assert_array_equal(back.events, events)
    assert back.shape is None


@pytest.mark.parametrize("suffix", US_SUFFIXES)
def test_times_between_microseconds_are_refused_or_cut_down_as_asked(tmp_path: Path, suffix: str) -> None:
    events, path = make_events(50), tmp_path / f"e{suffix}"
    events["t"] += 999
    with pytest.raises(DataError, match=r"round_times=True.*npz"):
        write_events(path, events, shape=SHAPE)
    assert not list(tmp_path.iterdir())
    write_events(path, events, shape=SHAPE, round_times=True)
    np.testing.assert_array_equal(read_events(path).events["t"], events["t"] - 999)


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(share=st.floats(0, 0.999))
@settings(max_examples=12, deadline=None)
def test_a_truncated_file_is_an_error_that_names_it(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, share: float
) -> None:
    path = tmp_path_factory.mktemp("cut") / f"e{suffix}"
    write_events(path, make_events(3000), shape=SHAPE)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    with pytest.raises(DataError, match=r"e\.\w+"):
        read_events(path)


@pytest.mark.parametrize("cut", [1, 4, 60])
def test_an_aedat4_file_that_ends_within_its_table_is_truncated(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "e.aedat4"
    write_events(path, make_events(3000), shape=SHAPE)
    path.write_bytes(path.read_bytes()[:-cut])
    with pytest.raises(DataError, match=r"byte \d+: the table .* truncated"):
        read_events(path)


@pytest.mark.parametrize("suffix", [".npz", ".aedat4"])
def test_damage_inside_is_found_and_its_place_named(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"e{suffix}"
    write_events(path, make_events(3000), shape=SHAPE)
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 64] = bytes(64)
    path.write_bytes(data)
    with pytest.raises(DataError, match=r"byte \d+: .*(damaged|truncated)"):
        read_events(path)


def test_the_header_decides_whatever_the_suffix(tmp_path: Path) -> None:
    events = make_events(10)
    write_events(tmp_path / "e.npz", events)
    (tmp_path / "e.npz").rename(tmp_path / "e.aedat4")
    assert read_events(tmp_path / "e.aedat4").format == "npz"


def test_unknown_and_missing_files_name_what_is_allowed(tmp_path: Path) -> None:
    path = tmp_path / "e.bin"
    with pytest.raises(DataError, match="No such file"):
        read_events(path)
    path.touch()
    with pytest.raises(DataError, match="is empty"):
        read_events(path)
    path.write_bytes(b"hello, events")
    with pytest.raises(DataError, match=r"b'hello, e'.*npz \(\.npz\); dsec"):
        read_events(path)
    (tmp_path / "e.npz").write_bytes(b"hello, events")
    with pytest.raises(DataError, match=r"byte 0.*b'PK'"):
        read_events(tmp_path / "e.npz")
    (tmp_path / "e.raw").write_bytes(b"\x4e\x01\x00\x80")
    with pytest.raises(DataError, match="format='evt3'"):
        read_events(tmp_path / "e.raw")
    path.write_bytes(b"#!AER-DAT3.1\r\n")
    with pytest.raises(DataError, match=r"AEDAT 3\.1; only 4\.0"):
        read_events(path)
    with pytest.raises(ConfigError, match="Did you mean 'evt3'"):
        read_events(path, format="evt33")
    with pytest.raises(ConfigError, match=r"'\.raw' names no format that is written. Allowed: npz"):
        write_events(tmp_path / "e.raw", make_events(1))


def test_events_that_no_file_should_hold_are_refused(tmp_path: Path) -> None:
    events = make_events(10)
    with pytest.raises(DataError, match=r"is the shape given as \(width, height\)"):
        write_events(tmp_path / "e.npz", events, shape=(8, 8))
    with pytest.raises(DataError, match="argsort"):
        write_events(tmp_path / "e.npz", events[::-1])
    with pytest.raises(DataError, match="EVENT_DTYPE"):
        write_events(tmp_path / "e.npz", np.zeros(3))
    with pytest.raises(DataError, match=r"shape=\(height, width\)"):
        write_events(tmp_path / "e.aedat4", events)


def test_files_out_of_order_are_refused_or_sorted(tmp_path: Path) -> None:
    events = make_events(100)
    np.savez(tmp_path / "e.npz", events=events[::-1])
    with pytest.raises(DataError, match="sort=True"):
        read_events(tmp_path / "e.npz")
    np.testing.assert_array_equal(np.sort(read_events(tmp_path / "e.npz", sort=True).events), np.sort(events))


def test_other_peoples_npz_counts_in_microseconds(tmp_path: Path) -> None:
    events = make_events(20)
    theirs = np.empty(20, [("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("p", "i1")])
    theirs["x"], theirs["y"], theirs["t"] = events["x"], events["y"], events["t"] // 1000
    theirs["p"] = np.where(events["pol"], 1, -1)
    np.savez(tmp_path / "e.npz", events=theirs)
    np.testing.assert_array_equal(read_events(tmp_path / "e.npz").events, events)
    np.savez(tmp_path / "e.npz", events=np.zeros(3, [("x", "<i2"), ("y", "<i2"), ("t", "<i8")]))
    with pytest.raises(DataError, match="fields x, y, t and pol"):
        read_events(tmp_path / "e.npz")
    np.savez(tmp_path / "e.npz", something=theirs)
    with pytest.raises(DataError, match=r"holds something\.npy"):
        read_events(tmp_path / "e.npz")


def test_dsec_files_have_dsecs_datasets_and_index(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    pytest.importorskip("hdf5plugin")
    events, path = make_events(2000), tmp_path / "e.h5"
    write_events(path, events)
    with h5py.File(path) as file:
        t, index = file["events/t"][()].astype(np.int64), file["ms_to_idx"][()].astype(np.int64)
        assert {name: file[f"events/{name}"].dtype.str for name in "xypt"} == {
            "x": "<u2", "y": "<u2", "p": "|u1", "t": "<u4",
        }  # fmt: skip
        np.testing.assert_array_equal(t + file["t_offset"][()], events["t"] // 1000)
    for k, first in enumerate(index):
        assert t[first] >= 1000 * k
        assert first == 0 or t[first - 1] < 1000 * k
    assert index.size == t[-1] // 1000 + 1
    events["t"][-1] += 2**32 * 1000
    with pytest.raises(DataError, match="32-bit times hold 4295 s"):
        write_events(path, events)


def test_dsec_names_its_extra_where_it_is_not_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "hdf5plugin", None)
    with pytest.raises(ConfigError, match=r"pip install 'pedcross\[events\]'"):
        write_events(tmp_path / "e.h5", make_events(1))


def test_a_file_of_dv_processing_is_read() -> None:
    """50 events in 3 packets, written by iniVation's dv-processing 2.0.4 from this formula."""
    recording = read_events(DV_FILE)
    k = np.arange(50)
    assert recording.shape == SHAPE
    np.testing.assert_array_equal(recording.events["x"], 7 * k % 64)
    np.testing.assert_array_equal(recording.events["y"], 5 * k % 48)
    np.testing.assert_array_equal(recording.events["t"], 1000 * (1_700_000_000_000_000 + 37 * k * k))
    np.testing.assert_array_equal(recording.events["pol"], k % 3 == 0)


def test_every_byte_of_an_aedat4_header_may_be_wrong_without_a_stack_trace(tmp_path: Path) -> None:
    data, path = DV_FILE.read_bytes(), tmp_path / "e.aedat4"
    whole = read_events(DV_FILE).events
    packets = data.find(b"</dv>")
    for at in [*range(14, 60), *range(packets, packets + 60)]:
        for value in (0x00, 0x7F, 0xFF):
            path.write_bytes(data[:at] + bytes([value]) + data[at + 1 :])
            try:
                assert read_events(path).events.size <= whole.size
            except DataError as error:
                assert "e.aedat4" in str(error)  # noqa: PT017 - either is right, another exception is not


@pytest.mark.skipif(not BAG.exists(), reason=f"the real recording is not there: {BAG}")
def test_the_real_recording_has_its_published_events() -> None:
    recording = read_events(BAG)
    assert recording.events.size == 343_474
    assert np.count_nonzero(recording.events["pol"]) == 125_183
    assert (recording.shape, recording.skipped, recording.format) == ((480, 640), 0, "rosbag")


def test_a_damaged_or_foreign_bag_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "e.db3"
    with sqlite3.connect(path) as bag:
        bag.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT)")
        bag.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data BLOB)")
    with pytest.raises(DataError, match="no topic of type event_camera_msgs/msg/EventPacket"):
        read_events(path)
    with sqlite3.connect(path) as bag:
        bag.execute("INSERT INTO topics VALUES (1, '/events', 'event_camera_msgs/msg/EventPacket')")
        bag.execute("INSERT INTO messages VALUES (7, 1, 0, ?)", (b"\0\1\0\0" + bytes(10),))
    with pytest.raises(DataError, match="message 7: byte 14: the message ends too early"):
        read_events(path)
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(DataError, match="sqlite cannot read the bag of 5000 bytes"):
        read_events(path)
