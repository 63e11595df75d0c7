"""The fourth section: the diagnosis, with live progress, and its answer as the report tells it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import Any

import panel as pn

from stepid.core.quantities import quantities_of
from stepid.diagnosis.headline import advice_beside, answer
from stepid.diagnosis.progress import stage_words
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.wording import effect_names, promised
from stepid.errors import StepidError
from stepid.report.equation import equation, numbers
from stepid.report.hand import Hand
from stepid.report.pictures import pictures
from stepid.report.provenance import of_diagnosis
from stepid.report.story import tell
from stepid.webapp.session import Session
from stepid.webapp.views.chapter import chapter
from stepid.webapp.views.parts import INPUT, button, card, column, folded, html, note, row, said, symbols, typeset
from stepid.webapp.work import Status, Work

_EFFORTS = {"quick": Effort.quick, "default": Effort, "thorough": Effort.thorough}
_SHOWN = ("missing", "parameters", "gap", "next")
_FOLDED = ("where", "notes")  # what is in neither stands above
_LEAD = (
    "Is a linear model adequate, and if not, which effect is missing? The effects of the catalogue are tried, alone "
    "and together, until none promises more."
)
_GONE = "The records have changed. The answer was of those before: diagnose again."
Beside = Callable[[Work[Any], Callable[[Status[Any]], None]], None]
"""Starts work, and calls with its status when it has ended."""


class DiagnosisView:
    """A button, progress, and the answer.

    `started` is called when a diagnosis begins, `shown` when all of its answer stands; `beside` is given other work.
    """

    def __init__(
        self, session: Session, started: Callable[[], None], beside: Beside, shown: Callable[[], None]
    ) -> None:
        self._session, self._started, self._beside, self._shown = session, started, beside, shown
        self._answered: Diagnosis | None = None
        self._effort = pn.widgets.Select(
            label="Effort", options=list(_EFFORTS), value="default", stylesheets=[INPUT], width=140, margin=0
        )
        self._start = button("Diagnose", primary=True, disabled=True)
        self._cancel = button("Cancel", disabled=True)
        self._start.on_click(self._begin)
        self._cancel.on_click(self._stop)
        self._progress = html()
        self._found = column()
        self.view = card(
            4, "Diagnosis", html(note(_LEAD)), row(self._effort, self._start, self._cancel), self._progress, self._found
        )

    def clear(self, *, ready: bool) -> None:
        """Show nothing yet, and say where an answer was; `ready` where a diagnosis could begin."""
        self._start.disabled, self._cancel.disabled = not ready, True
        self._progress.object = said("" if self._answered is None else _GONE)
        self._answered = None
        self._found[:] = []

    def _begin(self, _: object) -> None:
        self._answered = None
        self.clear(ready=False)
        try:
            self._session.diagnose(_EFFORTS[self._effort.value]())
        except StepidError as error:
            self._progress.object = said(str(error), bad=True)
            self._start.disabled = False
            return
        self._cancel.disabled = False
        self._started()

    def _stop(self, _: object) -> None:
        if self._session.work is not None:
            self._session.work.cancel()
            self._cancel.disabled = True

    def watch(self, status: Status[Diagnosis]) -> None:
        """Show how far it is."""
        stage = status.stage
        rows = {
            "trying": self._session.say.text(stage_words(stage)),
            "best answer so far": effect_names(stage.best) or "linear model",
            "left to try": "; ".join(filter(None, (f"{stage.left}", promised(stage.promise)))),
            "time": f"{status.seconds:.0f} s",
        }
        told = "".join(f"<dt>{name}</dt><dd>{escape(value)}</dd>" for name, value in rows.items())
        self._progress.object = f'<div class="bar"><span></span></div><dl class="progress">{told}</dl>'

    def end(self, status: Status[Diagnosis], hand: Hand) -> None:
        """Show how it ended."""
        self._start.disabled, self._cancel.disabled = False, True
        if status.result is None:
            self._progress.object = said("Canceled.") if status.canceled else said(status.failure, bad=True)
            return
        self._progress.object = said(f"Done in {status.seconds:.1f} s.")
        self._answered = d = status.result
        self._found[:] = [html(_headline(d)), html(note("Drawing the pictures …"))]
        self._beside(Work(lambda _: pictures(d, ())), lambda drawn: self._show(d, hand, drawn.result or {}))

    def _show(self, d: Diagnosis, hand: Hand, drawn: Mapping[str, Any]) -> None:
        """Show what the answer rests on below it, if it is still there."""
        if self._answered is not d:
            return
        places = {run.name: i for i, run in enumerate(d.runs)}
        told = {one.name: one for one in tell(d, hand, of_diagnosis(d)) if _says(one.lead, one.points)}
        told["parameters"] = told["parameters"].model_copy(update={"points": ()})  # the equation stands above
        self._found[1:] = [
            *(chapter(told[name], drawn, places) for name in _SHOWN if name in told),
            *(
                folded(told[name].title, chapter(told[name], drawn, places, titled=False))
                for name in _FOLDED
                if name in told
            ),
            folded(
                "The whole answer as text",
                html(f'<div class="scroll" tabindex="0"><pre>{escape(d.summary())}</pre></div>'),
            ),
        ]
        self._shown()


def _headline(d: Diagnosis) -> str:
    """The answer, what would close an open choice, and the equation of motion with its numbers."""
    say = quantities_of(d).text
    advice = note(say(advice_beside(d)))
    found = "".join(f"<div><dt>{symbols(name)}</dt><dd>{typeset(value)}</dd></div>" for name, value in numbers(d))
    return (
        f'<p class="answer" data-verdict="{d.verdict}">{typeset(say(answer(d)))}</p>{advice}'
        f'<p class="equation">{"<br>".join(map(symbols, equation(d)))}</p><dl class="numbers">{found}</dl>'
    )


def _says(lead: str, points: tuple[str, ...]) -> bool:
    return bool(points) or lead not in ("", "None.", "There is nothing to advise.")
