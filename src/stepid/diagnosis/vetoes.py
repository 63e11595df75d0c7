"""Effects that must not be named: those with an undetermined parameter, those that a linear parameter can imitate.

The search, the evidence and the rules of `stepid.diagnosis.verdict` ask for them; the rules say what it means.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from stepid.core.once import once
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.selection.candidate import Candidate
from stepid.effects.base import Effect
from stepid.effects.swing import Swing
from stepid.fitting.covariance import effect_parameters, estimates
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.profile import limited, present
from stepid.simulation.records import Records

_PerRun = tuple[float, ...]


def swing(context: FitContext, criteria: Criteria, found: Candidate) -> Swing:
    """How the campaign's runs swing under a fit."""
    rates, decays, masses, longest = _paces(found.optimum, context.records)
    return Swing(
        rates=rates,
        decays=decays,
        masses=masses,
        displacement=context.scales.displacement,
        duration=context.scales.duration,
        resolution=max(criteria.resolution, longest),
        pitch=criteria.pitch,
        fast=criteria.fast,
        slow=criteria.slow,
        swings=criteria.swings,
    )


@once
def _paces(optimum: Optimum, records: Records) -> tuple[_PerRun, _PerRun, _PerRun, float]:
    """Rates and decays of the runs, 1/s, their masses, kg, and two periods of the slowest in the shortest recording."""
    of, shared = optimum.problem.layout, optimum.shared
    rates, masses = of.rates(shared), of.mass(shared)
    decays = shared[of.damping][records.damper] / (2 * masses)
    durations = np.array([np.ptp(records.time[piece]) for piece in records.pieces()])
    if records.one_recording:  # its parts share their rates
        durations[:] = durations.sum()
    able = durations * rates > 2 * math.tau  # a record of less than two periods tells no rate
    able = able if able.any() else np.ones_like(able)
    shortest, slowest = durations[able].min(), rates[able].min(initial=np.inf)
    longest = float(2 * math.tau / (shortest * slowest))
    return tuple(map(float, rates)), tuple(map(float, decays)), tuple(map(float, masses)), longest


def imitators(context: FitContext, criteria: Criteria, found: Candidate) -> dict[str, str]:
    """Effects of a candidate that something else can stand in for, to what.

    A linear parameter stands in for none that leaves only noise and has all its parameters determined: if it did as
    well, these would be open. What is `unseen` is so there, too.
    """
    said = unseen(context, criteria, found)
    linear = _said(context, criteria, found, "imitates")
    if linear and _leaves_noise(context, criteria, found):
        open_ = effects_of(undetermined(context, criteria, found))
        linear = {name: words for name, words in linear.items() if name in open_}
    return linear | said


def unseen(context: FitContext, criteria: Criteria, found: Candidate) -> dict[str, str]:
    """Effects of a candidate of which the records are too short to show what sets them apart, to what is as good.

    The linear plant does not have it: a rest position that shifts leaves the parameters of a slow sine determined.
    """
    return _said(context, criteria, found, "unseen")


def _said(context: FitContext, criteria: Criteria, found: Candidate, asked: str) -> dict[str, str]:
    """What effects answer to `Effect.imitates` or `Effect.unseen` at their fitted values, where they say something."""
    if all(getattr(type(e), asked) is getattr(Effect, asked) for e in found.effects):
        return {}
    how, shared = swing(context, criteria, found), found.optimum.shared
    places = zip(found.effects, found.optimum.problem.layout.values, strict=True)
    said = {e.name: getattr(e, asked)(tuple(map(float, shared[place])), how) for e, place in places}
    return {name: words for name, words in said.items() if words}


def _leaves_noise(context: FitContext, criteria: Criteria, found: Candidate) -> bool:
    """Tell whether a fit to all samples, or to the decimated ones of the search, leaves no more than noise."""
    if found.optimum.problem.records is context.records:
        return at_floor(context, criteria, found)
    return found.optimum.cost <= context.noise_limit


def effects_of(parameters: Iterable[str]) -> set[str]:
    """Names of the effects whose parameters have these names."""
    return {name.rpartition(".")[0] for name in parameters}


def undetermined(context: FitContext, criteria: Criteria, found: Candidate) -> tuple[str, ...]:
    """Parameters of a candidate's effects that the data do not determine, by name: those of angles do not count."""
    if not found.effects:
        return ()
    values, _ = estimates(found.optimum, found.effects, context.floor)
    own, sizes = effect_parameters(found.effects), sizes_of(found.optimum, found.effects)
    out = []
    for name, value in values.items():
        if name not in own or own[name].angle:
            continue
        if value.uncertainty is None or value.uncertainty > criteria.open * sizes[name]:
            out.append(name)
    return tuple(out)


def sizes_of(optimum: Optimum, effects: tuple[Effect, ...]) -> dict[str, float]:
    """What uncertainties of effects' parameters are large beside, by name: how far each is from where its range begins.

    What ends there would go on, were it allowed to: the data ask for no such effect. Of an angle, where zero is as
    good as any, 1 rad.
    """
    problem, out = optimum.problem, dict[str, float]()
    for effect, place in zip(effects, problem.layout.values, strict=True):
        begins = np.where(np.isfinite(problem.lower[place]), problem.lower[place], 0.0)
        for parameter, size in zip(effect.parameters, np.abs(optimum.shared[place] - begins), strict=True):
            out[f"{effect.name}.{parameter.name}"] = 1.0 if parameter.angle else float(size)
    return out


def open_parameters(context: FitContext, criteria: Criteria, found: Candidate) -> tuple[str, ...]:
    """Parameters of a candidate's effects that the data leave open on the side on which the effect is absent."""
    names = undetermined(context, criteria, found)
    if not names or not at_floor(context, criteria, found):
        return names
    one_sided = limited(found.optimum, found.effects, context.floor, names)
    names = tuple(name for name in names if name not in one_sided)
    if not names or found.deviations:
        return names
    within = min(2 * criteria.open, 1.0)  # two standard uncertainties
    sure = present(found.optimum, found.effects, context.floor, names, within)
    return tuple(name for name in names if name not in sure)


def barred(context: FitContext, criteria: Criteria, found: Candidate) -> bool:
    """Tell whether a candidate may not be named: something else stands in for an effect, or it is open."""
    return bool(imitators(context, criteria, found)) or bool(open_parameters(context, criteria, found))
