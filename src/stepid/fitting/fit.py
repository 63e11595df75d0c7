"""Joint fit of a plant with given effects to all records of a campaign at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from stepid.core.arguments import as_campaign, as_workers
from stepid.core.experiment import Campaign
from stepid.core.latex import parameter_name
from stepid.core.noise import rms
from stepid.core.outliers import Mask
from stepid.core.quantities import in_own_quantities
from stepid.core.recorded import recorded
from stepid.core.words import length
from stepid.effects import CATALOGUE, Effect, resolve
from stepid.errors import ConvergenceError, UndeterminedError
from stepid.fitting.covariance import estimates, mass_is_held, most_likely
from stepid.fitting.eccentricity import find_eccentricity
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.fit_result import Fit as Fit
from stepid.fitting.hum import find_hum, without_hum
from stepid.fitting.input_fault import find_input_fault
from stepid.fitting.input_noise import follows, pooled_levels, without_lone_samples
from stepid.fitting.left_over import left_over
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.mean_of_runs import centered
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_color import colored_floor
from stepid.fitting.noise_floor import bounded_floor, enough, noise_floor, repeat_notes, weights
from stepid.fitting.problem import fit_linear, ratios_note, within_weights
from stepid.fitting.profile import profiled
from stepid.fitting.reading_faults import trust
from stepid.fitting.record_fault import ALL_RUNS
from stepid.fitting.run_fault import find_fault
from stepid.fitting.screening import screen
from stepid.simulation.layout import DEVIATIONS, own_state_names
from stepid.simulation.model import EffectModel, PlantModel, RunState
from stepid.simulation.records import Records, lay_out
from stepid.simulation.threads import single_threaded

_MISFIT = 1.1  # times the floor, beyond which a run may be to blame
HELD = (
    "By this model the added masses do not tell the base mass, which is held where what they can tell ends. No mass, "
    "stiffness, damping or force is determined, only their ratios. Something is missing in the model, or the weights "
    "are too light."
)
NOT_CONVERGED = "The fit did not converge; what is shown is the best so far."


def prepare(campaign: Campaign, *, workers: int = 1) -> FitContext:
    """Lay out what can be used of a campaign, weigh it and fit the linear plant; `workers` threads simulate.

    Raises
    ------
    stepid.errors.InputError
        If no run can be used.
    stepid.errors.UndeterminedError
        If the records are too short.
    stepid.errors.ConvergenceError
        If no linear plant can be fitted at all.
    """
    screened = screen(as_campaign(campaign))
    campaign, notes = screened.campaign, screened.notes
    records, linear, floor = _begun(campaign, screened.wrong, workers)
    faults = screened.faults
    for taken in (without_lone_samples, pooled_levels):
        other = taken(campaign)
        if other is None:
            continue
        held = _begun(other.campaign, screened.wrong, workers)
        if not follows(held[1], linear):
            campaign, (records, linear, floor) = other.campaign, held
            faults, notes = (*faults, *other.faults), (*notes, *other.said)
    hums = find_hum(records, linear)
    if hums:
        records, linear, floor = _begun(without_hum(campaign, hums), screened.wrong, workers)
    faults = (*faults, *(hum.fault for hum in hums))
    floor, colored = colored_floor(records, records.position - linear.solved.reading, white=floor)
    floor = bounded_floor(records, floor, linear.rms, int(linear.problem.free.sum() + linear.problem.active.sum()))
    return FitContext(records, linear, floor, workers=workers, faults=faults, colored=colored, notes=notes)


def _begun(campaign: Campaign, wrong: Mapping[str, Mask], workers: int) -> tuple[Records, Optimum, float]:
    """Lay out and weigh a campaign's records, and fit the linear plant; also the white noise floor, m."""
    records = lay_out(campaign)
    if not enough(records):
        raise UndeterminedError(
            f"campaign {campaign.name!r}: too few samples to tell the noise from the motion ({records.size} in all)",
            "Record longer or sample faster, or give counts_per_meter, from which the smallest noise follows.",
        )
    floor = noise_floor(records)
    records = records.reweighted(weights(records, floor) * trust(records, wrong))
    tolerance = 0.02 * floor**2
    linear = fit_linear(records, tolerance=tolerance, workers=workers)
    if linear is None:
        raise ConvergenceError(
            f"campaign {campaign.name!r}: no stable mass-spring-damper can be fitted to its records",
            "Look at the records: sign of counts_per_meter, the input column, the added masses and labels.",
        )
    if linear.rms > _MISFIT * floor:
        linear = within_weights(linear, tolerance=tolerance)
    return records, linear, floor


@in_own_quantities
@recorded()
@single_threaded
def fit(
    campaign: Campaign,
    *,
    effects: str | Effect | Iterable[str | Effect] = (),
    catalogue: tuple[Effect, ...] = CATALOGUE,
    workers: int = 1,
) -> Fit:
    """Fit a linear plant with given effects to all runs together.

    Shared by the runs: one base mass a base label, one stiffness a spring label, one damping a damper label, one force
    gain, the effects' parameters. Fitted for each run: its rest position, its displacement at the start where dry
    friction or play allows one, its initial state where the record starts in motion, its disturbance phase.

    Parameters
    ----------
    campaign : Campaign
    effects : iterable of str or Effect
        Canonical names or effects, one alone without brackets, too; none is the linear plant.
    catalogue : tuple of Effect
        Where names are looked up.
    workers : int
        Threads that simulate; the answer is the same for any number.

    Returns
    -------
    Fit

    Raises
    ------
    stepid.errors.InputError
        If an effect is not known, or no run can be used.
    stepid.errors.UndeterminedError
        If the records are too short.
    stepid.errors.ConvergenceError
        If no start leads to a stable plant.
    """
    wanted = resolve(effects, catalogue=catalogue)
    context = prepare(campaign, workers=as_workers(workers))
    optimum = fit_effects(context, wanted)
    if optimum is None:
        names = " and ".join(parameter_name(e.name) for e in wanted)
        raise ConvergenceError(
            f"campaign {campaign.name!r}: no start of {names} leads to a stable plant; the "
            f"linear fit leaves {length(context.linear.rms)}",
            "Try fewer effects, or look at the records for what the model cannot say.",
        )
    found = most_likely(optimum, context.floor)
    out = report(found, wanted, context.floor, notes=_remarks(context, optimum, found))
    return out.model_copy(update={"parameters": profiled(out.parameters, found, wanted, context.floor)})


def _remarks(context: FitContext, optimum: Optimum, found: Optimum) -> tuple[str, ...]:
    """What to say of a fit: `optimum` with the added masses as they are given, `found` with the most likely ones."""
    out = [
        *context.notes,
        *(f.words for f in context.faults if f.run == ALL_RUNS),
        *repeat_notes(context.records),
    ]
    if context.colored is not None:
        out.append(context.colored.words)
    if ratios := ratios_note(context.records):
        out.append(ratios)
    fault = find_input_fault(context)
    if fault is not None:
        out.append(fault.words)
    wrong = fault is None and found.rms > _MISFIT * context.floor
    eccentric = find_eccentricity(optimum, context.floor) if wrong else None
    if eccentric is not None:
        out.append(eccentric.fault.words)
    record_fault = find_fault(optimum, context.floor) if wrong and eccentric is None else None
    if record_fault is not None:
        out.append(record_fault.words)
    if mass_is_held(found):
        out.append(HELD)
    left = left_over(found, context)
    if left is not None:
        out.append(left)
    if not optimum.converged:
        out.append(NOT_CONVERGED)
    return tuple(out)


def report(optimum: Optimum, effects: tuple[Effect, ...], floor: float, *, notes: tuple[str, ...] = ()) -> Fit:
    """Make a fit's result."""
    records = optimum.problem.records
    values, correlation = estimates(optimum, effects, floor)
    residual = optimum.residual
    return Fit(
        parameters=values,
        model=unpack(optimum, effects),
        rms=optimum.rms,
        noise=floor,
        run_rms={
            run.name: rms(residual[piece][records.trusted[piece]])
            for run, piece in zip(records.runs, records.pieces(), strict=True)
        },
        correlation=correlation,
        converged=optimum.converged,
        notes=notes,
    )


def unpack(optimum: Optimum, effects: tuple[Effect, ...]) -> PlantModel:
    """Read a model off a fit: what differs from run to run does so about the mean of the runs."""
    optimum = centered(optimum)
    of = optimum.problem.layout
    r = of.records
    models = []
    for effect, place in zip(effects, of.values, strict=True):
        values = zip(effect.parameters, map(float, optimum.shared[place]), strict=True)
        models.append(EffectModel(name=effect.name, values={q.name: value for q, value in values}))
    rest = r.position - optimum.solved.reading
    square = r.weight**2
    keys = [f"{e.name}.{q.name}" for e in effects for q in e.run_parameters]
    own_keys = own_state_names(effects)
    differs = optimum.local[of.deviations].copy()
    differs[of.deviation("added_mass") - of.deviations.start] += r.added_mass - [run.added_mass for run in r.runs]
    runs = {}
    for i, (run, piece) in enumerate(zip(r.runs, r.pieces(), strict=True)):
        own = optimum.local[:, i]
        runs[run.name] = RunState(
            rest=float(np.average(rest[piece], weights=square[piece])),
            displacement=float(own[0]),
            velocity=float(own[1]),
            phases=dict(zip(keys, map(float, own[2 : of.own_states.start]), strict=True)),
            states=dict(zip(own_keys, map(float, own[of.own_states]), strict=True)) if r.moving[i] else {},
            deviations={q.name: float(d) for q, d in zip(DEVIATIONS, differs[:, i], strict=True) if d},
        )

    def by_label(labels: tuple[str, ...], place: slice) -> dict[str, float]:
        return dict(zip(labels, map(float, optimum.shared[place]), strict=True))

    return PlantModel(
        base_mass=by_label(r.bases, of.base_mass),
        stiffness=by_label(r.springs, of.stiffness),
        damping=by_label(r.dampers, of.damping),
        force_gain=float(optimum.shared[of.force_gain]),
        effects=tuple(models),
        runs=runs,
    )
