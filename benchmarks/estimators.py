"""Estimators side by side: the peak method in all its variants, the joint fit, and what a user would do instead.

    python benchmarks/estimators.py [--count 100] [--cells NAME …] [--ways NAME …] [--page docs/estimators.md]

Every campaign draws its plant anew; records come from the hidden simulator of the tests. Bias is the median error, RMSE
the root of the mean square, both in per cent of the truth; z is the median error over its standard uncertainty;
coverage is that of the 95 % intervals. A refusal counts in none of them.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import math
import sys
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]

import stepid  # noqa: E402
import users_way  # noqa: E402
from hidden.fast import fast  # noqa: E402
from hidden.plant import runs_like  # noqa: E402

QUANTITIES = ("base mass", "stiffness", "damping")
Found = dict[str, tuple[float, float | None]]  # value and standard uncertainty


@dataclass(frozen=True)
class Cell:
    """One setting; each row of the page changes one of them."""

    noise: float = 20e-6  # m
    correlation: float = 0.0  # s, of the noise
    sample_time: float = 0.0088542  # s
    ratio: float = 0.3  # damping ratio of the empty cart
    spread: float = 1.5  # kg, of the added masses of four runs
    friction: float = 0.0  # Coulomb, of the largest spring force
    weights: float = 0.0  # kg, of a 0.5 kg weight


CELLS = {
    "noise 5 µm": Cell(noise=5e-6),
    "usual": Cell(),
    "noise 50 µm": Cell(noise=50e-6),
    "noise 200 µm": Cell(noise=200e-6),
    "colored 2 ms": Cell(correlation=2e-3),
    "colored 10 ms": Cell(correlation=10e-3),
    "sampled every 0.9 ms": Cell(sample_time=0.88542e-3),
    "sampled every 4.4 ms": Cell(sample_time=4.4271e-3),
    "damping ratio 0.1": Cell(ratio=0.1),
    "damping ratio 0.6": Cell(ratio=0.6),
    "masses up to 0.5 kg": Cell(spread=0.5),
    "masses up to 4 kg": Cell(spread=4.0),
    "weights known to 5 g": Cell(weights=0.005),
    "friction 0.5 %": Cell(friction=0.005),
    "friction 3 %": Cell(friction=0.03),
}


def draw(cell: Cell, rng: np.random.Generator) -> tuple[stepid.Campaign, dict[str, float]]:
    mass, rate = float(rng.uniform(0.8, 1.2)), float(rng.uniform(13.0, 18.0))
    k = mass * rate**2
    truth = {"base mass": mass, "stiffness": k, "damping": 2 * cell.ratio * math.sqrt(k * mass)}
    reach = float(rng.uniform(0.014, 0.02))
    settle = min(5.0 * 2 * (mass + cell.spread) / truth["damping"], 8.0)
    count = 8 + round(settle / cell.sample_time)
    volts = np.where(np.arange(count) < 8, 0.0, 0.5)
    experiments = [
        stepid.Experiment(
            name=f"run {i + 1}", time=cell.sample_time * np.arange(count), position=np.zeros(count), input=volts,
            added_mass=added, spring="medium", damper="half",
        )
        for i, added in enumerate(np.linspace(0.0, cell.spread, 4).tolist())
    ]  # fmt: skip
    campaign = stepid.Campaign(name="made up", experiments=experiments, weight_uncertainty=cell.weights or 1e-7)
    runs = runs_like(
        campaign, base_mass=mass, stiffness={"medium": k}, damping={"half": truth["damping"]},
        force_gain=reach * k / 0.5,
        effects={"coulomb_friction": {"level": cell.friction * k * reach}} if cell.friction else {},
    )  # fmt: skip
    error = 0.0
    for run, step in zip(runs, np.diff([e.added_mass for e in experiments], prepend=0.0), strict=True):
        error += cell.weights * math.sqrt(step / 0.5) * rng.standard_normal()
        object.__setattr__(run, "mass", run.mass + error)
    noisy = [x + colored(x.size, cell, rng) for x in fast(runs)]
    made = [stepid.Experiment(**(e.model_dump() | {"position": x})) for e, x in zip(experiments, noisy, strict=True)]
    return campaign.model_copy(update={"experiments": tuple(made)}), truth


def colored(size: int, cell: Cell, rng: np.random.Generator) -> np.ndarray:
    out = cell.noise * rng.standard_normal(size)
    if cell.correlation:
        kept = math.exp(-cell.sample_time / cell.correlation)
        for i in range(1, size):
            out[i] = kept * out[i - 1] + math.sqrt(1 - kept**2) * out[i]
    return out


def by_hand(peak: Any, solver: Any) -> Callable[[stepid.Campaign], Found]:
    def found(campaign: stepid.Campaign) -> Found:
        p = stepid.identify(campaign, peak=peak, solver=solver)
        first, u = campaign.experiments[0].name, p.uncertainty
        return {
            "base mass": (p.masses[first], u.masses[first]),
            "stiffness": (p.stiffness["medium"], u.stiffness["medium"]),
            "damping": (p.pooled_damping["half"], u.pooled_damping["half"]),
        }

    return found


def by_fit(*effects: str) -> Callable[[stepid.Campaign], Found]:
    def found(campaign: stepid.Campaign) -> Found:
        p = stepid.fit(campaign, effects=effects).parameters
        names = ("base_mass", "stiffness[medium]", "damping[half]")
        return {q: (p[n].value, p[n].uncertainty) for q, n in zip(QUANTITIES, names, strict=True)}

    return found


SOLVERS = {"ordinary": stepid.OrdinaryLeastSquares(), "weighted": stepid.WeightedLeastSquares()}
if hasattr(stepid, "ErrorsInVariables"):
    SOLVERS["errors in variables"] = stepid.ErrorsInVariables()
PEAKS = {"sampled": stepid.SampledPeak(), "interpolated": stepid.InterpolatedPeak()}
WAYS: dict[str, Callable[[stepid.Campaign], Found]] = {
    **{f"{p} peak, {s} stack": by_hand(peak, solver) for p, peak in PEAKS.items() for s, solver in SOLVERS.items()},
    "joint fit, linear": by_fit(),
    "joint fit with friction": by_fit("coulomb_friction"),
    "`curve_fit` a record, masses": users_way.curve_fits,
    "`step_info` a record, masses": users_way.step_infos,
    "ERA a record, masses": users_way.realizations,
    "lmfit, all records": users_way.joint_lmfit,
}


def measure(name: str, count: int, ways: list[str]) -> dict[str, dict[str, Any]]:
    """Bias, RMSE, coverage and CPU time by estimator."""
    cell = CELLS[name]
    seen: dict[str, list[Any]] = {way: [] for way in ways}
    spent = dict.fromkeys(ways, 0.0)
    for number in range(count):
        campaign, truth = draw(cell, np.random.default_rng([zlib.crc32(name.encode()), number]))
        for way, estimate in ((way, WAYS[way]) for way in ways):
            began = time.process_time()
            try:
                found = estimate(campaign)
            except (ValueError, RuntimeError, ArithmeticError, np.linalg.LinAlgError):
                continue
            finally:
                spent[way] += time.process_time() - began
            seen[way].append([[found[q][0] / truth[q] - 1, (found[q][1] or math.nan) / truth[q]] for q in QUANTITIES])
    out: dict[str, dict[str, Any]] = {}
    for way, rows in seen.items():
        table = np.array(rows).reshape(-1, len(QUANTITIES), 2)
        error, spread = table[..., 0], table[..., 1]
        known = np.isfinite(spread).any()
        out[way] = {
            "refused": count - len(rows),
            "ms": 1e3 * spent[way] / count,
            "bias": [100 * float(v) for v in np.median(error, axis=0)] if rows else [],
            "rmse": [100 * float(v) for v in np.sqrt(np.mean(error**2, axis=0))] if rows else [],
            "z": [float(v) for v in np.median(error / spread, axis=0)] if known else [],
            "coverage": [100 * float(v) for v in np.mean(np.abs(error) < 1.96 * spread, axis=0)] if known else [],
        }
    return out


def page(results: dict[str, Any]) -> str:
    """The tables of the page."""
    out = []
    for name, said_of in results.items():
        count, ways = said_of["count"], said_of["ways"]
        chance = 100 * math.sqrt(0.95 * 0.05 / count)
        out += [f"### {name[0].upper()}{name[1:]}", ""]
        out += [f"{count} campaigns; chance moves a coverage by {chance:.0f}.", ""]
        titles = (
            "estimator",
            "bias, % (m, k, c)",
            "RMSE, % (m, k, c)",
            "z (m, k, c)",
            "covers, % (m, k, c)",
            "refused",
        )
        out += [f"| {' | '.join((*titles, 'ms'))} |", "| --- " * 7 + "|"]
        for way, said in ((way, ways[way]) for way in WAYS if way in ways):
            cells = [
                ", ".join(f"{v:.2g}" if abs(v) < 99.5 else f"{v:.0f}" for v in said[key]) or "–"
                for key in ("bias", "rmse")
            ]
            cells.append(", ".join(f"{v:.2f}" for v in said["z"]) or "–")
            cells.append(", ".join(f"{v:.0f}" for v in said["coverage"]) or "none given")
            out.append(f"| {way} | {' | '.join(cells)} | {said['refused'] or ''} | {said['ms']:.0f} |")
        out.append("")
    return "\n".join(out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--cells", nargs="*", choices=CELLS, default=list(CELLS))
    parser.add_argument("--ways", nargs="*", choices=WAYS, default=list(WAYS))
    parser.add_argument("--keep", type=Path, help="JSON file of finished cells, to go on from")
    parser.add_argument("--page", type=Path)
    given = parser.parse_args()
    done: dict[str, Any] = json.loads(given.keep.read_text()) if given.keep and given.keep.exists() else {}
    for name in given.cells:
        cell = done.setdefault(name, {"count": given.count, "ways": {}})
        missing = [way for way in given.ways if way not in cell["ways"]]
        if missing:
            cell["ways"] |= measure(name, cell["count"], missing)
            if given.keep:
                given.keep.write_text(json.dumps(done))
    text = page({name: done[name] for name in given.cells})
    print(text)
    if given.page:
        before, _, rest = given.page.read_text("utf-8").partition("<!-- tables -->\n")
        given.page.write_text(
            before + "<!-- tables -->\n" + text + "<!-- end -->\n" + rest.partition("<!-- end -->\n")[2], "utf-8"
        )


if __name__ == "__main__":
    main()
