"""Forces that together make a law of any shape: of a state, of a state's past, and overtones of a periodic effect."""

from __future__ import annotations

import numpy as np

from stepid.core.base import Array
from stepid.effects.base import Motion
from stepid.fitting.levenberg_marquardt import Optimum
from stepid.fitting.multistart import FitContext
from stepid.simulation.records import Records

_PIECES = 6  # straight pieces of the law on each side of zero; rates at which a memory fades
_SHORTEST = 2.0  # samples, of the time in which a memory fades; the longest is a record over as many


def free_forces(context: FitContext, optimum: Optimum) -> list[tuple[str, list[Array], bool]]:
    """States with the forces of any law of each along a fit's motion, and whether these are overtones of its effects.

    Parameters
    ----------
    context : FitContext
    optimum : Optimum
        Of the candidate, on all samples.

    Returns
    -------
    list of tuple
        State, forces, shape (S,) each, and whether they are overtones.
    """
    x, v = optimum.solved.states[:2]
    volts = context.motion.volts
    begun = np.concatenate([t - t[0] for t in (context.motion.time[piece] for piece in context.records.pieces())])
    where, speed, when = _pieces(x), _pieces(v), _pieces(begun)
    free = {"position": where, "velocity": speed, "position and velocity": [f * v for f in where]}
    free |= {"position and time": [f * x for f in when], "velocity and time": [f * v for f in when]}
    if volts.any():
        free["input and time"] = [f * volts for f in when]
        free["position and input"] = [f * volts for f in where]
        free["velocity and input"] = [f * volts for f in speed]
        free["the input's past"] = memories(context.records, volts)
    free["the position's past"] = memories(context.records, x)
    return [*((state, forces, False) for state, forces in free.items()), *_overtones(context, optimum)]


def _overtones(context: FitContext, optimum: Optimum) -> list[tuple[str, list[Array], bool]]:
    """Forces of the overtones of a fit's periodic effects, as `free_forces` has them."""
    x, v = optimum.solved.states[:2]
    out: list[tuple[str, list[Array], bool]] = []
    motion, layout = context.motion._replace(x=x, v=v), optimum.problem.layout
    for effect, place, rows in zip(layout.effects, layout.values, layout.run_values, strict=True):
        waves: list[Array] = []
        for r, piece in enumerate(context.records.pieces()):
            values = (*map(float, optimum.shared[place]), *map(float, optimum.local[rows, r]))
            within = Motion(*(field[piece] for field in motion))
            parts = effect.overtones(values, within)
            waves = waves or [np.zeros(x.size) for _ in parts]
            for wave, part in zip(waves, parts, strict=True):
                wave[piece] = part
        if waves:
            out.append(("time" if effect.run_parameters else "position", waves, True))
    return out


def _pieces(values: Array) -> list[Array]:
    """Forces of a state: at each knot on either side of zero one that is 1 N there and falls to 0 at its neighbors.

    Those at zero end there: a law may jump.
    """
    out = []
    for side in (values, -values):
        reach = float(side.max())
        if reach <= 0:
            continue
        knots = np.linspace(0.0, reach, _PIECES + 1)
        for k in range(_PIECES + 1):
            height = np.eye(_PIECES + 1)[k]
            out.append(np.where(side > 0, np.interp(side, knots, height), 0.0))
    return out


def memories(records: Records, values: Array) -> list[Array]:
    """Forces of a state's past: each follows its changes from the record's start, and forgets them at its own rate.

    Parameters
    ----------
    records : Records
    values : array, shape (S,)
        Of the state.

    Returns
    -------
    list of array, shape (S,)
        Those that forget fastest first.
    """
    from scipy.signal import lfilter

    step = float(np.median(records.sample_time))
    longest = max(float(np.ptp(records.time[piece])) for piece in records.pieces())
    out = []
    for time in np.geomspace(_SHORTEST * step, longest / _SHORTEST, _PIECES):
        force = np.zeros(values.size)
        for piece, dt in zip(records.pieces(), records.sample_time, strict=True):
            force[piece] = lfilter([1.0, -1.0], [1.0, -np.exp(-dt / time)], values[piece] - values[piece][0])
        out.append(force)
    return out
