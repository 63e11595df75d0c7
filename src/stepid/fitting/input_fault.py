"""An input that plainly does something else between its samples than the records say: held, joined by lines, smooth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.samples import WAYS, InputBetween
from stepid.effects import resolve
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import block_mean_deviate
from stepid.fitting.problem import build
from stepid.simulation.records import Records

_JUMPS = 3  # largest changes, that may be steps: a line from one to the next sample is but a delay by half a sample
_MANY = 12.0  # samples at which the input must change beside these
_IN_A_ROW = 0.3  # correlation of the sizes of successive changes: where single steps are far apart there is none
_FAR = 0.2  # of the input's range, that it covers without the jumps: what it does is no noise on steps
_EVIDENCE = 50.0  # by which the other reading of the input must explain better, n ln(cost / cost)
_WHITE = 2.5  # standard deviations of structure that it may leave
_LEFT = 0.05  # or share of the structure, where more is missing beside it
_TIE = 10.0  # evidence that does not decide
_RIVALS = ("input_delay", "actuator_lag")  # by half a sample they are near to a line
_SAID = {
    "held": "held from each sample to the next",
    "lines": "joined by straight lines between the samples",
    "smooth": "a smooth curve through the samples",
}


@dataclass(frozen=True)
class InputFault:
    """Runs whose input does `way` between the samples, and not what they say; `evidence` of that, n ln(cost / cost)."""

    runs: tuple[str, ...]
    all_runs: bool
    way: InputBetween
    said: tuple[InputBetween, ...]
    evidence: float

    @property
    def remedy(self) -> str:
        """What to set."""
        which = "every run" if self.all_runs else "these runs"
        return f'Set input_between="{self.way}" for {which}, and diagnose again.'

    @property
    def words(self) -> str:
        """Say whose input it is, and what it plainly does."""
        many = len(self.runs) > 1
        names = ", ".join(map(repr, self.runs))
        said = " or ".join(repr(way) for way in self.said)
        return (
            f"The input of run{'s' if many else ''} {names} is plainly {_SAID[self.way]}, while the record{'s' * many} "
            f"say{'s' * (not many)} {said}: set input_between={self.way!r}."
        )


def changes_throughout(run: Experiment) -> bool:
    """Tell whether an input changes at many samples in a row, so that it matters what it does between them."""
    change = np.diff(run.input, prepend=run.input_before)
    change[np.argsort(np.abs(change))[-_JUMPS:]] = 0.0
    power = float(np.sum(change**2))
    if power == 0.0:
        return False
    many = power**2 / float(np.sum(change**4))
    in_a_row = float(np.sum(np.abs(change[1:] * change[:-1]))) / power
    covered = float(np.ptp(np.cumsum(change))) / float(np.ptp(np.append(run.input, run.input_before)))
    return many > _MANY and in_a_row > _IN_A_ROW and covered > _FAR


def find_input_fault(context: FitContext) -> InputFault | None:
    """Find runs whose input the linear plant asks to be read in another way than their records say.

    Parameters
    ----------
    context : FitContext

    Returns
    -------
    InputFault or None
        None where the records are right, or the data cannot tell.
    """
    records = context.records
    throughout = [i for i, run in enumerate(records.runs) if changes_throughout(run)]
    found: list[tuple[Optimum, InputFault]] = []
    for way in WAYS:
        runs = [i for i in throughout if records.runs[i].input_between != way]
        fit = _read(context, way, runs) if runs else None
        if fit is not None and _plain(context, fit):
            found.append((fit, _fault(records, runs, way, _gain(context.linear, fit))))
    if not found:
        return None
    most = max(fault.evidence for _, fault in found)
    # where two ways are as good, the plainer one: lines before a spline
    fit, fault = next(item for item in found if item[1].evidence > most - _TIE)
    rivals = (_with_effect(context, *resolve([name])) for name in _RIVALS)
    if any(rival is not None and _gain(fit, rival) > _TIE for rival in rivals):
        return None
    return fault


def _fault(records: Records, runs: Sequence[int], way: InputBetween, evidence: float) -> InputFault:
    chosen = [records.runs[i] for i in runs]
    said = tuple(dict.fromkeys(run.input_between for run in chosen))
    return InputFault(tuple(run.name for run in chosen), len(runs) == len(records.runs), way, said, evidence)


def _read(context: FitContext, way: InputBetween, runs: Sequence[int]) -> Optimum | None:
    """Fit the linear plant with the input of some runs read in another way."""
    linear = context.linear
    problem = build(context.records.with_input_between(way, runs), ())
    problem = replace(problem, free=linear.problem.free, active=linear.problem.active)
    return minimize(problem, linear.shared, linear.local, tolerance=context.tolerance)


def _with_effect(context: FitContext, effect: Effect) -> Optimum | None:
    """Fit the linear plant with an effect of half a sample, the input as the records say."""
    problem = build(context.records, (effect,))
    local = np.zeros((problem.layout.n_run, len(context.records.runs)))
    local[:2] = context.linear.local[:2]
    local[problem.layout.deviations] = context.linear.local[context.linear.problem.layout.deviations]
    shared = np.append(context.linear.shared, 0.5 * float(context.records.sample_time.mean()))
    return minimize(problem, shared, local, tolerance=context.tolerance)


def _gain(one: Optimum, two: Optimum) -> float:
    """Evidence for the second of two fits, whatever the size of the noise."""
    samples = one.problem.records.weighed_size
    return samples * float(np.log(max(one.cost, 1e-300) / max(two.cost, 1e-300)))


def _plain(context: FitContext, fit: Optimum) -> bool:
    """Tell whether another reading of the input explains much better, and leaves next to nothing to explain."""
    if _gain(context.linear, fit) < _EVIDENCE:
        return False
    level = float(np.sqrt(fit.cost / fit.problem.records.weighed_size))

    def left(residual: Array) -> float:
        return block_mean_deviate(context.records, residual, max(level, 1e-12), context.period)

    linear = context.linear
    here, there = (left(o.problem.residual(o.solved)) for o in (linear, fit))
    return there < max(_WHITE, _LEFT * here)
