"""Burchett's paper rebuilt: Table 2 and Eqs. 12 to 15 from the four recovered runs, beside what is printed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stepid.core.base import Array, Finite, Label, Model, Positive, Vector
from stepid.datasets import burchett
from stepid.identification.characteristics_model import Characteristics
from stepid.identification.parameters import IdentifiedParameters, StackedSystem
from stepid.identification.solve import solve
from stepid.identification.solvers import OrdinaryLeastSquares, WeightedLeastSquares
from stepid.identification.stacked import assemble
from stepid.identification.transfer import held_response

STEP = 0.5  # V, "0.5 volt for all cases"
PRINTED_STIFFNESS = 216.2  # N/m


class PrintedCase(Model):
    """One run as the paper prints it.

    Parameters
    ----------
    name, figure, equation : str
        The run, its verification figure and its transfer function.
    mass, damping : float
        Table 2: kg, N·s/m.
    static_gain : float
        Table 2, in m/V (the paper prints cm/V without a unit).
    second_order : float
        s², the equation's coefficient m/k as printed.
    second_order_corrected : float
        s², with the misprinted digit put right.
    first_order : float
        s, the equation's coefficient c/k as printed.
    """

    name: Label
    figure: Label
    equation: Label
    mass: Positive
    damping: Positive
    static_gain: Positive
    second_order: Positive
    second_order_corrected: Positive
    first_order: Positive


def _printed(name: str, figure: str, equation: str, *values: float) -> PrintedCase:
    mass, damping, gain, second, corrected, first = values
    return PrintedCase(
        name=name,
        figure=figure,
        equation=equation,
        mass=mass,
        damping=damping,
        static_gain=gain / 100,
        second_order=second,
        second_order_corrected=corrected,
        first_order=first,
    )


PRINTED = (
    _printed("case 4", "Fig. 3", "Eq. 12", 0.9538, 14.01, 3.618, 0.004411, 0.004411, 0.06478),
    _printed("case 5", "Fig. 6", "Eq. 13", 1.4940, 13.85, 3.633, 0.006909, 0.006909, 0.06407),
    _printed("case 6", "Fig. 7", "Eq. 14", 2.4357, 15.42, 3.698, 0.001126, 0.01126, 0.07131),
    _printed("case 7", "Fig. 8", "Eq. 15", 2.9951, 16.19, 3.876, 0.001385, 0.01385, 0.07489),
)


class Misprint(Model):
    """A place where the printed text cannot be taken literally.

    Parameters
    ----------
    where, printed, correct, shows : str
        The place, what it says, what it should say, and how one can tell.
    """

    where: Label
    printed: Label
    correct: Label
    shows: Label


def _misprints(*rows: tuple[str, str, str, str]) -> tuple[Misprint, ...]:
    return tuple(Misprint(where=a, printed=b, correct=c, shows=d) for a, b, c, d in rows)


MISPRINTS = _misprints(
    ("Eq. 10, last matrix column", "(ω₁² − 1)", "(ζ₁² − 1)", "it is Eq. 6 as a row; with ω it makes no sense"),
    ("Eq. 10, mass rows", "1  1  …  0.5", "−1  +1  …  0.5", "it is Eq. 9 as a row"),
    ("first formula for c", "2mω_d/√(1−ζ²)", "2ζmω_d/√(1−ζ²)", "without ζ case 4 has 28.7 N·s/m, Table 2 says 14.01"),
    ("second formula for c", "2k√(1−ζ²)/ω_d", "2ζk√(1−ζ²)/ω_d", "likewise"),
    ("Eq. 14, s² term", "0.001126", "0.01126", "m/k = 2.4357/216.2 = 0.01127"),
    ("Eq. 15, s² term", "0.001385", "0.01385", "m/k = 2.9951/216.2 = 0.01385"),
    ("text below Fig. 6", "Figure 5", "Figure 3", "Fig. 5 lists a file"),
    ("Results, first paragraph", "Table 1", "Table 2", "Table 1 is the test matrix and holds no masses to find"),
    ("Eq. 12, s term", "0.06478", "0.06480", "c/k = 14.01/216.2; rounding, within 6e-4 in Eqs. 12 to 15"),
)


class PaperResponse(Model):
    """Step response of one run's model, from the rebuilt and from the printed parameters.

    Parameters
    ----------
    name, figure : str
    time, rebuilt, printed : array, shape (n,)
        s from the step; m.
    peak_time, peak, steady_state : float
        s, m, m: what was read off the measurement, recovered from Table 2.
    """

    name: Label
    figure: Label
    time: Vector
    rebuilt: Vector
    printed: Vector
    peak_time: Positive
    peak: Finite
    steady_state: Finite


class PaperRebuild(Model):
    """The paper's result, computed again.

    Parameters
    ----------
    system : StackedSystem
        Eq. 10, corrected.
    parameters : IdentifiedParameters
        By unweighted least squares in SI units: the paper's own solve.
    weighted : IdentifiedParameters
        By least squares weighted with the standard uncertainties.
    in_milliseconds : mapping
        Run name to mass, kg, by the paper's own solve when time is measured in milliseconds.
    printed : tuple of PrintedCase
    misprints : tuple of Misprint
    responses : tuple of PaperResponse
        To the 0.5 V step.
    """

    system: StackedSystem
    parameters: IdentifiedParameters
    weighted: IdentifiedParameters
    in_milliseconds: Mapping[str, Finite]
    printed: tuple[PrintedCase, ...]
    misprints: tuple[Misprint, ...]
    responses: tuple[PaperResponse, ...]


def rebuild_paper() -> PaperRebuild:
    """Rebuild Table 2 and the models of Eqs. 12 to 15 from the paper's four runs.

    Returns
    -------
    PaperRebuild
        Computed values and the printed ones, with the misprints.
    """
    data = burchett()
    system = assemble(data.characteristics, data.mass_offsets)
    parameters = solve(system, solver=OrdinaryLeastSquares())
    slow = tuple(  # rad/ms
        Characteristics(
            name=c.name,
            spring=c.spring,
            damped_frequency=c.damped_frequency / 1e3,
            damping_ratio=c.damping_ratio,
            natural_frequency=c.natural_frequency / 1e3,
        )
        for c in data.characteristics
    )
    return PaperRebuild(
        system=system,
        parameters=parameters,
        weighted=solve(system, solver=WeightedLeastSquares()),
        in_milliseconds=dict(solve(assemble(slow, data.mass_offsets), solver=OrdinaryLeastSquares()).masses),
        printed=PRINTED,
        misprints=MISPRINTS,
        responses=tuple(_response(parameters, c) for c in data.characteristics),
    )


def printed_parameters() -> IdentifiedParameters:
    """Table 2 as the paper prints it.

    Returns
    -------
    IdentifiedParameters
        Without uncertainties, which the paper does not give.
    """
    return IdentifiedParameters(
        masses={case.name: case.mass for case in PRINTED},
        damping={case.name: case.damping for case in PRINTED},
        static_gain={case.name: case.static_gain for case in PRINTED},
        stiffness={"medium": PRINTED_STIFFNESS},
        springs={case.name: "medium" for case in PRINTED},
        solver="the paper, Table 2",
    )


def _response(rebuilt: IdentifiedParameters, run: Characteristics) -> PaperResponse:
    sample_time, samples = 0.005, 501
    case = next(c for c in PRINTED if c.name == run.name)
    steady = (run.static_gain or 0.0) * STEP
    return PaperResponse(
        name=run.name,
        figure=case.figure,
        time=sample_time * np.arange(samples, dtype=np.float64),
        rebuilt=_step(rebuilt, run.name, samples, sample_time),
        printed=_step(printed_parameters(), run.name, samples, sample_time),
        peak_time=run.peak_time or 0.0,
        peak=steady * (1 + (run.overshoot or 0.0)),
        steady_state=steady,
    )


def _step(parameters: IdentifiedParameters, run: str, samples: int, sample_time: float) -> Array:
    return held_response(parameters, run, input=np.full(samples, STEP), sample_time=sample_time, input_before=0.0)
