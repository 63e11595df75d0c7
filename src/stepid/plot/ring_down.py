"""The ring-down of one run, zoomed: where the missing effect shows best beside what a linear model says."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from stepid.core.base import Array
from stepid.core.takes import takes
from stepid.diagnosis.result import Diagnosis, RunGap
from stepid.errors import UndeterminedError
from stepid.plot.gap import RESPONSE, a_diagnosis
from stepid.plot.panels import Responses, curves
from stepid.plot.scale import length_unit, reach_of
from stepid.plot.style import an_axes, dress, in_own_words, styled

_FAINT = 5.0  # times the noise: where the swing ends
_AFTER = 1.0  # times the ring-down, shown after it: there a linear model may still swing


class RingDown(NamedTuple):
    """The ring-down of a run: time [s] and the position [m] measured, by the linear model, and by the final one."""

    run: str
    time: Array
    measured: Array
    linear: Array
    model: Array


def zoomed_ring_down(d: Diagnosis) -> RingDown | None:
    """Cut out the ring-down of the run in which the linear model fails most there; None where no run swings.

    It begins where the position first passes its last value after the largest departure from it, and goes
    on for as long again after the swing has sunk below five times the noise.
    """
    phases = ("ring-down", "overshoot")  # what follows the first swing, or that alone
    swinging = [(phase, run) for phase in phases for run in d.runs if phase in run.phases]
    for _, run in sorted(swinging, key=lambda one: (phases.index(one[0]), -one[1].phases[one[0]])):
        piece = _ring_down(run, _FAINT * d.gap.noise)
        if piece is not None:
            time, *curves = (np.array(q)[piece] for q in (run.time, run.measured, run.linear, run.model))
            return RingDown(run.name, time, *curves)
    return None


def _ring_down(run: RunGap, faint: float) -> slice | None:
    off = run.measured - run.measured[-1]
    far = np.flatnonzero(np.abs(off) > 0.5 * np.abs(off).max(initial=0.0))
    if not far.size:
        return None
    passed = np.flatnonzero(off[far[-1] :] * off[far[-1]] <= 0)
    if not passed.size:
        return None
    first = int(far[-1] + passed[0])
    swings = np.flatnonzero(np.abs(off[first:]) > faint)
    if not swings.size or swings[-1] < 2:
        return None
    return slice(first, min(first + int(swings[-1] * (1 + _AFTER)) + 2, off.size))


def ring_down_responses(d: Diagnosis, shown: RingDown) -> Responses:
    """The ring-down in the unit in which its swing reads well."""
    scale, unit = length_unit(reach_of([shown.measured - shown.measured[-1]]))
    return Responses(shown.time, unit, curves(d, scale, shown.measured, shown.linear, shown.model))


@in_own_words
@takes(d=a_diagnosis, axes=an_axes)
def ring_down(d: Diagnosis, *, axes: Axes) -> Axes:
    """Draw the ring-down of the run in which the linear model fails most there, zoomed.

    Parameters
    ----------
    d : Diagnosis
        From `stepid.diagnose`.
    axes : matplotlib.axes.Axes
        To draw into.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.

    Raises
    ------
    stepid.errors.UndeterminedError
        If no run swings after its step or release.
    """
    shown = zoomed_ring_down(d)
    if shown is None:
        raise UndeterminedError(f"no run of {d.campaign!r} rings down", "Look at the responses instead: plot.gap_runs.")
    time, unit, drawn = ring_down_responses(d, shown)
    with styled():
        dress(axes)
        for kind, curve in drawn.items():
            axes.plot(time, curve, **RESPONSE[kind])
        axes.set_xlabel("time [s]")
        axes.set_ylabel(f"position [{unit}]")
        axes.set_title(f"{shown.run}: ring-down")
        axes.legend()
    return axes
