"""Where a record ends that stands beside longer ones in a table."""

from __future__ import annotations

from collections.abc import Sequence

from stepid.errors import InputError
from stepid.io.guess.words import read_title, tokens


def own_rows(
    rows: Sequence[Sequence[str]],
    labels: Sequence[str],
    *,
    own: Sequence[int],
    clock: Sequence[int],
    lines: Sequence[int],
    where: str,
    stop: int | None = None,
) -> int:
    """Count the rows of a record, whose cells are empty from where it ends.

    Parameters
    ----------
    rows : sequence of sequence of str
        Of the whole table.
    labels : sequence of str
        Names of all columns, or their numbers.
    own, clock : sequence of int
        Columns of the record's readings, and of its time.
    lines : sequence of int
        Numbers of the rows in the file, for messages.
    where : str
        The file, for messages.
    stop : int, optional
        Row at which the record was said to end.

    Raises
    ------
    stepid.errors.InputError
        Naming line and column, where time goes on and no other column is another run's position: readings are lost.
    """
    last = len(rows)
    while last and own and all(i < len(rows[last - 1]) and not rows[last - 1][i] for i in own):
        if sum(bool(cell) for i, cell in enumerate(rows[last - 1]) if i not in own) < 2:
            break  # beside its time there is no other record
        last -= 1
    if last in (0, len(rows)):
        return len(rows)
    there = {i for row in rows[last:] for i, cell in enumerate(row) if cell}
    stopped = bool(clock) and not there.intersection(clock)
    said = stop is not None and stop <= last
    if stopped or said or any(_is_another(i, labels, own, clock) for i in there.difference(own, clock)):
        return last
    raise InputError(
        f"{where}, line {lines[last]}, column {labels[own[0]]!r}: is empty from here on, though other columns go on",
        f"Restore its readings; if the record ends there, give stop = {last}.",
    )


def _is_another(column: int, labels: Sequence[str], own: Sequence[int], clock: Sequence[int]) -> bool:
    """Tell whether a column is called as another run's position: one of its own, or with a word of this run's."""
    if column >= len(labels):
        return False
    role = read_title(labels[column]).role
    first, *others = (set(tokens(labels[i])) for i in (*own, *clock))
    alike = first.difference(*others).intersection(tokens(labels[column]))
    return role == "position" or (role is None and bool(alike))
