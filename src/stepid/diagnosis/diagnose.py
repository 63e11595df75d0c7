"""The whole diagnosis of a campaign: five questions in order."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from functools import partial

import numpy as np

from stepid.core.arguments import as_campaign, as_workers
from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.noise import rms
from stepid.diagnosis.experiment_design import next_experiment
from stepid.diagnosis.locate import locate, phases_of
from stepid.diagnosis.notes import notes_on
from stepid.diagnosis.result import Diagnosis, Gap, Ranked, RunGap
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.verdict import Judgment, judge
from stepid.diagnosis.wording import effect_names
from stepid.effects import CATALOGUE, Effect, among_themselves
from stepid.errors import UndeterminedError
from stepid.fitting.covariance import estimates, parameter_names
from stepid.fitting.cross_validation import held_out_residuals
from stepid.fitting.fit import prepare, unpack
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.outlier_run import Suspect
from stepid.fitting.screening import screen
from stepid.simulation.threads import single_threaded
from stepid.simulation.warm_up import warm_up

Progress = Callable[[str], None]


def _silent(_: str) -> None:
    return None


@single_threaded
def diagnose(
    campaign: Campaign,
    *,
    catalogue: tuple[Effect, ...] = CATALOGUE,
    progress: Progress | None = None,
    workers: int = 1,
) -> Diagnosis:
    """Say whether a linear model is adequate for a campaign and, if not, which effect it is missing.

    Parameters
    ----------
    campaign : Campaign
        Two runs or more.
    catalogue : tuple of Effect
        Candidates; add your own to `stepid.effects.CATALOGUE`.
    progress : callable, optional
        Called with a few words before each stage.
    workers : int
        Threads that simulate; the answer is the same for any number.

    Returns
    -------
    Diagnosis

    Raises
    ------
    stepid.errors.UndeterminedError
        If the campaign has one run only.
    stepid.errors.InputError
        If nothing moves in a run.
    stepid.errors.ConvergenceError
        If not even a linear plant can be fitted.
    """
    campaign = as_campaign(campaign)
    tell = progress or _silent
    if len(campaign.experiments) < 2:
        raise UndeterminedError(
            f"campaign {campaign.name!r} has one run: a model that fits it cannot be checked on another",
            "Add a run with another added mass, or repeat this one.",
        )
    warm_up(tell)
    tell("linear fit")
    context = prepare(campaign, workers=as_workers(workers))
    if len(context.records.runs) < 2:
        raise UndeterminedError(
            f"campaign {campaign.name!r} has one usable run. {' '.join(screen(campaign).notes)}",
            "Record the others again: a model that fits one run cannot be checked on another.",
        )
    judgment = judge(context, among_themselves(catalogue), tell)
    if judgment.suspect is not None:
        return _diagnose_without(judgment.suspect, campaign, catalogue, tell, workers)
    tell("runs held out")
    return _report(campaign, context, judgment)


def _diagnose_without(
    suspect: Suspect, campaign: Campaign, catalogue: tuple[Effect, ...], progress: Progress, workers: int
) -> Diagnosis:
    """Leave out a run whose labels or scale are plainly wrong, and say so."""
    rest = tuple(e for e in campaign.experiments if e.name != suspect.run)
    others = campaign.model_copy(update={"experiments": rest})
    found = diagnose(others, catalogue=catalogue, progress=progress, workers=workers)
    notes = (f"{suspect.words} It is left out of this diagnosis.", *found.notes)
    return found.model_copy(update={"notes": notes, "data": campaign})


def _pooled(residuals: dict[int, Array]) -> float | None:
    return rms(np.concatenate(list(residuals.values()))) if residuals else None


def _report(campaign: Campaign, context: FitContext, judgment: Judgment) -> Diagnosis:
    records, floor = context.records, context.floor
    linear = context.linear
    final = judgment.chosen.optimum if judgment.verdict in ("named", "ambiguous") else linear
    chosen = judgment.chosen if final is not linear else None
    effects = chosen.effects if chosen else ()
    seen_before = held_out_residuals(linear, tolerance=context.tolerance)
    seen_after = held_out_residuals(final, tolerance=context.tolerance) if chosen else seen_before
    both = seen_before.keys() & seen_after.keys()
    seen_before = {i: seen_before[i] for i in sorted(both)}
    seen_after = {i: seen_after[i] for i in sorted(both)}
    proposal = None
    if judgment.alternatives:
        words = {id(c.optimum): effect_names(c.names) for c in (judgment.chosen, *judgment.alternatives)}
        proposal = next_experiment(
            campaign,
            judgment.chosen.optimum,
            [c.optimum for c in judgment.alternatives],
            floor=floor,
            tell=lambda o: words[id(o)],
        )
    elif judgment.fault is not None:
        proposal = judgment.fault.remedy
    elif judgment.verdict == "unexplained":
        doubt = f"Look at run {judgment.doubt.run!r} first: {judgment.doubt.words} " if judgment.doubt else ""
        proposal = (
            f"{doubt}Repeat one run without changing anything: what differs between the repeats is no property of "
            "the plant. Then a free release and a step the other way."
        )
    verdict, reasons = judgment.verdict, judgment.reasons
    return Diagnosis(
        campaign=campaign.name,
        verdict=verdict,
        effects=tuple(e.name for e in effects),
        alternatives=tuple(c.names for c in judgment.alternatives),
        gap=Gap(
            before=linear.rms,
            after=final.rms,
            noise=floor,
            held_out_before=_pooled(seen_before),
            held_out_after=_pooled(seen_after),
        ),
        parameters=estimates(final, effects, floor)[0],
        linear_parameters=estimates(linear, (), floor)[0],
        where=locate(records, linear, floor, context.measured),
        next_experiment=proposal,
        advice={e.name: e.advice for e in effects if e.advice},
        reasons=reasons,
        notes=((judgment.fault.words,) if judgment.fault else ()) + notes_on(campaign, context, final, effects),
        ranking=_ranking(judgment),
        runs=_runs(context, final, seen_before, seen_after),
        model=unpack(final, effects),
        linear_model=unpack(linear, ()),
        data=campaign,
    )


def _ranking(judgment: Judgment) -> tuple[Ranked, ...]:
    if not judgment.ranking:
        return ()
    best = judgment.ranking[0].evidence
    return tuple(
        Ranked(effects=c.names, rms=c.optimum.rms, evidence=c.evidence - best, parameters=_own(c))
        for c in judgment.ranking
    )


def _own(found: Candidate) -> dict[str, float]:
    names = [name for name, _ in parameter_names(found.optimum, found.effects)]
    return {n: float(v) for n, v in zip(names, found.optimum.shared, strict=True) if "." in n}


def _runs(
    context: FitContext, final: Optimum, seen_before: dict[int, Array], seen_after: dict[int, Array]
) -> tuple[RunGap, ...]:
    records, linear = context.records, context.linear
    before, after = linear.residual, final.residual
    phases = phases_of(records, linear, context.floor, context.measured)
    out = []
    for i, (run, piece) in enumerate(zip(records.runs, records.pieces(), strict=True)):
        y = records.position[piece]
        out.append(
            RunGap(
                name=run.name,
                time=records.time[piece],
                measured=y,
                linear=y - before[piece],
                model=y - after[piece],
                before=rms(before[piece]),
                after=rms(after[piece]),
                held_out_before=rms(seen_before[i]) if i in seen_before else None,
                held_out_after=rms(seen_after[i]) if i in seen_after else None,
                phases=phases[run.name],
            )
        )
    return tuple(out)


def diagnose_many(
    campaigns: Iterable[Campaign], *, catalogue: tuple[Effect, ...] = CATALOGUE, executor: Executor | None = None
) -> list[Diagnosis]:
    """Diagnose many campaigns, side by side where an executor is given.

    Parameters
    ----------
    campaigns : iterable of Campaign
    catalogue : tuple of Effect
    executor : concurrent.futures.Executor, optional
        A process pool uses all cores.

    Returns
    -------
    list of Diagnosis
        In the order of the campaigns.

    Raises
    ------
    stepid.errors.StepidError
        The first error of any campaign, see `diagnose`.
    """
    one = partial(diagnose, catalogue=catalogue)
    return list(executor.map(one, campaigns) if executor is not None else map(one, campaigns))
