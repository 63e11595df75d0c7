"""Records that hold several releases by hand."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.hand import period_of
from stepid.core.noise import reading_step, record_noise
from stepid.core.outliers import without_outliers
from stepid.core.quantities import in_own_quantities
from stepid.core.takes import described
from stepid.errors import InputError

if TYPE_CHECKING:
    from stepid.core.experiment import Experiment

_FEW = 8  # samples, the last of a record
_TAIL = 1.5  # periods near rest, after which a cart has come to it; or
_MUCH = 0.25  # of the record
_TIMES = 4  # that a middle of swings is found anew
_BIG = 0.3  # of the farthest point, which a cart that comes to rest stays below
_AGAIN = 1.5  # times the turn before, or what is rest: no free swing grows so
_FAINT = 0.05  # of the largest swing: less is rest
_STILL = 0.2  # of what is rest: less is no motion of the hand
_NOTABLE = 0.2  # of the largest swing, below which a growing one is noise or a touch
_QUIET = 8.0  # standard deviations of the noise that no swing stands out from
_SEEN = 3.0  # counts, likewise
_FEWEST = 24  # samples of a release
_ORDER = 4  # of a linear prediction: two modes
_LAG = 4  # parts of half a swing, from one of its samples to the next
_APART = 3.0  # times the median that it misses, from where on a sample is no part of it
_BREAKS = 2.4  # times the same, RMS, from where on a hand breaks it: white noise misses by 1.5


@in_own_quantities
def split_releases(experiment: Experiment) -> tuple[Experiment, ...]:
    """Split a record that holds several releases, or pushes, by hand into one record each.

    A free swing only dies away. Where it grows again, a hand has moved the cart: the record ends there, and the next
    begins. What the hand did first in each of them is left out by `fit` and `diagnose`.

    Parameters
    ----------
    experiment : Experiment
        A record with an input is returned whole: a fit follows all of its steps.

    Returns
    -------
    tuple of Experiment
        In order of time on the record's clock, called "name (1)", "name (2)", …; the record itself where it holds one
        release.
    """
    if not hasattr(experiment, "is_release"):
        raise InputError(f"an Experiment is needed, not {described(experiment)}", "Give one run: campaign[name].")
    if not experiment.is_release or experiment.starts == "rest":
        return (experiment,)
    hands = _hands(experiment)
    begins, ends = [0, *(after for _, after in hands)], [*(before for before, _ in hands), experiment.time.size]
    parts = [(a, b) for a, b in zip(begins, ends, strict=True) if b - a >= _FEWEST]
    if len(parts) < 2:
        return (experiment,)
    first, *later = (experiment.slice(a, b, name=f"{experiment.name} ({i})") for i, (a, b) in enumerate(parts, 1))
    return first, *(part.model_copy(update={"starts": "auto"}) for part in later)  # these begin with the hand


def _swings_on(y: Array, hands: list[tuple[int, int]]) -> bool:
    """Tell whether two modes beat, where it grows: a linear prediction of their order runs on, a hand breaks it."""
    lag = max(1, round(period_of(y) / 2 / _LAG))
    if y.size < _ORDER * lag + _FEWEST:
        return False
    past = np.stack([y[i * lag : y.size - (_ORDER - i) * lag] for i in range(_ORDER)], axis=1)
    table, here = np.column_stack([past, np.ones(past.shape[0])]), y[_ORDER * lag :]
    at, held = np.arange(_ORDER * lag, y.size), np.zeros(here.size, dtype=bool)
    for before, after in hands:
        held |= (at >= before) & (at < after + (_ORDER + _LAG) * lag)
    keep = np.ones(here.size, dtype=bool)
    for _ in range(_TIMES):
        law = np.linalg.lstsq(table[keep], here[keep], rcond=None)[0]
        missed = np.abs(here - table @ law)
        keep = missed <= _APART * np.median(missed[keep])
    return bool(np.mean(missed[held] ** 2) < (_BREAKS * np.median(missed)) ** 2)


class _Lobe(NamedTuple):
    """A stay on one side of rest: first sample, last (not included), farthest point [m], which side."""

    first: int
    last: int
    size: float
    side: float


def _hands(experiment: Experiment) -> list[tuple[int, int]]:
    """Last free sample before each time that a hand takes a cart that was let go, and first of what follows."""
    y = without_outliers(experiment)
    away = y - _rest_between(y)
    noise = record_noise(experiment)
    largest = float(np.abs(away).max())
    quiet = max(_QUIET * noise, _SEEN * reading_step(experiment), _FAINT * largest)
    lobes, half = _lobes(away, quiet)
    out: list[tuple[int, int]] = []
    swings = 0  # lobes since the last hand
    range_before = np.inf  # least from one farthest point to the next so far: whatever the rest, it only shrinks
    for before, lobe in pairwise(lobes):
        rested = lobe.first - before.last > 2 * half  # a period: one lobe the other way may be too small
        unseen = rested or lobe.side == before.side  # the turn between: it stayed within what is rest
        turn = lobe.size if unseen else before.size + lobe.size
        grown = lobe.size > _AGAIN * quiet if rested else turn > _AGAIN * range_before
        if lobe.size > _NOTABLE * largest and swings + rested > 1 and grown:
            still = max(before.last, _moved(away, before, lobe, quiet) - round(half)) if rested else lobe.first
            out.append((still if rested else before.first, still))  # a hand that catches the cart shapes a swing
            swings, range_before = 0, np.inf
        else:
            range_before = min(range_before if swings > 1 else np.inf, turn + quiet * unseen)  # a record cuts its first
            swings += lobe.side != before.side or rested
    return [] if out and _swings_on(y, out) else out


def _moved(away: Array, before: _Lobe, lobe: _Lobe, quiet: float) -> int:
    """Last sample of a cart at rest before a hand moves it."""
    between = away[before.last : lobe.first]
    off = np.abs(between - np.median(between))
    still = np.flatnonzero(off <= max(_STILL * quiet, float(off.min())))  # the median of two is neither of them
    return before.last + int(still[-1])


def _lobes(away: Array, quiet: float) -> tuple[list[_Lobe], float]:
    """Stays on one side of rest, farther than `quiet`, one after another; and the samples of half a swing."""
    at = np.flatnonzero(np.abs(away) > quiet)
    sides = np.sign(away[at])
    turns = at[1:][np.diff(sides) != 0]
    if turns.size < 2:
        return [], 0.0
    half = float(np.quantile(np.diff(turns), 0.25))
    ends = np.flatnonzero((np.diff(sides) != 0) | (np.diff(at) > half)) + 1
    parts = [(int(part[0]), int(part[-1]) + 1) for part in np.split(at, ends)]
    return [_Lobe(a, b, float(np.abs(away[a:b]).max()), float(np.sign(away[a]))) for a, b in parts], half


def _rest_between(y: Array) -> float:
    """Where the cart rests, m, whatever a hand does between: where it ends, or the middle of its swings."""
    away = np.abs(y - np.median(y[-_FEW:]))
    tail = y[int(np.flatnonzero(away >= _BIG * away.max())[-1]) + 1 :]
    period = period_of(y)
    if tail.size > max(_FEW, min(_TAIL * period, _MUCH * y.size)):
        return float(np.median(tail[tail.size // 2 :]))
    width = max(1, round(period / 24))
    order = np.argsort(middle := 0.5 * (y[width:] + y[:-width]))
    passed = np.cumsum(((y[width:] - y[:-width]) ** 2)[order])  # little of it where a hand holds
    rest = float(middle[order][int(np.searchsorted(passed, 0.5 * passed[-1]))])
    for _ in range(_TIMES):
        lobes, _half = _lobes(y - rest, _FAINT * float(np.ptp(y)))
        top = np.array([lobe.side * lobe.size for lobe in lobes])
        if top.size < 4:
            break
        rest += float(np.median(0.25 * top[:-2] + 0.5 * top[1:-1] + 0.25 * top[2:]))
    return rest
