"""Readings that repeat for longer than their noise allows: a sensor was clipped or stuck, and no cart at rest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Experiment
from stepid.core.noise import reading_step
from stepid.core.outliers import Mask
from stepid.core.words import length
from stepid.fitting.clipped import clipped, clipped_fault
from stepid.fitting.reading_faults import Mended
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.starts import starts_in_motion

_NEVER = 1e-6  # probability that noise repeats a reading so often anywhere in a record
_LEAST = 9  # samples: of fewer `stepid.fitting.reading_faults` knows
_ENOUGH = 10  # samples at rest before a step, of which the noise can be told


def flat_readings(runs: Sequence[Experiment]) -> dict[str, Mended]:
    """Find records with samples that a clipped or stuck sensor read, by run name: what is left out of them.

    These repeat a reading for longer than the noise of carts at rest allows, or stay at the end of the sensor's range
    in several swings (`stepid.fitting.clipped.clipped`).

    That noise is what neighbors differ by before a step, in the run where they do least: a rest that an encoder does
    not resolve says nothing, and a cart that creeps there is no noise. White noise of σ [m], read in steps of q,
    repeats a reading with a probability of erf(q / (2 √2 σ)) at most.

    Parameters
    ----------
    runs : sequence of Experiment

    Returns
    -------
    dict
        Of each such run the record as it is, which samples these are, and what is said; the fault's size is how long
        they last, s. No reading is interpolated: what a clipped cart did in the meantime is not known.
    """
    noise = min((float(np.std(np.diff(y)) / math.sqrt(2)) for y in _rests(runs)), default=0.0)
    found: dict[str, Mended] = {}
    for run in runs if noise > 0 else ():
        step = reading_step(run)
        if step > noise:
            continue
        repeats = math.erf(step / (2 * math.sqrt(2) * noise))
        most = math.log(_NEVER / run.position.size) / math.log(repeats) if repeats > 0 else 0.0
        flat = _repeated(run.position, max(_LEAST, math.ceil(1 + most)))
        if flat.any():
            found[run.name] = Mended(run, flat, (_fault(run, flat, noise),))
    for run in runs:
        if run.name not in found and (cut := clipped(run)).any():
            found[run.name] = Mended(run, cut, (clipped_fault(run, cut),))
    return found


def _rests(runs: Sequence[Experiment]) -> Iterator[Array]:
    """Readings of runs at rest before their input first changes, of those where they are enough."""
    for run in runs:
        changes = np.flatnonzero(np.diff(run.input, prepend=run.input_before))
        if changes.size and changes[0] >= _ENOUGH and not starts_in_motion(run):
            yield run.position[: changes[0]]


def _repeated(y: Array, least: int) -> Mask:
    """Samples of stretches of at least so many readings that are the same."""
    edges = np.flatnonzero(np.concatenate([[True], np.diff(y) != 0, [True]]))
    counts = np.diff(edges)
    out: Mask = np.repeat(counts >= least, counts)
    return out


def _fault(run: Experiment, flat: Mask, noise: float) -> RecordFault:
    at = np.flatnonzero(flat)
    words = (
        f"Run {run.name!r} repeats readings in {at.size} samples, from {run.time[at[0]] - run.time[0]:.3g} s on, "
        f"though the noise at rest is {length(noise)}: the sensor was clipped or stuck. These samples are left out."
    )
    size = float(at.size * run.sample_time)
    return RecordFault(run=run.name, kind="flat readings", size=size, unit="s", words=words)
