"""What else a diagnosis noticed: runs and segments left out, repeats that differ, clipped records, open parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.core.estimate import Estimate
from stepid.core.noise import reading_step
from stepid.diagnosis.vetoes import sizes_of
from stepid.diagnosis.wording import parameter_words
from stepid.effects.base import Effect
from stepid.fitting.covariance import parameter_names
from stepid.fitting.fit import NOT_CONVERGED
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import repeat_notes
from stepid.fitting.problem import fixes_mass, ratios_note

_SLOW = 1.0  # s between readings, of which a cart on a spring makes no use
_CLIPPED = 12  # samples at one extreme reading, in motion before and after
_PEAK = 0.2  # of these samples: within one count more, the least that a peak stays there
Flags = npt.NDArray[np.bool_]


def notes_on(
    context: FitContext, final: Optimum, effects: tuple[Effect, ...], parameters: Mapping[str, Estimate], open_: float
) -> tuple[str, ...]:
    """Collect remarks in words; `open_` is the relative uncertainty beyond which a parameter is open."""
    records = context.records
    out = [*context.notes, *repeat_notes(records)]
    if context.colored is not None:
        out.append(context.colored.words)
    slowest = float(records.sample_time.max())
    if slowest >= _SLOW:
        out.append(f"The readings come every {slowest:.3g} s: if the times are milliseconds, give time_scale = 0.001.")
    for run, begin, piece in zip(records.runs, records.begin, records.pieces(), strict=True):
        if _is_clipped(run.position[begin:][records.trusted[piece]], reading_step(run)):
            out.append(
                f"Run {run.name!r} stays at its extreme reading for {_CLIPPED} samples or more: did it hit a stop?"
            )
    if ratios := ratios_note(records):
        out.append(ratios)
    for effect, place in zip(effects, final.problem.layout.values, strict=True):
        if said := effect.remark(tuple(map(float, final.shared[place]))):
            out.append(said)
    out += _open_parameters(final, effects, parameters, open_)
    if not final.converged:
        out.append(NOT_CONVERGED)
    return tuple(out)


def _open_parameters(
    final: Optimum, effects: tuple[Effect, ...], parameters: Mapping[str, Estimate], open_: float
) -> Iterator[str]:
    """Say which parameters the data leave open, of those that they are asked for."""
    records, linear, sizes = final.problem.records, parameter_names(final, ()), sizes_of(final, effects)
    assumed = {linear[records.base[0]][0]} if fixes_mass(records) is not None else set()
    if not records.driven.any():
        assumed.add(linear[-1][0])  # no input asks for it
    for name, value in parameters.items():
        known = value.one_sided is not None or name in assumed
        if value.uncertainty is None and not known:
            yield f"The data do not determine {parameter_words(name)}."
        elif name in sizes and value.uncertainty is not None and value.uncertainty > open_ * sizes[name]:
            yield f"The data hardly determine {parameter_words(name)}: {value}."


def _is_clipped(y: Array, resolution: float) -> bool:
    """Tell whether a record stays at its extreme reading in motion, for longer than a peak does within a count."""
    for extreme in (y.max(), y.min()):
        at = y == extreme
        if at.sum() < _CLIPPED or at[0] or at[-1] or abs(y[-1] - extreme) <= 0.2 * np.ptp(y):
            continue
        first, end = _longest(at)
        near = np.abs(y - extreme) < 1.5 * resolution
        before, after = int(np.argmin(near[:first][::-1])), int(np.argmin(near[end:]))
        # of a parabola that a count cuts off, two counts cut off 1.4 times as much
        if end - first >= _CLIPPED and before + after < _PEAK * (end - first):
            return True
    return False


def _longest(at: Flags) -> tuple[int, int]:
    """First and end of the longest stretch of samples that are marked."""
    edges = np.flatnonzero(np.diff(at.astype(int), prepend=0, append=0)).reshape(-1, 2)
    first, end = edges[np.argmax(edges[:, 1] - edges[:, 0])]
    return int(first), int(end)
