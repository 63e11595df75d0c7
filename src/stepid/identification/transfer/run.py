"""Run a python-control system on the input of a record."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stepid.core.arguments import as_experiment
from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.hand import release_index
from stepid.core.quantities import in_own_quantities
from stepid.core.samples import CLOSE, course, off_even_clock
from stepid.core.takes import described
from stepid.errors import ConvergenceError, InputError
from stepid.identification.transfer.linear import sampled
from stepid.identification.transfer.records import as_numbers

if TYPE_CHECKING:
    import control

_STATE = "Give one finite number for each of the system's states, as stepid.initial_state(model, run) does."
_RELATIVE, _ABSOLUTE = 1e-10, 1e-13  # tolerances of the states; m and m/s, or the effects' own units


@in_own_quantities
def simulate_system(
    system: control.InputOutputSystem, run: Experiment, *, initial_state: npt.ArrayLike | None = None
) -> control.TimeResponseData:
    """Simulate a python-control system on a run's input, between its samples as `input_between` says.

    A linear system is sampled for that, which is exact; any other is integrated from one change of the input to the
    next, where `control.input_output_response` over the whole record would turn each held step into a ramp.

    Parameters
    ----------
    system : control.InputOutputSystem
        With one input [V]: from `transfer_function`, `state_space` or `nonlinear_system`, or your own.
    run : Experiment
        Its time and input are used; a release begins where the cart is free of the hand.
    initial_state : array, shape (d,), optional
        From `stepid.initial_state`; zero if not given.

    Returns
    -------
    control.TimeResponseData
        On the run's clock counted from its first sample, s; with inputs, states and outputs.

    Raises
    ------
    stepid.errors.InputError
        If the system has more than one input, a sample time that is not the run's, or another number of states than the
        initial state; the run rests under an input before its first sample and no initial state is given; or its input
        is not held and the system is a sampled one, or smooth and the system not linear.
    stepid.errors.ConvergenceError
        If the response runs away.
    """
    import control

    run = as_experiment(run)
    if not isinstance(system, control.InputOutputSystem):
        raise InputError(
            f"system is {described(system)}", "Give a system of python-control, as stepid.transfer_function returns it."
        )
    _check(system, run, initial_state)
    name = system.name
    if off_even_clock(run.time).max() > CLOSE:
        raise InputError(
            f"run {run.name!r}: its samples are uneven in time, and python-control steps evenly",
            "Simulate it with stepid.simulate.",
        )
    if isinstance(system, control.LTI):
        system = control.ss(system)  # a transfer function has no states to begin in
    begin = release_index(run)
    volts = run.input[begin:]
    time: Array = run.sample_time * np.arange(begin, run.input.size, dtype=np.float64)
    start = np.zeros(system.nstates) if initial_state is None else _state(initial_state)
    if isinstance(system, control.LTI):
        stepped: Any = system
        pieces = course(run.time, run.input, run.input_between)[begin:]
        if stepped.isctime():
            stepped = sampled(stepped, run.sample_time, pieces.shape[1])
        response = control.forced_response(stepped, T=time - time[0], U=pieces.T, X0=start)
        states, outputs = response.x, response.y.reshape(system.noutputs, -1)
    else:
        states, outputs = _integrate(system, time, volts, start, held=run.input_between == "held")
    return control.TimeResponseData(
        time,
        outputs,
        states,
        volts[None],
        issiso=system.noutputs == 1,
        output_labels=system.output_labels,
        input_labels=system.input_labels,
        state_labels=system.state_labels,
        title=f"{name}, input of run {run.name!r}",
        sysname=name,
    )


def _integrate(system: Any, time: Array, volts: Array, start: Array, *, held: bool) -> tuple[Array, Array]:
    """States (d, n) and outputs (p, n) of a nonlinear system, from one change of the input to the next."""
    import control

    last = time.size - 1
    changes = np.flatnonzero(np.diff(volts)) + 1 if held else np.arange(1, last)
    marks = [0, *(int(i) for i in changes if i < last), last]
    step = float(time[1] - time[0])  # at most, so that no kink is leapt over
    options = {"rtol": _RELATIVE, "atol": _ABSOLUTE, "max_step": step}
    states, outputs = [], []
    for i, j in pairwise(marks):
        part = time[i : j + 1]
        try:
            response = control.input_output_response(
                system,
                part,
                np.full(part.size, volts[i]) if held else volts[i : j + 1],
                start,
                solve_ivp_method="DOP853",
                solve_ivp_kwargs=options,
            )
        except (RuntimeError, FloatingPointError) as error:
            raise ConvergenceError(
                f"the simulation of {system.name!r} runs away after {part[0]:.4g} s ({error})",
                "Check its parameters: a softening spring or a negative mass has no bounded response.",
            ) from None
        start = response.x[:, -1]
        end = None if j == last else -1
        states.append(response.x[:, :end])
        outputs.append(response.y[:, :end])
    return np.concatenate(states, axis=1), np.concatenate(outputs, axis=1)


def _state(given: npt.ArrayLike) -> Array:
    """The numbers of an initial state."""
    out = as_numbers(given, "initial_state", _STATE)
    if not np.isfinite(out).all():
        raise InputError("initial_state has values that are not finite", _STATE)
    return out


def _is_linear(system: Any) -> bool:
    import control

    return isinstance(system, control.LTI)


def _check(system: Any, run: Experiment, initial_state: npt.ArrayLike | None) -> None:
    if system.ninputs != 1:
        raise InputError(
            f"system {system.name!r} has {system.ninputs} inputs, a run has one", "Choose one: system[:, 0]."
        )
    if system.isdtime(strict=True) and not np.isclose(system.dt, run.sample_time, rtol=1e-6):
        raise InputError(
            f"system {system.name!r} has sample time {system.dt} s, run {run.name!r} has {run.sample_time:.6g} s",
            "Sample the continuous system with the run's sample time.",
        )
    if run.input_between != "held" and system.isdtime(strict=True):
        raise InputError(
            f"system {system.name!r} is sampled for an input of its own, the input of run {run.name!r} is not held",
            "Give the continuous system.",
        )
    if run.input_between == "smooth" and not _is_linear(system):
        raise InputError(
            f"the input of run {run.name!r} is smooth, which python-control gives to linear systems only",
            "Take stepid.simulate, or a linear system (stepid.state_space).",
        )
    if initial_state is None and run.input_before != 0:
        raise InputError(
            f"run {run.name!r} rests under {run.input_before:g} V before its first sample",
            "Take a state space or nonlinear system and give initial_state=stepid.initial_state(model, run).",
        )
    if initial_state is not None and system.nstates is None:
        raise InputError(
            f"system {system.name!r} is a transfer function, which has no states to begin in",
            "Take stepid.state_space in its place.",
        )
    if initial_state is not None and np.size(initial_state) != system.nstates:
        raise InputError(
            f"initial state has {np.size(initial_state)} values, system {system.name!r} has {system.nstates} states",
            f"Its states are {', '.join(system.state_labels)}.",
        )
