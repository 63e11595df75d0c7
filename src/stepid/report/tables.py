"""The tables of a report beside those of the diagnosis' summary."""

from __future__ import annotations

import numpy as np

from stepid.core.estimate import format_value
from stepid.core.experiment import Experiment
from stepid.core.words import digits
from stepid.diagnosis.result import Diagnosis
from stepid.identification.parameters import IdentifiedParameters, StackedSystem, shared_rows
from stepid.identification.transfer.verification import Verification
from stepid.report.chapter import Table


def runs_table(diagnosis: Diagnosis) -> Table:
    """What was recorded."""
    if diagnosis.data is None:
        rows = [(run.name, str(run.time.size), _milliseconds(run.time[1] - run.time[0])) for run in diagnosis.runs]
        return Table(caption="The runs", header=("run", "samples", "sample time [ms]"), rows=tuple(rows))
    header = ("run", "added mass [kg]", "spring", "damper", "base", "input [V]", "samples", "sample time [ms]")
    return Table(
        caption="The runs", header=header, rows=tuple(map(_run, diagnosis.data.experiments)), words=(2, 3, 4, 5)
    )


def _run(run: Experiment) -> tuple[str, ...]:
    return (
        run.name,
        f"{run.added_mass:g}",
        run.spring,
        run.damper,
        run.base,
        _levels(run),
        str(run.time.size),
        _milliseconds(run.sample_time),
    )


def _levels(run: Experiment) -> str:
    """The input as it steps: ``"0 → 0.5 → 0"``."""
    if run.is_release:
        return "none (release)"
    changes = run.input[np.flatnonzero(np.diff(run.input)) + 1]
    levels = [run.input_before, *([run.input[0]] if run.input[0] != run.input_before else []), *changes]
    joined = {"held": "", "lines": ", joined by lines", "smooth": ", smooth"}[run.input_between]
    if len(levels) > 6:
        return f"{run.input.min():.3g} … {run.input.max():.3g}{joined}"
    return " → ".join(f"{level:.3g}" for level in levels) + joined


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.3f}"


def characteristics_table(system: StackedSystem) -> Table:
    """What was read from each record."""
    rows = []
    for run in system.characteristics:
        u = run.uncertainty
        rows.append(
            (
                run.name,
                "–" if run.peak_time is None else format_value(run.peak_time, u.peak_time),
                "–" if run.overshoot is None else format_value(100 * run.overshoot, 100 * (u.overshoot or 0.0)),
                format_value(run.damping_ratio, u.damping_ratio),
                format_value(run.damped_frequency, u.damped_frequency),
                "–" if run.static_gain is None else format_value(run.static_gain, u.static_gain),
            )
        )
    header = ("run", "peak time [s]", "overshoot [%]", "damping ratio", "ω_d [rad/s]", "static gain [m/V]")
    return Table(caption="Read from each record (Eqs. 7 and 8)", header=header, rows=tuple(rows))


def system_table(system: StackedSystem, found: IdentifiedParameters) -> Table:
    """Eq. 10 with its solution below."""
    rows = [
        (label, *(_plain(value) for value in row), _plain(right), unit)
        for label, row, right, unit in zip(system.row_labels, system.matrix, system.rhs, system.row_units, strict=True)
    ]
    springs = dict.fromkeys(run.spring for run in system.characteristics)
    unknowns = [f"{found.masses[run.name]:.5g} kg" for run in system.characteristics]
    unknowns += [f"{found.stiffness[s]:.5g} N/m" for s in springs]
    rows.append(("solution", *unknowns, "", ""))
    return Table(
        caption=f"Stacked system (Eq. 10, corrected), matrix · unknowns = rhs: {len(rows) - 1} rows, "
        f"{len(unknowns)} unknowns; masses in kg, stiffnesses in N/m",
        header=("row", *system.column_labels, "= rhs", "unit"),
        rows=tuple(rows),
        words=(len(unknowns) + 2,),
    )


def _plain(value: float) -> str:
    return f"{value:.5g}".replace("-", "−")


def found_tables(found: IdentifiedParameters) -> tuple[Table, ...]:
    """The solution with its uncertainties: by run, what the runs share, what was left out."""
    u = found.uncertainty
    rows = [
        (name, format_value(mass, u.masses.get(name)), format_value(found.damping[name], u.damping.get(name)))
        for name, mass in found.masses.items()
    ]
    shared = tuple(shared_rows(found))
    tables = [
        Table(caption="By run", header=("run", "mass [kg]", "damping [N·s/m]"), rows=tuple(rows)),
        Table(caption="What runs share", header=("parameter", "value", "unit"), rows=shared, words=(2,)),
    ]
    if found.excluded:
        left_out = tuple(found.excluded.items())
        tables.append(Table(caption="Left out by the peak method", header=("run", "why"), rows=left_out, words=(1,)))
    return tuple(tables)


def verification_table(verified: Verification) -> Table:
    """How well the identified models meet the records."""

    def micro(value: float | None) -> str:
        return "–" if value is None else digits(1e6 * value)

    rows = [
        (run.name, f"{run.fit_percent:.1f}", *map(micro, (run.rms, run.rms_before_peak, run.rms_after_peak)))
        for run in verified.runs
    ]
    header = ("run", "fit [%]", "RMS [µm]", "before the peak [µm]", "after the peak [µm]")
    return Table(caption="Measured against simulated", header=header, rows=tuple(rows))


def phase_table(diagnosis: Diagnosis) -> Table:
    """RMS of the linear joint fit's residual, by phase and run."""
    phases = tuple(diagnosis.where.phases)
    rows = [("all runs", *(digits(1e6 * rms) for rms in diagnosis.where.phases.values()))]
    rows += [
        (run.name, *(digits(1e6 * run.phases[name]) if name in run.phases else "–" for name in phases))
        for run in diagnosis.runs
    ]
    return Table(
        caption="What the linear joint fit leaves, RMS",
        header=("run", *(f"{name} [µm]" for name in phases)),
        rows=tuple(rows),
    )
