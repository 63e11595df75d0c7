"""Saved results read again, whichever version of stepid wrote them."""

from __future__ import annotations

import inspect
import json
import os
import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import stepid
from stepid.core.base import Model
from stepid.core.provenance import Provenance
from stepid.core.saving import FORMAT, SCHEMA, checksum, parts
from stepid.core.takes import article, described
from stepid.errors import InputError
from stepid.io.textfile import as_path, decode, read_bytes

M = TypeVar("M", bound=Model)
Document = dict[str, Any]
UPGRADES: Mapping[int, Callable[[Document], Document]] = {}
"""Schema to what makes its documents those of the next schema."""
_RESAVE = "Save the result again, or get another copy of the file."


def load(path: str | os.PathLike[str], *, kind: type[M] = Model) -> M:  # type: ignore[assignment]
    """Read what the `save` of a result wrote, in this version or an older one.

    Parameters
    ----------
    path : path-like
    kind : type, optional
        What the file shall hold, for example ``stepid.Diagnosis``; by default anything that stepid saves.

    Returns
    -------
    stepid.core.base.Model
        Equal to what was saved: a `Diagnosis`, a `Fit`, a `Campaign`, …; its `provenance` is that of the saved one.

    Raises
    ------
    stepid.errors.InputError
        If there is no such file, it is damaged or changed, is nothing that stepid saved, comes from a newer version or
        holds another kind of result.
    """
    if not (isinstance(kind, type) and issubclass(kind, Model)):
        raise InputError(
            f"kind = {described(kind)} is no kind of result", "Give a class, for example kind=stepid.Diagnosis."
        )
    file = as_path(path)
    document = _current(_document(file), file)
    name = document["kind"]
    found = kind if kind.__name__ == name else kinds().get(name)
    if found is None:
        raise InputError(
            f"{file}: holds {article(name)}, which this version of stepid does not know",
            _update(document) or "If it is a class of your own, give it: stepid.load(path, kind=…).",
        )
    if not issubclass(found, kind):
        raise InputError(
            f"{file}: holds {article(name)}, not {article(kind.__name__)}", f"Leave out kind={kind.__name__}."
        )
    try:
        model = found.from_dict(document["result"])
        _give_provenance(model, document)
    except InputError as error:
        raise InputError(f"{file}: {error.cause}", _update(document) or _RESAVE) from None
    except (TypeError, AttributeError, RecursionError):
        raise InputError(f"{file}: holds no whole {name}", _update(document) or _RESAVE) from None
    return model


@cache
def kinds() -> Mapping[str, type[Model]]:
    """What can be read by its name: every model that is public, and what public functions give."""
    from stepid.datasets.lab import LabTruth
    from stepid.datasets.paper import PaperData
    from stepid.datasets.replication import Misprint, PaperRebuild, PaperResponse, PrintedCase
    from stepid.diagnosis.result import Gap, Ranked, RunGap, Where
    from stepid.identification.parameters import ParameterUncertainty
    from stepid.identification.transfer.verification import VerificationRun
    from stepid.identification.trends import Trend, Trends

    found: list[type[Model]] = [LabTruth, PaperData, Misprint, PaperRebuild, PaperResponse, PrintedCase]
    found += [Gap, Ranked, RunGap, Where, ParameterUncertainty, Trend, Trends, VerificationRun, Provenance]
    for room in (stepid, stepid.lab):
        public = [getattr(room, name) for name in room.__all__]
        found += [one for one in public if inspect.isclass(one) and issubclass(one, Model)]
    return {one.__name__: one for one in found}


def _document(file: Path) -> Document:
    """Read the file and see that it is whole and ours."""
    text = decode(read_bytes(file), str(file))
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        whose = "is damaged" if FORMAT in text[:200] else "is no JSON"
        raise InputError(
            f"{file}, line {error.lineno}, column {error.colno}: {whose} ({error.msg})",
            f"A file that stepid saves is written whole or not at all: it was cut off or changed later. {_RESAVE}"
            if FORMAT in text[:200]
            else "Give a file that the save of a result wrote.",
        ) from None
    except (ValueError, RecursionError):  # a number of thousands of digits, brackets within brackets
        raise InputError(f"{file}: is damaged", _RESAVE) from None
    if not isinstance(document, dict) or document.get("format") != FORMAT or type(document.get("schema")) is not int:
        raise InputError(
            f"{file}: is no result that stepid saved",
            "Give a file that the save of a result wrote; stepid.read_campaign reads manifests, and what --json and"
            " --out write is for other programs.",
        )
    if document["schema"] > SCHEMA or document["schema"] < 1:
        raise InputError(
            f"{file}: has schema {document['schema']}; stepid {stepid.__version__} reads 1 to {SCHEMA}",
            "It was saved by a newer version: update stepid with pip install --upgrade stepid.",
        )
    if document.get("sha256") != checksum(document):
        raise InputError(f"{file}: was changed or damaged after it was saved", _RESAVE)
    return document


def _current(document: Document, file: Path) -> Document:
    for schema in range(document["schema"], SCHEMA):
        document = UPGRADES[schema](document)
    shapes = {"kind": str, "versions": dict, "parts": dict, "result": dict}
    if not all(isinstance(document.get(key), shape) for key, shape in shapes.items()):
        raise InputError(f"{file}: is no result that stepid saved", _RESAVE)
    return document


def _give_provenance(model: Model, document: Document) -> None:
    if document.get("provenance") is not None:
        model._provenance = Provenance.from_dict(document["provenance"])
    inside = dict(parts(model)) if document["parts"] else {}
    for where, told in document["parts"].items():
        if where in inside:
            inside[where]._provenance = Provenance.from_dict(told)


def _update(document: Document) -> str:
    """What to do where a newer version saved the file; nothing where it did not."""
    saved = document["versions"].get("stepid")
    if not isinstance(saved, str) or _numbers(saved) <= _numbers(stepid.__version__):
        return ""
    return f"It was saved by stepid {saved}, and this is {stepid.__version__}: update stepid."


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(number) for number in re.findall(r"\d{1,9}", version)[:3])
