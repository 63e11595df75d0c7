"""Small parts that the sections of the page share: headings, messages, tables as HTML, cards."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import Any

import panel as pn

from stepid.report.chapter import Table

PALETTE = files("stepid.report").joinpath("palette.css").read_text(encoding="utf-8")
STYLE = "".join(
    files(package).joinpath(name).read_text(encoding="utf-8")
    for package, name in (("stepid.report", "tables.css"), ("stepid.webapp.views", "page.css"))
)
CARD = """
:host { background: var(--card); border: 1px solid var(--grid); border-radius: 8px; padding: 1.1rem 1.2rem 1.2rem;
  margin-bottom: 1.1rem; box-sizing: border-box; min-width: 0; }
@media (max-width: 40rem) { :host { padding: 0.9rem 0.7rem; border-radius: 0; border-inline: 0; } }
"""
GRID = """
:host { display: grid !important; grid-template-columns: repeat(auto-fill, minmax(min(19.5rem, 100%), 1fr));
  gap: 0.8rem 1.2rem; width: 100%; }
.scroll-button { display: none; }
"""
_BUTTON = """
.bk-btn { font-size: 0.95rem; padding: 0.4rem 1rem; border-radius: 5px; }
:host .bk-btn.bk-btn.bk-btn { background: var(--paper); color: var(--ink); border: 1px solid var(--line); }
.bk-btn a { padding: 0.4rem 1rem; }
.bk-btn:disabled, .bk-btn[disabled] { opacity: 0.5; cursor: not-allowed; }
.bk-btn:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
"""
INPUT = """
label { white-space: normal; font-size: 0.92rem; color: var(--ink); line-height: 1.3; }
.bk-input { background-color: var(--card); color: var(--ink); border: 1px solid var(--line); font-size: 1rem; }
.bk-input:focus-visible { outline: 3px solid var(--accent); outline-offset: 1px; }
.bk-input::placeholder { color: var(--soft); opacity: 1; }
select.bk-input.bk-input.bk-input {
  color-scheme: light dark; appearance: auto; background-image: none; padding-right: 0.3em; }
"""
_PRIMARY = """
:host .bk-btn.bk-btn.bk-btn.bk-btn { background: var(--accent); color: var(--card); border-color: var(--accent); }
"""
_FOLD = """
:host { background: var(--card); color: var(--ink); border: 1px solid var(--line); border-radius: 6px;
  box-shadow: none; }
.card-header { background: var(--paper); color: var(--ink); border-radius: 6px; }
.card-header:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
.card-button { color: var(--ink); }
"""
_WIDE: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": 0}


def html(text: str = "", **more: Any) -> pn.pane.HTML:
    """A piece of HTML in the page's type; what comes from people must be escaped."""
    return pn.pane.HTML(text, stylesheets=[STYLE], **_WIDE, **more)


def card(number: int, title: str, *inside: Any) -> pn.Column:
    """A section of the page."""
    heading = html(f'<h2><span class="number">{number}</span> {escape(title)}</h2>')
    return pn.Column(heading, *inside, stylesheets=[CARD], **_WIDE)


def button(name: str, *, primary: bool = False, disabled: bool = False) -> pn.widgets.Button:
    """A button."""
    style = [_BUTTON, _PRIMARY] if primary else [_BUTTON]
    return pn.widgets.Button(label=name, disabled=disabled, stylesheets=style, margin=0)


def download(name: str, make: Callable[[], io.BytesIO]) -> pn.widgets.FileDownload:
    """A button that gives a file, not of use yet."""
    return pn.widgets.FileDownload(
        callback=make, filename=name, label=name, disabled=True, stylesheets=[_BUTTON], margin=0
    )


def folded(title: str, *inside: Any) -> pn.Card:
    """A part that is opened by its title."""
    return pn.Card(
        pn.Column(*inside, sizing_mode="stretch_width", margin=(8, 12, 12, 12)),
        title=title,
        collapsed=True,
        stylesheets=[_FOLD],
        sizing_mode="stretch_width",
        margin=(10, 0, 0, 0),
    )


def column(*inside: Any) -> pn.Column:
    """Parts below each other."""
    return pn.Column(*inside, **_WIDE)


def row(*inside: Any) -> pn.FlexBox:
    """Parts beside each other, as far as there is room."""
    return pn.FlexBox(
        *inside, gap="0.6rem 0.8rem", align_items="end", sizing_mode="stretch_width", margin=(0, 0, 10, 0)
    )


def grid(*inside: Any) -> pn.Column:
    """Parts in columns of equal width."""
    return pn.Column(*inside, stylesheets=[GRID], **_WIDE)


def said(text: str, *, bad: bool = False) -> str:
    """A message as HTML, which a screen reader tells at once."""
    if not text:
        return ""
    kind, role = ("bad", "alert") if bad else ("good", "status")
    return f'<p class="said {kind}" role="{role}">{escape(text)}</p>'


def note(text: str) -> str:
    """A paragraph as HTML."""
    return f"<p>{typeset(text)}</p>" if text else ""


def points(sentences: Iterable[str]) -> str:
    """A list as HTML."""
    items = "".join(f"<li>{typeset(one)}</li>" for one in sentences)
    return f"<ul>{items}</ul>" if items else ""


def typeset(text: str) -> str:
    """Escape, keep a number, its uncertainty and its unit on one line, and set ω_d with a low d."""
    kept = re.sub(r"(?<=\d) (?=(?:µm|mm|µrad|mrad|rad|kg|ms|s|V|A|N|%)(?:\W|$))", "\u00a0", escape(text))
    return kept.replace(" ± ", "\u00a0±\u00a0").replace("ω_d", "ω<sub>d</sub>")


def symbols(text: str) -> str:
    """Escape, and set letters such as K_f with a low f."""
    return re.sub(r"_(\w)\b", r"<sub>\1</sub>", typeset(text))


def tables_html(tables: Sequence[Table]) -> str:
    """Tables of a report as HTML."""
    return f'<div class="tables">{"".join(map(_table, tables))}</div>' if tables else ""


def _table(table: Table) -> str:
    words = {0, *table.words}

    def cells(row: Sequence[str], tag: str, first: str) -> str:
        return "".join(
            f"<{first if i == 0 else tag}{' class=words' if i in words else ''}>{typeset(cell)}"
            f"</{first if i == 0 else tag}>"
            for i, cell in enumerate(row)
        )

    head = cells(table.header, "th scope=col", "th scope=col")
    body = "".join(f"<tr>{cells(row, 'td', 'th scope=row')}</tr>" for row in table.rows)
    caption = escape(table.caption)
    return (
        (
            f'<div class="table"><div class="scroll" tabindex="0" role="group" aria-label="{caption}">'
            f"<table><caption>{typeset(table.caption)}</caption><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
            "</div></div>"
        )
        .replace("</th scope=col>", "</th>")
        .replace("</th scope=row>", "</th>")
    )
