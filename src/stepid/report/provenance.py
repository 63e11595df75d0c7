"""Where the numbers of a report come from: files with their hashes, versions, date."""

from __future__ import annotations

import hashlib
import os
import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from stepid.core.base import Label, Model
from stepid.diagnosis.result import Diagnosis
from stepid.io.campaign_files import MANIFEST, READERS, named_files
from stepid.io.manifest import parse_manifest
from stepid.io.safe_read import inside
from stepid.io.textfile import as_path, decode, read_bytes

_PACKAGES = ("stepid", "numpy", "scipy", "control")


class Source(Model):
    """What was read: a file, or a run of which only the numbers are known.

    Parameters
    ----------
    name : str
        File name, relative to the manifest's folder, or run.
    sha256 : str
        Of the file's bytes, or of the run's numbers.
    """

    name: Label
    sha256: Label


class Provenance(Model):
    """Where a report comes from.

    Parameters
    ----------
    sources : tuple of Source
    of_files : bool
        True where the hashes are those of files, as ``sha256sum`` prints them.
    versions : tuple of tuple of str
        Package and version.
    written : str
        Date and time, UTC.
    """

    sources: tuple[Source, ...]
    of_files: bool
    versions: tuple[tuple[str, str], ...]
    written: Label


def of_files(manifest: str | os.PathLike[str], *, allow_outside: bool = False) -> Provenance:
    """Hash the manifest of a campaign and every file that it names.

    Parameters
    ----------
    manifest : path-like
    allow_outside : bool
        As for `stepid.read_campaign`.

    Returns
    -------
    Provenance

    Raises
    ------
    stepid.errors.InputError
        If a file cannot be read, or lies outside of the manifest's folder.
    """
    path = as_path(manifest)
    if os.path.isdir(path):
        path = path / MANIFEST
    raw = read_bytes(path)
    _, runs = parse_manifest(decode(raw, str(path)), str(path), READERS)
    names = [name for _, run in runs for name in named_files(run)]
    sources = [Source(name=path.name, sha256=hashlib.sha256(raw).hexdigest())]
    for name in dict.fromkeys(names):  # several runs may come from one table
        file = inside(path.parent, name, str(path), allow_outside=allow_outside)
        sources.append(Source(name=name, sha256=hashlib.sha256(read_bytes(file)).hexdigest()))
    return _today(tuple(sources), of_files=True)


def of_data(diagnosis: Diagnosis) -> Provenance:
    """Hash the records that a diagnosis holds, where the files are not known.

    Parameters
    ----------
    diagnosis : Diagnosis

    Returns
    -------
    Provenance
        For each run the hash of its times [s], then its measured positions [m], as little-endian 64-bit floats.
    """
    sources = []
    for run in diagnosis.runs:
        numbers = np.array([run.time, run.measured], dtype="<f8").tobytes()
        sources.append(Source(name=run.name, sha256=hashlib.sha256(numbers).hexdigest()))
    return _today(tuple(sources), of_files=False)


def _today(sources: tuple[Source, ...], *, of_files: bool) -> Provenance:
    found = [("Python", platform.python_version())]
    for package in _PACKAGES:
        try:
            found.append((package, version(package)))
        except PackageNotFoundError:  # run from a copy that was never installed
            found.append((package, "unknown"))
    return Provenance(
        sources=sources,
        of_files=of_files,
        versions=tuple(found),
        written=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
