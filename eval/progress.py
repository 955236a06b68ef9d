"""A progress bar that any of the long functions can report to."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Column

__all__ = ["bar"]


@contextmanager
def bar(title: str, console: Console) -> Iterator[Callable[[int, int, str], None]]:
    """Show a bar while the block runs.

    Yields:
        A function of (done, total, what was last), as ``generate``, ``benchmark`` and ``evaluate`` call it.
        What was done before the first call counts as done, not as speed.
    """
    rest = Column(ratio=1, no_wrap=True, overflow="ellipsis")
    columns = (
        TextColumn("{task.description}", table_column=Column(no_wrap=True)),
        BarColumn(bar_width=16),
        MofNCompleteColumn(table_column=Column(no_wrap=True)),
        TimeElapsedColumn(table_column=Column(no_wrap=True)),
        TimeRemainingColumn(table_column=Column(no_wrap=True)),
        TextColumn("[dim]{task.fields[what]}", table_column=rest),
    )
    progress = Progress(*columns, console=console, expand=True)
    task = progress.add_task(title, total=None, what="")

    def report(done: int, total: int, what: str) -> None:
        progress.start()  # at the first call: an error before it should not leave an empty bar
        progress.update(task, completed=done, total=total, what=what)

    try:
        yield report
    finally:
        if progress.live.is_started:
            progress.stop()
