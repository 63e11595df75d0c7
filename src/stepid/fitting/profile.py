"""Profile likelihood of parameters near a bound or hardly determined: no parabola says how sure one is there."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stepid.core.estimate import Estimate
from stepid.core.once import once
from stepid.effects.base import Effect
from stepid.fitting.covariance import estimates, parameter_names, uncertain
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
    for strength in _strengths(optimum, effects, names):
        near, column = uncertain(optimum, floor), strength.column
        if not (near.open[column] or near.noise[column, column] > strength.value**2):
            continue
        end = _end(optimum, strength, floor)
        if end is not None:
            ends = (end, None) if strength.to_none < 0 else (None, end)
            out[strength.name] = Estimate(value=strength.value, unit=strength.unit, limits=ends)
    return out


@once
def present(
    optimum: Optimum, effects: tuple[Effect, ...], floor: float, names: tuple[str, ...], within: float
) -> frozenset[str]:
    """Of some parameters those that are not none within their 95 % limits: strengths that the data determine.

    A fit's curvature may give half of a value as its uncertainty where the likelihood ends long before zero: the
    coefficient of a power law goes with its exponent. What comes from weights and scale counts as in `profiled`.

    Parameters
    ----------
    optimum, effects, floor, names
        As for `limited`.
    within : float
        Share of the way to none, within which the limit must be.
    """
    found, out = estimates(optimum, effects, floor)[0], set()
    for strength in _strengths(optimum, effects, names):
        end, parts = _end(optimum, strength, floor), found[strength.name].parts
        other = _NORMAL * math.hypot(*(part for cause, part in parts.items() if cause != "noise"))
        if end is not None and math.hypot(end - strength.value, other) < within * abs(strength.to_none):
            out.add(strength.name)
    return frozenset(out)


class _Strength(NamedTuple):
    """The one parameter by which an effect grows faint: its place among the global ones, and its way to none.

    `column` is its place among those that are free.
    """

    name: str
    unit: str
    place: int
    column: int
    value: float
    to_none: float


def _strengths(optimum: Optimum, effects: tuple[Effect, ...], names: Collection[str]) -> list[_Strength]:
    """Strengths of effects, of those that are asked for and free."""
    out, problem = [], optimum.problem
    for effect, place in zip(effects, problem.layout.values, strict=True):
        values = tuple(map(float, optimum.shared[place]))
        way = np.subtract(effect.faint(values, 0.0), values)
        moved = np.flatnonzero(way)
        if moved.size != 1 or not problem.free[place.start + int(moved[0])]:
            continue
        i = int(moved[0])
        quantity, at = effect.parameters[i], place.start + i
        name = f"{effect.name}.{quantity.name}"
        if name in names:
            out.append(_Strength(name, quantity.unit, at, int(problem.free[:at].sum()), values[i], float(way[i])))
    return out


@once
def _end(optimum: Optimum, strength: _Strength, floor: float) -> float | None:
    """The 95 % limit of a strength toward none; None where none is within it."""
    problem, place, value = optimum.problem, strength.place, strength.value
    near = uncertain(optimum, floor)
    wanted = _NORMAL**2 * near.level**2 * max(float(near.excess[strength.column]), 1.0)
    end = _limit(optimum, place, math.copysign(0.5 * value, strength.to_none), wanted)
    if end is None or not problem.lower[place] < end < problem.upper[place]:
        return None
    return end if abs(end - value) < abs(strength.to_none) else None


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
