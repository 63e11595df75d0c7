"""Noise that is larger than it looks: what is left above the floor, and is there where the cart rests, too."""

from __future__ import annotations

import math

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
    return not louder_in_motion(context, criteria, found) and not trace(context, criteria, found)


def louder_in_motion(context: FitContext, criteria: Criteria, found: Candidate) -> bool:
    """Tell whether a rest has more than twice the power while the cart moves as while it rests; True if it never rests.

    Above the least that the floor may be, as it is known within `Criteria.floor`, and by more than one standard error
    that both mean squares have of white noise: a floor that was read a little too high, or few samples at rest, would
    leave nothing there.
    """
    phase = phase_of_samples(context.records, context.linear, context.measured, context.floor)
    resting = (phase == BEFORE) | (phase == REST)
    if not (resting.any() and (~resting).any()):
        return True
    residual = found.optimum.problem.residual(found.optimum.solved)
    square, weight = residual**2, context.records.weight**2
    still, moving = (float(square[at].sum() / weight[at].sum()) for at in (resting, ~resting))
    least = (context.floor / criteria.floor) ** 2
    spread = [size * math.sqrt(2 / at.sum()) for size, at in ((still, resting), (moving, ~resting))]
    return moving - least - 2 * (still - least) > math.hypot(2 * spread[0], spread[1])


def trace(context: FitContext, criteria: Criteria, found: Candidate) -> str:
    """The state of a law that takes most of a rest, or more than chance does, and than real laws are rough; or ''.

    Rough by a share of the whole misfit: no effect is asked, but what the linear plant leaves. Where the plant runs
    away no law can be asked, and nothing is ruled out.
    """
    beyond, rough = allowed(context, criteria, found, noise=False)
    laws = free_laws(context, found.optimum)
    seen = (law.state for law in laws if law.is_seen(beyond, rough) and law.power > rough)
    return laws[0].state if len(laws) == 1 else next(seen, "")
