"""The bridge to python-control: the only module that imports it, and only when called (it takes a second to load)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stepid._base import Array
from stepid.errors import IdentificationError
from stepid.parameters import IdentifiedParameters

if TYPE_CHECKING:
    import control


def transfer_function(parameters: IdentifiedParameters, run: str) -> control.TransferFunction:
    """Make the transfer function of one run (Eq. 11).

    G(s) = K/((m/k)s² + (c/k)s + 1), with the run's mass, damping and static gain and its spring's stiffness.

    Parameters
    ----------
    parameters : IdentifiedParameters
        From `stepid.identify` or `stepid.solve`.
    run : str
        Name of the run, for example ``"case 4"``.

    Returns
    -------
    control.TransferFunction
        From voltage [V] to displacement [m], so with K in m/V; named after the run.

    Raises
    ------
    stepid.errors.InputError
        If the run was not identified.
    stepid.errors.IdentificationError
        If the run has no static gain because it holds no step.
    """
    import control

    k = parameters.run_stiffness(run)
    if run not in parameters.static_gain:
        raise IdentificationError(
            f"run {run!r} has no static gain, because it holds no step of the input",
            "Eq. 11 needs one: name a run with a voltage step.",
        )
    denominator = [parameters.masses[run] / k, parameters.damping[run] / k, 1.0]
    return control.tf([parameters.static_gain[run]], denominator, name=run, inputs="voltage", outputs="position")


def held_response(
    parameters: IdentifiedParameters, run: str, *, input: Array, sample_time: float, input_before: float
) -> Array:
    """Response of the identified model to a sampled and held input, from rest.

    `control.forced_response` draws straight lines between the samples of a continuous system's input, which turns
    a step into a ramp one sample long. So the system is first sampled with a zero-order hold, which is exact.

    Parameters
    ----------
    parameters : IdentifiedParameters
    run : str
    input : array, shape (n,)
        V, each value held from its sample to the next.
    sample_time : float
        s.
    input_before : float
        V, under which the plant rests before the first sample.

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
    response = control.forced_response(control.sample_system(model, sample_time, method="zoh"), U=input - input_before)
    return np.asarray(response.outputs, dtype=np.float64)


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

    m, c, k = parameters.masses[run], parameters.damping[run], parameters.run_stiffness(run)
    model = control.ss([[0.0, 1.0], [-k / m, -c / m]], [[0.0], [1.0 / m]], [[1.0, 0.0]], [[0.0]])
    sampled = control.sample_system(model, sample_time, method="zoh")
    still = np.zeros(samples)
    columns = [control.forced_response(sampled, U=still, X0=start).outputs for start in ([1.0, 0.0], [0.0, 1.0])]
    return np.column_stack(columns).astype(np.float64)
