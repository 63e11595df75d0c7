"""How much of a made-up folder is understood: field by field, right, asked for or wrong."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lab_folders import INPUT, POSITION, TIME, Truth
from stepid.io.guess.answers import Answers, with_answers
from stepid.io.guess.draft import Draft
from stepid.io.guess.questions import open_questions
from stepid.io.guess.spoken import spoken
from stepid.io.guess.understand import draft_runs

UNITS = ("time unit", "position unit", "input unit")


def files_of(truths: Sequence[Truth], folder: Path) -> list[Path]:
    return [folder / name for name in dict.fromkeys(truth.file for truth in truths)]


def judge(truths: Sequence[Truth], folder: Path) -> tuple[Counter[str], list[str]]:
    """Count right, asked and wrong fields, and list those that are not right."""
    drafts = with_answers(draft_runs(files_of(truths, folder)), Answers())
    count: Counter[str] = Counter()
    trouble = []
    if any(question.key == "position" for question in open_questions(drafts)):  # what the columns are is asked first
        return Counter({"asked": 10 * len(truths)}), ["position asked"]
    if len(drafts) != len(truths):
        trouble.append(f"{len(drafts)} runs for {len(truths)}")
    for truth in truths:
        for field, state in fields(truth, drafts, folder).items():
            count[state] += 1
            if state != "right":
                trouble.append(f"{truth.file}: {field} {state}")
            if state == "wrong" and field in UNITS:
                count["wrong unit"] += 1
    return count, trouble


def fields(truth: Truth, drafts: Sequence[Draft], folder: Path) -> dict[str, str]:
    mine = [d for d in drafts if d.file.name == truth.file and same(d.readings.get("position"), truth.position)]
    names = "format encoding table time_column time_unit position_unit input_column input_unit mass spring"
    if len(mine) != 1:
        return dict.fromkeys(names.replace("_", " ").split(), "wrong")
    draft = mine[0]
    out = {"format": draft.format == truth.format, "encoding": draft.layout.get("encoding") == _encoding(truth, folder)}
    whole = all(np.all(values == np.rint(values)) for values in draft.readings.values())
    out["table"] = whole or draft.layout.get("decimal", ".") == truth.decimal  # without decimals either mark is right
    time = draft.readings.get("time")
    close = truth.format == "ecp" and time is not None and np.allclose(time, truth.time, atol=1e-3)
    out["time column"] = close or same(time, None if truth.sample_time else truth.time)
    out["input column"] = same(draft.readings.get("input"), truth.input)
    out["spring"] = draft.spring.value == (truth.spring or "spring")
    states = {field: "right" if ok else "wrong" for field, ok in out.items()}
    states["time unit"] = _time_unit(draft, truth)
    states["position unit"] = _scaled(draft, "position", None if draft.turn else POSITION[truth.position_unit])
    states["input unit"] = "asked" if truth.input is None else _scaled(draft, "input", INPUT[truth.input_unit])
    states["mass"] = _mass(draft, truth)
    return states


def same(found: np.ndarray | None, true: np.ndarray | None) -> bool:
    if found is None or true is None:
        return found is None and true is None
    return found.shape == true.shape and bool(np.allclose(found, true, rtol=1e-8, atol=1e-12))


def answers_of(key: str, truths: Sequence[Truth]) -> str:
    """What somebody who was there answers."""
    first = truths[0]
    return {
        "position_unit": first.position_unit,
        "counts_per_meter": f"{1 / first.scale:.12g}",
        "sample_time": f"{first.sample_time or 0:g}",
        "time_unit": first.time_unit,
        "input_unit": first.input_unit,
        "step": f"{first.level:g}",
        "motion": "rotation" if first.position_scale else "translation",
        "weight": "0.5",
        "added_mass": ",".join(f"{truth.real_mass:g}" for truth in truths),
    }[key]


def asked_by(truths: Sequence[Truth], folder: Path) -> list[str]:
    """What is asked of a folder; each answer closes its question."""
    drafts = draft_runs(files_of(truths, folder))
    said: dict[str, object] = {}
    keys = []
    while questions := open_questions(with_answers(drafts, Answers(**said))):  # type: ignore[arg-type]
        key = questions[0].key
        keys.append(key)
        if key == "position":
            drafts = draft_runs(files_of(truths, folder), {"position": "all"})
            continue
        said[key] = spoken(key, answers_of(key, truths))
        assert len(keys) < 9, keys
    return keys


def _encoding(truth: Truth, folder: Path) -> str | None:
    if truth.encoding in ("xlsx", "utf-8", "utf-8-sig"):
        return None
    if truth.encoding == "cp1252":
        try:
            (folder / truth.file).read_bytes().decode("utf-8")
        except UnicodeDecodeError:
            return "cp1252"
        return None
    return truth.encoding


def _time_unit(draft: Draft, truth: Truth) -> str:
    if truth.sample_time is None:
        return _scaled(draft, "time", TIME[truth.time_unit])
    if draft.sample_time is None:
        return "asked"
    return "right" if np.isclose(draft.sample_time.value, truth.sample_time) else "wrong"


def _scaled(draft: Draft, role: str, true: float | None) -> str:
    if true is None:
        unit = draft.units.get(role)
        return "wrong" if unit is not None and unit.value != "counts" else "asked"
    scale = draft.scale(role)
    if scale is None:
        return "wrong" if role in draft.units and draft.units[role].value == "counts" else "asked"
    return "right" if np.isclose(scale, true) else "wrong"


def _mass(draft: Draft, truth: Truth) -> str:
    if truth.mass is not None and draft.mass is not None:
        return "right" if np.isclose(draft.mass.value, truth.mass) else "wrong"
    if truth.weights is not None and (draft.weights is not None or draft.mass is not None):
        return "right" if draft.weights == truth.weights else "wrong"
    return "asked" if draft.mass is None and draft.weights is None else "wrong"
