"""What else a diagnosis noticed: runs and segments left out, repeats that differ, clipped records, open parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stepid.core.base import Array
from stepid.core.estimate import Estimate
from stepid.diagnosis.wording import parameter_words
from stepid.effects.base import Effect
from stepid.fitting.covariance import effect_parameters, parameter_names
from stepid.fitting.fit import NOT_CONVERGED
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.noise_floor import repeat_notes
from stepid.fitting.problem import fixes_mass

_SLOW = 1.0  # s between readings, of which a cart on a spring makes no use
_CLIPPED = 12  # samples at one extreme reading, in motion before and after


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
    for run, begin in zip(records.runs, records.begin, strict=True):
        if _is_clipped(run.position[begin:]):
            out.append(
                f"Run {run.name!r} stays at its extreme reading for {_CLIPPED} samples or more: did it hit a stop?"
            )
    if fixes_mass(records) is not None:
        out.append(
            "No two runs differ in added mass: the total mass is set to 1 kg and every parameter is per unit mass."
        )
    for effect, place in zip(effects, final.problem.layout.values, strict=True):
        if said := effect.remark(tuple(map(float, final.shared[place]))):
            out.append(said)
    own = effect_parameters(effects)
    assumed = parameter_names(final, ())[records.base[0]][0] if fixes_mass(records) is not None else None
    for name, value in parameters.items():
        known = value.one_sided is not None or name == assumed
        if value.uncertainty is None and not known:
            out.append(f"The data do not determine {parameter_words(name)}.")
        elif name in own and value.uncertainty is not None and value.uncertainty > open_ * abs(value.value):
            out.append(f"The data hardly determine {parameter_words(name)}: {value}.")
    if not final.converged:
        out.append(NOT_CONVERGED)
    return tuple(out)


def _is_clipped(y: Array) -> bool:
    for extreme in (y.max(), y.min()):
        at = np.flatnonzero(y == extreme)
        if at.size >= _CLIPPED and at[0] > 0 and at[-1] < y.size - 1:
            run = np.diff(np.flatnonzero(np.concatenate([[True], np.diff(at) > 1, [True]])))
            long = int(run.max())
            if long >= _CLIPPED and abs(y[-1] - extreme) > 0.2 * np.ptp(y):
                return True
    return False
