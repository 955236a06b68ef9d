"""As much of FlatBuffers as AEDAT4 needs: reading tables with every offset checked against the buffer.

Layout after FlatBuffers' "Internals" page: a table begins with the signed distance back to its vtable; a vtable holds
its own size, the table's, then each field's offset in the table (0: absent); strings and vectors begin with their
length.
"""

from __future__ import annotations

import struct

__all__ = ["LayoutError", "Table", "root"]


class LayoutError(ValueError):
    """A buffer that breaks the layout; the text gives the byte in it."""


def _read(data: bytes, code: str, at: int) -> int:
    size = struct.calcsize("<" + code)
    if at < 0 or at + size > len(data):
        raise LayoutError(f"byte {at} of {len(data)} is needed")
    (value,) = struct.unpack_from("<" + code, data, at)
    return int(value)


class Table:
    """A table at a place in a buffer; fields by their number in the schema."""

    def __init__(self, data: bytes, at: int) -> None:
        self.data, self._at = data, at
        self._vtable = at - _read(data, "i", at)
        self._vtable_bytes = _read(data, "H", self._vtable)

    def place(self, field: int) -> int | None:
        """Byte of a field, None where it is absent (and has its default)."""
        slot = 4 + 2 * field
        if slot + 2 > self._vtable_bytes:
            return None
        offset = _read(self.data, "H", self._vtable + slot)
        return self._at + offset if offset else None

    def number(self, field: int, code: str, default: int) -> int:
        """An integer field, ``code`` as in struct."""
        at = self.place(field)
        return default if at is None else _read(self.data, code, at)

    def vector(self, field: int, item_bytes: int) -> tuple[int, int]:
        """(byte of the first item, number of items) of a string or vector; (0, 0) where it is absent."""
        at = self.place(field)
        if at is None:
            return 0, 0
        at += _read(self.data, "I", at)
        count = _read(self.data, "I", at)
        if at + 4 + count * item_bytes > len(self.data):
            raise LayoutError(f"{count} items of {item_bytes} bytes at byte {at + 4} of {len(self.data)}")
        return at + 4, count


def root(data: bytes, identifier: bytes) -> Table:
    """The root table of a size-prefixed buffer.

    Raises:
        LayoutError: For another identifier, or sizes and offsets that do not fit.
    """
    size = _read(data, "I", 0)
    if size + 4 > len(data):
        raise LayoutError(f"{size} bytes announced, {len(data) - 4} there")
    if data[8:12] != identifier:
        raise LayoutError(f"identifier {data[8:12]!r}, expected {identifier!r}")
    return Table(data, 4 + _read(data, "I", 4))
