"""Fewer samples for the screen: the extremes of every segment stay, and the page says so."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array

MOST = 800  # samples of a curve; a picture has no more pixels


def listed(values: Array) -> list[float]:
    """Return numbers for the page; five digits are more than a screen shows, and an eighth of the size."""
    return [float(f"{v:.5g}") for v in values]


def kept_samples(*curves: Array, most: int = MOST) -> npt.NDArray[np.intp]:
    """Choose the samples that a picture shows.

    Parameters
    ----------
    *curves : array, shape (n,)
        Drawn over the same times.
    most : int
        How many samples at most.

    Returns
    -------
    array of int
        Indices in order: all where there are few enough, else the first, the last, and of each of equal segments the
        samples at which a curve is least and largest.
    """
    n = curves[0].size
    if n <= most:
        return np.arange(n)
    segments = np.array_split(np.arange(n), max((most - 2) // (2 * len(curves)), 1))
    kept = {0, n - 1}
    for segment in segments:
        for curve in curves:
            part = curve[segment]
            kept |= {int(segment[part.argmin()]), int(segment[part.argmax()])}
    return np.array(sorted(kept))
