"""A law of any shape: what a force of position or velocity, or a spring, damping or drive that changes, takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.diagnosis.constancy import CONDITIONS, by_condition, scatter_columns
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import effective_samples
from stepid.diagnosis.free_forces import free_forces
from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.covariance import at_bound
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.score_test import responses_along
from stepid.simulation.records import Records
from stepid.simulation.simulator import COARSE, Simulator, Solved

_OPEN = 1e-6  # singular value of a direction that the data leave open


class FreeLaw(NamedTuple):
    """What a law of any shape takes: of which state, the share of the rest, and that much power, m².

    `beyond` is what chance does not: a normal deviate as rare as the F ratio of what the law takes to what it leaves,
    or to the noise where that is more. `own` laws are of an effect of the fit itself, and no other force: its
    overtones, or its parameters where they are not the same in all conditions.
    `changes` says by which share of it each effect's size, its first parameter, changes where the law stands beside it.
    """

    state: str
    share: float
    power: float
    beyond: float = 0.0
    own: bool = False
    changes: tuple[float, ...] = ()

    def is_seen(self, beyond: float, rough: float) -> bool:
        """Tell whether it takes most of a rest that may be rough, or more than chance does; see `allowed`."""
        return bool(rough and self.share > 0.5) or self.beyond > beyond

    @property
    def states(self) -> frozenset[str]:
        """As `stepid.diagnosis.states.states_of` an effect has them."""
        return frozenset(self.state.split(" and "))


def free_laws(context: FitContext, optimum: Optimum, records: Records | None = None) -> tuple[FreeLaw, ...]:
    """Find what laws of any shape take of a fit's rest, each piecewise linear and free.

    A force of position or of velocity; a damping that depends on position or time; a spring that does on time; a drive
    that does on position, velocity or time; memories of position or input, that fade at rates of any mixture. Overtones
    of the fit's periodic effects are a law each, and so are parameters of its effects that are not the same in all
    conditions (`stepid.diagnosis.constancy`).

    The fitted plant is pushed by each piece along its own trajectory; the responses, and those to the fit's own
    parameters, are fitted to the residual. A share is corrected for the number of coefficients (adjusted coefficient of
    determination), by the effective samples of the residual.

    Parameters
    ----------
    context : FitContext
    optimum : Optimum
        Of the candidate, on all samples.
    records : Records, optional
        The samples that are asked: the context's decimated ones by default, or all of its records.

    Returns
    -------
    tuple of FreeLaw
        One for each state, then those of overtones and of the conditions; nothing is taken where the plant runs away.
    """
    records = records or context.decimated
    for asked, within, laws in context.laws:
        if asked is optimum and within is records:
            known: tuple[FreeLaw, ...] = laws
            return known
    found = _free_laws(context, optimum, records)
    context.laws.append((optimum, records, found))
    return found


def _free_laws(context: FitContext, optimum: Optimum, records: Records) -> tuple[FreeLaw, ...]:
    asked = _Asked.of(context, optimum, records)
    if asked is None:
        return (FreeLaw("position", 0.0, 0.0),)
    left, found = asked.left(asked.known), []
    laws = free_forces(context, optimum)
    for (state, _, own), pushed in zip(laws, asked.pushed([some for _, some, _ in laws]), strict=True):
        changes = _changes(optimum, asked.place, np.hstack([asked.known, pushed]), asked.residual)
        found.append(left.taken_by(pushed, state, own, changes))
    varied = by_condition(optimum, asked.place, asked.known, records)
    if varied.size:
        scattered = np.hstack([asked.known, scatter_columns(asked.fit)])
        found.append(asked.left(scattered).taken_by(varied, CONDITIONS, True))
    return tuple(found)


def beside(context: FitContext, optimum: Optimum, one: FreeLaw, other: FreeLaw) -> tuple[FreeLaw, FreeLaw]:
    """What each of two of `free_laws` takes of what the other leaves.

    A force that is missing changes the whole motion: laws of every state follow some of it.
    """
    asked = _Asked.of(context, optimum, context.decimated)
    forces = {(state, own): some for state, some, own in free_forces(context, optimum)}
    laws = one, other
    both = [forces[law.state, law.own] for law in laws if (law.state, law.own) in forces]
    if asked is None or len(both) < 2:
        return laws
    pushed = asked.pushed(both)

    def taken(law: FreeLaw, columns: Array, leaving: Array) -> FreeLaw:
        left = asked.left(np.hstack([asked.known, leaving]))
        return left.taken_by(columns, law.state, law.own, law.changes)

    return taken(one, *pushed), taken(other, *reversed(pushed))


class _Asked(NamedTuple):
    """A fit's rest on some samples, and what changes it."""

    context: FitContext
    fit: Optimum  # solved on these samples
    along: Optimum  # the same, as it went along all of them
    residual: Array
    known: Array  # the Jacobian, but for what is at a bound
    place: Index  # global parameters that its first columns belong to

    @classmethod
    def of(cls, context: FitContext, optimum: Optimum, records: Records) -> _Asked | None:
        """None where the plant runs away."""
        problem = optimum.problem
        solved: Solved | None = optimum.solved
        if records is not problem.records:  # all of them show the error of a coarse simulation
            problem = replace(problem, simulator=Simulator(records, problem.simulator.effects, COARSE))
            solved = problem.solve(optimum.shared, optimum.local)
        if solved is None or not np.isfinite(jacobian := problem.jacobian(solved)).all():
            return None
        free = ~at_bound(optimum)
        place = np.flatnonzero(problem.free)
        along = replace(optimum, problem=problem)
        here = replace(along, solved=solved)
        return cls(context, here, along, problem.residual(solved), jacobian[:, free], place[free[: place.size]])

    def pushed(self, laws: Sequence[Sequence[Array]]) -> list[Array]:
        """Changes of the reading by the forces of some laws, shape (S, n) each."""
        records, forces = self.fit.problem.records, [force for some in laws for force in some]
        responses = responses_along(self.along, records, forces)
        ends = np.cumsum([len(some) for some in laws])
        parts = np.split(records.weighted(responses.T).T, ends[:-1], axis=1)
        return [part[:, np.isfinite(part).all(axis=0)] for part in parts]

    def left(self, known: Array) -> _Left:
        """What the fit leaves beyond what is known to change it."""
        context, records = self.context, self.fit.problem.records
        noise = records.weighed_size * context.floor**2
        noise = context.noise_cost if records is context.decimated else noise
        samples = float(effective_samples(records, self.residual).sum())
        return _Left(self.residual, known, samples, noise, context.floor)


class _Left:
    """What a fit leaves, m, beyond what changes of the reading that are known can do to it."""

    def __init__(self, residual: Array, known: Array, samples: float, noise: float, floor: float) -> None:
        self._own, self._floor = _basis(known), floor
        self._rest = residual - self._own @ (self._own.T @ residual)
        self._square = float(self._rest @ self._rest)
        self._power = self._square - noise
        self._count = samples - self._own.shape[1]

    def taken_by(self, columns: Array, state: str, own: bool, changes: tuple[float, ...] = ()) -> FreeLaw:
        """What further changes of the reading, shape (S, n), take of it."""
        further = columns - self._own @ (self._own.T @ columns)
        law = _basis(further[:, np.linalg.norm(further, axis=0) > _OPEN * np.linalg.norm(columns, axis=0)])
        taken, pieces = float(np.sum((law.T @ self._rest) ** 2)), law.shape[1]
        if not pieces:
            return FreeLaw(state, 0.0, 0.0, 0.0, own, changes)
        spare = max(self._count - pieces, 1.0)
        chance = pieces * (self._square - taken) / spare
        power = max(taken - chance, 0.0)
        share = min(power / self._power, 1.0) if self._power > 0 else 0.0
        noise = max(chance, pieces * self._floor**2)  # readings that rest weigh less
        beyond = _deviate(taken / noise, pieces, spare) if noise > 0 else 0.0
        return FreeLaw(state, share, power, beyond, own, changes)


def followed(context: FitContext, criteria: Criteria, found: Candidate, part: float) -> FreeLaw | None:
    """Law that what is as small as the noise follows by more than `allowed`, None where there is none.

    `part` is that of the misfit's power which conditions leave to its effects.

    Among the decimated samples, which are means of neighbors, it may be chance; then all of them do not tell it. What
    is less than rounding leaves follows the steps of the sensor.
    """
    if found.optimum.rms <= context.rounding:
        return None
    beyond, power = allowed(context, criteria, found, noise=True, part=part)
    seen = [law for law in free_laws(context, found.optimum) if law.beyond > beyond and law.power > power]
    if not seen or all(law.beyond <= beyond for law in free_laws(context, found.optimum, context.records)):
        return None
    return max(seen, key=lambda law: law.beyond)


def allowed(
    context: FitContext, criteria: Criteria, found: Candidate, *, noise: bool, part: float = 1.0
) -> tuple[float, float]:
    """Standard deviations beyond chance, and power [m²], that a law of another shape may take of what is left.

    Real laws are rough, which shows in a rest; what leaves only `noise` has no room for that. Noise that is colored,
    or rounding that nothing dithers, or stands beside runs that differ, is not known well enough to say so, nor what
    chance takes of it.

    A law is rough by a share of the `part` of the misfit that is its to explain: see `LeftOut.part_of_effects`.
    """
    known = not found.deviations and context.colored is None and context.dithered
    beyond = criteria.shape if known else criteria.white
    if noise and known:
        return beyond, 0.0
    return beyond, criteria.rough * part * (context.coarse_linear.cost - context.noise_cost)


def _changes(optimum: Optimum, place: Index, columns: Array, residual: Array) -> tuple[float, ...]:
    """Change of each effect's first parameter in one linearized step, as a share of it.

    `place` are the global parameters that the first columns belong to.
    """
    size = np.linalg.norm(columns, axis=0)
    size[size == 0] = np.inf
    step = np.linalg.lstsq(columns / size, residual, rcond=_OPEN)[0] / size
    of = optimum.problem.layout
    moved = dict(zip(place.tolist(), step, strict=False))
    return tuple(float(moved.get(v.start, 0.0) / (optimum.shared[v.start] or np.inf)) for v in of.values)


def _deviate(ratio: float, pieces: int, spare: float) -> float:
    """Normal deviate that is as rare as an F ratio (Wilson and Hilferty 1931; Abramowitz and Stegun 26.6.15)."""
    up, down = 2 / (9 * pieces), 2 / (9 * spare)
    root = np.cbrt(ratio)
    return float(((1 - down) * root - (1 - up)) / np.sqrt(up + down * root**2))


def _basis(columns: Array) -> Array:
    """Orthonormal basis of columns, each scaled to one."""
    size = np.linalg.norm(columns, axis=0)
    columns = columns[:, size > 0] / size[size > 0]
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    out: Array = left[:, values > _OPEN * values[:1].max(initial=0.0)] if values.size else left
    return out
