"""Linear least squares run by run: derivatives reduced to triangles, and damped steps from these.

The samples of a run go by in chunks that Householder reflections fold into an upper triangle (Golub and Van Loan,
Matrix Computations, 5.2): as exact as a QR factorization of all samples, and no room for more than a chunk. The columns
of a triangle are the run's own parameters, the global ones, and the residual.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stepid.simulation.compiled import compiled, compiled_sums
from stepid.simulation.simulator import STEEPEST

Array = Any  # numba knows the types

_CHUNK = 64  # samples


@compiled_sums
def _fold(triangle: Array, rows: Array, pivots: int, size: int, count: int) -> None:
    """Fold rows (size, count), column by column, into an upper triangle until their first `pivots` columns are zero."""
    for j in range(pivots):
        x = rows[j]
        square = 0.0
        for i in range(count):
            square += x[i] * x[i]
        if square == 0.0:
            continue
        head = triangle[j, j]
        length = np.sqrt(head * head + square)
        if head > 0.0:
            length = -length
        lead = head - length
        triangle[j, j] = length
        for k in range(j + 1, size):
            y = rows[k]
            total = lead * triangle[j, k]
            for i in range(count):
                total += x[i] * y[i]
            share = total / (length * lead)
            triangle[j, k] += lead * share
            for i in range(count):
                y[i] += x[i] * share


@compiled_sums
def weigh(position: Array, reading: Array, weight: Array, bounds: Array, out: Array) -> float:
    """Write measured minus simulated, each run's rest position fitted, times the weights, m; return its square, m²."""
    cost = 0.0
    for r in range(bounds.size - 1):
        total, mean = 0.0, 0.0
        for i in range(bounds[r], bounds[r + 1]):
            square = weight[i] * weight[i]
            total += square
            mean += square * (position[i] - reading[i])
        mean /= total
        for i in range(bounds[r], bounds[r + 1]):
            out[i] = (position[i] - reading[i] - mean) * weight[i]
            cost += out[i] * out[i]
    return cost


@compiled
def _row(shared: Array, local: Array, column: int) -> Array:
    return shared[column] if column < shared.shape[0] else local[column - shared.shape[0]]


@compiled_sums
def _fold_run(
    shared: Array, local: Array, columns: Array, residual: Array, weight: Array, begin: int, end: int, triangle: Array
) -> None:
    """Fold the samples of a run into its triangle, the mean that its rest position takes away left out."""
    count = columns.size
    means, room = np.zeros(count), np.empty((count + 1, _CHUNK))
    total = 0.0
    for i in range(begin, end):
        total += weight[i] * weight[i]
    for c in range(count):
        row, mean = _row(shared, local, columns[c]), 0.0
        for i in range(begin, end):
            mean += weight[i] * weight[i] * row[i]
        means[c] = mean / total
    for first in range(begin, end, _CHUNK):
        n = min(_CHUNK, end - first)
        for c in range(count):
            row, mean, place = _row(shared, local, columns[c]), means[c], room[c]
            for i in range(n):
                place[i] = (row[first + i] - mean) * weight[first + i]
        for i in range(n):
            room[count, i] = residual[first + i]
        _fold(triangle, room, count + 1, count + 1, n)


@compiled
def reduce_runs(
    shared: Array,
    local: Array,
    residual: Array,
    weight: Array,
    bounds: Array,
    columns: Array,
    own: Array,
    block: Array,
    triangles: Array,
    size: Array,
    own_size: Array,
    pull: Array,
) -> bool:
    """Reduce every run to a triangle; false where a derivative is not finite, or too steep to be squared.

    Parameters
    ----------
    shared, local : arrays, shape (P, S) and (Q, S)
        Derivatives of the reading by the global and the per-run parameters.
    residual : array, shape (S,)
        m, weighted, see `weigh`.
    weight : array, shape (S,)
        Square roots of the samples' weights.
    bounds : array of int, shape (R + 1,)
        Where each run's samples begin and end.
    columns : array of int, shape (R, M)
        Rows of each run's columns among the two: its own parameters, then the global ones.
    own : array of int, shape (R,)
        Number of own parameters; n global ones follow.
    block : array of int, shape (R,)
        Triangle of each run; runs without own parameters may share one.
    triangles : array, shape (B, M + 1, M + 1)
        Written; zero before.
    size, own_size : arrays, shape (n,) and (B, M - n)
        Written: sums of squares of the columns; zero before.
    pull : array, shape (n,)
        Written: half of the decrease of the cost by each global parameter, m² a unit; zero before.
    """
    n = size.size
    for r in range(own.size):
        count = own[r] + n
        triangle = triangles[block[r]]
        _fold_run(shared, local, columns[r, :count], residual, weight, bounds[r], bounds[r + 1], triangle)
        for i in range(count + 1):
            for j in range(i, count + 1):
                if not abs(triangle[i, j]) < STEEPEST:
                    return False
    sizes = np.zeros(triangles.shape[0], dtype=np.int64)
    sizes[block] = own
    for b in range(sizes.size):
        k, triangle = sizes[b], triangles[b]
        for i in range(k + n):
            for j in range(i, k):
                own_size[b, j] += triangle[i, j] ** 2
            for j in range(n):
                size[j] += triangle[i, k + j] ** 2
                pull[j] += triangle[i, k + j] * triangle[i, k + n]
    return True


@compiled
def damped_step(
    triangles: Array, own: Array, damping: float, size: Array, own_size: Array, step: Array, own_step: Array
) -> float:
    """Write the damped step of the global parameters and of each block's own; return the decrease that it promises, m².

    Parameters
    ----------
    triangles : array, shape (B, M + 1, M + 1)
        From `reduce_runs`.
    own : array of int, shape (B,)
        Number of own parameters of each block.
    damping : float
        Of steps in units of the columns' sizes.
    size, own_size : arrays, shape (n,) and (B, M - n)
        Sizes of the columns; infinite for parameters that stay.
    step, own_step : arrays, shape (n,) and (B, M - n)
        Written.
    """
    n, root, most = size.size, np.sqrt(damping), triangles.shape[1]
    rest, room = np.zeros((n + 1, n + 1)), np.zeros((most, most))
    for j in range(n):
        rest[j, j] = root
    tops = np.empty(triangles.shape)
    for b in range(own.size):
        k, m = own[b], own[b] + n + 1
        top = tops[b]
        for i in range(m):
            for j in range(m):
                top[i, j] = triangles[b, i, j]
                if j < k:
                    top[i, j] /= own_size[b, j]
                elif j < m - 1:
                    top[i, j] /= size[j - k]
        room[:m, :k] = 0.0
        for j in range(k):
            room[j, j] = root
        _fold(top, room, k, m, k)
        for j in range(k, m):
            for i in range(k, m):
                room[j, i] = top[i, j]
        _fold(rest, room[k:], n + 1, n + 1, m)
    for j in range(n - 1, -1, -1):
        total = rest[j, n]
        for i in range(j + 1, n):
            total -= rest[j, i] * step[i]
        step[j] = total / rest[j, j]
    gain = 0.0
    for b in range(own.size):
        k, m = own[b], own[b] + n + 1
        for j in range(k - 1, -1, -1):
            total = tops[b, j, m - 1]
            for i in range(j + 1, k):
                total -= tops[b, j, i] * own_step[b, i]
            for i in range(n):
                total -= tops[b, j, k + i] * step[i]
            own_step[b, j] = total / tops[b, j, j]
        for i in range(m):
            change = 0.0
            for j in range(i, k):
                change += triangles[b, i, j] * own_step[b, j] / own_size[b, j]
            for j in range(n):
                change += triangles[b, i, k + j] * step[j] / size[j]
            gain += change * (2.0 * triangles[b, i, m - 1] - change)
        for j in range(k):
            own_step[b, j] /= own_size[b, j]
    for j in range(n):
        step[j] /= size[j]
    return gain
