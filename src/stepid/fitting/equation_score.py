"""How much effects could explain of the equation of motion on the measured motion: for starts only.

A response of the linear plant tells little where the plant moves far from that: under strong friction it has stopped
where the linear plant still swings. The equation holds on the motion as it was measured, while the cart moves: at rest
friction holds it with what it takes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect, Regressor
from stepid.fitting.multistart import FitContext
from stepid.fitting.problem import fixes_mass
from stepid.fitting.score_test import Column, difference, scaled
from stepid.fitting.weak_form import WeakForm

_WIDTHS = (0.45, 0.3, 0.2, 0.15, 0.1)  # of a bump, of the strongest period: the next where few fit into the motion
_OVERLAP = 4.0  # bumps that say as much as one
_FEWEST = 8.0  # independent bumps, less the linear plant's parameters


class EquationOfMotion:
    """The equation of motion along the measured motion, as `stepid.fitting.joint_score.JointScore` takes it.

    Parameters
    ----------
    context : FitContext

    Attributes
    ----------
    width : float
        s, of the bumps that test it.
    samples : float
        Independent bumps, less the linear plant's parameters.
    """

    def __init__(self, context: FitContext) -> None:
        self._context = context
        mass, speed = fixes_mass(context.records), context.motion.v
        for share in _WIDTHS:
            self.width = share * context.period
            self._weak = WeakForm(context.records, self.width, fixed_mass=mass, speed=speed)
            basis, left = self._weak.plain
            self.samples = left.size / _OVERLAP - basis.shape[1]
            if self.samples > _FEWEST:
                break
        self.left = left
        self.directed = self.samples > 0

    def beyond(self, seen: Array) -> Array:
        """The part of tested forces, shape (rows,) or (rows, k), that the linear plant's own cannot follow."""
        return self._weak.beyond(seen)

    def adapted(self, seen: Array) -> Array:
        """Shared parameters of the linear plant beside tested forces, shape (rows,); those fitted where none is one."""
        plant = self._weak.plant_beside(-seen)
        return self._context.coarse_linear.shared if plant is None else plant[0]

    def _regressors(self, effect: Effect) -> Sequence[Regressor]:
        """What to try of an effect; of a scan the deepest valleys of what this equation leaves."""
        if not effect.repeats:
            return self._context.regressors(effect, self._context.scales)
        return self._weak.deepest(effect.regressors(self._context.scales, self._context.motion))

    def columns(self, effects: tuple[Effect, ...]) -> list[Column]:
        """Tested forces of every effect at each of its starts.

        Of an effect that is no force on a known motion, that which moves the linear plant as the effect does: it is the
        same for what the drive and the sensor do, near it for what has states of its own.
        """
        context, out = self._context, []
        for effect in effects:
            regressors = self._regressors(effect)
            for regressor in regressors:
                out.append(Column(effect, -self._weak.test(regressor.forces), regressor.values))
            for values in () if regressors else map(tuple, effect.starts(context.scales)):
                changes = difference(context.linear, effect, values)
                if changes is not None:
                    shared = context.linear.shared
                    tested = np.column_stack([-self._weak.force_behind(change, shared) for change in changes.T])
                    out.append(Column(effect, tested, scaled(effect, values)))
        return [column for column in out if math.isfinite(float(np.abs(column.responses).max(initial=0.0)))]
