"""The figures of perturbed campaigns on answers made by hand, and runs that are taken up again."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
if not BENCHMARKS.exists():
    pytest.skip("the benchmarks are not beside the tests", allow_module_level=True)
sys.path.append(str(BENCHMARKS))

import judge  # noqa: E402
import one_by_one  # noqa: E402
import page  # noqa: E402
import score_perturbed  # noqa: E402


def record(**changed: Any) -> dict[str, Any]:
    plain = {
        "set": "perturbed-none",
        "number": 1,
        "kind": "five",
        "runs": 5,
        "truth": [],
        "outside": None,
        "r0": 3.0,
        "verdict": "adequate",
        "effects": [],
        "alternatives": [],
        "seconds": 0.5,
        "parameters": {},
        "true_parameters": {},
        "perturbations": {"gain": {"scatter": 0.02}},
        "r0_perturbation": 3.0,
        "r0_kinds": {"gain": 3.0},
    }
    return plain | changed


def value(records: list[dict[str, Any]], name: str) -> float | None:
    return next((x.value for x in score_perturbed.score(records) if x.name == name), None)


def test_a_perturbation_s_own_twin_is_no_wrong_name() -> None:
    hummed = {"perturbations": {"hum": {}}, "verdict": "named"}
    twin = record(**hummed, effects=["periodic_disturbance"])
    other = record(**hummed, effects=["periodic_disturbance", "cogging"])
    stranger = record(verdict="named", effects=["periodic_disturbance"])
    assert [judge.wrong_name(r) for r in (twin, other, stranger, record())] == [False, True, True, False]
    assert value([twin, other, stranger], "perturbed, linear: wrong names") == 2


def test_what_is_told_is_looked_for_kind_by_kind() -> None:
    assert judge.told(record(scatter={"gain": {"deviation": 0.02, "explained": 0.6}}), "gain")
    assert not judge.told(record(scatter={"gain": {"deviation": 1e-6, "explained": 0.0}}), "gain")
    assert not judge.told(record(notes=["The gain is 8 N/V."]), "gain")
    assert judge.told(record(notes=["The gain differs by 2 % from run to run."]), "gain")
    assert judge.told(record(faults=[{"run": "case 2", "kind": "outliers", "size": 3}]), "outliers")
    assert judge.told(record(notes=["Three samples are missing."]), "dropped")
    assert not judge.told(record(), "hold_long")
    deep = record(r0_kinds={"gain": 3.0, "ar1": 1.2}, scatter={"gain": {"explained": None}})
    assert judge.mattering(deep) == ["gain"]
    assert value([deep, record()], "perturbed, r0 ≥ 2: kind told") == 0.5


def test_one_effect_is_named_with_or_without_the_twin() -> None:
    single = {"set": "perturbed-single", "truth": ["end_stop"], "verdict": "named", "qualified": True}
    right = record(**single, effects=["end_stop"])
    both = record(**single, effects=["end_stop", "flexible_coupling"], perturbations={"second_mode": {}})
    more = record(**single, effects=["end_stop", "cogging"])
    other = record(**single, effects=["cogging"])
    silent = record(**single | {"verdict": "unexplained"})
    error = {k: v for k, v in right.items() if k not in ("verdict", "effects", "alternatives")} | {
        "error": "ValueError"
    }
    faint = record(**single | {"qualified": False}, effects=["cogging"])
    some = [right, both, more, other, silent, error, faint]
    assert value(some, "perturbed, one effect: named") == pytest.approx(2 / 6)
    assert value(some, "perturbed, one effect: other name") == pytest.approx(2 / 6)


def test_triples_count_where_each_effect_is_needed() -> None:
    names = ["a", "b", "c"]
    triple = {"set": "triples", "truth": names, "verdict": "named", "perturbations": None}
    needed = {"costs": {"a": 2.0, "b": 1.3, "c": 9.0}}
    full = record(**triple, **needed, effects=names)
    part = record(**triple, **needed, effects=["a", "b"])
    twin = record(**triple, **needed, effects=["a", "b", "d"], twins=[["d", "a", "b"]])
    hidden = record(**triple, costs={"a": 2.0, "b": 1.1, "c": 9.0}, effects=["a"])
    for r in (full, part, twin, hidden):
        del r["perturbations"]
    assert value([full, part, twin, hidden], "triples that need all: all named") == pytest.approx(2 / 3)


def test_a_wrong_name_that_no_data_tell_from_the_truth_is_counted_apart() -> None:
    outside = {"set": "outside-all", "outside": "bump", "verdict": "named", "perturbations": {}}
    alike = record(**outside, effects=["cogging"], outside_twins=[["cogging"]])
    other = record(**outside, effects=["cogging"], outside_twins=[["end_stop"]])
    assert value([alike, other], "outside the catalogue: wrong names") == 2
    assert value([alike, other], "outside the catalogue: of these, not told from the truth by any data") == 1


def test_answers_that_another_effort_changes() -> None:
    same, more = ["adequate", []], ["named", ["cogging"]]
    some = [record(efforts={"quick": quick, "doubled": same}) for quick in (same, same, same, more)]
    assert value([*some, record()], "quick: another answer") == 0.25
    assert value([*some, record()], "twice the effort: another answer") == 0


def test_probability_is_compared_with_what_is_right() -> None:
    single = {"set": "single-all", "truth": ["end_stop"], "verdict": "named", "perturbations": {}}
    right, wrong = (record(**single, probability=0.92, effects=[e]) for e in ("end_stop", "cogging"))
    (row,) = score_perturbed.calibration([right] * 90 + [wrong] * 10)
    assert (row["low"], row["count"], row["right"], row["met"]) == (0.9, 100, 0.9, True)
    (row,) = score_perturbed.calibration([right] * 50 + [wrong] * 50)
    assert row["met"] is False
    (row,) = score_perturbed.calibration([right] * 10)
    assert row["met"] is None


def test_intervals_of_plant_and_effect() -> None:
    told = record(
        set="perturbed-single",
        truth=["end_stop"],
        verdict="named",
        effects=["end_stop"],
        true_plant={"base_mass": 1.0, "force_gain": 5.0},
        true_parameters={"end_stop.position": 0.01},
        parameters={"base_mass": (1.01, 0.01), "force_gain": (9.0, 0.1), "end_stop.position": (0.02, 0.001)},
        intervals={"end_stop.position": [0.005, 0.03]},
    )
    assert value([told], "perturbed: 95 % intervals cover") == 1.0
    assert value([told], "perturbed: median |error|/σ") == pytest.approx(5.5)


def test_a_run_is_taken_up_where_it_broke_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = []

    def fake(task: one_by_one.Task) -> dict[str, Any]:
        made.append(task)
        return {"set": task[0], "number": task[1], "salt": task[2]}

    monkeypatch.setattr(one_by_one, "run_task", fake)
    monkeypatch.setattr(one_by_one, "warm", lambda: None)
    file, tasks = tmp_path / "lines.jsonl", [("none", i, "s") for i in range(4)]
    one_by_one.run(tasks[:2], file, 1)
    with file.open("a", encoding="utf-8") as lines:
        lines.write('{"set": "none", "num')
    records = one_by_one.run(tasks, file, 1)
    assert made == tasks
    assert [r["number"] for r in records] == [0, 1, 2, 3]
    assert [json.loads(x)["number"] for x in file.read_text(encoding="utf-8").splitlines()] == [0, 1, 2, 3]
    assert one_by_one.wanted("triples=60") == ("triples", 60)
    with pytest.raises(ValueError, match="NAME=N"):
        one_by_one.wanted("nothing=3")


@pytest.mark.parametrize(("wrong", "of", "met"), [(1, 50, True), (2, 50, False), (6, 300, True), (7, 400, False)])
def test_of_fewer_campaigns_than_asked_as_large_a_part_may_be_wrong(wrong: int, of: int, met: bool) -> None:
    named = record(verdict="named", effects=["cogging"])
    lines = score_perturbed.score([named] * wrong + [record()] * (of - wrong))
    (line,) = (x for x in lines if x.name == "perturbed, linear: wrong names")
    assert (line.asked, line.value, line.count, line.met) == ("≤ 6 of 300", wrong, of, met)


def test_the_page_counts_by_effect_by_trouble_and_by_law() -> None:
    lost = {"truth": ["free_play"], "verdict": "unexplained"}
    found = {"truth": ["free_play"], "verdict": "named", "effects": ["free_play"]}
    clean = [record(set="single-all", **lost), record(set="single-all", **found), record(set="single-all", r0=1.0)]
    troubled = [
        record(set="perturbed-single", perturbations={"gain": {}, "hum": {}}, **found),
        record(set="perturbed-single", perturbations={"hum": {}}, **lost),
        record(set="perturbed-single", perturbations={"hum": {}}, qualified=False, **lost),
    ]
    eddy = {"set": "outside-all", "outside": "eddy_brake", "verdict": "named", "effects": ["cogging"]}
    strange = [
        record(**eddy, outside_twins=[["cogging"]]),
        record(**eddy),
        record(set="perturbed-outside", outside="bump"),
    ]
    plants = "# Real\n\n| recording | known | answer | CPU [s] | as asked |\n| --- | --- | --- | --- | --- |\n"
    plants += "| ship: a model (10.1/x) | a spring | named: cubic | 3.0 | yes |\n\nAll are.\n"
    text = page.markdown("THE LINES", [*clean, *troubled, *strange], "abc1234", plants)
    assert (
        "abc1234: 9 campaigns, 2 of outside-all, 1 of perturbed-outside, 3 of perturbed-single, 3 of single-all."
        in text
    )
    assert "THE LINES" in text
    assert "| free play | 2 | 1 | 1 |" in text
    assert "| gain | 1 | 1 | 0 |" in text
    assert "| hum | 2 | 1 | 0 |" in text
    assert "| eddy brake | 2 | 2 | 1 |" in text
    assert "| bump | 1 | 0 | 0 |" in text
    assert "| outside-all | 2 | 0 | 0 | 0 | 1.00 |" in text
    assert (
        "| recording | known | answer | as asked |\n| --- | --- | --- | --- |\n| ship | a spring | named: cubic | yes |"
        in text
    )
