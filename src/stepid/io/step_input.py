"""The input of a record whose file does not hold it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array, Finite, Model
from stepid.core.samples import is_even
from stepid.core.takes import described, number, taken
from stepid.errors import InputError, naming


class StepInput(Model):
    """A step of the input, for records without an input column (the paper's, Figs. 4 and 5).

    Parameters
    ----------
    level : float
        V, from `start` on.
    start : float
        s on the record's clock (an export's runs from Sample 0); taken at the nearest sample.
    end : float or None
        s, where the input goes back to what it was before the step; None where it never does.
    """

    level: Finite
    start: Finite = 0.0
    end: Finite | None = None

    def values(self, time: Array, *, before: float = 0.0) -> Array:
        """Sample the step.

        Parameters
        ----------
        time : array, shape (n,)
            s, increasing, n at least 2.
        before : float
            V, before the step and after its end.

        Returns
        -------
        array, shape (n,)
            V, held from each sample to the next.

        Raises
        ------
        stepid.errors.InputError
            If the step starts outside the record or ends before it starts.
        """
        if not (isinstance(time, np.ndarray) and time.dtype.kind in "fiu" and time.ndim == 1 and time.size > 1):
            raise InputError(f"time is {described(time)}", "Give the record's times, an array of two numbers or more.")
        taken("StepInput.values", "before", before, number())
        step = (time[-1] - time[0]) / (time.size - 1)
        with np.errstate(all="ignore"):
            first = _number(time, step, self.start)
            last = float(time.size) if self.end is None else _number(time, step, self.end)
        if not 0 <= first < time.size:
            raise InputError(
                f"the step starts at {self.start:g} s, outside the record ({time[0]:g} s to {time[-1]:g} s)",
                "Give the start on the record's own clock; a level held since before the record is input_before.",
            )
        if not last > first:
            raise InputError(
                f"the step ends at {self.end:g} s, not after its start at {self.start:g} s",
                "Give an end at least one sample after the start, or leave it out.",
            )
        index = np.arange(time.size)
        return np.where((index >= first) & (index < last), self.level, before).astype(np.float64)


def _number(time: Array, step: float, moment: float) -> float:
    """Number of the sample nearest to a moment, counted on beyond the record's ends."""
    if time[0] < moment < time[-1] and not is_even(time):
        return float(np.argmin(np.abs(time - moment)))
    return float(np.rint((moment - time[0]) / step))


InputValues = StepInput | Sequence[float] | npt.NDArray[np.float64]


def sample_input(given: object, time: Array, *, before: float, where: str) -> Array:
    """Turn what the caller gave as input, a `StepInput` or an array, into values at `time` (V)."""
    with naming(where):
        if isinstance(given, StepInput):
            return given.values(time, before=before)
        if isinstance(given, np.ma.MaskedArray):
            raise InputError("input is a masked array", "Leave out what is masked, or give its values.")
        try:
            values = np.asarray(given)
        except (ValueError, TypeError, OverflowError) as error:
            raise InputError(
                f"input is not an array ({error})", "Give StepInput(level=…, start=…) or an array."
            ) from None
        if values.dtype.kind not in "fiu" or values.shape != time.shape:
            raise InputError(
                f"input has shape {values.shape} and type {values.dtype}, the record {time.size} samples",
                "Give StepInput(level=…, start=…) or one number in volts a sample.",
            )
    return values.astype(np.float64)
