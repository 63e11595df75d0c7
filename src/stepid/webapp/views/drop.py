"""The first section: files are dropped, what was understood is told, what is open is asked for."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import panel as pn

from stepid.errors import StepidError
from stepid.io.guess.sources import sources
from stepid.report.chapter import Table
from stepid.webapp.inbox import LARGEST_UPLOAD
from stepid.webapp.intake import SETTINGS
from stepid.webapp.session import Session
from stepid.webapp.views.parts import INPUT, button, card, column, folded, html, note, points, row, said, tables_html

_PAUSE = 0.8  # s without another file, before what was dropped is read
_LEAD = (
    "Recordings as your lab left them: text, CSV, workbooks or exports of the ECP program, or a campaign.toml with the "
    "files that it names. They stay on this computer."
)

_DROP = """
.filepond--panel-root.filepond--panel-root {
  background-color: var(--paper) !important; border: 1px dashed var(--line); }
.filepond--root.filepond--root, .filepond--root .filepond--drop-label.filepond--drop-label {
  background: transparent; color: var(--ink); border-color: var(--line); }
.filepond--root .filepond--label-action.filepond--label-action { color: var(--accent); }
.filepond--drop-label label:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
.filepond--item-panel, [data-filepond-item-state] .filepond--item-panel { background-color: #3d4a56; }
[data-filepond-item-state*="error"] .filepond--item-panel { background-color: #a03b00; }
.filepond--file .filepond--file-status-sub, .filepond--file .filepond--file-info-sub { opacity: 1; }
"""


class DropView:
    """Files in, records out; `changed` is called when they are others."""

    def __init__(self, session: Session, changed: Callable[[], None]) -> None:
        self._session, self._changed, self._dropped = session, changed, 0
        self._taken: dict[str, bytes] = {}
        self._files = pn.widgets.FileDropper(
            multiple=True,
            max_file_size=f"{LARGEST_UPLOAD // 1_000_000}MB",
            stylesheets=[_DROP],
            sizing_mode="stretch_width",
            margin=(0, 0, 10, 0),
        )
        self._files.param.watch(self._drop, "value")
        self._example = button("Try the example")
        self._example.on_click(self._try)
        self._message = html()
        self._open = column()
        self._understood = html()
        self._settings = column()
        self._more = folded("What was understood, and where to correct it", self._understood, self._settings)
        self.view = card(
            1, "Recordings", html(note(_LEAD)), self._files, row(self._example), self._message, self._open, self._more
        )
        self.show()

    async def _drop(self, _: object) -> None:
        self._dropped += 1
        mine = self._dropped
        await asyncio.sleep(_PAUSE)  # several files come one by one
        if mine == self._dropped:
            files = {n: v.encode() if isinstance(v, str) else v for n, v in self._files.value.items()}
            if files and files != self._taken:  # a slow page tells the same files twice: work on them goes on
                self._taken = files
                self._do(lambda: self._session.drop(files))

    def _try(self, _: object) -> None:
        self._taken = {}
        self._do(self._session.example)

    def _answer(self, key: str, event: Any) -> None:
        try:
            self._session.answer(key, event.new)
        except StepidError as error:
            self.tell(str(error))
            return
        self.show()
        self._changed()

    def _do(self, act: Callable[[], None]) -> None:
        try:
            act()
        except StepidError as error:
            self.show()
            self.tell(str(error))
        else:
            self.show()
        self._changed()

    def tell(self, text: str) -> None:
        """Show what is wrong."""
        self._message.object = said(text, bad=True)

    def show(self) -> None:
        """Show what the session holds."""
        intake = self._session.intake
        runs = len(intake.rows)
        words = f"{runs} run{'s' * (runs > 1)} read." if intake.recorded is not None else ""
        if intake.questions:
            words = "The files do not say all. Please answer:"
        self._message.object = said(words) + points(f"{words}; left out" for words in intake.left_out)
        asked = {question.key: question for question in intake.questions}
        self._open[:] = [
            self._ask(q.key, q.text, placeholder=f"for example {q.default}" * bool(q.default)) for q in asked.values()
        ]
        self._more.visible = bool(intake.drafts)
        if not intake.drafts:
            return
        told = sources(intake.drafts)
        say = self._session.say.text
        told = {say(title): list(map(say, cells)) for title, cells in told.items()}
        told = {"run": [draft.name for draft in intake.drafts], **told}
        table = Table(
            caption="What ends in ? no file says: it is taken by its size, or as usual",
            header=tuple(told),
            rows=tuple(zip(*told.values(), strict=True)),
            words=tuple(range(len(told))),
        )
        doubts = [f"{draft.named}: {doubt}" for draft in intake.drafts for doubt in draft.doubts]
        self._understood.object = tables_html([table]) + points(doubts)
        self._settings[:] = [self._ask(key, words) for key, words in SETTINGS.items() if key not in asked]

    def _ask(self, key: str, words: str, placeholder: str = "") -> pn.widgets.TextInput:
        asked = pn.widgets.TextInput(
            label=words,
            value=self._session.intake.said.get(key, ""),
            placeholder=placeholder,
            stylesheets=[INPUT],
            sizing_mode="stretch_width",
            max_width=560,
            margin=(4, 0),
        )
        asked.param.watch(lambda event: self._answer(key, event), "value")
        return asked
