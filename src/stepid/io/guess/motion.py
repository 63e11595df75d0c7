"""What readings tell of a motion: whether there is one, and which columns hold the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stepid.core.base import Array

_FLAT = 4  # levels of a reading at rest: its last digit flickers
_NOISE = 0.5  # of the variance of any two readings, that of two near each other: 1 for noise, far less for a motion
_LAGS = 8  # a fast swing has as few samples a period, and looks like noise from one to the next
_MOST, _AWAY = 0.98, 10.0  # readings this many times as far from the median as most are no motion but spikes
_SAME = 1e-6  # of its variance, what is left of a column beside its scaled copy
_BY = 1e-3  # by which factors of two scaled copies may differ


def moves(values: Array) -> bool:
    """Say whether readings, shape (n,), move, and do not only flicker about one value; NaN and spikes do not count."""
    kept = values[np.isfinite(values)]
    if kept.size < 2:
        return False
    away = np.abs(kept - np.median(kept))
    most = float(np.quantile(away, _MOST, method="lower"))
    kept = kept[away <= _AWAY * most] if most > 0 else kept
    spread = float(np.var(kept))
    if spread == 0 or np.unique(kept).size <= _FLAT:
        return False
    lags = range(1, 1 + max(1, min(_LAGS, kept.size // 8)))
    return min(float(np.var(kept[lag:] - kept[:-lag])) for lag in lags) < _NOISE * 2 * spread


def copies(columns: Sequence[Array]) -> tuple[int, ...]:
    """The first two columns of which one is the other to scale, and so the same motion: a length and its angle."""
    values = np.column_stack(columns)
    values = values[np.isfinite(values).all(axis=1)]
    spread = values.std(axis=0) if len(values) else np.zeros(len(columns))
    moving = np.flatnonzero(spread > 0)
    if len(values) <= 2 or moving.size < 2:
        return ()
    normal = (values[:, moving] - values[:, moving].mean(axis=0)) / spread[moving]
    same = np.argwhere(np.triu(1 - (normal.T @ normal / len(values)) ** 2 < _SAME, k=1))
    return tuple(int(moving[i]) for i in same[0]) if len(same) else ()


def alike(first: Sequence[Array], second: Sequence[Array]) -> bool:
    """Say whether position and input of one run are by one factor those of another."""
    values = np.column_stack([*first, *second])
    x, u, x2, u2 = values[np.isfinite(values).all(axis=1)].T
    if not np.ptp(x) > 0 or not u.any():
        return False
    factor = float((x2 - x2.mean()) @ (x - x.mean()) / (x.size * x.var()))
    return bool(np.abs(u2 - factor * u).max() <= _BY * np.abs(u2).max())
