"""Result rows on disk: appended as they come, so that a stopped run is completed and not repeated."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from pedcross_env.errors import ConfigError, DataError

__all__ = ["RowLog", "prepare_folder", "read_json", "read_rows", "write_json", "write_rows"]


def prepare_folder(folder: Path, name: str = "out") -> None:
    """Make ``folder`` and check that it can be written.

    Raises:
        ConfigError: If it cannot; ``name`` is the setting it came from.
    """
    probe = folder / ".writable"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise ConfigError(
            f"{name} = {folder} cannot be written: {error.strerror}. Choose another."
        ) from error


class RowLog:
    """A file of JSON lines. A last line cut off by a kill is dropped and overwritten."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def read(self) -> list[dict[str, Any]]:
        """Return all whole rows.

        Raises:
            DataError: If a line that is not the last is damaged.
        """
        if not self.path.exists():
            return []
        lines = self.path.read_text(encoding="utf-8").splitlines()
        rows = []
        for number, line in enumerate(lines, start=1):
            try:
                rows.append(json.loads(line))
            except json.JSONDecodeError as error:
                if number == len(lines):
                    break
                raise DataError(
                    f"{self.path}, line {number}, is damaged; delete the file to begin anew."
                ) from error
        return rows

    def rewrite(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Replace the file's content as a whole."""
        temporary = self.path.with_suffix(".tmp")
        temporary.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
        temporary.replace(self.path)

    def append(self, row: Mapping[str, Any]) -> None:
        """Add one row and hand it to the operating system at once."""
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")


def write_rows(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows with equal keys as Parquet, whole or not at all; nothing for no rows."""
    if not rows:
        path.unlink(missing_ok=True)
        return
    temporary = path.with_suffix(".tmp")
    pq.write_table(pa.Table.from_pylist([dict(row) for row in rows]), temporary)
    temporary.replace(path)


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Read a Parquet file of rows; an absent one is empty.

    Raises:
        DataError: If the file is damaged.
    """
    if not path.exists():
        return []
    try:
        rows: list[dict[str, Any]] = pq.read_table(path).to_pylist()
    except (pa.ArrowInvalid, OSError) as error:
        raise DataError(f"{path} is damaged ({error}); run the command that wrote it again.") from error
    return rows


def write_json(path: Path, value: Any) -> None:
    """Write a JSON file, whole or not at all."""
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps(value, indent=1, default=str), encoding="utf-8")
    temporary.replace(path)


def read_json(path: Path) -> Any:
    """Read a JSON file; None where it is absent, DataError where it is damaged."""
    if not path.exists():
        return None
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise DataError(f"{path} is damaged ({error}); run the command that wrote it again.") from error
