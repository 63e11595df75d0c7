"""How large a fault of one run is: its standard error, the scatter of the other runs, what noise alone leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stepid.core.base import Array
from stepid.core.samples import lagged_products
from stepid.fitting.deviations import applies, promised
from stepid.fitting.levenberg_marquardt import Optimum, Problem
from stepid.simulation.records import Records

REACHED = 1.08  # times the floor, to have explained all
DECIDES = 10.0  # χ² by which one explanation must be the better one


def noise_cost(records: Records, floor: float) -> float:
    """Cost of a fit that leaves nothing but noise, at most [m²]."""
    count = records.weighed_size
    return float(((REACHED + 3.0 / np.sqrt(2.0 * count)) * floor) ** 2 * count)


def noise_level(found: Optimum, floor: float) -> float:
    """Size of the noise [m] that parameters are uncertain by: the residual's, the more so where it is correlated."""
    records, residual = found.problem.records, found.problem.residual(found.solved)
    size = float(np.sqrt(found.cost / records.weighed_size))
    if size <= REACHED * floor:
        return max(size, floor)
    most = max(int(np.diff(records.bounds).min()) // 3, 1)
    rho = np.sum([lagged_products(residual[piece], most) for piece in records.pieces()], axis=0) / found.cost
    return size * float(np.sqrt(1.0 + 2.0 * np.sum(rho**2)))


def standard_error(found: Optimum, plain: Problem, run: int, kind: str, floor: float) -> float:
    """Standard error of a fault's size, in the deviation's unit."""
    without = replace(found, problem=replace(found.problem, active=plain.active))
    promise = promised(without, [(run, kind)]).get((run, kind))
    return np.inf if promise is None else float(promise.errors[run]) * noise_level(found, floor)


def scatter_of_others(found: Optimum, run: int, kind: str) -> float:
    """Standard deviation of the same deviation over the other runs, about the mean of each label."""
    problem = found.problem
    records = problem.records
    row = problem.layout.deviation(kind)
    others = applies(problem, kind)
    others[run] = False
    # each alone, the others as they are: a step to first order
    steps = promised(found, [(int(r), kind) for r in np.flatnonzero(others)])
    values: Array = found.local[row].copy()
    for r in np.flatnonzero(others):
        promise = steps.get((int(r), kind))
        if promise is not None:
            values[r] += promise.values[r]
    groups = {"damping": records.damper, "stiffness": records.spring}.get(kind, np.zeros_like(records.spring))
    squares, freedom = 0.0, 0
    for g in np.unique(groups[others]):
        own = values[others & (groups == g)]
        if own.size > 1:
            squares += float(np.sum((own - own.mean()) ** 2))
            freedom += own.size - 1
    return float(np.sqrt(squares / freedom)) if freedom else 0.0
