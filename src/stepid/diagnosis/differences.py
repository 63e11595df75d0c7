"""What runs differ by that are repeats by their labels: a result of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stepid.core.base import Finite, Model, NonNegative
from stepid.core.words import length
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.wording import whole_percent
from stepid.fitting.deviations import SCATTER, applies, scatter_values
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.random_effects import deviation_std
from stepid.simulation.layout import DEVIATIONS, STARTS

_UNITS = {q.name: q.unit for q in (*DEVIATIONS, *STARTS)} | {"rest": "m"}
_NOTABLE = 3.0  # times the standard error of a rest position, that its scatter must be to be told
_TOLD = 0.01  # of the misfit's power: less is 0 %
_WORDS = {
    "start_time": "The runs start within ±{0:.3g} ms of one another (standard deviation)",
    "gain": "The gain differs from run to run by {1:.2g} % (standard deviation)",
    "damping": "The damping differs from run to run by {1:.2g} % (standard deviation)",
    "friction": "The friction differs from run to run by {1:.2g} % (standard deviation)",
    "start_offset": "The runs start off their rest position by {2} (standard deviation)",
    "start_velocity": "The runs start with a speed of {2}/s (standard deviation)",
}


class Scatter(Model):
    """One condition that differs from run to run.

    Parameters
    ----------
    deviation : float
        Standard deviation over the runs, in `unit`; of gain, damping and friction relative.
    unit : str
        ``"s"``, ``"m"``, ``"m/s"`` or ``""``.
    explained : float
        Part of the misfit's power that it explains, between 0 and 1.
    """

    deviation: NonNegative
    unit: str
    explained: Finite


def scatter_of(
    context: FitContext, found: Candidate, candidates: Sequence[Candidate], shown: Optimum, law: str = ""
) -> dict[str, Scatter]:
    """Say by what the runs differ under a candidate: for each condition its standard deviation, and what it explains.

    No condition is told that takes nothing, or of which all runs have as much as may scatter: that is a law or a fault.

    Parameters
    ----------
    context : FitContext
    found : Candidate
    candidates : sequence of Candidate
        Others, fitted with fewer conditions free.
    shown : Optimum
        The fit whose rest positions are told: where nothing is named the linear plant's, and not a candidate's that
        shifts them at will.
    law : str
        A condition that goes with another one, which is no scatter.
    """
    optimum = found.optimum
    values = scatter_values(optimum) | {"rest": scatter_values(shown)["rest"]}
    told = {kind: v for kind, v in values.items() if kind == "rest" or kind in found.deviations}
    spread = deviation_std(told, context.records.damper)
    samples = np.add.reduceat(context.records.weight**2, context.records.first)
    out = {}
    for kind in sorted(found.deviations & spread.keys()):  # runs that are held at rest differ in no start
        if kind == law or _at_most(optimum, kind):
            continue
        without = _without(context, found, kind, spread[kind], candidates)
        share = 1.0 - optimum.cost / without if without > 0 else 0.0
        if share >= _TOLD:
            out[kind] = Scatter(deviation=spread[kind], unit=_UNITS[kind], explained=share)
    rest = 0.0 if context.records.one_recording else spread.get("rest", 0.0)  # it has one, which a law may shift
    if rest > _NOTABLE * shown.rms / np.sqrt(samples.min()) and rest > context.floor:
        moved = float(np.sum(samples * (values["rest"] - np.average(values["rest"], weights=samples)) ** 2))
        out["rest"] = Scatter(deviation=rest, unit="m", explained=moved / (moved + shown.cost))
    return out


def _at_most(optimum: Optimum, kind: str) -> bool:
    """Tell whether all runs that may differ do as far as `stepid.fitting.deviations.with_deviations` lets them."""
    problem, row = optimum.problem, optimum.problem.layout.deviation(kind)
    free = problem.active[row]
    if problem.most is None or not free.any():
        return False
    return bool(np.isclose(np.abs(optimum.local[row]), problem.most[row])[free].all())


def _without(context: FitContext, found: Candidate, kind: str, spread: float, candidates: Sequence[Candidate]) -> float:
    """Cost [m²] that is left where one condition is the same in all runs: what they share is no difference."""
    problem = found.optimum.problem
    row = problem.layout.deviation(kind)
    free = problem.active[row]
    drawn = kind in SCATTER and free[applies(problem, kind)].all()  # else zero is what all share
    shared = float(found.optimum.local[row, free].mean()) if drawn and free.any() else 0.0
    if abs(shared) <= spread:
        known = [c for c in candidates if c.key == (found.key[0], found.deviations - {kind})]
        if known:
            return known[0].optimum.cost
        shared = 0.0
    active = problem.active.copy()
    active[row] = False
    local = np.where(active, found.optimum.local, 0.0)
    local[row] = np.where(free, shared, 0.0)
    fitted = minimize(
        replace(problem, active=active), found.optimum.shared, local, tolerance=context.tolerance, iterations=12
    )
    return found.optimum.cost if fitted is None else fitted.cost


def scatter_words(scatter: dict[str, Scatter], effects: str = "", *, rest: bool = False) -> tuple[str, ...]:
    """The same in sentences; beside a `rest` that nothing explains, what differs may be part of that.

    Beside `effects` the share is one of what they leave.
    """
    whole = f"what {effects} would leave" if effects else "the misfit's power"
    out = []
    for kind, s in scatter.items():
        if kind == "rest":  # every model has one for each run: it is no misfit
            out.append(f"The rest position differs from run to run by {length(s.deviation)} (standard deviation).")
            continue
        said = _WORDS[kind].format(1e3 * s.deviation, 1e2 * s.deviation, length(s.deviation))
        out.append(f"{said}: {whole_percent(s.explained)} of {whole}.")
    if rest and scatter:
        out.append("What seems to differ between the runs may be part of what is missing.")
    return tuple(out)
