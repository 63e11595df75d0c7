"""From the evidence and the verdict to the result: gaps, parameters, tables, what next."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.noise import rms
from stepid.diagnosis.differences import scatter_of, scatter_words
from stepid.diagnosis.experiment_design import next_experiment
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.locate import locate, phases_of
from stepid.diagnosis.notes import notes_on
from stepid.diagnosis.remainder import NEITHER, UNDRIVEN, remainder
from stepid.diagnosis.result import Diagnosis, Gap, Ranked, RunGap
from stepid.diagnosis.rules_lead import leads
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.shape_in_motion import of_the_linear_plant
from stepid.diagnosis.verdict import Answer
from stepid.diagnosis.wording import effect_names
from stepid.fitting.covariance import effect_parameters, estimates
from stepid.fitting.fit import unpack
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import repeats

_REPEAT = "Repeat {} without changing anything: what differs between the repeats is no property of the plant. "
_BESIDE_STEPS = "Record a free release and a step the other way."
_BESIDE_RELEASES = "Record a release from the other side, and one from half as far."
_WEIGH = "Weigh the added masses, and state their uncertainty (weight_uncertainty): their errors would explain it, too."


def _pooled(residuals: dict[int, Array]) -> float | None:
    return rms(np.concatenate(list(residuals.values()))) if residuals else None


def report(campaign: Campaign, evidence: EvidenceRecord, answer: Answer) -> Diagnosis:
    """Make a diagnosis's result."""
    context = evidence.context
    records, floor, linear = context.records, context.floor, context.linear
    adequate = answer.verdict == "adequate"
    told = answer.shown if answer.verdict != "unexplained" else evidence.linear
    final, effects = told.optimum, told.effects
    before, after = evidence.left_out.residuals(told)
    parameters = estimates(final, effects, floor)[0] | evidence.limited(told)
    differing = _differing(evidence, answer, told)
    law = evidence.systematic(differing)
    scatter = scatter_of(context, differing, evidence.candidates, final, "" if law is None else law.kind)
    beside_a_rest = not adequate and (differing is not answer.shown or not evidence.at_floor(answer.shown))
    pooled = _pooled(before), _pooled(after)
    return Diagnosis(
        campaign=campaign.name,
        verdict=answer.verdict,
        effects=tuple(e.name for e in effects),
        alternatives=tuple(c.names for c in answer.alternatives),
        gap=Gap(before=linear.rms, after=final.rms, noise=floor, held_out_before=pooled[0], held_out_after=pooled[1]),
        parameters=parameters,
        linear_parameters=estimates(linear, (), floor)[0],
        where=locate(
            records,
            linear,
            floor,
            context.measured,
            enough=adequate and evidence.at_floor(evidence.linear),
            otherwise=lambda: of_the_linear_plant(context),
        ),
        next_experiment=_next(evidence, answer),
        advice={e.name: e.advice for e in effects if e.advice},
        reasons=(*answer.reasons, *_rest(evidence, answer)),
        notes=each_once(
            *(fault.words for fault in evidence.faults),
            *((evidence.input_fault.words,) if evidence.input_fault else ()),
            *scatter_words(scatter, effect_names(told.names), rest=beside_a_rest),
            *notes_on(context, final, effects, parameters, evidence.criteria.open),
        ),
        ranking=_ranking(evidence),
        runs=_runs(context, final, before, after),
        model=unpack(final, effects),
        linear_model=unpack(linear, ()),
        explained=_explained(pooled) if evidence.left_out.shows(told) or not effects else None,
        left=_left(context, final),
        probability=evidence.probability(answer),
        scatter=scatter,
        faults=evidence.faults,
        wrong_inputs=evidence.input_fault.runs if evidence.input_fault else (),
        data=campaign,
        criteria=evidence.criteria,
    )


def _differing(evidence: EvidenceRecord, answer: Answer, told: Candidate) -> Candidate:
    """The candidate of which is said by what the runs differ: what is told, or shown, with what differs in it.

    Where nothing is explained and neither has any, the linear plant with conditions that take as much of the misfit as
    a lead has to: an effect that may not be named can hide that.
    """
    for one in (told, answer.shown):
        if one.deviations or answer.verdict != "unexplained":
            return one
    plain = (w.candidate for w in evidence.weighed if w.candidate.deviations and not w.candidate.effects)
    taking = (c for c in plain if evidence.leads.taken(evidence.linear, c) >= evidence.criteria.lead)
    return next(taking, answer.shown)


def _rest(evidence: EvidenceRecord, answer: Answer) -> tuple[str, ...]:
    """Say what shape the rest has, where one remains that no wrong input makes."""
    if evidence.input_fault is not None or evidence.at_floor(answer.shown):
        return ()
    if answer.verdict not in ("named", "unexplained"):
        return ()
    shapes = remainder(evidence.context, answer.shown, evidence.criteria)
    refuted = answer.verdict == "unexplained" and answer.rule == leads.__name__
    return () if refuted and shapes in (NEITHER, UNDRIVEN) else shapes  # a law that does better was told already


def each_once(*notes: str) -> tuple[str, ...]:
    """Notes without those said before: what was left out of a record may also be told as its fault, or by two looks."""
    return tuple(dict.fromkeys(notes))


def _explained(pooled: tuple[float | None, float | None]) -> float | None:
    before, after = pooled
    return None if before is None or after is None or before == 0 else 1.0 - (after / before) ** 2


def _taken(before: Array, after: Array) -> float:
    """Share of a residual's power that is gone, 0 where there was none."""
    power = float(before @ before)
    return 1.0 - float(after @ after) / power if power > 0 else 0.0


def _left(context: FitContext, final: Optimum) -> float:
    """RMS of the residual in per cent of that of the motion about each run's rest."""
    records = context.records
    rest = records.position - final.solved.reading
    motion = records.position - (rest - final.residual)
    size = rms(motion[records.trusted])
    return 100.0 * final.rms / size if size > 0 else 0.0


def _next(evidence: EvidenceRecord, answer: Answer) -> str | None:
    if answer.alternatives:
        words = {id(c.optimum): effect_names(c.names) for c in (answer.shown, *answer.alternatives)}
        return next_experiment(
            answer.shown.optimum,
            [c.optimum for c in answer.alternatives],
            floor=evidence.context.floor,
            tell=lambda o: words[id(o)],
            criteria=evidence.criteria,
        )
    if evidence.input_fault is not None:
        return evidence.input_fault.remedy
    if answer.verdict == "unexplained":
        records = evidence.context.records
        beside = _BESIDE_STEPS if records.driven.any() else _BESIDE_RELEASES
        again = _REPEAT.format("the recording" if records.one_recording else "one run")
        return beside if repeats(records) else again + beside
    return _WEIGH if answer.verdict == "ambiguous" else None


def _ranking(evidence: EvidenceRecord) -> tuple[Ranked, ...]:
    return tuple(
        Ranked(
            effects=w.candidate.names,
            deviations=tuple(sorted(w.candidate.deviations)),
            rms=w.candidate.optimum.rms,
            evidence=w.loss,
            probability=w.weight,
            explained=1.0 - w.candidate.optimum.cost / evidence.linear.optimum.cost,
            parameters=_own(w.candidate),
        )
        for w in evidence.weighed
    )


def _own(found: Candidate) -> dict[str, float]:
    own, of = effect_parameters(found.effects), found.optimum.problem.layout
    return {n: float(v) for n, v in zip(own, found.optimum.shared[of.linear.stop :], strict=True)}


def _runs(
    context: FitContext, final: Optimum, seen_before: dict[int, Array], seen_after: dict[int, Array]
) -> tuple[RunGap, ...]:
    records, linear = context.records, context.linear
    before, after = linear.residual, final.residual
    phases = phases_of(records, linear, context.floor, context.measured)
    out = []
    for i, (run, piece) in enumerate(zip(records.runs, records.pieces(), strict=True)):
        y, trusted = records.position[piece], records.trusted[piece]
        linear_rest, final_rest = before[piece][trusted], after[piece][trusted]
        out.append(
            RunGap(
                name=run.name,
                time=records.time[piece],
                measured=y,
                linear=y - before[piece],
                model=y - after[piece],
                before=rms(linear_rest),
                after=rms(final_rest),
                held_out_before=rms(seen_before[i]) if i in seen_before else None,
                held_out_after=rms(seen_after[i]) if i in seen_after else None,
                phases=phases[run.name],
                explained=_taken(linear_rest, final_rest),
            )
        )
    return tuple(out)
