"""Results as files that last: one JSON file each, with its schema, versions, provenance and a hash of itself."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from stepid.core.atomic_write import staged
from stepid.core.base import Model
from stepid.core.provenance import versions
from stepid.core.takes import described
from stepid.errors import InputError

FORMAT = "stepid result"
_A_LINE = 50
SCHEMA = 1
"""Raised where files of the version before need a change to be read; `stepid.report.saved` then holds that change."""


def save(model: Model, path: str | os.PathLike[str]) -> Path:
    """Write a model; see `Model.save`."""
    if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str) or not os.fspath(path):
        raise InputError(f"{described(path)} is not a path", "Give the file's path as text or pathlib.Path.")
    if "\0" in os.fspath(path):
        raise InputError(f"{path!r} cannot be written: it holds a zero byte", "Correct the path.")
    target = Path(path)
    if os.path.isdir(target):
        raise InputError(f"{target} is a folder", f"Name a file in it, for example {target / 'result.json'}.")
    document = {
        "format": FORMAT,
        "schema": SCHEMA,
        "kind": type(model).__name__,
        "versions": dict(versions()),
        "provenance": None if model.provenance is None else model.provenance.to_dict(),
        "parts": {where: part.provenance.to_dict() for where, part in parts(model) if part.provenance is not None},
        "result": model.to_dict(),
    }
    document["sha256"] = checksum(document)
    try:
        raw = (_written(document) + "\n").encode()
    except UnicodeEncodeError as error:
        raise InputError(f"{target}: a name is not text ({error.reason})", "Rename it.") from None
    with staged(target.parent) as folder:
        (folder / target.name).write_bytes(raw)
    return target


def _written(value: object) -> str:
    """Write JSON with one entry a line, but up to 50 numbers: lines that people, editors and diff can take."""
    if isinstance(value, dict) and value:
        entries = (f"{json.dumps(key, ensure_ascii=False)}: {_written(one)}" for key, one in value.items())
        return "{\n" + ",\n".join(entries) + "\n}"
    if isinstance(value, list) and any(isinstance(one, dict | list) for one in value):
        return "[\n" + ",\n".join(map(_written, value)) + "\n]"
    if isinstance(value, list) and len(value) > _A_LINE:
        cuts = range(0, len(value), _A_LINE)
        return "[\n" + ",\n".join(json.dumps(value[i : i + _A_LINE], ensure_ascii=False)[1:-1] for i in cuts) + "\n]"
    return json.dumps(value, ensure_ascii=False)


def checksum(document: Mapping[str, Any]) -> str:
    """SHA-256 of all that a file says but its own ``sha256``, whatever its layout and the order of its keys."""
    told = {key: value for key, value in document.items() if key != "sha256"}
    return hashlib.sha256(json.dumps(told, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def parts(model: Model, where: str = "") -> Iterator[tuple[str, Model]]:
    """All models inside a model, each with the way to it: ``"data/experiments/0"``."""
    for field in type(model).model_fields:
        yield from _inside(getattr(model, field), f"{where}{field}")


def _inside(value: object, where: str) -> Iterator[tuple[str, Model]]:
    if isinstance(value, Model):
        yield where, value
        yield from parts(value, f"{where}/")
    elif isinstance(value, tuple):
        for number, one in enumerate(value):
            yield from _inside(one, f"{where}/{number}")
    elif isinstance(value, Mapping):
        for key, one in value.items():
            yield from _inside(one, f"{where}/{key}")
