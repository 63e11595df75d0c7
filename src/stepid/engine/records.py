"""All records of a campaign laid end to end, ready for the simulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stepid._base import Array
from stepid.experiment import Campaign, Experiment

Index = npt.NDArray[np.intp]


@dataclass(frozen=True)
class Records:
    """Samples of all runs end to end: S samples, R runs.

    `runs` holds the experiments; arrays over samples have shape (S,), arrays over runs (R,). `bounds` (R + 1,) gives
    where each run begins and ends. `moving` marks runs whose record starts in motion, so that their initial state is
    a parameter.
    """

    runs: tuple[Experiment, ...]
    bounds: Index
    run: Index
    time: Array
    position: Array
    volts: Array
    sample_time: Array
    added_mass: Array
    before: Array
    moving: npt.NDArray[np.bool_]
    bases: tuple[str, ...]
    springs: tuple[str, ...]
    dampers: tuple[str, ...]
    base: Index
    spring: Index
    damper: Index

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(self.bounds[-1])

    @property
    def first(self) -> Index:
        """Index of each run's first sample."""
        return self.bounds[:-1]

    def pieces(self) -> list[slice]:
        """Return each run's samples as a slice."""
        return [slice(int(a), int(b)) for a, b in zip(self.bounds[:-1], self.bounds[1:], strict=True)]

    def centered(self, values: Array) -> Array:
        """Subtract each run's mean over the last axis: what a free rest position leaves."""
        sums = np.add.reduceat(values, self.first, axis=-1)
        out: Array = values - (sums / np.diff(self.bounds))[..., self.run]
        return out

    def subset(self, keep: Sequence[int]) -> Records:
        """Return the records of some runs only, labels unchanged."""
        return _lay([self.runs[i] for i in keep], self.moving[list(keep)], (self.bases, self.springs, self.dampers))


def starts_in_motion(experiment: Experiment) -> bool:
    """Tell whether a record starts in motion: its motion comes from no input that the record shows."""
    if not experiment.is_release:
        return False
    return bool(np.ptp(experiment.position) > 0)


def lay_out(campaign: Campaign) -> Records:
    """Lay a campaign's records end to end."""
    runs = list(campaign.experiments)
    labels = tuple(
        tuple(dict.fromkeys(getattr(e, field) for e in runs)) for field in ("base", "spring", "damper")
    )
    return _lay(runs, np.array([starts_in_motion(e) for e in runs]), (labels[0], labels[1], labels[2]))


def _lay(
    runs: list[Experiment],
    moving: npt.NDArray[np.bool_],
    labels: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]],
) -> Records:
    sizes = [e.time.size for e in runs]
    bases, springs, dampers = labels
    return Records(
        runs=tuple(runs),
        bounds=np.concatenate([[0], np.cumsum(sizes)]).astype(np.intp),
        run=np.repeat(np.arange(len(runs)), sizes),
        time=np.concatenate([e.time - e.time[0] for e in runs]),
        position=np.concatenate([e.position for e in runs]),
        volts=np.concatenate([e.input for e in runs]),
        sample_time=np.array([e.sample_time for e in runs]),
        added_mass=np.array([e.added_mass for e in runs]),
        before=np.array([e.input_before for e in runs]),
        moving=moving,
        bases=bases,
        springs=springs,
        dampers=dampers,
        base=np.array([bases.index(e.base) for e in runs], dtype=np.intp),
        spring=np.array([springs.index(e.spring) for e in runs], dtype=np.intp),
        damper=np.array([dampers.index(e.damper) for e in runs], dtype=np.intp),
    )
