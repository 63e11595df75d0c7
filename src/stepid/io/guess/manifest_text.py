"""Drafts as the text of a campaign.toml, each line with what it means and where it is from."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from stepid.core.words import counted
from stepid.io.guess.answers import MARK
from stepid.io.guess.draft import ROLES, TURNS, Draft, quantities_of_drafts
from stepid.io.guess.words import COUNTS
from stepid.io.manifest import toml_value

_CONTROL = re.compile(r"[\x00-\x1f\x7f]")
_COARSE = (MARK, "s; the printed times are too coarse to tell it")
_SI = {"time": "s", "position": "m", "input": "V"}


def manifest_text(drafts: Sequence[Draft], name: str, folder: Path) -> str:
    """Write a manifest.

    Parameters
    ----------
    drafts : sequence of Draft
    name : str
        Of the campaign.
    folder : pathlib.Path
        Where the manifest is to stand; files are named from there.

    Returns
    -------
    str
        TOML that `stepid.read_campaign` reads. What is not known is ``"?"``, which it refuses.
    """
    runs = [_keys(draft, folder) for draft in drafts]
    shared = [
        key
        for key in runs[0]
        if key not in ("name", "file", "added_mass") and all(run.get(key) == runs[0][key] for run in runs)
    ]
    top: dict[str, tuple[object, str]] = {"name": (name, "of the campaign")}
    own = quantities_of_drafts(drafts)
    if own.motion == "rotation":
        said = drafts[0].motion
        top["motion"] = (own.motion, f"{'by the unit of the angle' if said is None else said.why}: kg·m², rad, N·m")
    if own.input_unit != "V":
        top["input_unit"] = (own.input_unit, "by the unit of the input")
    top |= {key: (value, own.text(comment)) for key, (value, comment) in runs[0].items() if key in shared}
    blocks = [_block(top)]
    for draft, run in zip(drafts, runs, strict=True):
        notes = "".join(f"# {_plain(doubt)}\n" for doubt in draft.doubts)
        rest = {key: (value, own.text(comment)) for key, (value, comment) in run.items() if key not in shared}
        blocks.append(f"[[experiment]]\n{notes}" + _block(rest))
    open_lines = sum(text.count(f'"{MARK}"') for text in blocks)
    head = "# Written by stepid init. What a line says is from the files unless its comment says otherwise.\n"
    if open_lines:
        head += f'# Not known: {open_lines} value(s), marked "{MARK}". Put in what is right.\n'
    return head + "\n".join(blocks)


def _keys(draft: Draft, folder: Path) -> dict[str, tuple[object, str]]:
    """Keys of a run, each with its value and its comment."""
    keys: dict[str, tuple[object, str]] = {
        "name": (draft.name, ""),
        "file": (_from(folder, draft.file), ""),
        "format": (draft.format, ""),
    }
    keys |= {key: (value, "") for key, value in draft.layout.items()}
    keys |= _export_keys(draft) if draft.format == "ecp" else _table_keys(draft)
    if draft.step is not None:
        keys["step"] = _step(*draft.step.value)
    elif "input" not in draft.columns:
        keys["step"] = ({"level": 0.0}, "a free release, by the name") if draft.release else (MARK, _NO_INPUT)
    mass = draft.mass
    if mass is not None:
        keys["added_mass"] = (mass.value, f"kg, {_by(mass.why)}")
    else:
        weights = "" if draft.weights is None else f"; the name says {counted(draft.weights, 'weight')}"
        keys["added_mass"] = (MARK, f"kg, on top of what the cart weighs{weights}")
    keys["spring"] = (draft.spring.value, "runs of one label share a stiffness" + _assumed(draft.spring.assumed))
    keys["damper"] = (draft.damper.value, "runs of one label share a damping" + _assumed(draft.damper.assumed))
    return keys


def _step(level: float, start: float | None) -> tuple[object, str]:
    """A step whose level was said; where it starts shows only the position."""
    if start is None and level:
        return MARK, f"{{ level = {level!r}, start = 0.0 }} in V and s, the start where the motion begins"
    found: dict[str, float] = {"level": level} if start is None else {"level": level, "start": start}
    return found, "V, s; the level as you said, the start where the motion begins" if level else "a free release"


_NO_INPUT = "{ level = 0.5, start = 0.0 } in V and s, level 0.0 for a free release: no column is an input"


def _export_keys(draft: Draft) -> dict[str, tuple[object, str]]:
    keys: dict[str, tuple[object, str]] = {}
    scale = draft.scale("position")
    sign = -1 if draft.falling else 1
    if scale is None:
        keys["counts_per_meter"] = (MARK, "counts of one meter; negative where +V gives falling counts")
    else:
        falling = "; negative because counts fall where the input rises" if draft.falling else ""
        keys["counts_per_meter"] = (sign * round(1 / abs(scale), 6), f"as you said{falling}")
    if draft.sample_time is None:
        keys["sample_time"] = _COARSE
    elif draft.sample_time.why.startswith("as you"):
        keys["sample_time"] = (draft.sample_time.value, "s, as you said")
    return keys


def _table_keys(draft: Draft) -> dict[str, tuple[object, str]]:
    keys: dict[str, tuple[object, str]] = {}
    for role in ROLES:
        if role in draft.columns:
            column = draft.columns[role]
            keys[role] = (column, _counted(draft.titles[role], column) if isinstance(column, int) else "")
        elif role == "position":
            keys[role] = (MARK, f"one of {', '.join(draft.choices)}")
        if role == "time" and (sample_time := _sample_time(draft)) is not None:
            keys["sample_time"] = sample_time
        if role in draft.columns:
            keys |= _scale_keys(draft, role)
    return keys


def _sample_time(draft: Draft) -> tuple[object, str] | None:
    """The sample time, where it is known or has to be said; None where the stamps tell it."""
    if (known := draft.sample_time) is not None:
        return known.value, f"s, {_by(known.why)}"
    if not draft.has_no_clock:
        return None
    return _COARSE if "time" in draft.columns else (MARK, "s between two rows")


def _scale_keys(draft: Draft, role: str) -> dict[str, tuple[object, str]]:
    """SI units per unit of a column, where they are not one or not sure, and the encoder's counts."""
    scale = draft.scale(role)
    if scale is None:
        return {f"{role}_scale": (MARK, f"{_SI[role]} per unit of the column: nothing says its unit")}
    keys: dict[str, tuple[object, str]] = {}
    sign = -1 if role == "position" and draft.falling else 1
    if scale * sign != 1 or _unsure(draft, role):
        keys[f"{role}_scale"] = (sign * scale, _scale_words(draft, role))
    counts = draft.units.get(role)
    if role == "position" and counts is not None and counts.value == COUNTS:
        keys["counts_per_meter"] = (round(1 / scale, 6), "for the resolution")
    return keys


def _counted(title: str, column: int) -> str:
    return "columns count from 0" if title == f"column {column}" else f"{title!r}; columns count from 0"


def _scale_words(draft: Draft, role: str) -> str:
    unit = draft.units.get(role)
    said = draft.scales.get(role)
    if said is not None:
        words = f"{_SI[role]} per unit of the column, {_by(said.why)}"
    elif unit is None:
        words = f"{_SI[role]} per unit"
    else:
        turned = "rad" if unit.value in TURNS else _SI[role]
        si = unit.value.removeprefix("m") if role == "input" else turned
        words = f"{unit.value if unit.value == si else f'{si} per {unit.value}'}, {_by(unit.why)}"
        if unit.value in TURNS and not draft.turns:
            words += "; masses then are moments of inertia"
        if unit.assumed:
            words += ": check it"
    if role == "position" and draft.falling:
        words += "; negative because readings fall where the input rises"
    return words


def _unsure(draft: Draft, role: str) -> bool:
    """Whether a scale of 1 is worth a line: the unit was not said, or is no unit of this kind."""
    unit = draft.units.get(role)
    return role in draft.scales or unit is None or unit.assumed or unit.value not in ("s", "m", "V")


def _assumed(yes: bool) -> str:
    return "; the same for all, unless you say otherwise" if yes else ""


def _by(why: str) -> str:
    return why if why.startswith("as ") or "×" in why else f"by {why}"


def _from(folder: Path, file: Path) -> str:
    """The file as named from a folder."""
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # on another drive
        return file.resolve().as_posix()


def _block(keys: Mapping[str, tuple[object, str]]) -> str:
    lines = []
    for key, (value, comment) in keys.items():
        line = f"{key} = {toml_value(value)}"
        lines.append(f"{line:<28}  # {_plain(comment)}\n" if comment else f"{line}\n")
    return "".join(lines)


def _plain(comment: str) -> str:
    """Show control characters, as of a column's name, which TOML refuses in comments."""
    return _CONTROL.sub(lambda found: f"\\x{ord(found[0]):02x}", comment)
