"""How much tighter a joint fit of all samples would be than the peaks are: Fisher information of the linear plant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stepid.core.base import Array
from stepid.core.estimate import format_value
from stepid.core.experiment import Experiment
from stepid.core.mass_offset import weight_parts
from stepid.core.noise import noise_level
from stepid.identification.parameters import IdentifiedParameters

_WORTH = 2.0  # times as tight: less is not worth a word
_MOST_CHANGES = 40  # of an input: one that changes all the time is not what this method reads
_CONTRADICT = 2.0  # misfit beyond which runs contradict each other: a linear fit would be as wrong
_STEP = 1e-6  # relative, of a derivative
_ENOUGH = 20_000  # samples of a run: of longer ones every n-th stands for n


class _Shared(NamedTuple):
    """Places of the shared parameters: base masses, stiffnesses, damping constants, force gain."""

    bases: list[str]
    springs: list[str]
    dampers: list[str]

    @property
    def size(self) -> int:
        return len(self.bases) + len(self.springs) + len(self.dampers) + 1

    def of(self, run: Experiment) -> list[int]:
        a, b = len(self.bases), len(self.bases) + len(self.springs)
        return [
            self.bases.index(run.base),
            a + self.springs.index(run.spring),
            b + self.dampers.index(run.damper),
            self.size - 1,
        ]


def tighter_by_fit(runs: Sequence[Experiment], found: IdentifiedParameters, weight_uncertainty: float) -> str | None:
    """Say in a sentence how much tighter `stepid.fit` would be; None where it would not by much, or one cannot tell.

    Parameters
    ----------
    runs : sequence of Experiment
        Those that were used.
    found : IdentifiedParameters
    weight_uncertainty : float
        kg, of a 0.5 kg weight.

    Returns
    -------
    str or None
    """
    contradict = found.misfit is not None and found.misfit > _CONTRADICT
    if contradict or set(found.bases.values()) - set(found.base_mass) or not found.static_gain:
        return None
    shared = _Shared(list(found.base_mass), list(found.stiffness), list(found.pooled_damping))
    spread = _joint(runs, found, shared, weight_uncertainty)
    if spread is None:
        return None
    values = [
        ("base mass", "kg", found.base_mass, found.uncertainty.base_mass),
        ("stiffness", "N/m", found.stiffness, found.uncertainty.stiffness),
        ("damping", "N·s/m", found.pooled_damping, found.uncertainty.pooled_damping),
    ]
    flat = [(what, unit, of[label], told.get(label)) for what, unit, of, told in values for label in of]
    gains = [(told or 0.0) / float(s) for (_, _, _, told), s in zip(flat, spread, strict=False)]
    best = int(np.argmax(gains))
    if gains[best] < _WORTH:
        return None
    what, unit, value, told = flat[best]
    sizes = _size(value, float(spread[best])), _size(value, told)
    return (
        f"The peaks are a few samples of many. If the plant is linear and the noise white, stepid.fit would be "
        f"{gains[best]:.2g} times as tight: {what} within {sizes[0]} {unit}, here {sizes[1]} {unit}."
    )


def _size(value: float, spread: float | None) -> str:
    shown = format_value(value, spread).partition(" ± ")[2]
    return f"{spread:.2g}" if "e" in shown else shown


def _joint(
    runs: Sequence[Experiment], found: IdentifiedParameters, shared: _Shared, weight_uncertainty: float
) -> Array | None:
    """Standard uncertainties of the shared parameters in a joint fit; None where a run's input is not one of steps."""
    added = np.array([run.added_mass for run in runs])
    parts = weight_parts(added, weight_uncertainty)
    n, k = shared.size, parts.shape[1]
    total = np.zeros((n + k, n + k))
    total[n:, n:] = np.eye(k)
    forces = [
        found.static_gain[run.name] * found.run_stiffness(run.name) for run in runs if run.name in found.static_gain
    ]
    gain = float(np.mean(forces))
    for run, part in zip(runs, parts, strict=True):
        slopes = _slopes(run, found, gain)
        if slopes is None:
            return None
        rows = np.zeros((n + k, slopes.shape[1]))
        rows[shared.of(run)] = slopes
        rows[n:] = np.outer(part, slopes[0])  # an added mass acts as the base's
        rows -= rows.mean(axis=1, keepdims=True)  # the rest position is fitted
        noise = noise_level(run.position[run.position.size // 2 :], resolution=run.resolution)
        if not noise > 0:
            return None
        with np.errstate(over="ignore", invalid="ignore"):  # an input beyond all numbers is told below
            total += rows @ rows.T / noise**2 * (run.time.size / slopes.shape[1])
    size = np.sqrt(np.diag(total))
    if not (np.isfinite(total).all() and (size > 0).all()) or np.linalg.cond(total / size / size[:, None]) > 1e12:
        return None
    out: Array = np.sqrt(np.diag(np.linalg.inv(total / size / size[:, None]))) / size
    return out


def _slopes(run: Experiment, found: IdentifiedParameters, gain: float) -> Array | None:
    """Derivatives of a run's response by mass, stiffness, damping and force gain, shape (4, n) at n even times of it.

    At the values that the runs share: those of single runs would seem to weigh the weights, as a scale of all masses,
    stiffnesses, dampings and forces would no longer leave every response as it is.
    """
    levels = np.concatenate([[run.input_before], run.input])
    changes = np.flatnonzero(np.diff(levels))
    if run.name not in found.static_gain or run.input_between != "held" or changes.size > _MOST_CHANGES:
        return None
    mass = found.base_mass[run.base] + run.added_mass
    plant = np.array([mass, found.stiffness[run.spring], found.pooled_damping[run.damper], gain])
    time = run.time[:: -(-run.time.size // _ENOUGH)]

    def response(values: Array) -> Array:
        mass, k, c, force = values
        rate = np.sqrt(complex((c / 2 / mass) ** 2 - k / mass))  # imaginary where it swings
        slow, fast = -c / 2 / mass + rate, -c / 2 / mass - rate
        out = np.zeros(time.size)
        for i in changes:
            first = int(np.searchsorted(time, run.time[i]))
            t = time[first:] - run.time[i]
            swing = (slow * np.exp(fast * t) - fast * np.exp(slow * t)) / (slow - fast)
            out[first:] += force / k * (levels[i + 1] - levels[i]) * (1 - swing.real)
        return out

    here, steps = response(plant), np.diag(_STEP * plant)
    if np.any(plant == 0) or not np.isfinite(here).all():
        return None
    return np.array([(response(plant + step) - response(plant - step)) / (2 * step.sum()) for step in steps])
