"""Wrong samples of a record, found before any fit: isolated outliers, and readings that repeat the one before."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array, Index
from stepid.core.experiment import Experiment
from stepid.core.once import once
from stepid.core.outliers import LONGEST, SIDE, Block, Mask, interpolate_readings, isolated, outliers, stand_out
from stepid.core.words import at_samples, counted, length
from stepid.fitting.record_fault import RecordFault
from stepid.simulation.records import Records

_STUCK = 4.0  # the same where a reading is repeated to the last digit and the cart then catches up
_CAUGHT_UP = 0.7  # share of the way missed meanwhile that a reading makes good in one sample: a cart at rest does not
_STEADY = 0.5  # speed before over speed after, or the reverse, of a cart that moves on
_STICKS = 8  # samples that a reading may stick
_NEXT_TO_NOTHING = 1e-6  # square-root weight of a reading that is left out
_RESIDUAL = 8.0  # standard deviations of a good fit's residual


class Mended(NamedTuple):
    """A record whose isolated wrong samples are interpolated, which samples are wrong, and what is said of them."""

    run: Experiment
    wrong: Mask
    faults: tuple[RecordFault, ...]


def _stuck(y: Array, noise: float, least: float) -> list[Block]:
    """Blocks that repeat the reading before them while their neighbors move on."""
    found = []
    for begin, end in _repeated(y):
        count = int(end - begin)
        if count > _STICKS or begin < SIDE or end > y.size - SIDE:
            continue
        before, after = (y[begin - 1] - y[begin - SIDE]) / 3, (y[end + 3] - y[end]) / 3
        speed, caught = 0.5 * (before + after), (y[end] - y[end - 1]) / (count + 1)
        slow, fast = sorted((abs(before), abs(after)))
        if before * after <= 0 or slow < _STEADY * fast or caught / speed < _CAUGHT_UP:
            continue
        score, off = stand_out(y, count, np.array([begin]), noise)
        if score.max() > _STUCK and np.abs(off).max() > least:
            found.append((float(score.max()), int(begin), count))
    return found


def _copied(y: Array, noise: float, least: float) -> list[Block]:
    """Blocks that repeat the reading before them, of readings that noise makes all different.

    On a grid it repeats some by itself; a cart at rest repeats one for long where there is none.
    """
    blocks = _repeated(y)
    told = y[np.flatnonzero(np.diff(y, prepend=np.nan) != 0)]
    if least > 0 or np.unique(told).size < told.size or np.diff(blocks, axis=1).max(initial=0) > _STICKS:
        return []
    return [(math.inf, int(begin), int(end - begin)) for begin, end in blocks if SIDE <= begin < end <= y.size - SIDE]


def _repeated(y: Array) -> Index:
    """First sample of each block that repeats the reading before it, and the first after it, shape (n, 2)."""
    same = np.concatenate([[False], np.diff(y) == 0, [False]])
    return np.column_stack([np.flatnonzero(same[1:] & ~same[:-1]), np.flatnonzero(~same[1:] & same[:-1])]) + 1


def mend(run: Experiment) -> Mended:
    """Interpolate readings that no motion explains.

    Parameters
    ----------
    run : Experiment

    Returns
    -------
    Mended
        The record itself where nothing is wrong with it, or where too much is.
    """
    read, (stuck, copied, out) = _interpolated(run)
    stuck = stuck | copied
    wrong = stuck | out
    if not wrong.any():
        return Mended(run, wrong, ())
    y = read.copy()
    off = np.abs(y - run.position)
    if run.counts_per_meter is None and (step := run.resolution) is not None:
        y[wrong] = _on_grid(y[wrong], run.position[~wrong], step)
    kinds = {"outliers": out, "stuck readings": stuck}
    faults = [_fault(run.name, kind, mask, off) for kind, mask in kinds.items() if mask.any()]
    y.setflags(write=False)
    return Mended(run.model_copy(update={"position": y}), wrong, tuple(faults))


@once
def _interpolated(run: Experiment) -> tuple[Array, list[Mask]]:
    """Readings of a run without wrong ones, m, and which stuck or stood out: kept, for a record is screened twice."""
    return interpolate_readings(run, detectors=(_stuck, _copied, outliers))


def _on_grid(values: Array, told: Array, step: float) -> Array:
    """Values rounded to the encoder's step that other readings alone tell: off its grid they would hide it."""
    levels = np.unique(told)
    after = np.clip(np.searchsorted(levels, values), 1, levels.size - 1)
    near = np.where(values - levels[after - 1] < levels[after] - values, levels[after - 1], levels[after])
    out: Array = near + step * np.rint((values - near) / step)
    return out


def _fault(run: str, kind: str, mask: Mask, off: Array) -> RecordFault:
    at = np.flatnonzero(mask)
    size = float(off[mask].max())
    one = at.size == 1
    does = "stand" + "s" * one + f" out by {'up to ' * (not one)}{length(size)}"
    if kind == "stuck readings":
        does = f"repeat{'s' * one} the one before"
    words = (
        f"Run {run!r}: {counted(at.size, 'reading')} ({at_samples(at.tolist())}) {does}; "
        f"{'it is' if one else 'they are'} left out."
    )
    return RecordFault(run=run, kind=kind, size=size, unit="m", words=words)


def trust(records: Records, wrong: Mapping[str, Mask]) -> Array:
    """Factors of the square-root weights, shape (S,): next to nothing where a reading is wrong.

    Parameters
    ----------
    records : Records
    wrong : mapping
        Run name to mask over the samples of its experiment.
    """
    masks = [wrong.get(run.name, np.zeros(run.position.size, dtype=bool)) for run in records.runs]
    every = np.concatenate([mask[b:] for mask, b in zip(masks, records.begin, strict=True)])
    return np.where(every, _NEXT_TO_NOTHING, 1.0)


def outliers_of(residual: Array, floor: float) -> Mask:
    """Isolated samples, one to three in a row, beyond eight robust standard deviations in the residual of a good fit.

    Parameters
    ----------
    residual : array, shape (n,)
        m, of one run.
    floor : float
        m; the standard deviation is not taken below it.

    Returns
    -------
    array of bool, shape (n,)
    """
    middle = float(np.median(residual))
    spread = max(1.4826 * float(np.median(np.abs(residual - middle))), floor)
    far = np.abs(residual - middle) > _RESIDUAL * spread
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]])))
    out = np.zeros(residual.size, dtype=bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        sides = np.concatenate([residual[max(0, begin - 2) : begin], residual[end : end + 2]])
        calm = not sides.size or float(np.abs(sides - middle).max()) < _RESIDUAL / 2 * spread
        if end - begin <= LONGEST and calm:
            out[begin:end] = True
    return out if math.isfinite(spread) and isolated(out) else np.zeros_like(out)
