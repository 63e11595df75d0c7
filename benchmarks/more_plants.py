"""Diagnose more recordings of real plants, and say whether what is named may be in them.

    STEPID_MORE_DATA=… python benchmarks/more_plants.py [--only NAME]… [--page docs/more-plants.md --commit HASH]

One process; the kernel is compiled before the clock starts; seconds are the process's CPU time.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")

import stepid
from further_sets import SETS as FURTHER
from more_sets import SETS as MORE
from more_sets import MoreSet
from real_sets import named
from stepid import Diagnosis
from stepid.simulation.warm_up import warm_up

SETS = {**MORE, **FURTHER}
_HEAD = ("recording", "what is known", "answer", "share", "floors before", "after", "CPU [s]", "names")
_PAGE = """# More real plants

Recordings of plants with one degree of freedom, found in public repositories when the rules of the diagnosis stood.
None of them is part of stepid: `benchmarks/more_plants.py` reads them from a folder of their own, and makes this page.
What they showed mended some rules (the [changes](changelog.md) say which), so that they are no test of these any more;
no number that decides was set on them. A record with one run is cut into three slices. *Share* is what the answer
takes of the misfit's power on runs left out. *Floors* is what the linear model and the answer leave, over the noise
floor. *Names* says whether all effects that are named are known to be in the plant.

"""

_FURTHER = """# Real plants that were found last

Sixteen more recordings, from seven sources, looked for to see what the diagnosis of the day does wrong:
`benchmarks/more_plants.py --further` makes this page. Three of its defects came to light in them (the
[changes](changelog.md) say which), so that these are no test of what mended them. Columns are as on the page of
[more plants](more-plants.md).

"""

_MEASURED = """## Masses and stiffnesses

Of some plants the masses were weighed (a third of the spring's in it) and the stiffness was measured at rest. Two
swings with 39.5 g between them tell both:

"""


class Row(NamedTuple):
    """One recording and its answer."""

    what: MoreSet
    found: Diagnosis
    seconds: float

    @property
    def names(self) -> str:
        """Whether the names are right, or nothing is known of them; – where none is told."""
        told = set(self.found.effects)
        if self.found.verdict not in ("named", "ambiguous"):
            return "–"
        if told <= self.what.allowed:
            return "right"
        return "not known" if told <= self.what.allowed | self.what.unknown else "wrong"

    @property
    def answer(self) -> str:
        """The verdict, and what it names."""
        if not self.found.effects:
            return self.found.verdict
        return f"{self.found.verdict}: {named(self.found.effects, self.found.alternatives)}".replace("_", " ")

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the page."""
        gap, share = self.found.gap, self.found.explained
        return (
            f"{self.what.name}: {self.what.source}",
            self.what.known,
            self.answer,
            "" if share is None or self.names == "–" else f"{share:.2f}",
            f"{gap.before / gap.noise:.3g}",
            f"{gap.after / gap.noise:.3g}",
            f"{self.seconds:.1f}",
            self.names,
        )


def page(rows: list[Row], commit: str, head: str) -> str:
    """All rows as a page of the documentation, below its head."""
    lines = [_HEAD, tuple("---" for _ in _HEAD), *(row.cells for row in rows)]
    table = "\n".join("| " + " | ".join(cells) + " |" for cells in lines)
    kinds = ("right", "not known", "wrong", "–")
    right, open_, wrong, none = (sum(row.names == kind for row in rows) for kind in kinds)
    total = f"Of {len(rows)} recordings {right} are named right and {wrong} wrong. Of {open_} names no one knows. "
    total += f"{none} answers name nothing."
    return f"{head}This run is of {commit}. {total}\n\n{table}\n{_measured(rows)}"


def _measured(rows: list[Row]) -> str:
    """What a balance and a ruler told of the plants, and what the joint fit of the linear plant says; "" if nothing."""
    found = [(row, name, value) for row in rows for name, value in row.what.measured.items()]
    told = [(row.what.name, name, f"{value:g}", str(row.found.linear_parameters[name])) for row, name, value in found]
    lines = [("recording", "parameter", "measured", "found"), ("---",) * 4, *told]
    table = "\n".join("| " + " | ".join(cells) + " |" for cells in lines)
    return f"\n{_MEASURED}{table}\n" if told else ""


def main() -> None:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=sorted(SETS), help="recordings to run")
    parser.add_argument("--further", action="store_true", help="those that were found last")
    parser.add_argument("--page", type=Path, help="where to write the page of the documentation")
    parser.add_argument("--commit", default="this version", help="what is run, for the page")
    given = parser.parse_args()
    warm_up(lambda words: None)
    rows = []
    for name in given.only or (FURTHER if given.further else MORE):
        campaign = SETS[name].build()
        begin = time.process_time()
        rows.append(Row(SETS[name], stepid.diagnose(campaign), time.process_time() - begin))
        print(" | ".join(rows[-1].cells), flush=True)
    if given.page:
        given.page.write_text(page(rows, given.commit, _FURTHER if given.further else _PAGE), encoding="utf-8")


if __name__ == "__main__":
    main()
