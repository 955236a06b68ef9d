"""AEDAT 4.0, the files of iniVation's DV software. No library of theirs is needed: Arrow has both compressions.

    14 bytes "#!AER-DAT4.0\\r\\n"
    IOHeader     a size-prefixed FlatBuffer "IOHE": compression (i32), dataTablePosition (i64), infoNode (XML string)
    packets      i32 stream, i32 size, then so many bytes: a compressed size-prefixed FlatBuffer; that of events,
                 "EVTS", is a vector of 16-byte structs (i64 t in us, i16 x, i16 y, bool on)
    data table   at dataTablePosition up to the end, compressed, "FTAB": each packet's place, size and times

The XML names each stream and its type. Layout after iniVation's documentation and what dv-processing 2.0.4 writes.
"""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from pedcross_env.errors import ConfigError, DataError
from pedcross_env.sensors.event_files.flatbuffer import LayoutError, root
from pedcross_env.sensors.event_files.recording import Recording, damaged, join, whole_us

__all__ = ["read", "write"]

_MAGIC = b"#!AER-DAT4.0\r\n"
_COMPRESSIONS = {0: None, 1: "lz4", 2: "lz4", 3: "zstd", 4: "zstd"}  # NONE, LZ4, LZ4_HIGH, ZSTD, ZSTD_HIGH
_EVENT = np.dtype([("t", "<i8"), ("x", "<i2"), ("y", "<i2"), ("on", "u1"), ("pad", "V3")])
_LZ4 = 1
_PACKET_EVENTS = 8192
_LARGEST_ADDRESS = 2**15 - 1
_SOURCE = "pedcross"


def _decompress(data: bytes, codec: str | None) -> bytes:
    if codec is None:
        return data
    import pyarrow as pa

    with pa.input_stream(pa.py_buffer(data), compression=codec) as stream:
        return bytes(stream.read())


def _event_streams(xml: str) -> dict[int, tuple[int, int] | None]:
    """Number of each stream of events to its (height, width), from the header's XML."""
    streams: dict[int, tuple[int, int] | None] = {}
    tree = ElementTree.fromstring(xml)
    for node in tree.iterfind("./node[@name='outInfo']/node"):
        attributes = {a.get("key"): a.text or "" for a in node.iterfind("attr")}
        if attributes.get("typeIdentifier") != "EVTS":
            continue
        info = {a.get("key"): a.text or "" for a in node.iterfind("./node[@name='info']/attr")}
        sized = "sizeX" in info and "sizeY" in info
        streams[int(node.get("name", ""))] = (int(info["sizeY"]), int(info["sizeX"])) if sized else None
    return streams


def read(path: Path, stream: int | None = None) -> Recording:
    """Read the events of an AEDAT4 file; its frames, IMU samples and triggers are passed over.

    Args:
        path: Of the file.
        stream: Number of the stream, where the file has several of events.

    Raises:
        DataError: For a truncated or damaged file, or several streams without a choice.
    """
    data = path.read_bytes()
    at = len(_MAGIC)
    if not data.startswith(_MAGIC):
        raise damaged(path, 0, f"begins with {data[:14]!r}, expected {_MAGIC!r}")
    try:
        header = root(data[at:], b"IOHE")
        compression, table_at = header.number(0, "i", 0), header.number(1, "q", -1)
        xml_at, xml_bytes = header.vector(2, 1)
        streams = _event_streams(header.data[xml_at : xml_at + xml_bytes].decode())
    except (LayoutError, ValueError, ElementTree.ParseError) as error:
        raise damaged(path, at, f"the header that begins here cannot be read ({error})") from error
    if compression not in _COMPRESSIONS:
        raise damaged(path, at, f"the header names compression {compression}; known are 0 to 4")
    number = _choose(path, streams, stream)
    at += 4 + int.from_bytes(data[at : at + 4], "little")
    end = len(data) if table_at < 0 else table_at
    if end > len(data):
        raise damaged(path, len(data), f"the file ends, but its table is at byte {end}: it is truncated")
    if table_at >= 0:
        _check_table(path, table_at, data[table_at:], _COMPRESSIONS[compression])
    parts = [np.empty(0, _EVENT)]
    while at < end:
        if at + 8 > end:
            raise damaged(path, at, f"{end - at} bytes where a packet's header of 8 is expected: truncated")
        found, size = struct.unpack_from("<ii", data, at)
        if size <= 0 or at + 8 + size > end:
            raise damaged(
                path, at, f"a packet of {size} bytes, where {end - at - 8} are left: truncated or damaged"
            )
        if found == number:
            parts.append(_packet(path, at, data[at + 8 : at + 8 + size], _COMPRESSIONS[compression]))
        at += 8 + size
    events = np.concatenate(parts)
    out = join(events["x"], events["y"], events["t"], events["on"] > 0, path=path, what=f"stream {number}")
    return Recording(out, streams[number], "aedat4")


def _check_table(path: Path, at: int, data: bytes, codec: str | None) -> None:
    """Refuse a file that ends within its table, which nothing else is read from."""
    try:
        root(_decompress(data, codec), b"FTAB")
    except (LayoutError, OSError, ValueError) as error:
        raise damaged(
            path, at, f"the table of {len(data)} bytes that begins here is truncated or damaged ({error})"
        ) from error


def _choose(path: Path, streams: dict[int, tuple[int, int] | None], stream: int | None) -> int:
    names = ", ".join(map(str, sorted(streams))) or "none"
    if stream is None and len(streams) == 1:
        return next(iter(streams))
    if not streams:
        raise DataError(f"{path} has no stream of events (type EVTS); record the event camera's output.")
    if stream is None:
        raise DataError(
            f"{path} has several streams of events ({names}); choose one: "
            f"pedcross_env.sensors.event_files.aedat4.read(path, stream=...)."
        )
    if stream not in streams:
        raise ConfigError(f"stream = {stream} is not allowed: {path} has streams of events {names}.")
    return stream


def _packet(path: Path, at: int, data: bytes, codec: str | None) -> np.ndarray:
    try:
        table = root(_decompress(data, codec), b"EVTS")
        first, count = table.vector(0, _EVENT.itemsize)
        return np.frombuffer(table.data, _EVENT, count, first)
    except (LayoutError, OSError, ValueError) as error:
        raise damaged(
            path, at, f"the packet of {len(data)} bytes that begins here is damaged ({error})"
        ) from error


def write(path: Path, events: np.ndarray, shape: tuple[int, int] | None, round_times: bool) -> None:
    """Write an AEDAT4 file with LZ4; see formats.write_events.

    Raises:
        DataError: Without a shape, for addresses beyond 32767, or times that are no whole microseconds.
    """
    import pyarrow as pa

    if shape is None:
        raise DataError("AEDAT4 needs the sensor's size: write_events(path, events, shape=(height, width)).")
    if events.size and max(events["x"].max(), events["y"].max()) > _LARGEST_ADDRESS:
        raise DataError(f"AEDAT4 holds addresses up to {_LARGEST_ADDRESS}; write .npz or .h5 instead.")
    records = np.zeros(events.size, _EVENT)
    records["t"] = whole_us(events, "AEDAT4", round_times=round_times)
    records["x"], records["y"], records["on"] = events["x"], events["y"], events["pol"]

    codec = pa.Codec("lz4")
    chunks = [records[k : k + _PACKET_EVENTS] for k in range(0, records.size, _PACKET_EVENTS)]
    bodies = [codec.compress(_events_buffer(chunk), asbytes=True) for chunk in chunks]
    xml = _info_xml(shape).encode()
    at = len(_MAGIC) + len(_header_buffer(xml, 0))
    places = []
    for body, chunk in zip(bodies, chunks, strict=True):
        places.append((at + 8, len(body), chunk.size, int(chunk["t"][0]), int(chunk["t"][-1])))
        at += 8 + len(body)
    with path.open("wb") as file:
        file.write(_MAGIC + _header_buffer(xml, at))
        for body in bodies:
            file.write(struct.pack("<ii", 0, len(body)) + body)
        file.write(codec.compress(_table_buffer(places), asbytes=True))


def _events_buffer(records: np.ndarray) -> bytes:
    # size, root table at 20, identifier; vtable at 14; the table's one field: the vector, its items at 32
    head = struct.pack("<I4s2x3Hii", 16, b"EVTS", 6, 8, 4, 6, 4) + struct.pack("<I", records.size)
    return _sized(head + records.tobytes())


def _header_buffer(xml: bytes, table_at: int) -> bytes:
    # vtable at 18: compression at 4, table's position at 12 (aligned to 8), XML at 8 of the table at 28
    body = struct.pack("<I4s6x5HiiIq", 24, b"IOHE", 10, 20, 4, 12, 8, 10, _LZ4, 12, table_at)
    text = struct.pack("<I", len(xml)) + xml + b"\0"
    return _sized(body + text + bytes(-(len(text) + 4) % 8))


def _table_buffer(places: list[tuple[int, int, int, int, int]]) -> bytes:
    """The data table: for each packet the place of its body, its size, number of events, first and last time."""
    count = len(places)
    head = struct.pack("<I4s2x3Hii", 16, b"FTAB", 6, 8, 4, 6, 4) + struct.pack("<I", count)
    offsets_at = 4 + len(head)
    # Tables of 44 bytes every 48, at 4 modulo 8, so that their 64-bit fields are aligned; one vtable serves all.
    first = offsets_at + 4 * count + 14
    first += (4 - first) % 8
    vtable = struct.pack("<7H", 14, 44, 12, 4, 20, 28, 36)
    offsets = b"".join(struct.pack("<I", first + 48 * k - (offsets_at + 4 * k)) for k in range(count))
    gap = first - 14 - (offsets_at + 4 * count)
    tables = b"".join(
        struct.pack("<iiiqqqq4x", 48 * k + 14, 0, size, at, events, start, end)
        for k, (at, size, events, start, end) in enumerate(places)
    )
    return _sized(head + offsets + bytes(gap) + vtable + tables)


def _sized(body: bytes) -> bytes:
    return struct.pack("<I", len(body)) + body


def _info_xml(shape: tuple[int, int]) -> str:
    height, width = shape
    return (
        '<dv version="2.0"><node name="outInfo" path="/outInfo/"><node name="0" path="/outInfo/0/">'
        '<attr key="compression" type="string">LZ4</attr>'
        f'<attr key="originalModuleName" type="string">{escape(_SOURCE)}</attr>'
        '<attr key="originalOutputName" type="string">events</attr>'
        '<attr key="typeDescription" type="string">Array of events (polarity ON/OFF).</attr>'
        '<attr key="typeIdentifier" type="string">EVTS</attr>'
        '<node name="info" path="/outInfo/0/info/">'
        f'<attr key="sizeX" type="int">{width}</attr><attr key="sizeY" type="int">{height}</attr>'
        f'<attr key="source" type="string">{escape(_SOURCE)}</attr>'
        "</node></node></node></dv>"
    )
