"""Starts of a force that repeats in position: each run may have come to rest in another of its potential wells."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.multistart import FitContext, Start

_PITCHES = np.geomspace(0.05, 1.2, 120)  # of the largest displacement
_APART = 1.1  # least ratio of two pitches that are both tried


def well_starts(context: FitContext, effect: Effect, count: int = 2) -> list[Start]:
    """Best starts of an effect that `repeats`, by linear least squares on the weak form; none where no run is released.

    A released cart is measured from where it comes to rest, which need not be the spring's rest position, so that the
    force seems to have another phase in every run. The weak form's constant, spring stiffness times where the run
    began, tells how far the runs' zeros are apart, and with it the one phase of the force.
    """
    records, motion = context.records, context.measured
    if not effect.repeats or not records.moving.any():
        return []
    pitches = _PITCHES * context.scales.displacement
    left = np.array([context.weak.left_by_run(_waves(motion.x, pitch)) for pitch in pitches])
    own = records.run == np.arange(len(records.runs))[:, None]
    found: list[Start] = []
    tried: list[float] = []
    for i in np.argsort(left):
        pitch = float(pitches[i])
        if len(found) == count or any(1 / _APART < pitch / other < _APART for other in tried):
            continue
        tried.append(pitch)
        solution = context.weak.solve(
            tuple(np.where(mine, wave, 0.0) for wave in _waves(motion.x, pitch) for mine in own)
        )
        if solution is None:
            continue
        sine, cosine = solution.coefficients.reshape(2, -1)
        apart = solution.displacement - motion.x[records.first]
        turned = np.exp(1j * (np.arctan2(cosine, sine) - 2 * np.pi * apart / pitch))
        strength = np.hypot(sine, cosine)
        values = float(np.median(strength)), pitch, float(np.angle(np.sum(strength * turned)))
        begins = np.where(records.moving, solution.displacement, np.nan)
        found.append(Start(solution.shared, (values,), begins))
    return found


def _waves(x: Array, pitch: float) -> list[Array]:
    """Sine and cosine of the position."""
    angle = 2 * np.pi * x / pitch
    return [np.sin(angle), np.cos(angle)]
