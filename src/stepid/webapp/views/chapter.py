"""A chapter of the report, shown in the page: its sentences, pictures and tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import panel as pn

from stepid.report.chapter import Chapter, Picture
from stepid.webapp.views.parts import column, grid, html, note, points, tables_html
from stepid.webapp.views.picture import picture


def chapter(told: Chapter, drawn: Mapping[str, Any], places: Mapping[str, int], *, titled: bool = True) -> pn.Column:
    """Show a chapter; `drawn` has its pictures, `places` the places of the runs in their names."""
    title = f"<h3>{escape(told.title)}</h3>" * titled
    parts: list[Any] = [html(f"{title}{note(told.lead)}{points(told.points)}")]
    for one in told.pictures:
        parts += _picture(one, drawn, places)
    if told.tables:
        parts.append(html(tables_html(told.tables)))
    return column(*parts)


def key(lines: Sequence[tuple[str, str]]) -> str:
    """What the lines of a picture mean, as HTML."""
    entries = "".join(
        f'<span><svg viewBox="0 0 30 12" aria-hidden="true"><path class="{escape(sort)}" d="M0 6H30"/></svg>'
        f"{escape(words)}</span>"
        for sort, words in lines
    )
    return f'<div class="key">{entries}</div>' if lines else ""


def _picture(one: Picture, drawn: Mapping[str, Any], places: Mapping[str, int]) -> list[Any]:
    title = html(f"<h3>{escape(one.title)}</h3>{key([(a, b) for a, b in one.key])}")
    if not one.runs:
        return [title, picture(drawn[one.name], one.alt)] if one.name in drawn else []
    beside = one.beside or ("",) * len(one.runs)
    said = one.said or (one.alt,) * len(one.runs)
    shown = []
    for run, more, words in zip(one.runs, beside, said, strict=True):
        name = f"{one.name}-{places[run]}"
        if name in drawn:
            head = f"<h3>{escape(run)} <small>{escape(more)}</small></h3>"
            shown.append(column(html(head), picture(drawn[name], words)))
    return [title, grid(*shown)]
