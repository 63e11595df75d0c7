"""A plant as a linear python-control system: transfer function and state space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stepid.core.arguments import a_run
from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.quantities import in_own_quantities
from stepid.core.samples import InputBetween, course
from stepid.core.takes import a, takes
from stepid.effects import CATALOGUE, Effect
from stepid.errors import IdentificationError
from stepid.identification.parameters import IdentifiedParameters
from stepid.identification.transfer.express import refuse, system_name, why_not_linear
from stepid.identification.transfer.plant import plant_of
from stepid.simulation.model import PlantModel

if TYPE_CHECKING:
    import control


_a_source = a((IdentifiedParameters, PlantModel), "what stepid.identify returns, or a PlantModel, as fit.model")


@in_own_quantities
@takes(source=_a_source, run=a_run)
def transfer_function(
    source: IdentifiedParameters | PlantModel, run: str | Experiment, *, catalogue: tuple[Effect, ...] = CATALOGUE
) -> control.TransferFunction:
    """Make the transfer function of one run (Eq. 11).

    G(s) = K/((m/k)s² + (c/k)s + 1), with the run's mass, damping and static gain and its spring's stiffness. Effects
    that keep the plant linear (actuator lag, viscoelastic spring, flexible coupling) raise its order.

    Parameters
    ----------
    source : IdentifiedParameters or PlantModel
        From `stepid.identify` or `stepid.solve`; or the model of a `stepid.fit` or `stepid.diagnose`.
    run : str or Experiment
        Name of the run, for example ``"case 4"``; for a PlantModel the run itself, ``campaign["case 4"]``, because the
        model does not know its labels.
    catalogue : tuple of Effect
        Where a model's effects are looked up.

    Returns
    -------
    control.TransferFunction
        From voltage [V] to displacement from rest [m], so with K in m/V; named after the run.

    Raises
    ------
    stepid.errors.InputError
        If the run was not identified, the model lacks one of its labels, or has an effect that is not linear.
    stepid.errors.IdentificationError
        If the run has no static gain because it holds no step.
    """
    import control

    a, b, name, _ = _matrices(source, run, catalogue)
    numerator: Any
    denominator: Any
    if isinstance(source, IdentifiedParameters):
        k = source.run_stiffness(name)
        numerator, denominator = [source.static_gain[name]], [source.masses[name] / k, source.damping[name] / k, 1.0]
    else:
        numerator, denominator = _polynomials(a, b)
    return control.tf(numerator, denominator, name=system_name(name), inputs="voltage", outputs="position")


@in_own_quantities
@takes(source=_a_source, run=a_run)
def state_space(
    source: IdentifiedParameters | PlantModel, run: str | Experiment, *, catalogue: tuple[Effect, ...] = CATALOGUE
) -> control.StateSpace:
    """Make the state-space system of one run, x = (displacement [m] from rest, velocity [m/s], the effects' own).

    Parameters
    ----------
    source, run, catalogue
        As `transfer_function`.

    Returns
    -------
    control.StateSpace
        From voltage [V] to displacement from rest [m]; named after the run.

    Raises
    ------
    stepid.errors.StepidError
        As `transfer_function`.
    """
    import control

    a, b, name, states = _matrices(source, run, catalogue)
    seen = np.zeros((1, len(states)))
    seen[0, 0] = 1.0
    return control.ss(a, b, seen, [[0.0]], name=system_name(name), inputs="voltage", outputs="position", states=states)


def _matrices(
    source: IdentifiedParameters | PlantModel, run: str | Experiment, catalogue: tuple[Effect, ...]
) -> tuple[Array, Array, str, list[str]]:
    """System matrix (d, d), input matrix (d, 1), the run's name and the names of the states."""
    name = run.name if isinstance(run, Experiment) else run
    if isinstance(source, IdentifiedParameters):
        k = source.run_stiffness(name)
        if name not in source.static_gain:
            raise IdentificationError(
                f"run {name!r} has no static gain, because it holds no step of the input",
                "Eq. 11 needs one: name a run with a voltage step.",
            )
        m, c = source.masses[name], source.damping[name]
        matrix = np.array([[0.0, 1.0], [-k / m, -c / m]])
        return matrix, np.array([[0.0], [source.static_gain[name] * k / m]]), name, ["displacement", "velocity"]
    plant = plant_of(source, run, catalogue=catalogue)
    refuse(
        plant.effects,
        why_not_linear,
        what=f"run {name!r}: a linear system",
        remedy="Use stepid.nonlinear_system or stepid.simulate, or the model without effects (diagnosis.linear_model).",
    )
    unit = np.eye(len(plant.states))
    columns = [plant.rates(plant.parameters, state, time=0.0, volts=0.0) for state in unit]
    driven = plant.rates(plant.parameters, 0.0 * unit[0], time=0.0, volts=1.0)
    return np.column_stack(columns), driven[:, None], name, plant.states


def _polynomials(a: Array, b: Array) -> tuple[Array, Array]:
    """Numerator and denominator of the first state, the denominator ending in 1.

    By the Markov parameters C Aⁱ B, so that the numerator's leading zeros are exact.
    """
    denominator = np.atleast_1d(np.poly(a)).real
    markov, state = [0.0], b[:, 0]
    for _ in range(a.shape[0]):
        markov.append(float(state[0]))
        state = a @ state
    numerator = np.convolve(denominator, markov)[: a.shape[0] + 1]
    first = int(np.flatnonzero(numerator)[0]) if np.any(numerator) else a.shape[0]
    return numerator[first:] / denominator[-1], denominator / denominator[-1]


def held_response(
    parameters: IdentifiedParameters,
    run: str,
    *,
    input: Array,
    sample_time: float,
    input_before: float,
    input_between: InputBetween = "held",
) -> Array:
    """Response of the identified model to a sampled input, from rest.

    `control.forced_response` draws straight lines between the samples of a continuous system's input, which turns
    a held step into a ramp one sample long. So the system is first sampled, exactly, for what the input does.

    Parameters
    ----------
    parameters : IdentifiedParameters
    run : str
    input : array, shape (n,)
        V, at each sample.
    sample_time : float
        s.
    input_before : float
        V, under which the plant rests before the first sample.
    input_between : "held", "lines" or "smooth"
        What the input does from each sample to the next.

    Returns
    -------
    array, shape (n,)
        Displacement from that rest position, m.

    Raises
    ------
    stepid.errors.StepidError
        As `transfer_function`.
    """
    import control

    model = control.ss(transfer_function(parameters, run))
    time: Array = sample_time * np.arange(input.size, dtype=np.float64)
    moved: Array = input - input_before
    pieces = course(time, moved, input_between)
    response = control.forced_response(sampled(model, sample_time, pieces.shape[1]), U=pieces.T)
    return np.asarray(response.outputs, dtype=np.float64).ravel()


def sampled(system: control.StateSpace, sample_time: float, terms: int) -> control.StateSpace:
    """Sample a continuous system of one input for an input that is a polynomial from each sample to the next.

    Parameters
    ----------
    system : control.StateSpace
    sample_time : float
        s.
    terms : int
        Of the polynomial; 1 is the zero-order hold.

    Returns
    -------
    control.StateSpace
        Exact at the samples; its inputs are the polynomial's coefficients at each.
    """
    import control
    from scipy.linalg import expm

    d = system.nstates
    whole = np.zeros((d + terms, d + terms))  # the input and its derivatives are states, too
    whole[:d, :d], whole[:d, d : d + 1] = system.A, system.B
    whole[d:, d:] = np.diag(np.arange(1.0, terms), 1)  # of the coefficients in the time since the sample
    step = expm(sample_time * whole)
    through = np.zeros((system.noutputs, terms))
    through[:, :1] = system.D
    return control.ss(step[:d, :d], step[:d, d:], system.C, through, sample_time)


def free_responses(parameters: IdentifiedParameters, run: str, *, samples: int, sample_time: float) -> Array:
    """Free responses of the identified model to a unit initial displacement and to a unit initial velocity.

    Parameters
    ----------
    parameters : IdentifiedParameters
    run : str
    samples : int
    sample_time : float
        s.

    Returns
    -------
    array, shape (samples, 2)
        Displacement for 1 m, and for 1 m/s.

    Raises
    ------
    stepid.errors.InputError
        If the run was not identified.
    """
    import control

    k = parameters.run_stiffness(run)  # refuses a run that was not identified
    m, c = parameters.masses[run], parameters.damping[run]
    model = control.ss([[0.0, 1.0], [-k / m, -c / m]], [[0.0], [1.0 / m]], [[1.0, 0.0]], [[0.0]])
    sampled = control.sample_system(model, sample_time, method="zoh")
    still = np.zeros(samples)
    columns = [control.forced_response(sampled, U=still, X0=start).outputs for start in ([1.0, 0.0], [0.0, 1.0])]
    return np.column_stack(columns).astype(np.float64)
