"""Derivatives that follow from others, beside the same simulated: how near to the truth, and what a fit takes.

python benchmarks/following_derivatives.py [--rounds N]

Every case of tests/hidden: each derivative that follows, and its forward difference, against the central difference of
a simulation 10,000 times as tight. Then fits of the made-up lab campaign, the two ways in turn in one process.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests")]

import numpy as np  # noqa: E402

import stepid  # noqa: E402
from hidden.accuracy_cases import CASES, run  # noqa: E402
from hidden_runs import central, plant_of, simulator_of  # noqa: E402
from stepid.fitting.problem import build  # noqa: E402
from stepid.simulation.homogeneity import Homogeneity  # noqa: E402

TIGHT = 1e-12
FITS = (
    ("coulomb_friction",),
    ("stribeck_friction",),
    ("presliding_hysteresis",),
    ("coulomb_friction", "cubic_stiffness"),
)


@contextmanager
def all_simulated() -> Iterator[None]:
    """Within this nothing follows from anything."""
    kept = Homogeneity.following

    def nothing(self: Homogeneity, *args: object, **options: object) -> object:
        found = kept(self, *args, **options)  # type: ignore[arg-type]
        return found._replace(spared=np.zeros_like(found.spared), row=np.full_like(found.row, -1))

    Homogeneity.following = nothing  # type: ignore[method-assign, assignment]
    try:
        yield
    finally:
        Homogeneity.following = kept  # type: ignore[method-assign]


def errors(case: str) -> Iterator[tuple[float, float]]:
    """Relative errors of each derivative that follows in a case: as it follows, and as a forward difference."""
    told = run(case)
    shared, local = plant_of(told, list(told.effects))
    sim, tight = simulator_of(told), simulator_of(told, tolerance=TIGHT)
    wanted, active = np.ones(shared.size, dtype=bool), build(sim.records, sim.effects).active
    solved = sim.solve(shared, local)
    if solved is None:
        return
    asked = shared, local, solved.reading, wanted, active, solved.states
    row = sim._homogeneity.following(shared, local, wanted, active, flow=True).row
    follows = np.vstack(sim.derivatives(*asked))
    with all_simulated():
        forward = np.vstack(sim.derivatives(*asked))
    for i in row[row >= 0].tolist():
        truth = central(tight, shared, local, i, sim.steps(shared)[i])
        size = float(np.linalg.norm(truth))
        yield float(np.linalg.norm(follows[i] - truth)) / size, float(np.linalg.norm(forward[i] - truth)) / size


def seconds(effects: tuple[str, ...], campaign: stepid.Campaign) -> float:
    begin = time.process_time()
    stepid.fit(campaign, effects=effects)
    return time.process_time() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    found = np.array([pair for case in CASES for pair in errors(case)])
    print(f"| relative error of {len(found)} derivatives | follows | forward difference |\n| --- | --- | --- |")
    for name, value in (("median", np.median(found, axis=0)), ("90 %", np.quantile(found, 0.9, axis=0))):
        print(f"| {name} | {value[0]:.1e} | {value[1]:.1e} |")
    print(f"| largest | {found[:, 0].max():.1e} | {found[:, 1].max():.1e} |")
    campaign = stepid.datasets.lab_campaign()
    print("\n| fit of the lab campaign, CPU s | follows | all simulated | ratio |\n| --- | --- | --- | --- |")
    for effects in FITS:
        seconds(effects, campaign)
        times = []
        for _ in range(rounds):
            with all_simulated():
                simulated = seconds(effects, campaign)
            times.append((seconds(effects, campaign), simulated))
        less, more = np.median(times, axis=0)
        print(f"| {' + '.join(effects)} | {less:.3f} | {more:.3f} | {more / less:.2f} |")


if __name__ == "__main__":
    main()
