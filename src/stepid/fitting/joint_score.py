"""How much several effects could explain together, by one linearized step on the measured motion: for starts only.

One at a time, an effect whose response looks like another's is overlooked until that one is there, and a fit of the
wrong one first may end far from both. Together they cost no further simulation: sums of products of the responses that
are at hand tell all pairs, and on the best pairs all further effects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.score_test import Column
from stepid.fitting.tangent import scaled_to_one

_OPEN = 1e-6  # eigenvalue, over the largest, of a direction that the responses leave open
_BEAM = 40  # sets of which each is scored with every further effect


class Beside(Protocol):
    """What parts of a residual and of responses a plant's own parameters can follow: `Tangent`, or another."""

    @property
    def left(self) -> Array:
        """Residual that they leave, shape (rows,)."""
        ...

    @property
    def samples(self) -> float:
        """How many of the residual's samples are independent, less those parameters."""
        ...

    def beyond(self, seen: Array) -> Array:
        """What they cannot follow of responses, shape (rows,) or (rows, k)."""
        ...

    def adapted(self, seen: Array) -> Array:
        """The plant's shared parameters beside a response of shape (rows,)."""
        ...


class ScoredSet(NamedTuple):
    """A start of several effects on a fit: their values, the fit's parameters then, and the share of the residual left.

    `inner` is the least share that a set with one effect less promises to leave.
    """

    effects: tuple[Effect, ...]
    values: tuple[tuple[float, ...], ...]
    shared: Array
    left: float
    inner: float


class _Found(NamedTuple):
    blocks: tuple[int, ...]
    left: float
    coefficients: Array


class _Blocks:
    """Responses of a fit to every start of the effects, less what its own parameters can follow."""

    def __init__(self, tangent: Beside, table: Sequence[Column]) -> None:
        self.columns: list[Column] = []
        self.scales: list[Array] = []
        parts: list[Array] = []
        for column in table:
            scaled = scaled_to_one(tangent.beyond(column.responses))
            if scaled is not None:
                parts.append(scaled[0])
                self.scales.append(scaled[1])
                self.columns.append(column)
        every = np.concatenate(parts, axis=1) if parts else np.zeros((tangent.left.size, 0))
        self._gram, self._along = every.T @ every, every.T @ tangent.left
        self._total, self._samples = float(tangent.left @ tangent.left), tangent.samples
        ends = np.cumsum([0, *(scale.size for scale in self.scales)])
        self._places = [np.arange(a, b) for a, b in pairwise(ends)]

    def effects(self, blocks: Iterable[int]) -> tuple[Effect, ...]:
        return tuple(self.columns[b].effect for b in blocks)

    def solved(self, blocks: tuple[int, ...]) -> _Found:
        """Least squares by some blocks."""
        place = np.concatenate([self._places[b] for b in blocks])
        values, vectors = np.linalg.eigh(self._gram[np.ix_(place, place)])
        kept = values > _OPEN * values[-1]
        seen = vectors[:, kept].T @ self._along[place]
        gain = float(np.sum(seen**2 / values[kept])) / self._total
        free = 1.0 - min(place.size / self._samples, 1.0)
        left = max(1.0 - gain, 0.0) / free**2 if free > 0 else math.inf  # as cross-validation would find
        return _Found(blocks, left, vectors[:, kept] @ (seen / values[kept]))

    def start(self, found: _Found) -> tuple[tuple[tuple[float, ...], ...], Array] | None:
        """Values of the effects, and their responses together; None where a law cannot have such a strength."""
        out, response, at = [], np.zeros(self.columns[0].responses.shape[0]), 0
        for b in found.blocks:
            own = found.coefficients[at : at + self.scales[b].size] / self.scales[b]
            values = self.columns[b].values(own)
            if values is None:
                return None
            out.append(values)
            response = response + self.columns[b].responses @ own
            at += own.size
        return tuple(out), response


def score_sets(
    beside: Beside, table: Sequence[Column], size: int, count: int, *, apart: Callable[[Effect, Effect], bool]
) -> list[ScoredSet]:
    """Score sets of starts against a residual: all pairs, larger ones by a beam.

    What is left counts by generalized cross-validation (Golub, Heath and Wahba, Technometrics 21, 1979).

    Parameters
    ----------
    beside : Beside
        Whose residual, and what need not be explained of it.
    table : sequence of Column
        From `stepid.fitting.score_test.columns`, or of the same rows.
    size : int
        Effects of a set, 2 or more.
    count : int
        Starts of each set of effects.
    apart : callable
        Tells whether two effects may stand beside each other.

    Returns
    -------
    list of ScoredSet
        The best few of each set of effects; what leaves least first.
    """
    blocks = _Blocks(beside, table)
    numbers = range(len(blocks.columns))
    level = [blocks.solved((b,)) for b in numbers]
    inner: dict[frozenset[str], float] = {}
    for width in range(1, size):
        inner = _least(blocks, level)
        grown = {
            tuple(sorted((*f.blocks, b)))
            for f in (level if width == 1 else sorted(level, key=lambda f: f.left)[:_BEAM])
            for b in numbers
            if all(apart(e, blocks.columns[b].effect) for e in blocks.effects(f.blocks))
        }
        level = [blocks.solved(some) for some in sorted(grown)]
    out: list[ScoredSet] = []
    taken: dict[frozenset[str], int] = {}
    for found in sorted(level, key=lambda f: f.left):
        effects = blocks.effects(found.blocks)
        names = frozenset(e.name for e in effects)
        begun = blocks.start(found) if taken.get(names, 0) < count else None
        if begun is None:
            continue
        taken[names] = taken.get(names, 0) + 1
        within = min(inner.get(names - {name}, math.inf) for name in names)
        out.append(ScoredSet(effects, begun[0], beside.adapted(begun[1]), found.left, within))
    return out


def _least(blocks: _Blocks, level: Sequence[_Found]) -> dict[frozenset[str], float]:
    """Least share left by each set of effects, by its starts that a law can have."""
    out: dict[frozenset[str], float] = {}
    for found in level:
        names = frozenset(e.name for e in blocks.effects(found.blocks))
        if found.left < out.get(names, math.inf) and blocks.start(found) is not None:
            out[names] = found.left
    return out
