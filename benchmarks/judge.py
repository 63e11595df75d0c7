"""Whether an answer to a clean or a perturbed campaign is right, wrong or silent, and whether it tells what differs."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterable
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "tests")]

from hidden.perturb import TWINS  # noqa: E402
from score import Record, answers, first_right, in_set, misnamed, truth  # noqa: E402

# what in scatter, faults or notes tells a kind: a key of d.scatter, or words
SCATTER = ("start_time", "gain", "rest", "damping", "friction")
LEAST_PART = 0.01  # of the misfit's power, below which an entry of d.scatter tells nothing
DIFFER = re.compile(r"differ|scatter|run to run|between runs|in each run|run by run", re.IGNORECASE)
WORDS = {
    "start_time": r"start(s|ed|ing)? (time|late|early)|begin(s|ning)? (late|early)|delay",
    "gain": r"gain|force (constant|differs)|scale",
    "damping": r"damp",
    "friction": r"friction",
    "rest": r"rest(s|ing)? (position|place|move|differ|change)|rest is unexplained|offset",
    "ar1": r"correlat|colou?red|not white|autoregress",
    "hum": r"\bhum\b|mains|50 Hz|60 Hz|line frequency|periodic|spectral line",
    "pink": r"correlat|colou?red|not white|1/f|wander|slow noise",
    "outliers": r"outlier|spike|wrong sample|isolated|bad sample|glitch",
    "dropped": r"dropped|missing|lost sample|uneven|\bgaps?\b|repeated sample|repeats",
    "eccentricity": r"eccentric|encoder|periodic in position|scale of the sensor",
    "second_mode": r"second mode|further mode|\bmodes?\b|resonan",
    "creep": r"creep|relax|rest (moves|drifts)|drift",
    "hold_short": r"\bheld\b|\bholds?\b|let go|before (its|the) release",
    "hold_long": r"\bheld\b|\bholds?\b|let go|before (its|the) release",
}


def kinds(record: Record) -> tuple[str, ...]:
    return tuple(record.get("perturbations", ()))


def own_twins(record: Record) -> frozenset[str]:
    """Effects of the catalogue that are what the campaign was perturbed by."""
    return frozenset(TWINS[k] for k in kinds(record) if k in TWINS)


def acceptable(record: Record) -> bool:
    """Whether the answered set holds the truth, with or without a perturbation's own twin."""
    hidden, twins = truth(record), own_twins(record)
    return any(hidden <= a and a - hidden <= twins for a in answers(record))


def named_right(record: Record) -> bool:
    """The one true effect is in an answer that is not only a lead, and nothing foreign is in it."""
    return misnamed(record) and (acceptable(record) or is_twin(record))


def is_twin(record: Record) -> bool:
    """The first answer fits data made from the truth with Δχ² < 10."""
    found = answers(record)
    return bool(found) and any(set(t) == found[0] for t in record.get("twins", ()))


def right_or_twin(record: Record) -> bool:
    return first_right(record) or is_twin(record) or (in_set(record) and bool(record.get("inseparable")))


def wrong_name(record: Record) -> bool:
    """Something is named, and it is neither the truth nor a perturbation's own twin."""
    if not misnamed(record) or is_twin(record):
        return False
    hidden = frozenset() if record.get("outside") else truth(record)
    foreign = frozenset(record["effects"]) - hidden - own_twins(record)
    return bool(foreign) and (not hidden or not acceptable(record))


def told_by_no_data(record: Record) -> bool:
    """A wrong name that fits data made from the truth, without noise, with Δχ² below 10."""
    return wrong_name(record) and record["effects"] in record.get("outside_twins", [])


def right(record: Record) -> bool:
    """What `probability` speaks of: the answered set holds the truth."""
    if record.get("outside"):
        return not wrong_name(record)
    return acceptable(record) or is_twin(record)


def told(record: Record, kind: str) -> bool:
    """Whether scatter, faults or notes tell one kind of perturbation."""
    scatter, word = record.get("scatter", {}).get(kind), re.compile(WORDS[kind], re.IGNORECASE)
    if scatter is not None and (scatter.get("explained") is None or scatter["explained"] > LEAST_PART):
        return True
    faults = [" ".join(str(v) for v in fault.values() if v is not None) for fault in record.get("faults", ())]
    if any(word.search(text) for text in faults):
        return True
    # a note on gain or damping may speak of anything: it must speak of runs that differ
    notes = [n for n in record.get("notes", ()) if kind not in SCATTER or DIFFER.search(n)]
    return any(word.search(text) for text in notes)


def told_or_named(record: Record, kind: str) -> bool:
    return told(record, kind) or TWINS.get(kind) in record.get("effects", ())


def mattering(record: Record, least: float = 2.0) -> list[str]:
    """Kinds that cost the true model `least` floors each, alone."""
    return [k for k, r0 in record.get("r0_kinds", {}).items() if r0 >= least]


def intervals(records: Iterable[Record]) -> list[tuple[str, bool, float]]:
    """(name, whether the 95 % interval holds it, |error| over its standard uncertainty) of plant and effect."""
    found = []
    for r in records:
        for name, true in (r.get("true_plant", {}) | r["true_parameters"]).items():
            value, sigma = r["parameters"].get(name) or (None, None)
            if name == "force_gain" or name.endswith("phase") or sigma is None or not 0 < sigma < math.inf:
                continue
            low, high = r.get("intervals", {}).get(name) or (value - 1.96 * sigma, value + 1.96 * sigma)
            found.append((name, low <= true <= high, abs(value - true) / sigma))
    return found
