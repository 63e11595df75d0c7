"""Records of sensors that are slower than their clock, for what reads a record by its turning points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from stepid.core.experiment import Experiment
from stepid.core.repeated_readings import AtSensorRate, at_sensor_rate, at_sensor_rates, sensor_notes

_SURE = 0.1  # of the time from one reading to the next: better known it does not matter


def between_readings(experiment: Experiment) -> Experiment:
    """Return a record with a cubic spline through the readings, where its sensor repeats each; else the record.

    Its own clock stays, for turning points are read off even samples. A stair of repeated readings has none: they lie
    half a stair too late, and as long.
    """
    slow = at_sensor_rate(experiment)
    if slow is None or not slow.out:
        return experiment
    taken, y = slow.run.time[~slow.stale], slow.run.position[~slow.stale]
    spline = CubicSpline(taken, y, bc_type="natural")
    smooth = spline(np.clip(experiment.time, taken[0], taken[-1]))
    smooth.setflags(write=False)
    return experiment.model_copy(update={"position": smooth, "counts_per_meter": None})


def all_between_readings(runs: Sequence[Experiment]) -> tuple[list[Experiment], list[str]]:
    """Return runs as `between_readings` does, and say of which that is."""
    _, slow = at_sensor_rates(runs)
    return [between_readings(run) for run in runs], sensor_notes(slow, _read)


def _read(found: AtSensorRate) -> str:
    """Say that a curve is read, and what of it is not known."""
    known = f" When it took them is known to {found.early:.2g} s only: the uncertainties do not contain that."
    return f"A smooth curve through the readings is read.{known if found.early > _SURE * found.period else ''}"
