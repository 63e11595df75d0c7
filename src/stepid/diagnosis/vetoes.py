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
    """Effects of a candidate that something else can stand in for, to what.

    A linear parameter stands in for none that leaves only noise and has all its parameters determined: if it did as
    well, these would be open. What the linear plant has not, as a rest position that shifts, stands in there, too.
    """
    if all(type(e).imitates is Effect.imitates and type(e).unseen is Effect.unseen for e in found.effects):
        return {}
    how, said, linear = swing(context, criteria, found), {}, {}
    for e, place in zip(found.effects, found.optimum.problem.layout.values, strict=True):
        values = tuple(map(float, found.optimum.shared[place]))
        said[e.name], linear[e.name] = e.unseen(values, how), e.imitates(values, how)
    if any(linear.values()) and _leaves_noise(context, criteria, found):
        open_ = {name.rpartition(".")[0] for name in undetermined(context, criteria, found)}
        linear = {name: words for name, words in linear.items() if name in open_}
    both = {name: words or linear.get(name, "") for name, words in said.items()}
    return {name: words for name, words in both.items() if words}


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
