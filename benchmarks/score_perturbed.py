"""Acceptance figures of clean and perturbed campaigns, from the lines of `benchmarks/diagnosis.py --lines FILE`.

python benchmarks/score_perturbed.py FILE [FILE ...] [--json OUT] [--failures] [--page docs/diagnosis-benchmark.md]
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent)]

import judge  # noqa: E402
from score import Line, Record, answers, first_right, in_set, mean, misnamed, quantile, share, visible  # noqa: E402

LEAST_COST = 1.3  # floors that leaving an effect out must cost
# an error counts as no answer, wherever one was asked for
SILENT: Record = {"verdict": "unexplained", "effects": [], "alternatives": [], "parameters": {}}
BINS = (0.0, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0)


def count(name: str, most: int, of: int, records: Sequence[Record], bad: Callable[[Record], bool]) -> Line:
    """How many records are bad, of how many; at most `most` of `of` are asked for, of fewer as large a part."""
    wrong = [r for r in records if bad(r)]
    met = len(wrong) <= most and len(wrong) * of <= most * len(records)
    return Line(name, f"≤ {most} of {of:,}", float(len(wrong)) if records else None, len(records), met, wrong)


def needed(record: Record) -> bool:
    """Whether leaving out any one of the hidden effects costs enough to be seen."""
    costs = record.get("costs", {}).values()
    return bool(costs) and all(c is not None and c >= LEAST_COST for c in costs)


def untold(what: str, records: Sequence[Record]) -> Line:
    """Of the wrong names those that fit data made from the truth, without noise, with Δχ² below 10."""
    wrong = [r for r in records if judge.wrong_name(r)]
    alike = sum(map(judge.told_by_no_data, wrong))
    return Line(f"{what}: of these, not told from the truth by any data", "–", float(alike), len(wrong), None)


def clean(by: dict[str, list[Record]]) -> list[Line]:
    single, none = by["single-all"] + by["single"] + by["new"], by["none"]
    clear = [r for r in single if visible(r)]
    separable = [r for r in clear if not r.get("inseparable")]
    band = [r for r in single if 1.1 <= r["r0"] < 2]
    pairs = [r for r in by["pairs-all"] if needed(r)]
    triples = [r for r in by["triples"] if needed(r)]
    outside = [r for name in ("outside", "outside-all", "outside-seen", "outside-new") for r in by[name]]

    def lost(r: Record) -> bool:
        return not (in_set(r) or judge.is_twin(r))

    return [
        count("single, r0 ≥ 2: truth not in the answer", 1, 236, clear, lost),
        share("single, r0 ≥ 2, separable: named first", "≥ 99 %", 0.99, separable, first_right),
        mean("single, r0 ≥ 2, separable: set size", "≤ 1.15", 1.15, [max(len(answers(r)), 1) for r in separable]),
        share("single, r0 1.1 to 2: truth not in it", "≤ 3 %", 0.03, band, lost, at_most=True),
        count("none: named", 5, 1000, none, misnamed),
        share("pairs that need both: both named", "≥ 95 %", 0.95, pairs, judge.right_or_twin),
        share("triples that need all: all named", "≥ 80 %", 0.8, triples, judge.right_or_twin),
        count("outside the catalogue: wrong names", 6, 300, outside, judge.wrong_name),
        untold("outside the catalogue", outside),
    ]


def perturbed(by: dict[str, list[Record]], seen: str) -> list[Line]:
    """The same for one group of perturbed sets: "" is all kinds, "-seen" those that may be looked at."""
    none, outside = by[f"perturbed-none{seen}"], by[f"perturbed-outside{seen}"]
    single = [r for r in by[f"perturbed-single{seen}"] if r.get("qualified", True)]
    tellable = [r | {"kind told": k} for r in none for k in judge.mattering(r)]
    words = seen.replace("-", ", ")
    lines = [
        count(f"perturbed{words}, linear: wrong names", 6, 300, none, judge.wrong_name),
        share(f"perturbed{words}, r0 ≥ 2: kind told", "≥ 80 %", 0.8, tellable, lambda r: judge.told(r, r["kind told"])),
        share(f"perturbed{words}, one effect: named", "≥ 90 %", 0.9, single, judge.named_right),
        share(f"perturbed{words}, one effect: other name", "≤ 2 %", 0.02, single, judge.wrong_name, at_most=True),
        count(f"perturbed{words}, outside: wrong names", 8, 200, outside, judge.wrong_name),
        untold(f"perturbed{words}, outside", outside),
    ]
    return [x for x in lines if x.count]


def coverage(name: str, low: float, high: float, records: Iterable[Record]) -> list[Line]:
    found = judge.intervals(records)
    if not found:
        return []
    inside = sum(f[1] for f in found) / len(found)
    asked = f"{100 * low:.0f} to {100 * high:.0f} %"
    middle = quantile([f[2] for f in found], 0.5)
    fine = 0.4 <= middle <= 1.0 if "perturbed" in name else None
    return [
        Line(f"{name}: 95 % intervals cover", asked, inside, len(found), low <= inside <= high),
        Line(f"{name}: median |error|/σ", "0.4 to 1" if fine is not None else "–", middle, len(found), fine),
    ]


def times(records: Sequence[Record]) -> list[Line]:
    by = defaultdict(list)
    for r in records:
        group = "hard" if r["set"].startswith(("outside", "perturbed")) else r["set"]
        by["single" if group in ("single-all", "new") else group].append(r)
    nine = [r["seconds"] for r in by["single"] if r["runs"] >= 9]
    two, hard = [r["seconds"] for r in by["pairs-all"] + by["pairs"]], [r["seconds"] for r in by["hard"]]
    lines = [
        mean("none: median CPU s", "≤ 0.1", 0.1, [r["seconds"] for r in by["none"]], middle=True),
        mean("one effect, nine runs: median CPU s", "≤ 0.4", 0.4, nine, middle=True),
        mean("two effects: median CPU s", "≤ 1.5", 1.5, two, middle=True),
        mean("outside or perturbed: median CPU s", "≤ 5", 5.0, hard, middle=True),
    ]
    if hard:
        most = quantile(hard, 0.9)
        lines.append(Line("outside or perturbed: 90 % CPU s", "≤ 15", most, len(hard), most <= 15))
    return lines


def efforts(records: Sequence[Record]) -> list[Line]:
    """Answers that another effort changes."""
    some = [r for r in records if "efforts" in r]

    def changed(name: str) -> Callable[[Record], bool]:
        return lambda r: r["efforts"][name] != [r["verdict"], sorted(r["effects"])]

    return [
        count("twice the effort: another answer", 3, 534, some, changed("doubled")),
        share("quick: another answer", "≤ 4 %", 0.04, some, changed("quick"), at_most=True),
    ]


def calibration(records: Iterable[Record]) -> list[dict[str, float | bool | None]]:
    """Bins of `probability`: how many answers, their mean, the share that is right, and whether that is near enough."""
    given = [r for r in records if r.get("probability") is not None and misnamed(r)]
    rows = []
    for low, high in pairwise(BINS):
        some = [r for r in given if low <= r["probability"] < high or (high == 1.0 and r["probability"] == 1.0)]
        if not some:
            continue
        n, told = len(some), sum(r["probability"] for r in some) / len(some)
        right = sum(map(judge.right, some)) / n
        margin = 0.05 + 2 * math.sqrt(max(told * (1 - told), 0.0) / n)
        met = abs(right - told) <= margin if n >= 50 else None
        rows.append({"low": low, "high": high, "count": n, "told": told, "right": right, "margin": margin, "met": met})
    return rows


def score(records: Sequence[Record]) -> list[Line]:
    """Every figure that the records can give."""
    done, by = [SILENT | r if "error" in r else r for r in records], defaultdict(list)
    for r in done:
        by[r["set"]].append(r)
    lines = [*clean(by), *perturbed(by, ""), *perturbed(by, "-seen")]
    fine = [r for r in done if "perturbations" not in r and r["truth"] and first_right(r)]
    rough = [r for r in done if "perturbations" in r and r["truth"] and misnamed(r) and judge.acceptable(r)]
    lines += [*coverage("clean", 0.92, 0.98, fine), *coverage("perturbed", 0.88, 0.99, rough), *times(done)]
    lines += efforts(done)
    lines.append(share("ended in an error", "≤ 0 %", 0.0, records, lambda r: "error" in r, at_most=True))
    return [x for x in lines if x.value is not None]


def kinds_told(records: Iterable[Record]) -> str:
    """By kind of perturbation of a linear plant: how often it matters, is told, is named by its twin; wrong names."""
    rows = ["| kind | campaigns | r0 ≥ 2 | told | told or its twin named | wrong names |", "|" + " --- |" * 6]
    some = [SILENT | r for r in records if r["set"].startswith("perturbed-none")]
    for kind in judge.WORDS:
        own = [r for r in some if kind in judge.kinds(r)]
        deep = [r for r in own if kind in judge.mattering(r)]
        if own:
            hits = (sum(judge.told(r, kind) for r in deep), sum(judge.told_or_named(r, kind) for r in deep))
            wrong = sum(map(judge.wrong_name, own))
            rows.append(f"| {kind} | {len(own)} | {len(deep)} | {hits[0]} | {hits[1]} | {wrong} |")
    return "\n".join(rows) if len(rows) > 2 else ""


def report(records: Sequence[Record], *, failures: bool = False) -> str:
    lines = score(records)
    parts = ["| | asked | reached | cases | met |\n| --- | --- | --- | --- | --- |", *(_row(x) for x in lines)]
    bins = calibration(r for r in records if "error" not in r)
    if bins:
        parts += ["", "| probability | answers | mean | right | within | met |", "|" + " --- |" * 6]
        parts += [
            f"| {b['low']} to {b['high']} | {b['count']} | {b['told']:.3f} | {b['right']:.3f} | ±{b['margin']:.3f} | "
            f"{'' if b['met'] is None else 'yes' if b['met'] else 'no'} |"
            for b in bins
        ]
    parts += ["", kinds_told(records)]
    apart = sum(r["set"].startswith("perturbed-single") and not r.get("qualified", True) for r in records)
    parts.append(f"\nPerturbed single campaigns whose effect takes less than half, counted apart: {apart}.")
    if failures:
        parts += ["", *(_failure(x.name, r) for x in lines for r in x.failures)]
    return "\n".join(parts)


def _row(line: Line) -> str:
    value = line.value or 0.0
    shown = f"{100 * value:.1f} %" if "%" in line.asked else f"{value:.3g}"
    met = "" if line.met is None else "yes" if line.met else "no"
    return f"| {line.name} | {line.asked} | {shown} | {line.count} | {met} |"


def _failure(name: str, r: Record) -> str:
    said = r.get("error") or f"{r['verdict']} {r['effects']} or {r['alternatives']}"
    hidden = "+".join([*r["truth"], *filter(None, [r["outside"]]), *judge.kinds(r)]) or "nothing"
    return f"{name}: {r['set']} {r['number']} ({r['kind']}, r0 {r['r0']:.2f}) {hidden} -> {said}"


def main() -> None:
    from one_by_one import read

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--json", type=Path, help="write the figures here")
    parser.add_argument("--failures", action="store_true", help="list every case that missed a line")
    parser.add_argument("--page", type=Path, help="write the documentation's page here")
    parser.add_argument("--commit", default="the salt's commit", help="that froze the code, for the page")
    parser.add_argument("--note", default="", help="what is to be known of the run, for the page")
    args = parser.parse_args()
    records = [r for file in args.files for r in read(file)]
    print(report(records, failures=args.failures))
    if args.page:
        from page import markdown

        plants = (Path(__file__).parents[1] / "docs" / "real-plants.md").read_text(encoding="utf-8")
        args.page.write_text(markdown(report(records), records, args.commit, plants, args.note), encoding="utf-8")
    if args.json:
        figures = [
            {"name": x.name, "asked": x.asked, "value": x.value, "count": x.count, "met": x.met} for x in score(records)
        ]
        args.json.write_text(json.dumps({"lines": figures, "bins": calibration(records)}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
