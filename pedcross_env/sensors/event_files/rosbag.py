"""Events in ROS 2 bags (sqlite): event_camera_msgs/msg/EventPacket with EVT3 inside, as the Metavision driver records.

A message is CDR: two bytes of representation, two of options, then, aligned from there: stamp (i32, u32), frame_id
(string), height, width (u32), seq, time_base (u64), encoding (string), is_bigendian (bool), events (sequence of u8).
EVT3's own times count; the bag's are those of the host. Source: the messages' definition in ros-event-camera/
event_camera_msgs (Apache-2.0).
"""

from __future__ import annotations

import sqlite3
import struct
from contextlib import closing
from pathlib import Path

import numpy as np

from pedcross_env.errors import DataError, unknown_name
from pedcross_env.sensors.event_files.prophesee import decode_evt3
from pedcross_env.sensors.event_files.recording import Recording, damaged

__all__ = ["read"]

_TYPE = "event_camera_msgs/msg/EventPacket"


class _Cdr:
    """Reads one message's fields in order; struct.error where it ends too early."""

    def __init__(self, data: bytes) -> None:
        if len(data) < 4 or data[0] != 0 or data[1] not in (0, 1):
            raise struct.error("no CDR header")
        self._data, self._at, self._order = data, 4, "<" if data[1] else ">"

    def take(self, code: str) -> int:
        size = struct.calcsize(code)
        self._at += -(self._at - 4) % size
        (value,) = struct.unpack_from(self._order + code, self._data, self._at)
        self._at += size
        return int(value)

    def chunk(self) -> bytes:
        """A string (its closing zero included) or a sequence of bytes."""
        size = self.take("I")
        if self._at + size > len(self._data):
            raise struct.error(f"{size} bytes announced at byte {self._at} of {len(self._data)}")
        out = self._data[self._at : self._at + size]
        self._at += size
        return out


def _packet(data: bytes) -> tuple[tuple[int, int], str, bytes]:
    """((height, width), encoding, payload) of a message."""
    cdr = _Cdr(data)
    cdr.take("i"), cdr.take("I")
    cdr.chunk()
    height, width = cdr.take("I"), cdr.take("I")
    cdr.take("Q"), cdr.take("Q")
    encoding = cdr.chunk().rstrip(b"\0").decode("ascii", "replace")
    cdr.take("?")
    return (height, width), encoding, cdr.chunk()


def _messages(path: Path, topic: str | None) -> list[tuple[int, bytes]]:
    """(id, data) of a topic's messages in order of their times."""
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as bag:
            topics = dict(bag.execute("SELECT name, id FROM topics WHERE type = ?", (_TYPE,)).fetchall())
            if not topics:
                raise DataError(f"{path} has no topic of type {_TYPE}; record the event camera's own topic.")
            if topic is None and len(topics) > 1:
                raise DataError(
                    f"{path} has {len(topics)} topics of events ({', '.join(sorted(topics))}); choose one: "
                    f"pedcross_env.sensors.event_files.rosbag.read(path, topic=...)."
                )
            if topic is not None and topic not in topics:
                raise unknown_name("topic", topic, topics)
            chosen = topics[topic] if topic is not None else next(iter(topics.values()))
            query = "SELECT id, data FROM messages WHERE topic_id = ? ORDER BY timestamp, id"
            return bag.execute(query, (chosen,)).fetchall()
    except sqlite3.Error as error:
        raise DataError(
            f"{path}: sqlite cannot read the bag of {path.stat().st_size} bytes ({error}): it is truncated, damaged or "
            f"of another kind; copy it again."
        ) from error


def read(path: Path, topic: str | None = None) -> Recording:
    """Read the events of a bag; see formats.read_events.

    Args:
        path: Of the .db3 file.
        topic: Which one, where the bag has several topics of events.

    Raises:
        DataError: For a damaged bag or message (named by its id and byte), or another encoding than evt3.
        ConfigError: For an unknown topic.
    """
    parts: list[bytes] = []
    ids: list[int] = []
    shape: tuple[int, int] | None = None
    for ident, data in _messages(path, topic):
        try:
            shape, encoding, payload = _packet(data)
        except struct.error as error:
            raise damaged(
                f"{path}, message {ident}", len(data), f"the message ends too early ({error})"
            ) from None
        if encoding != "evt3":
            raise DataError(f"{path}, message {ident}: encoding {encoding!r}; allowed: 'evt3'.")
        if len(payload) % 2:
            raise damaged(
                f"{path}, message {ident}", len(payload) - 1, "the payload ends within a word of 2 bytes"
            )
        parts.append(payload)
        ids.append(ident)
    starts = np.cumsum([0, *map(len, parts)])

    def where(byte: int) -> tuple[str, int]:
        k = int(np.searchsorted(starts, byte, side="right")) - 1
        return (f"{path}, payload of message {ids[k]}", byte - int(starts[k])) if ids else (str(path), byte)

    events, skipped = decode_evt3(np.frombuffer(b"".join(parts), "<u2"), shape, where)
    return Recording(events, shape, "rosbag", skipped)
