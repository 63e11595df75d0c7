"""Noise that is larger than it looks: what is left above the floor, and is there where the cart rests, too."""

from __future__ import annotations

import numpy as np

from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.free_law import allowed, free_laws
from stepid.diagnosis.phases import BEFORE, REST, phase_of_samples
from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.multistart import FitContext


def is_noise(context: FitContext, criteria: Criteria, found: Candidate) -> bool:
    """Tell whether what a fit leaves is noise.

    Above the floor it is no more than twice as much, in power, while the cart moves as while it rests (noise knows of
    no motion), and no law of any shape takes a part of it.

    Parameters
    ----------
    context : FitContext
    criteria : Criteria
    found : Candidate
    """
    return moving_over_resting(context, found) < 2 and not trace(context, criteria, found)


def moving_over_resting(context: FitContext, found: Candidate) -> float:
    """Mean square above the floor's while the cart moves, over that while it rests; infinite where there is none."""
    phase = phase_of_samples(context.records, context.linear, context.measured, context.floor)
    resting = (phase == BEFORE) | (phase == REST)
    square, weight = found.optimum.problem.residual(found.optimum.solved) ** 2, context.records.weight**2
    if not (resting.any() and (~resting).any()):
        return np.inf
    still, moving = (float(square[at].sum() / weight[at].sum()) - context.floor**2 for at in (resting, ~resting))
    return moving / still if still > 0 else np.inf


def trace(context: FitContext, criteria: Criteria, found: Candidate) -> str:
    """The state of a law that takes most of a rest, or more than chance does, and than real laws are rough; or ''.

    Rough by a share of the whole misfit: no effect is asked, but what the linear plant leaves. Where the plant runs
    away no law can be asked, and nothing is ruled out.
    """
    beyond, rough = allowed(context, criteria, found, noise=False)
    laws = free_laws(context, found.optimum)
    seen = (law.state for law in laws if law.is_seen(beyond, rough) and law.power > rough)
    return laws[0].state if len(laws) == 1 else next(seen, "")
