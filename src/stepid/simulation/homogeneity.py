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

from stepid.core.base import Array, Index
from stepid.effects.base import Effect
from stepid.simulation.layout import ParameterLayout
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
        self._layout, self._notable = layout, _NOTABLE * scale
        parameters = tuple(q for e in layout.effects for q in e.parameters)
        self._told = all(e.own_units is not None for e in layout.effects)
        self._shaken = any(e.never_rests for e in layout.effects)  # by a law of the clock, which starts when it likes
        moves = [type(e).reading is Effect.reading for e in layout.effects for _ in e.parameters]
        self._touched = np.zeros((layout.n_global, len(layout.records.runs)), dtype=bool)
        for p in range(layout.n_global):
            self._touched[p, layout.touched(p)] = True
        # power of each unit in each parameter: by how much it changes, for a value of one
        n, one, (first, stop) = layout.n_global, np.ones(len(parameters)), (layout.linear.stop, layout.n_global)
        self._powers = np.zeros((3, n + layout.n_run))
        by_length, by_time, by_mass = self._powers
        by_length[layout.force_gain] = by_mass[layout.force_gain] = 1.0
        by_length[first:stop], by_mass[first:stop] = lengths(parameters, one), masses(parameters, one)
        by_time[first:stop] = times(parameters, one) * moves
        by_time[layout.stiffness], by_time[layout.damping] = -2.0, -1.0
        by_mass[layout.stiffness] = by_mass[layout.damping] = 1.0
        own = slice(n + layout.own_states.start, n + layout.own_states.stop)
        units = [unit for e in layout.effects for unit in e.own_units or ()]
        if self._told:
            by_mass[own] = [unit == "N" for unit in units]
            by_time[own] = -np.array(["/s" in unit for unit in units], dtype=float) - 2.0 * by_mass[own]
        by_length[n : n + 2], by_time[n + 1], by_length[own] = 1.0, -1.0, 1.0
        # of N·(s/m)^p, whose exponent stands beside it
        self._exponents = [first + i for i, q in enumerate(parameters) if q.length is None and "^p" in q.unit]

    def following(self, shared: Array, local: Array, wanted: Mask, active: Mask, *, flow: bool) -> Following:
        """Tell which of the wanted derivatives follow from the others; with `flow` those by times, too."""
        from stepid.simulation.slopes import follow_units

        of, records = self._layout, self._layout.records
        powers = self._powers
        if self._exponents:
            powers = powers.copy()
            powers[0, self._exponents] = 1.0 - shared[np.add(self._exponents, 1)]
        asked = np.concatenate([self._touched & wanted[:, None], active])
        out = Following(
            np.zeros_like(asked),
            np.full((3, len(records.runs)), -1, dtype=np.intp),
            np.zeros((3, len(records.runs), len(asked))),
        )
        follow_units(
            powers, shared, np.ascontiguousarray(local), self._touched, asked, records.largest_input, of.force_gain,
            records.base, of.stiffness.start + records.spring, of.mass(shared) + local[of.deviation("added_mass")],
            self._notable, self._told, flow and not self._shaken, *out,
        )  # fmt: skip
        return out
