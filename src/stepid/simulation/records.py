"""All records of a campaign laid end to end, ready for the simulator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array, Index
from stepid.core.experiment import Campaign, Experiment
from stepid.core.hand import release_index
from stepid.core.samples import InputBetween, course, is_even
from stepid.core.slices import of_one_recording
from stepid.simulation.clock import clock
from stepid.simulation.starts import starts_in_motion

_NONE = 1e-4  # square-root weight of a reading that is left out


@dataclass(frozen=True, eq=False)
class Records:
    """Samples of all runs end to end: S samples, R runs.

    `runs` holds the experiments; arrays over samples have shape (S,), arrays over runs (R,). `bounds` (R + 1,) gives
    where each run begins and ends. `moving` marks runs whose record starts in motion, so that their initial state is
    a parameter. `begin` is the index within the experiment at which each run's samples begin. `weight` (S,) are the
    square roots of the samples' weights. `coefficients` (S, 1), (S, 2) or (S, 4) are the polynomial of the input [V]
    from each sample to the next: held, straight or cubic. Where samples were left out, these are the samples `at` (S,).
    `added_mass` may differ from what the experiments say, by what a fit found; `weight_uncertainty` [kg],
    `scale_uncertainty` and `mass_scale` [kg], the largest difference of added masses on one base, 1 at most, are the
    campaign's.
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
    begin: Index
    weight: Array
    coefficients: Array
    at: Index | None = None
    weight_uncertainty: float = 0.0
    scale_uncertainty: float = 0.0
    mass_scale: float = 1.0

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(self.bounds[-1])

    @cached_property
    def weighed_size(self) -> float:
        """Number of samples, each counted by its weight."""
        return float((self.weight**2).sum())

    @property
    def first(self) -> Index:
        """Index of each run's first sample."""
        return self.bounds[:-1]

    @cached_property
    def largest_input(self) -> Array:
        """Largest input of each run, that before its record among them, V, shape (R,)."""
        before: Array = np.abs(self.before)
        return np.maximum(before, np.maximum.reduceat(np.abs(self.volts), self.first)) if self.size else before

    @cached_property
    def one_recording(self) -> bool:
        """Whether all runs are parts of one recording, of one plant: they differ by what changes in it."""
        return of_one_recording(self.runs)

    @property
    def driven(self) -> npt.NDArray[np.bool_]:
        """Runs that an input moves, shape (R,)."""
        out: npt.NDArray[np.bool_] = self.largest_input > 0
        return out

    @property
    def trusted(self) -> npt.NDArray[np.bool_]:
        """Samples that count, shape (S,): wrong readings have hardly any weight."""
        out: npt.NDArray[np.bool_] = self.weight > _NONE
        return out

    def pieces(self) -> list[slice]:
        """Return each run's samples as a slice."""
        return list(self._pieces)

    @cached_property
    def _pieces(self) -> tuple[slice, ...]:
        return tuple(slice(int(a), int(b)) for a, b in pairwise(self.bounds))

    def evenly(self, run: int, values: Array) -> tuple[float, Array]:
        """Values at a run's samples at as many even times, by straight lines, and those times' distance, s."""
        own, even = values[self._pieces[run]], self._even[run]
        if even is None:
            return float(self.sample_time[run]), own
        return float(even[1] - even[0]), np.interp(even, self.time[self._pieces[run]], own)

    def at_samples(self, run: int, values: Array) -> Array:
        """Values at even times, as `evenly` gives them, at the run's samples."""
        even = self._even[run]
        return values if even is None else np.interp(self.time[self._pieces[run]], even, values)

    @cached_property
    def _even(self) -> tuple[Array | None, ...]:
        """As many even times as each run has samples, s; None where its samples are even, or were thinned out."""
        times = [self.time[piece] for piece in self.pieces()]
        thin = self.at is not None
        return tuple(None if thin or is_even(t) else np.linspace(t[0], t[-1], t.size) for t in times)

    def centered(self, values: Array) -> Array:
        """Subtract each run's weighted mean over the last axis: what a free rest position leaves."""
        out: Array = values - np.add.reduceat(values * self._share, self.first, axis=-1)[..., self.run]
        return out

    @cached_property
    def extent(self) -> float:
        """How far from its run's mean a reading is at most, m."""
        return float(np.abs(self.centered(self.position)).max(initial=0.0))

    @cached_property
    def _share(self) -> Array:
        """Weight of each sample in its run, their sum 1, shape (S,)."""
        square = self.weight**2
        out: Array = square / np.add.reduceat(square, self.first)[self.run]
        return out

    def weighted(self, values: Array) -> Array:
        """Centered values times the square roots of the weights: what least squares sees."""
        out: Array = self.centered(values) * self.weight
        return out

    def subset(self, keep: Sequence[int], *, under: Records | None = None) -> Records:
        """Return the records of some runs only, labels unchanged or numbered as those of other records are."""
        index, of = list(keep), under or self
        weight = np.concatenate([self.weight[self.pieces()[i]] for i in index])
        runs = [self.runs[i] for i in index]
        laid = _lay(runs, self.moving[index], (of.bases, of.springs, of.dampers), self.begin[index], weight)
        return replace(self._known(laid), added_mass=self.added_mass[index])

    def like(self, runs: Sequence[Experiment]) -> Records:
        """Lay out other runs under the same labels."""
        none = np.zeros(len(runs))
        laid = _lay(list(runs), none > 0, (self.bases, self.springs, self.dampers), none.astype(np.intp), None)
        return self._known(laid)

    def _known(self, laid: Records) -> Records:
        """Give other records what is known of this campaign's weights and scale."""
        return replace(
            laid,
            weight_uncertainty=self.weight_uncertainty,
            scale_uncertainty=self.scale_uncertainty,
            mass_scale=self.mass_scale,
        )

    def repeated(self, count: int) -> Records:
        """Return the same records several times over, as runs of their own."""
        by_run = ("sample_time", "added_mass", "before", "moving", "base", "spring", "damper", "begin")
        by_sample = ("time", "position", "volts", "weight")
        tiled: dict[str, Any] = {name: np.tile(getattr(self, name), count) for name in (*by_run, *by_sample)}
        bounds = np.append((self.first + self.size * np.arange(count)[:, None]).ravel(), count * self.size)
        return replace(
            self,
            runs=self.runs * count,
            bounds=bounds,
            run=np.repeat(np.arange(len(bounds) - 1), np.diff(bounds)),
            coefficients=np.tile(self.coefficients, (count, 1)),
            at=None,
            **tiled,
        )

    def with_input(self, volts: Array) -> Records:
        """Return the same records with other inputs, shape (S,), that do between the samples what the old ones did."""
        ways = [run.input_between for run in self.runs]
        parts = [course(self.time[p], volts[p], way) for p, way in zip(self.pieces(), ways, strict=True)]
        return replace(self, volts=volts, coefficients=_stacked(parts))

    def with_input_between(self, way: InputBetween, runs: Sequence[int]) -> Records:
        """Return the same records with the input of some runs taken in another way between its samples."""
        chosen = set(runs)
        other = [e.model_copy(update={"input_between": way}) if i in chosen else e for i, e in enumerate(self.runs)]
        return replace(self, runs=tuple(other), coefficients=_coefficients(other, self.begin))

    def reweighted(self, weight: Array) -> Records:
        """Return the same records with other square-root weights, shape (S,)."""
        return replace(self, weight=weight)


def lay_out(campaign: Campaign) -> Records:
    """Lay a campaign's records end to end; what a hand held before a release is left out."""
    runs = list(campaign.experiments)
    labels = tuple(tuple(dict.fromkeys(getattr(e, field) for e in runs)) for field in ("base", "spring", "damper"))
    moving = np.array([starts_in_motion(e) for e in runs])
    begin = np.array([release_index(e) if m else 0 for e, m in zip(runs, moving, strict=True)], dtype=np.intp)
    laid = _lay(runs, moving, (labels[0], labels[1], labels[2]), begin, None)
    return replace(
        laid,
        weight_uncertainty=campaign.weight_uncertainty,
        scale_uncertainty=campaign.scale_uncertainty,
        mass_scale=min(mass_span(laid) or 1.0, 1.0),  # 1 kg where none differ: it is assumed then
    )


def mass_span(records: Records) -> float:
    """Largest difference of added masses on one base, kg; 0 where none differ."""
    spans = [float(np.ptp(records.added_mass[records.base == base])) for base in np.unique(records.base)]
    return max(spans, default=0.0)


def _coefficients(runs: Sequence[Experiment], begin: Index) -> Array:
    parts = [course(clock(e), e.input, e.input_between)[b:] for e, b in zip(runs, begin, strict=True)]
    return _stacked(parts)


def _stacked(parts: Sequence[Array]) -> Array:
    """Polynomials of all runs end to end, zeros for the terms that a run does not have."""
    out = np.zeros((sum(len(part) for part in parts), max(part.shape[1] for part in parts)))
    at = 0
    for part in parts:
        out[at : at + len(part), : part.shape[1]] = part
        at += len(part)
    return out


def _lay(
    runs: list[Experiment],
    moving: npt.NDArray[np.bool_],
    labels: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]],
    begin: Index,
    weight: Array | None,
) -> Records:
    sizes = [e.time.size - int(b) for e, b in zip(runs, begin, strict=True)]
    bases, springs, dampers = labels

    def joined(field: str) -> Array:
        return np.concatenate([getattr(e, field)[b:] for e, b in zip(runs, begin, strict=True)])

    sample_time = np.array([e.sample_time for e in runs])
    return Records(
        runs=tuple(runs),
        bounds=np.concatenate([[0], np.cumsum(sizes)]).astype(np.intp),
        run=np.repeat(np.arange(len(runs)), sizes),
        time=np.concatenate([clock(e)[b:] - e.time[0] for e, b in zip(runs, begin, strict=True)]),
        position=joined("position"),
        volts=joined("input"),
        sample_time=sample_time,
        added_mass=np.array([e.added_mass for e in runs]),
        before=np.array([e.input_before for e in runs]),
        moving=moving,
        bases=bases,
        springs=springs,
        dampers=dampers,
        base=np.array([bases.index(e.base) for e in runs], dtype=np.intp),
        spring=np.array([springs.index(e.spring) for e in runs], dtype=np.intp),
        damper=np.array([dampers.index(e.damper) for e in runs], dtype=np.intp),
        begin=begin,
        weight=np.ones(sum(sizes)) if weight is None else weight,
        coefficients=_coefficients(runs, begin),
    )
