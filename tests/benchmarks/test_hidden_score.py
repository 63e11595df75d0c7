"""The benchmark's scores on answers made by hand: each line counts what it says."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
if not BENCHMARKS.exists():
    pytest.skip("the benchmarks are not beside the tests", allow_module_level=True)
sys.path.append(str(BENCHMARKS))

import score  # noqa: E402
from practice import canonical  # noqa: E402


def record(**changes: Any) -> dict[str, Any]:
    plain = {
        "set": "single",
        "number": 1,
        "runs": 9,
        "truth": ["coulomb_friction"],
        "outside": None,
        "r0": 5.0,
        "noise": 1.0,
        "verdict": "named",
        "effects": ["coulomb_friction"],
        "alternatives": [],
        "after": 1.02,
        "held_out_after": 1.1,
        "seconds": 0.5,
        "parameters": {"coulomb_friction.level": (0.301, 0.001)},
        "true_parameters": {"coulomb_friction.level": 0.3},
    }
    return plain | changes


def line(records: list[dict[str, Any]], name: str) -> score.Line:
    return next(x for x in score.score(records) if x.name == name)


def test_an_ambiguous_answer_with_the_truth_in_it_is_in_the_set_but_not_first() -> None:
    answer = record(verdict="ambiguous", effects=["stribeck_friction"], alternatives=[["coulomb_friction"]])
    assert line([answer], "r0 ≥ 2: truth in the set").value == 1.0
    assert line([answer], "r0 ≥ 2, separable: named first").value == 0.0
    assert line([answer], "r0 ≥ 2, separable: size of the set").value == 2.0
    told_apart_by_nobody = answer | {"inseparable": True}
    assert line([told_apart_by_nobody], "r0 ≥ 2, separable: named first").value is None
    assert score.right(told_apart_by_nobody)
    assert not score.right(answer)


def test_a_pair_counts_where_both_can_be_seen() -> None:
    pair = record(set="pairs", truth=["coulomb_friction", "end_stop"], effects=["end_stop"])
    assert line([pair], "pairs, r0 ≥ 2: both named").value == 0.0
    hidden = pair | {"twins": [["end_stop"]], "inseparable": True}
    assert line([hidden], "pairs, r0 ≥ 2: both named").value is None
    foreign = pair | {"effects": ["cogging"], "twins": [["cogging"]], "inseparable": True}
    assert line([foreign], "pairs, r0 ≥ 2: both named").value == 0.0


def test_faint_effects_and_none() -> None:
    wrong = record(r0=1.02, effects=["cogging"])
    quiet = record(r0=1.02, verdict="adequate", effects=[])
    assert line([wrong, quiet], "r0 < 1.05: adequate or the truth").value == 0.5
    none = record(set="none", truth=[], verdict="adequate", effects=[], true_parameters={})
    false = none | {"verdict": "named", "effects": ["sensor_drift"]}
    told = line([none, none, none, false], "none: a name")
    assert told.value == 0.25
    assert not told.met
    assert told.failures == [false]


def test_unexplained_is_right_outside_the_catalogue_and_wrong_inside() -> None:
    bump = record(set="outside", truth=[], outside="bump", verdict="unexplained", effects=[], true_parameters={})
    assert line([bump], "outside the catalogue: no wrong name").value == 1.0
    named = bump | {"verdict": "named", "effects": ["cogging"]}
    assert line([named], "outside the catalogue: no wrong name").value == 0.0
    assert line([record(verdict="unexplained", effects=[])], "r0 ≥ 2: truth in the set").value == 0.0


def test_gaps_parameters_and_errors() -> None:
    fine, poor = record(), record(after=1.2, held_out_after=1.3, parameters={"coulomb_friction.level": (0.33, 0.001)})
    assert line([fine, poor], "named: RMS after ≤ 1.1 × noise floor").value == 0.5
    assert line([fine, poor], "held-out runs ≤ 1.2 × noise floor").value == 0.5
    assert line([fine, poor], "95 % intervals cover").value == 0.5
    assert line([fine], "parameter error, median").value == pytest.approx(1 / 300)
    assert line([fine, record(error="ValueError")], "ended in an error").value == 0.5
    angle = record(true_parameters={"cogging.phase": 0.1}, parameters={"cogging.phase": (0.1 + 6.28, 0.01)})
    assert score.parameter_errors([angle])[0][1] == pytest.approx(0.0032, abs=1e-4)


def test_short_names_of_the_practice_answers() -> None:
    assert canonical(["asymmetric_friction"], {"Fc": 0.1, "Fcm": 0.05}) == {
        "asymmetric_friction.level_backward": 0.1,
        "asymmetric_friction.level_forward": pytest.approx(0.15),
    }
    assert canonical(["presliding_hysteresis"], {"kb": 1000.0, "alpha": 2e-4}) == {
        "presliding_hysteresis.distance": 2e-4,
        "presliding_hysteresis.level": pytest.approx(0.2),
    }
