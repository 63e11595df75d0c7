"""What is said of a run's fault."""

from __future__ import annotations

from stepid.core.words import length
from stepid.fitting.levenberg_marquardt import Optimum

DRIFT = "sensor_drift"
ROUND = (-1.0, 2.0, 0.5, -2.0, -0.5, 4.0, 0.25, 10.0, 0.1, 100.0, 0.01, 1000.0, 0.001, 2.54, 1 / 2.54)
"""Factors that a wrong scale has."""
UNITS = {"added_mass": "kg", "stiffness": "N/m", "damping": "N·s/m", "gain": "", "start_time": "s", DRIFT: "m/s"}
_NEAR = 0.03  # relative, to a round factor
_TURNED = 0.15  # the same for a turned sign: by a plant that lacks a law it is a little more or less than that
_SAME = 0.1  # relative, to another label's stiffness or damping


def fault_words(
    optimum: Optimum, run: int, kind: str, size: float, rivals: tuple[str, ...], *, agree: bool = True
) -> str:
    """Say which run disagrees, and what would explain it; `size` as a deviation.

    Parameters
    ----------
    optimum : Optimum
        The fit with the fault.
    run : int
        Index of the run.
    kind : str
    size : float
        The deviation, in its unit; m/s for a drift.
    rivals : tuple of str
        Runs that may as well be the wrong one.
    agree : bool
        Whether the fit leaves only noise in the others.
    """
    name = optimum.problem.records.runs[run].name
    if rivals:
        names = " or ".join(repr(n) for n in (name, *rivals))
        return f"One run disagrees with the others, {names}; without it the others agree. Record them again."
    others = "which agree among themselves" if agree else "and far more than these do among themselves"
    return f"Run {name!r} disagrees with the others, {others}. {_explanation(optimum, run, kind, size)}"


def _explanation(optimum: Optimum, run: int, kind: str, size: float) -> str:
    records = optimum.problem.records
    if kind == "added_mass":
        told = float(records.added_mass[run])
        true = max(told + size, 0.0)
        return f"With {true:.4g} kg added instead of {told:g} kg it agrees: a wrong added mass. Weigh it again."
    if kind in ("stiffness", "damping"):
        return _label(optimum, run, kind, size)
    if kind == "gain":
        return _factor(1.0 + size)
    if kind == "start_time":
        late = size / float(records.sample_time[run])
        way = "after" if late > 0 else "before"
        return f"Its readings come {abs(late):.2g} samples {way} its input: check how the two were put together."
    return f"With its zero drifting by {length(size)}/s it agrees."


def _label(optimum: Optimum, run: int, kind: str, size: float) -> str:
    """A wrong spring or damper, and whether another one of the campaign fits."""
    of, records = optimum.problem.layout, optimum.problem.records
    what, unit, place, labels, own = (
        ("spring", "N/m", of.stiffness, records.springs, records.spring[run])
        if kind == "stiffness"
        else ("damper", "N·s/m", of.damping, records.dampers, records.damper[run])
    )
    values = optimum.shared[place]
    told = float(values[own])
    found = told * (1.0 + size)
    near = [n for i, n in enumerate(labels) if i != own and abs(values[i] - found) < _SAME * abs(found)]
    like = f", that of {what} {near[0]!r}" if near else ""
    check = "Check which spring was in." if what == "spring" else "Check its setting."
    return (
        f"With a {kind} of {found:.4g} {unit}{like} instead of the {told:.4g} {unit} of {what} {labels[own]!r} "
        f"it agrees: a wrong {what} label. {check}"
    )


def _factor(factor: float) -> str:
    near = min(ROUND, key=lambda r: abs(factor / r - 1))
    off = abs(factor / near - 1)
    if off > (_TURNED if near == -1.0 else _NEAR):
        return f"Its readings, or its input, are {factor:.3g} times what the others ask for: check scale and amplifier."
    if near == -1.0:
        return "With its sign turned it agrees: check the sign of its counts_per_meter, or of its input."
    return f"Its readings are {near:.4g} times what the others ask for: check its counts_per_meter."
