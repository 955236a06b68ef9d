"""Prophesee's files: decoded events (DAT) and what the sensor sends (RAW with EVT2, EVT2.1 or EVT3 inside).

All begin with text lines "% keyword value". Layouts after Prophesee's documentation of the formats ("DAT File Format",
"EVT 2.0 Format", "EVT 2.1 Format", "EVT 3.0 Format"); little-endian, times in microseconds.

    DAT   after the text two bytes, event type and record size (8); records: u32 t, u32 with x in bits 0-13, y 14-27,
          polarity 28
    EVT2  u32 words, kind in bits 28-31. 0 OFF, 1 ON: bits 22-27 low time, x 11-21, y 0-10. 8: bits 0-27 high time
    EVT21 u64 words: the upper half a word of EVT2, the lower one a bit for each of the 32 pixels from its x on; where
          the header says "endianness=legacy" (IMX636), the upper half comes first
    EVT3  u16 words, kind in bits 12-15. 0 y; 2 x and polarity (bit 11): an event; 3 x and polarity of the first pixel
          of vectors; 4, 5 vector of 12, 8 pixels, a bit each; 6 low time (12 bit); 8 high time (12 bit, wraps)
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pedcross_env.errors import DataError
from pedcross_env.sensors.event_files.recording import Recording, damaged, join

__all__ = [
    "decode_evt2", "decode_evt3", "read_dat", "read_evt2", "read_evt21", "read_evt3", "recognise",
]  # fmt: skip

_RECORD_BYTES = 8
_CD_TYPES = (0x00, 0x0C)  # Event2d and EventCD of DAT
_ENCODINGS = {"2.0": "evt2", "2.1": "evt21", "3.0": "evt3"}
_EVT2_KINDS = (0x0, 0x1, 0x8, 0xA, 0xE, 0xF)
_EVT3_KINDS = (0x0, 0x2, 0x3, 0x4, 0x5, 0x6, 0x7, 0x8, 0xA, 0xE, 0xF)
_ADDR_Y, _ADDR_X, _VECT_BASE_X, _VECT_12, _VECT_8, _TIME_LOW, _TIME_HIGH = 0x0, 0x2, 0x3, 0x4, 0x5, 0x6, 0x8

Where = Callable[[int], tuple[str, int]]
"""Byte of the decoded words to the name of the file (or message) and the byte in it."""


def _header(data: bytes) -> tuple[dict[str, str], int]:
    """Keywords in lower case to values, and the byte at which the binary part begins."""
    values: dict[str, str] = {}
    at = 0
    while data[at : at + 1] == b"%":
        end = data.find(b"\n", at)
        if end < 0:
            break
        line = data[at + 1 : end].decode("latin-1").strip()
        at = end + 1
        if line == "end":
            break
        key, _, value = line.partition(" ")
        values[key.lower()] = value.strip()
    return values, at


def _shape(values: dict[str, str]) -> tuple[int, int] | None:
    """(height, width) from whichever of the known lines is there."""
    geometry = re.fullmatch(r"(\d+)\s*x\s*(\d+)", values.get("geometry", ""))
    if geometry:
        return int(geometry[2]), int(geometry[1])
    options = _options(values)
    height, width = options.get("height", values.get("height")), options.get("width", values.get("width"))
    return (int(height), int(width)) if height and width and height.isdigit() and width.isdigit() else None


def _options(values: dict[str, str]) -> dict[str, str]:
    """What the line "format" says beside the encoding: height, width, endianness."""
    return dict(re.findall(r"(\w+)=(\w+)", values.get("format", "")))


def _encoding(values: dict[str, str]) -> str | None:
    """What a RAW header calls its words: "2.0", "2.1", "3.0"; None without such a line."""
    named = re.match(r"EVT\s*(\d)(\d?)", values.get("format", ""), re.IGNORECASE)
    if named:
        return f"{named[1]}.{named[2] or 0}"
    return values.get("evt")


def recognise(path: Path, head: bytes) -> str:
    """Name the format of a file that begins with "%"; DataError where its header does not tell."""
    values, _ = _header(head)
    encoding = _encoding(values)
    if encoding in _ENCODINGS:
        return _ENCODINGS[encoding]
    if encoding is not None:
        raise DataError(
            f"{path}: its header says EVT {encoding}; read are EVT 2.0, 2.1 and 3.0: convert the recording."
        )
    if "data" in values or path.suffix.lower() == ".dat":
        return "dat"
    raise DataError(
        f"{path}: its header has no line '% evt 3.0' or '% format EVT3'; name the encoding: "
        f"read_events(path, format='evt3'), 'evt21' or 'evt2' (or 'dat')."
    )


def _words(path: Path, dtype: str) -> tuple[dict[str, str], np.ndarray, int]:
    """Header, all words after it, and the byte of the first; refuses a file that ends within a word."""
    data = path.read_bytes()
    values, begin = _header(data)
    size = np.dtype(dtype).itemsize
    rest = (len(data) - begin) % size
    if rest:
        raise damaged(
            path, len(data) - rest, f"the file ends {rest} bytes into a word of {size}: it is truncated"
        )
    return values, np.frombuffer(data, dtype, offset=begin), begin


def read_dat(path: Path) -> Recording:
    """Read a DAT file; see formats.read_events."""
    data = path.read_bytes()
    values, begin = _header(data)
    if len(data) < begin + 2:
        raise damaged(path, len(data), "the file ends before the event type and size that follow the header")
    kind, size = data[begin], data[begin + 1]
    if kind not in _CD_TYPES or size != _RECORD_BYTES:
        raise damaged(
            path, begin, f"event type {kind} of {size} bytes, expected type 0 or 12 (change detection) of 8 bytes",
            "convert other types of event first",
        )  # fmt: skip
    begin += 2
    rest = (len(data) - begin) % _RECORD_BYTES
    if rest:
        raise damaged(
            path, len(data) - rest, f"the file ends {rest} bytes into a record of 8: it is truncated"
        )
    records = np.frombuffer(data, "<u4", offset=begin).reshape(-1, 2)
    t, bits = records[:, 0].astype(np.int64), records[:, 1]
    x, y, on = bits & 0x3FFF, bits >> 14 & 0x3FFF, (bits >> 28 & 1).astype(bool)
    shape = _shape(values)
    _check_inside(x, y, shape, np.arange(t.size) * _RECORD_BYTES + begin, lambda byte: (str(path), byte))
    return Recording(join(x, y, _unwrap(t, 32), on, path=path, what="records"), shape, "dat")


def read_evt2(path: Path) -> Recording:
    """Read a RAW file of EVT2 words; see formats.read_events."""
    values, words, begin = _words(path, "<u4")
    shape = _shape(values)
    events, skipped = decode_evt2(words, shape, lambda byte: (str(path), begin + byte))
    return Recording(events, shape, "evt2", skipped)


def read_evt21(path: Path) -> Recording:
    """Read a RAW file of EVT2.1 words; see formats.read_events."""
    values, words, begin = _words(path, "<u8")
    order = _options(values).get("endianness", "little")
    if order not in ("little", "legacy"):
        raise DataError(
            f"{path}: its header says endianness={order}; read are little and legacy: convert the recording."
        )
    halves, shape = words.view("<u4").reshape(-1, 2), _shape(values)
    head, pixels = halves.T if order == "legacy" else halves.T[::-1]
    events, skipped = decode_evt2(head, shape, lambda byte: (str(path), begin + byte), pixels)
    return Recording(events, shape, "evt21", skipped)


def read_evt3(path: Path) -> Recording:
    """Read a RAW file of EVT3 words; see formats.read_events."""
    values, words, begin = _words(path, "<u2")
    shape = _shape(values)
    events, skipped = decode_evt3(words, shape, lambda byte: (str(path), begin + byte))
    return Recording(events, shape, "evt3", skipped)


def _unwrap(counter: np.ndarray, bits: int) -> np.ndarray:
    """Turn a counter of ``bits`` that wraps into one that does not; steps over half its range are wraps."""
    half = 1 << (bits - 1)
    step = np.diff(counter)
    turns = np.cumsum((step < -half).astype(np.int64) - (step > half))
    out = counter.astype(np.int64)
    out[1:] += turns << bits
    return out


def _check_kinds(kind: np.ndarray, allowed: tuple[int, ...], name: str, size: int, where: Where) -> None:
    known = np.zeros(16, bool)
    known[list(allowed)] = True
    bad = np.flatnonzero(~known[kind])
    if bad.size:
        path, byte = where(int(bad[0]) * size)
        raise damaged(
            path, byte, f"word of kind {kind[bad[0]]:#x}, which {name} does not have: damaged, or no {name}"
        )


def _check_inside(
    x: np.ndarray, y: np.ndarray, shape: tuple[int, int] | None, byte: np.ndarray, where: Where
) -> None:
    if shape is None:
        return
    bad = np.flatnonzero((x >= shape[1]) | (y >= shape[0]))
    if bad.size:
        k = int(bad[0])
        path, at = where(int(byte[k]))
        raise damaged(
            path, at, f"event at x = {x[k]}, y = {y[k]}, outside the header's {shape[1]}x{shape[0]} sensor"
        )


def _last(mask: np.ndarray) -> np.ndarray:
    """Index of the last True up to each place, -1 before the first."""
    return np.maximum.accumulate(np.where(mask, np.arange(mask.size), -1))


def decode_evt2(
    words: np.ndarray, shape: tuple[int, int] | None, where: Where, pixels: np.ndarray | None = None
) -> tuple[np.ndarray, int]:
    """Decode EVT2 words, (N,) uint32: (events, number of events before the first high time, which are left out).

    Args:
        words: All of a stream.
        shape: (height, width) that addresses are held against, or None.
        where: Names a byte of the words in errors.
        pixels: The other halves of EVT2.1 words, (N,) uint32: bit k for an event k pixels beside x; None: EVT2.
    """
    name, size = ("EVT2", 4) if pixels is None else ("EVT2.1", 8)
    kind = words >> 28
    _check_kinds(kind, _EVT2_KINDS, name, size, where)
    is_high = kind == 0x8
    high = _unwrap((words[is_high] & 0xFFFFFFF).astype(np.int64), 28)
    order = np.cumsum(is_high) - 1  # of the high time in force at each word
    at = np.flatnonzero(kind <= 1)
    beside = np.zeros(at.size, np.int64)
    if pixels is not None:
        bits = np.unpackbits(
            pixels[at].astype("<u4").view(np.uint8).reshape(-1, 4), axis=1, bitorder="little"
        )
        hit, beside = np.nonzero(bits)
        at = at[hit]
    timed = order[at] >= 0
    chosen = at[timed]
    word = words[chosen]
    t = (high[order[chosen]] << 6) + (word >> 22 & 0x3F)
    x, y = (word >> 11 & 0x7FF) + beside[timed], word & 0x7FF
    _check_inside(x, y, shape, size * chosen, where)
    return join(x, y, t, kind[chosen] == 1, path=where(0)[0], what=name), at.size - chosen.size


def decode_evt3(words: np.ndarray, shape: tuple[int, int] | None, where: Where) -> tuple[np.ndarray, int]:
    """Decode EVT3 words, (N,) uint16: (events, number of words with events before time and address are known).

    The format has a state (time, row, base of vectors); here each word's state is looked up as the last word of the
    kind that sets it, so that no loop runs over words. Arguments as decode_evt2.
    """
    kind, payload = words >> 12, (words & 0xFFF).astype(np.int64)
    _check_kinds(kind, _EVT3_KINDS, "EVT3", 2, where)
    t_us = _evt3_times(kind, payload)
    row, base = _last(kind == _ADDR_Y), _last(kind == _VECT_BASE_X)

    single = np.flatnonzero(kind == _ADDR_X)
    vector = np.flatnonzero((kind == _VECT_12) | (kind == _VECT_8))
    known = (t_us >= 0) & (row >= 0)
    usable, vectors = single[known[single]], vector[known[vector] & (base[vector] >= 0)]
    skipped = single.size - usable.size + vector.size - vectors.size

    # A vector begins where the last one since its base ended.
    length = np.where(kind == _VECT_12, 12, 0) + np.where(kind == _VECT_8, 8, 0)
    before = np.cumsum(length) - length
    first_x = (payload[base[vectors]] & 0x7FF) + before[vectors] - before[base[vectors]]
    valid = payload[vectors] & np.where(kind[vectors] == _VECT_12, 0xFFF, 0xFF)
    hit, bit = np.nonzero(valid[:, None] >> np.arange(12) & 1)

    word = np.concatenate([usable, vectors[hit]])
    x = np.concatenate([payload[usable] & 0x7FF, first_x[hit] + bit])
    on = np.concatenate([payload[usable], payload[base[vectors[hit]]]]) >> 11 > 0
    order = np.argsort(word, kind="stable")  # bits of a vector stay in their order
    word, x, on = word[order], x[order], on[order]
    y = payload[row[word]] & 0x7FF
    _check_inside(x, y, shape, 2 * word, where)
    return join(x, y, t_us[word], on, path=where(0)[0], what="EVT3"), skipped


def _evt3_times(kind: np.ndarray, payload: np.ndarray) -> np.ndarray:
    """Time at each word in us, (N,) int64; -1 before the first high time."""
    at_high = np.flatnonzero(kind == _TIME_HIGH)
    if at_high.size == 0:
        return np.full(kind.size, -1, np.int64)
    high = _unwrap(payload[at_high], 12)
    order = np.cumsum(kind == _TIME_HIGH) - 1
    # A low time belongs to the high time it follows: where that has moved on, it starts again at 0.
    moved = np.concatenate([[True], np.diff(high) != 0])
    since = at_high[np.maximum.accumulate(np.where(moved, np.arange(high.size), 0))]
    low = _last(kind == _TIME_LOW)
    fresh = low > since[np.maximum(order, 0)]
    t_us = (high[np.maximum(order, 0)] << 12) + np.where(fresh, payload[np.maximum(low, 0)], 0)
    return np.where(order >= 0, t_us, -1)
