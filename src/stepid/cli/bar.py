"""What goes on, on standard error: a bar with counts on a terminal, else plain lines, as logs have them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from rich.markup import escape
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Column

from stepid.cli.terminal import console
from stepid.core.bar import switched_off


class Tell(Protocol):
    """Takes a few words, how many steps are done and how many are left."""

    def __call__(self, words: str, done: int = 0, left: int = 0) -> None:
        """Say it."""
        ...


@contextmanager
def showing(*, lines: bool, bar: bool) -> Iterator[Tell]:
    """Say on standard error what goes on.

    Parameters
    ----------
    lines : bool
        In lines, where standard error is no terminal.
    bar : bool
        In a bar, where it is one.
    """
    screen = console(stderr=True)
    if not (screen.is_terminal and bar and not switched_off()):
        yield (lambda words, done=0, left=0: screen.print(words, markup=False)) if lines else _silent
        return
    columns = (
        SpinnerColumn(),
        BarColumn(bar_width=20),
        TextColumn("{task.fields[count]}"),
        TimeElapsedColumn(),
        TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="ellipsis", ratio=1)),
    )
    with Progress(*columns, console=screen, transient=True, expand=True) as shown:
        task = shown.add_task("", total=None, count="")

        def tell(words: str, done: int = 0, left: int = 0) -> None:
            every = done + left
            count = f"{done}/{every}" if every else ""
            shown.update(task, description=escape(words), completed=done, total=every or None, count=count)

        yield tell


def _silent(words: str, done: int = 0, left: int = 0) -> None:
    return None
