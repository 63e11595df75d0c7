"""From files to drafts of runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from stepid.errors import InputError
from stepid.io.guess.draft import Draft
from stepid.io.guess.export import export_of, from_export
from stepid.io.guess.file_names import plain_name, read_name
from stepid.io.guess.named import named
from stepid.io.guess.table import from_table
from stepid.io.guess.text import NoTableError, text_lines
from stepid.io.program_files import ProgramFileError
from stepid.io.textfile import as_path, read_bytes
from stepid.io.workbook import is_workbook, sheet_names, workbook_lines


def draft_runs(files: Sequence[Path], chosen: Mapping[str, str] | None = None) -> tuple[Draft, ...]:
    """Find out what files of recordings hold.

    Parameters
    ----------
    files : sequence of pathlib.Path
        Delimited text, workbooks (``.xlsx``) and exports of the ECP program, several runs side by side or one a file.
    chosen : mapping, optional
        ``"time"``, ``"position"`` and ``"input"`` to the names of their columns, where somebody has said so; the
        position ``"all"`` says that each column of a position is a run.

    Returns
    -------
    tuple of Draft
        In the order of the files. Names are unique.

    Raises
    ------
    stepid.errors.InputError
        Naming the file: if it is missing, or holds no table of numbers; or if no file has a column that is chosen.
    """
    found = [draft for file in files for draft in _file(as_path(file), chosen or {})]
    for role in chosen or {}:
        found = _having_column(found, role)
    if len({draft.file.parent for draft in found}) > 1:  # a folder a run
        found = [named(draft, read_name(draft.file.parent.name), None) for draft in found]
    twice = Counter(draft.name for draft in found)
    out: list[Draft] = []
    for draft in found:
        name = _whence(draft) if twice[draft.name] > 1 else draft.name
        first, number = name, 2
        while any(other.name == name for other in out):
            name, number = f"{first} ({number})", number + 1
        out.append(draft.having(name=name))
    return tuple(out)


def _having_column(found: Sequence[Draft], role: str) -> list[Draft]:
    """Refuse a column that no file has; where some have it, it is a doubt of the others."""
    if found and all(role in draft.lacking for draft in found):
        first = found[0]
        remedy = f"Give one of these columns as the {role}, by its name or its number from 0."
        if first.format == "ecp":
            remedy = f"Leave the column of the {role} out; a campaign.toml takes another encoder: encoder = 2."
        raise InputError(f"{first.file}: {first.lacking[role]}", remedy)
    return [
        draft.having(doubts=(*draft.doubts, _instead(draft, role))) if role in draft.lacking else draft
        for draft in found
    ]


def _instead(draft: Draft, role: str) -> str:
    taken = draft.titles[role] if role in draft.columns and draft.format == "table" else ""
    return f"{draft.lacking[role]}{f'; {taken!r} is taken' if taken else ''}"


def recordings(files: Sequence[Path]) -> tuple[list[Path], tuple[str, ...]]:
    """Tell files with tables from others, such as notes: the files to take, and why others are left out."""
    taken, refused = [], []
    for file in files:
        try:
            _file(as_path(file), {})
        except (NoTableError, ProgramFileError) as error:
            refused.append(error.cause)
        else:
            taken.append(file)
    return taken, tuple(refused)


def _whence(draft: Draft) -> str:
    """A longer name: with the file, or where the file is called like its run, that of the folder."""
    stem = plain_name(draft.file.stem)
    return plain_name(draft.file.parent.name) if stem == draft.name else f"{stem}, {draft.name}"


def _file(file: Path, chosen: Mapping[str, str]) -> list[Draft]:
    raw = read_bytes(file)
    where = str(file)
    if is_workbook(raw):
        return _workbook(raw, file, chosen)
    lines, encoding = text_lines(raw, file)
    if encoding is None and (export := export_of(lines, where)) is not None:
        return [from_export(export, file, chosen)]
    return from_table(lines, file, {} if encoding is None else {"encoding": encoding}, chosen)


def _workbook(raw: bytes, file: Path, chosen: Mapping[str, str]) -> list[Draft]:
    where, out, names = str(file), [], sheet_names(raw, str(file))
    for i, name in enumerate(names):
        try:
            lines = workbook_lines(raw, where, name)
            drafts = from_table(lines, file, {"sheet": name} if i else {}, chosen, workbook=True)
        except NoTableError:  # a sheet of notes or pictures
            continue
        said = read_name(name)
        out += [named(draft, said, plain_name(name)) if len(names) > 1 else draft for draft in drafts]
    if not out:
        raise InputError(f"{where}: no sheet holds a table of numbers that stepid finds", "Save the table as CSV.")
    return out
