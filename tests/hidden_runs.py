"""A run of the hidden plant through stepid's own simulator."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

import stepid
from hidden.accuracy_cases import COUNTS, Case, reference, run
from hidden.plant import Run
from stepid.effects import resolve
from stepid.simulation.layout import DEVIATIONS
from stepid.simulation.records import Records, lay_out
from stepid.simulation.simulator import FINE, Simulator


def polynomials(time: np.ndarray, volts: np.ndarray, between: str) -> np.ndarray:
    """Polynomial of the input from each sample to the next, rising powers: (S, 1), (S, 2) or (S, 4)."""
    if between == "held":
        return volts[:, None].copy()
    if between == "straight":
        return np.column_stack([volts, np.append(np.diff(volts) / np.diff(time), 0.0)])
    rising = CubicSpline(time, volts).c[::-1].T
    return np.ascontiguousarray(np.vstack([rising, [volts[-1], 0.0, 0.0, 0.0]]))


def records_of(told: Run) -> Records:
    time = told.sample_time * np.arange(told.size)
    volts = np.asarray(told.inputs, float)
    travel = max(abs(told.position), told.gain * float(np.abs(volts).max()) / told.stiffness) or 0.01
    whole = stepid.Experiment(
        name="run",
        time=time,
        position=travel * (-1.0) ** np.arange(told.size),
        input=volts,
        added_mass=0.0,
        spring="a",
        damper="b",
        input_before=told.input_before,
    )
    records = lay_out(stepid.Campaign(name="one", experiments=(whole,)))
    coefficients = polynomials(time, volts, told.input_between)
    return replace(records, moving=np.array([bool(told.position)]), coefficients=coefficients)


def plant_of(told: Run, names: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """The plant as the simulator's parameters, those of the campaign and those of the run."""
    shared = [told.mass, told.stiffness, told.damping, told.gain]
    local = [told.position, told.velocity]
    own = 0
    for effect in resolve(tuple(names)):
        shared += [told.effects[effect.name][q.name] for q in effect.parameters]
        local += [told.phase for _ in effect.run_parameters]
        own += effect.n_extra + effect.n_memory
    return np.array(shared), np.array(local + [0.0] * (own + len(DEVIATIONS)))[:, None]


def simulator_of(told: Run, **options: Any) -> Simulator:
    return Simulator(records_of(told), resolve(list(told.effects)), **options)


def simulated(told: Run, **options: Any) -> np.ndarray:
    """Reading at each sample, m."""
    shared, local = plant_of(told, list(told.effects))
    return simulator_of(told, **options).readings(shared[None], local[None])[0]


def central(sim: Simulator, shared: np.ndarray, local: np.ndarray, row: int, step: float) -> np.ndarray:
    """Central difference of the reading by one parameter, those of the run after the shared ones."""
    both = []
    for way in (1, -1):
        moved = [shared.copy(), local.copy()]
        if row < shared.size:
            moved[0][row] += way * step
        else:
            moved[1][row - shared.size] += way * step
        both.append(sim.readings(moved[0][None], moved[1][None])[0])
    out: np.ndarray = (both[0] - both[1]) / (2 * step)
    return out


def error(case: str | Case, tolerance: float = FINE) -> float:
    """RMS distance to the tight reference, counts."""
    off = simulated(run(case), tolerance=tolerance) - reference(case)
    return float(np.sqrt(np.mean(off**2))) * COUNTS
