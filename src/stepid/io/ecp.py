"""Raw exports of the ECP Executive program, in every variant that labs pass on."""

from __future__ import annotations

import os
from collections.abc import Sequence
from numbers import Integral

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.recorded import recorded
from stepid.core.samples import InputBetween, Starts
from stepid.core.takes import described, taken
from stepid.core.takes import number as a_number
from stepid.core.units import check_numbers
from stepid.errors import InputError, naming
from stepid.io.ecp_layout import (
    COMMANDED,
    EFFORT,
    SAMPLE,
    TIME,
    Export,
    encoder_column,
    is_encoder,
    parse_export,
    repeats,
)
from stepid.io.sample_clock import real_stamps, rebuild_time
from stepid.io.step_input import InputValues, StepInput, sample_input
from stepid.io.textfile import as_path, read_lines

VOLTS_PER_DAC_UNIT = 5 / 4095  # the newer program logs 4095·V/5
FULL_SCALE = 12.0  # more volts than the plant's amplifier takes, fewer DAC units than any step
FEWEST = 8  # rows
MANY = 12  # more levels of effort than an operator steps through


@recorded()
def read_ecp(
    path: str | os.PathLike[str],
    *,
    counts_per_meter: float,
    encoder: int = 1,
    name: str | None = None,
    added_mass: float = 0.0,
    spring: str = "spring",
    damper: str = "damper",
    base: str = "cart",
    input: InputValues | None = None,
    input_before: float = 0.0,
    input_between: InputBetween = "held",
    starts: Starts = "auto",
    sample_time: float | None = None,
    columns: Sequence[str] | None = None,
    effort_scale: float | None = None,
) -> Experiment:
    """Read one raw export of the ECP Executive program.

    Read are: the raw export (header, then rows in brackets) with CR LF, LF or CR; copies whose header is missing, is a
    ``%`` comment or has become a file name, with ``dat = [`` before the rows (the paper's Figs. 4 and 5); and the
    tab-separated text of the newer program. Time is rebuilt from Sample, because exports print it rounded to 1 ms; the
    newer program's stamps are taken as they are where they are not one multiple of Sample.

    Parameters
    ----------
    path : path-like
        The file.
    counts_per_meter : float
        Encoder counts a meter of travel, negative where +V gives falling counts.
    encoder : int
        Number of the encoder to read, 1 to 3.
    name : str, optional
        Of the run; the file's stem by default.
    added_mass : float
        kg, known weights on the cart.
    spring, damper, base : str
        Labels of what the run shares with others.
    input : StepInput or array, shape (n,), optional
        V, for files without Control Effort. In open loop Commanded Pos only repeats the encoder and says nothing of it.
    input_before : float
        V, before the first sample.
    input_between : "held", "lines" or "smooth"
        What the input does between two samples, as in `Experiment`; the program's own is held.
    starts : "auto", "rest" or "motion"
        How the record starts, as in `Experiment`.
    sample_time : float, optional
        s; by default the least-squares slope of Time on Sample.
    columns : sequence of str, optional
        Names of all columns in order, for files whose header is missing or does not fit: ``"Sample"``, ``"Time"``,
        ``"Commanded Pos"``, ``"Encoder 1 Pos"``, ``"Control Effort"``; any other name is not read.
    effort_scale : float, optional
        V per unit of Control Effort; by default 1, and 5/4095 for the newer program's tab-separated text, which logs
        DAC units.

    Returns
    -------
    Experiment
        Time in s (Sample 0 is time 0), position in m, input in V.

    Raises
    ------
    stepid.errors.InputError
        Naming file, line and column: if the file is missing, empty, cut off, not text or holds what is not a number;
        if a column is missing or Sample has a gap; if Time is not one multiple of Sample or does not determine the
        sample time to 0.1 %; if nothing says what the input was; if the record is a closed-loop move.
    """
    file = as_path(path)
    export = parse_export(read_lines(file), columns=columns, where=str(file))
    return export_experiment(
        export,
        where=str(file),
        counts_per_meter=counts_per_meter,
        encoder=encoder,
        name=file.stem if name is None else name,
        added_mass=added_mass,
        spring=spring,
        damper=damper,
        base=base,
        input=input,
        input_before=input_before,
        input_between=input_between,
        starts=starts,
        sample_time=sample_time,
        effort_scale=effort_scale,
    )


def export_experiment(
    export: Export,
    *,
    where: str,
    counts_per_meter: float,
    encoder: int,
    name: str,
    added_mass: float,
    spring: str,
    damper: str,
    base: str,
    input: InputValues | None,
    input_before: float,
    input_between: InputBetween = "held",
    starts: Starts = "auto",
    sample_time: float | None,
    effort_scale: float | None,
) -> Experiment:
    """Make an experiment of a parsed export; see `read_ecp`."""
    numbers = {"counts_per_meter": counts_per_meter, "input_before": input_before}
    check_numbers(where, **numbers, sample_time=sample_time, effort_scale=effort_scale)
    taken(where, "counts_per_meter", counts_per_meter, a_number("counts a meter of travel, with their sign"))
    if counts_per_meter == 0 or effort_scale == 0:
        raise InputError(f"{where}: counts_per_meter or effort_scale is zero", "Give the scale, with its sign.")
    if len(export.lines) < FEWEST:
        raise InputError(
            f"{where}: holds {len(export.lines)} rows; a record needs at least {FEWEST}", "Export the whole record."
        )
    counts = _whole(export, _encoder(export, encoder, where), where)
    _check_open_loop(export, where)
    time = real_stamps(export) if export.tabbed and sample_time is None else None
    if time is None:
        time = rebuild_time(
            _sample(export, where),
            export.get(TIME),
            resolution=export.time_resolution,
            sample_time=sample_time,
            lines=export.lines,
            where=where,
        )
    volts = _volts(export, input, time, effort_scale, input_before, where)
    with np.errstate(all="ignore"):  # an overflow is reported by the model: not finite
        position = counts / float(counts_per_meter) + 0.0  # + 0.0 turns -0 into 0
    with naming(where):
        return Experiment(
            name=name,
            time=time,
            position=position,
            input=volts,
            added_mass=added_mass,
            spring=spring,
            damper=damper,
            counts_per_meter=float(counts_per_meter),
            input_before=input_before,
            input_between=input_between,
            starts=starts,
            base=base,
        )


def _encoder(export: Export, encoder: object, where: str) -> str:
    there = [name for name in export.columns if is_encoder(name)]
    listed = ", ".join(there) or "none"
    if isinstance(encoder, bool) or not isinstance(encoder, Integral) or not 1 <= int(encoder) < 10**9:
        raise InputError(
            f"{where}: encoder is {described(encoder)}", f"Give the number of an encoder; the file has {listed}."
        )
    column = encoder_column(int(encoder))
    if column not in export:
        raise InputError(f"{where}: has no column {column!r}", f"Choose encoder=…; the file has {listed}.")
    return column


def _whole(export: Export, column: str, where: str) -> Array:
    values = export[column]
    broken = np.flatnonzero(values != np.rint(values))
    if broken.size:
        raise InputError(
            f"{where}, line {export.lines[broken[0]]}, column {column!r}: {values[broken[0]]:g} is not whole counts",
            "Export the position in counts; other units are for read_table.",
        )
    return values


def _sample(export: Export, where: str) -> Array:
    if SAMPLE not in export:
        if TIME not in export:
            raise InputError(f"{where}: has neither a Sample nor a Time column", "State the columns with columns=(…).")
        return np.arange(len(export.lines), dtype=np.float64)  # Time then has to show that no row is missing
    sample = _whole(export, SAMPLE, where)
    jump = np.flatnonzero(np.diff(sample) != 1)
    if jump.size:
        row = int(jump[0])
        raise InputError(
            f"{where}, line {export.lines[row + 1]}, column {SAMPLE!r}: "
            f"{sample[row + 1]:.0f} follows {sample[row]:.0f}",
            "Samples are missing or doubled; export the whole record again.",
        )
    return sample


def _check_open_loop(export: Export, where: str) -> None:
    """Refuse a closed-loop move: a set-point in Commanded Pos, and an effort that answers it without end."""
    if COMMANDED not in export:
        return
    commanded = export[COMMANDED]
    setpoint = np.unique(commanded).size <= MANY
    if encoder_column(1) in export:
        moves = np.unique(export[encoder_column(1)]).size > MANY
        apart = not repeats(commanded, export[encoder_column(1)])
    else:  # Commanded Pos repeats encoder 1 in open loop, so another encoder tells nothing
        moves, apart = True, setpoint
    if EFFORT in export:
        closed = apart and np.unique(export[EFFORT]).size > MANY
    else:
        closed = apart and moves and setpoint and encoder_column(1) in export and bool(np.any(commanded))
    if closed:
        raise InputError(
            f"{where}: is a closed-loop move: Commanded Pos is a set-point (from {commanded.min():.0f} to "
            f"{commanded.max():.0f}) that the encoder does not repeat, and no step of the input",
            "Record an open-loop step. If it was one, call that column something else with columns=(…).",
        )


def _volts(
    export: Export, given: InputValues | None, time: Array, scale: float | None, before: float, where: str
) -> Array:
    values = None if given is None else sample_input(given, time, before=before, where=where)
    if EFFORT not in export:
        if values is None:
            raise InputError(
                f"{where}: has no Control Effort column, so nothing in it says what the input was",
                "Give it with input=StepInput(level=0.5, start=0.0), in V and s, or as an array.",
            )
        return values
    effort = export[EFFORT]
    if scale is None:
        _check_unit(export, where)
        scale = VOLTS_PER_DAC_UNIT if export.tabbed else 1.0
    with np.errstate(all="ignore"):
        volts = effort * float(scale)
    if values is not None and (off := np.flatnonzero(values != volts)).size:
        what = "the StepInput" if isinstance(given, StepInput) else "the array"
        raise InputError(
            f"{where}, line {export.lines[off[0]]}: {what} given as input says {values[off[0]]:g} V, "
            f"the Control Effort column {volts[off[0]]:g} V",
            "Leave input out where the file has the column.",
        )
    return volts + 0.0


def _check_unit(export: Export, where: str) -> None:
    largest = float(np.abs(export[EFFORT]).max())
    if export.tabbed and 0 < largest < FULL_SCALE:
        raise InputError(
            f"{where}: is tab-separated as the newer program writes it, in DAC units, but its Control Effort stays "
            f"below {largest:g} as volts would",
            "State the unit with effort_scale, in V: 1 for volts, 5 / 4095 for DAC units.",
        )
    if not export.tabbed and largest > FULL_SCALE:
        raise InputError(
            f"{where}: Control Effort reaches {largest:g}, too much for volts",
            "State the unit with effort_scale, in V: 1 for volts, 5 / 4095 for DAC units.",
        )
