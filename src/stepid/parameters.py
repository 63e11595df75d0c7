"""The result models of the paper's method: characteristics, stacked system, identified parameters, verification."""

from __future__ import annotations

from collections.abc import Mapping

from stepid._base import Finite, Label, Matrix, Model, NonNegative, Positive, Vector


class CharacteristicsUncertainty(Model):
    """Standard uncertainties of `Characteristics`, same units; None where the quantity is None."""

    peak_time: NonNegative | None = None
    overshoot: NonNegative | None = None
    steady_state: NonNegative | None = None
    damping_ratio: NonNegative = 0.0
    damped_frequency: NonNegative = 0.0
    natural_frequency: NonNegative = 0.0
    static_gain: NonNegative | None = None
    settling_time: NonNegative | None = None


class Characteristics(Model):
    """Second-order response characteristics of one run (Eqs. 3, 4, 7, 8).

    Parameters
    ----------
    name, spring, damper, base : str
        The run and its labels.
    added_mass : float or None
        kg; not needed by `stepid.assemble`, which takes mass offsets.
    damped_frequency, natural_frequency : float
        rad/s.
    damping_ratio : float
    peak_time : float or None
        s, from the sample where the input changes; None for a release.
    overshoot : float or None
        Decimal fraction (Eq. of M_p); None for a release.
    steady_state : float or None
        m, signed displacement from the rest position before the step; None for a release.
    static_gain : float or None
        m/V; None for a release.
    settling_time : float or None
        s, into the 2 % band.
    uncertainty : CharacteristicsUncertainty
    correlation : float
        Correlation of the errors of `damped_frequency` and `damping_ratio`.
    """

    name: Label
    damped_frequency: Positive
    damping_ratio: NonNegative
    natural_frequency: Positive
    peak_time: Positive | None = None
    overshoot: Positive | None = None
    steady_state: Finite | None = None
    static_gain: Finite | None = None
    settling_time: NonNegative | None = None
    uncertainty: CharacteristicsUncertainty = CharacteristicsUncertainty()
    correlation: Finite = 0.0
    spring: Label = "spring"
    damper: Label = "damper"
    base: Label = "cart"
    added_mass: NonNegative | None = None


class StackedSystem(Model):
    """The stacked linear system of Eqs. 6, 9 and 10 (corrected).

    Parameters
    ----------
    matrix : array, shape (rows, n + s)
        n masses, then s stiffnesses.
    rhs : array, shape (rows,)
    row_labels, column_labels : tuple of str
    characteristics : tuple of Characteristics
        The runs behind the rows, in the order of the mass columns.
    row_covariance : array, shape (rows, rows)
        Covariance of the row residuals at the solution's scale; see `stepid.assemble`.
    """

    matrix: Matrix
    rhs: Vector
    row_labels: tuple[str, ...]
    column_labels: tuple[str, ...]


class ParameterUncertainty(Model):
    """Standard uncertainties of `IdentifiedParameters`, same keys and units."""

    masses: Mapping[str, NonNegative]
    stiffness: Mapping[str, NonNegative]
    damping: Mapping[str, NonNegative]
    damping_from_stiffness: Mapping[str, NonNegative]
    pooled_damping: Mapping[str, NonNegative]
    static_gains: Mapping[str, NonNegative]
    base_mass: Mapping[str, NonNegative]


class IdentifiedParameters(Model):
    """What the paper's method finds."""

    masses: Mapping[str, Finite]
