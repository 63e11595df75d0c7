"""How much several effects could explain together, by one linearized step on the measured motion: for starts only.

One at a time, an effect whose response looks like another's is overlooked until that one is there, and a fit of the
wrong one first may end far from both. Together they cost no further simulation: sums of products of the responses that
are at hand tell all pairs, and on the best pairs all further effects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.score_test import Column
from stepid.fitting.tangent import scaled_parts

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
    """A start of several effects: their values, and the share of the residual that they leave.

    `inner` is the least share that a set with one effect less promises to leave; `blocks` are its columns of the table,
    `coefficients` their strengths.
    """

    effects: tuple[Effect, ...]
    values: tuple[tuple[float, ...], ...]
    left: float
    inner: float
    blocks: tuple[int, ...]
    coefficients: Array


class _Found(NamedTuple):
    blocks: tuple[int, ...]
    left: float
    coefficients: Array  # of the columns scaled to one


class JointScore:
    """Scores of sets of starts against a residual: all pairs, larger ones by a beam.

    What is left counts by generalized cross-validation (Golub, Heath and Wahba, Technometrics 21, 1979).

    Parameters
    ----------
    beside : Beside
        Whose residual, and what need not be explained of it.
    table : sequence of Column
        From `stepid.fitting.score_test.columns`, or of the same rows.
    apart : callable
        Tells whether two effects may stand beside each other.
    """

    def __init__(self, beside: Beside, table: Sequence[Column], *, apart: Callable[[Effect, Effect], bool]) -> None:
        self._beside, self._columns, self._scales = beside, list[Column](), list[Array]()
        parts: list[Array] = []
        for column, scaled in zip(table, scaled_parts(beside.beyond, [c.responses for c in table]), strict=True):
            if scaled is not None:
                parts.append(scaled[0])
                self._scales.append(scaled[1])
                self._columns.append(column)
        every = np.concatenate(parts, axis=1) if parts else np.zeros((beside.left.size, 0))
        self._gram, self._along = every.T @ every, every.T @ beside.left
        self._total = float(beside.left @ beside.left)
        ends = np.cumsum([0, *(scale.size for scale in self._scales)])
        self._places = [np.arange(a, b) for a, b in pairwise(ends)]
        effects = [column.effect for column in self._columns]
        self._apart = np.array([[apart(a, b) for b in effects] for a in effects], dtype=bool)
        self._levels: list[list[_Found]] = [self._solved([(b,) for b in range(len(effects))])]

    def sets(self, size: int, count: int) -> list[ScoredSet]:
        """Score sets of so many effects, 2 or more: the best few starts of each, what leaves least first."""
        inner = self._least(self._level(size - 1))
        out: list[ScoredSet] = []
        taken: dict[frozenset[str], int] = {}
        for found in sorted(self._level(size), key=lambda f: f.left):
            effects = tuple(self._columns[b].effect for b in found.blocks)
            names = frozenset(e.name for e in effects)
            values = self._values(found) if taken.get(names, 0) < count else None
            if values is None:
                continue
            taken[names] = taken.get(names, 0) + 1
            within = min(inner.get(names - {name}, math.inf) for name in names)
            out.append(ScoredSet(effects, values, found.left, within, found.blocks, self._unscaled(found)))
        return out

    def adapted(self, found: ScoredSet) -> Array:
        """The plant's shared parameters beside a set."""
        responses = np.concatenate([self._columns[b].responses for b in found.blocks], axis=1)
        return self._beside.adapted(responses @ found.coefficients)

    def _level(self, size: int) -> list[_Found]:
        """Sets of so many columns, solved; they are kept."""
        while len(self._levels) < size:
            last = self._levels[-1]
            kept = last if len(self._levels) == 1 else sorted(last, key=lambda f: f.left)[:_BEAM]
            able = [np.flatnonzero(self._apart[list(f.blocks)].all(axis=0)) for f in kept]
            grown = {tuple(sorted((*f.blocks, int(b)))) for f, new in zip(kept, able, strict=True) for b in new}
            self._levels.append(self._solved(sorted(grown)))
        return self._levels[size - 1]

    def _solved(self, sets: Sequence[tuple[int, ...]]) -> list[_Found]:
        """Least squares by each of some sets of columns: those with as many coefficients at once."""
        places = [np.concatenate([self._places[b] for b in blocks]) for blocks in sets]
        out: list[_Found] = []
        for size in sorted({place.size for place in places}):
            alike = [i for i, place in enumerate(places) if place.size == size]
            place = np.array([places[i] for i in alike])
            values, vectors = np.linalg.eigh(self._gram[place[:, :, None], place[:, None, :]])
            seen = np.einsum("nij,ni->nj", vectors, self._along[place])
            with np.errstate(divide="ignore", invalid="ignore"):
                part = np.where(values > _OPEN * values[:, -1:], seen / values, 0.0)
            free = 1.0 - min(size / self._beside.samples, 1.0)
            left = np.maximum(1.0 - np.sum(seen * part, axis=1) / self._total, 0.0)
            left = left / free**2 if free > 0 else np.full(len(alike), math.inf)  # as cross-validation would find
            coefficients = np.einsum("nij,nj->ni", vectors, part)
            out += [_Found(sets[i], float(share), own) for i, share, own in zip(alike, left, coefficients, strict=True)]
        return out

    def _unscaled(self, found: _Found) -> Array:
        out: Array = found.coefficients / np.concatenate([self._scales[b] for b in found.blocks])
        return out

    def _values(self, found: _Found) -> tuple[tuple[float, ...], ...] | None:
        """Values of the effects; None where a law cannot have such a strength."""
        out, at, strengths = [], 0, self._unscaled(found)
        for b in found.blocks:
            values = self._columns[b].values(strengths[at : at + self._scales[b].size])
            if values is None:
                return None
            out.append(values)
            at += self._scales[b].size
        return tuple(out)

    def _least(self, level: Sequence[_Found]) -> dict[frozenset[str], float]:
        """Least share left by each set of effects, by its starts that a law can have."""
        out: dict[frozenset[str], float] = {}
        for found in level:
            names = frozenset(self._columns[b].effect.name for b in found.blocks)
            if found.left < out.get(names, math.inf) and self._values(found) is not None:
                out[names] = found.left
        return out
