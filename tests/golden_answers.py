"""Answers of `stepid.fit` and `stepid.diagnose` on standing hidden campaigns. ``python tests/golden_answers.py`` writes
them again and prints what changed; ``python tests/golden_answers.py none "pairs 8"`` does so for those only.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import stepid
from counting import counting
from hidden.sets import one

FILE = Path(__file__).parent / "golden" / "answers.json"
QUICK = (
    *(("none", n) for n in (0, 1, 2, 3)),
    *(("single", n) for n in (1, 5, 6, 8, 11, 12, 13, 14, 15, 17, 19, 29, 33)),
)
SLOW = (("pairs", 8), ("pairs", 18), ("outside", 0))  # their diagnoses take long
FIT = (("pairs", 18),)  # of these the fit alone does not
CLOSE = 1e-3  # relative, of a parameter; or a third of its uncertainty
CLOSE_RMS = 5e-3
FEW = 10  # fits that a search may try more where rounding decides a tie
GROWTH = 1.1  # of the counts
Answer = dict[str, Any]


def name(which: str, number: int) -> str:
    return f"{which} {number}"


def diagnosed(campaign: stepid.Campaign) -> dict[str, Any]:
    with counting() as counts:
        said = stepid.diagnose(campaign)
    return {
        "verdict": said.verdict,
        "effects": list(said.effects),
        "alternatives": [list(names) for names in said.alternatives],
        "rms before": said.gap.before,
        "rms after": said.gap.after,
        "parameters": _values(said.parameters),
        "samples": counts.samples,
        "fits": counts.fits,
    }


def fitted(campaign: stepid.Campaign, effects: tuple[str, ...]) -> dict[str, Any]:
    with counting() as counts:
        found = stepid.fit(campaign, effects=effects)
    return {
        "effects": list(effects),
        "rms": found.rms,
        "parameters": _values(found.parameters),
        "samples": counts.samples,
        "fits": counts.fits,
    }


EXACT = {"weight_uncertainty": 1e-9}  # kg: the hidden campaigns' weights are what they say


def answer(which: str, number: int) -> Answer:
    """What the present code says of a campaign, and what it took."""
    campaign, truth = one(which, number)
    campaign = campaign.model_copy(update=EXACT)
    out: Answer = {"diagnose": diagnosed(campaign)}
    if which != "outside":  # nothing in the catalogue is true there
        out["fit"] = fitted(campaign, truth["effects"])
    return out


def _values(parameters: Mapping[str, stepid.Estimate]) -> dict[str, list[float | None]]:
    return {key: [_short(e.value), _short(e.uncertainty)] for key, e in parameters.items()}


def _short(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.7g}")


@cache
def committed() -> dict[str, Answer]:
    found: dict[str, Answer] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def flat(answer: Answer) -> dict[str, Any]:
    """Each thing by the words that tell it."""
    out = {}
    for call, said in answer.items():
        for what, value in said.items():
            parts = value.items() if what == "parameters" else ()
            out |= {f"{call}: {key}": part for key, part in parts} or {f"{call}: {what}": value}
    return out


def differences(before: Answer, after: Answer) -> Iterator[tuple[str, Any, Any]]:
    """What differs between two answers by more than the tolerances, and counts that grew."""
    one, two = flat(before), flat(after)
    for what in dict.fromkeys((*one, *two)):
        old, new = one.get(what), two.get(what)
        if not _agree(what.partition(": ")[2], old, new):
            yield what, old, new


def _agree(what: str, old: Any, new: Any) -> bool:
    if old is None or new is None or what in ("verdict", "effects", "alternatives"):
        return bool(old == new)
    if what in ("samples", "fits"):
        return bool(new <= GROWTH * old + (FEW if what == "fits" else 0))
    if what.startswith("rms"):
        return bool(abs(new - old) <= CLOSE_RMS * old)
    value, spread = old
    return bool(abs(new[0] - value) <= max(CLOSE * abs(value), (spread or 0.0) / 3))


def table(rows: list[tuple[str, str, Any, Any]]) -> str:
    cells = [("campaign", "what", "before", "after"), *(tuple(map(str, row)) for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(4)]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in cells)


def main(only: list[str]) -> None:
    before = committed() if FILE.exists() else {}
    after, rows = {}, []
    for which, number in (*QUICK, *SLOW):
        key = name(which, number)
        if only and which not in only and key not in only:
            after |= {key: before[key]} if key in before else {}
            continue
        after[key] = answer(which, number)
        old, new = flat(before.get(key, {})), flat(after[key])
        rows += [(key, w, old.get(w), new.get(w)) for w in dict.fromkeys((*old, *new)) if old.get(w) != new.get(w)]
    for call in ("samples", "fits"):
        total = [sum(said.get(call, 0) for a in some.values() for said in a.values()) for some in (before, after)]
        rows.append(("all", call, *total))
    FILE.write_text(_text(after), encoding="utf-8")
    print(table(rows))


def _text(answers: dict[str, Answer]) -> str:
    """JSON with a line for each thing."""
    calls = []
    for key, found in answers.items():
        lines = []
        for call, said in found.items():
            own = ",\n".join(f"   {json.dumps(w)}: {json.dumps(v, ensure_ascii=False)}" for w, v in said.items())
            lines.append(f"  {json.dumps(call)}: {{\n{own}\n  }}")
        calls.append(f" {json.dumps(key)}: {{\n" + ",\n".join(lines) + "\n }")
    return "{\n" + ",\n".join(calls) + "\n}\n"


if __name__ == "__main__":
    main(sys.argv[1:])
