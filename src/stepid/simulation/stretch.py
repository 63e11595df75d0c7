"""Many plants at once on a stretch without events: where they are at any moment of it."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.simulation.exact import FullStep, Index, exponential
from stepid.simulation.law import Lanes, Law
from stepid.simulation.series import along, series
from stepid.simulation.substeps import substeps


class Stretch:
    """Lanes from given states on, each in a regime that lasts: direction, sides, held by friction or not.

    Parameters
    ----------
    law : Law
    table : array, shape (n_rows, lanes)
    z : array, shape (n_states, lanes)
        States at its start.
    elapsed, left : arrays, shape (lanes,)
        s, since the step began, and until it ends.
    sign, moving : arrays, shape (lanes,)
        Direction of motion; 1.0 where the cart moves, 0.0 where friction holds it.
    sides : array, shape (n_sides, lanes)
    full : FullStep, optional
        Of affine laws: their paths are series.
    group : array of int, shape (lanes,), optional
        Which of the plants of `full` each lane is.
    """

    def __init__(
        self,
        law: Law,
        table: Array,
        z: Array,
        elapsed: Array,
        left: Array,
        sign: Array,
        sides: Array,
        moving: Array,
        full: FullStep | None = None,
        group: Index | None = None,
    ) -> None:
        self.law, self.table, self.z, self.elapsed, self.left = law, table, z, elapsed, left
        self.sign, self.sides, self.moving = sign, sides, moving
        self.full, self.group = full, group
        self._terms: Array | None = None
        self._begun = False

    def take(self, index: Index) -> Stretch:
        """The same of some lanes."""
        group = None if self.group is None else self.group[index]
        part = Stretch(
            self.law,
            self.table[:, index],
            self.z[:, index],
            self.elapsed[index],
            self.left[index],
            self.sign[index],
            self.sides[:, index],
            self.moving[index],
            self.full,
            group,
        )
        part._begun = self._begun
        part._terms = None if self._terms is None else self._terms[:, :, index]
        return part

    def at(self, time: Array) -> Array:
        """States so long [s] after the start, shape (n_states, lanes)."""
        return self.onward(self.z, 0.0, time)

    def onward(self, z: Array, since: Array | float, time: Array) -> Array:
        """States so long [s] after the start, from those at an earlier moment: affine plants need them not."""
        if self.full is None or self.group is None:
            elapsed, length = self.elapsed + since, time - since
            return substeps(self.law, self.table, z, elapsed, length, self.sign, self.sides, self.moving)
        if self.terms is not None:
            return self.z + along(self.terms, time)
        mean = exponential(np.moveaxis(self._slope() * time, 2, 0))[1]
        out: Array = self.z + np.einsum("sij,js->is", mean, self.rates(self.z, 0.0) * time)
        return out

    def rates(self, z: Array, time: Array | float) -> Array:
        """Rates of change of states so long after the start, shape (n_states, lanes); memories have none."""
        out = np.zeros_like(z)
        Lanes(self.law, self.table, self.sides).rates(z, self.sign, self.elapsed + time, out[: self.law.n_rates])
        out[:2] *= self.moving
        return out

    @property
    def terms(self) -> Array | None:
        """Coefficients of the lanes' series, see `stepid.simulation.series`; None where they have none."""
        if not self._begun and self.full is not None and self.group is not None:
            self._terms = series(self._slope(), self.rates(self.z, 0.0), self.left)
        self._begun = True
        return self._terms

    def _slope(self) -> Array:
        assert self.full is not None
        assert self.group is not None
        slope = self.full.slope(self.group, self.sides)
        slope[:2] *= self.moving
        return slope
