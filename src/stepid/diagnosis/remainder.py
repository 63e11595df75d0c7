"""What shape the rest has that an answer leaves, and which kinds of law make such a shape."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.free_law import allowed
from stepid.diagnosis.phases import phase_of_samples
from stepid.diagnosis.residual_force import ResidualForce, residual_force
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.shape_in_motion import KINDS, law_in_motion
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.fitting.spectrum import resonances
from stepid.fitting.weak_form import measured_motion

_TOLD = 0.3  # share of the rest that a shape must take to be told
_BESIDE = 0.5  # of the largest share: a shape that takes less is not told beside it
_PIECE = 0.2  # of the period: segments of motion shorter than this are not independent
_PLENTY = 2.0  # independent segments a coefficient, the least that tell a shape
_APART = 0.15  # of the natural frequency: a swing nearer than this is the plant's own
_SWINGS = 2.0  # periods in the longest record: fewer are a drift
_OVERTONES, _IN_TUNE = (2, 3, 4, 5), 0.05  # of the natural frequency; relative, how near a swing is to one of them
_SINGLED = 2.0  # times its even share of what a shape takes, that makes a run one of those that are named
_RUNS = 3  # named at most


NEITHER = (
    "The rest follows neither velocity, position nor time alone. "
    "Laws of the drive, laws with a memory and shocks leave such a rest.",
)
"""What is said of a rest that has none of the shapes, where an input drives the plant."""
UNDRIVEN = (NEITHER[0].replace("Laws of the drive, laws", "Laws"),)
"""The same of releases."""


class Share(NamedTuple):
    """A shape of the rest: the share of its power that the shape takes, less what chance takes, and a word on it."""

    shape: str
    share: float
    detail: str = ""


def remainder(context: FitContext, candidate: Candidate, criteria: Criteria) -> tuple[str, ...]:
    """Say what shape the rest of a candidate's fit has, and which kinds of law make it.

    Noise hides a force more than it hides a motion: where no shape is seen in the force, laws of any shape are asked
    what they take of the motion's rest (`stepid.diagnosis.free_law`).

    Parameters
    ----------
    context : FitContext
    candidate : Candidate
    criteria : Criteria

    Returns
    -------
    tuple of str
        A sentence for each shape that takes a part worth telling, the largest first; empty where there is too little
        motion to tell.
    """
    shares = rest_shares(context, candidate.optimum)
    if not shares:
        return ()
    least = max(_TOLD, _BESIDE * shares[0].share)
    told = tuple(_sentence(one) for one in shares if one.share >= least)
    neither = NEITHER if context.records.driven.any() else UNDRIVEN
    return told or _in_the_motion(context, candidate, criteria) or neither


def _in_the_motion(context: FitContext, candidate: Candidate, criteria: Criteria) -> tuple[str, ...]:
    """What is said of the law of any shape that takes a good part of the motion's rest, more than chance does."""
    beyond, _ = allowed(context, criteria, candidate, noise=False)
    law = law_in_motion(context, candidate.optimum, share=_TOLD, beyond=beyond)
    return () if law is None else (f"{_percent(law.share)} fits {': '.join(KINDS[law.state])}.",)


def rest_shares(context: FitContext, optimum: Optimum) -> tuple[Share, ...]:
    """Shares of the rest's power that functions of velocity, of position, of time and of the run take, largest first.

    The rest is the force that would produce the fit's residual while the cart moves, less what one linear plant takes.
    Each share is corrected for its number of coefficients (adjusted coefficient of determination).

    Parameters
    ----------
    context : FitContext
    optimum : Optimum
        Of the candidate.
    """
    records, floor, period = context.records, context.floor, context.period
    linear = optimum.shared[optimum.problem.layout.linear]
    motion = measured_motion(records, linear, floor, period)
    phase = phase_of_samples(records, context.linear, context.measured, floor)
    force = residual_force(records, optimum, motion, phase, floor)
    step = float(np.median(records.sample_time))
    pieces = force.force.size * min(1.0, step / (_PIECE * period))
    plain = np.column_stack([np.ones_like(force.x), force.x, force.v, force.volts])
    if pieces < _PLENTY * plain.shape[1] or not np.all(np.isfinite(force.force)):
        return ()
    basis = _basis(plain)
    rest = force.force - basis @ (basis.T @ force.force)
    if float(rest @ rest) <= 0:
        return ()
    found = [
        Share("velocity", _share(rest, basis, _of_velocity(force), pieces)),
        Share("position", _share(rest, basis, _of_position(force), pieces)),
        Share("slow", _share(rest, basis, _slow(force), pieces)),
        _line(context, _lines(context, optimum, period), force, rest, basis, pieces),
        _of_runs(context, force, rest, basis, pieces),
    ]
    return tuple(sorted(found, key=lambda one: -one.share))


def _lines(context: FitContext, optimum: Optimum, period: float) -> tuple[float, ...]:
    """Frequencies [Hz] at which the residual swings, more than once or twice, and the plant does not."""
    own, least = 1.0 / period, _SWINGS / context.scales.duration
    return tuple(f for f in resonances(context.records, optimum.residual) if f > least and abs(f - own) > _APART * own)


def _basis(columns: Array) -> Array:
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns / np.where(size > 0, size, 1.0), full_matrices=False)
    out: Array = left[:, values > 1e-6 * values[0]] if values.size else left
    return out


def _share(rest: Array, basis: Array, columns: Array, pieces: float) -> float:
    own = _taken(rest, basis, columns)
    if own is None:
        return 0.0
    taken, count = float(own @ own) / float(rest @ rest), float(np.linalg.matrix_rank(columns))
    if pieces < _PLENTY * count:
        return 0.0
    return max(0.0, 1.0 - (1.0 - taken) * pieces / (pieces - count))


def _taken(rest: Array, basis: Array, columns: Array) -> Array | None:
    """The part of the rest that columns take beyond what a linear plant takes."""
    beyond = columns - basis @ (basis.T @ columns)
    size = np.linalg.norm(columns, axis=0)
    beyond = beyond[:, np.linalg.norm(beyond, axis=0) > 1e-6 * np.where(size > 0, size, np.inf)]
    if not beyond.shape[1]:
        return None
    own = _basis(beyond)
    out: Array = own @ (own.T @ rest)
    return out


def _of_velocity(force: ResidualForce) -> Array:
    v, sign = _scaled(force.v), force.features[0]
    return np.column_stack([sign, np.abs(v), v * np.abs(v), v**2, v**3])


def _of_position(force: ResidualForce) -> Array:
    x = _scaled(force.x)
    return np.column_stack([np.abs(x), x * np.abs(x), x**2, x**3, x**5])


def _slow(force: ResidualForce) -> Array:
    return _by_run(force, np.column_stack([np.ones_like(force.time), force.time, force.time**2]))


def _line(
    context: FitContext, lines: tuple[float, ...], force: ResidualForce, rest: Array, basis: Array, pieces: float
) -> Share:
    """The swing that takes most, with an amplitude and a phase of its own in every run: steady, or an overtone."""
    best = Share("line", 0.0)
    for frequency in lines:
        angle = 2 * np.pi * frequency * force.time
        share = _share(rest, basis, _by_run(force, np.column_stack([np.sin(angle), np.cos(angle)])), pieces)
        if share > best.share:
            times, detail = _overtone(context.linear, frequency), f"{frequency:.3g} Hz"
            best = Share("line", share, detail)
            if times:
                best = Share("overtone", share, f"{detail}, {times} times the natural frequency")
    return best


def _overtone(linear: Optimum, frequency: float) -> int:
    """Which multiple of the natural frequency of every run a frequency [Hz] is, 0 where it is none."""
    own = linear.problem.layout.rates(linear.shared) / (2 * np.pi)
    in_tune = (n for n in _OVERTONES if np.all(np.abs(frequency - n * own) < _IN_TUNE * n * own))
    return next(in_tune, 0)


def _of_runs(context: FitContext, force: ResidualForce, rest: Array, basis: Array, pieces: float) -> Share:
    """A linear plant of its own in every run, and the runs in which that takes most."""
    columns = _by_run(force, np.column_stack([force.x, force.v, force.volts]))
    share, own = _share(rest, basis, columns, pieces), _taken(rest, basis, columns)
    if own is None or not share:
        return Share("run", 0.0)
    names = [run.name for run in context.records.runs]
    power = np.bincount(force.run.astype(np.intp), weights=own**2, minlength=len(names)) / float(own @ own)
    order = [i for i in np.argsort(-power) if power[i] > _SINGLED / len(names)][:_RUNS]
    return Share("run", share, ", ".join(repr(names[i]) for i in order))


def _by_run(force: ResidualForce, columns: Array) -> Array:
    runs = np.unique(force.run)
    return np.column_stack([np.where((force.run == r)[:, None], columns, 0.0) for r in runs])


def _scaled(values: Array) -> Array:
    reach = float(np.abs(values).max(initial=0.0))
    return values / reach if reach > 0 else values


def _percent(share: float) -> str:
    return f"{100 * share:.0f} % of the rest"


def _sentence(one: Share) -> str:
    percent = _percent(one.share)
    if one.shape in KINDS:
        return f"{percent} is {': '.join(KINDS[one.shape])}."
    if one.shape == "slow":
        return f"{percent} changes slowly in time: a drifting sensor, creep or warming makes it."
    if one.shape == "line":
        return f"{percent} is a steady swing at {one.detail}: a shaker, a fan or a further mode of the plant makes it."
    if one.shape == "overtone":
        return f"{percent} is a swing at {one.detail}: a law that bends makes such an overtone, and a further mode may."
    where = f", most in {one.detail}" if one.detail else ""
    return (
        f"{percent} is a stiffness, damping or gain of its own in every run{where}: "
        "settings that do not repeat, or that changed between the runs, make it."
    )
