"""Recordings as labs leave them, understood without a manifest: what `stepid init` does, from Python."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from stepid.core.takes import WantedError, a, described, each, number, optional, taken, text
from stepid.errors import InputError
from stepid.io.guess.answers import Answers, with_answers
from stepid.io.guess.campaign_draft import CampaignDraft, argument
from stepid.io.guess.file_names import natural
from stepid.io.guess.files import files_of
from stepid.io.guess.read import name_of
from stepid.io.guess.understand import draft_runs
from stepid.io.textfile import as_path

Column = str | int
Files = str | os.PathLike[str] | Iterable[str | os.PathLike[str]]
_EACH = ("added_mass", "spring", "damper")


def draft_campaign(
    files: Files,
    *,
    name: str | None = None,
    added_mass: float | Sequence[float] | None = None,
    spring: str | Sequence[str] | None = None,
    damper: str | Sequence[str] | None = None,
    weight: float | None = None,
    position: Column | None = None,
    time: Column | None = None,
    input: Column | None = None,
    position_unit: str | float | None = None,
    time_unit: str | float | None = None,
    input_unit: str | float | None = None,
    counts_per_meter: float | None = None,
    sample_time: float | None = None,
    step: float | None = None,
    motion: str | None = None,
) -> CampaignDraft:
    """Find out what recordings hold, as `stepid init` does: columns, units, decimal marks, masses and labels.

    What the files do not say is asked for by the draft; give it here. What is given goes before what was found.

    Parameters
    ----------
    files : path-like or iterable of path-like
        Delimited text, workbooks (``.xlsx``) or exports of the ECP program; folders and patterns such as
        ``"lab/*.csv"`` stand for their files, ordered by the numbers in their names.
    name : str, optional
        Of the campaign; that of the folder by default.
    added_mass : float or sequence of float, optional
        kg, known weights: of all runs, or one a run in the order of the files.
    spring, damper : str or sequence of str, optional
        Labels, of all runs, or one a run.
    weight : float, optional
        kg, of one weight, where names say ``2mass``.
    position, time, input : str or int, optional
        Columns, by name or by index from 0; ``position="all"`` says that each of several positions is a run.
    position_unit : str or float, optional
        ``"m"``, ``"cm"``, ``"mm"``, ``"um"``, ``"in"``, ``"deg"``, ``"rad"`` or ``"counts"``, or meters per unit.
    time_unit : str or float, optional
        ``"s"``, ``"ms"`` or ``"us"``, or seconds per unit.
    input_unit : str or float, optional
        ``"V"``, ``"mV"``, ``"N"``, ``"A"`` or ``"N·m"``, or volts per unit.
    counts_per_meter : float, optional
        Of the encoder, where positions are counts.
    sample_time : float, optional
        s, between rows without a time, or whose printed times repeat.
    step : float, optional
        V, of the input where no column is one; 0 for a free release. It starts where the motion does.
    motion : "translation" or "rotation", optional
        Where positions do not say whether the plant turns.

    Returns
    -------
    CampaignDraft
        Shows what was understood. Its method ``campaign`` gives the `Campaign`, ``write`` a commented
        ``campaign.toml``.

    Raises
    ------
    stepid.errors.InputError
        If there are no files, one holds no table of numbers, or what is given cannot be meant.
    """
    own = "draft_campaign"
    units = {"position_unit": position_unit, "time_unit": time_unit, "input_unit": input_unit}
    plain = {"weight": weight, "counts_per_meter": counts_per_meter, "sample_time": sample_time, "step": step}
    answers: dict[str, Any] = {
        "added_mass": _several(own, "added_mass", added_mass, number(), float, "a number, or one a run (kg)"),
        "spring": _several(own, "spring", spring, text(), str, "a label, or one a run"),
        "damper": _several(own, "damper", damper, text(), str, "a label, or one a run"),
        **{key: taken(own, key, value, optional(_unit)) for key, value in units.items()},
        **{key: taken(own, key, value, optional(number())) for key, value in plain.items()},
        "motion": taken(own, "motion", motion, optional(text())),
    }
    columns = {"position": position, "time": time, "input": input}
    chosen = {
        role: str(taken(own, role, column, a((str, int), "a column, by name or index")))
        for role, column in columns.items()
        if column is not None
    }
    taken(own, "name", name, optional(text()))
    differing = [key for key in _EACH if len(set(answers[key] or ())) > 1]
    found, left_out = files_of(paths_of(files), differing, call=argument)
    drafts = with_answers(draft_runs(found, chosen), Answers(**answers))
    return CampaignDraft(name=name or name_of(drafts), runs=drafts, left_out=left_out)


def paths_of(files: object) -> list[Path]:
    """Files and folders; a pattern stands for what it matches, as not every shell expands it."""
    if isinstance(files, str | os.PathLike):
        files = [files]
    if isinstance(files, bytes | Mapping) or not isinstance(files, Iterable):
        raise InputError(f"files is {described(files)}", "Give one path, or several.")
    out: list[Path] = []
    for one in files:
        path = as_path(one)
        pattern = str(path)
        if glob.has_magic(pattern) and not path.exists():
            matched = sorted(map(Path, glob.glob(pattern)), key=natural)
            if not matched:
                raise InputError(f"{pattern}: no file is called so", "Correct the pattern, or name the files.")
            out += matched
        else:
            out.append(path)
    if not out:
        raise InputError("files is empty", "Give one path, or several.")
    return out


def _unit(value: object) -> str:
    if isinstance(value, str) and value:
        return value
    try:
        return repr(float(number()(value)))
    except WantedError:
        raise WantedError("a unit, or SI units per unit as a number") from None


def _several(own: str, key: str, value: object, check: Any, kind: type, words: str) -> tuple[Any, ...] | None:
    """One value for all runs, or one a run."""
    if value is None:
        return None
    try:
        return (kind(check(value)),)
    except WantedError:
        return tuple(map(kind, taken(own, key, value, each(check, words, least=1))))
