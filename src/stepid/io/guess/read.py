"""Drafts, where nothing is open, as a campaign."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from stepid.core.experiment import Campaign
from stepid.errors import InputError
from stepid.io.campaign_files import read_as
from stepid.io.guess.draft import Draft
from stepid.io.guess.manifest_text import manifest_text
from stepid.io.guess.questions import open_questions


def folder_of(drafts: Sequence[Draft]) -> Path:
    """The folder that all files of drafts are in."""
    parents = {draft.file.parent for draft in drafts}
    return parents.pop() if len(parents) == 1 else Path(os.path.commonpath([parent.resolve() for parent in parents]))


def name_of(drafts: Sequence[Draft]) -> str:
    """A campaign's name where none is given: that of its folder."""
    return folder_of(drafts).resolve().name or "recordings"


def campaign_of_drafts(
    drafts: Sequence[Draft], *, call: Callable[[str], str], otherwise: str = "", name: str | None = None
) -> Campaign:
    """Read drafts as a campaign.

    Parameters
    ----------
    drafts : sequence of Draft
    call : callable
        How what answers a question is called, for the error.
    otherwise : str
        What else can be done about open questions.
    name : str, optional
        Of the campaign; that of the folder by default.

    Raises
    ------
    stepid.errors.InputError
        Naming all that the recordings do not say, and what says it.
    """
    if questions := open_questions(drafts):
        wanted = ", ".join(call(question.key) for question in questions)
        asked = " ".join(question.text for question in questions)
        remedy = f"Give {wanted}{f', or {otherwise}' * bool(otherwise)}."
        raise InputError(f"the recordings do not say all: {asked}", remedy)
    return read_as(manifest_text(drafts, name or name_of(drafts), Path()), Path("the recordings"))
