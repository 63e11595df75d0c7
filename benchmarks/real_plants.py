"""Diagnose recordings of real one-mass plants, and hold the answers against what is known of each.

    STEPID_REAL_DATA=… python benchmarks/real_plants.py [--only NAME]… [--json FILE] [--page docs/real-plants.md]

One process; the kernel is compiled before the clock starts; seconds are the process's CPU time.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from pydantic import BaseModel

import stepid
from real_sets import SETS, RealSet, named
from stepid import Diagnosis
from stepid.simulation.warm_up import warm_up

MOST_SECONDS = 20.0  # CPU, for each
_PAGE = """# Real plants

Recordings that others made and published, of plants with one degree of freedom.
None of them is part of stepid: `benchmarks/real_plants.py` reads them from a folder of their own.
The gap is what the linear model and the answer leave, RMS; in roll and in the pendulum the position is an angle, in
the Silverbox a voltage.
*As asked*: the name is right, the gap small enough, and it takes at most 20 s. Of the whole roll decays and of Trento,
where more than the catalogue is at work, "unexplained" is right, too.

"""
_HEAD = ("recording", "known", "answer", "gap before", "gap after", "CPU [s]", "as asked")


class Row(BaseModel):
    """One recording: what is known of it, what stepid says, and whether that is what was asked."""

    name: str
    source: str
    known: str
    verdict: str
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    unit: str
    before: float
    after: float
    most: float | None
    explained: float | None
    left: float
    scatter: tuple[str, ...]
    faults: tuple[str, ...]
    parameters: dict[str, float]
    reasons: tuple[str, ...]
    seconds: float
    right: bool
    close: bool

    @property
    def passed(self) -> bool:
        """Whether the name, the gap and the time are as asked."""
        return self.right and self.close and self.seconds <= MOST_SECONDS


def diagnosed(what: RealSet, progress: bool = False) -> Row:
    """Diagnose one recording."""
    campaign = what.build()
    begin = time.process_time()

    def tell(stage: str) -> None:
        print(f"    {time.process_time() - begin:6.2f} s  {stage}", flush=True)

    d: Diagnosis = stepid.diagnose(campaign, progress=tell if progress else None)
    seconds = time.process_time() - begin
    unit, scale = what.unit
    after = scale * d.gap.after
    return Row(
        name=what.name,
        source=what.source,
        known=what.known,
        verdict=d.verdict,
        effects=d.effects,
        alternatives=d.alternatives,
        unit=unit,
        before=scale * d.gap.before,
        after=after,
        most=what.most if what.most < float("inf") else None,
        explained=d.explained,
        left=d.left,
        scatter=tuple(d.scatter),
        faults=tuple(f"{f.run}: {f.kind}" for f in d.faults),
        parameters={name: e.value for name, e in d.parameters.items()},
        reasons=d.reasons,
        seconds=seconds,
        right=what.right(d),
        close=after <= what.most or (d.verdict == "unexplained" and what.name == "roll-whole"),
    )


def told(row: Row) -> str:
    """One row as text for a terminal."""
    names = named(row.effects, row.alternatives)
    asked = f" (≤ {row.most:g})" if row.most is not None else ""
    gap = f"{row.before:.4g} → {row.after:.4g} {row.unit}{asked}"
    differ = ", ".join((*row.scatter, *row.faults))
    return (
        f"{'ok  ' if row.passed else 'MISS'} {row.name:26s} {row.verdict:11s} {names} | {gap} | {row.seconds:.1f} s | "
        f"known: {row.known}" + (f" | runs differ: {differ}" if differ else "")
    )


def page(rows: list[Row]) -> str:
    """All rows as a page of the documentation."""
    lines = ["| " + " | ".join(_HEAD) + " |", "| " + " | ".join("---" for _ in _HEAD) + " |"]
    for row in rows:
        names = named(row.effects, row.alternatives).replace("_", " ")
        cells = (
            f"{row.name}: {row.source}",
            row.known,
            f"{row.verdict}: {names}" if row.verdict != "adequate" else "adequate",
            f"{row.before:.3g} {row.unit}",
            f"{row.after:.3g} {row.unit}",
            f"{row.seconds:.1f}",
            "yes" if row.passed else "no",
        )
        lines.append("| " + " | ".join(cells) + " |")
    passed = sum(row.passed for row in rows)
    end = f"\n{passed} of {len(rows)} are as asked: name, gap and at most {MOST_SECONDS:g} s.\n"
    return _PAGE + "\n".join(lines) + "\n" + end


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=sorted(SETS), help="recordings to run; all by default")
    parser.add_argument("--json", type=Path, help="where to write all figures")
    parser.add_argument("--page", type=Path, help="where to write the page of the documentation")
    parser.add_argument("--progress", action="store_true", help="say what is done when")
    parser.add_argument("--reasons", action="store_true", help="say why")
    given = parser.parse_args()
    rows = []
    warm_up(print)
    for name in given.only or SETS:
        try:
            row = diagnosed(SETS[name], given.progress)
        except Exception as error:  # one recording that fails must not hide the others
            print(f"FAIL {name}: {type(error).__name__}: {error}", flush=True)
            continue
        rows.append(row)
        print(told(row), flush=True)
        if given.reasons:
            print(*(f"    {r}" for r in row.reasons), sep="\n")
            print("   ", {k: float(f"{v:.5g}") for k, v in row.parameters.items()}, flush=True)
    if given.json:
        given.json.write_text(json.dumps([row.model_dump() for row in rows], indent=1, ensure_ascii=False) + "\n")
    if given.page:
        given.page.write_text(page(rows))


if __name__ == "__main__":
    main()
