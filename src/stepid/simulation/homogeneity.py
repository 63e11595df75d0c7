"""Derivatives that follow from others, because a plant moves alike in any units of length, time and mass.

By Euler's theorem on homogeneous functions, with bᵢ the power of a unit in pᵢ:
measured with lengths λ times as long, a plant moves λ times as far, Σ bᵢ pᵢ ∂x/∂pᵢ = x;
with times λ times as long, where nothing drives or shakes it, λ times as slowly, Σ bᵢ pᵢ ∂x/∂pᵢ = −t v;
with masses λ times as large, and with them all forces, as before, Σ bᵢ pᵢ ∂x/∂pᵢ = 0.
Up to three derivatives of each run need no simulation.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.simulation.layout import Index, ParameterLayout
from stepid.simulation.magnitudes import lengths, masses, times

Mask = npt.NDArray[np.bool_]

_NOTABLE = 0.1  # of the motion that a parameter must make up, or a small difference of large numbers would be left


class Following(NamedTuple):
    """What follows from what, by lengths first, then by times and by masses.

    Parameters
    ----------
    spared : array of bool, shape (P + Q, R)
        Derivatives that need no simulation.
    row : array of int, shape (3, R)
        Parameter whose derivative follows in each run, -1 where none does.
    weight : array, shape (3, R, P + Q)
        By how much each parameter changes with the unit.
    """

    spared: Mask
    row: Index
    weight: Array


class Homogeneity:
    """Which derivatives follow from others for one structure of plant.

    Parameters
    ----------
    layout : ParameterLayout
    scale : float
        m, typical displacement.
    """

    def __init__(self, layout: ParameterLayout, scale: float) -> None:
        self._layout, self._scale = layout, scale
        self._parameters = tuple(q for e in layout.effects for q in e.parameters)
        self._told = all(e.own_units is not None for e in layout.effects)
        own = [unit for e in layout.effects for unit in e.own_units or ()]
        self._own_mass = np.array([unit == "N" for unit in own], dtype=float)
        self._own_time = -np.array(["/s" in unit for unit in own], dtype=float) - 2.0 * self._own_mass
        self._shaken = any(e.never_rests for e in layout.effects)  # by a law of the clock, which starts when it likes
        self._moves = np.array([type(e).reading is Effect.reading for e in layout.effects for _ in e.parameters], bool)
        self._touched = np.zeros((layout.n_global, len(layout.records.runs)), dtype=bool)
        for p in range(layout.n_global):
            self._touched[p, layout.touched(p)] = True

    def following(self, shared: Array, local: Array, wanted: Mask, active: Mask, *, flow: bool) -> Following:
        """Tell which of the wanted derivatives follow from the others; with `flow` those by times, too."""
        of, runs = self._layout, np.arange(local.shape[1])
        n, gain, base = of.n_global, of.force_gain, of.records.base
        asked = np.concatenate([self._touched & wanted[:, None], active])
        pushed = of.records.largest_input
        driven = pushed > 0
        at = np.where(self._touched, shared[:, None], 0.0).T
        at[~driven, gain] = 0.0
        own, effects = slice(n + of.own_states.start, n + of.own_states.stop), slice(of.linear.stop, n)
        states = local[of.own_states].T
        weight = np.zeros((3, runs.size, asked.shape[0]))
        by_length, by_time, by_mass = weight
        by_length[:, gain] = by_mass[:, gain] = at[:, gain]
        by_length[:, effects] = lengths(self._parameters, shared[effects])
        by_length[:, n : n + 2], by_length[:, own] = local[:2].T, states
        by_time[:, of.stiffness], by_time[:, of.damping] = -2.0 * at[:, of.stiffness], -at[:, of.damping]
        by_time[:, effects] = times(self._parameters, shared[effects]) * self._moves
        by_time[:, n + 1], by_time[:, own] = -local[1], states * self._own_time
        by_mass[:, of.stiffness], by_mass[:, of.damping] = at[:, of.stiffness], at[:, of.damping]
        by_mass[:, effects] = masses(self._parameters, shared[effects])
        by_mass[:, own] = states * self._own_mass
        missing = ((weight != 0.0) & ~asked.T).any(axis=2)
        spring = of.stiffness.start + of.records.spring
        notable = _NOTABLE * self._scale
        by_gain = asked[gain] & (np.abs(at[:, gain]) * pushed > notable * np.abs(at[runs, spring]))
        by_start = asked[n] & (np.abs(local[0]) > notable)
        row = np.empty((3, runs.size), dtype=np.intp)
        row[0] = np.where(by_gain, gain, np.where(by_start, n, -1))
        row[1] = np.where(asked[spring, runs] & ~driven & (flow and not self._shaken), spring, -1)
        row[2] = np.where(asked[base, runs], base, -1)
        row[missing | (not self._told)] = -1
        by_mass[runs, base] = of.mass(shared) + local[of.deviation("added_mass")]
        spared = np.zeros_like(asked)
        spared[gain] = ~driven  # without input it does nothing
        for rows in row:
            spared[rows[rows >= 0], runs[rows >= 0]] = True
        return Following(spared, row, weight)
