"""One plain record a campaign: what was hidden, what the diagnosis answered, and what nobody could tell apart."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

import score
import stepid
from stepid.effects import CATALOGUE, resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects

Case = tuple[str, stepid.Campaign, dict[str, Any]]
SEVERAL = ("pairs-all", "triples")


def diagnose_case(case: Case, *, twins: bool = True, without: Sequence[str] = ()) -> dict[str, Any]:
    """Truth, answer, gap, parameters, time; an error is an answer. Effects in `without` are no candidates."""
    which, campaign, truth = case
    record = hidden(which, campaign, truth)
    start, cpu = time.perf_counter(), time.process_time()
    try:
        if truth.get("refused"):
            raise ValueError(truth["refused"])
        d = stepid.diagnose(campaign, catalogue=tuple(e for e in CATALOGUE if e.name not in without))
    except Exception as error:  # the benchmark reports every failure, also those that nobody foresaw
        record |= {"seconds": time.process_time() - cpu, "waited": time.perf_counter() - start}
        return record | {"error": f"{type(error).__name__}: {error}"}
    # one thread: what it takes where nobody else computes
    record |= {"seconds": time.process_time() - cpu, "waited": time.perf_counter() - start, **answered(d)}
    if twins and record["truth"] and truth["r0"] >= 2 and not (score.first_right(record) and d.verdict == "named"):
        record["twins"] = find_twins(campaign, truth, record)
        record["inseparable"] = bool(record["twins"])
    if twins and record["outside"] and record["effects"]:  # whatever the name, it is wrong: how wrong
        record["outside_twins"] = find_twins(campaign, truth, record)
    if twins and which in SEVERAL:
        record["costs"] = leaving_out(campaign, truth)
    return record


def with_efforts(campaign: stepid.Campaign) -> dict[str, list[Any]]:
    """Verdict and names with half and with twice the effort."""
    out = {}
    for name, effort in (("quick", stepid.Effort.quick()), ("doubled", stepid.Effort().scaled(2))):
        d = stepid.diagnose(campaign, effort=effort)
        out[name] = [d.verdict, sorted(d.effects)]
    return out


def hidden(which: str, campaign: stepid.Campaign, truth: dict[str, Any]) -> dict[str, Any]:
    """What the simulator put into the campaign."""
    number = truth.get("number")
    plant = {"base_mass": truth.get("base_mass"), "force_gain": truth.get("force_gain")}
    for name in ("stiffness", "damping"):
        plant |= {f"{name}[{label}]": value for label, value in truth.get(name, {}).items()}
    return {
        "set": which,
        "name": campaign.name,
        "number": truth["seed"] if number is None else number,
        "seed": truth["seed"],
        "kind": truth["kind"],
        "runs": len(campaign.experiments),
        "truth": list(truth["effects"]),
        "outside": truth["outside"],
        "r0": truth["r0"],
        "noise": truth["noise_rms"],
        "variants": list(truth["variants"]),
        "true_parameters": truth["parameters"],
        "true_plant": {name: value for name, value in plant.items() if value is not None},
        **{k: truth[k] for k in ("perturbations", "r0_perturbation", "r0_kinds", "share", "qualified") if k in truth},
    }


def answered(d: Any) -> dict[str, Any]:
    """What the diagnosis says; None where this version of the package does not say it."""
    intervals = {name: getattr(e, "interval", None) for name, e in d.parameters.items()}
    scatter = getattr(d, "scatter", None) or {}
    return {
        "verdict": d.verdict,
        "effects": list(d.effects),
        "alternatives": [list(a) for a in d.alternatives],
        "before": d.gap.before,
        "after": d.gap.after,
        "told_noise": d.gap.noise,
        "held_out_after": d.gap.held_out_after,
        "parameters": {name: (e.value, e.uncertainty) for name, e in d.parameters.items()},
        "intervals": {name: list(ends) for name, ends in intervals.items() if ends is not None},
        "next_experiment": None if d.next_experiment is None else str(d.next_experiment),
        "probability": getattr(d, "probability", None),
        "explained": getattr(d, "explained", None),
        "left": getattr(d, "left", None),
        "cause": _words(getattr(d, "cause", None)),
        "causes": [list(getattr(c, "effects", ())) for c in getattr(d, "causes", None) or ()],
        "scatter": {
            name: {key: getattr(s, key, None) for key in ("deviation", "unit", "explained")}
            for name, s in scatter.items()
        },
        "faults": [
            {key: _words(getattr(f, key, None)) for key in ("run", "kind", "size", "unit", "words")}
            for f in getattr(d, "faults", None) or ()
        ],
        "notes": [str(note) for note in getattr(d, "notes", None) or ()],
    }


def _words(value: Any) -> Any:
    return value if value is None or isinstance(value, (int, float, str)) else str(value)


def exact(campaign: stepid.Campaign, truth: dict[str, Any]) -> stepid.Campaign | None:
    """The campaign without noise and perturbations; None where samples are missing."""
    if "exact" not in truth:
        return None
    pairs = list(zip(campaign.experiments, truth["exact"], strict=True))
    if any(e.time.size != len(x) for e, x in pairs):
        return None
    return stepid.Campaign(
        name=campaign.name,
        experiments=tuple(e.model_copy(update={"position": np.asarray(x), "counts_per_meter": None}) for e, x in pairs),
    )


def find_twins(campaign: stepid.Campaign, truth: dict[str, Any], record: dict[str, Any]) -> list[list[str]]:
    """Answers that, fitted to data made from the truth without noise, leave Δχ² < 10: nobody can tell them apart."""
    clean = exact(campaign, truth)
    if clean is None:
        return []
    twins = []
    for other in {tuple(record["effects"]), *map(tuple, record["alternatives"])}:
        if set(other) == set(truth["effects"]) or not other:
            continue
        left = _left(clean, other)
        if left is not None and _samples(clean) * left**2 / truth["noise_rms"] ** 2 < 10:
            twins.append(list(other))
    return twins


def leaving_out(campaign: stepid.Campaign, truth: dict[str, Any]) -> dict[str, float | None]:
    """RMS in floors that is left where one effect is left out and all others are fitted; 1 is nothing."""
    clean = exact(campaign, truth)
    costs: dict[str, float | None] = {}
    for name in truth["effects"]:
        left = None if clean is None else _left(clean, [other for other in truth["effects"] if other != name])
        costs[name] = None if left is None else float(np.hypot(left / truth["noise_rms"], 1.0))
    return costs


def _samples(campaign: stepid.Campaign) -> int:
    return sum(e.time.size for e in campaign.experiments)


def _left(campaign: stepid.Campaign, effects: Sequence[str]) -> float | None:
    try:
        fitted = fit_effects(prepare(campaign), resolve(effects))  # no intervals: on exact data they take long
    except Exception:  # what cannot be fitted is no twin, and loses no other case
        return None
    return None if fitted is None else float(fitted.rms)
