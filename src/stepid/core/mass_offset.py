"""Known differences between the masses of runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stepid.core.base import Array, Finite, Label, Model, NonNegative

WEIGHT = 0.5  # kg, one lab weight
WEIGHT_UNCERTAINTY = 0.005  # kg, how well one lab weight is known (manual: 500 ± 5 g)


class MassOffset(Model):
    """A known difference between the masses of two runs (Eq. 9).

    Parameters
    ----------
    from_run, to_run : str
        Names of the runs.
    difference : float
        kg, mass of `to_run` minus mass of `from_run`.
    uncertainty : float
        kg, standard uncertainty; 0 is an exact constraint.
    """

    from_run: Label
    to_run: Label
    difference: Finite
    uncertainty: NonNegative = WEIGHT_UNCERTAINTY


def weight_spread(mass: float, weight_uncertainty: float) -> float:
    """Standard uncertainty of an added mass made of weights with independent errors, kg.

    Parameters
    ----------
    mass : float
        kg.
    weight_uncertainty : float
        kg, of one weight of 0.5 kg.
    """
    return weight_uncertainty * math.sqrt(abs(mass) / WEIGHT)


def known_in_words(heaviest: float, weight_uncertainty: float) -> str:
    """How well the largest added mass [kg] is taken as known, the beginning of a sentence."""
    known = weight_spread(heaviest, weight_uncertainty)
    return f"The largest added mass, {heaviest:.3g} kg, is taken as known to {known:.2g} kg"


def weight_parts(added: Array, uncertainty: float) -> Array:
    """Errors of the added masses [kg] as independent parts of unit variance, shape (R, K).

    Weights are put on one after another, each with its own error, as in `stepid.Campaign.mass_offsets`: runs of equal
    added mass share theirs.
    """
    steps = np.unique(added[added > 0]) if uncertainty > 0 else np.zeros(0)
    sizes = uncertainty * np.sqrt(np.diff(steps, prepend=0.0) / WEIGHT)
    return (added[:, None] >= steps) * sizes


def chained(runs: Sequence[tuple[str, str, float]], weight_uncertainty: float) -> tuple[MassOffset, ...]:
    """Differences of runs (name, base, added mass [kg]) of one base sorted by added mass, each to the next."""
    out = []
    for base in dict.fromkeys(base for _, base, _ in runs):
        own = sorted(((name, mass) for name, of, mass in runs if of == base), key=lambda run: run[1])
        for (one, lighter), (two, heavier) in pairwise(own):
            difference = heavier - lighter
            spread = weight_spread(difference, weight_uncertainty)
            out.append(MassOffset(from_run=one, to_run=two, difference=difference, uncertainty=spread))
    return tuple(out)
