"""A report is a row of sections: a heading and a body."""

from __future__ import annotations

from collections.abc import Iterable

from stepid.core.base import Label, Model


class Section(Model):
    """One part of a report.

    Parameters
    ----------
    title : str
    body : str
        Plain text, ready to print.
    """

    title: Label
    body: str


def as_text(sections: Iterable[Section]) -> str:
    """Join sections to one plain text.

    Parameters
    ----------
    sections : iterable of Section

    Returns
    -------
    str
        Headings underlined, ending in a newline.
    """
    return "\n\n".join(f"{s.title}\n{'=' * len(s.title)}\n{s.body}" for s in sections) + "\n"
