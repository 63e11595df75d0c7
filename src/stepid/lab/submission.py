"""What a group hands in."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

from stepid.core.atomic_write import staged
from stepid.core.base import Label, Model
from stepid.core.estimate import Estimate
from stepid.core.takes import a
from stepid.errors import InputError
from stepid.io.safe_read import LARGEST_NOTE
from stepid.io.textfile import as_path, decode, read_bytes


class Submission(Model):
    """What a group hands in: parameters with uncertainties, and what it says was hidden.

    From a fit or a diagnosis: ``Submission(group="A", parameters=d.parameters, effects=d.effects,
    alternatives=d.alternatives)``.

    Parameters
    ----------
    group : str
    parameters : mapping of str to Estimate
        By the names of `stepid.fit`: ``"base_mass"``, ``"stiffness[medium]"``, ``"coulomb_friction.level"``, … An
        uncertainty of None says that the records do not determine the value.
    effects : tuple of str
        Canonical names of what the group found; () where it found nothing missing.
    alternatives : tuple of tuple of str
        What it could not tell from `effects`.
    """

    group: Label
    parameters: Mapping[str, Estimate]
    effects: tuple[str, ...] = ()
    alternatives: tuple[tuple[str, ...], ...] = ()

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write the file to hand in; `read_submission` reads it.

        Parameters
        ----------
        path : path-like
            Ends in ``.json``. An older file of the same name is replaced.

        Returns
        -------
        pathlib.Path

        Raises
        ------
        stepid.errors.InputError
            If the path has another ending or cannot be written.
        """
        file = as_path(path)
        if file.suffix != ".json":
            raise InputError(f"{file}: does not end in .json", "Give it a name like group-A.json.")
        text = json.dumps(self.model_dump(mode="json"), indent=2, ensure_ascii=False) + "\n"
        with staged(file.parent) as scratch:
            (scratch / file.name).write_text(text, encoding="utf-8")
        return file

    def __repr__(self) -> str:
        named = " and ".join(self.effects) or "nothing"
        return f"Submission(group {self.group!r}: {named} named, {len(self.parameters)} parameters)"

    __str__ = __repr__


a_submission = a(Submission, "a Submission, as stepid.lab.read_submission returns it")
"""Check of an argument `submission`."""


def read_submission(path: str | os.PathLike[str]) -> Submission:
    """Read what a group handed in.

    Parameters
    ----------
    path : path-like
        A JSON file as `Submission.write` makes it, or written by hand:
        ``{"group": "A", "effects": [], "parameters": {"base_mass": {"value": 0.95, "uncertainty": 0.01, "unit":
        "kg"}}}``.

    Returns
    -------
    Submission

    Raises
    ------
    stepid.errors.InputError
        Naming the file: if it is missing, no JSON, or a field is missing, unknown or not a finite number.
    """
    file = as_path(path)
    try:
        return Submission.model_validate_json(decode(read_bytes(file, largest=LARGEST_NOTE), str(file)))
    except InputError as error:
        said = error.cause if error.cause.startswith(str(file)) else f"{file}: {error.cause}"
        raise InputError(said, error.remedy) from None


def read_submissions(folder: str | os.PathLike[str]) -> tuple[Submission, ...]:
    """Read all submissions (``*.json``) of a folder, in the order of their file names.

    Parameters
    ----------
    folder : path-like

    Returns
    -------
    tuple of Submission

    Raises
    ------
    stepid.errors.InputError
        If there is no such folder or no such file in it, and for what `read_submission` refuses.
    """
    where = as_path(folder)
    files = sorted(where.glob("*.json")) if os.path.isdir(where) else []
    if not files:
        raise InputError(f"{where}: is no folder with submissions (*.json)", "Put what the groups handed in there.")
    return tuple(read_submission(file) for file in files)
