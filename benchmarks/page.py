"""The page of the documentation on how often the diagnosis is right, from the lines of one frozen run."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence

import judge
from hidden.outside import EVERY_OUTSIDE, SEEN_OUTSIDE
from score import Record, answers, first_right, in_set

UNSEEN = set(EVERY_OUTSIDE) - set(SEEN_OUTSIDE)

HEAD = """# Does the diagnosis name the right effect?

`python benchmarks/score_perturbed.py LINES --page docs/diagnosis-benchmark.md` makes this page from the lines of one
run:

    python benchmarks/diagnosis.py --set single-all=400 --set perturbed-single=300 --salt HASH --lines LINES

The campaigns come from a simulator that shares no code with stepid (`tests/hidden`): event-located integration, an
encoder that rounds, noise from none to heavy, four to nine runs over steps up, back and the other way, free releases
and pulses. Their seeds are made from the hash of the commit that froze the code: nobody had seen them, each is run
once, and all are counted. *Perturbed* campaigns have what real labs have on top: starts, gains, damping and friction
that differ from run to run, colored noise, hum, wrong and dropped readings, eccentric encoders, further modes, creep
and hand holds. *Outside the catalogue* are 29 laws that stepid does not know: nothing is to be named. Two thirds of the
perturbations and of these laws were never looked at.

*r0* is the RMS residual of the best joint linear fit over the noise RMS: at 1 the effect is invisible. An answer is a
set: the effect named first, and those that the data cannot tell from it. *Told by no data*: fitted to noise-free data
made from the truth, the wrong name leaves Δχ² below 10. Where a count is
asked of more cases than were run, it is met where the share is. [Earlier runs](benchmark-history.md) and
[real plants](real-plants.md) have pages of their own.
"""


def markdown(lines: str, records: Sequence[Record], commit: str, plants: str = "", note: str = "") -> str:
    """The whole page: clean, perturbed and real side by side.

    Parameters
    ----------
    lines : str
        The table of lines, probabilities and kinds that are told.
    records : sequence of dict
        What was run.
    commit : str
        That the salt was the hash of.
    plants : str
        The documentation's page of real plants.
    note : str
        What is to be known of the run.
    """
    run = [r for r in records if "error" not in r]
    one = [r for r in run if r["set"] == "single-all" and r["r0"] >= 1.1]
    perturbed = [r for r in run if r["set"] == "perturbed-single" and r.get("qualified", True)]
    outside = [r for r in run if r["set"] in ("outside-all", "perturbed-outside")]
    parts = [
        HEAD,
        f"This run is of {commit}: {len(records):,} campaigns, {_sets(records)}. {note}",
        "## Lines",
        lines,
        "## One effect, r0 at least 1.1",
        _by(one, lambda r: r["truth"], {"campaigns": bool, "in the answer": in_set, "first": first_right}),
        "## One effect among the troubles of a lab, by kind of trouble",
        _by(
            perturbed,
            judge.kinds,
            {"campaigns": bool, "named": judge.named_right, "another name": judge.wrong_name},
        ),
        "## Outside the catalogue",
        _by(
            outside,
            _law,
            {"campaigns": bool, "wrong names": judge.wrong_name, "told by no data": judge.told_by_no_data},
        ),
        "## Real plants",
        _real(plants),
        "## Answers",
        _answers(run),
    ]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _sets(records: Iterable[Record]) -> str:
    counts = Counter(r["set"] for r in records)
    return ", ".join(f"{n:,} of {which}" for which, n in sorted(counts.items()))


def _law(r: Record) -> list[str]:
    """The law, by name only where it may be looked at while the diagnosis is developed."""
    return [r["outside"] if r["outside"] in SEEN_OUTSIDE else f"the {len(UNSEEN)} others"]


def _by(
    records: Iterable[Record], groups: Callable[[Record], Iterable[str]], columns: dict[str, Callable[[Record], object]]
) -> str:
    """A table of how many records of each group have each of some properties."""
    found = defaultdict(list)
    for r in records:
        for group in groups(r):
            found[group].append(r)
    rows = [f"| | {' | '.join(columns)} |", "|" + " --- |" * (len(columns) + 1)]
    for group, own in sorted(found.items()):
        counts = (sum(bool(has(r)) for r in own) for has in columns.values())
        rows.append(f"| {group.replace('_', ' ')} | {' | '.join(map(str, counts))} |")
    return "\n".join(rows)


def _real(plants: str) -> str:
    """Of the table of real plants what is known, what is answered and whether that is as asked."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in plants.splitlines() if line.startswith("|")]
    return "\n".join(f"| {row[0].partition(':')[0]} | {row[1]} | {row[2]} | {row[-1]} |" for row in rows)


def _answers(records: Iterable[Record]) -> str:
    """How many effects the answers of each set have, and how many answers they are."""
    found = defaultdict(list)
    for r in records:
        found[r["set"]].append(r)
    rows = ["| set | named | ambiguous | adequate | unexplained | answers in a set, mean |", "|" + " --- |" * 6]
    for which, own in sorted(found.items()):
        verdicts = Counter(r["verdict"] for r in own)
        named = [len(answers(r)) for r in own if r["effects"]]
        mean = f"{sum(named) / len(named):.2f}" if named else ""
        shown = " | ".join(str(verdicts[v]) for v in ("named", "ambiguous", "adequate", "unexplained"))
        rows.append(f"| {which} | {shown} | {mean} |")
    return "\n".join(rows)
