"""The benchmark's text: the table of lines, times, confusion, failures, and the Markdown page."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

from score import Line, Record, answers, confusion, first_right, in_set, one_unseen, parameter_errors, quantile, visible

HEAD = """# Does the diagnosis name the right effect?

Rebuilt by one command: `python benchmarks/diagnosis.py --page docs/diagnosis-benchmark.md`.

The campaigns come from a simulator that shares no code with stepid (`tests/hidden`): event-located integration, an
encoder that rounds, noise from none to heavy, four to nine runs over steps up, back and the other way, free releases
and pulses. *r0* is the RMS residual of the best joint linear fit over the noise RMS: at 1 the effect is invisible. An
answer is a set: the effect named first, and those that the data cannot tell from it. Inseparable: a twin, fitted to
noise-free data made from the truth, leaves Δχ² < 10. The floor in every ratio is the true noise.
Pairs before number 460 were developed against, as were some of the others: `--skip` draws fresh ones.
"""


def report(lines: Sequence[Line], records: Sequence[Record]) -> str:
    """Scores, times and bands as Markdown tables."""
    table = ["| | asked | reached | cases | met |", "| --- | --- | --- | --- | --- |", *(x.row() for x in lines)]
    return "\n".join([*table, "", _times(records), "", _bands(records), "", _parameters(records)])


def _sets(records: Sequence[Record]) -> str:
    """Which campaigns of each set were diagnosed."""
    rows = ["| set | campaigns | numbers |", "| --- | --- | --- |"]
    groups = defaultdict(list)
    for r in records:
        groups[r["set"]].append(r["number"])
    for which, numbers in groups.items():
        rows.append(f"| {which} | {len(numbers)} | {min(numbers)} to {max(numbers)} |")
    return "\n".join(rows)


def _times(records: Sequence[Record]) -> str:
    groups = defaultdict(list)
    for r in records:
        groups[(r["set"], r["runs"])].append(r["seconds"])
    rows = [
        "| CPU time on one core | runs | median s | 90 % s | slowest s | cases |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for (which, runs), s in sorted(groups.items()):
        rows.append(f"| {which} | {runs} | {quantile(s, 0.5):.2f} | {quantile(s, 0.9):.2f} | {max(s):.2f} | {len(s)} |")
    return "\n".join(rows)


def _bands(records: Sequence[Record]) -> str:
    rows = ["| one effect, r0 | in the set | first | set size | cases |", "| --- | --- | --- | --- | --- |"]
    edges = (0.0, 1.05, 1.1, 2.0, 5.0, 20.0, 100.0, float("inf"))
    single = [r for r in records if r["set"] == "single" and "error" not in r]
    for low, high in pairwise(edges):
        some = [r for r in single if low <= r["r0"] < high]
        if some:
            n = len(some)
            hits, first = sum(map(in_set, some)), sum(map(first_right, some))
            size = sum(len(answers(r)) for r in some) / n
            rows.append(
                f"| {low:g} to {high:g} | {100 * hits / n:.1f} % | {100 * first / n:.1f} % | {size:.2f} | {n} |"
            )
    return "\n".join(rows)


def _parameters(records: Sequence[Record]) -> str:
    rows = ["| parameter | median error | within 95 % | cases |", "| --- | --- | --- | --- |"]
    groups = defaultdict(list)
    for name, off, z, _ in parameter_errors(r for r in records if "error" not in r and visible(r) and first_right(r)):
        groups[name].append((off, abs(z) <= 1.96))
    for name, found in sorted(groups.items()):
        middle, inside = quantile([f[0] for f in found], 0.5), sum(f[1] for f in found) / len(found)
        rows.append(f"| {name} | {100 * middle:.2g} % | {100 * inside:.0f} % | {len(found)} |")
    return "\n".join(rows)


def failures(lines: Sequence[Line]) -> str:
    """Each failed case with what it takes to make it again."""
    rows = []
    for line in lines:
        for r in line.failures:
            told = r.get("error") or f"{r['verdict']} {r['effects']} or {r['alternatives']}"
            ratio = "" if "after" not in r else f", after/floor {r['after'] / r['noise']:.3f}"
            odd = f" {r['variants']}" if r["variants"] else ""
            more = f" {r['parameter']} z {r['z']:.1f}" if "z" in r else ""
            case = f"{r['set']} {r['number']} ({r['kind']}, r0 {r['r0']:.2f}{odd})"
            rows.append(f"  {line.name}: {case} {r['truth'] or r['outside'] or 'nothing'} -> {told}{ratio}{more}")
    return "\n".join(["failures:", *rows]) if rows else "no failures"


def markdown(lines: Sequence[Line], records: Sequence[Record]) -> str:
    """The page for the documentation."""
    clear = [r for r in records if r["set"] == "single" and visible(r)]
    parts = [
        HEAD,
        _sets(records),
        "",
        "## Lines",
        "",
        report(lines, records),
        "",
        "## Confusion, one effect, r0 at least 2",
        "",
        _grid(clear),
    ]
    rest = [r for r in records if r["set"] in ("none", "outside")]
    parts += ["", "## What is not in the catalogue, and nothing at all", "", _grid(rest)]
    two = [r for r in records if r["set"] == "pairs" and visible(r)]
    apart = [f"{r['set']} {r['number']}" for r in two if one_unseen(r)]
    said = (
        "Pairs of which a part alone explains data without noise, counted apart: " + (", ".join(apart) or "none") + "."
    )
    parts += [
        "",
        "## Two effects, r0 at least 2",
        "",
        said,
        "",
        _grid([r for r in two if not one_unseen(r)]),
        "",
        "## Every case that missed a line",
        "",
    ]
    return "\n".join([*parts, "```text", failures(lines), "```", ""])


def _grid(records: Sequence[Record]) -> str:
    rows = ["| hidden | right first | in the set | answered first otherwise |", "| --- | --- | --- | --- |"]
    groups = defaultdict(list)
    for r in records:
        groups[" + ".join(sorted(r["truth"])) or r["outside"] or "none"].append(r)
    told = confusion(records)
    for name, some in sorted(groups.items()):
        fine = [r for r in some if "error" not in r]
        other = {k: v for k, v in told[name].items() if k != name}
        listed = ", ".join(f"{k} ({v})" for k, v in sorted(other.items(), key=lambda item: -item[1]))
        first, hits = sum(map(first_right, fine)), sum(map(in_set, fine))
        known = bool(some[0]["truth"]) or name == "none"
        shown = f"{first} of {len(some)} | {hits} of {len(some)}" if known else "– | –"
        rows.append(f"| {name} | {shown} | {listed} |")
    return "\n".join(rows)
