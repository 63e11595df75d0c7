"""Is every effect of a combination needed? Each is taken away in turn, and the others are fitted anew."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.selection.beam import STRONG
from stepid.diagnosis.selection.candidate import Candidate, candidate, polish
from stepid.diagnosis.selection.racing import level_within
from stepid.effects import Effect
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.multistart import Contender, FitContext, Start
from stepid.fitting.problem import build

_FADING = (0.5, 0.2, 0.05)  # shares of an effect on its way out of a combination
_NEEDED = 200.0  # χ² that a combination may seem to lose without an effect, to be tried without
_TURNS = 8  # phases tried


def simplified(context: FitContext, ranked: list[Candidate]) -> list[Candidate]:
    """Simplify the best of a ranking, and what then is best, for as long as that betters it."""
    last: Candidate | None = None
    while ranked[0] is not last and len(ranked[0].effects) > 1:
        last = ranked[0]
        ranked = replaced(ranked, simplify(context, last))
    return ranked


def replaced(ranked: list[Candidate], better: list[Candidate]) -> list[Candidate]:
    """A ranking with some fitted anew."""
    anew = {c.combination for c in better}
    return sorted([*better, *(c for c in ranked if c.combination not in anew)], key=lambda c: c.evidence)


def simplify(context: FitContext, found: Candidate) -> list[Candidate]:
    """Drop each effect of a combination in turn and fit the others from where they stand; those that do no worse.

    A single effect can have been stuck where the combination was not. An effect that matters to first order stays.
    """
    out = []
    for dropped, effect in enumerate(found.effects):
        own = _place(found, dropped)
        values = tuple(float(v) for v in found.optimum.shared[own])
        if _moved(found.optimum, own, np.array(effect.faint(values, 0.0))).loss > _NEEDED * context.floor**2:
            continue
        for drop in (_drop, _fade, _again):
            fewer = drop(context, found, dropped)
            if fewer is not None and fewer.evidence < found.evidence + STRONG:
                out.append(fewer)
                break
    return sorted(out, key=lambda c: c.evidence)


def plainer(
    context: FitContext, found: Candidate, known: list[tuple[Effect, ...]], catalogue: tuple[Effect, ...]
) -> list[Candidate]:
    """Replace each general effect by the simpler one inside it, fitted from where it stands; those that do no worse.

    The simpler one may have been stuck on its own; those in `known` were not.
    """
    out = []
    for place, effect in enumerate(found.effects):
        own, shared = _place(found, place), found.optimum.shared
        for inner in (e for e in catalogue if e.name in effect.contains):
            level = level_within(effect, shared[own], inner)
            if level is None or len(inner.parameters) > 1 or inner.run_parameters != effect.run_parameters:
                continue
            effects = (*found.effects[:place], inner, *found.effects[place + 1 :])
            if effects in known:
                continue
            problem = build(context.records, effects)
            known_rows = problem.layout.own_states.start
            local = np.zeros((problem.layout.n_run, len(context.records.runs)))
            local[:known_rows] = found.optimum.local[:known_rows]
            values = np.concatenate([shared[: own.start], [level], shared[own.stop :]])
            fitted = minimize(problem, values, local, tolerance=context.tolerance, iterations=30)
            simpler = None if fitted is None else candidate(context, effects, fitted)
            if simpler is not None and simpler.evidence < found.evidence + STRONG:
                out.append(simpler)
    return out


def _place(found: Candidate, number: int) -> slice:
    """Where an effect's parameters stand among the shared ones."""
    return found.optimum.problem.layout.values[number]


def _fade(context: FitContext, found: Candidate, dropped: int) -> Candidate | None:
    """Fit a combination without one effect, which first fades while the others adapt."""
    return _drop(context, found, dropped, _FADING)


def _again(context: FitContext, found: Candidate, dropped: int) -> Candidate | None:
    """Race a combination without one effect anew: from where it stands, at every phase of what has one."""
    own = _place(found, dropped)
    values = tuple(float(v) for v in found.optimum.shared[own])
    moved = _moved(found.optimum, own, np.array(found.effects[dropped].faint(values, 0.0))).shared
    n = found.optimum.problem.layout.linear.stop
    rest = [(e, moved[_place(found, i)]) for i, e in enumerate(found.effects) if i != dropped]
    starts = []
    for turn in np.arange(_TURNS) * 2 * np.pi / _TURNS:
        turned = [tuple(v + turn * (q.unit == "rad") for v, q in zip(w, e.parameters, strict=True)) for e, w in rest]
        starts.append(Start(moved[:n], tuple(turned)))
    contender = Contender(context, tuple(e for e, _ in rest))
    contender.begin(starts, like=context.outline)
    contender.run(laps=20)
    return polish(context, contender)


def _drop(context: FitContext, found: Candidate, dropped: int, shares: tuple[float, ...] = ()) -> Candidate | None:
    """Fit a combination without one effect, which may first fade to `shares` of itself while the others adapt."""
    optimum = found.optimum
    of = optimum.problem.layout
    own = _place(found, dropped)
    values = tuple(float(v) for v in optimum.shared[own])
    for share in shares:
        shared, local, _ = _moved(optimum, own, np.array(found.effects[dropped].faint(values, share)))
        free = optimum.problem.free.copy()
        free[own] = False
        held = replace(optimum.problem, free=free)
        faded = minimize(held, shared, local, tolerance=context.tolerance, iterations=8)
        if faded is None:
            return None
        optimum = faded
    shared, moved, _ = _moved(optimum, own, np.array(found.effects[dropped].faint(values, 0.0)))
    rest = tuple(e for place, e in enumerate(found.effects) if place != dropped)
    problem = build(context.records, rest)
    local = np.delete(moved[: of.own_states.start], of.run_values[dropped], axis=0)
    own_states = np.zeros((problem.layout.n_run - len(local), local.shape[1]))  # begin anew
    fewer = minimize(
        problem,
        np.delete(shared, own),
        np.concatenate([local, own_states]),
        tolerance=context.tolerance,
        iterations=20,
    )
    return None if fewer is None else candidate(context, rest, fewer)


class _Moved(NamedTuple):
    """Parameters after a change, and the increase of the cost [m²] that it asks for to first order."""

    shared: Array
    local: Array
    loss: float


def _moved(optimum: Optimum, own: slice, values: Array) -> _Moved:
    """Parameters with those of one effect set, and all others where that change asks for them, to first order."""
    problem = optimum.problem
    jacobian = problem.jacobian(optimum.solved)
    place = np.flatnonzero(problem.free)
    fixed = np.zeros(jacobian.shape[1], dtype=bool)
    fixed[: place.size] = (place >= own.start) & (place < own.stop)
    asked = jacobian[:, fixed] @ (values - optimum.shared[own])[problem.free[own]]
    size = np.linalg.norm(jacobian, axis=0)
    size[size == 0] = np.inf
    scaled = (jacobian / size)[:, ~fixed]
    answer = np.linalg.lstsq(scaled, -asked, rcond=1e-10)[0]
    delta = np.zeros(jacobian.shape[1])
    delta[~fixed] = answer / size[~fixed]
    shared, local = optimum.shared.copy(), optimum.local.copy()
    shared[problem.free] += delta[: place.size]
    shared[own] = values
    local[problem.active] += delta[place.size :]
    left = asked + scaled @ answer
    return _Moved(np.clip(shared, problem.lower, problem.upper), local, float(left @ left))
