"""The manifest of a campaign, campaign.toml: its keys, checked one by one, and its text."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar

from stepid.core.samples import WAYS
from stepid.errors import InputError
from stepid.io.step_input import StepInput


class _WantedError(Exception):
    """What a value should have been."""


def _text(value: object) -> str:
    if not (isinstance(value, str) and value):
        raise _WantedError("text that is not empty")
    return value


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _WantedError("a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise _WantedError("a finite number")
    return number


def _positive(value: object) -> float:
    number = _number(value)
    if number <= 0:
        raise _WantedError("above zero")
    return number


def _mass(value: object) -> float:
    number = _number(value)
    if number < 0:
        raise _WantedError("the mass in kg that was added, 0 or more")
    return number


def _scale(value: object) -> float:
    number = _number(value)
    if number == 0:
        raise _WantedError("a number other than zero")
    return number


def _whole(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise _WantedError("a whole number")
    return value


def _column(value: object) -> str | int:
    if isinstance(value, bool) or not isinstance(value, str | int):
        raise _WantedError("a column's name or its index from 0")
    return value


def _texts(value: object) -> tuple[str, ...]:
    if not (isinstance(value, list) and value and all(isinstance(v, str) and v for v in value)):
        raise _WantedError("a list of texts")
    return tuple(value)


def _format(value: object) -> str:
    if value not in ("ecp", "table"):
        raise _WantedError('"ecp" (the default) or "table" (CSV or any delimited text)')
    return str(value)


def _decimal(value: object) -> str:
    if value not in (".", ","):
        raise _WantedError('"." (the default) or ","')
    return str(value)


def _between(value: object) -> str:
    if value not in WAYS:
        raise _WantedError('"held" (the default), "lines" (joined by straight lines) or "smooth" (a cubic spline)')
    return str(value)


def _step(value: object) -> StepInput:
    if not isinstance(value, dict) or "level" not in value or not value.keys() <= {"level", "start", "end"}:
        raise _WantedError("a table like { level = 0.5, start = 0.0 }, in V and s (end is optional)")
    try:
        numbers = {key: _number(v) for key, v in value.items()}
    except _WantedError:
        raise _WantedError("a table of numbers like { level = 0.5, start = 0.0 }") from None
    return StepInput(**numbers)


T = TypeVar("T")
Check = Callable[[object], object]
CAMPAIGN: Mapping[str, Check] = {"name": _text, "weight_uncertainty": _positive}
_SHARED: Mapping[str, Check] = {
    "name": _text,
    "format": _format,
    "added_mass": _mass,
    "spring": _text,
    "damper": _text,
    "base": _text,
    "counts_per_meter": _scale,
    "input_before": _number,
    "input_between": _between,
    "sample_time": _positive,
    "step": _step,
}
EXPORT: Mapping[str, Check] = {
    **_SHARED,
    "file": _text,
    "encoder": _whole,
    "columns": _texts,
    "effort_scale": _scale,
}
TABLE: Mapping[str, Check] = {
    **_SHARED,
    "file": _text,
    "files": _texts,
    "time": _column,
    "position": _column,
    "input": _column,
    "time_scale": _positive,
    "position_scale": _scale,
    "input_scale": _scale,
    "delimiter": _text,
    "decimal": _decimal,
    "skiprows": _whole,
    "start": _whole,
    "stop": _whole,
}
KEYS = {"ecp": EXPORT, "table": TABLE}
OWN = ("name", "file", "files")  # never the same for all runs
DEFAULTS: Mapping[str, Check] = {key: check for key, check in {**EXPORT, **TABLE}.items() if key not in OWN}
REQUIRED = ("name", "added_mass", "spring", "damper")


def parse_manifest(text: str, where: str) -> tuple[dict[str, Any], list[tuple[str, dict[str, Any]]]]:
    """Parse and check the text of a manifest.

    Returns
    -------
    campaign : dict
        The campaign's own keys.
    experiments : list of (format, dict)
        Format ``"ecp"`` or ``"table"`` and the checked keys of each run. What stands above the runs and is a key of
        runs is theirs, but for those that say otherwise.

    Raises
    ------
    stepid.errors.InputError
        Naming the file, the run and the key.
    """
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        if not where.endswith(".toml"):
            raise InputError(
                f"{where}: is no manifest of a campaign (not TOML: {error})",
                "Give a campaign.toml that names this file under an [[experiment]]; stepid diagnose --help shows one.",
            ) from None
        remedy = "Correct it; texts need quotation marks, numbers points, and runs two brackets: [[experiment]]."
        raise InputError(f"{where}: is not TOML ({error})", remedy) from None
    runs = document.pop("experiment", None)
    if not isinstance(runs, list) or not runs or not all(isinstance(run, dict) for run in runs):
        raise InputError(f"{where}: lists no experiments", "Add a [[experiment]] table for each run.")
    if own := [key for key in document if key in OWN and key not in CAMPAIGN]:
        raise InputError(
            f"{where}: the key {own[0]!r} stands above the runs", "Move it below the [[experiment]] of its run."
        )
    above = _checked(document, {**CAMPAIGN, **DEFAULTS}, ("name",), where)
    defaults = {key: value for key, value in document.items() if key in DEFAULTS}
    parsed = [_run(run, defaults, i, where) for i, run in enumerate(runs)]
    if idle := [key for key in defaults if not any(key in KEYS[kind] for kind, _ in parsed)]:
        only, remedy = _ONLY["table" if idle[0] in TABLE else "ecp"]
        raise InputError(f"{where}: the key {idle[0]!r} is for {only}, and no run is one", remedy)
    return {key: above[key] for key in CAMPAIGN if key in above}, parsed


_ONLY = {
    "table": ("tables", 'Add format = "table", or remove the key.'),
    "ecp": ("exports of the ECP program", "Remove the key."),
}


def _run(run: dict[str, Any], defaults: dict[str, Any], index: int, where: str) -> tuple[str, dict[str, Any]]:
    who = f"{where}, run {run['name']!r}" if isinstance(run.get("name"), str) else f"{where}, experiment {index + 1}"
    kind = run.get("format", defaults.get("format", "ecp"))
    known = KEYS[_right(_format, "format", kind, who)]
    if kind == "ecp" and (only := [key for key in run if key in TABLE and key not in EXPORT]):
        raise InputError(f"{who}: the key {only[0]!r} is for tables", _ONLY["table"][1])
    said = {"step", "input"} & run.keys()  # one takes the place of the other
    shared = {k: v for k, v in defaults.items() if k in known and not (said and k in ("step", "input"))}
    required = (*REQUIRED, "file") if kind == "ecp" else (*REQUIRED, "position")
    checked = _checked({**shared, **run}, known, required, who)
    checked.pop("format", None)
    if kind == "table" and ("file" in checked) == ("files" in checked):
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
        place = "; above the first [[experiment]] it is for all runs" if missing[0] in DEFAULTS else ""
        raise InputError(f"{who}: the key {missing[0]!r} is missing", f"Add {missing[0]} = …{place}.")
    return result


def _right(check: Callable[[object], T], key: str, value: object, who: str) -> T:
    try:
        return check(value)
    except _WantedError as wanted:
        text = repr(value)
        shown = text if len(text) <= 60 else text[:57] + "..."
        raise InputError(f"{who}: {key} is {shown}", f"It must be {wanted}.") from None


def render_manifest(campaign: Mapping[str, object], experiments: Sequence[Mapping[str, object]]) -> str:
    """Write the text of a manifest; numbers in full, so that they read back equal."""
    blocks = [_lines(campaign), *("[[experiment]]\n" + _lines(run) for run in experiments)]
    return "\n".join(blocks)


def _lines(keys: Mapping[str, object]) -> str:
    return "".join(f"{key} = {_toml(value)}\n" for key, value in keys.items())


def _toml(value: object) -> str:
    if isinstance(value, str):
        # JSON's escapes are TOML's, except that TOML wants DEL escaped, too
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
