"""Records that are the same, sample for sample, which no two measurements are."""

from __future__ import annotations

from collections.abc import Iterable

from stepid.core.experiment import Experiment


def copies(runs: Iterable[Experiment]) -> dict[str, str]:
    """Find runs that hold the record of another: all but the first of equal labels, all of different labels.

    Parameters
    ----------
    runs : iterable of Experiment

    Returns
    -------
    dict
        Name of a run that is to be left out to the reason, in words.
    """
    groups: dict[bytes, list[Experiment]] = {}
    for run in runs:
        groups.setdefault(run.position.tobytes(), []).append(run)
    left_out: dict[str, str] = {}
    for first, *others in groups.values():
        if not others:
            continue
        names = ", ".join(repr(run.name) for run in (first, *others))
        if all(conditions(run) == conditions(first) for run in others):
            why = f"Runs {names} hold the same record, sample for sample: copies, no repeats; one of them is used."
            left_out |= {run.name: why for run in others}
        else:
            why = (
                f"Runs {names} hold the same record under different labels: at most one of them is what it says, "
                "and they are left out. Check their files."
            )
            left_out |= {run.name: why for run in (first, *others)}
    return left_out


def conditions(run: Experiment) -> tuple[object, ...]:
    """What repeated runs have in common: labels, added mass, clock and input."""
    known = (run.added_mass, run.spring, run.damper, run.base, run.input_before, run.sample_time, run.input_between)
    return (*known, run.input.tobytes())
