"""Readings that jump at one sample and stay so: an encoder lost counts, or a marker slipped."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.noise import reading_step
from stepid.core.words import length
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault_size import DECIDES, count_samples
from stepid.simulation.records import Records

_MOST = 0.7  # share of what is left above the noise that the jump must take
_SHARP = 0.3  # of the jump, by which the readings on either side of it may differ by more or less
_BESIDE = 0.05  # of the period, at most, in which they do: a motion changes by little
_FEWEST = 5  # samples on either side
_SEEN = 0.02  # of a step's power that a fit's own parameters must leave of it
_SURE = 5.0  # standard deviations


class Jump(NamedTuple):
    """The readings of a run are off by `size`, m, from the reading at `time`, s, on; and its fault in words."""

    run: str
    time: float
    size: float
    fault: RecordFault

    def mended(self, campaign: Campaign) -> Campaign:
        """Take the jump out of a campaign's readings."""
        runs = []
        for run in campaign.experiments:
            if run.name == self.run:
                position = np.where(run.time < self.time, run.position, run.position - self.size)
                position.setflags(write=False)
                run = run.model_copy(update={"position": position})
            runs.append(run)
        return campaign.model_copy(update={"experiments": tuple(runs)})


def find_jump(fit: Optimum, floor: float, period: float) -> Jump | None:
    """Find one jump in the readings of one run that takes most of what a fit leaves above the noise.

    Every sample of every run is tried, the fit's own parameters free in one linearized step. The readings just before
    and just after have to differ by as much: what drifts is no jump.

    Parameters
    ----------
    fit : Optimum
        Best fit so far.
    floor : float
        m.
    period : float
        s, of the plant.

    Returns
    -------
    Jump or None
    """
    problem, records = fit.problem, fit.problem.records
    residual, jacobian = problem.residual(fit.solved), problem.jacobian(fit.solved)
    excess = float(residual @ residual) - floor**2 * count_samples(records)
    size = np.linalg.norm(jacobian, axis=0)
    if excess <= 0 or not np.isfinite(size).all():
        return None
    own = np.linalg.qr(jacobian[:, size > 0] / size[size > 0])[0]
    rest = residual - own @ (own.T @ residual)
    found = [_strongest(rest, own, records, run) for run in range(len(records.runs))]
    run = int(np.argmax([gain for gain, _, _ in found]))
    gain, sample, jump = found[run]
    others = max((g for i, (g, _, _) in enumerate(found) if i != run), default=0.0)
    noise = max(float(rest @ rest) - gain, 0.0) / count_samples(records)
    if gain < max(_MOST * excess, _SURE**2 * noise, others + DECIDES * noise):
        return None
    if not _is_sharp(rest, records, run, sample, jump, period):
        return None
    return _told(records, run, sample, jump)


def _strongest(rest: Array, own: Array, records: Records, run: int) -> tuple[float, int, float]:
    """Power [m²] that a jump in a run takes of a rest, its sample within the run, and its size, m."""
    piece = records.pieces()[run]
    weight = records.weight[piece]
    if weight.size <= 2 * _FEWEST:
        return 0.0, 0, 0.0

    def later(values: Array) -> Array:
        """Sums from each sample on: the product of a step there with what has no mean."""
        out: Array = np.cumsum(values[::-1], axis=0)[::-1]
        return out

    product, square = later(weight * rest[piece]), later(weight**2)
    square -= square**2 / square[0]
    seen = square - np.sum(later(weight[:, None] * own[piece]) ** 2, axis=1)
    able = seen > _SEEN * square
    able[:_FEWEST] = able[-_FEWEST:] = False
    gain = np.where(able, product**2 / np.where(able, seen, 1.0), 0.0)
    at = int(np.argmax(gain))
    return float(gain[at]), at, float(product[at] / seen[at]) if able[at] else 0.0


def _is_sharp(rest: Array, records: Records, run: int, sample: int, jump: float, period: float) -> bool:
    """Tell whether the readings beside a sample differ by a jump, within what their noise allows."""
    piece = records.pieces()[run]
    weight = records.weight[piece]
    near = max(_FEWEST, int(_BESIDE * period / float(records.sample_time[run])))
    sides = [slice(max(sample - near, 0), sample), slice(sample, sample + near)]
    if any(weight[side].sum() <= 0 for side in sides):
        return False
    values = [float(rest[piece][side].sum() / weight[side].sum()) for side in sides]
    spread = np.sqrt(sum(float(np.var(rest[piece][side])) / weight[side].size for side in sides))
    return abs(values[1] - values[0] - jump) <= _SHARP * abs(jump) + float(spread)


def _told(records: Records, run: int, sample: int, jump: float) -> Jump:
    record = records.runs[run]
    time = float(record.time[records.begin[run] + sample])
    step = reading_step(record)
    counts = f", {abs(jump) / step:.0f} steps of the sensor," if step > 0 else ""
    words = (
        f"Run {record.name!r}: its readings jump by {length(abs(jump))}{counts} at {time:.4g} s and stay so. "
        "Did the encoder lose counts, or a marker slip?"
    )
    fault = RecordFault(run=record.name, kind="jump", size=jump, unit="m", words=words)
    return Jump(record.name, time, jump, fault)
