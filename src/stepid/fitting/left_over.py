"""Whether what a fit leaves is noise, and what to say where it is not."""

from __future__ import annotations

import math

from stepid.core.words import length
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import block_mean_deviate, least_floor, von_neumann_ratio

_MORE = 1.2  # times the floor, beyond which more than noise is left
_SLOW = 5.0  # standard deviations by which what is left is slower than white noise


def left_over(optimum: Optimum, context: FitContext) -> str | None:
    """Say in one sentence that more than noise is left, and what that does to the intervals; None where it is noise.

    Parameters
    ----------
    optimum : Optimum
    context : FitContext
        Of the same campaign.

    Notes
    -----
    More than noise is 1.2 times the noise floor, or a residual that is slower than white noise by five standard
    deviations, both of its successive differences and of its means over a tenth of a period.
    """
    times = optimum.rms / context.floor
    exact = optimum.rms <= least_floor(optimum.problem.records)
    if times <= _MORE and (exact or not _slow(optimum, context)):
        return None
    return (
        f"More than noise is left, {length(optimum.rms)} where the noise is {length(context.floor)}: the "
        "intervals hold only if the model is right, and the true values may lie far outside of them; stepid.diagnose "
        "looks for the cause."
    )


def _slow(optimum: Optimum, context: FitContext) -> bool:
    if context.colored is not None:
        return False  # noise that is slow itself
    records = optimum.problem.records
    ratio, count = von_neumann_ratio(records, optimum.residual)
    if ratio < 1.0 + _SLOW / math.sqrt(max(count, 1)):
        return False
    residual = optimum.problem.residual(optimum.solved)
    return block_mean_deviate(records, residual, optimum.rms, context.period) > _SLOW
