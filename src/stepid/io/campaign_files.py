"""Campaigns on disk: campaign.toml and the records beside it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from stepid.core.arguments import as_campaign
from stepid.core.atomic_write import staged
from stepid.core.base import Model
from stepid.core.experiment import Campaign, Experiment
from stepid.core.quantities import in_own_quantities
from stepid.core.recorded import recorded
from stepid.core.takes import described
from stepid.errors import InputError, naming
from stepid.io.ecp_write import render_export
from stepid.io.manifest import BACKSLASH, no_json, parse_manifest, quantities_in, render_manifest
from stepid.io.readers import EcpReader, Reader, TableReader
from stepid.io.safe_read import inside
from stepid.io.textfile import as_path, decode, read_bytes

MANIFEST = "campaign.toml"
_ESCAPED = "\a\b\t\n\v\f\r\x1b"
LARGEST_MANIFEST = 1_000_000
"""Bytes of a manifest: more than 3,000 runs."""
READERS: dict[str, Reader] = {"ecp": EcpReader(), "table": TableReader()}
"""Formats of records by the name that a manifest gives them; the first is the default. Add your own."""


@recorded()
def read_campaign(path: str | os.PathLike[str], *, allow_outside: bool = False) -> Campaign:
    """Read a campaign from its manifest and the records that it names.

    Parameters
    ----------
    path : path-like
        The manifest, or the folder in which it is called ``campaign.toml``. Files are looked for beside it.
    allow_outside : bool
        Read files outside of the manifest's folder, too: by absolute paths, ``..`` or links. Only for manifests that
        you trust: one from a stranger could take any file of yours for a record.

    Returns
    -------
    Campaign

    Raises
    ------
    stepid.errors.InputError
        Naming the manifest, the run and the key, or the run, its file, line and column: for a missing file, an unknown
        or missing key (with the nearest known one), a name used twice, a mass below zero, and all that `read_ecp` and
        `read_table` refuse.

    Notes
    -----
    Keys of the campaign: ``name`` and, optionally, ``weight_uncertainty`` (kg), ``scale_uncertainty`` (relative),
    ``motion`` (``"translation"``, ``"rotation"``: kg·m², rad and N·m in place of kg, m and N) and ``input_unit``
    (``"V"``, ``"A"``, ``"N"``, ``"N·m"``; in place of V).
    Keys of a run (``[[experiment]]``):
    ``name``, ``file``, ``added_mass`` (kg), ``spring``, ``damper``, ``counts_per_meter``; optionally ``base``,
    ``encoder``, ``sample_time`` (s), ``step = { level = 0.5, start = 0.0 }`` (V, s) where the file has no Control
    Effort, ``input_before`` (V), ``input_between`` (``"held"``, ``"lines"``, ``"smooth"``), ``starts`` (``"auto"``,
    ``"rest"``, ``"motion"``), ``columns`` and ``effort_scale``, as in `read_ecp`. With ``format = "table"``:
    ``file`` or ``files``, ``position`` and, optionally, ``time``, ``input``, ``position_scale``, ``time_scale``,
    ``input_scale``, ``delimiter``, ``decimal``, ``skiprows``, ``encoding``, ``sheet``, ``start`` and ``stop``, as in
    `read_table`, and ``run``, one of several side by side, as in `read_tables`. Any key of a run but ``name``,
    ``file`` and ``files`` may stand above the runs instead, for all of them; a run's own key wins.
    """
    manifest = as_path(path)
    if os.path.isdir(manifest):  # pathlib's is_dir raises on names that the system refuses
        manifest = manifest / MANIFEST
    if not isinstance(allow_outside, bool):
        raise InputError(f"allow_outside is {described(allow_outside)}", "Give True or False.")
    where = str(manifest)
    if manifest.suffix.lower() == ".json" and os.path.isfile(manifest):  # whatever its size
        raise no_json(where)
    text = decode(read_bytes(manifest, largest=LARGEST_MANIFEST), where)
    return campaign_of(text, manifest, allow_outside=allow_outside)


def campaign_of(text: str, manifest: Path, *, allow_outside: bool = False) -> Campaign:
    """Read a campaign from the text of its manifest; files are looked for beside `manifest`, which need not exist."""
    where = str(manifest)
    keys, runs = parse_manifest(text, where, READERS)
    with quantities_in({**keys, "experiment": [run for _, run in runs]}, where).spoken():
        experiments = tuple(_read_run(kind, run, manifest, allow_outside=allow_outside) for kind, run in runs)
    with naming(where):
        return Campaign(experiments=experiments, **keys)


@recorded()
def read_as(text: str, manifest: Path) -> Campaign:
    """Read a campaign like `campaign_of`, from wherever its files are; it knows the files that it comes from."""
    return campaign_of(text, manifest, allow_outside=True)


def named_files(run: Mapping[str, Any]) -> tuple[str, ...]:
    """Files that a run of a manifest names, in order."""
    return tuple(run.get("files", ())) or (run["file"],)


def _read_run(kind: str, run: dict[str, Any], manifest: Path, *, allow_outside: bool) -> Experiment:
    who = f"{manifest}, run {run['name']!r}"
    names = named_files(run)
    keys = {key: value for key, value in run.items() if key not in ("file", "files")}
    if "step" in keys:
        keys["input"] = keys.pop("step")
    for name in names:
        _check_escapes(manifest.parent, name, who)
    paths = [inside(manifest.parent, name, who, allow_outside=allow_outside) for name in names]
    for name, path in zip(names, paths, strict=True):
        if not os.path.exists(path):
            slash = ', with "/" between folders' * ("\\" in name)
            raise InputError(
                f"{who}: there is no file {name!r} beside the manifest",
                f"Correct its name{slash}, or put the file there.",
            )
    with naming(who):
        return READERS[kind].read(paths, **keys)


def _check_escapes(folder: Path, name: str, who: str) -> None:
    r"""Refuse what a backslash makes of a name: in TOML ``"lab\run1.csv"`` holds a carriage return."""
    odd = next((letter for letter in name if letter in _ESCAPED), None)
    if odd is not None and not os.path.exists(folder / name):
        raise InputError(
            f"{who}: there is no file {name!r}, whose name holds the control character {odd!r}",
            f"Correct it: {BACKSLASH}.",
        )


@in_own_quantities
def write_campaign(campaign: Campaign, folder: str | os.PathLike[str]) -> Path:
    """Write a campaign: a manifest, and for each run a file that reads back equal.

    A run whose positions are whole counts and whose inputs have four decimals becomes an ECP export, any other a table
    with 17 digits. Nothing is overwritten, and nothing is left behind where writing fails.

    Parameters
    ----------
    campaign : Campaign
    folder : path-like
        Made if it does not exist.

    Returns
    -------
    pathlib.Path
        The manifest.

    Raises
    ------
    stepid.errors.InputError
        If the folder holds a file of one of the names to be written, or cannot be written to.
    """
    target = as_path(folder)
    files = _render(as_campaign(campaign))
    for name in files:
        if os.path.lexists(target / name):
            raise InputError(f"{target / name}: exists already", "Choose a new folder, or move the file away.")
    with staged(target) as scratch:  # by name the manifest is last, so a campaign is seen whole or not at all
        for name, content in files.items():
            (scratch / name).write_bytes(content)
    return target / MANIFEST


def _render(campaign: Campaign) -> dict[str, bytes]:
    scales = {e.counts_per_meter for e in campaign.experiments}
    shared = scales.pop() if len(scales) == 1 else None
    keys: dict[str, object] = {"name": campaign.name}
    if shared is not None:
        keys["counts_per_meter"] = shared
    keys |= _unusual(campaign, ("weight_uncertainty", "scale_uncertainty", "motion", "input_unit"))
    files: dict[str, bytes] = {}
    runs = []
    for number, experiment in enumerate(campaign.experiments, 1):
        run: dict[str, object] = {
            "name": experiment.name,
            "added_mass": experiment.added_mass,
            "spring": experiment.spring,
            "damper": experiment.damper,
            "base": experiment.base,
        }
        if shared is None and experiment.counts_per_meter is not None:
            run["counts_per_meter"] = experiment.counts_per_meter
        run |= _unusual(experiment, ("input_before", "input_between", "starts"))
        stem = f"{number:02d}-" + (re.sub(r"[^a-z0-9]+", "-", experiment.name.lower()).strip("-")[:40] or "run")
        export = render_export(experiment)
        if export is not None:
            text, period = export
            run |= {"file": f"{stem}.txt", "sample_time": period}
        else:
            text = _table_text(experiment)
            run |= {"format": "table", "file": f"{stem}.csv", "time": "time", "position": "position", "input": "input"}
        files[str(run["file"])] = text.encode()
        runs.append(run)
    try:
        files[MANIFEST] = render_manifest(keys, runs).encode()
    except UnicodeEncodeError as error:
        raise InputError(f"campaign {campaign.name!r}: a name is not text ({error.reason})", "Rename it.") from None
    return files


def _unusual(model: Model, fields: Iterable[str]) -> dict[str, object]:
    """Values of the fields that differ from their defaults."""
    values = {field: getattr(model, field) for field in fields}
    return {field: value for field, value in values.items() if value != type(model).model_fields[field].default}


def _table_text(experiment: Experiment) -> str:
    rows = zip(experiment.time, experiment.position, experiment.input, strict=True)
    return "time,position,input\n" + "".join(f"{t:.17g},{x:.17g},{u:.17g}\n" for t, x, u in rows)
