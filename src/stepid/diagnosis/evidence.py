"""What a candidate earns, on one scale, whether or not the noise floor is in reach: QBIC and its weights."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.samples import lagged_products
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.selection.candidate import Candidate, is_free
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.mean_of_runs import starts_late
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import block_mean_deviate, von_neumann_ratio
from stepid.fitting.random_effects import price_of_scatter
from stepid.simulation.records import Records


def effective_samples(records: Records, residual: Array) -> Array:
    """Effective number of independent samples of each run's residual, shape (R,).

    n/(1 + 2 Σρ²) over the lags below a third of the samples (Bartlett 1946), less what white noise shows by chance.
    Of a sample that weighs less than one n counts its weight; the mean of several is one.

    Parameters
    ----------
    records : Records
    residual : array, shape (S,)
        Weighted, m.
    """
    out, counted = np.empty(len(records.runs)), np.minimum(records.weight**2, 1.0)
    for r, piece in enumerate(records.pieces()):
        y, counts = residual[piece] - residual[piece].mean(), counted[piece]
        n = float(counts.sum())
        power = float(y @ y)
        if power <= 0 or n < 2:
            out[r] = n
            continue
        most = max(2, y.size // 3)
        lags = lagged_products(y, most) / power
        chance = lagged_products(counts, most) / n**2 / (1.0 - np.arange(1, most) / y.size)  # 1/n of equal weights
        out[r] = n / (1.0 + 2.0 * max(0.0, float(np.sum(lags**2 - chance))))
    return np.maximum(out, 2.0)


def price(optimum: Optimum, counts: Array, variance: float) -> float:
    """Price of the free parameters: ln of the effective samples that each of them is fitted to.

    What differs from run to run costs by how much it differs; see `price_of_scatter`.

    Parameters
    ----------
    optimum : Optimum
    counts : array, shape (R,)
        Effective samples of each run.
    variance : float
        m², of what the best fit leaves.
    """
    problem = optimum.problem
    own = problem.active.sum(axis=0) - problem.active[problem.layout.deviations].sum(axis=0)
    own = own * np.log(np.maximum(counts, 2.0))
    shared = float(problem.free.sum()) * math.log(float(counts.sum()))
    return shared + float(np.sum(own)) + price_of_scatter(optimum, counts, variance)


def less_likely_by(
    context: FitContext, other: Optimum, best: Optimum, *, cost: float | None = None, more: int = 0
) -> float:
    """QBIC by which a fit is less likely than the best, by the samples that are effective in what the best leaves.

    Parameters
    ----------
    context : FitContext
    other, best : Optimum
    cost : float, optional
        m², what the other leaves with parameters of another kind free; its own cost where it is not given.
    more : int
        Such parameters.
    """
    qbic = qbic_by(context, best)
    return qbic(other, cost, more) - qbic(best)


def qbic_by(context: FitContext, best: Optimum) -> Callable[..., float]:
    """QBIC of a fit above the best's cost, of what it leaves [m²] and with more parameters where these are given.

    N ln cost + price, N the effective samples of the best's residual. What is less than the sensor's rounding leaves is
    no evidence.
    """
    records, least = context.records, max(context.rounding_cost, np.finfo(float).tiny)
    counts = effective_samples(records, best.problem.residual(best.solved))
    samples, lowest = float(counts.sum()), max(best.cost, least)
    variance = lowest / records.weighed_size
    known: dict[Optimum, float] = {}  # a search asks of the same fits again and again

    def qbic(fit: Optimum, cost: float | None = None, more: int = 0) -> float:
        left = max(fit.cost if cost is None else cost, least)
        if fit not in known:
            known[fit] = price(fit, counts, variance)
        return samples * math.log(left / lowest) + known[fit] + more * math.log(samples)

    return qbic


class Weighed(NamedTuple):
    """A candidate with its QBIC, less the least of all, and its weight among all."""

    candidate: Candidate
    loss: float
    weight: float


def weigh(context: FitContext, candidates: Sequence[Candidate]) -> list[Weighed]:
    """Rank candidates by QBIC = N ln cost + price, N the effective samples of the best one's residual; best first.

    Where the best leaves white noise this is the usual BIC with the noise estimated; where it does not, the residual's
    own correlation says how few independent samples there are (Burnham and Anderson 2002, section 2.5). What is less
    than the sensor's rounding leaves is no evidence.
    """
    best = min(candidates, key=lambda c: c.optimum.cost)
    scores = list(map(qbic_by(context, best.optimum), (c.optimum for c in candidates)))
    lowest = min(scores)
    raw = [math.exp(-0.5 * min(s - lowest, 1400.0)) for s in scores]
    found = [Weighed(c, s - lowest, w / math.fsum(raw)) for c, s, w in zip(candidates, scores, raw, strict=True)]
    return sorted(found, key=lambda w: w.loss)


def chosen_at(criteria: Criteria, found: Candidate) -> float:
    """What effects and conditions cost where an answer is chosen, in QBIC: each must earn more than chance does.

    Start times that are all as late are two conditions: what they share is a delay, and no scatter.
    """
    late = bool(found.deviations) and starts_late(found.optimum)
    return criteria.further * (found.complexity + late)


def at_floor(context: FitContext, criteria: Criteria, found: Candidate) -> bool:
    """Tell whether a fit leaves nothing but noise, whose size is known to some per cent only.

    One with an effect that is free in every run has to reach the floor.
    """
    times, chance = found.optimum.rms / context.floor, 2.0 / math.sqrt(context.records.weighed_size)
    if is_free(found) and times > criteria.floor + chance:
        return False
    if found.optimum.rms <= context.rounding:
        return True
    if context.colored is not None:  # its size is known less well, and it is not white
        return times <= criteria.near
    if found.structure >= criteria.white or times > criteria.near + chance:
        return False
    return times <= criteria.floor + chance or is_white(context, found, 2.0)


def is_white(context: FitContext, found: Candidate, deviations: float) -> bool:
    """Tell whether a residual is as white as noise of its own size, within so many standard deviations."""
    ratio, count = von_neumann_ratio(context.records, found.optimum.residual)
    return ratio < 1.0 + deviations / math.sqrt(max(count, 1))


def block_means(context: FitContext, optimum: Optimum) -> float:
    """Standard deviations by which a residual's means over blocks exceed those of white noise of the floor's size."""
    return block_mean_deviate(context.records, optimum.problem.residual(optimum.solved), context.floor, context.period)


def bought_by_freedom(
    context: FitContext, candidates: Iterable[Candidate], simple: Candidate, general: Candidate
) -> float:
    """χ² that a general law takes of what the simple one inside leaves, the same conditions free where that is known.

    What conditions that are free take is not the law's.
    """
    as_free = [c.optimum.cost for c in candidates if c.key == (simple.key[0], general.deviations)]
    return float(min([simple.optimum.cost, *as_free]) - general.optimum.cost) / context.floor**2


def part_left(before: float, after: float, noise: float = 0.0) -> float:
    """Part of a power above the noise that is left afterwards, m² or any unit; all of it where there was none."""
    whole = before - noise
    return max(after - noise, 0.0) / whole if whole > 0 else 1.0


def predicts(criteria: Criteria, count: int, taken: tuple[float, float]) -> bool:
    """Tell whether so many effects lead by the share that they take on runs left out, and by its steadiness."""
    share, steady = taken
    return share >= least_share(criteria, count) and steady >= criteria.steady


def least_share(criteria: Criteria, count: int) -> float:
    """Share of the misfit that so many effects have to take to lead: each further one halves what may be left."""
    return 1.0 - (1.0 - criteria.lead) * 0.5 ** (count - 1)
