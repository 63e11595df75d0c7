"""What each panel of a diagnosis shows, in the units of its axes: matplotlib and plotly draw the same numbers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.result import Diagnosis, Ranked, RunGap, Where
from stepid.identification.transfer.verification import VerificationRun
from stepid.plot.scale import length_unit, reach_of

_BAND = 2.0  # standard deviations of the noise, to either side


class Responses(NamedTuple):
    """Positions over time [s] in `unit`, by what they are.

    ``"measured"`` and ``"simulated"``; of a diagnosis ``"measured"``, ``"linear"`` and, where one was added,
    ``"effect"``.
    """

    time: Array
    unit: str
    curves: dict[str, Array]


class Residual(NamedTuple):
    """Measured minus simulated in `unit`; the scale ends at ±`end`, the band of the noise at ±`band`."""

    values: Array
    unit: str
    end: float
    band: float


class Levels(NamedTuple):
    """RMS [µm] by model, a value for each of `names`, and the noise; `span` is the least and the largest above zero."""

    names: tuple[str, ...]
    values: dict[str, list[float]]
    noise: float
    span: tuple[float, float] | None


class Force(NamedTuple):
    """Residual force [N] over `levels` in `unit`, in pieces that no line joins."""

    unit: str
    pieces: tuple[tuple[Array, Array], ...]


class Jump(NamedTuple):
    """Where a force [N] that jumps ends on either side of zero velocity, and by how much in words."""

    below: float
    above: float
    said: str


class Shown(NamedTuple):
    """A candidate, the RMS that it leaves [µm], and whether the diagnosis names it."""

    one: Ranked
    left: float
    named: bool


class Candidates(NamedTuple):
    """Candidates from the top down, the noise [µm], and the `span` of all."""

    shown: tuple[Shown, ...]
    noise: float
    span: tuple[float, float] | None


def responses(d: Diagnosis, run: RunGap) -> Responses:
    """A run as measured, as the linear model says, and as the model with the effects says."""
    return Responses(run.time, "mm", curves(d, 1e3, run.measured, run.linear, run.model))


def curves(d: Diagnosis, scale: float, measured: Array, linear: Array, final: Array) -> dict[str, Array]:
    """Name and scale the curves of a response; the final model is one where effects were added."""
    effect = {"effect": scale * final} if d.effects else {}
    return {"measured": scale * measured, "linear": scale * linear, **effect}


def linear_reach(d: Diagnosis) -> float:
    """How far the linear model's residuals reach, m: one scale for all runs, so that they compare."""
    return reach_of(run.measured - run.linear for run in d.runs)


def final_reach(d: Diagnosis) -> float:
    """How far the final model's residuals reach, m, and at least the band of the noise."""
    return reach_of([*(run.measured - run.model for run in d.runs), np.array([_BAND * d.gap.noise])])


def residual(measured: Array, simulated: Array, *, reach: float, noise: float = 0.0) -> Residual:
    """What is left of a response, on a scale that holds `reach`; lengths in m."""
    scale, unit = length_unit(reach)
    return Residual(scale * (measured - simulated), unit, 1.05 * scale * reach, _BAND * scale * noise)


def verification_responses(run: VerificationRun) -> Responses:
    """A run as measured and as its identified model says."""
    return Responses(run.time, "mm", {"measured": 1e3 * run.measured, "simulated": 1e3 * run.simulated})


def verification_residual(run: VerificationRun, *, reach: float | None = None) -> Residual:
    """What its identified model leaves, on a scale of its own or one that holds `reach` [m]."""
    own = reach_of([run.measured - run.simulated]) if reach is None else reach
    return residual(run.measured, run.simulated, reach=own)


def gap_levels(d: Diagnosis) -> Levels:
    """The RMS gap before and after, and the noise: of the runs that were fitted, and of those held out."""
    groups = {"fitted": (d.gap.before, d.gap.after)}
    if d.gap.held_out:
        groups["held out"] = d.gap.held_out
    before, after = ([1e6 * rms for rms in column] for column in zip(*groups.values(), strict=True))
    values = {"linear": before, "effect": after} if d.effects else {"linear": before}
    noise = 1e6 * d.gap.noise
    return Levels(tuple(groups), values, noise, _span([*before, *after, noise]))


def phase_levels(d: Diagnosis) -> Levels:
    """The linear model's RMS by phase of the response, and the noise."""
    linear = [1e6 * rms for rms in d.where.phases.values()]
    noise = 1e6 * d.gap.noise
    return Levels(tuple(d.where.phases), {"linear": linear}, noise, _span([*linear, noise]))


def velocity_force(where: Where) -> Force:
    """The residual force over velocity; no line crosses zero, for what happens there is the point of the picture."""
    levels, force = where.velocity_levels, where.velocity_force
    return Force("m/s", tuple((levels[side], force[side]) for side in (levels < 0, levels >= 0)))


def position_force(where: Where) -> Force:
    """The residual force over position from rest."""
    return Force("mm", ((1e3 * where.position_levels, where.position_force),))


def force_jump(where: Where) -> Jump | None:
    """By how much the force jumps at zero velocity; None where it has no such shape."""
    (_, below), (_, above) = velocity_force(where).pieces
    if where.jump is None or not below.size or not above.size:
        return None
    middle = float(below[-1] + above[0]) / 2
    return Jump(middle - where.jump / 2, middle + where.jump / 2, f"jump {abs(where.jump):.2g} N")


def ranked_candidates(d: Diagnosis, *, most: int) -> Candidates:
    """The best candidates, then the linear model, each with whether the diagnosis names it, alone or among others.

    A set of effects that was fitted with and without conditions that differ between runs counts as named once: where
    it leaves what the answer leaves, else where it ranks best.
    """
    named: dict[tuple[str, ...], Ranked] = {}
    for one in d.ranking:
        answered = one.effects == d.effects and one.rms == d.gap.after
        if one.effects and one.effects in (d.effects, *d.alternatives) and (answered or one.effects not in named):
            named[one.effects] = one
    plain = [one for one in d.ranking if not (one.effects or one.deviations)][:1]
    best = [one for one in d.ranking if one.effects or one.deviations][:most] + plain
    shown = tuple(Shown(one, 1e6 * one.rms, named.get(one.effects) is one) for one in best)
    noise = 1e6 * d.gap.noise
    return Candidates(shown, noise, _span([noise, *(each.left for each in shown)]))


def _span(values: Iterable[float]) -> tuple[float, float] | None:
    """The least and the largest value that a logarithmic axis can show."""
    shown = [value for value in values if value > 0]
    return (min(shown), max(shown)) if shown else None
