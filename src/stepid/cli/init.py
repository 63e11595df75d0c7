"""`stepid init`: recordings become a campaign; and recordings that are read without one."""

from __future__ import annotations

import dataclasses
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import stepid
from stepid.cli.said import Said, taking_answers
from stepid.cli.terminal import command, console
from stepid.errors import InputError
from stepid.io.guess.spoken import spoken

if TYPE_CHECKING:
    from stepid.core.experiment import Campaign
    from stepid.io.guess.draft import Draft
    from stepid.io.guess.questions import Question


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
    from stepid.io.guess.questions import open_questions
    from stepid.io.guess.write import manifest_bytes, write_draft
    from stepid.io.recordings import paths_of

    found, refused = _files(paths_of(files), said)
    target = _target(found, out, force=force)
    drafts = _drafts(found, said)
    name = name or target.parent.resolve().name or "campaign"
    manifest_bytes(drafts, name, target.parent)  # what cannot be written is refused before anybody is asked
    show(console(), drafts, refused)
    if ask and sys.stdin.isatty():
        drafts = _ask(found, said, drafts)
    write_draft(drafts, name, target)
    screen = console()
    screen.print(f"wrote {target}", style="dim", markup=False)
    if questions := open_questions(drafts):
        screen.print(f'Not known, and marked "?" in {target.name}:', markup=False)
        for question in questions:
            screen.print(f"  {question.text} ({flag(question.key)})", markup=False)
        return
    outside = any(target.parent.resolve() not in file.resolve().parents for file in found)
    stepid.read_campaign(target, allow_outside=outside)  # whatever is still wrong is said now
    more = ["--allow-outside"] * outside
    screen.print(f"Next: {command('stepid', 'diagnose', str(target), *more, '--out', 'results')}", markup=False)


def read_records(paths: Sequence[Path], said: Said, *, allow_outside: bool = False) -> Campaign:
    """Read a campaign from its manifest, or from recordings without one; InputError where something is not known."""
    from stepid.io.guess.files import holds_records
    from stepid.io.guess.read import campaign_of_drafts
    from stepid.io.guess.sources import doubts_of
    from stepid.io.recordings import paths_of

    paths = paths_of(paths)
    first = paths[0]
    manifest = len(paths) == 1 and (first.suffix == ".toml" or (first / "campaign.toml").is_file())
    if manifest or (len(paths) == 1 and not first.is_dir() and not holds_records(first)):
        if said.given:
            raise InputError(f"{flag(said.given[0])} is for recordings", f"Say it in {first}.")
        return stepid.read_campaign(first, allow_outside=allow_outside)
    files, refused = _files(paths, said)
    drafts = _drafts(files, said)
    for line in doubts_of(drafts, refused):  # also where progress is not wanted: the answer rests on it
        console(stderr=True).print(line, markup=False)
    return campaign_of_drafts(drafts, call=flag, otherwise="let stepid init write a campaign.toml")


def flag(key: str) -> str:
    """The option that answers a question."""
    return {"input_column": "--input"}.get(key, f"--{key.replace('_', '-')}")


def _drafts(files: Sequence[Path], said: Said) -> tuple[Draft, ...]:
    from stepid.io.guess.answers import with_answers
    from stepid.io.guess.understand import draft_runs

    return with_answers(draft_runs(files, said.columns), said.answers)


def _files(paths: Sequence[Path], said: Said) -> tuple[list[Path], tuple[str, ...]]:
    from stepid.io.guess.files import files_of

    return files_of(paths, said.each, call=flag)


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
    from stepid.io.guess.questions import open_questions

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
        before = said
        try:
            said = _heard(question, answer, said)
            drafts = _drafts(files, said)
            if any(q.key == question.key for q in open_questions(drafts)):
                screen.print("That does not answer it.", markup=False)
        except InputError as error:
            screen.print(str(error), style="red", markup=False)
            said = before
    return drafts


def _heard(question: Question, answer: str, said: Said) -> Said:
    key = question.key
    if key == "position":
        return dataclasses.replace(said, columns={**said.columns, "position": answer})
    return said.hearing(key, spoken(key, answer))
