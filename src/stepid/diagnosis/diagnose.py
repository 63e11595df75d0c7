"""The whole diagnosis of a campaign: five questions in order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import NamedTuple

from stepid.core.arguments import as_campaign, as_workers
from stepid.core.experiment import Campaign, Experiment
from stepid.core.quantities import in_own_quantities, spoken_now
from stepid.core.recorded import recorded
from stepid.core.takes import a, able, each, optional, takes
from stepid.core.words import length
from stepid.diagnosis.answer import each_once, report
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.explore import Found, explored, linear_candidate
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.odd_run import fault_of, outlying_runs, stands_out
from stepid.diagnosis.plain_faults import eccentricity_of, fault_beside_effects, fault_beside_the_plant, swap_of
from stepid.diagnosis.progress import Progress, Tell, listener, telling
from stepid.diagnosis.result import Diagnosis
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.verdict import judge
from stepid.effects import CATALOGUE, Effect, a_catalogue, among_themselves
from stepid.errors import UndeterminedError
from stepid.fitting.eccentricity import without_eccentricity
from stepid.fitting.fit import prepare
from stepid.fitting.input_fault import find_input_fault
from stepid.fitting.multistart import FitContext
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.screening import split_campaign
from stepid.fitting.swapped_weights import doubt, swap_faults, without_swap
from stepid.simulation.threads import single_threaded
from stepid.simulation.warm_up import warm_up

_OUTLYING = 2  # runs that are left out in turn

_how = {
    "catalogue": a_catalogue,
    "criteria": optional(a(Criteria, "stepid.Criteria(…)")),
    "effort": optional(a(Effort, "stepid.Effort(), Effort.quick() or Effort.thorough()")),
    "progress": listener,
}


@in_own_quantities
@takes(**_how)
@recorded(criteria=Criteria, effort=Effort)
@single_threaded
def diagnose(
    campaign: Campaign,
    *,
    catalogue: tuple[Effect, ...] = CATALOGUE,
    criteria: Criteria | None = None,
    effort: Effort | None = None,
    progress: Tell | bool | None = None,
    workers: int = 1,
) -> Diagnosis:
    """Say whether a linear model is adequate for a campaign and, if not, which effect it is missing.

    Parameters
    ----------
    campaign : Campaign
        Two runs or more.
    catalogue : tuple of Effect
        Candidates; add your own to `stepid.effects.CATALOGUE`. Of two with one name the last counts.
    criteria : Criteria, optional
        What decides the answer.
    effort : Effort, optional
        How hard to search: ``Effort.quick()``, ``Effort()``, ``Effort.thorough()``.
    progress : callable or False, optional
        Called with a `Progress` before each stage: a few words, the best answer so far, what is done and left. An
        exception that it raises cancels the diagnosis. By default a notebook shows a bar, and a script nothing; False
        is silent there, too, as is the environment variable ``STEPID_PROGRESS=0``.
    workers : int
        Threads that simulate; the answer is the same for any number.

    Returns
    -------
    Diagnosis

    Raises
    ------
    stepid.errors.UndeterminedError
        If the campaign has one run only, or too few usable runs or samples.
    stepid.errors.InputError
        If nothing moves in any run; one in which nothing moves is left out, and that is noted.
    stepid.errors.ConvergenceError
        If not even a linear plant can be fitted.
    """
    campaign, splits = split_campaign(as_campaign(campaign))
    if len(campaign.experiments) < 2:
        raise UndeterminedError(
            f"campaign {campaign.name!r} has one run: a model that fits it cannot be checked on another",
            "Add a run with another added mass, or repeat this one. A long record can be cut: campaign.in_parts(3), "
            "or --parts 3.",
        )
    with telling(progress) as tell:
        how = _How(among_themselves(catalogue), criteria or Criteria(), effort or Effort(), tell, as_workers(workers))
        done = _prepared(campaign, how)
    return done.model_copy(update={"notes": (*splits, *done.notes)}) if splits else done


class _How(NamedTuple):
    catalogue: tuple[Effect, ...]
    criteria: Criteria
    effort: Effort
    tell: Tell
    workers: int


def _prepared(campaign: Campaign, how: _How) -> Diagnosis:
    """Fit the linear plant, and diagnose what it leaves."""
    warm_up(lambda words: how.tell(Progress(words)))
    how.tell(Progress("linear fit"))
    context = prepare(campaign, workers=how.workers)
    if len(context.records.runs) < 2:
        raise UndeterminedError(
            f"campaign {campaign.name!r} has one usable run. {' '.join(context.notes)}",
            "Record the others again: a model that fits one run cannot be checked on another.",
        )
    left = f"linear model leaves {length(context.linear.rms)}, noise {length(context.floor)}"
    how.tell(Progress(spoken_now().text(left)))
    return _diagnosed(campaign, context, how)


def _diagnosed(
    campaign: Campaign,
    context: FitContext,
    how: _How,
    accused: tuple[RecordFault, ...] = (),
    searched: Found | None = None,
) -> Diagnosis:
    """Diagnose what was laid out; a run that is plainly at fault is left out, and the rest diagnosed anew.

    What was `searched` before is not searched again.
    """
    wrong_input = find_input_fault(context)
    doubts: tuple[str, ...] = ()
    if wrong_input is not None:
        found = Found(context, (linear_candidate(context),))
    else:
        found = searched or _explored(context, how)
        swap = swap_of(found, how.criteria)
        doubts = (doubt(swap),) if swap is not None and swap.doubtful else ()
        if swap is not None and not doubts:
            exchanged = campaign.model_copy(update={"experiments": without_swap(campaign.experiments, swap)})
            return _diagnosed(exchanged, prepare(exchanged, workers=how.workers), how, (*accused, *swap_faults(swap)))
        alone = fault_beside_the_plant(found, how.criteria)
        fault = alone or fault_beside_effects(found, how.criteria)
        if fault is not None:
            others = [run for run in _usable(campaign, context) if run.name != fault.run]
            done = _anew(campaign, others, how, (*accused, _left_out(fault)))
            if alone or done.verdict != "unexplained":  # else what it was accused beside explains nothing
                return _noting(done, (*context.notes, *doubts))
        without = _without_an_odd_run(campaign, found, how, accused)
        if without is not None:
            return _noting(without, (*context.notes, *doubts))
    how.tell(Progress("runs held out", best=found.best.names))
    faults = (*accused, *found.context.faults)
    eccentric = None if wrong_input is not None else eccentricity_of(found, how.criteria, accused)
    if eccentric is not None:
        corrected = without_eccentricity(campaign, eccentric).experiments
        done = _anew(campaign, corrected, how, (*accused, _and(eccentric.fault, "It is subtracted.")))
        if done.effects or done.verdict == "adequate":
            return _noting(done, doubts)
        faults += (eccentric.fault,)
    evidence = EvidenceRecord(found.context, how.criteria, found.candidates, wrong_input, faults)
    return _noting(report(campaign, evidence, judge(evidence)), doubts)


def _explored(context: FitContext, how: _How) -> Found:
    return explored(context, how.catalogue, how.criteria, how.effort, how.tell)


def _noting(done: Diagnosis, more: tuple[str, ...]) -> Diagnosis:
    return done.model_copy(update={"notes": each_once(*done.notes, *more)}) if more else done


def _anew(campaign: Campaign, runs: Sequence[Experiment], how: _How, accused: tuple[RecordFault, ...]) -> Diagnosis:
    """Diagnose some runs, or corrected ones, in the place of a campaign's."""
    other = campaign.model_copy(update={"experiments": tuple(runs)})
    done = _diagnosed(other, prepare(other, workers=how.workers), how, accused)
    return done.model_copy(update={"data": campaign})


def _without_an_odd_run(
    campaign: Campaign, found: Found, how: _How, accused: tuple[RecordFault, ...]
) -> Diagnosis | None:
    """Diagnose without one run that takes most of the misfit, where that explains all others."""
    context = found.context
    if at_floor(context, how.criteria, found.best) or context.by_weights is not None:
        return None
    for run in outlying_runs(context, [c.optimum for c in found.single])[:_OUTLYING]:
        name = context.records.runs[run].name
        others = tuple(e for e in _usable(campaign, context) if e.name != name)
        rest = campaign.model_copy(update={"experiments": others})
        laid_out = prepare(rest, workers=how.workers)
        fewer = _explored(laid_out, how)
        if not stands_out(context, run, fewer.best):
            continue
        evidence = EvidenceRecord(fewer.context, how.criteria, fewer.candidates)
        answer = judge(evidence)
        if answer.verdict == "unexplained":
            continue
        fault = fault_of(context, run, answer.shown, fewer.context.floor, sure=how.criteria.size)
        if fault is None:
            continue
        done = _diagnosed(rest, laid_out, how, (*accused, _left_out(fault)), fewer)
        if done.verdict != "unexplained":
            return done.model_copy(update={"data": campaign})
    return None


def _usable(campaign: Campaign, context: FitContext) -> list[Experiment]:
    """A campaign's runs but for those that were left out: the copy of a run must not take its place."""
    used = {run.name for run in context.records.runs}
    return [run for run in campaign.experiments if run.name in used]


def _left_out(fault: RecordFault) -> RecordFault:
    return _and(fault, "It is left out of this diagnosis.")


def _and(fault: RecordFault, words: str) -> RecordFault:
    return fault.model_copy(update={"words": f"{fault.words} {words}"})


@takes(
    **_how,
    campaigns=each(as_campaign, "campaigns in a list"),
    executor=optional(able("map", "an executor of concurrent.futures")),
)
def diagnose_many(
    campaigns: Iterable[Campaign],
    *,
    catalogue: tuple[Effect, ...] = CATALOGUE,
    criteria: Criteria | None = None,
    effort: Effort | None = None,
    executor: Executor | None = None,
    progress: Tell | bool | None = None,
) -> list[Diagnosis]:
    """Diagnose many campaigns, side by side where an executor is given.

    Parameters
    ----------
    campaigns : iterable of Campaign
    catalogue : tuple of Effect
    criteria : Criteria, optional
    effort : Effort, optional
    executor : concurrent.futures.Executor, optional
        A process pool uses all cores.
    progress : callable or False, optional
        Called with a `Progress` before each campaign, in their order; as in `diagnose`.

    Returns
    -------
    list of Diagnosis
        In the order of the campaigns.

    Raises
    ------
    stepid.errors.StepidError
        The first error of any campaign, see `diagnose`.
    """
    several = tuple(campaigns)
    one = partial(diagnose, catalogue=catalogue, criteria=criteria, effort=effort, progress=False)
    made = iter(executor.map(one, several) if executor is not None else map(one, several))
    done: list[Diagnosis] = []
    with telling(progress, line=str) as tell:
        for campaign in several:
            tell(Progress(campaign.name, done=len(done), left=len(several) - len(done)))
            done.append(next(made))
    return done
