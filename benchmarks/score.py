"""Scores of diagnoses against the truth: every line that the diagnosis has to meet, from plain records."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

Record = dict[str, Any]


@dataclass
class Line:
    """One acceptance line: what was asked, what came out, of how many."""

    name: str
    asked: str
    value: float | None
    count: int
    met: bool | None
    failures: list[Record] = field(default_factory=list)

    def row(self) -> str:
        if self.value is None:
            return f"| {self.name} | {self.asked} | no case | 0 | |"
        shown = f"{100 * self.value:.1f} %" if "%" in self.asked else f"{self.value:.3g}"
        return f"| {self.name} | {self.asked} | {shown} | {self.count} | {'yes' if self.met else 'no'} |"


def answers(record: Record) -> list[frozenset[str]]:
    """The answered set: the first answer, then what the data cannot tell from it; adequate is the empty answer."""
    if record["verdict"] == "adequate":
        return [frozenset()]
    if record["verdict"] == "unexplained":
        return []
    return list(dict.fromkeys([frozenset(record["effects"]), *map(frozenset, record["alternatives"])]))


def truth(record: Record) -> frozenset[str]:
    return frozenset(record["truth"])


def in_set(record: Record) -> bool:
    return truth(record) in answers(record)


def first_right(record: Record) -> bool:
    found = answers(record)
    return bool(found) and found[0] == truth(record)


def right(record: Record) -> bool:
    """Named first, or one of several that fit data made from the truth as well (a twin)."""
    return first_right(record) or (in_set(record) and bool(record.get("inseparable")))


def one_unseen(record: Record) -> bool:
    """Of the hidden effects, a part alone explains data made from the truth without noise (a twin inside it)."""
    return any(set(twin) < truth(record) for twin in record.get("twins", []))


def visible(record: Record) -> bool:
    return bool(record["r0"] >= 2)


def share(
    name: str,
    asked: str,
    limit: float,
    records: Iterable[Record],
    good: Callable[[Record], bool],
    *,
    at_most: bool = False,
) -> Line:
    """Share of records that are good (or, at most, bad: then `good` says which count)."""
    some = list(records)
    if not some:
        return Line(name, asked, None, 0, None)
    hits = [r for r in some if good(r)]
    value = len(hits) / len(some)
    wrong = hits if at_most else [r for r in some if not good(r)]
    return Line(name, asked, value, len(some), value <= limit if at_most else value >= limit, wrong)


def mean(name: str, asked: str, limit: float, values: Sequence[float], *, middle: bool = False) -> Line:
    if not values:
        return Line(name, asked, None, 0, None)
    value = quantile(values, 0.5) if middle else sum(values) / len(values)
    return Line(name, asked, value, len(values), value <= limit)


def quantile(values: Sequence[float], q: float) -> float:
    ordered = sorted(values)
    at = q * (len(ordered) - 1)
    low = math.floor(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])


def parameter_errors(records: Iterable[Record]) -> list[tuple[str, float, float, Record]]:
    """(name, relative error, error over its uncertainty, record) of the effect's own parameters where it is named."""
    found = []
    for r in records:
        for name, true in r["true_parameters"].items():
            told = r["parameters"].get(name)
            if told is None or told[1] is None or not math.isfinite(told[1]) or told[1] <= 0:
                continue
            off = told[0] - true
            scale = abs(true)
            if name.endswith("phase"):  # an angle: the nearest turn, per radian
                off, scale = (off + math.pi) % (2 * math.pi) - math.pi, 1.0
            found.append((name, abs(off) / scale, off / told[1], r))
    return found


def score(records: Sequence[Record]) -> list[Line]:
    """Every acceptance line that the records can decide."""
    done = [r for r in records if "error" not in r]
    by = defaultdict(list)
    for r in done:
        by[r["set"]].append(r)
    single, none, pairs, outside = by["single"], by["none"], by["pairs"], by["outside"]
    clear = [r for r in single if visible(r)]
    separable = [r for r in clear if not r.get("inseparable")]
    band = [r for r in single if 1.1 <= r["r0"] < 2]
    faint = [r for r in single if r["r0"] < 1.05]
    both = [r for r in pairs if visible(r) and not one_unseen(r)]
    named = [r for r in done if r["verdict"] == "named" and r["set"] != "outside"]
    held = [r for r in named if r["held_out_after"] is not None]
    lines = [
        share("r0 ≥ 2: truth in the set", "100 %", 1.0, clear, in_set),
        share("r0 ≥ 2, separable: named first", "≥ 99 %", 0.99, separable, first_right),
        mean("r0 ≥ 2, separable: size of the set", "≤ 1.2", 1.2, [max(len(answers(r)), 1) for r in separable]),
        share("r0 1.1 to 2: truth in the set", "≥ 97 %", 0.97, band, in_set),
        share("r0 < 1.05: adequate or the truth", "≥ 97 %", 0.97, faint, faint_right),
        share("none: a name", "≤ 0.5 %", 0.005, none, misnamed, at_most=True),
        share("named: RMS after ≤ 1.1 × noise floor", "≥ 99 %", 0.99, named, lambda r: r["after"] <= 1.1 * r["noise"]),
        share(
            "held-out runs ≤ 1.2 × noise floor", "≥ 95 %", 0.95, held, lambda r: r["held_out_after"] <= 1.2 * r["noise"]
        ),
        share("pairs, r0 ≥ 2: both named", "≥ 93 %", 0.93, both, right),
        share("pairs, r0 ≥ 2: truth in the set", "≥ 93 %", 0.93, both, in_set),
        share("outside the catalogue: no wrong name", "≥ 97 %", 0.97, outside, lambda r: not misnamed(r)),
    ]
    errors = parameter_errors(r for r in clear if first_right(r))
    if errors:
        lines.append(mean("parameter error, median", "≤ 0.003", 0.003, [e[1] for e in errors], middle=True))
        inside = sum(abs(e[2]) <= 1.96 for e in errors) / len(errors)
        beyond = [e[3] | {"parameter": e[0], "z": e[2]} for e in errors if abs(e[2]) > 4]
        met = 0.92 <= inside <= 0.98
        lines.append(Line("95 % intervals cover", "92 to 98 %", inside, len(errors), met, beyond))
    nine = [r["seconds"] for r in clear if r["runs"] >= 9]
    lines.append(mean("one effect, nine runs: median CPU s", "≤ 0.7", 0.7, nine, middle=True))
    two = [r["seconds"] for r in pairs if visible(r)]
    lines.append(mean("two effects: median CPU s", "≤ 5", 5.0, two, middle=True))
    lines.append(share("ended in an error", "≤ 0 %", 0.0, records, lambda r: "error" in r, at_most=True))
    return lines


def faint_right(record: Record) -> bool:
    found = answers(record)
    return bool(found) and found[0] in (frozenset(), truth(record))


def misnamed(record: Record) -> bool:
    return record["verdict"] in ("named", "ambiguous") and bool(record["effects"])
