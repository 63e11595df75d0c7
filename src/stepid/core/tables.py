"""Plain-text and notebook tables: one small grid, two ways to show it."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from stepid.core.quantities import spoken_now

Rows = Sequence[Sequence[str]]


def text_table(header: Sequence[str], rows: Rows, *, title: str = "") -> str:
    """Return an aligned text table; the first column is flush left, the others flush right."""
    say = spoken_now().text  # before the columns get their widths
    header, rows = [say(cell) for cell in header], [[say(cell) for cell in row] for row in rows]
    widths = [max(len(line[i]) for line in (header, *rows)) for i in range(len(header))]

    def line(cells: Sequence[str]) -> str:
        first, *rest = (
            cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(cells, widths, strict=True))
        )
        return "  ".join((first, *rest)).rstrip()

    lines = [line(header), "  ".join("-" * w for w in widths), *(line(row) for row in rows)]
    return "\n".join(([title] if title else []) + lines)


def html_table(header: Sequence[str], rows: Rows, *, title: str = "") -> str:
    """Return the same table as HTML for notebooks."""
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "".join(
        "<tr><th>" + escape(row[0]) + "</th>" + "".join(f"<td>{escape(cell)}</td>" for cell in row[1:]) + "</tr>"
        for row in rows
    )
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
