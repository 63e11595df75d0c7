"""The third section: Table 2's numbers, and the verification responses."""

from __future__ import annotations

from html import escape

from stepid.core.quantities import quantities_of
from stepid.report.captions import verification
from stepid.report.chapter import Table
from stepid.report.hand import HandMethod
from stepid.report.tables import characteristics_table, found_tables, verification_table
from stepid.webapp import pictures
from stepid.webapp.views.chapter import key
from stepid.webapp.views.parts import card, column, grid, html, note, said, tables_html
from stepid.webapp.views.picture import picture

_LEAD = (
    "The paper's way: the first peak of each record gives its damped frequency and damping ratio; with the known "
    "differences of the masses they fix every mass, stiffness and damping."
)


class HandView:
    """What the peak method finds."""

    def __init__(self) -> None:
        self._text = html()
        self._heading = html()
        self._pictures = grid()
        self._verified = html()
        self.tables: tuple[Table, ...] = ()
        self.view = card(
            3,
            "Parameters by the peak method",
            html(note(_LEAD)),
            self._text,
            column(self._heading, self._pictures, self._verified),
        )
        self.clear("Not computed yet: the runs above are not complete.")

    def clear(self, why: str) -> None:
        """Show why there is nothing."""
        self.tables = ()
        self._text.object = said(why)
        self._heading.object = self._verified.object = ""
        self._pictures[:] = []

    def show(self, hand: HandMethod) -> None:
        """Show what was found."""
        tables = (*found_tables(hand.found), characteristics_table(hand.system), verification_table(hand.verified))
        say = quantities_of(hand.found)
        self.tables = say.result(tables, words=True)
        notes = "".join(map(note, say.result(hand.found.notes, words=True)))
        self._text.object = notes + tables_html(self.tables[:-1])
        caption = say.result(verification(hand.verified), words=True)
        self._heading.object = f"<h3>{escape(caption.title)}</h3>{key([(a, b) for a, b in caption.key])}"
        drawn = pictures.verified(hand.verified)
        self._pictures[:] = [
            column(html(f"<h3>{escape(run)} <small>{escape(beside)}</small></h3>"), picture(drawn[run], words))
            for run, beside, words in zip(caption.runs, caption.beside, caption.said, strict=True)
        ]
        self._verified.object = tables_html(self.tables[-1:])
