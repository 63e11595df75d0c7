"""The campaigns of a class with their answers: written for the students, sealed for the instructor."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path
from typing import Self

from pydantic import model_validator

from stepid.core.atomic_write import staged
from stepid.core.base import Model
from stepid.core.experiment import Campaign
from stepid.core.takes import takes
from stepid.errors import InputError
from stepid.io.campaign_files import read_campaign, write_campaign
from stepid.io.safe_read import LARGEST_NOTE
from stepid.io.textfile import as_path, decode, read_bytes
from stepid.lab.answers import Answer, Answers, an_answer
from stepid.lab.hashes import digest
from stepid.lab.seal import seal, unseal

SEALED, COMMITMENT = "answers.sealed", "commitment.txt"
_SAFE = 12  # letters or digits of a seed: to try 10^12 numbers takes a core more than a year
LONG_ENOUGH = f"Take a sentence that nobody else knows, or a number nobody has seen, of {_SAFE} characters or more."
_PADDED = 8192  # bytes a group: more than any answer, so that the sealed file's length tells nothing


def guessable(seed: int | str) -> bool:
    """Tell whether a program that tries all seeds would soon come to this one."""
    return len(str(seed)) < _SAFE


class Assignment(Model):
    """Blind campaigns, one a group, made by `stepid.lab.make`. Printing it does not give the answers away.

    Parameters
    ----------
    campaigns : tuple of Campaign
        In the order of the groups.
    answers : Answers
    """

    campaigns: tuple[Campaign, ...]
    answers: Answers

    @model_validator(mode="after")
    def _one_each(self) -> Self:
        if len(self.campaigns) != len(self.answers.answers):
            raise ValueError("campaigns and answers differ in number")
        return self

    @property
    def groups(self) -> tuple[str, ...]:
        """Names of the groups."""
        return self.answers.groups

    def __getitem__(self, group: str) -> Campaign:
        """Return a group's campaign; InputError names the groups there are."""
        self.answers[group]  # refuses a group that does not exist
        return self.campaigns[self.groups.index(group)]

    def __repr__(self) -> str:
        return f"Assignment({len(self.groups)} groups: {', '.join(self.groups)})"

    __str__ = __repr__

    def write(self, folder: str | os.PathLike[str], *, passphrase: str) -> Path:
        """Write a folder a group, for the students, and the sealed answers beside them.

        Each group's folder holds ``campaign.toml`` with its records, and ``commitment.txt``. All files bear one time
        stamp. The folder appears whole or not at all.

        Parameters
        ----------
        folder : path-like
            New.
        passphrase : str
            Opens ``answers.sealed`` again; at least 8 characters. It is kept nowhere.

        Returns
        -------
        pathlib.Path
            The sealed answers.

        Raises
        ------
        stepid.errors.InputError
            If the folder exists or cannot be written, the passphrase is too short, or so is the seed.
        """
        target = as_path(folder)
        if os.path.lexists(target):
            raise InputError(f"{target}: exists already", "Choose a new folder, or move it away.")
        if guessable(self.answers.seed):
            raise InputError(f"seed {self.answers.seed!r} can be guessed, and with it all answers", LONG_ENOUGH)
        sealed = seal(self.answers.model_dump_json(), passphrase=passphrase, padded=_PADDED * max(len(self.groups), 1))
        with staged(target.parent) as scratch:
            whole = scratch / target.name
            whole.mkdir()
            for answer in self.answers.answers:
                write_campaign(self[answer.group], whole / answer.group)
                (whole / answer.group / COMMITMENT).write_text(_committed(answer), encoding="utf-8")
            (whole / SEALED).write_text(sealed, encoding="utf-8")
            _stamp(whole)
        return target / SEALED


def _committed(answer: Answer) -> str:
    return (
        f"Group {answer.group}: SHA-256 of the sealed answer to these records.\n"
        f"{answer.commitment}\n"
        "Keep it. When the answer is opened, stepid.lab.confirm shows that nobody has changed it.\n"
    )


def _stamp(folder: Path) -> None:
    """Give all files one time: how long each took to make would tell something about what is in it."""
    now = int(time.time())
    for path in (*folder.rglob("*"), folder):
        os.utime(path, (now, now))


def open_answers(path: str | os.PathLike[str], *, passphrase: str) -> Answers:
    """Open the sealed answers.

    Parameters
    ----------
    path : path-like
        ``answers.sealed``, or the folder that holds it.
    passphrase : str
        That of `Assignment.write`.

    Returns
    -------
    Answers

    Raises
    ------
    stepid.errors.InputError
        If the file is missing, cut off or changed, or the passphrase is wrong.
    """
    file = as_path(path)
    if os.path.isdir(file):
        file = file / SEALED
    return Answers.model_validate_json(
        unseal(read_bytes(file, largest=LARGEST_NOTE), passphrase=passphrase, where=str(file))
    )


@takes(answer=an_answer)
def confirm(answer: Answer, folder: str | os.PathLike[str]) -> None:
    """Show that an answer is the one that a group's folder was handed out with.

    Parameters
    ----------
    answer : Answer
        As the instructor has published it.
    folder : path-like
        The group's, with its records and ``commitment.txt``.

    Raises
    ------
    stepid.errors.InputError
        If the answer is not the one committed to, the records are not those it belongs to, or a file is missing.
    """
    where = as_path(folder)
    note = where / COMMITMENT
    found = re.search(r"^[0-9a-f]{64}$", decode(read_bytes(note, largest=LARGEST_NOTE), str(note)), re.MULTILINE)
    if found is None:
        raise InputError(f"{note}: holds no SHA-256", "Take the file as it was handed out.")
    if found[0] != answer.commitment:
        raise InputError(
            f"{note}: is not the commitment to this answer of group {answer.group!r}",
            "Either is another one than at the beginning: compare with a copy made then.",
        )
    if digest(read_campaign(where)) != answer.records:
        raise InputError(
            f"{where}: its records are not those that the answer belongs to",
            "Compare them with a copy made when they were handed out.",
        )
