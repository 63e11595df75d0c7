"""Where a result comes from: the bytes that were read, the numbers that were worked on, settings and versions."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Iterable, Mapping, Sequence, ValuesView
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from stepid.core.base import Label, Model
from stepid.core.experiment import Campaign, Experiment

_PACKAGES = ("stepid", "numpy", "scipy", "control", "numba", "pydantic")


class Source(Model):
    """A file that was read, or a run of which only the numbers are known.

    Parameters
    ----------
    name : str
        File name, relative to the folder of the file that was read first, or run.
    sha256 : str
        Of the file's bytes as they were read, or of the run's numbers.
    """

    name: Label
    sha256: Label


class Provenance(Model):
    """Where a result comes from. It stands beside the data: results are equal whatever theirs is.

    Parameters
    ----------
    function : str
        What made the result: ``"diagnose"``, ``"read_campaign"``, …
    sources : tuple of Source
        Files as they were read, with the SHA-256 that ``sha256sum`` prints; none for data that came from no file.
    records : tuple of Source
        Runs that were worked on: SHA-256 of time [s], position [m] and input [V] as little-endian 64-bit floats.
    settings : mapping
        The function's keyword arguments as plain values; None stands for the function's own choice.
    versions : mapping
        Package to version.
    made : str
        Date and time, UTC, ISO 8601.
    """

    function: Label
    sources: tuple[Source, ...] = ()
    records: tuple[Source, ...] = ()
    settings: Mapping[str, Any] = {}
    versions: Mapping[str, str] = {}
    made: str = ""


def made_now(
    function: str,
    *,
    read: Sequence[tuple[Path, str]] = (),
    data: Iterable[object] = (),
    settings: Mapping[str, object] | None = None,
) -> Provenance:
    """Say where a result comes from.

    Parameters
    ----------
    function : str
    read : sequence of tuple
        Files that were read, with their SHA-256.
    data : iterable
        What the function worked on: campaigns, experiments, results, lists of them.
    settings : mapping, optional

    Returns
    -------
    Provenance
    """
    sources = [Source(name=_short(path, read[0][0]), sha256=digest) for path, digest in read]
    records: list[Source] = []
    for item in data:
        _gather(item, sources, records)
    return Provenance(
        function=function,
        sources=tuple(dict.fromkeys(sources)),
        records=tuple(dict.fromkeys(records)),
        settings={name: plain(value) for name, value in (settings or {}).items()},
        versions=versions(),
        made=datetime.now(UTC).isoformat(timespec="seconds"),
    )


def joined(one: Model, other: object) -> Provenance | None:
    """Say where `one` comes from after something else was added to it."""
    told = one.provenance
    if told is None:
        return None
    return told.model_copy(update={"sources": tuple(dict.fromkeys((*told.sources, *sources_of(other))))})


def sources_of(data: object) -> tuple[Source, ...]:
    """Files that a campaign, an experiment or a result comes from, each once."""
    sources: list[Source] = []
    _gather(data, sources, [])
    return tuple(dict.fromkeys(sources))


@cache
def versions() -> Mapping[str, str]:
    """Versions of Python and of the packages that compute."""
    found = {"Python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:  # run from a copy that was never installed
            found[package] = "unknown"
    return found


def hash_of(run: Experiment) -> str:
    """SHA-256 of a run's time [s], position [m] and input [V], as little-endian 64-bit floats."""
    digest = hashlib.sha256()
    for values in (run.time, run.position, run.input):
        digest.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return digest.hexdigest()


def _gather(item: object, sources: list[Source], records: list[Source]) -> None:
    if isinstance(item, Model) and item.provenance is not None:
        sources += item.provenance.sources
    if isinstance(item, Experiment):
        records.append(Source(name=item.name, sha256=hash_of(item)))
    elif isinstance(item, Campaign):
        for run in item.experiments:
            if item.provenance is None:
                _gather(run, sources, records)
            else:
                records.append(Source(name=run.name, sha256=hash_of(run)))
    elif isinstance(item, Model) and item.provenance is not None:
        records += item.provenance.records
    elif isinstance(item, list | tuple | ValuesView):
        for one in item:
            _gather(one, sources, records)


def _short(path: Path, first: Path) -> str:
    """Name a file without telling where on the machine it lies."""
    try:
        return path.relative_to(first.parent).as_posix()
    except ValueError:
        return path.name


def plain(value: object) -> Any:
    """Write an argument as plain numbers, words, lists and dictionaries, without paths."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if np.isfinite(value) else str(value)
    if isinstance(value, np.ndarray):
        return {"shape": list(value.shape), "sha256": hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()}
    if isinstance(value, Model):
        return {"kind": type(value).__name__, **value.to_dict()}
    if isinstance(value, os.PathLike):
        return Path(value).name
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, Sequence):
        return [plain(one) for one in value]
    name = getattr(value, "name", None)  # an effect
    return name if isinstance(name, str) else type(value).__name__
