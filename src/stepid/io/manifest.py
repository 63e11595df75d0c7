"""The manifest of a campaign, campaign.toml: its keys, checked one by one, and its text."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

from stepid.core.quantities import CART, INPUT_UNITS, MOTIONS, Quantities, middle_dot
from stepid.core.takes import WantedError
from stepid.errors import InputError
from stepid.io.manifest_values import (
    Check,
    check_between,
    check_input_unit,
    check_mass,
    check_motion,
    check_number,
    check_positive,
    check_scale,
    check_share,
    check_starts,
    check_step,
    check_text,
)
from stepid.io.readers import Reader

T = TypeVar("T")
Readers = Mapping[str, Reader]
CAMPAIGN: Mapping[str, Check] = {
    "name": check_text,
    "weight_uncertainty": check_positive,
    "scale_uncertainty": check_share,
    "motion": check_motion,
    "input_unit": check_input_unit,
}
SHARED: Mapping[str, Check] = {
    "name": check_text,
    "format": check_text,
    "added_mass": check_mass,
    "spring": check_text,
    "damper": check_text,
    "base": check_text,
    "counts_per_meter": check_scale,
    "input_before": check_number,
    "input_between": check_between,
    "starts": check_starts,
    "sample_time": check_positive,
    "step": check_step,
    "file": check_text,
}
"""Keys that a run of every format may have; its reader has more."""
OWN = ("name", "file", "files")  # never the same for all runs
_WORK = 10_000_000  # sum of the squared numbers of points a line; 3,000 files on one line are below it
BACKSLASH = """in "…" a backslash begins an escape; write "/" in its place, or single quotes: '…'"""
_JSON = re.compile(r"\s*(\{|\[\s*\{)")  # with neither a line of TOML can begin
_NAME_CSV = "Give a campaign.toml that names the CSV under an [[experiment]]; stepid diagnose --help shows one."
_NAME_IT = _NAME_CSV.replace("the CSV", "this file")
_DEEPEST = 16  # points in the name of a table
REQUIRED = ("name", "added_mass", "spring", "damper")


def parse_manifest(text: str, where: str, readers: Readers) -> tuple[dict[str, Any], list[tuple[str, dict[str, Any]]]]:
    """Parse and check the text of a manifest.

    Parameters
    ----------
    text : str
    where : str
        Its path, for messages.
    readers : mapping of str to Reader
        By the name of their format; the first is the default.

    Returns
    -------
    campaign : dict
        The campaign's own keys.
    experiments : list of (format, dict)
        The name of a format and the checked keys of each run. What stands above the runs and is a key of
        runs is theirs, but for those that say otherwise.

    Raises
    ------
    stepid.errors.InputError
        Naming the file, the run and the key.
    """
    if _JSON.match(text):
        raise no_json(where)
    _check_depth(text, where)
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        if not where.endswith(".toml"):
            raise InputError(f"{where}: is no manifest of a campaign (not TOML: {error})", _NAME_IT) from None
        remedy = "Correct it; texts need quotation marks, numbers points, and runs two brackets: [[experiment]]."
        if (at := re.search(r"at line (\d+)", str(error))) and "\\" in text.split("\n")[int(at[1]) - 1]:
            remedy = f"Correct it: {BACKSLASH}."
        raise InputError(f"{where}: is not TOML ({error})", remedy) from None
    with quantities_in(document, where).spoken():
        return _parsed(document, where, readers)


def is_manifest(text: str) -> bool:
    """Say whether a text may be a manifest, good or bad: it is TOML, or JSON in its place."""
    try:
        _check_depth(text, "")
        tomllib.loads(text)
    except (InputError, ValueError, RecursionError):
        return _JSON.match(text) is not None
    return True


def no_json(where: str) -> InputError:
    """Say that a file of JSON is no manifest, and no table either."""
    return InputError(f"{where}: is no manifest of a campaign but JSON", f"Save the record as CSV. {_NAME_CSV}")


def quantities_in(document: Mapping[str, Any], where: str) -> Quantities:
    """Quantities that a manifest speaks of; its texts and its path are names."""
    motion, input_unit = document.get("motion"), middle_dot(document.get("input_unit"))
    own = Quantities(
        motion if motion in MOTIONS else CART.motion, input_unit if input_unit in INPUT_UNITS else CART.input_unit
    )
    runs = document.get("experiment")
    tables = [document, *(run for run in runs if isinstance(run, Mapping))] if isinstance(runs, list) else [document]
    values = [value for table in tables for value in table.values()]
    several = [one for value in values for one in (value if isinstance(value, list | tuple) else [value])]
    return own.keeping([where, *(text for text in several if isinstance(text, str))])


def _parsed(
    document: dict[str, Any], where: str, readers: Readers
) -> tuple[dict[str, Any], list[tuple[str, dict[str, Any]]]]:
    """Check what stands in a manifest; see `parse_manifest`."""
    runs = _listed_runs(document.pop("experiment", None), document, where)
    if own := [key for key in document if key in OWN and key not in CAMPAIGN]:
        raise InputError(
            f"{where}: the key {own[0]!r} stands above the runs", "Move it below the [[experiment]] of its run."
        )
    shareable = _shareable(readers)
    above = _checked(document, {**CAMPAIGN, **shareable}, ("name",), where)
    defaults = {key: value for key, value in document.items() if key in shareable}
    parsed = [_run(run, defaults, i, where, readers) for i, run in enumerate(runs)]
    _check_defaults(defaults, {kind for kind, _ in parsed}, where, readers)
    return {key: above[key] for key in CAMPAIGN if key in above}, parsed


def _listed_runs(runs: object, above: Mapping[str, object], where: str) -> list[dict[str, Any]]:
    """Return the runs if they are a list of tables; InputError tells what `above` them may have been meant for one."""
    if isinstance(runs, list) and runs and all(isinstance(run, dict) for run in runs):
        return runs
    if isinstance(runs, Mapping):
        raise InputError(f"{where}: lists no experiments but one [experiment]", "Write two brackets: [[experiment]].")
    near = [key for key in above if get_close_matches(key.lower(), ["experiment", "run", "runs"], cutoff=0.7)]
    if near:
        raise InputError(f"{where}: lists no experiments but {near[0]!r}", "Write [[experiment]] above each run.")
    raise InputError(f"{where}: lists no experiments", "Add a [[experiment]] table for each run.")


def _shareable(readers: Readers) -> dict[str, Check]:
    """Keys that may stand above the runs, for all of them: those of every format."""
    every = {**SHARED, "format": _one_of(readers)}
    for reader in readers.values():
        every |= reader.keys
    return {key: check for key, check in every.items() if key not in OWN}


def _check_defaults(defaults: Mapping[str, object], formats: Collection[str], where: str, readers: Readers) -> None:
    """Refuse a key above the runs that no run's format has."""
    used = {*SHARED, *(key for name in formats for key in readers[name].keys)}
    idle = next((key for key in defaults if key not in used), None)
    if idle is not None:
        only, remedy = _owner(idle, readers)
        raise InputError(f"{where}: the key {idle!r} is for {only}, and no run is one", remedy)


def _check_depth(text: str, where: str) -> None:
    """Refuse keys of very many parts: the time that they take grows with the square of their number."""
    work = 0
    for number, line in enumerate(text.split("\n"), 1):
        dots = line.count(".")
        work += dots * dots
        if work > _WORK or (dots > _DEEPEST and line.lstrip().startswith("[")):
            cause = f"{where}, line {number}: holds {dots} points, more than the keys and numbers of a manifest"
            remedy = "Write a list of many files on several lines." if where.endswith(".toml") else _NAME_IT
            raise InputError(cause, remedy)


def _one_of(readers: Readers) -> Check:
    """Check of the key ``format``."""

    def check(value: object) -> str:
        if not isinstance(value, str) or value not in readers:
            raise WantedError(" or ".join(f'"{name}" ({reader.hint})' for name, reader in readers.items()))
        return value

    return check


def _owner(key: str, readers: Readers) -> tuple[str, str]:
    """Whose a key is that a run cannot have, and what to do."""
    name = next(name for name, reader in readers.items() if key in reader.keys)
    default = name == next(iter(readers))
    return readers[name].records, "Remove the key." if default else f'Add format = "{name}", or remove the key.'


def _run(
    run: dict[str, Any], defaults: dict[str, Any], index: int, where: str, readers: Readers
) -> tuple[str, dict[str, Any]]:
    who = f"{where}, run {run['name']!r}" if isinstance(run.get("name"), str) else f"{where}, experiment {index + 1}"
    is_format = _one_of(readers)
    kind = run.get("format", defaults.get("format", next(iter(readers))))
    reader = readers[str(_right(is_format, "format", kind, who))]
    known = {**SHARED, "format": is_format, **reader.keys}
    others = {key for other in readers.values() for key in other.keys if key not in known}
    if only := [key for key in run if key in others]:
        records, remedy = _owner(only[0], readers)
        raise InputError(f"{who}: the key {only[0]!r} is for {records}", remedy)
    said = {"step", "input"} & run.keys()  # one takes the place of the other
    shared = {k: v for k, v in defaults.items() if k in known and not (said and k in ("step", "input"))}
    several = "files" in reader.keys
    required = (*REQUIRED, *(() if several else ("file",)), *reader.required)
    checked = _checked({**shared, **run}, known, required, who)
    checked.pop("format", None)
    if several and ("file" in checked) == ("files" in checked):
        raise InputError(f"{who}: needs either file or files", 'Give file = "…" or files = ["…", "…"].')
    if "step" in checked and "input" in checked:
        raise InputError(f"{who}: gives both step and input", "Keep the one that is true.")
    return kind, checked


def _checked(
    keys: Mapping[str, object], checks: Mapping[str, Check], required: Sequence[str], who: str
) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in keys.items():
        if key not in checks:
            if key in CAMPAIGN:
                raise InputError(f"{who}: {key!r} is a key of the campaign", "Move it above the first [[experiment]].")
            near = get_close_matches(key, checks, n=1, cutoff=0.5)
            known = f"Did you mean {near[0]!r}?" if near else f"Known keys: {', '.join(checks)}."
            raise InputError(f"{who}: unknown key {key!r}", known)
        result[key] = _right(checks[key], key, value, who)
    missing = [key for key in required if key not in result]
    if missing:
        place = "; above the first [[experiment]] it is for all runs" if missing[0] not in OWN else ""
        if len(missing) > 1:
            several = ", ".join(map(repr, missing))
            raise InputError(
                f"{who}: the keys {several} are missing", f"Add {', '.join(f'{key} = …' for key in missing)}."
            )
        raise InputError(f"{who}: the key {missing[0]!r} is missing", f"Add {missing[0]} = …{place}.")
    return result


def _right(check: Callable[[object], T], key: str, value: object, who: str) -> T:
    try:
        return check(value)
    except WantedError as wanted:
        text = repr(value)
        shown = text if len(text) <= 60 else text[:57] + "..."
        raise InputError(f"{who}: {key} is {shown}", f"It must be {wanted}.") from None


def check_value(key: str, value: object, who: str) -> object:
    """Check the value of a key of `SHARED` as in a manifest; InputError names `who`."""
    return _right(SHARED[key], key, value, who)


def render_manifest(campaign: Mapping[str, object], experiments: Sequence[Mapping[str, object]]) -> str:
    """Write the text of a manifest; numbers in full, so that they read back equal."""
    blocks = [_lines(campaign), *("[[experiment]]\n" + _lines(run) for run in experiments)]
    return "\n".join(blocks)


def _lines(keys: Mapping[str, object]) -> str:
    return "".join(f"{key} = {toml_value(value)}\n" for key, value in keys.items())


def toml_value(value: object) -> str:
    """Write a text, a number or a table of such as TOML."""
    if isinstance(value, str):
        # JSON's escapes are TOML's, except that TOML wants DEL escaped, too
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_value(one)}" for key, one in value.items()) + " }"
    return repr(value)
