"""Why a step response yields no characteristics: it has not settled, or does not overshoot."""

from __future__ import annotations

import math

from stepid.core.words import length
from stepid.errors import NoOvershootError, NoStepError, NotSettledError


def no_overshoot(who: str, excess: float, level: float, noise: float, grid: float) -> NoOvershootError:
    """The peak is none that stands out, or as high as the level itself; lengths in m."""
    if excess * level >= level:
        return NoOvershootError(
            f"{who}: the peak is {excess:.2f} times the steady displacement above it, no damped step response",
            "Check the rest position before the step and that the input was held.",
        )
    resolution = f", resolution {length(grid)}" if grid > 0 else ""
    return NoOvershootError(
        f"{who}: no overshoot to be seen ({100 * excess:.2f} % of {length(level)}, noise {length(noise)}{resolution})",
        "Eqs. 7 and 8 need an overshoot: less damping, more mass or a stiffer spring; stepid.fit needs none.",
    )


def hidden_peak(who: str, excess: float, noise: float) -> NoOvershootError:
    """There is an overshoot, but noise [m] leaves open when."""
    return NoOvershootError(
        f"{who}: noise of {length(noise)} hides when the overshoot of {100 * excess:.2g} % is reached",
        "A larger step, or a finer encoder; stepid.fit takes all samples and needs no peak.",
    )


def no_step(who: str, spread: float, peak_time: float) -> NoStepError:
    """The input takes its time: its spread [s] is no small part of that to the peak."""
    return NoStepError(
        f"{who}: the input takes some {math.sqrt(12.0) * spread:.2g} s to change, of the {peak_time:.2g} s to the peak",
        "The peak method needs a step; stepid.fit takes any input.",
    )


def swinging(who: str, fraction: float) -> NotSettledError:
    """It swings at the end, by a fraction of its steady displacement."""
    return not_settled(who, f"still swings ±{100 * fraction:.1f} % of its steady displacement at the end")


def not_settled(who: str, how: str) -> NotSettledError:
    """It has not settled, in words that follow "it"."""
    return NotSettledError(
        f"{who}: the response has not settled, it {how}",
        "Record longer, until the swing is below 2 % of the steady displacement.",
    )
