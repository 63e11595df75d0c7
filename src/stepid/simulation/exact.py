"""Exact steps of linear plants: matrix exponentials with held input."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.simulation.law import LENGTH, Lanes, Law

Index = npt.NDArray[np.intp]


def exponential(a: Array) -> tuple[Array, Array]:
    """Matrix exponentials of a stack and their integrals, exp(a) and ∫ exp(a s) ds over 0 to 1, shapes (n, d, d).

    Taylor of degree 12 with scaling and squaring.
    """
    norm = float(np.abs(a).sum(axis=2).max(initial=0.0))
    if not math.isfinite(norm):
        return np.full_like(a, np.nan), np.full_like(a, np.nan)
    squarings = max(0, math.ceil(math.log2(norm / 0.25))) if norm > 0 else 0
    b = a / 2.0**squarings
    eye = np.eye(a.shape[1])
    mean = eye + b / 12
    for degree in range(11, 1, -1):
        mean = eye + (b @ mean) / degree
    total = eye + b @ mean
    for _ in range(squarings):
        mean = (mean + total @ mean) / 2
        total = total @ total
    return total, mean


def step_matrices(law: Law, table: Array, sides: Array) -> tuple[Array, Array, Array]:
    """Transition matrix Φ, held-input matrix Γ and A of plants that are affine within a regime.

    Parameters
    ----------
    law : Law
        Affine: within the regime its rates are A z + b.
    table : array, shape (n_rows, lanes)
    sides : array, shape (n_sides, lanes)
        The regime.

    Returns
    -------
    phi, gamma, a : arrays, shape (lanes, d, d)
        z(length) = Φ z(0) + Γ b, b the rates at z = 0; z' = A z + b.
    """
    d, lanes = law.n_states, table.shape[1]
    sign = np.ones(lanes)
    base = offset(law, table, sign, sides)
    held = Lanes(law, table, sides)
    a = np.empty((lanes, d, d))
    for j in range(d):
        z = np.zeros((d, lanes))
        z[j] = 1.0
        out = np.empty((d, lanes))
        a[:, :, j] = (held.rates(z, sign, 0.0, out) - base).T
    length = table[LENGTH][:, None, None]
    phi, mean = exponential(a * length)
    return phi, mean * length, a


def offset(law: Law, table: Array, sign: Array, sides: Array) -> Array:
    """Rates at z = 0 under the held input and the friction of `sign`, shape (d, lanes)."""
    z, out = np.zeros((law.n_states, table.shape[1])), np.empty((law.n_states, table.shape[1]))
    return law.rates(table, z, sign, 0.0, sides, out)


class FullStep:
    """Exact steps of a whole sample for affine laws: one matrix for each plant and regime, shared by all its samples.

    Parameters
    ----------
    law : Law
    plants : array, shape (n_rows, G)
        Lane table of the plants; its LENGTH row is the step.
    """

    def __init__(self, law: Law, plants: Array) -> None:
        self._law = law
        regimes = 2**law.n_sides
        bits = np.repeat(np.arange(regimes), plants.shape[1])
        sides = np.array([np.where(bits >> i & 1, 1.0, -1.0) for i in range(law.n_sides)]).reshape(-1, bits.size)
        self.phi, self.gamma, a = step_matrices(law, np.tile(plants, regimes), sides)
        by_lane = (np.ascontiguousarray(m.transpose(1, 2, 0)) for m in (self.phi, self.gamma, a))
        self._phi, self._gamma, self._slope = by_lane
        self._plants = plants.shape[1]

    def __call__(self, group: Index, table: Array, z: Array, sign: Array, sides: Array) -> Array:
        """Advance every lane (of plant `group`) by its whole step, shape (d, lanes) in and out."""
        group = self._regime(group, sides)
        b = offset(self._law, table, sign, sides)
        out = np.zeros_like(z)
        for i, j in np.ndindex(self._phi.shape[:2]):
            out[i] += self._phi[i, j].take(group) * z[j]
            if j:  # the position's rate is zero at z = 0
                out[i] += self._gamma[i, j].take(group) * b[j]
        return out

    def transition(self, group: Index, sides: Array) -> Array:
        """Φ of lanes over their whole step, shape (d, d, lanes)."""
        return self._phi[:, :, self._regime(group, sides)]

    def slope(self, group: Index, sides: Array) -> Array:
        """A in z' = A z + b of lanes, shape (d, d, lanes)."""
        return self._slope[:, :, self._regime(group, sides)]

    def _regime(self, group: Index, sides: Array) -> Index:
        for i in range(self._law.n_sides):
            group = group + np.where(sides[i] > 0, self._plants << i, 0)
        return group
