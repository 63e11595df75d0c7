"""Draw how often answers given with a probability are right, from the lines of `benchmarks/diagnosis.py --lines FILE`.

python benchmarks/calibration.py FILE [FILE ...] [--out docs/_static/calibration.png]
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]

from score_perturbed import calibration  # noqa: E402

KINDS = (("clean", "o", "#0072b2"), ("perturbed", "s", "#d55e00"))


def bins(records: Sequence[dict[str, Any]], kind: str) -> list[dict[str, Any]]:
    """Bins of the clean campaigns, or of the perturbed ones."""
    return calibration(r for r in records if "error" not in r and ("perturbations" in r) == (kind == "perturbed"))


def draw(records: Sequence[dict[str, Any]], out: Path) -> None:
    """Draw the share that is right against the probability that was told, with two binomial standard errors."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(4.2, 3.6), layout="constrained")
    axes.plot([0, 100], [0, 100], color="0.5", linewidth=0.8, label="as told")
    for kind, marker, color in KINDS:
        found = bins(records, kind)
        told = [100 * b["told"] for b in found]
        right = [100 * b["right"] for b in found]
        error = [200 * math.sqrt(b["right"] * (1 - b["right"]) / b["count"]) for b in found]
        label = f"{kind}, {sum(b['count'] for b in found)} answers"
        if found:
            axes.errorbar(told, right, error, fmt=marker, color=color, capsize=2, label=label)
        for b, x, y in zip(found, told, right, strict=True):
            up = 6 if kind == "clean" else -6  # the two may lie on each other
            axes.annotate(str(b["count"]), (x, y), xytext=(-5, up), textcoords="offset points", ha="right", fontsize=7)
    axes.set_xlim(0, 103)
    axes.set_ylim(0, 103)
    axes.set_xlabel("probability told [%]")
    axes.set_ylabel("answers that hold the truth [%]")
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    axes.legend(loc="upper left", frameon=False, fontsize=8)
    figure.savefig(out, dpi=150)
    plt.close(figure)


def main() -> None:
    from one_by_one import read

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "_static" / "calibration.png")
    args = parser.parse_args()
    draw([r for file in args.files for r in read(file)], args.out)


if __name__ == "__main__":
    main()
