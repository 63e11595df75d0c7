"""Records as python-control's TimeResponseData, and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stepid.core.arguments import as_experiment
from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.quantities import in_own_quantities
from stepid.core.samples import InputBetween, Starts
from stepid.core.takes import able, described, takes
from stepid.errors import InputError

if TYPE_CHECKING:
    import control


@in_own_quantities
def to_time_response(run: Experiment, *, position: npt.ArrayLike | None = None) -> control.TimeResponseData:
    """Make python-control's response data of a record, to plot or to compare with other responses.

    Parameters
    ----------
    run : Experiment
    position : array, shape (n,), optional
        m, shown in place of the measured one: a simulation from `stepid.simulate`.

    Returns
    -------
    control.TimeResponseData
        Output `position` [m], input `voltage` [V], time [s] as in the record; its `plot` method draws it.

    Raises
    ------
    stepid.errors.InputError
        If `position` has another length than the record.
    """
    import control

    run = as_experiment(run)
    what = f"run {run.name!r}: the position handed over"
    shown = run.position if position is None else as_numbers(position, what, "Give positions in m, one a sample.")
    if shown.shape != run.time.shape:
        raise InputError(
            f"run {run.name!r} has {run.time.size} samples, the position handed over has shape {shown.shape}",
            "Simulate the campaign that holds this run: stepid.simulate(model, campaign)[run.name].",
        )
    return control.TimeResponseData(
        np.array(run.time),
        np.array(shown),
        inputs=np.array(run.input),
        issiso=True,
        output_labels=["position"],
        input_labels=["voltage"],
        sysname=run.name,
        title=run.name if position is None else f"{run.name}, simulated",
    )


def as_numbers(given: npt.ArrayLike, what: str, remedy: str) -> Array:
    """Take numbers that somebody hands over; InputError says `what` is none."""
    try:
        if isinstance(given, np.ma.MaskedArray):
            raise TypeError("a masked array")
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{what} is no array of numbers ({error})", remedy) from None


@takes(data=able("to_pandas", "the TimeResponseData that a simulation of python-control returns"))
def from_time_response(
    data: control.TimeResponseData,
    *,
    name: str,
    added_mass: float,
    spring: str,
    damper: str,
    output: int | str | None = None,
    input: int | str | None = None,
    trace: int | str | None = None,
    counts_per_meter: float | None = None,
    input_before: float = 0.0,
    base: str = "cart",
    input_between: InputBetween = "held",
    starts: Starts = "auto",
) -> Experiment:
    """Make an experiment of python-control's response data.

    Parameters
    ----------
    data : control.TimeResponseData
        Of any of control's simulations, in SI units; time must be uniform. Data without an input are a free release.
    name, added_mass, spring, damper, counts_per_meter, input_before, base, input_between, starts
        Fields of `Experiment`. ``control.forced_response`` joins the input of a continuous system by lines.
    output, input, trace : int or str, optional
        Which to take, by number or label; needed where there are several.

    Returns
    -------
    Experiment

    Raises
    ------
    stepid.errors.InputError
        If there are several outputs, inputs or traces and none is chosen, the chosen one does not exist, or a field is
        wrong.
    """
    if not data.success:
        raise InputError(
            f"run {name!r}: the response data come from a simulation that failed ({data.message})",
            "Repeat it with tighter tolerances.",
        )
    y, u = np.asarray(data.y), None if data.u is None else np.asarray(data.u)
    if data.ntraces:
        which = _choose("trace", trace, data.ntraces, data.trace_labels, run=name)
        y, u = y.reshape(data.noutputs, data.ntraces, -1)[:, which], _trace(u, data, which)
    elif trace is not None:
        raise InputError(f"run {name!r}: the response data have no traces", "Leave trace out.")
    position = y[_choose("output", output, data.noutputs, data.output_labels, run=name)]
    if u is None or not data.ninputs:
        volts: Any = np.zeros(position.size)
    else:
        volts = u[_choose("input", input, data.ninputs, data.input_labels, run=name)]
    return Experiment(
        name=name,
        time=np.asarray(data.t),
        position=position,
        input=volts,
        added_mass=added_mass,
        spring=spring,
        damper=damper,
        counts_per_meter=counts_per_meter,
        input_before=input_before,
        base=base,
        input_between=input_between,
        starts=starts,
    )


def _trace(u: Any, data: Any, which: int) -> Any:
    return None if u is None else u.reshape(data.ninputs, data.ntraces, -1)[:, which]


def _choose(what: str, wanted: int | str | None, count: int, labels: Sequence[str] | None, *, run: str) -> int:
    """Index of the chosen output, input or trace."""
    names = [f"{i}" if labels is None else f"{i} ({labels[i]!r})" for i in range(count)]
    if wanted is None:
        if count == 1:
            return 0
        raise InputError(
            f"run {run!r}: the response data have {count} {what}s", f"Choose one with {what}=…: {', '.join(names)}."
        )
    index = list(labels or ()).index(wanted) if isinstance(wanted, str) and wanted in (labels or ()) else wanted
    if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < count:
        raise InputError(
            f"run {run!r}: the response data have no {what} {described(wanted)}", f"There are: {', '.join(names)}."
        )
    return index
