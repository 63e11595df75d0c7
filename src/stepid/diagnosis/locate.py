"""Second question: where does the linear model disagree? By phase, by run, and as a force against the motion."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.phases import PHASES, phase_of_samples, phase_rms
from stepid.diagnosis.residual_force import CLEAR, residual_force, shape
from stepid.diagnosis.result import Where
from stepid.diagnosis.wording import sentences
from stepid.effects.base import Motion
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.spectrum import strongest_period
from stepid.fitting.weak_form import measured_motion
from stepid.simulation.records import Records

_BINS = 24  # of velocity and of position
_VARIES = 0.02  # relative spread of what differs between runs
_LEAST = 6  # samples that make a bin


def locate(
    records: Records,
    linear: Optimum,
    floor: float,
    motion: Motion | None = None,
    *,
    enough: bool = False,
    otherwise: Callable[[], str] = str,
) -> Where:
    """Say where the linear joint fit and the measurement disagree.

    Parameters
    ----------
    records : Records
    linear : Optimum
        The linear joint fit to these records.
    floor : float
        m, noise floor.
    motion : Motion, optional
        As measured, where it is known already.
    enough : bool
        Whether the linear plant is the answer: it then disagrees nowhere.
    otherwise : callable
        Says what shape the residual has where its force shows none, '' where it has none either.

    Returns
    -------
    Where
    """
    residual = linear.residual
    motion = motion or _motion(records, linear, floor)
    phase = phase_of_samples(records, linear, motion, floor)
    square, trusted = residual**2, records.trusted
    seen = {name: trusted & (phase == i) for i, name in enumerate(PHASES)}
    phases = {name: _rms(square[at]) for name, at in seen.items() if at.any()}
    pieces = zip(records.runs, records.pieces(), strict=True)
    runs = {run.name: _rms(square[piece][trusted[piece]]) for run, piece in pieces}
    force = residual_force(records, linear, motion, phase, floor)
    kind = shape(force)
    # what the linear parameters took in place of a clear shape is given back, so that a step looks like a step
    clear = kind if kind is not None and kind.share >= CLEAR else None
    shown = force.force if clear is None else force.force - clear.taken
    velocity = _binned(force.v, shown, _sided(force.v))
    position = _binned(force.x, shown, _even(force.x))
    trends = run_trends(records, linear, np.array(list(runs.values())))
    return Where(
        phases=phases,
        velocity_levels=velocity[0],
        velocity_force=velocity[1],
        position_levels=position[0],
        position_force=position[1],
        runs=runs,
        trends=trends,
        sentences=sentences(
            _rms(square[trusted]),
            floor,
            phases,
            runs,
            trends,
            kind,
            driven=bool(records.driven.any()),
            enough=enough,
            otherwise="" if enough or clear or kind is None else otherwise(),
        ),
        jump=2 * clear.coefficient if clear is not None and clear.name == "sign of velocity" else None,
    )


def phases_of(
    records: Records, linear: Optimum, floor: float, motion: Motion | None = None
) -> dict[str, dict[str, float]]:
    """RMS [m] of the linear fit's residual by run name and phase of the response."""
    phase = phase_of_samples(records, linear, motion or _motion(records, linear, floor), floor)
    found = phase_rms(records, linear.residual, phase)
    return {run.name: phases for run, phases in zip(records.runs, found, strict=True)}


def _motion(records: Records, linear: Optimum, floor: float) -> Motion:
    return measured_motion(records, linear.shared, floor, strongest_period(records))


def _rms(square: Array) -> float:
    return math.sqrt(float(square.mean())) if square.size else 0.0


def _sided(values: Array) -> Array:
    """Edges with one at zero, so that no bin holds both directions."""
    reach = float(np.abs(values).max(initial=0.0))
    return np.linspace(-reach, reach, _BINS + 1)


def _even(values: Array) -> Array:
    return np.linspace(values.min(initial=0.0), values.max(initial=0.0), _BINS + 1)


def _binned(levels: Array, values: Array, edges: Array) -> tuple[Array, Array]:
    """Mean level and mean value of the bins that hold enough samples."""
    if not levels.size or edges[-1] <= edges[0]:
        return np.zeros(0), np.zeros(0)
    place = np.clip(np.searchsorted(edges, levels, side="right") - 1, 0, _BINS - 1)
    count = np.bincount(place, minlength=_BINS)
    full = count >= _LEAST
    mean = [np.bincount(place, weights=w, minlength=_BINS)[full] / count[full] for w in (levels, values)]
    return mean[0], mean[1]


def run_trends(records: Records, linear: Optimum, rms: Array) -> dict[str, float]:
    """Correlation of the runs' RMS with mass, size and direction, among runs with the same spring and damper."""
    mass = linear.shared[: len(records.bases)][records.base] + records.added_mass
    jump = []
    for r, run in enumerate(records.runs):
        if records.moving[r]:  # a release: how far it is let go from rest
            jump.append(float(linear.local[0, r]))
        else:
            change = np.diff(run.input, prepend=run.input_before)
            jump.append(float(change[np.argmax(np.abs(change) > 0.05 * np.abs(change).max(initial=0.0))]))
    kinds = np.array(jump)
    size = np.array([np.abs(run.input - run.input_before).max() for run in records.runs])
    size = np.where(records.moving, np.abs(kinds), size)
    group = np.array([f"{s} {d} {m}" for s, d, m in zip(records.spring, records.damper, records.moving, strict=True)])
    found = {}
    for name, values in (("mass", mass), ("size", size), ("direction", np.sign(kinds))):
        inner, relative, compared = np.zeros(rms.size), np.zeros(rms.size), np.zeros(rms.size, dtype=bool)
        for g in np.unique(group):
            mine = group == g
            relative[mine] = rms[mine] / max(float(rms[mine].mean()), 1e-300) - 1
            inner[mine] = values[mine] - values[mine].mean()
            compared[mine] = np.ptp(values[mine]) > _VARIES * np.abs(values[mine]).max()
        if compared.sum() >= 3 and np.std(relative[compared]) > 0:
            found[name] = float(np.corrcoef(inner[compared], relative[compared])[0, 1])
    return found
