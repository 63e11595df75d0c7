"""Profile likelihood of parameters near a bound or hardly determined: no parabola says how sure one is there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stepid.core.estimate import Estimate
from stepid.effects.base import Effect
from stepid.fitting.covariance import parameter_names, uncertain
from stepid.fitting.levenberg_marquardt import Optimum, minimize

_NORMAL = 1.96  # standard deviations, of a 95 % interval
_NEAR = 2.5  # standard uncertainties from a bound
_VAGUE = 0.25  # uncertainty by noise over the value, above which a parabola is not trusted
_TRIES = 7  # fits a side
_CLOSE = 0.05  # relative, of the likelihood ratio at a limit
_FAR = 30.0  # times the parabola's distance at which a side is open


def profiled(
    parameters: Mapping[str, Estimate], optimum: Optimum, effects: tuple[Effect, ...], floor: float
) -> dict[str, Estimate]:
    """Give parameters near a bound, or hardly determined, the limits of their profile likelihood.

    All other parameters are fitted anew on both sides, up to where χ² has grown by 3.84, the noise's correlation
    counted in; what comes from weights and scale is added. A side without such a place is open, and the parameter is
    not determined.

    Parameters
    ----------
    parameters : mapping
        Name to Estimate, as `stepid.fitting.covariance.estimates` gives them.
    optimum, effects, floor
        As there.
    """
    problem, out = optimum.problem, dict(parameters)
    names = [name for name, _ in parameter_names(optimum, effects)]
    odd = [i for i in np.flatnonzero(problem.free).tolist() if _odd(parameters[names[i]], optimum, i)]
    if not odd:
        return out
    near = uncertain(optimum, floor)
    for i in odd:
        e = parameters[names[i]]
        column = int(problem.free[:i].sum())
        wanted = _NORMAL**2 * near.level**2 * float(near.excess[column])
        ends = [_limit(optimum, i, way * _NORMAL * e.parts["noise"], wanted) for way in (-1.0, 1.0)]
        low, high = ends
        if low is None or high is None:
            out[names[i]] = Estimate(value=e.value, unit=e.unit)
            continue
        other = _NORMAL * math.hypot(e.parts.get("weights", 0.0), e.parts.get("scale", 0.0))
        limits = e.value - math.hypot(e.value - low, other), e.value + math.hypot(high - e.value, other)
        limits = max(limits[0], float(problem.lower[i])), min(limits[1], float(problem.upper[i]))
        out[names[i]] = e.model_copy(update={"limits": limits})
    return out


def _odd(e: Estimate, optimum: Optimum, index: int) -> bool:
    spread = e.parts.get("noise")
    if spread is None or not spread > 0 or e.unit == "rad":
        return False
    value, low, high = e.value, optimum.problem.lower[index], optimum.problem.upper[index]
    return bool(min(value - low, high - value) < _NEAR * spread or spread > _VAGUE * abs(value))


def _limit(optimum: Optimum, index: int, distance: float, wanted: float) -> float | None:
    """Where the cost has grown by so much [m²], or the bound before it; None where it never does."""
    problem = optimum.problem
    value, low, high = float(optimum.shared[index]), float(problem.lower[index]), float(problem.upper[index])
    held = replace(problem, free=problem.free & (np.arange(problem.free.size) != index))
    best, found, first = optimum.cost, optimum, abs(distance)
    for _ in range(_TRIES):
        place = min(max(value + distance, low), high)
        shared = found.shared.copy()
        shared[index] = place
        again = minimize(held, shared, found.local, tolerance=0.01 * wanted, iterations=12)
        grown = np.inf if again is None else again.cost - best
        if abs(grown / wanted - 1.0) < _CLOSE:
            return place
        if grown < wanted and place in (low, high):
            return place
        if abs(distance) > _FAR * first:
            return None
        found = again if again is not None else found
        factor = math.sqrt(wanted / max(grown, 0.02 * wanted)) if np.isfinite(grown) else 0.5
        distance *= min(max(factor, 0.2), 5.0)
    return min(max(value + distance, low), high)
