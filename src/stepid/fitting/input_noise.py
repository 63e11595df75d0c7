"""An input that was measured: the drive held its levels, and readings scatter about them, or a few are wrong."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.experiment import Campaign
from stepid.core.input_levels import at_levels, beside_levels, held_bounds, lone_samples, without_samples
from stepid.core.noise import rms
from stepid.core.words import at_samples, counted, runs_named
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.simulator import Simulator

_APART = 3.0  # standard uncertainties of a difference, within which two levels are one, or chance is enough


class Held(NamedTuple):
    """A campaign with inputs as its drive may have held them, and what is said of how they were read if it did."""

    campaign: Campaign
    said: tuple[str, ...]
    faults: tuple[RecordFault, ...] = ()


def follows(held: Optimum, read: Optimum) -> bool:
    """Tell whether a cart follows what is read of its input beside the levels.

    The linear plant that is fitted to the levels tells how it would move by that: at least half of it must be in what
    the plant leaves, and more than of such a motion at other times. Whatever else is missing, a lag or friction, is in
    either. Where the levels tell no plant, as those of an input that is noise, what is read must leave less than half
    of what they do.

    Parameters
    ----------
    held : Optimum
        Linear plant fitted to the runs with their inputs at their levels.
    read : Optimum
        The same with their inputs as they were read.
    """
    moved = Simulator(read.problem.records, ()).readings(held.shared[None], held.local[None])[0] - held.solved.reading
    spectra = np.fft.rfft(held.residual), np.fft.rfft(moved)
    shared = np.fft.irfft(spectra[0] * spectra[1].conj(), moved.size)  # with that motion later by each sample
    clear = 2 * shared[0] > moved @ moved and shared[0] > _APART * rms(shared)
    return bool(2 * read.cost < held.cost or clear)


class _Read(NamedTuple):
    """What is read of one level: its mean and standard uncertainty, V."""

    mean: float
    spread: float


def without_lone_samples(campaign: Campaign) -> Held | None:
    """Hold each input at its level where up to three samples leave it for another; None where none do.

    A blow that is all a run is driven by is none of them.

    Parameters
    ----------
    campaign : Campaign
    """
    held, faults = list(campaign.experiments), []
    for number, run in enumerate(campaign.experiments):
        lone = lone_samples(run.input)
        volts = without_samples(run.input, lone)
        if lone and np.ptp(volts) > 0:
            held[number] = run.model_copy(update={"input": volts})
            faults.append(_misread(run.name, volts, run.input))
    if not faults:
        return None
    said = tuple(fault.words for fault in faults)
    return Held(campaign.model_copy(update={"experiments": tuple(held)}), said, tuple(faults))


def _misread(name: str, held: Array, read: Array) -> RecordFault:
    """Samples at which an input was misread."""
    at = np.flatnonzero(held != read)
    off, many = float(np.abs(held - read).max()), at.size > 1
    of = f"{counted(at.size, 'reading')} of its input ({at_samples(at.tolist())})"
    is_off = f"{'are up to' if many else 'is'} {off:.3g} V beside the level around {'them' if many else 'it'}"
    words = f"Run {name!r}: {of} {is_off}, which the cart does not follow: that level is taken."
    return RecordFault(run=name, kind="misread input", size=off, unit="V", words=words)


def pooled_levels(campaign: Campaign) -> Held | None:
    """Hold each input at its levels where it scatters about these; None where no input does.

    Levels that the noise does not tell apart are one, in whichever runs.

    Parameters
    ----------
    campaign : Campaign
    """
    found = {run.name: bounds for run in campaign.experiments if (bounds := held_bounds(run)) is not None}
    if not found:
        return None
    read, noise = {}, {}
    for run in (run for run in campaign.experiments if run.name in found):
        parts = [run.input[a:b] for a, b in pairwise(found[run.name])]
        scatter = beside_levels(run.input, found[run.name])
        noise[run.name] = float(np.std(scatter))
        few = _alike(scatter)
        read[run.name] = [
            _Read(float(part.mean()), noise[run.name] * np.sqrt(min(few / part.size, 1.0))) for part in parts
        ]
    level = _pooled(sorted({one for some in read.values() for one in some}))
    runs = tuple(
        at_levels(run, found[run.name], [level[one] for one in read[run.name]]) if run.name in found else run
        for run in campaign.experiments
    )
    return Held(campaign.model_copy(update={"experiments": runs}), (_noisy(noise),))


def _noisy(noise: dict[str, float]) -> str:
    """Say whose input is noisy, by the standard deviation of each, V, and what is taken for it."""
    return (
        f"The input of {runs_named(list(noise))} is read with noise of up to {max(noise.values()):.2g} V. "
        "The cart does not follow that noise, so the levels are taken that the input was held at."
    )


def _alike(scatter: Array) -> float:
    """How many samples of noise tell as much as one: 1 where it is white, (1 + ρ) / (1 − ρ) where it is AR(1)."""
    power = float(scatter @ scatter)
    like = max(1.0 - float(np.sum(np.diff(scatter) ** 2)) / (2 * power), 0.0) if power > 0 else 0.0
    return (1.0 + like) / max(1.0 - like, 1.0 / scatter.size)


def _pooled(read: Sequence[_Read]) -> dict[_Read, float]:
    """Level of each, V, of those in order that lie within the noise of the one before the mean."""
    groups: list[list[_Read]] = []
    for one in read:
        last = groups[-1][-1] if groups else None
        if last is not None and one.mean - last.mean <= _APART * float(np.hypot(one.spread, last.spread)):
            groups[-1].append(one)
        else:
            groups.append([one])
    means = [np.average([r.mean for r in some], weights=[r.spread**-2.0 for r in some]) for some in groups]
    return {one: float(mean) for some, mean in zip(groups, means, strict=True) for one in some}
