"""Where the numbers of a report come from: files with their hashes, versions, date."""

from __future__ import annotations

import hashlib
from datetime import UTC, datetime

import numpy as np

from stepid.core.base import Label, Model
from stepid.core.experiment import Campaign
from stepid.core.provenance import Source, sources_of, versions
from stepid.diagnosis.result import Diagnosis

_PACKAGES = ("Python", "stepid", "numpy", "scipy", "control")


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


def of_campaign(campaign: Campaign) -> Provenance:
    """Say which files a campaign was read from, as they were then.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    Provenance
    """
    return _today(sources_of(campaign), of_files=True)


def of_diagnosis(diagnosis: Diagnosis) -> Provenance:
    """Say where a diagnosis comes from: the files as they were read, or its records where it came from none.

    Parameters
    ----------
    diagnosis : Diagnosis

    Returns
    -------
    Provenance
    """
    known = diagnosis.provenance
    if known is None or not known.sources:
        return of_data(diagnosis)
    return _today(known.sources, of_files=True)


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
    return Provenance(
        sources=sources,
        of_files=of_files,
        versions=tuple((package, versions()[package]) for package in _PACKAGES),
        written=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
