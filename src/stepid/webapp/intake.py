"""From dropped files to records: what `stepid init` understands of them, what is open, or what a manifest says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from stepid.core.experiment import Campaign
from stepid.errors import InputError
from stepid.io.campaign_files import MANIFEST, read_as, read_campaign
from stepid.io.guess.answers import Answers, with_answers
from stepid.io.guess.draft import Draft, Found
from stepid.io.guess.file_names import natural
from stepid.io.guess.manifest_text import manifest_text
from stepid.io.guess.questions import Question, open_questions
from stepid.io.guess.spoken import spoken
from stepid.io.guess.understand import draft_runs, recordings
from stepid.webapp.inbox import Inbox

_BY_ROW = ("added_mass", "weight")  # the table asks for them
_COLUMNS = ("time", "position", "input")
NAME = "my campaign"
SETTINGS: Mapping[str, str] = {
    "position_unit": "Unit of the position: m, cm, mm, um, in, deg, rad, counts, or meters per unit",
    "counts_per_meter": "Counts of one meter",
    "time_unit": "Unit of the time: s, ms, us, or seconds per unit",
    "sample_time": "Seconds between two samples",
    "input_unit": "Unit of the input: V, mV, N, A, or volts per unit",
    "step": "Step of the input in V, where no column is one (0: the cart was let go)",
    "weight": 'Kilograms of one weight, where names say "2mass"',
    "motion": "rotation where the plant turns: kg·m², rad and N·m",
    "time": "Column of the time, by name or number from 0",
    "position": 'Column of the position ("all" if each of several is a run)',
    "input": "Column of the input",
}
"""What can be said about recordings beside the table of the runs: its key, and the words for it."""


@dataclass(frozen=True)
class Row:
    """A run as the table has it: its labels, and its added mass in kg, None where it is not known yet.

    One that is not `used` is left out of the table and of the campaign, and can come back.
    """

    name: str
    added_mass: float | None
    spring: str
    damper: str
    used: bool = True


@dataclass(frozen=True)
class Intake:
    """Records as far as they are understood.

    `recorded` has the records with the names and masses that they were read with, a mass that is not known as zero;
    it is None while `questions` are open. `rows` are what the table begins with. `said` are answers by their key.
    """

    name: str
    said: Mapping[str, str] = field(default_factory=dict)
    drafts: tuple[Draft, ...] = ()
    questions: tuple[Question, ...] = ()
    recorded: Campaign | None = None
    rows: tuple[Row, ...] = ()
    left_out: tuple[str, ...] = ()


def of_campaign(campaign: Campaign) -> Intake:
    """Take in a campaign that is read already."""
    rows = tuple(Row(run.name, run.added_mass, run.spring, run.damper) for run in campaign)
    return Intake(campaign.name, recorded=campaign, rows=rows)


def of_files(inbox: Inbox, said: Mapping[str, str] | None = None) -> Intake:
    """Take in dropped files, with what was said about them so far.

    Parameters
    ----------
    inbox : Inbox
    said : mapping, optional
        Keys of `SETTINGS` to what was typed.

    Returns
    -------
    Intake

    Raises
    ------
    stepid.errors.StepidError
        If a file cannot be a record, the manifest is wrong, or what was said cannot be meant.
    """
    manifests = [name for name in inbox.names if name.lower().endswith(".toml")]
    if len(manifests) > 1:
        raise InputError(f"{len(manifests)} manifests: {', '.join(manifests)}", "Drop one campaign at a time.")
    if manifests:
        return of_campaign(read_campaign(inbox.folder / manifests[0]))
    if not inbox.names:
        raise InputError("no file was dropped", f"Drop recordings, or a {MANIFEST} with the files that it names.")
    return _of_recordings(inbox, dict(said or {}))


def _of_recordings(inbox: Inbox, said: dict[str, str]) -> Intake:
    files = sorted((inbox.folder / name for name in inbox.names), key=natural)
    taken, refused = recordings(files) if len(files) > 1 else (files, ())
    answers: dict[str, Any] = {key: spoken(key, text) for key, text in said.items() if key not in _COLUMNS}
    columns = {role: said[role] for role in _COLUMNS if role in said}
    drafts = with_answers(draft_runs(taken or files, columns), Answers(**answers))
    questions = open_questions(drafts)
    needed = tuple(question for question in questions if question.key not in _BY_ROW)
    # where names count weights, the weight of one says all masses at once
    weights = tuple(question for question in questions if question.key == "weight")
    rows = tuple(
        Row(d.name, None if d.mass is None else float(d.mass.value), d.spring.value, d.damper.value) for d in drafts
    )
    recorded = None
    if not needed:
        massed = [draft if draft.mass is not None else draft.having(mass=Found(0.0, "")) for draft in drafts]
        recorded = read_as(manifest_text(massed, NAME, inbox.folder), inbox.folder / "the recordings")
    left_out = tuple(inbox.hidden(words) for words in refused)
    return Intake(NAME, said, drafts, (*needed, *weights), recorded, rows, left_out)


def answered(inbox: Inbox, intake: Intake, key: str, text: str) -> Intake:
    """Take the files in again with one more answer; an empty one takes it back. InputError where it is none."""
    said = {**intake.said, key: text.strip()}
    if not said[key]:
        del said[key]
    found = of_files(inbox, said)
    if any(question.key == key for question in found.questions) and key in said:
        raise InputError(f"{text!r} does not answer it", next(q.text for q in found.questions if q.key == key))
    return replace(found, name=intake.name)
