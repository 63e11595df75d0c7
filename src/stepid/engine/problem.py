"""From a campaign and effects to a fit problem: what is free, what is fixed, where it starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stepid._base import Array
from stepid.effects.base import Effect, Parameter, Scales
from stepid.engine.least_squares import Optimum, Problem, minimize
from stepid.engine.records import Records
from stepid.engine.trajectory import Simulator
from stepid.engine.weak import WeakForm

_WIDTHS = (0.6, 1.0, 1.6, 0.35)  # of the strongest period, for the weak form
_MASSES = (1.0, 0.4, 2.5)  # kg


def fixes_mass(records: Records) -> float | None:
    """Base mass to assume where no two runs of one base differ in added mass, else None.

    The total mass of the first run is then 1 kg, and every parameter is per unit mass.
    """
    for base in range(len(records.bases)):
        added = records.added_mass[records.base == base]
        if added.size and np.ptp(added) > 0:
            return None
    return 1.0 - float(records.added_mass[0])


def build(records: Records, effects: tuple[Effect, ...], *, fineness: float = 1.0) -> Problem:
    """Set up the fit of a linear plant with effects to all records."""
    sim = Simulator(records, effects, fineness)
    a, b, c = sim.n_labels
    parameters: list[Parameter] = [q for e in effects for q in e.parameters]
    least_added = np.array([records.added_mass[records.base == i].min(initial=np.inf) for i in range(a)])
    lower = np.concatenate(
        [1e-3 - least_added, np.full(b, 1e-9), np.zeros(c), [-np.inf], [q.lower for q in parameters]]
    )
    upper = np.concatenate([np.full(a + b + c + 1, np.inf), [q.upper for q in parameters]])
    free = np.ones(sim.n_shared, dtype=bool)
    if fixes_mass(records) is not None:
        free[0] = False
    if not (np.any(records.volts) or np.any(records.before)):
        free[a + b + c] = False
    active = np.zeros((sim.n_local, len(records.runs)), dtype=bool)
    active[0] = records.moving | any(e.rests_anywhere or e.never_rests for e in effects)
    active[1] = records.moving | any(e.never_rests for e in effects)
    active[2:] = True
    unknown = [not e.settled for e in effects for _ in range(e.n_extra)]
    unknown += [not e.settled for e in effects for _ in range(e.n_memory)]
    active[sim.own_states] = records.moving & np.array(unknown, dtype=bool)[:, None]
    return Problem(sim, free, lower, upper, active)


def start_local(problem: Problem, like: Optimum | None = None) -> Array:
    """Local parameters to start from: those of an optimum with the same records, or read off the records."""
    records = problem.simulator.records
    local = np.zeros((problem.simulator.n_local, len(records.runs)))
    if like is not None:
        local[:2] = like.local[:2]
        local[0, ~problem.active[0]] = 0.0
        return local
    for r, piece in enumerate(records.pieces()):
        if records.moving[r]:
            y = records.position[piece]
            tail = y[-max(8, y.size // 5) :]
            n = min(6, y.size)
            local[0, r] = y[0] - 0.5 * (tail.max() + tail.min())
            local[1, r] = np.polyfit(records.time[piece][:n], y[:n], 1)[0]
    return local


def start_phases(problem: Problem, shared: Array, local: Array, start: Array | None) -> Array:
    """Local parameters with each run's phases read off its residual: from a wrong phase there is no way downhill.

    The reading is as good as linear in the sine and cosine of a phase; both are fitted to the run by least squares.
    """
    sim, out = problem.simulator, local
    records = sim.records
    row = 2
    for effect in sim.law.effects:
        for q, parameter in enumerate(effect.run_parameters, row):
            if parameter.unit != "rad":
                continue
            seen = []
            for phase in (0.0, np.pi, np.pi / 2):
                tried = out.copy()
                tried[q] = phase
                solved = sim.solve(shared, tried, start=start)
                if solved is None:
                    return out
                seen.append(solved.reading)
            middle = 0.5 * (seen[0] + seen[1])
            waves = records.weighted(np.array([seen[0] - middle, seen[2] - middle]))
            left = records.weighted(records.position - middle)
            out = out.copy()
            for r, piece in enumerate(records.pieces()):
                cosine, sine = np.linalg.lstsq(waves[:, piece].T, left[piece], rcond=None)[0]
                out[q, r] = np.arctan2(sine, cosine)
        row += len(effect.run_parameters)
    return out


def strongest_period(records: Records) -> float:
    """Period [s] of the strongest oscillation over all records."""
    best, power = 0.5, 0.0
    for r, piece in enumerate(records.pieces()):
        y = np.diff(records.position[piece])
        spectrum = np.abs(np.fft.rfft(y * np.hanning(y.size), 4 * y.size)) ** 2
        frequency = np.fft.rfftfreq(4 * y.size, float(records.sample_time[r]))
        usable = frequency > 1.5 / (y.size * records.sample_time[r])
        k = int(np.argmax(np.where(usable, spectrum, 0.0)))
        if spectrum[k] > power:
            best, power = 1.0 / float(frequency[k]), float(spectrum[k])
    return best


def fit_linear(records: Records, *, tolerance: float = 0.0) -> Optimum | None:
    """Fit the linear plant: weak-form starts of several widths, the best few polished."""
    problem = build(records, ())
    period, mass = strongest_period(records), fixes_mass(records)
    tried: list[Optimum] = []
    for guess in (mass,) if mass is not None else (None, *_MASSES):
        for width in _WIDTHS:
            weak = WeakForm(records, width * period, fixed_mass=guess).solve()
            if weak is None:
                continue
            shared = weak.shared
            start = start_local(problem)
            if guess is not mass:  # the ratios first: noise can hide the mass from the weak form, never k/m and c/m
                held = replace(problem, free=problem.free & (np.arange(problem.free.size) >= len(records.bases)))
                first = minimize(held, shared, start, tolerance=tolerance, iterations=8)
                if first is None:
                    continue
                shared, start = first.shared, first.local
            found = minimize(problem, shared, start, tolerance=tolerance)
            if found is None:
                continue
            tried.append(found)
            costs = sorted(o.cost for o in tried)
            if len(tried) > 1 and costs[1] < 1.001 * costs[0]:
                return min(tried, key=lambda o: o.cost)
    return min(tried, key=lambda o: o.cost) if tried else None


def scales(records: Records, linear: Optimum, floor: float) -> Scales:
    """Typical magnitudes, from the records and the linear fit."""
    states = linear.solved.states
    a, b, c = linear.problem.simulator.n_labels
    shared = linear.shared
    stiffness = float(shared[a : a + b].mean())
    mass = float((shared[:a][records.base] + records.added_mass).mean())
    volts = np.abs(records.volts)
    displacement = float(np.abs(states[0]).max())
    return Scales(
        displacement=displacement,
        velocity=float(np.abs(states[1]).max()),
        force=stiffness * displacement,
        mass=mass,
        stiffness=stiffness,
        damping=float(np.abs(shared[a + b : a + b + c]).mean()),
        volts=float(volts.max()) or 1.0,
        volts_least=float(volts[volts > 0].min()) if volts.any() else 1.0,
        sample_time=float(records.sample_time.mean()),
        duration=float(np.max(records.time)),
        floor=floor,
        low=float(states[0].min()),
        high=float(states[0].max()),
        resonances=resonances(records, linear.residual),
    )


def resonances(records: Records, residual: Array, count: int = 3) -> tuple[float, ...]:
    """Frequencies [Hz] at which the residual is strongest over all runs, strongest first."""
    duration = float(np.max(records.time))
    step = float(records.sample_time.min())
    grid = np.fft.rfftfreq(4 * int(duration / step), step)
    total = np.zeros_like(grid)
    for r, piece in enumerate(records.pieces()):
        y = residual[piece]
        n = 4 * y.size
        total += np.interp(
            grid, np.fft.rfftfreq(n, float(records.sample_time[r])), np.abs(np.fft.rfft(y * np.hanning(y.size), n)) ** 2
        )
    total[grid < 1.0 / duration] = 0.0
    found: list[float] = []
    for _ in range(count):
        k = int(np.argmax(total))
        if total[k] <= 0:
            break
        found.append(float(grid[k]))
        total[np.abs(grid - grid[k]) < max(1.5 / duration, 0.15 * grid[k])] = 0.0
    return tuple(found)
