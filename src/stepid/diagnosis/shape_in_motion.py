"""The shape that a misfit has in the motion, where noise hides that of the force: which law of any shape takes it."""

from __future__ import annotations

from typing import NamedTuple

from stepid.diagnosis.free_law import FreeLaw, free_laws
from stepid.diagnosis.wording import whole_percent
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext

_MOST, _SEEN = 0.7, 2.0  # share of a misfit that describes it (less is another law in disguise); deviates beyond chance


class Kind(NamedTuple):
    """What a law of any shape is, and which laws make it."""

    what: str
    made_by: str


KINDS = {
    "velocity": Kind("a force that depends on velocity", "laws of friction or damping make it"),
    "position": Kind("a force that depends on position", "springs that bend, play, stops or magnets make it"),
    "position and velocity": Kind("a damping that depends on position", "magnets and guides that tighten make it"),
    "position and time": Kind("a stiffness that changes in time", "a spring that creeps, warms or lets go makes it"),
    "velocity and time": Kind("a damping that changes in time", "oil that warms makes it"),
    "input and time": Kind("a drive that changes in time", "an amplifier that warms or a supply that sags makes it"),
    "position and input": Kind("a drive that depends on position", "magnets and pinions off center make it"),
    "velocity and input": Kind("a drive that depends on velocity", "the voltage that a motor induces makes it"),
    "the input's past": Kind("a drive with a memory", "lags and delays make it"),
    "the position's past": Kind("a spring with a memory", "creep, relaxation and hysteresis make it"),
}
"""By the state of a `stepid.diagnosis.free_law.FreeLaw`."""


def law_in_motion(context: FitContext, optimum: Optimum, *, share: float, beyond: float) -> FreeLaw | None:
    """Find the law of any shape that takes of a fit's rest what chance does least likely.

    Parameters
    ----------
    context : FitContext
    optimum : Optimum
        On all samples.
    share : float
        Of the rest's power, that it takes at least.
    beyond : float
        Standard deviations beyond chance, that it takes at least.

    Returns
    -------
    FreeLaw or None
    """
    laws = (one for one in free_laws(context, optimum) if one.state in KINDS and not one.own)
    seen = (one for one in laws if one.share >= share and one.beyond > beyond)
    return max(seen, key=lambda one: one.beyond, default=None)


def of_the_linear_plant(context: FitContext) -> str:
    """Say which law of any shape takes most of what the linear plant leaves, '' where none does."""
    law = law_in_motion(context, context.linear, share=_MOST, beyond=_SEEN)
    return "" if law is None else f"{whole_percent(law.share)} of the residual fits {KINDS[law.state].what}"
