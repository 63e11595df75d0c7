"""The whole page of one session: its sections, and what follows from what."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import panel as pn

from stepid.core.quantities import quantities_of
from stepid.diagnosis.text import GAP_HEADER, gap_rows, parameter_header, parameter_rows
from stepid.errors import IdentificationError, StepidError
from stepid.report.chapter import Table
from stepid.report.hand import Hand, HandMethod, by_hand
from stepid.webapp.session import Session
from stepid.webapp.views.diagnosis import DiagnosisView
from stepid.webapp.views.downloads import DownloadView
from stepid.webapp.views.drop import DropView
from stepid.webapp.views.hand import HandView
from stepid.webapp.views.parts import PALETTE, html, note
from stepid.webapp.views.play import PlayView
from stepid.webapp.views.records import RecordsView
from stepid.webapp.work import Status, Work

_EVERY = 250  # ms between two looks at what works
_TITLE = "<h1>stepid</h1>"
_LEAD = "From recordings of a mass-spring-damper to its parameters, and to the effect that the linear model is missing."
_NOT_YET = "Not computed yet:"
_ROOT = """
:host { background: var(--paper); max-width: 72rem; margin: 0 auto !important; padding: 0.8rem 1.1rem 2rem;
  box-sizing: border-box; }
@media (max-width: 40rem) { :host { padding-inline: 0; } }
"""
DESIGN = """
:root, :host {
  --design-background-color: var(--card); --design-background-text-color: var(--ink);
  --design-surface-color: var(--paper); --design-surface-text-color: var(--ink);
  --design-primary-color: var(--accent); --panel-border-color: var(--line); color-scheme: light dark;
}
"""


class Page:
    """The sections of one session."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self._tasks: list[tuple[Work[Any], Callable[[Status[Any]], None]]] = []
        self._hand: Hand = None
        self._ticking: Any = None
        self._drop = DropView(session, self._records_changed)
        self._records = RecordsView(session, self._changed)
        self._by_hand = HandView()
        self._diagnosis = DiagnosisView(session, self._tick_on, self._start, self._answered)
        self._play = PlayView(self._start)
        self._downloads = DownloadView(session, self._tables)
        self._rest = pn.Column(
            self._records.view,
            self._by_hand.view,
            self._diagnosis.view,
            self._play.view,
            self._downloads.view,
            sizing_mode="stretch_width",
            margin=0,
            visible=False,
        )
        self.view = pn.Column(
            html(f'<div class="top">{_TITLE}{note(_LEAD)}</div>'),
            self._drop.view,
            self._rest,
            stylesheets=[PALETTE, DESIGN, _ROOT],
            sizing_mode="stretch_width",
        )
        self._records_changed()

    def _records_changed(self) -> None:
        self._records.show()
        self._rest.visible = self.session.intake.recorded is not None
        self._changed()

    def _changed(self) -> None:
        """Another campaign: what was found of the last one goes."""
        self._tasks, self._hand = [], None
        try:
            campaign = self.session.campaign
        except StepidError as error:
            self._by_hand.clear(f"{_NOT_YET} {error}")
            self._diagnosis.clear(ready=False)
            self._play.clear(f"{_NOT_YET} {error}")
            self._downloads.show(complete=False)
            return
        self._by_hand.clear("Computing …")
        self._diagnosis.clear(ready=True)
        self._downloads.show(complete=True)
        self._play.clear("Computing …")
        self._start(Work(lambda _: by_hand(campaign)), self._take_hand)

    def _take_hand(self, status: Status[HandMethod | IdentificationError]) -> None:
        self._hand = status.result
        if isinstance(status.result, HandMethod):
            self._by_hand.show(status.result)
        else:
            self._by_hand.clear(status.failure or str(status.result))
        self._downloads.show(complete=True)
        self._play.begin(self.session.campaign)

    def _start(self, work: Work[Any], done: Callable[[Status[Any]], None]) -> None:
        self._tasks.append((work.start(), done))
        self._tick_on()

    def _tick_on(self) -> None:
        if self._ticking is None:
            self._ticking = pn.state.add_periodic_callback(self._tick, period=_EVERY)
        elif not self._ticking.running:
            self._ticking.start()

    def _tick(self) -> None:
        """Look at what works beside the page."""
        for one in list(self._tasks):
            work, done = one
            if not (status := work.status).running and one in self._tasks:
                self._tasks.remove(one)
                done(status)
        if (diagnosing := self.session.work) is not None:
            self._diagnosis.watch(diagnosing.status)
            if self.session.take():
                self._diagnosis.end(self.session.last, self._hand)
                if self.session.found is not None:
                    self._play.begin(self.session.campaign, self.session.found)
        if not self._tasks and self.session.work is None:
            self._ticking.stop()

    def _answered(self) -> None:
        """Give the report when all stands above its button: what comes later would move it away from a click."""
        self._downloads.show(complete=True)

    def _tables(self) -> tuple[Table, ...]:
        d = self.session.found
        if d is None:
            return self._by_hand.tables
        fitted = Table(caption="The joint fit", header=parameter_header(d), rows=tuple(parameter_rows(d)))
        gap = Table(caption="The gap by run", header=GAP_HEADER, rows=tuple(gap_rows(d)))
        return (*self._by_hand.tables, *quantities_of(d).result((fitted, gap), words=True))
