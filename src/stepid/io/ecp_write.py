"""The ECP export as bytes, for records that it holds exactly."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.errors import InputError
from stepid.io.ecp import FULL_SCALE, export_experiment
from stepid.io.ecp_layout import parse_export

_HEADER = " Sample   Time     Commanded Pos   Encoder 1 Pos   Control Effort\r\n\n"


def render_export(experiment: Experiment) -> tuple[str, float] | None:
    """Write an experiment as an ECP export, where it reads back equal.

    Parameters
    ----------
    experiment : Experiment

    Returns
    -------
    (text, sample_time) or None
        The file, and the sample time in s that belongs to it; None where positions are not whole counts, inputs do
        not have four decimals, or a number does not fit its column.
    """
    scale = experiment.counts_per_meter
    if scale is None:
        return None
    with np.errstate(all="ignore"):
        counts: Array = np.rint(experiment.position * scale)
        first = float(np.rint(experiment.time[0] / experiment.sample_time))
        if not np.array_equal(counts / scale, experiment.position) or not np.all(np.abs(counts) < 1e14):
            return None
    if not 0 <= first < 1e5 - experiment.time.size or experiment.time[-1] >= 1e4:
        return None
    if np.abs(experiment.input).max() > FULL_SCALE:
        return None
    sample: Array = first + np.arange(experiment.time.size, dtype=np.float64)
    period = _period(sample, experiment)
    if period is None:
        return None
    text = _text(sample, experiment.time, counts, experiment.input)
    return (text, period) if _reads_back(text, period, experiment) else None


def _period(sample: Array, experiment: Experiment) -> float | None:
    """The sample time whose multiples are the experiment's times, bit for bit."""
    guess = experiment.sample_time
    # a product with a power of two is exact, so such a sample gives the factor away
    exact = [t / n for n, t in zip(sample, experiment.time, strict=True) if n > 0 and np.frexp(n)[0] == 0.5]
    near = [guess, float(np.nextafter(guess, 0)), float(np.nextafter(guess, np.inf))]
    return next((float(p) for p in [*exact[-1:], *near] if np.array_equal(sample * p, experiment.time)), None)


def _text(sample: Array, time: Array, counts: Array, effort: Array) -> str:
    rows = [
        f"{n:6.0f}{t:9.3f}{c:16.0f}{c:16.0f}{u:16.4f}"
        for n, t, c, u in zip(sample, time, counts + 0.0, effort + 0.0, strict=True)
    ]
    rows[0] = "[" + rows[0][1:]
    return _HEADER + ";\r\n".join(rows) + "]\r\n"


def _reads_back(text: str, period: float, experiment: Experiment) -> bool:
    lines = text.replace("\r\n", "\n").split("\n")
    try:
        again = export_experiment(
            parse_export(lines, columns=None, where="export"),
            where="export",
            counts_per_meter=experiment.counts_per_meter or 0.0,
            encoder=1,
            name=experiment.name,
            added_mass=experiment.added_mass,
            spring=experiment.spring,
            damper=experiment.damper,
            base=experiment.base,
            input=None,
            input_before=experiment.input_before,
            input_between=experiment.input_between,
            starts=experiment.starts,
            sample_time=period,
            effort_scale=None,
        )
    except InputError:
        return False
    return again == experiment
