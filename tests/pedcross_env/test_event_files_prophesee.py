"""Prophesee's formats, against encoders written here from the documented bit layouts, word by word."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pedcross_env.contracts import EVENT_DTYPE
from pedcross_env.errors import DataError
from pedcross_env.sensors.event_files import read_events

Event = tuple[int, int, int, bool]  # x, y, t in us, polarity
RAW_HEADER = b"% evt {}\n% geometry 640x480\n% end\n"
DAT_HEADER = b"% Data file containing CD events\n% Version 2\n% Width 640\n% Height 480\n"


def make_events(seed: int, span_us: int, count: int = 300) -> list[Event]:
    """Sorted by time, then row, polarity and column, several at a time: what a readout would send."""
    rng = np.random.default_rng(seed)
    times = rng.choice(np.arange(count // 4) * max(1, span_us // (count // 4)), count)
    rows, polarities = rng.integers(0, 480, 4), rng.random(count) < 0.5
    drawn = zip(times, rng.choice(rows, count), polarities, rng.integers(300, 360, count), strict=True)
    return [(int(x), int(y), int(t), bool(p)) for t, y, p, x in sorted(set(drawn))]


def as_array(events: Iterable[Event]) -> np.ndarray:
    return np.array([(x, y, 1000 * t, p) for x, y, t, p in events], EVENT_DTYPE)


def encode_dat(events: list[Event]) -> bytes:
    return b"\x0c\x08" + b"".join(
        struct.pack("<II", t % 2**32, x | y << 14 | p << 28) for x, y, t, p in events
    )


def encode_evt2(events: list[Event]) -> bytes:
    words, high = [], None
    for x, y, t, p in events:
        if t >> 6 != high:
            high = t >> 6
            words.append(0x8 << 28 | high & 0xFFFFFFF)
        words.append(int(p) << 28 | (t & 0x3F) << 22 | x << 11 | y)
    return struct.pack(f"<{len(words)}I", *words)


def encode_evt21(events: list[Event], *, legacy: bool) -> bytes:
    """Runs of one row, polarity and time within 32 aligned columns as one word."""
    words: list[tuple[int, int]] = []
    high, k = None, 0
    while k < len(events):
        x, y, t, p = events[k]
        if t >> 6 != high:
            high = t >> 6
            words.append((0x8 << 28 | high & 0xFFFFFFF, 0))
        run = k
        while run < len(events) and events[run][1:] == (y, t, p) and events[run][0] >> 5 == x >> 5:
            run += 1
        pixels = sum(1 << (event[0] & 31) for event in events[k:run])
        words.append((int(p) << 28 | (t & 0x3F) << 22 | (x & ~31) << 11 | y, pixels))
        k = run
    if legacy:
        return b"".join(struct.pack("<II", head, pixels) for head, pixels in words)
    return b"".join(struct.pack("<Q", head << 32 | pixels) for head, pixels in words)


def encode_evt3(events: list[Event], *, vectors: bool) -> bytes:
    """Send what changed; with ``vectors``, runs of one row, polarity and time as vectors of 12 and 8 pixels."""
    words: list[int] = []
    high = low = row = None
    k = 0
    while k < len(events):
        x, y, t, p = events[k]
        if t >> 12 != high:
            high, low = t >> 12, None
            words.append(0x8000 | high & 0xFFF)
        if t & 0xFFF != low:
            low = t & 0xFFF
            words.append(0x6000 | low)
        if y != row:
            row = y
            words.append(0x0000 | y)
        run = k
        while run < len(events) and events[run][1:] == (y, t, p):
            run += 1
        columns = {event[0] for event in events[k:run]}
        if vectors and len(columns) > 1:
            words.append(0x3000 | int(p) << 11 | x)
            at, last, long = x, max(columns), True
            while at <= last:
                size = 12 if long else 8
                mask = sum(1 << bit for bit in range(size) if at + bit in columns)
                words.append((0x4000 if long else 0x5000) | mask)
                at, long = at + size, not long
            k = run
        else:
            words.append(0x2000 | int(p) << 11 | x)
            k += 1
    return struct.pack(f"<{len(words)}H", *words)


def write(path: Path, name: str, body: bytes) -> Path:
    """A file of an encoding, or of "evt21" and the order of its halves."""
    encoding, _, kind = name.partition(" ")
    header = DAT_HEADER
    if encoding != "dat":
        header = RAW_HEADER.replace(b"{}", f"{encoding[3]}.{encoding[4:] or 0}".encode())
    if encoding == "evt21":
        header = header.replace(b"% end", f"% format EVT21;endianness={kind}\n% end".encode())
    path.write_bytes(header + body)
    return path


ENCODERS = {
    "dat": encode_dat,
    "evt2": encode_evt2,
    "evt21 little": lambda events: encode_evt21(events, legacy=False),
    "evt21 legacy": lambda events: encode_evt21(events, legacy=True),
    "evt3": lambda events: encode_evt3(events, vectors=False),
    "evt3 vectors": lambda events: encode_evt3(events, vectors=True),
}


@pytest.mark.parametrize("name", ENCODERS)
@given(seed=st.integers(0, 2**32 - 1), span_us=st.sampled_from([40, 5000, 2_000_000]))
@settings(max_examples=15, deadline=None)
def test_what_was_encoded_is_read(
    tmp_path_factory: pytest.TempPathFactory, name: str, seed: int, span_us: int
) -> None:
    events, encoding = make_events(seed, span_us), name.split()[0]
    path = tmp_path_factory.mktemp("p") / ("e.dat" if encoding == "dat" else "e.raw")
    recording = read_events(write(path, name, ENCODERS[name](events)))
    np.testing.assert_array_equal(recording.events, as_array(events))
    assert (recording.shape, recording.format, recording.skipped) == ((480, 640), encoding, 0)


@pytest.mark.parametrize("name", ENCODERS)
def test_no_events_and_one_event_are_read(tmp_path: Path, name: str) -> None:
    for events in ([], [(639, 479, 12_345, True)]):
        path = write(tmp_path / f"e.{'dat' if name == 'dat' else 'raw'}", name, ENCODERS[name](events))
        np.testing.assert_array_equal(read_events(path).events, as_array(events))


@pytest.mark.parametrize(
    ("name", "bits"), [("dat", 32), ("evt2", 34), ("evt21 legacy", 34), ("evt3", 24), ("evt3 vectors", 24)]
)
def test_clocks_that_wrap_go_on(tmp_path: Path, name: str, bits: int) -> None:
    times = [(1 << bits) - 3000, (1 << bits) - 1, 1 << bits, (1 << bits) + 9000]
    events = [(5 + k, 7, t, k % 2 == 0) for k, t in enumerate(times)]
    path = write(tmp_path / "e.raw", name, ENCODERS[name](events))
    np.testing.assert_array_equal(read_events(path).events, as_array(events))


def test_evt3_repeats_its_high_time_without_losing_the_low_one(tmp_path: Path) -> None:
    words = [0x8001, 0x6123, 0x0005, 0x2007, 0x8001, 0x2008, 0x8002, 0x2009]
    path = write(tmp_path / "e.raw", "evt3", struct.pack("<8H", *words))
    assert (read_events(path).events["t"] // 1000).tolist() == [0x1123, 0x1123, 0x2000]


@pytest.mark.parametrize(
    ("encoding", "words", "kept"),
    [
        ("evt2", [0x10000000, 0x80000001, 0x10000801], 1),
        ("evt3", [0x2003, 0x4FFF, 0x8001, 0x0001, 0x4FFF, 0x2003], 1),
    ],
)
def test_events_before_the_first_time_and_address_are_left_out_and_counted(
    tmp_path: Path, encoding: str, words: list[int], kept: int
) -> None:
    body = struct.pack(f"<{len(words)}{'I' if encoding == 'evt2' else 'H'}", *words)
    recording = read_events(write(tmp_path / "e.raw", encoding, body))
    assert recording.events.size == kept
    assert recording.skipped == {"evt2": 1, "evt3": 3}[encoding]


@pytest.mark.parametrize("order", ["little", "legacy"])
def test_events_of_evt21_before_the_first_time_are_counted_one_by_one(tmp_path: Path, order: str) -> None:
    halves = [(0x10000000, 0b101), (0x80000001, 0), (0xA0000000, 0xFFFF), (0x10010001, 1 << 31 | 2)]
    body = b"".join(struct.pack("<II", *(half if order == "legacy" else half[::-1])) for half in halves)
    recording = read_events(write(tmp_path / "e.raw", f"evt21 {order}", body))
    assert recording.skipped == 2
    assert recording.events.tolist() == [(33, 1, 64_000, True), (63, 1, 64_000, True)]


def test_a_word_of_evt21_of_unknown_kind_or_order_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "e.raw", "evt21 legacy", b"")
    begin = path.stat().st_size
    path = write(tmp_path / "e.raw", "evt21 legacy", struct.pack("<4I", 0x80000001, 0, 0x50000000, 0))
    with pytest.raises(DataError, match=rf"byte {begin + 8}: word of kind 0x5, which EVT2\.1 does not have"):
        read_events(path)
    with pytest.raises(DataError, match="endianness=big; read are little and legacy"):
        read_events(write(tmp_path / "e.raw", "evt21 big", b""))


def test_triggers_and_continuations_are_passed_over(tmp_path: Path) -> None:
    words = [0x8001, 0x0001, 0xA101, 0x7005, 0xF123, 0xE000, 0x2003]
    assert read_events(write(tmp_path / "e.raw", "evt3", struct.pack("<7H", *words))).events.size == 1


@pytest.mark.parametrize("name", ENCODERS)
def test_a_file_cut_inside_a_word_says_at_which_byte(tmp_path: Path, name: str) -> None:
    path = write(tmp_path / "e.raw", name, ENCODERS[name](make_events(1, 5000)))
    data = path.read_bytes()
    path.write_bytes(data[:-1])
    word = {"dat": 8, "evt2": 4, "evt21": 8, "evt3": 2}[name.split()[0]]
    with pytest.raises(DataError, match=rf"byte {len(data) - word}: the file ends {word - 1} bytes into a"):
        read_events(path)


@pytest.mark.parametrize(
    ("encoding", "words", "place"),
    [("evt2", [0x80000001, 0x50000000], 4), ("evt3", [0x8001, 0x0001, 0x9000], 4)],
)
def test_a_word_of_unknown_kind_is_named_with_its_byte(
    tmp_path: Path, encoding: str, words: list[int], place: int
) -> None:
    path = write(tmp_path / "e.raw", encoding, b"")
    begin = path.stat().st_size
    path.write_bytes(
        path.read_bytes() + struct.pack(f"<{len(words)}{'I' if encoding == 'evt2' else 'H'}", *words)
    )
    with pytest.raises(DataError, match=rf"byte {begin + place}: word of kind 0x[59]"):
        read_events(path)


@pytest.mark.parametrize("name", ENCODERS)
def test_an_address_outside_the_sensor_is_named_with_its_byte(tmp_path: Path, name: str) -> None:
    path = write(tmp_path / "e.raw", name, ENCODERS[name]([(3, 3, 9, True), (700, 3, 9, True)]))
    with pytest.raises(DataError, match=r"byte \d+: event at x = 700, y = 3, outside the header's 640x480"):
        read_events(path)


def test_headers_of_all_ages_are_understood(tmp_path: Path) -> None:
    body = encode_evt3([(3, 4, 5, True)], vectors=False)
    path = tmp_path / "e.raw"
    for header in (
        b"% format EVT3;height=720;width=1280\n",
        b"% Date 2020-01-01\n% evt 3.0 \n",
        b"%evt 3.0\n%end\n",
    ):
        path.write_bytes(header + body)
        recording = read_events(path)
        assert recording.events.size == 1
        assert recording.shape == ((720, 1280) if b"height" in header else None)
    path.write_bytes(b"% format EVT4;height=720;width=1280\n")
    with pytest.raises(DataError, match=r"EVT 4\.0; read are EVT 2\.0, 2\.1 and 3\.0"):
        read_events(path)
    path.write_bytes(b"% Date 2020-01-01\n" + body)
    with pytest.raises(DataError, match="format='evt3'"):
        read_events(path)
    assert read_events(path, format="evt3").events.size == 1


def test_a_dat_file_of_other_events_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "e.dat"
    path.write_bytes(DAT_HEADER + b"\x0e\x08")
    with pytest.raises(DataError, match="event type 14 of 8 bytes, expected type 0 or 12"):
        read_events(path)
    path.write_bytes(DAT_HEADER + b"\x0c")
    with pytest.raises(DataError, match="ends before the event type"):
        read_events(path)
