"""A lead on a real plant: one effect that explains most of a gap whose rest no model of one plant could."""

from __future__ import annotations

from collections import Counter

import numpy as np

from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.cross_validation import held_out_residuals
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import repeats, sensor_noise

_LEFT = 0.5  # of the misfit's power that a lead may leave
_SEEN = 0.6  # of the power in held-out runs
_RIVAL = 1.08  # times the RMS of a lead within which another is as good


def _has_repeats(context: FitContext) -> bool:
    """Tell whether runs were repeated, and do not agree as their sensor would: releases start anew each time."""
    records = context.records
    if repeats(records):
        return context.floor > 1.5 * sensor_noise(records)
    of = zip(records.base, records.spring, records.damper, records.added_mass, strict=True)
    alike = Counter(key for key, moving in zip(of, records.moving, strict=True) if moving)
    return max(alike.values(), default=0) > 1


def partial_lead(
    context: FitContext, linear: Candidate, ranked: list[Candidate]
) -> tuple[Candidate | None, tuple[Candidate, ...]]:
    """Find a single effect that clearly leads on a real plant, whose repeated runs scatter more than its sensor.

    Such a plant never reaches the floor. The lead counts where the effect takes away half of the misfit's power, and
    runs left out of the fit gain as much. Returned are the lead and the effects that come as near.
    """
    alone = sorted((c for c in ranked if len(c.effects) == 1), key=lambda c: c.evidence)
    simple = [c for c in alone if not c.effects[0].contains]
    kin = [c for c in simple if alone[0].effects[0].contains and c.effects[0].dry]
    simple = kin or simple  # a friction law of more parameters leads: the simplest of its kind is named
    if not simple or not _has_repeats(context):
        return None, ()
    best = simple[0]
    if best.names == ("load_proportional_friction",):  # where no load varies, the simpler name says it all
        best = next(iter(same_law(context, best, simple)), best)
    twins = (best, *same_law(context, best, ranked))
    near = tuple(c for c in simple if c not in twins and c.optimum.rms < _RIVAL * best.optimum.rms)
    if any(_left(context, linear, c) > _LEFT for c in (best, *near)) or not _holds(context, linear, best):
        return None, ()
    return best, near


def _left(context: FitContext, linear: Candidate, found: Candidate) -> float:
    floor = context.floor**2
    return (found.optimum.rms**2 - floor) / max(linear.optimum.rms**2 - floor, 1e-30)


def _holds(context: FitContext, linear: Candidate, found: Candidate) -> bool:
    """Tell whether runs left out of the fit gain as well."""
    before = held_out_residuals(linear.optimum, tolerance=context.tolerance)
    after = held_out_residuals(found.optimum, tolerance=context.tolerance)
    runs = before.keys() & after.keys()
    power = [sum(float(np.sum(seen[i] ** 2)) for i in runs) for seen in (before, after)]
    return bool(runs) and power[1] <= _SEEN * power[0]


def same_law(context: FitContext, best: Candidate, ranked: list[Candidate]) -> tuple[Candidate, ...]:
    """Candidates that are the same law in this campaign: friction with and without the load where no load varies."""
    records = context.records
    if np.ptp(records.added_mass) > 0 or len(records.bases) > 1:
        return ()
    out = []
    for other in ranked:
        if other is not best and len(other.effects) == len(best.effects):
            changed = {e.name for e in other.effects} ^ {e.name for e in best.effects}
            if changed == {"coulomb_friction", "load_proportional_friction"}:
                out.append(other)
    return tuple(out)
