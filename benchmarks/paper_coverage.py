"""Coverage of the 95 % intervals of the paper's method: sampled peaks, both solvers, with and without noise.

Run `python benchmarks/paper_coverage.py [campaigns]`. Each campaign draws its plant, its four weights (5 g each) and
its noise anew; steps of 18 mm, sample time 8.8542 ms. A figure is right when it lies within 92 to 98 %.
"""

from __future__ import annotations

import sys
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from closed_form import draw_plant, make_campaign
from stepid.errors import IdentificationError
from stepid.identification.characteristics import characterize
from stepid.identification.peak import InterpolatedPeak, Peak, SampledPeak
from stepid.identification.solve import solve
from stepid.identification.solvers import OrdinaryLeastSquares, WeightedLeastSquares
from stepid.identification.stacked import assemble

SOLVERS = {"ordinary": OrdinaryLeastSquares(), "weighted": WeightedLeastSquares()}
QUANTITIES = ("base mass", "stiffness", "damping (each run)", "damping (pooled)")


def z_scores(campaigns: int, *, noise: float, peak: Peak) -> dict[str, dict[str, np.ndarray]]:
    """Error over standard uncertainty, by solver and quantity; failures count as infinite."""
    scores: dict[str, dict[str, list[float]]] = {name: {q: [] for q in QUANTITIES} for name in SOLVERS}
    for number in range(campaigns):
        rng = np.random.default_rng([zlib.crc32(b"coverage"), round(noise * 1e9), number])
        plant = draw_plant(rng)
        campaign = make_campaign(plant, rng, noise=noise, weight_spread=0.005)
        runs = [characterize(run, peak=peak) for run in campaign.experiments]
        system = assemble(runs, campaign.mass_offsets)
        for name, solver in SOLVERS.items():
            try:
                found = solve(system, solver=solver)
            except IdentificationError:
                for values in scores[name].values():
                    values.append(float("inf"))
                continue
            spread = found.uncertainty
            first = campaign.experiments[0].name
            lists = scores[name]
            lists["base mass"].append((found.masses[first] - plant.base_mass) / spread.masses[first])
            lists["stiffness"].append((found.stiffness["medium"] - plant.stiffness) / spread.stiffness["medium"])
            lists["damping (pooled)"].append(
                (found.pooled_damping["1/2 turn"] - plant.damping) / spread.pooled_damping["1/2 turn"]
            )
            for run in campaign.experiments:
                lists["damping (each run)"].append((found.damping[run.name] - plant.damping) / spread.damping[run.name])
    return {name: {q: np.array(v) for q, v in lists.items() if v} for name, lists in scores.items()}


def rows(campaigns: int) -> Iterator[tuple[str, str, str, str, float, float]]:
    for peak in (SampledPeak(), InterpolatedPeak()):
        for noise in (0.0, 20e-6):
            for solver, by_quantity in z_scores(campaigns, noise=noise, peak=peak).items():
                for quantity, scores in by_quantity.items():
                    inside = 100 * float(np.mean(np.abs(scores) < 1.96))
                    bias = float(np.median(scores))
                    yield type(peak).__name__, f"{noise * 1e6:.0f} µm", solver, quantity, inside, bias


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    print(
        f"{count} campaigns each; 95 % intervals; sampling error of a figure {100 * (0.95 * 0.05 / count) ** 0.5:.1f} %"
    )
    print(f"{'peak':<17}{'noise':<8}{'solver':<10}{'quantity':<20}{'covered':>9}{'median z':>10}")
    for peak, noise, solver, quantity, inside, bias in rows(count):
        print(f"{peak:<17}{noise:<8}{solver:<10}{quantity:<20}{inside:8.1f}%{bias:10.2f}")
