"""Whether the noise of the readings is white: a mixture of white and first-order colored noise, or 1/f."""

from __future__ import annotations

from typing import Literal

from stepid.core.base import Model, NonNegative, Positive


class NoiseColor(Model):
    """Noise of the readings that is not white.

    Parameters
    ----------
    kind : "ar1" or "1/f"
        First-order autoregressive noise, or a spectrum that falls with the inverse of the frequency.
    correlation_time : float
        s; of 1/f noise that of the slowest part which the records can show.
    white, colored : float
        m, standard deviations of the two parts.
    effective_samples : float
        Samples of white noise that would tell as much of a mean.
    """

    kind: Literal["ar1", "1/f"]
    correlation_time: Positive
    white: NonNegative
    colored: Positive
    effective_samples: Positive
