"""What the standing campaigns reach, as text: the table of lines, times, bands of r0, parameters, failures."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

from score import Line, Record, answers, first_right, in_set, parameter_errors, quantile, visible


def report(lines: Sequence[Line], records: Sequence[Record]) -> str:
    """Scores, times and bands as Markdown tables."""
    table = ["| | asked | reached | cases | met |", "| --- | --- | --- | --- | --- |", *(x.row() for x in lines)]
    return "\n".join([*table, "", _times(records), "", _bands(records), "", _parameters(records)])


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
