"""`stepid init`: recordings become a campaign; and recordings that are read without one."""

from __future__ import annotations

import dataclasses
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import stepid
from stepid.cli.said import Said, taking_answers
from stepid.cli.terminal import console
from stepid.errors import InputError
from stepid.io.guess.spoken import spoken

if TYPE_CHECKING:
    from stepid.core.experiment import Campaign
    from stepid.io.guess.answers import Question
    from stepid.io.guess.draft import Draft

_KINDS = (".csv", ".txt", ".xlsx", ".tsv", ".dat", ".m", ".lvm", ".asc")
_FLAGS = {"position": "--position", "input_unit": "--input-unit"}
_MANY = 500  # files


@taking_answers
def init(
    said: Said,
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILES...", help="Recordings: CSV, text, .xlsx or ECP exports.", show_default=False),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="Where to write; beside the files unless said.", show_default=False),
    ] = None,
    name: Annotated[
        str | None, typer.Option("--name", help="Of the campaign; the folder's unless said.", show_default=False)
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Write over a campaign.toml that is there.")] = False,
    ask: Annotated[
        bool, typer.Option("--ask/--no-ask", help="Ask for what is not known, or mark it in the file.")
    ] = True,
) -> None:
    """Look at recordings, ask for what they do not say, and write a commented campaign.toml."""
    from stepid.cli.understood import show
    from stepid.io.guess.answers import open_questions
    from stepid.io.guess.manifest_text import manifest_text

    found, refused = _files(files, said)
    target = _target(found, out, force=force)
    drafts = _drafts(found, said)
    show(console(), drafts)
    for refusal in refused:
        console().print(f"{refusal}; left out", markup=False)
    if ask and sys.stdin.isatty():
        drafts = _ask(found, said, drafts)
    text = manifest_text(drafts, name or target.parent.resolve().name or "campaign", target.parent)
    try:
        target.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror})", "Give another place by --out.") from None
    screen = console()
    screen.print(f"wrote {target}", style="dim", markup=False)
    if questions := open_questions(drafts):
        screen.print(f'Not known, and marked "?" in {target.name}:', markup=False)
        for question in questions:
            screen.print(f"  {question.text} ({flag(question.key)})", markup=False)
        return
    outside = any(target.parent.resolve() not in file.resolve().parents for file in found)
    stepid.read_campaign(target, allow_outside=outside)  # whatever is still wrong is said now
    screen.print(f"Next: stepid diagnose {target}{' --allow-outside' * outside} --out results", markup=False)


def read_records(paths: Sequence[Path], said: Said, *, allow_outside: bool = False) -> Campaign:
    """Read a campaign from its manifest, or from recordings without one; InputError where something is not known."""
    first = paths[0]
    manifest = len(paths) == 1 and (first.suffix == ".toml" or (first / "campaign.toml").is_file())
    if manifest or (len(paths) == 1 and not first.is_dir() and not _looks_like_records(first)):
        if said.given:
            raise InputError(f"{flag(said.given[0])} is for recordings", f"Say it in {first}.")
        return stepid.read_campaign(first, allow_outside=allow_outside)
    files, _ = _files(paths, said)
    return campaign_of_files(files, said)


def campaign_of_files(files: Sequence[Path], said: Said) -> Campaign:
    """Read recordings as a campaign; InputError names what they do not say, and the options that do."""
    from stepid.io.campaign_files import read_as
    from stepid.io.guess.answers import open_questions
    from stepid.io.guess.manifest_text import manifest_text

    drafts = _drafts(files, said)
    if questions := open_questions(drafts):
        flags = ", ".join(flag(question.key) for question in questions)
        asked = " ".join(question.text for question in questions)
        raise InputError(
            f"the recordings do not say all: {asked}", f"Give {flags}, or let stepid init write a campaign.toml."
        )
    where = Path("the recordings")
    folder = Path(os.path.commonpath([file.resolve().parent for file in files]))
    return read_as(manifest_text(drafts, folder.name or "recordings", Path()), where)


def flag(key: str) -> str:
    """The option that answers a question."""
    return {"input_column": "--input"}.get(key, f"--{key.replace('_', '-')}")


def _looks_like_records(path: Path) -> bool:
    return path.suffix.lower() in _KINDS


def _drafts(files: Sequence[Path], said: Said) -> tuple[Draft, ...]:
    from stepid.io.guess.answers import with_answers
    from stepid.io.guess.understand import draft_runs

    return with_answers(draft_runs(files, said.columns), said.answers)


def _files(paths: Sequence[Path], said: Said) -> tuple[list[Path], tuple[str, ...]]:
    """Files, and those of folders, in order; and why some that hold no table are left out."""
    from stepid.io.guess.file_names import natural
    from stepid.io.guess.understand import recordings

    out: list[Path] = []
    for path in paths:
        inside = [file for file in path.iterdir() if _looks_like_records(file)] if path.is_dir() else [path]
        out += sorted(inside, key=natural) if path.is_dir() else inside
    if not out:
        raise InputError(f"{paths[0]}: holds no recordings ({', '.join(_KINDS)})", "Name the files.")
    if len(out) > _MANY:
        raise InputError(f"{len(out)} files are more than a campaign has", "Name those of one campaign.")
    if values := said.each:
        _check_order(out, values)
    files = sorted(out, key=natural) if not values and len({file.parent for file in out}) == 1 else out
    taken, refused = recordings(files) if len(files) > 1 else (files, ())
    return (taken, refused) if taken else (files, ())


def _check_order(files: Sequence[Path], values: Sequence[str]) -> None:
    """Refuse values a run for files in the order of a shell's pattern, where their numbers have another."""
    from stepid.io.guess.file_names import natural

    numbered = sorted(files, key=natural)
    shells = (str, lambda file: re.sub(r"[\W_]", "", str(file)).casefold())  # by bytes, or as a locale has it
    if numbered != list(files) and any(list(files) == sorted(files, key=key) for key in shells):
        given, meant = (" ".join(file.name for file in order) for order in (files, numbered))
        flags = " and ".join(flag(key) for key in values)
        raise InputError(
            f"{flags}: it is not clear which value is whose, as the files came in the order {given}",
            f"Name the files one by one in the order of the values, such as {meant}.",
        )


def _target(files: Sequence[Path], out: Path | None, *, force: bool) -> Path:
    if out is None:
        parents = {file.parent for file in files}
        folder = parents.pop() if len(parents) == 1 else Path(os.path.commonpath([file.parent for file in files]))
        out = folder / "campaign.toml"
    elif out.is_dir():
        out = out / "campaign.toml"
    if not out.parent.is_dir():
        raise InputError(f"{out.parent}: there is no such folder", "Make it, or give another place by --out.")
    if os.path.lexists(out) and not force:
        raise InputError(f"{out}: exists already", "Say --force to write over it, or give another place by --out.")
    return out


def _ask(files: Sequence[Path], said: Said, drafts: tuple[Draft, ...]) -> tuple[Draft, ...]:
    """Ask question by question; an empty answer leaves it open, and marks it."""
    from stepid.io.guess.answers import open_questions

    screen, skipped = console(), set()
    while left := [q for q in open_questions(drafts) if q.key not in skipped]:
        question = left[0]
        default = f" [{question.default}]" if question.default else ""
        screen.print(f"{question.text}{default} ", end="", markup=False)
        try:
            answer = input().strip() or question.default
        except EOFError:
            break
        if not answer:
            skipped.add(question.key)
            continue
        try:
            said = _heard(question, answer, said)
            drafts = _drafts(files, said)
            if any(q.key == question.key for q in open_questions(drafts)):
                screen.print("That does not answer it.", markup=False)
        except InputError as error:
            screen.print(str(error), style="red", markup=False)
            said = said.hearing(question.key, None)
    return drafts


def _heard(question: Question, answer: str, said: Said) -> Said:
    key = question.key
    if key == "position":
        return dataclasses.replace(said, columns={**said.columns, "position": answer})
    return said.hearing(key, spoken(key, answer))
