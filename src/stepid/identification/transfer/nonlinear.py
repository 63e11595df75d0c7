"""A plant with effects as a python-control nonlinear system."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stepid.core.arguments import a_run
from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.quantities import in_own_quantities
from stepid.core.takes import takes
from stepid.effects import CATALOGUE, Effect
from stepid.identification.transfer.express import refuse, system_name, why_not_nonlinear
from stepid.identification.transfer.plant import plant_of
from stepid.simulation.model import PlantModel, a_model

if TYPE_CHECKING:
    import control


@in_own_quantities
@takes(model=a_model, run=a_run)
def nonlinear_system(
    model: PlantModel, run: Experiment, *, catalogue: tuple[Effect, ...] = CATALOGUE
) -> control.NonlinearIOSystem:
    """Make a python-control nonlinear system of one run's plant, effects included.

    Its equations are those of `stepid.simulate`. They hold between the input's changes: `simulate_system` runs it on a
    measured, held input; `control.input_output_response` draws straight lines between the samples of its input.

    Parameters
    ----------
    model : PlantModel
        ``fit.model`` or ``diagnosis.model``.
    run : Experiment
        Whose added mass, labels and rest position are taken.
    catalogue : tuple of Effect
        Where the model's effects are looked up.

    Returns
    -------
    control.NonlinearIOSystem
        From `voltage` [V] to `position` [m], as the sensor reads it: rest position and drift included (a run that the
        model does not know has its rest position at zero). States: `displacement` [m] from rest, `velocity` [m/s], the
        effects' own. Time counts from the record's first sample. Its `params` are `mass`, `stiffness`, `damping`,
        `force_gain`, `rest` and the effects' parameters, ``"cubic_stiffness.coefficient"``, in SI units.

    Raises
    ------
    stepid.errors.InputError
        If the model has an effect that no such system expresses (dry friction, delays): the reason is given; or it
        lacks a label of the run, or names an effect that is not in the catalogue.
    """
    import control

    plant = plant_of(model, run, catalogue=catalogue)
    refuse(
        plant.effects,
        why_not_nonlinear,
        what=f"run {run.name!r}: a python-control system",
        remedy="stepid.simulate expresses every effect; or leave this one out of the model.",
    )

    def rates(time: float, state: Array, input: Array, params: dict[str, float]) -> Array:
        return plant.rates(params, state, time=time, volts=float(input[0]))

    def reading(time: float, state: Array, input: Array, params: dict[str, float]) -> list[float]:
        return [plant.reading(params, state, time=time)]

    made: Any = control.nlsys(
        rates,
        reading,
        name=system_name(run.name),
        inputs="voltage",
        outputs="position",
        states=plant.states,
        params=plant.parameters,
    )
    return made


@in_own_quantities
@takes(model=a_model, run=a_run)
def initial_state(model: PlantModel, run: Experiment, *, catalogue: tuple[Effect, ...] = CATALOGUE) -> Array:
    """State in which one run begins, for `nonlinear_system` and `state_space` of the same model and run.

    Parameters
    ----------
    model : PlantModel
    run : Experiment
    catalogue : tuple of Effect

    Returns
    -------
    array, shape (d,)
        Displacement [m], velocity [m/s] and the effects' own states: at rest under the input before the record, plus
        what the model has of the run's start. For a release it is the state at the first sample at which the cart is
        free of the hand.

    Raises
    ------
    stepid.errors.InputError
        If the model lacks a label of the run, or names an effect that is not in the catalogue.
    """
    return np.array(plant_of(model, run, catalogue=catalogue).start)
