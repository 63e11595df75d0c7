"""The report as Markdown, for a lab notebook."""

from __future__ import annotations

import re
from collections.abc import Mapping
from urllib.parse import quote

from stepid.core.quantities import quantities_of
from stepid.diagnosis.headline import advice_beside, answer
from stepid.diagnosis.result import Diagnosis
from stepid.report.chapter import Chapter, Table
from stepid.report.hand import Hand
from stepid.report.provenance import Provenance
from stepid.report.story import tell

# what Markdown reads as markup; numbers with signs and units stay readable
_MARKUP = re.compile(r"([\\`*_\[\]<>|#~$&])")


def markdown(d: Diagnosis, hand: Hand, provenance: Provenance, files: Mapping[str, str]) -> str:
    """Write a diagnosis as Markdown with tables in the common (GitHub) form.

    Parameters
    ----------
    d : Diagnosis
    hand : HandMethod, IdentificationError or None
    provenance : Provenance
    files : mapping
        Name of a still picture to its file, as the text shall link it.

    Returns
    -------
    str
    """
    say = quantities_of(d).text
    parts = [f"# {plain(d.campaign)}: diagnosis", f"**{plain(say(answer(d)))}**"]
    if advice := advice_beside(d):
        parts.append(plain(say(advice)))
    for number, chapter in enumerate(tell(d, hand, provenance), 1):
        parts.append(f"## {number}. {plain(chapter.title)}")
        parts += _body(chapter, files)
    return "\n\n".join(parts) + "\n"


def _body(chapter: Chapter, files: Mapping[str, str]) -> list[str]:
    parts = [plain(chapter.lead)] if chapter.lead else []
    if chapter.points:
        parts.append("\n".join(f"- {plain(point)}" for point in chapter.points))
    shown = [picture for picture in chapter.pictures if picture.still in files]
    parts += [f"![{plain(picture.alt)}]({quote(files[picture.still])})" for picture in shown]
    for table in chapter.tables:
        parts += [f"**{plain(table.caption)}**", markdown_table(table)]
    return parts


def markdown_table(table: Table) -> str:
    """Write a table in the common (GitHub) form."""
    rule = [":--" if i == 0 or i in table.words else "--:" for i in range(len(table.header))]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (_cells(table.header), rule, *map(_cells, table.rows)))


def _cells(cells: tuple[str, ...]) -> list[str]:
    return [plain(cell) for cell in cells]


def plain(text: str) -> str:
    """Escape markup; a text stays on its line."""
    return _MARKUP.sub(r"\\\1", " ".join(text.split()))
