"""How far stepid's simulator is from tight-tolerance, event-located integration, effect by effect.

    python benchmarks/simulator_accuracy.py [--only NAME] [--fit]
    python benchmarks/simulator_accuracy.py --cases [--only NAME]

Five runs at the paper's sample time are computed by `hidden.reference` (tests/hidden) and by `stepid.simulate` with the
same plant; the difference is in counts of the paper's encoder (226600 counts/m; asked: RMS at most 0.1). The time is
that of one call of `stepid.simulate`, after a first one. With --fit, `stepid.fit` is given the reference's data and the
true effect: what it leaves, and what the simulator's error does to the effect's parameters. With --cases single runs
of every effect, a step and a release, and of thirty combinations of two to four are compared, as in
tests/simulation/test_reference.py (asked: RMS at most 0.001).
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

import stepid  # noqa: E402
from exact_plants import COUNTS, EFFECTS, exact_campaign, true_model  # noqa: E402
from hidden.accuracy_cases import CASES  # noqa: E402
from hidden_runs import error  # noqa: E402


def print_cases(only: str | None) -> None:
    """RMS of every single run, counts, and the worst of each kind."""
    worst: dict[str, float] = {}
    for case in CASES:
        if only and only not in case:
            continue
        rms = error(case)
        words = case.split()
        kind = words[-1] if words[-1] in ("step", "release") else words[0]
        worst[kind] = max(worst.get(kind, 0.0), rms)
        print(f"{case}: {rms:.6f}", flush=True)
    print("worst RMS, counts:", ", ".join(f"{kind} {rms:.6f}" for kind, rms in worst.items()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="one effect")
    parser.add_argument("--fit", action="store_true", help="also fit the reference's data")
    parser.add_argument("--cases", action="store_true", help="single runs of every effect and of combinations")
    args = parser.parse_args()
    if args.cases:
        print_cases(args.only)
        return
    print("| effect | RMS, counts | largest | CPU ms | after a fit, RMS | worst parameter |")
    print("| --- | --- | --- | --- | --- | --- |")
    worst = 0.0
    for name, values in EFFECTS.items():
        if args.only and name != args.only:
            continue
        campaign = exact_campaign({name: values})
        model = true_model(campaign, name, values)
        stepid.simulate(model, campaign)
        start = time.process_time()
        ours = stepid.simulate(model, campaign)
        seconds = time.process_time() - start
        off = np.concatenate([ours[e.name] - e.position for e in campaign.experiments]) * COUNTS
        rms = float(np.sqrt(np.mean(off**2)))
        worst = max(worst, rms)
        row = f"| {name} | {rms:.4f} | {np.max(np.abs(off)):.3f} | {1e3 * seconds:.1f} |"
        if args.fit:
            f = stepid.fit(campaign, effects=(name,))
            off_by = max(abs(f.parameters[f"{name}.{p}"].value / v - 1) for p, v in values.items())
            row += f" {f.rms * COUNTS:.4f} | {100 * off_by:.2g} % |"
        print(row if args.fit else row + " | |", flush=True)
    print(f"worst RMS: {worst:.4f} counts, asked: at most 0.1")


if __name__ == "__main__":
    main()
