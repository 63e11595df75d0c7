"""Noise of an input that was measured: the drive held its levels, and the readings scatter about them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stepid.core.base import Index
from stepid.core.experiment import Campaign, Experiment
from stepid.core.input_levels import STEP, level_bounds
from stepid.core.words import listed

_APART = 3.0  # standard uncertainties of a difference, within which two levels are one


class Levels(NamedTuple):
    """A campaign with inputs that are held at their levels, and what was read of them beside that."""

    campaign: Campaign
    noise: dict[str, float]  # V, standard deviation, by run

    @property
    def note(self) -> str:
        """Say whose input is noisy, and what is taken for it."""
        most = max(self.noise.values())
        runs = listed([repr(name) for name in self.noise], "and")
        return (
            f"The input of run{'s' * (len(self.noise) > 1)} {runs} is read with noise of up to {most:.2g} V. "
            "The cart does not follow that noise, so the levels are taken that the input was held at."
        )


class _Read(NamedTuple):
    """What is read of one level: its mean and standard uncertainty, V."""

    mean: float
    spread: float


def at_levels(campaign: Campaign) -> Levels | None:
    """Hold each input at its levels where it scatters about these like white noise; None where no input does.

    Levels that the noise does not tell apart are one, in whichever runs.

    Parameters
    ----------
    campaign : Campaign
    """
    found = {run.name: bounds for run in campaign.experiments if (bounds := _bounds(run)) is not None}
    if not found:
        return None
    read, noise = {}, {}
    for run in (run for run in campaign.experiments if run.name in found):
        parts = [run.input[a:b] for a, b in pairwise(found[run.name])]
        scatter = np.concatenate([part - part.mean() for part in parts])
        noise[run.name] = float(np.std(scatter))
        read[run.name] = [_Read(float(part.mean()), noise[run.name] / np.sqrt(part.size)) for part in parts]
    level = _pooled(sorted({one for some in read.values() for one in some}))
    runs = tuple(
        _held(run, found[run.name], [level[one] for one in read[run.name]]) if run.name in found else run
        for run in campaign.experiments
    )
    return Levels(campaign.model_copy(update={"experiments": runs}), noise)


def _bounds(run: Experiment) -> Index | None:
    return level_bounds(run.input) if run.input_between == "held" else None


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


def _held(run: Experiment, bounds: Index, levels: Sequence[float]) -> Experiment:
    """A run with its input at these levels; it rested at the first where that is no step from what it says."""
    held = np.repeat(levels, np.diff(bounds))
    no_step = abs(levels[0] - run.input_before) <= STEP * float(np.ptp([run.input_before, *levels]))
    before = levels[0] if no_step else run.input_before
    return run.model_copy(update={"input": held, "input_before": before})
