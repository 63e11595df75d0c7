"""How much two effects could explain together, by one linearized step on the measured motion: for starts only.

One at a time, an effect whose response looks like another's is overlooked until that one is there, and a fit of the
wrong one first may end far from both. Two at a time cost no further simulation: sums of products of the responses that
are at hand tell all pairs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Effect
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.score_test import Column, Tangent, scaled_to_one

_OPEN = 1e-6  # eigenvalue, over the largest, of a direction that two responses leave open


class ScoredPair(NamedTuple):
    """A start of two effects on a fit: their values, the fit's parameters then, and the cost left, m²."""

    effects: tuple[Effect, Effect]
    values: tuple[tuple[float, ...], tuple[float, ...]]
    shared: Array
    left: float


class _Block(NamedTuple):
    column: Column
    scale: Array
    place: slice


def score_pairs(
    base: Optimum, table: Sequence[Column], count: int, *, apart: Callable[[Effect, Effect], bool]
) -> list[ScoredPair]:
    """Score every pair of starts against the residual of a fit to the decimated records.

    Parameters
    ----------
    base : Optimum
    table : sequence of Column
        From `stepid.fitting.score_test.columns`.
    count : int
        Starts of each pair of effects.
    apart : callable
        Tells whether two effects may stand beside each other.

    Returns
    -------
    list of ScoredPair
        The best few of each pair of effects; least cost first.
    """
    tangent = Tangent(base)
    blocks: list[_Block] = []
    parts: list[Array] = []
    width = 0
    for column in table if tangent.directed else ():
        scaled = scaled_to_one(tangent.beyond(column.responses))
        if scaled is not None:
            parts.append(scaled[0])
            blocks.append(_Block(column, scaled[1], slice(width, width + scaled[1].size)))
            width = blocks[-1].place.stop
    if not blocks:
        return []
    every = np.concatenate(parts, axis=1)
    gram, along = every.T @ every, every.T @ tangent.left
    total = float(tangent.left @ tangent.left)
    found: dict[tuple[Effect, Effect], list[tuple[float, _Block, _Block, Array]]] = {}
    for one, other in combinations(blocks, 2):
        both = one.column.effect, other.column.effect
        if apart(*both):
            gain, coefficients = _solved(gram, along, one.place, other.place)
            found.setdefault(both, []).append((total - gain, one, other, coefficients))
    out = []
    for both, scored in found.items():
        starts = 0
        for left, one, other, coefficients in sorted(scored, key=lambda item: item[0]):
            first = coefficients[: one.scale.size] / one.scale
            second = coefficients[one.scale.size :] / other.scale
            values = one.column.values(first), other.column.values(second)
            if values[0] is None or values[1] is None:
                continue
            shared = tangent.adapted(one.column.responses @ first + other.column.responses @ second)
            out.append(ScoredPair(both, (values[0], values[1]), shared, max(left, 0.0)))
            starts += 1
            if starts == count:
                break
    return sorted(out, key=lambda pair: pair.left)


def _solved(gram: Array, along: Array, one: slice, other: slice) -> tuple[float, Array]:
    """Decrease of the cost by the responses of two blocks, and their coefficients."""
    place = np.r_[one, other]
    values, vectors = np.linalg.eigh(gram[np.ix_(place, place)])
    kept = values > _OPEN * values[-1]
    seen = vectors[:, kept].T @ along[place]
    return float(np.sum(seen**2 / values[kept])), vectors[:, kept] @ (seen / values[kept])
