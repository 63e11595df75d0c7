"""Readers of records: what a format is, for the manifest; adding one is a class like these and an entry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

from stepid.core.experiment import Experiment
from stepid.errors import InputError
from stepid.io.ecp import read_ecp
from stepid.io.manifest_values import (
    Check,
    check_column,
    check_decimal,
    check_positive,
    check_scale,
    check_text,
    check_texts,
    check_whole,
)
from stepid.io.table import read_table
from stepid.io.tables import read_tables


class Reader(Protocol):
    """Reads the records of one format; with a key ``files`` a run may name several files."""

    @property
    def records(self) -> str:
        """What its records are, for messages: "tables"."""

    @property
    def hint(self) -> str:
        """How to choose it among the others, for messages: "CSV or any delimited text"."""

    @property
    def keys(self) -> Mapping[str, Check]:
        """What a run may have beside the keys of every run, each with the check of its value."""

    @property
    def required(self) -> Sequence[str]:
        """Which of `keys` a run must have."""

    def read(self, paths: Sequence[Path], **keys: Any) -> Experiment:
        """Read one run.

        Parameters
        ----------
        paths : sequence of pathlib.Path
            Its files; they exist.
        **keys
            Those of the run, checked: ``name``, ``added_mass``, …; a ``step`` comes as ``input``.

        Returns
        -------
        Experiment

        Raises
        ------
        stepid.errors.InputError
            Naming the file.
        """


class EcpReader:
    """Exports of the ECP program."""

    records = "exports of the ECP program"
    hint = "the default"
    keys: Mapping[str, Check] = MappingProxyType(
        {"encoder": check_whole, "columns": check_texts, "effort_scale": check_scale}
    )
    required = ()

    def read(self, paths: Sequence[Path], **keys: Any) -> Experiment:
        """Read one export; see `stepid.read_ecp`."""
        if "counts_per_meter" not in keys:
            raise InputError(
                "counts_per_meter is missing",
                'Add it above the runs or to the run; a CSV table needs none, but format = "table" with its columns: '
                "time, position, position_scale (meters per unit) and input.",
            )
        return read_ecp(paths[0], **keys)


class TableReader:
    """Delimited tables."""

    records = "tables"
    hint = "CSV or any delimited text"
    keys: Mapping[str, Check] = MappingProxyType(
        {
            "files": check_texts,
            "time": check_column,
            "position": check_column,
            "input": check_column,
            "time_scale": check_positive,
            "position_scale": check_scale,
            "input_scale": check_scale,
            "delimiter": check_text,
            "decimal": check_decimal,
            "skiprows": check_whole,
            "encoding": check_text,
            "sheet": check_text,
            "start": check_whole,
            "stop": check_whole,
            "run": check_text,
        }
    )
    required = ("position",)

    def read(self, paths: Sequence[Path], **keys: Any) -> Experiment:
        """Read one table or several that are joined; see `stepid.read_table`, with ``run`` `stepid.read_tables`."""
        run = keys.pop("run", None)
        return read_table(paths, **keys) if run is None else read_tables(paths, runs=(run,), **keys)[0]
