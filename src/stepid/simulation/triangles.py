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
    """Write measured minus simulated, each run's rest position fitted, times the weights, m; return its square, m².

    The square is summed in a loop that writes nothing: one that writes is compiled twice, for arrays that may overlap
    and for those that do not, with other orders of the sum, and which is taken depended on where the arrays lie.
    """
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
    for i in range(bounds[0], bounds[-1]):
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
def _set_aside(top: Array, k: int, n: int, root: float, room: Array, rest: Array) -> None:
    """Damp a block's own parameters, and fold what they cannot explain into the triangle of the global ones."""
    m = k + n + 1
    for j in range(m):
        for i in range(k):
            room[j, i] = root if i == j else 0.0
    _fold(top, room, k, m, k)
    for j in range(k, m):
        for i in range(k, m):
            room[j, i] = top[i, j]
    _fold(rest, room[k:], n + 1, n + 1, m)


@compiled
def _solve(top: Array, right: Array, size: int) -> None:
    """Solve an upper triangular system in place."""
    for j in range(size - 1, -1, -1):
        for i in range(j + 1, size):
            right[j] -= top[j, i] * right[i]
        right[j] /= top[j, j]


@compiled
def _decrease(triangle: Array, k: int, step: Array, own_step: Array) -> float:
    """Decrease of the cost by a step, m²."""
    n, out = step.size, 0.0
    for i in range(k + n + 1):
        change = 0.0
        for j in range(k):
            change += triangle[i, j] * own_step[j]
        for j in range(n):
            change += triangle[i, k + j] * step[j]
        out += change * (2.0 * triangle[i, k + n] - change)
    return out


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
    rest, room, tops = np.zeros((n + 1, n + 1)), np.zeros((most, most)), triangles.copy()
    for j in range(n):
        rest[j, j] = root
    for b in range(own.size):
        k, top = own[b], tops[b]
        for j in range(k):
            top[:, j] /= own_size[b, j]
        for j in range(n):
            top[:, k + j] /= size[j]
        _set_aside(top, k, n, root, room, rest)
    step[:] = rest[:n, n]
    _solve(rest, step, n)
    for b in range(own.size):
        k, top = own[b], tops[b]
        for j in range(k):
            own_step[b, j] = top[j, k + n]
            for i in range(n):
                own_step[b, j] -= top[j, k + i] * step[i]
        _solve(top, own_step[b], k)
        for j in range(k):
            own_step[b, j] /= own_size[b, j]
    step /= size
    gain = 0.0
    for b in range(own.size):
        gain += _decrease(triangles[b], own[b], step, own_step[b])
    return gain
