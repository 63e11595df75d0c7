"""Known differences between the masses of runs."""

from __future__ import annotations

from stepid.core.base import Finite, Label, Model, NonNegative

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
