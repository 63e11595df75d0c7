"""Profile likelihood of parameters near a bound or hardly determined: no parabola says how sure one is there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stepid.core.estimate import Estimate
from stepid.core.once import once
from stepid.effects.base import Effect
from stepid.fitting.covariance import parameter_names, uncertain
from stepid.fitting.levenberg_marquardt import Optimum, minimize

_NORMAL = 1.96  # standard deviations, of a 95 % interval
_NEAR = 2.5  # standard uncertainties from a bound
_VAGUE = 0.25  # uncertainty by noise over the value, above which a parabola is not trusted
_TRIES = 7  # fits a side
_CLOSE = 0.05  # relative, of the likelihood ratio at a limit
_NOISY = 1.2  # times the floor, beyond which what bends the fit a little would limit a size, too
_FAR = 30.0  # times the parabola's distance at which a side is open


def profiled(
    parameters: Mapping[str, Estimate], optimum: Optimum, effects: tuple[Effect, ...], floor: float
) -> dict[str, Estimate]:
    """Give parameters near a bound, or hardly determined, the limits of their profile likelihood.

    All other parameters are fitted anew on both sides, up to where χ² has grown by 3.84, the noise's correlation
    counted in; what comes from weights and scale is added. A side without such a place is open, and the parameter is
    not determined; see `limited` for what the other side says.

    Parameters
    ----------
    parameters : mapping
        Name to Estimate, as `stepid.fitting.covariance.estimates` gives them.
    optimum, effects, floor
        As there.
    """
    names = [name for name, _ in parameter_names(optimum, effects)]
    sized = limited(optimum, effects, floor, tuple(names)) if optimum.rms < _NOISY * floor else {}
    problem, out = optimum.problem, {**parameters, **sized}
    odd = [i for i in np.flatnonzero(problem.free).tolist() if out[names[i]].parts and _odd(out[names[i]], optimum, i)]
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


@once
def limited(optimum: Optimum, effects: tuple[Effect, ...], floor: float, names: tuple[str, ...]) -> dict[str, Estimate]:
    """Of some parameters those that the data limit on the side on which the effect is absent, and on no other.

    A gap that the cart never crosses has a least width and no largest, a saturation below all inputs a highest level
    and no least: the effect is there, its size is open. The strength of an effect is asked, by `Effect.faint`, where it
    is one parameter of which the fit's curvature tells nothing: its uncertainty is as large as itself.

    Parameters
    ----------
    optimum, effects, floor
        As for `stepid.fitting.covariance.estimates`.
    names : tuple of str
        Parameters that are asked.

    Returns
    -------
    dict of str to Estimate
        Without an uncertainty; one end of the 95 % limits is None.
    """
    out: dict[str, Estimate] = {}
    problem = optimum.problem
    for effect, place in zip(effects, problem.layout.values, strict=True):
        values = tuple(map(float, optimum.shared[place]))
        away = np.subtract(effect.faint(values, 0.0), values)
        moved = np.flatnonzero(away)
        name = f"{effect.name}.{effect.parameters[moved[0]].name}" if moved.size == 1 else ""
        if name not in names:
            continue
        index, value = place.start + int(moved[0]), values[moved[0]]
        near, column = uncertain(optimum, floor), int(problem.free[:index].sum())
        if not problem.free[index] or not (near.open[column] or near.noise[column, column] > value**2):
            continue
        wanted = _NORMAL**2 * near.level**2 * max(float(near.excess[column]), 1.0)
        toward = math.copysign(0.5 * value, away[moved[0]])
        end = _limit(optimum, index, toward, wanted)
        if end is None or not problem.lower[index] < end < problem.upper[index]:
            continue
        if abs(end - value) < abs(away[moved[0]]):
            ends = (end, None) if toward < 0 else (None, end)
            out[name] = Estimate(value=value, unit=effect.parameters[moved[0]].unit, limits=ends)
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
    inside, outside = 0.0, math.inf  # distances at which the cost has grown by less, and by more
    for _ in range(_TRIES):
        place = min(max(value + distance, low), high)
        distance = place - value
        shared = found.shared.copy()
        shared[index] = place
        again = minimize(held, shared, found.local, tolerance=0.01 * wanted, iterations=12)
        grown = np.inf if again is None else again.cost - best
        if abs(grown / wanted - 1.0) < _CLOSE:
            return place
        if again is not None and grown < wanted:
            if place in (low, high):
                return place
            if abs(distance) > _FAR * first:
                return None
            found, inside = again, abs(distance)
        else:
            outside = abs(distance)
        factor = math.sqrt(wanted / max(grown, 0.02 * wanted)) if np.isfinite(grown) else 0.5
        distance *= min(max(factor, 0.2), 5.0)
        if not inside < abs(distance) < outside:  # flat, then steep: no parabola
            distance = math.copysign(0.5 * (inside + outside), distance)
    if math.isfinite(outside):
        distance = math.copysign(outside, distance)
    return min(max(value + distance, low), high)
