"""stepid's Levenberg–Marquardt beside `scipy.optimize.least_squares`: same residual, same derivatives, same starts.

    python benchmarks/least_squares.py [campaigns]

Every effect of a few kinds, hidden campaigns with r0 = 10, starts off by up to 15 %. Compared are the CPU time of a fit
and where it ends, as cost over that of the best of the two. scipy runs with its own default settings and with
tolerances like stepid's (a step that promises less than 0.05 χ²).
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import sys
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from hidden.campaigns import make_campaign
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import Problem, minimize
from stepid.fitting.problem import build, start_local

EFFECTS = ("coulomb_friction", "stribeck_friction", "cubic_stiffness", "free_play", "flexible_coupling", "actuator_lag")


def by_scipy(problem: Problem, shared: np.ndarray, local: np.ndarray, **options: float) -> float:
    """Cost at which scipy ends, m²; in units of the floor, so that its absolute tolerances mean something."""
    free, active = problem.free, problem.active
    count = int(free.sum())
    scale = np.concatenate(
        [problem.simulator.typical(shared)[free], np.full(int(active.sum()), problem.simulator.scale)]
    )

    def place(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a, b = shared.copy(), local.copy()
        a[free], b[active] = p[:count] * scale[:count], p[count:] * scale[count:]
        return a, b

    def residual(p: np.ndarray) -> np.ndarray:
        solved = problem.simulator.solve(*place(p))
        return np.full(problem.records.size, 1e6) if solved is None else problem.residual(solved) * 1e6

    def jacobian(p: np.ndarray) -> np.ndarray:
        solved = problem.solve(*place(p))
        return np.zeros((problem.records.size, p.size)) if solved is None else -problem.jacobian(solved) * 1e6 * scale

    lower = np.concatenate([problem.lower[free], np.full(int(active.sum()), -np.inf)]) / scale
    upper = np.concatenate([problem.upper[free], np.full(int(active.sum()), np.inf)]) / scale
    start = np.clip(np.concatenate([shared[free], local[active]]) / scale, lower + 1e-9, upper)
    found = least_squares(residual, start, jac=jacobian, bounds=(lower, upper), x_scale="jac", **options)
    return 2.0 * float(found.cost) * 1e-12


def main(count: int) -> None:
    print("effect                fits   own s  scipy s  scipy, loose s   ends: own  scipy  loose (median over best)")
    for name in EFFECTS:
        times, costs = np.zeros(3), []
        for number in range(count):
            campaign, truth = make_campaign(700 + number, (name,), kind="four", r0=10.0)
            context = prepare(campaign)
            problem = build(context.records, resolve([name]))
            rng = np.random.default_rng(number)
            values = [truth["parameters"][f"{name}.{q.name}"] for q in resolve([name])[0].parameters]
            shared = np.concatenate([context.linear.shared, values])
            shared[context.linear.shared.size :] *= rng.uniform(0.85, 1.15, len(values))
            local = start_local(problem, context.linear)
            loose = context.tolerance / context.linear.cost
            ends = []
            for i in range(3):
                start = time.process_time()
                if i == 0:
                    own = minimize(problem, shared, local, tolerance=context.tolerance)
                    ends.append(np.inf if own is None else own.cost)
                else:
                    options = {} if i == 1 else {"ftol": max(loose, 1e-10), "xtol": 1e-10, "gtol": 1e-12}
                    ends.append(by_scipy(problem, shared, local, **options))
                times[i] += time.process_time() - start
            costs.append(np.array(ends) / min(ends))
        middle = np.median(costs, axis=0)
        print(f"{name:20s} {count:5d} {times[0]:7.2f} {times[1]:8.2f} {times[2]:15.2f} ", end="")
        print(f"{middle[0]:12.4f} {middle[1]:6.4f} {middle[2]:6.4f}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
