"""From a campaign and effects to a fit problem: what is free, what is fixed, where it starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from stepid.core.base import Array
from stepid.effects.base import Effect, Parameter, Scales
from stepid.fitting.levenberg_marquardt import Optimum, Problem, minimize
from stepid.fitting.spectrum import resonances, strongest_period
from stepid.fitting.weak_form import WeakForm
from stepid.simulation.layout import LEAST_MASS
from stepid.simulation.magnitudes import exponents
from stepid.simulation.records import Records, mass_span
from stepid.simulation.simulator import FINE, Simulator

_WIDTHS = (0.6, 1.0, 1.6, 0.35)  # of the strongest period, for the weak form
_MASSES = (1.0, 0.4, 2.5)  # of the largest difference of added masses, 1 kg at most
_TRAVEL, _SAMPLE_TIME = 0.02, 5e-3  # m and s, of a lab's rig: there bounds are as they stand in the catalogue
_HEAVIEST = 30.0  # times the largest difference of added masses, and 1 over it: then 1.5 % of a frequency tell a mass
_ALIKE = 1e-3  # relative difference of the costs at which two starts end in one optimum
PHASES = 12  # tried a run where the reading is not linear in their sine and cosine


def fixes_mass(records: Records) -> float | None:
    """Base mass to assume where no two runs of one base differ in added mass, else None.

    The total mass of the first run is then 1 kg, and every parameter is per unit mass.
    """
    if mass_span(records) > 0:
        return None
    return 1.0 - float(records.added_mass[0])


def ratios_note(records: Records) -> str | None:
    """Say that the parameters are ratios to an assumed mass; None where a difference in added mass tells the mass."""
    if fixes_mass(records) is None:
        return None
    return (
        "No two runs differ in added mass: the total mass is set to 1 kg and every parameter is per unit mass. "
        "Its uncertainty is that of the ratio."
    )


def build(records: Records, effects: tuple[Effect, ...], *, tolerance: float = FINE, workers: int = 1) -> Problem:
    """Set up the fit of a linear plant with effects to all records."""
    sim = Simulator(records, effects, tolerance, workers=workers)
    of = sim.layout
    a, b, c = len(records.bases), len(records.springs), len(records.dampers)
    parameters: list[Parameter] = [q for e in effects for q in e.parameters]
    least_added = np.array([records.added_mass[records.base == i].min(initial=np.inf) for i in range(a)])
    least = LEAST_MASS * records.mass_scale - least_added
    lower = np.concatenate([least, np.full(b, 1e-9), np.zeros(c), [-np.inf], _least_values(parameters, sim)])
    upper = np.concatenate([np.full(a + b + c + 1, np.inf), [q.upper for q in parameters]])
    free = np.ones(of.n_global, dtype=bool)
    if fixes_mass(records) is not None:
        free[records.base[0]] = False
    if not records.driven.any():
        free[of.force_gain] = False
    active = np.zeros((of.n_run, len(records.runs)), dtype=bool)
    active[:2] = free_starts(records, effects)
    active[2 : of.own_states.start] = True
    unknown = [not e.settled for e in effects for _ in range(e.n_extra + e.n_memory)]
    active[of.own_states] = records.moving & np.array(unknown, dtype=bool)[:, None]
    return Problem(sim, free, lower, upper, active)


def free_starts(records: Records, effects: Sequence[Effect]) -> npt.NDArray[np.bool_]:
    """Whether each run's displacement and velocity at the first sample are free with some effects, shape (2, R)."""
    shaken = any(e.never_rests for e in effects)
    return np.stack([records.moving | any(shaken or e.rests_anywhere for e in effects), records.moving | shaken])


def _least_values(parameters: list[Parameter], sim: Simulator) -> Array:
    """Lower bounds of effects' parameters, shape (n,): those of a lab's rig, in the units of this one's size."""
    powers, mass = exponents(tuple(parameters)), sim.records.mass_scale
    length = sim.scale / _TRAVEL if sim.moves else 1.0
    time = float(np.median(sim.records.sample_time)) / _SAMPLE_TIME
    units = np.log([mass * length / time**2, length, time, mass, 1.0])  # N, m, s, kg, V
    out: Array = np.array([q.lower for q in parameters]) * np.exp(powers @ units)
    return out


def start_local(problem: Problem, like: Optimum | None = None) -> Array:
    """Local parameters to start from: those of an optimum with the same records, or read off the records."""
    records = problem.records
    local = np.zeros((problem.layout.n_run, len(records.runs)))
    if like is not None:
        local[:2] = np.where(problem.active[:2], like.local[:2], 0.0)
        own = problem.layout.deviations
        local[own] = np.where(problem.active[own], like.local[like.problem.layout.deviations], 0.0)
        return local
    for r, piece in enumerate(records.pieces()):
        if records.moving[r]:
            y = records.position[piece]
            tail = y[-max(8, y.size // 5) :]
            n = min(6, y.size)
            local[0, r] = y[0] - 0.5 * (tail.max() + tail.min())
            local[1, r] = np.polyfit(records.time[piece][:n], y[:n], 1)[0]
    return local


def start_phases(problem: Problem, shared: Array, local: Array) -> Array:
    """Local parameters with each run's phases read off its residual: from a wrong phase there is no way downhill.

    Where friction or play decides when the cart moves, phases all around are tried as well.

    Parameters
    ----------
    shared : array, shape (C, P)
        Of several starts.
    local : array, shape (C, Q, R)

    Returns
    -------
    array, shape (C, Q, R)
    """
    sim = problem.simulator
    out = local
    for row in phase_rows(problem):
        out = np.array([_read_phases(problem, *start, row) for start in zip(shared, out, strict=True)])
        if any(e.dry or e.n_switches for e in sim.effects):
            around = np.repeat(out[:, None], 1 + PHASES, axis=1)
            around[:, 1:, row] = 2 * np.pi * np.arange(PHASES)[:, None] / PHASES
            out = best_by_run(problem, shared, around)
    return out


def phase_rows(problem: Problem) -> list[int]:
    """Rows of the local parameters that are phases."""
    parameters = [q for e in problem.simulator.effects for q in e.run_parameters]
    return [row for row, parameter in enumerate(parameters, 2) if parameter.unit == "rad"]


def _read_phases(problem: Problem, shared: Array, local: Array, row: int) -> Array:
    """Local parameters with one row of phases fitted by least squares.

    The reading is as good as linear in the sine and cosine of a phase.
    """
    sim = problem.simulator
    records = sim.records
    tried = np.repeat(local[None], 3, axis=0)
    tried[:, row] = np.array([0.0, np.pi, np.pi / 2])[:, None]
    seen = sim.readings(np.repeat(shared[None], 3, axis=0), tried)
    if not np.isfinite(seen).all():
        return local
    middle = 0.5 * (seen[0] + seen[1])
    waves = records.weighted(np.array([seen[0] - middle, seen[2] - middle]))
    left = records.weighted(records.position - middle)
    out = local.copy()
    for r, piece in enumerate(records.pieces()):
        cosine, sine = np.linalg.lstsq(waves[:, piece].T, left[piece], rcond=None)[0]
        out[row, r] = np.arctan2(sine, cosine)
    return out


def best_by_run(problem: Problem, shared: Array, tried: Array) -> Array:
    """Each run's best of several local parameters: with the shared ones given, runs do not depend on each other.

    Parameters
    ----------
    shared : array, shape (C, P)
    tried : array, shape (C, K, Q, R)
        K for each of the shared ones; the first of equally good ones is taken.

    Returns
    -------
    array, shape (C, Q, R)
    """
    sim = problem.simulator
    records = sim.records
    copies, count = tried.shape[:2]
    every = np.repeat(shared, count, axis=0)
    flat = tried.reshape(copies * count, *tried.shape[2:])
    reading = sim.readings(every, flat)
    with np.errstate(all="ignore"):
        square = records.weighted(records.position - reading) ** 2
        cost = np.nan_to_num(np.add.reduceat(square, records.first, axis=1), nan=np.inf)
    best = np.argmin(cost.reshape(copies, count, -1), axis=1)
    chosen: Array = np.take_along_axis(tried, best[:, None, None, :], axis=1)[:, 0]
    return chosen


def fit_linear(records: Records, *, tolerance: float = 0.0, workers: int = 1) -> Optimum | None:
    """Fit the linear plant: weak-form starts of several widths, the best few polished; None where no start is stable.

    Where no width leads to a stable plant, as where carts only rise and stick, the motion is shorter than the strongest
    period says: then widths are halved until one does.
    """
    period = strongest_period(records)
    widths = [width * period for width in _WIDTHS]
    found = _fit_linear(records, widths, tolerance, workers)
    width, least = min(widths) / 2, float(records.sample_time.min())
    while found is None and width > least:
        found = _fit_linear(records, [width], tolerance, workers)
        width /= 2
    return found


def within_weights(linear: Optimum, *, tolerance: float = 0.0) -> Optimum:
    """The linear fit with base masses that known weights can tell: others are said by what the plant does not explain.

    Where a misfit remains, a mass may grow without end, or vanish, for whatever the weights then do is nothing, or
    all; no start near such a plant leads to what is missing. The plant's other parameters go with its masses, which are
    held. Nor does a start near a light plant lead to a heavy one, beside which the weights do next to nothing: that is
    tried as well, so that the answer leaves no more than it does.
    """
    records, of = linear.problem.records, linear.problem.layout
    if fixes_mass(records) is not None:
        return linear
    lightest, heaviest = mass_span(records) / _HEAVIEST, mass_span(records) * _HEAVIEST

    def told(found: Optimum) -> bool:
        mass = found.shared[of.base_mass]
        return bool(np.all((lightest <= mass) & (mass <= heaviest)))

    mass = linear.shared[of.base_mass]
    near = linear if told(linear) else _held(linear, np.clip(mass, lightest, heaviest), tolerance)
    aim = np.inf if near is None else near.cost
    heavy = _held(linear, np.full(mass.size, heaviest), tolerance, aim)
    if heavy is None or heavy.cost >= aim:
        return near or linear
    free = minimize(linear.problem, heavy.shared, heavy.local, tolerance=tolerance)
    return free if free is not None and told(free) and free.cost < heavy.cost else heavy


def _held(linear: Optimum, base_mass: Array, tolerance: float, aim: float = np.inf) -> Optimum | None:
    """The linear fit with its base masses held at some; it begins with the same ratios to the mean mass that moves."""
    of, records = linear.problem.layout, linear.problem.records
    moving = base_mass[records.base] + records.added_mass
    shared = linear.shared * (np.mean(moving) / np.mean(of.mass(linear.shared)))  # k/m and c/m stay
    shared[of.base_mass] = base_mass
    return minimize(_at_its_mass(linear.problem), shared, linear.local, tolerance=tolerance, aim=aim)


def _at_its_mass(problem: Problem) -> Problem:
    """The problem with its base masses held."""
    return replace(problem, free=problem.free & (np.arange(problem.free.size) >= len(problem.records.bases)))


def _fit_linear(records: Records, widths: Sequence[float], tolerance: float, workers: int) -> Optimum | None:
    """Fit the linear plant from the weak form with bumps of these widths [s]."""
    problem = build(records, (), workers=workers)
    mass = fixes_mass(records)
    best: Optimum | None = None
    for guess in (mass,) if mass is not None else (None, *(share * records.mass_scale for share in _MASSES)):
        for width in widths:
            weak = WeakForm(records, width, fixed_mass=guess).solve()
            if weak is None:
                continue
            shared = weak.shared
            start = start_local(problem)
            if guess is not mass:  # the ratios first: noise can hide the mass from the weak form, never k/m and c/m
                first = minimize(_at_its_mass(problem), shared, start, tolerance=tolerance, iterations=8)
                if first is None:
                    continue
                shared, start = first.shared, first.local
            if best is None:
                best = minimize(problem, shared, start, tolerance=tolerance)
                continue
            other = minimize(problem, shared, start, tolerance=max(tolerance, 0.1 * _ALIKE * best.cost), aim=best.cost)
            if other is not None and other.cost < (1 - _ALIKE) * best.cost:
                best = minimize(problem, other.shared, other.local, tolerance=tolerance) or best
            elif other is not None and other.cost < (1 + _ALIKE) * best.cost:
                return best
    return best


def scales(records: Records, linear: Optimum, floor: float) -> Scales:
    """Typical magnitudes, from the records and the linear fit."""
    states = linear.solved.states
    of, shared = linear.problem.layout, linear.shared
    stiffness = float(shared[of.stiffness].mean())
    mass = float(of.mass(shared).mean())
    volts = np.abs(records.volts)
    displacement = float(np.abs(states[0]).max())
    return Scales(
        displacement=displacement,
        velocity=float(np.abs(states[1]).max()),
        force=stiffness * displacement,
        mass=mass,
        stiffness=stiffness,
        damping=float(np.abs(shared[of.damping]).mean()),
        volts=float(volts.max()) or 1.0,
        volts_least=float(volts[volts > 0].min()) if volts.any() else 1.0,
        sample_time=float(records.sample_time.mean()),
        duration=max(float(np.ptp(records.time[piece])) for piece in records.pieces()),
        floor=floor,
        low=float(states[0].min()),
        high=float(states[0].max()),
        resonances=resonances(records, linear.residual),
    )
