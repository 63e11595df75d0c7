"""What one person's page holds: files, the table, the campaign, and results; nothing of it is shared."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import stepid
from stepid.core.experiment import Campaign
from stepid.core.quantities import Quantities, quantities_of
from stepid.diagnosis.result import Diagnosis
from stepid.errors import InputError, StepidError
from stepid.io.guess.draft import quantities_of_drafts
from stepid.webapp import intake as reading
from stepid.webapp import runs as table
from stepid.webapp.inbox import Inbox
from stepid.webapp.intake import Intake, Row
from stepid.webapp.work import Status, Work


class Session:
    """The state of a page. Its methods are what a person does; a refusal leaves all as it was.

    Parameters
    ----------
    campaign : Campaign, optional
        To begin with.
    """

    def __init__(self, campaign: Campaign | None = None) -> None:
        self.inbox = Inbox()
        self.present = True
        self.watched: Callable[[], bool] = lambda: True  # whether somebody has the page open
        self.work: Work[Diagnosis] | None = None
        self._begin(Intake("") if campaign is None else reading.of_campaign(campaign))

    def _begin(self, intake: Intake) -> None:
        self.intake = intake
        self.name = intake.name
        self.rows: tuple[Row, ...] = intake.rows
        self._forget()

    def _forget(self) -> None:
        """Results are of one campaign: where it changes, they go, and the work on them ends."""
        if self.work is not None:
            self.work.cancel()
        self.work = None
        self.found: Diagnosis | None = None
        self.last: Status[Diagnosis] = Status(running=False)

    def drop(self, files: Mapping[str, bytes]) -> None:
        """Take files in place of those before; StepidError, in words fit for the page, where they cannot be read."""
        same = self.inbox.put(files)
        try:
            intake = self._read(self.intake.said if same else {})
        except StepidError as error:
            self._begin(Intake(""))
            raise type(error)(self.inbox.hidden(error.cause), self.inbox.hidden(error.remedy)) from None
        self._go_on(intake, same)

    def _read(self, said: Mapping[str, str]) -> Intake:
        """Read the files with what was said of those before, where it still fits."""
        try:
            return reading.of_files(self.inbox, said)
        except StepidError:
            if not said:
                raise
            return reading.of_files(self.inbox)

    def example(self) -> None:
        """Take the made-up lab campaign."""
        self.inbox.put({})
        self._begin(reading.of_campaign(stepid.datasets.lab_campaign()))

    def answer(self, key: str, text: str) -> None:
        """Say what the files do not; see `stepid.webapp.intake.SETTINGS`."""
        try:
            intake = reading.answered(self.inbox, self.intake, key, text)
        except StepidError as error:
            raise type(error)(self.inbox.hidden(error.cause), self.inbox.hidden(error.remedy)) from None
        self._go_on(intake, frozenset(self.inbox.names))

    def _go_on(self, intake: Intake, same: frozenset[str]) -> None:
        """Begin with what was read, but keep what was typed about runs of files that are the same."""
        was = zip(self.intake.drafts, self.intake.rows, self.rows, strict=bool(self.intake.drafts))
        typed = {(d.file.name, read.name): now for d, read, now in was if now != read and d.file.name in same}
        name = self.name if self.intake.drafts and same else intake.name
        self._begin(intake)
        self.name = name
        if intake.drafts:
            read = zip(intake.drafts, intake.rows, strict=True)
            self.rows = tuple(typed.get((draft.file.name, row.name), row) for draft, row in read)

    def edit(self, place: int, key: str, value: object) -> None:
        """Change a cell of the table; InputError where a manifest would be refused with it."""
        self.rows = table.edited(self.rows, place, key, value)
        self._forget()

    def choose(self, names: Sequence[str]) -> None:
        """Use the runs of these names only; the others wait. InputError where there are none."""
        self.rows = table.chosen(self.rows, names)
        self._forget()

    def rename(self, name: str) -> None:
        """Give the campaign another name."""
        if not name.strip():
            raise InputError("the campaign has no name", "Give it one.")
        self.name = name.strip()
        self._forget()

    @property
    def say(self) -> Quantities:
        """How its plant moves and what drives it, for words and units of the page."""
        if self.intake.recorded is not None:
            return quantities_of(self.intake.recorded)
        return quantities_of_drafts(self.intake.drafts)

    @property
    def campaign(self) -> Campaign:
        """The campaign as the table says; InputError names what is missing."""
        if self.intake.recorded is None:
            if self.intake.questions:
                asked = " ".join(question.text for question in self.intake.questions)
                raise InputError(f"the files do not say all: {asked}", "Answer it above the table.")
            raise InputError("there are no records yet", "Drop files, or try the example.")
        return table.labeled(self.intake.recorded, self.rows, self.name)

    def diagnose(self, effort: stepid.Effort | None = None) -> Work[Diagnosis]:
        """Begin a diagnosis, in place of one that runs."""
        campaign = self.campaign
        self._forget()
        self.work = Work(
            lambda tell: stepid.diagnose(campaign, effort=effort, progress=tell),
            wanted=lambda: self.present and self.watched(),
        ).start()
        return self.work

    def take(self) -> bool:
        """Keep what finished work has found; say whether it has just ended."""
        work = self.work
        if work is None or work.status.running:
            return False
        self.found, self.work = work.status.result, None
        self.last = work.status
        return True

    def close(self) -> None:
        """End its work, and remove its files."""
        self.present = False
        self._forget()
        self.inbox.close()
