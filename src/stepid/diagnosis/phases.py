"""Phases of a run's responses: before, rise, overshoot, ring-down, rest; driven where the input never holds."""

from __future__ import annotations

import math

import numpy as np

from stepid.core.base import Array, Index
from stepid.effects.base import Motion
from stepid.errors import NoStepError
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.identification.steps import find_steps
from stepid.simulation.records import Records

PHASES = ("before", "driven", "rise", "overshoot", "ring-down", "rest")
BEFORE, DRIVEN, RISE, OVERSHOOT, RING_DOWN, REST = range(len(PHASES))
_BAND = 0.02  # of the travel: within it the cart is settled
_CLEAR = 4.0  # times the noise floor: motion that can be seen
_TURN = 0.03  # of the highest speed: below it a change of direction is noise
_STILL = 5  # samples, the least that are called a rest


def phase_of_samples(records: Records, linear: Optimum, motion: Motion, floor: float) -> Index:
    """Index into `PHASES` of each sample.

    Parameters
    ----------
    records : Records
    linear : Optimum
        The linear joint fit: where each step would lead.
    motion : Motion
        From `stepid.fitting.weak_form.measured_motion`.
    floor : float
        m, noise.

    Returns
    -------
    array of int, shape (S,)
    """
    of = linear.problem.layout
    gain = linear.shared[of.force_gain] / linear.shared[of.stiffness][records.spring]  # m/V, static
    out = np.full(records.size, RING_DOWN, dtype=np.intp)
    for r, (run, piece) in enumerate(zip(records.runs, records.pieces(), strict=True)):
        label, x, v = out[piece], motion.x[piece], motion.v[piece]
        if records.moving[r]:
            _label_driven(label, np.diff(records.volts[piece], prepend=records.volts[piece][0]), x, floor)
            continue
        try:
            steps = find_steps(run)
        except NoStepError:
            change = np.diff(run.input, prepend=run.input_before)
            label[:] = BEFORE if change.any() else REST
            if change.any():
                _label_driven(label, change, x, floor)
            continue
        label[: steps[0].began] = BEFORE
        for step in steps:
            stop = step.stop if step.number < step.total else x.size
            here = slice(step.began, stop)
            steady = float(gain[r] * run.input[step.start])
            _label_step(label[here], x[here], v[here], steady, floor)
    return out


def _label_driven(label: Index, change: Array, x: Array, floor: float) -> None:
    """Label a run from its input's first change to the last as driven, and where it settles after that as at rest."""
    changes = np.flatnonzero(change)
    first, last = (int(changes[0]), int(changes[-1]) + 1) if changes.size else (0, 0)
    label[first:last] = DRIVEN
    label[last:] = RING_DOWN
    label[last + _settled(x[last:], float(np.ptp(x)), floor) :] = REST


def _settled(x: Array, travel: float, floor: float) -> int:
    """Index from which the position stays where it ends; its size where it does not."""
    if x.size < 2 * _STILL:
        return int(x.size)
    end = float(np.median(x[-max(_STILL, x.size // 10) :]))
    away = np.flatnonzero(np.abs(x - end) > max(_BAND * travel, _CLEAR * floor))
    first = int(away[-1]) + 1 if away.size else 0
    return first if x.size - first >= _STILL else int(x.size)


def _label_step(label: Index, x: Array, v: Array, steady: float, floor: float) -> None:
    """Write the phases of one response into its samples; `steady` is where the linear plant would rest."""
    if not x.size:
        return
    travel = steady - float(x[0])
    if abs(travel) <= _CLEAR * floor:
        label[_settled(x, abs(travel), floor) :] = REST
        return
    rest = _settled(x, abs(travel), floor)
    if rest < x.size:  # where it does rest is better known than where the linear plant would
        steady = float(np.median(x[rest:]))
    sign = math.copysign(1.0, travel)
    beyond, speed = sign * (x - steady), sign * v
    crossed = _first(beyond >= 0, 0)
    label[:crossed] = RISE
    turn = _TURN * float(np.abs(v).max())
    peak = _first(speed < -turn, crossed)
    end = min(_first(beyond < 0, crossed), _first(speed > turn, peak))
    label[crossed:end] = OVERSHOOT
    label[rest:] = REST


def _first(where: np.ndarray[tuple[int], np.dtype[np.bool_]], begin: int) -> int:
    """Index of the first true entry from `begin` on; the size where there is none."""
    found = np.flatnonzero(where[begin:])
    return begin + int(found[0]) if found.size else int(where.size)


def phase_rms(records: Records, residual: Array, phase: Index) -> tuple[dict[str, float], ...]:
    """RMS [m] of a residual by phase, one mapping a run."""
    found = []
    for piece in records.pieces():
        trusted = records.trusted[piece]
        square, label = residual[piece][trusted] ** 2, phase[piece][trusted]
        found.append(
            {name: math.sqrt(float(square[label == i].mean())) for i, name in enumerate(PHASES) if np.any(label == i)}
        )
    return tuple(found)
