"""What the best answers say about the data: wrong readings, their color, a floor that was too high, weights."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from stepid.core.noise import floor_from_residual
from stepid.core.words import length
from stepid.diagnosis.evidence import less_likely_by
from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.covariance import by_weights
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_color import NoiseColor, colored_floor
from stepid.fitting.noise_floor import least_floor
from stepid.fitting.problem import build
from stepid.fitting.reading_faults import outliers_of
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.records import Records

_BELOW = 0.85  # times the floor that a fit leaves where the floor was read too high
_NOISE = 1.5  # times the floor that most of a residual may be, for what stands out of it to be wrong readings
_MANY = 0.02  # share of samples, beyond which they are no isolated wrong readings
_UNTRUSTED = 1e-6  # square-root weight of a reading that is left out


def refined(
    context: FitContext, best: Candidate, likeliest: Candidate | None = None, simpler: Iterable[Candidate] = ()
) -> FitContext | None:
    """Look again at the data, by what the best answer leaves; a new context where that changes what is known.

    Parameters
    ----------
    context : FitContext
    best : Candidate
        That leaves least.
    likeliest : Candidate, optional
        Of most evidence; the best where it is not given.
    simpler : iterable of Candidate
        Those that errors of the weights may stand beside, the simplest first.
    """
    for look in (_without_outliers, _with_color, _with_lower_floor):
        found = look(context, best)
        if found is not None:
            return found
    return _with_weights(context, likeliest or best, simpler)


def _with_weights(context: FitContext, likeliest: Candidate, simpler: Iterable[Candidate]) -> FitContext | None:
    """Take the added masses with which a simpler answer leaves only noise, as far as their uncertainty allows.

    It has to be as likely as the likeliest is with the weights as they are: a floor is known to some per cent only, and
    what an effect takes of that would be put into the weights.
    """
    able = filter(None, (by_weights(c.optimum, context.floor) for c in simpler))
    likely = next((o for o in able if less_likely_by(context, o, likeliest.optimum) <= 0), None)
    if likely is None:
        return None
    return _again(context, context.floor, replace(context.records, added_mass=likely.problem.records.added_mass))


def _again(
    context: FitContext,
    floor: float,
    records: Records,
    *,
    faults: tuple[RecordFault, ...] = (),
    colored: NoiseColor | None = None,
) -> FitContext | None:
    linear = context.linear
    if records is not context.records:
        fitted = minimize(build(records, (), workers=context.workers), linear.shared, linear.local)
        if fitted is None:
            return None
        linear = fitted
    return FitContext(
        records,
        linear,
        floor,
        workers=context.workers,
        faults=(*context.faults, *faults),
        colored=colored or context.colored,
        first=context.first,
        notes=context.notes,
    )


def _without_outliers(context: FitContext, best: Candidate) -> FitContext | None:
    records, residual = context.records, best.optimum.residual
    weight, faults = records.weight.copy(), []
    for run, piece in zip(records.runs, records.pieces(), strict=True):
        mask = outliers_of(residual[piece], context.floor) & (weight[piece] > _UNTRUSTED)
        if not mask.any() or mask.mean() > _MANY:
            continue
        weight[piece] = np.where(mask, _UNTRUSTED, weight[piece])
        size = float(np.abs(residual[piece][mask]).max())
        one = mask.sum() == 1
        said = "1 reading stands out by" if one else f"{int(mask.sum())} readings stand out by up to"
        words = f"Run {run.name!r}: {said} {length(size)}. {'It is' if one else 'They are'} left out."
        faults.append(RecordFault(run=run.name, kind="outliers", size=size, unit="m", words=words))
    noise = 1.4826 * float(np.median(np.abs(residual))) <= _NOISE * context.floor
    standing = float(np.sum(residual[weight < records.weight] ** 2))
    if not faults or not (noise or standing > 0.5 * best.optimum.cost):
        return None  # what stands out of a misfit, and is not most of it, is a part of it
    return _again(context, context.floor, context.records.reweighted(weight), faults=tuple(faults))


def _with_color(context: FitContext, best: Candidate) -> FitContext | None:
    if context.colored is not None:
        return None
    floor, colored = colored_floor(context.records, best.optimum.residual)
    if colored is None or floor <= context.floor:
        return None
    return _again(context, floor, context.records, colored=colored)


def _with_lower_floor(context: FitContext, best: Candidate) -> FitContext | None:
    if best.optimum.rms >= _BELOW * context.floor:
        return None
    problem = best.optimum.problem
    count = int(problem.free.sum() + problem.active.sum())
    floor = max(floor_from_residual(best.optimum.residual, parameters=count), least_floor(context.records))
    if floor >= _BELOW * context.floor:
        return None
    return _again(context, floor, context.records)
