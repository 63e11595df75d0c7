"""Effects that must not be named: those with an undetermined parameter, those that a linear parameter can imitate.

The search, the evidence and the rules of `stepid.diagnosis.verdict` ask for them; the rules say what it means.
"""

from __future__ import annotations

import math

import numpy as np

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.selection.candidate import Candidate
from stepid.effects.base import Effect
from stepid.effects.swing import Swing
from stepid.fitting.covariance import effect_parameters, estimates
from stepid.fitting.multistart import FitContext


def swing(context: FitContext, criteria: Criteria, found: Candidate) -> Swing:
    """How the campaign's runs swing under a fit."""
    of, shared = found.optimum.problem.layout, found.optimum.shared
    rates = np.sqrt(np.maximum(shared[of.stiffness][context.records.spring], 0.0) / of.mass(shared))
    shortest = min(float(np.ptp(context.records.time[piece])) for piece in context.records.pieces())
    slowest = float(rates.min(initial=np.inf))
    return Swing(
        rates=tuple(map(float, rates)),
        displacement=context.scales.displacement,
        duration=context.scales.duration,
        resolution=max(criteria.resolution, 2 * math.tau / (shortest * slowest)),
        pitch=criteria.pitch,
        fast=criteria.fast,
        slow=criteria.slow,
        swings=criteria.swings,
    )


def imitators(context: FitContext, criteria: Criteria, found: Candidate) -> dict[str, str]:
    """Effects of a candidate that a linear parameter can stand in for, to which one.

    What leaves only noise and has all its parameters determined is none: if a linear parameter did as well, these would
    be open.
    """
    if all(type(e).imitates is Effect.imitates for e in found.effects):
        return {}
    how = swing(context, criteria, found)
    places = found.optimum.problem.layout.values
    said = {
        e.name: e.imitates(tuple(map(float, found.optimum.shared[place])), how)
        for e, place in zip(found.effects, places, strict=True)
    }
    said = {name: words for name, words in said.items() if words}
    if said and _leaves_noise(context, criteria, found):
        open_ = {name.rpartition(".")[0] for name in undetermined(context, criteria, found)}
        said = {name: words for name, words in said.items() if name in open_}
    return said


def _leaves_noise(context: FitContext, criteria: Criteria, found: Candidate) -> bool:
    """Tell whether a fit to all samples, or to the decimated ones of the search, leaves no more than noise."""
    if found.optimum.problem.records is context.records:
        return at_floor(context, criteria, found)
    return found.optimum.cost <= context.noise_limit


def undetermined(context: FitContext, criteria: Criteria, found: Candidate) -> tuple[str, ...]:
    """Parameters of a candidate's effects that the data do not determine, by name: those of angles do not count."""
    values, _ = estimates(found.optimum, found.effects, context.floor)
    own = effect_parameters(found.effects)
    out = []
    for name, value in values.items():
        if name not in own or own[name].angle:
            continue
        if value.uncertainty is None or value.uncertainty > criteria.open * abs(value.value):
            out.append(name)
    return tuple(out)
