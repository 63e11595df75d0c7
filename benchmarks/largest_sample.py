"""Median error in standard uncertainties of the stack's solvers where noise picks the peak: 200 µm, every 8.9 ms.

    python benchmarks/largest_sample.py [--count 4000] [--peaks sampled …] [--solvers weighted …] [--keep FILE]

The campaigns are those of `estimators.py`; peaks are read once for all solvers. Chance moves a median of z by
1.25/√count, 0.02 in 4,000 campaigns. A solver whose solution does not settle counts as refused.
"""

from __future__ import annotations

import argparse
import json
import math
import zlib
from pathlib import Path
from typing import Any

import numpy as np

import estimators  # first: it finds the tests
import stepid
from stepid.errors import StepidError
from stepid.identification.identify import characterize_campaign
from stepid.identification.solve import solve
from stepid.identification.stacked import assemble

QUANTITIES = estimators.QUANTITIES


def solved(
    campaign: stepid.Campaign, truth: dict[str, float], peak: Any, solvers: list[str]
) -> dict[str, list[float] | None]:
    """Error and standard uncertainty of each quantity by solver, flat."""
    used, excluded = characterize_campaign(campaign, peak=peak)
    out: dict[str, list[float] | None] = dict.fromkeys(solvers)
    if excluded:
        return out
    system = assemble([used[run.name] for run in campaign.experiments], campaign.mass_offsets)
    first = campaign.experiments[0].name
    for name in solvers:
        try:
            p = solve(system, solver=estimators.SOLVERS[name])
        except StepidError:
            continue
        u = p.uncertainty
        pairs = (
            (p.masses[first] - truth["base mass"], u.masses[first]),
            (p.stiffness["medium"] - truth["stiffness"], u.stiffness["medium"]),
            (p.pooled_damping["half"] - truth["damping"], u.pooled_damping["half"]),
        )
        out[name] = [float(v) for pair in pairs for v in pair]
    return out


def row(peak: str, solver: str, found: list[list[float] | None]) -> str:
    values = np.array([one for one in found if one is not None]).reshape(-1, 3, 2)
    z = values[..., 0] / values[..., 1]
    middle = ", ".join(f"{v:+.3f}" for v in np.median(z, axis=0))
    cover = ", ".join(f"{v:.1f}" for v in 100 * np.mean(np.abs(z) < 1.96, axis=0))
    refused = len(found) - len(values)
    return f"| {peak} peak, {solver} | {middle} | {cover} | {refused} of {len(found)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=4000)
    parser.add_argument("--peaks", nargs="*", choices=estimators.PEAKS, default=list(estimators.PEAKS))
    parser.add_argument("--solvers", nargs="*", choices=estimators.SOLVERS, default=list(estimators.SOLVERS))
    parser.add_argument("--cell", choices=estimators.CELLS, default="noise 200 µm")
    parser.add_argument("--keep", type=Path, help="file of finished campaigns, a line each, to go on from")
    given = parser.parse_args()
    cell, seed = estimators.CELLS[given.cell], zlib.crc32(given.cell.encode())
    lines = given.keep.read_text().splitlines() if given.keep and given.keep.exists() else []
    results: list[dict[str, Any]] = [json.loads(line) for line in lines][: given.count]
    for number in range(len(results), given.count):
        campaign, truth = estimators.draw(cell, np.random.default_rng([seed, number]))
        results.append({peak: solved(campaign, truth, estimators.PEAKS[peak], given.solvers) for peak in given.peaks})
        if given.keep:
            with given.keep.open("a") as file:
                file.write(json.dumps(results[-1]) + "\n")
    print(f"{given.cell}, {given.count} campaigns; chance moves a median z by {1.25 / math.sqrt(given.count):.3f}\n")
    print("| estimator | median z (m, k, c) | covers, % (m, k, c) | refused |\n| --- | --- | --- | --- |")
    for peak in given.peaks:
        for solver in given.solvers:
            print(row(peak, solver, [one[peak][solver] for one in results if solver in one.get(peak, ())]))


if __name__ == "__main__":
    main()
