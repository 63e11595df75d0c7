"""Read second-order characteristics off records (Eqs. 7 and 8); their formulas are in `identification.second_order`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from stepid.core.arguments import as_experiment
from stepid.core.experiment import Experiment
from stepid.core.held_before import held_before
from stepid.core.quantities import in_own_quantities
from stepid.core.recorded import recorded
from stepid.core.takes import takes
from stepid.errors import IdentificationError
from stepid.identification.characteristics_model import Characteristics, CharacteristicsUncertainty
from stepid.identification.free_response import is_free_response, release_characteristics
from stepid.identification.peak import InterpolatedPeak, Peak, SampledPeak, a_peak
from stepid.identification.second_order import (
    damped_frequency,
    damping_ratio,
    natural_frequency,
    overshoot_of,
    settling_time,
)
from stepid.identification.slow_sensor import between_readings
from stepid.identification.step_response import overshoot, static_gain, step_characteristics
from stepid.identification.steps import Step, find_steps

__all__ = [
    "Characteristics",
    "CharacteristicsUncertainty",
    "InterpolatedPeak",
    "SampledPeak",
    "Step",
    "characterize",
    "characterize_all",
    "characterize_each",
    "damped_frequency",
    "damping_ratio",
    "find_steps",
    "natural_frequency",
    "overshoot",
    "overshoot_of",
    "settling_time",
    "static_gain",
]


@contextmanager
def _computable(experiment: Experiment) -> Iterator[None]:
    """Say of which run the numbers are that divide by zero or leave the range of numbers: no plant's, but a file's."""
    try:
        yield
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise IdentificationError(
            f"run {experiment.name!r}: its numbers cannot be those of a step response ({error})",
            "Look at the record: scales and columns, and samples far off the others.",
        ) from None


@in_own_quantities
@takes(peak=a_peak)
@recorded(peak=InterpolatedPeak)
def characterize(experiment: Experiment, *, peak: Peak | None = None) -> Characteristics:
    """Read the characteristics of the first step of a record, or of a hand release where there is no input.

    Parameters
    ----------
    experiment : Experiment
        A step in either direction from any rest position, at sample 0 (from `input_before`) or later; or a record
        without input that the plant is let go in, with or without the time that the hand still holds it. One that is
        said to start in motion, under an input that never changes, is a release about another rest position.
    peak : Peak, optional
        How the peak is read; default `InterpolatedPeak()`. `SampledPeak()` is the paper's own reading.

    Returns
    -------
    Characteristics
        Each with a standard uncertainty propagated from sample time, noise and resolution. Steps give peak time and
        overshoot, from them the damped frequency (Eq. 7) and the damping ratio (Eq. 8). A release gives both from
        its extrema (half period, logarithmic decrement); what only a step has is None.

    Raises
    ------
    stepid.errors.NoStepError
        If there is no step in the input, or the position does not move.
    stepid.errors.NoOvershootError
        If the response does not overshoot.
    stepid.errors.NotSettledError
        If the record is cut before its peak or before the plant rests, or the plant moved before the step.
    """
    experiment = held_before(between_readings(as_experiment(experiment)))
    how = InterpolatedPeak() if peak is None else peak
    with _computable(experiment):
        if is_free_response(experiment):
            return release_characteristics(experiment, peak=how)
        return step_characteristics(experiment, find_steps(experiment)[0], peak=how)


@in_own_quantities
@takes(peak=a_peak)
@recorded(peak=InterpolatedPeak)
def characterize_each(
    experiment: Experiment, *, peak: Peak | None = None
) -> tuple[Characteristics | IdentificationError, ...]:
    """Read the characteristics of every step, with the error in place of a step that does not yield them.

    Parameters
    ----------
    experiment, peak
        As for `stepid.characterize`.

    Returns
    -------
    tuple
        One entry a step, in order of time. The first has the name of the run, the others ``"…, step 2"`` and so on.

    Raises
    ------
    stepid.errors.NoStepError
        If there is no step at all.
    """
    experiment = held_before(between_readings(as_experiment(experiment)))
    how = InterpolatedPeak() if peak is None else peak
    if is_free_response(experiment):
        return (characterize(experiment, peak=how),)
    found: list[Characteristics | IdentificationError] = []
    for step in find_steps(experiment):
        try:
            with _computable(experiment):
                found.append(step_characteristics(experiment, step, peak=how))
        except IdentificationError as error:
            found.append(error)
    return tuple(found)


@in_own_quantities
@takes(peak=a_peak)
@recorded(peak=InterpolatedPeak)
def characterize_all(experiment: Experiment, *, peak: Peak | None = None) -> tuple[Characteristics, ...]:
    """Read the characteristics of every step of a record: up, back, and any more.

    Parameters
    ----------
    experiment, peak
        As for `stepid.characterize`.

    Returns
    -------
    tuple of Characteristics
        One a step, in order of time.

    Raises
    ------
    stepid.errors.IdentificationError
        The error of the first step that does not yield them, as for `stepid.characterize`; `characterize_each`
        returns errors beside results instead.
    """
    found = []
    for result in characterize_each(experiment, peak=peak):
        if isinstance(result, IdentificationError):
            raise result
        found.append(result)
    return tuple(found)
