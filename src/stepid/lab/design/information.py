"""What each run says of the parameters: Fisher information of the joint fit, run by run, and what runs say together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.mass_offset import weight_parts
from stepid.effects.base import Effect
from stepid.errors import ConvergenceError
from stepid.fitting.levenberg_marquardt import Problem
from stepid.fitting.problem import build
from stepid.lab.design.candidate import Step, record
from stepid.simulation.model import PlantModel
from stepid.simulation.records import Records, lay_out
from stepid.simulation.simulate import pack
from stepid.simulation.simulator import PATIENT, Simulator, Solved

_OPEN = 1e-10  # share of the largest eigenvalue, below which the runs leave a direction open


@dataclass(frozen=True)
class Point:
    """A plant simulated on some records, which hold its readings, ready for derivatives."""

    problem: Problem
    solved: Solved
    shared: Array
    local: Array

    @property
    def records(self) -> Records:
        """The records."""
        return self.problem.records


def lay_out_steps(steps: Sequence[Step], plant: PlantModel, duration: float) -> Records:
    """Lay out the records of some runs, without readings."""
    runs = tuple(record(step, plant, duration, f"step {i}") for i, step in enumerate(steps))
    return lay_out(Campaign(name="steps", experiments=runs))


def simulated(plant: PlantModel, effects: tuple[Effect, ...], records: Records) -> Point:
    """Simulate a plant on records, which take its readings.

    Raises
    ------
    stepid.errors.ConvergenceError
        If the plant runs away.
    """
    shared, local = pack(plant, records, effects)
    reading = Simulator(records, effects, patience=PATIENT).readings(shared[None], local[None])[0]
    problem = build(replace(records, position=reading), effects) if np.isfinite(reading).all() else None
    solved = problem.solve(shared, local) if problem is not None else None
    if problem is None or solved is None:
        raise ConvergenceError(
            "the guessed plant runs away under these steps",
            "Give smaller levels or effects: a softening spring or a negative damping has no bounded response.",
        )
    return Point(problem, solved, shared, local)


def information(point: Point, signal: Array | None = None) -> list[Array]:
    """Information of each run about the free shared parameters, for noise of 1 m; its own parameters are eliminated.

    Parameters
    ----------
    point : Point
    signal : array, shape (S,), optional
        m, a residual that is taken in as one more parameter, the last.

    Returns
    -------
    list of array, shape (n, n)
    """
    n = int(point.problem.free.sum())
    out = []
    for piece, columns, rows in point.problem.blocks(point.solved):
        table = np.nan_to_num(rows, copy=False, posinf=0.0, neginf=0.0)
        if signal is not None:
            table = np.vstack([table, signal[piece]])
        own = columns.size - n
        triangle = np.asarray(np.linalg.qr(table.T, mode="r"))[own:, own:]
        out.append(triangle.T @ triangle)
    return out


def inverted(matrix: Array) -> tuple[Array, Array]:
    """Inverse of an information, and which parameters it leaves open, shape (n,)."""
    size = np.sqrt(np.diag(matrix))
    size[size == 0] = 1.0
    values, axes = np.linalg.eigh(matrix / size / size[:, None])
    usable = values > _OPEN * values[-1]
    inverse = (axes * np.where(usable, 1 / np.where(usable, values, 1.0), 0.0)) @ axes.T
    open_ = np.abs(axes[:, ~usable]).max(axis=1, initial=0.0) > 1e-3
    return inverse / size / size[:, None], open_


def with_weights(tables: Sequence[Array], parts: Array, variance: float) -> Array:
    """Information of all runs about n parameters and k errors of weights, these with unit variance, shape (n+k, n+k).

    Parameters
    ----------
    tables : sequence of array, shape (n, n)
        Of each run, for noise of 1 m; the first parameter is the base mass, as which an added mass acts.
    parts : array, shape (R, k)
        From `stepid.core.mass_offset.weight_parts`.
    variance : float
        m², of the noise.
    """
    n, k = tables[0].shape[0], parts.shape[1]
    out = np.zeros((n + k, n + k))
    for table, part in zip(tables, parts, strict=True):
        both = np.vstack([np.eye(n), np.outer(part, np.eye(n)[0])])
        out += both @ (table / variance) @ both.T
    out[n:, n:] += np.eye(k)
    return out


def covariances(
    steps: Sequence[Step], known: Mapping[Step, Array], *, variance: float, weight_uncertainty: float
) -> tuple[Array, Array, Array]:
    """Covariance from noise and from the weights, shapes (n, n), and which parameters stay open, shape (n,).

    The weights' errors are parameters with a prior, as in `stepid.fit`.

    Parameters
    ----------
    steps : sequence of Step
    known : mapping
        Information of each run, for noise of 1 m.
    variance : float
        m², of the noise.
    weight_uncertainty : float
        kg, of a weight of 500 g.
    """
    parts = weight_parts(np.array([step.added_mass for step in steps]), weight_uncertainty)
    tables = [known[step] for step in steps]
    n = tables[0].shape[0]
    inverse, open_ = inverted(with_weights(tables, parts, variance))
    weights = inverse[:n, n:] @ inverse[n:, :n]
    return inverse[:n, :n] - weights, weights, open_[:n]
