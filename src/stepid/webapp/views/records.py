"""The second section: each record in a picture, and the table of the runs."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import panel as pn

from stepid.core.experiment import Experiment
from stepid.core.frames import make_frame
from stepid.errors import StepidError
from stepid.webapp import pictures
from stepid.webapp.intake import Row
from stepid.webapp.runs import COLUMNS, massless
from stepid.webapp.session import Session
from stepid.webapp.views.parts import INPUT, card, column, grid, html, note, said
from stepid.webapp.views.picture import picture

_TITLES = {"name": "run", "added_mass": "added mass [kg]", "spring": "spring", "damper": "damper"}
_LEAD = (
    "Runs with the same spring or damper label share one stiffness or damping. Added masses are the known weights on "
    "top of the cart. Click a cell, or go to it by Tab, to change it."
)
_WRAPPED = """
.bk-input-group.bk-inline { display: flex; flex-wrap: wrap; gap: 4px 14px; }
.bk-input-group.bk-inline.bk-inline > * { margin: 0; }
"""
_CHOICE = "Runs in the campaign; take the tick away to leave one out"
_TABLE = """
.tabulator.pnx-tabulator { background: var(--card); color: var(--ink); border: 1px solid var(--grid);
  font-size: 0.92rem; }
.pnx-tabulator .tabulator-header.tabulator-header, .pnx-tabulator .tabulator-header .tabulator-col.tabulator-col {
  background: var(--paper); color: var(--ink); border-color: var(--line); }
.pnx-tabulator .tabulator-tableholder .tabulator-table.tabulator-table { background: var(--card); color: var(--ink); }
.pnx-tabulator .tabulator-row.tabulator-row.tabulator-row { background: var(--card); color: var(--ink);
  border-bottom: 1px solid var(--grid); }
.pnx-tabulator .tabulator-row .tabulator-cell.tabulator-cell { border-right-color: var(--grid); }
.pnx-tabulator .tabulator-row .tabulator-cell.tabulator-editable { cursor: text; }
.pnx-tabulator .tabulator-cell:focus { outline: 3px solid var(--accent); outline-offset: -3px; }
.pnx-tabulator .tabulator-cell input { background: var(--card); color: var(--ink); }
.pnx-tabulator .tabulator-header-contents { min-height: 0; }
.pnx-tabulator .tabulator-header .tabulator-col .tabulator-col-title.tabulator-col-title { white-space: normal; }
"""


class RecordsView:
    """The runs; `changed` is called when a cell or the name was changed."""

    def __init__(self, session: Session, changed: Callable[[], None]) -> None:
        self._session, self._changed = session, changed
        self._name = pn.widgets.TextInput(
            label="Name of the campaign",
            stylesheets=[INPUT],
            sizing_mode="stretch_width",
            max_width=420,
            margin=(0, 0, 8, 0),
        )
        self._name.param.watch(self._rename, "value")
        self._message = html()
        self._table = pn.widgets.Tabulator(
            make_frame({key: [] for key in COLUMNS}),
            titles=_TITLES,
            editors={key: {"type": "input", "elementAttributes": {"aria-label": _TITLES[key]}} for key in COLUMNS},
            formatters={key: {"type": "plaintext"} for key in COLUMNS},
            show_index=False,
            sortable=False,
            selectable=False,
            layout="fit_columns",
            configuration={
                "columnDefaults": {"headerWordWrap": True},
                "keybindings": {"navNext": False, "navPrev": False},
            },  # Tab leaves the table in the end
            theme="simple",
            stylesheets=[_TABLE],
            sizing_mode="stretch_width",
            margin=(0, 0, 8, 0),
        )
        self._table.on_edit(self._edit)
        self._used = pn.widgets.CheckBoxGroup(
            options=[], inline=True, stylesheets=[INPUT, _WRAPPED], sizing_mode="stretch_width", margin=(0, 0, 8, 0)
        )
        self._used.param.watch(self._choose, "value")
        self._pictures = grid()
        self._heads: list[pn.pane.HTML] = []
        self._put_back: set[tuple[int, str]] = set()  # cells to which the value before was sent
        self._telling = False
        self._lead = html()
        choice = html(f"<p>{_CHOICE}</p>")
        self.view = card(
            2, "Runs", self._lead, self._name, self._message, self._table, choice, self._used, self._pictures
        )

    def show(self) -> None:
        """Show the records of the session anew."""
        session = self._session
        self._lead.object = note(session.say.text(_LEAD))
        self._telling = True
        self._name.value = session.name
        self._telling = False
        recorded = session.intake.recorded
        runs = tuple(recorded or ())
        self._heads = [html(_head(run.name, run)) for run in runs]
        self._pictures[:] = [
            column(head, picture(pictures.record(run, session.say), f"Position and input of {run.name} against time."))
            for head, run in zip(self._heads, runs, strict=True)
        ]
        self._fill()

    def _fill(self) -> None:
        say, rows = self._session.say, self._shown
        self._put_back.clear()
        self._offer()
        self._table.titles = {key: say.text(title) for key, title in _TITLES.items()}
        self._table.value = make_frame({key: [_text(getattr(row, key)) for row in rows] for key in COLUMNS})
        self._ask()

    @property
    def _shown(self) -> tuple[Row, ...]:
        return tuple(row for row in self._session.rows if row.used)

    def _offer(self) -> None:
        """Show which runs are in use, and their pictures only."""
        rows = self._session.rows
        self._telling = True
        self._used.param.update(options=[row.name for row in rows], value=[row.name for row in self._shown])
        self._telling = False
        for row, shown in zip(rows, self._pictures, strict=False):  # there are none while questions are open
            shown.visible = row.used

    def _choose(self, event: Any) -> None:
        if self._telling:
            return
        try:
            self._session.choose(event.new)
        except StepidError as error:
            self._offer()
            self._message.object = said(str(error), bad=True)
            return
        self._fill()
        self._changed()

    def _ask(self) -> None:
        """Ask for the masses that are missing."""
        missing = massless(self._session.rows)
        words = self._session.say.text("Which masses were added? Put them into the table, in kg")
        self._message.object = said(f"{words}: {', '.join(missing)}." if missing else "", bad=True)

    def _edit(self, event: Any) -> None:
        row, key = int(event.row), str(event.column)
        before = self._shown[row]
        place = self._session.rows.index(before)
        try:
            if _text(getattr(before, key)) != str(event.value).strip():
                self._session.edit(place, key, event.value)
        except StepidError as error:
            self._message.object = said(f"{error} The value before stays.", bad=True)
            self._table.patch({key: [(row, _text(getattr(before, key)))]})
            self._put_back.add((place, key))
            return
        self._ask()
        if (place, key) in self._put_back:  # that may have come after this one was typed, and hide it
            self._put_back.discard((place, key))
            self._table.patch({key: [(row, str(event.value).strip())]})
        # what was taken stays as it was typed: a change from here would close the cell that is being written in now
        if (now := self._session.rows[place]) == before:
            return
        if key == "name":
            if (recorded := self._session.intake.recorded) is not None:  # else there are no pictures to head
                self._heads[place].object = _head(now.name, recorded.experiments[place])
            self._offer()
        self._changed()

    def _rename(self, event: Any) -> None:
        if self._telling or event.new == self._session.name:
            return
        try:
            self._session.rename(event.new)
        except StepidError as error:
            self._message.object = said(str(error), bad=True)
            return
        self._changed()


def _head(name: str, run: Experiment) -> str:
    return f"<h3>{escape(name)} <small>{run.time.size} samples</small></h3>"


def _text(value: object) -> str:
    return "" if value is None else f"{value:.10g}" if isinstance(value, float) else str(value)
