"""What a diagnosis says when it is printed: five questions in order, rounded by the uncertainty, nothing made up."""

from __future__ import annotations

import math
import re

import pytest

import diagnosis_example as example
import stepid
from diagnosis_example import changed
from stepid.core.estimate import Estimate
from stepid.core.words import digits, length
from stepid.diagnosis.result import Diagnosis, Gap, Where
from stepid.diagnosis.text import QUESTIONS, next_steps, standing
from stepid.diagnosis.wording import candidate_name, chance, effect_names, parameter_words, per_cent, promised
from stepid.identification.parameters import IdentifiedParameters, ParameterUncertainty
from stepid.report import diagnosis_report, hand_method_table


def rows(text: str, header: str) -> dict[str, list[str]]:
    """Rows of a table by their first cell; cells are two blanks apart."""
    lines = [re.split(r"\s{2,}", line.strip()) for line in text.splitlines()]
    begin = next(i for i, cells in enumerate(lines) if cells[0] == header)
    found: dict[str, list[str]] = {}
    for cells in lines[begin + 2 :]:
        if cells == [""]:
            break
        found[cells[0]] = cells[1:]
    return found


@pytest.mark.parametrize(("share", "said"), [(0.25, "25 %"), (0.0, "none"), (-37.8, "none")])
def test_of_a_misfit_nothing_or_some_is_explained(share: float, said: str) -> None:
    found = standing(changed(example.named(), explained=share))
    assert found[0].startswith(f"On runs left out of the fit it explains {said}")


@pytest.mark.parametrize(
    ("meters", "expected"),
    [
        (6.367e-4, "637 µm"),
        (1.978e-5, "19.8 µm"),
        (9.996e-6, "10.0 µm"),
        (4.4e-7, "0.44 µm"),
        (9.9951e-4, "1.00 mm"),
        (9.994e-4, "999 µm"),
        (0.0123, "12.3 mm"),
        (0.0, "0.00 µm"),
    ],
)
def test_lengths_have_three_digits(meters: float, expected: str) -> None:
    assert length(meters) == expected


def test_digits_and_names() -> None:
    assert [digits(v) for v in (99.96, 99.94, 9.996, 0.123, 1234.5)] == ["100", "99.9", "10.0", "0.12", "1234"]
    assert effect_names(("coulomb_friction", "input_delay")) == "Coulomb friction and input delay"


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        (1.0, "100 %"),
        (0.99999, "> 99.99 %"),
        (0.9987, "99.87 %"),
        (0.913, "91.3 %"),
        (0.52, "52 %"),
        (0.004, "0.4 %"),
        (1e-5, "0 %"),
        (-0.12, "−12 %"),
    ],
)
def test_shares_have_the_digits_that_count(share: float, expected: str) -> None:
    assert per_cent(share) == expected


def test_probabilities_are_never_certain() -> None:
    assert [chance(p) for p in (1.0, 0.985, 0.5, 0.011, 0.0)] == [">99 %", "98 %", "50 %", "1 %", "<1 %"]


def test_candidates_tell_what_differs_between_runs() -> None:
    assert candidate_name(()) == "nothing (linear)"
    assert candidate_name((), ("gain",)) == "linear, gains differ"
    said = candidate_name(("coulomb_friction",), ("friction", "start_time"))
    assert said == "Coulomb friction, friction differs, start times differ"


def test_the_best_eight_candidates_and_the_linear_model_are_shown() -> None:
    d = example.named()
    many = tuple(d.ranking[1].model_copy(update={"effects": (f"effect_{i}",)}) for i in range(12))
    shown = rows(changed(d, ranking=(*many, d.ranking[-1])).summary(), "candidate")
    assert list(shown) == [*(f"effect {i}, start times differ" for i in range(8)), "nothing (linear)"]


def test_summary_answers_the_five_questions_in_order() -> None:
    d = example.named()
    text = d.summary()
    places = [text.index(question) for question in QUESTIONS]
    assert places == sorted(places)
    assert text.startswith("Diagnosis of campaign 'cases 4 to 7': named\nA linear model is not adequate: Coulomb")
    answers = [text[a:b] for a, b in zip(places, [*places[1:], len(text)], strict=True)]
    assert f"{length(d.gap.noise)} RMS. The linear joint fit leaves {length(d.gap.before)}" in answers[0]
    assert all(sentence in answers[1] for sentence in d.where.sentences)
    assert set(rows(answers[1], "phase")) == set(d.where.phases)
    assert list(rows(answers[2], "candidate")) == [
        "Coulomb friction",
        "quadratic damping and input delay, start times differ",
        "nothing (linear)",
    ]
    others = rows(answers[2], "candidate")
    explained = 100 * (1 - (d.gap.after / d.gap.before) ** 2)
    assert others["Coulomb friction"] == [f"{explained:.2f} %", digits(1e6 * d.gap.after), ">99 %"]
    assert others["quadratic damping and input delay, start times differ"][::2] == ["84 %", "<1 %"]
    assert others["nothing (linear)"] == ["0 %", digits(1e6 * d.gap.before), "<1 %"]
    assert f"On runs left out of the fit it explains {explained:.2f} % of the linear model's misfit." in answers[3]
    assert "The final model leaves 0.25 % of the motion, in RMS." in answers[3]
    assert "The probability that this answer is right is 98 %." in answers[3]
    assert "evidence" not in text
    assert d.reasons[0] in answers[3]
    assert "clean and align the rails" in answers[4]
    assert str(d) == text


def test_gap_and_parameters_are_what_the_model_holds() -> None:
    d = example.named()
    gaps = rows(d.summary(), "RMS")
    assert list(gaps) == ["all runs", *example.RUNS]
    g = d.gap
    assert g.held_out_before is not None
    assert g.held_out_after is not None
    expected = [1e6 * g.before, 1e6 * g.after, g.after / g.noise, 1e6 * g.held_out_before, 1e6 * g.held_out_after]
    cells = gaps["all runs"]
    assert [float(cell) for cell in (*cells[:3], *cells[4:])] == pytest.approx(expected, rel=6e-3)
    assert [gaps[run.name][3] for run in d.runs] == [per_cent(run.explained) for run in d.runs]
    found = rows(d.summary(), "parameter")
    assert list(found) == list(d.parameters)
    level = d.parameters["coulomb_friction.level"]
    assert found["coulomb_friction.level"] == ["–", *str(level).rsplit(" ", 1)]
    assert level.value == pytest.approx(example.LEVEL, rel=0.01)
    assert found["stiffness[medium]"][2] == "N/m"


def test_no_run_held_out_is_a_dash() -> None:
    d = example.named()
    bare = changed(d, gap=Gap(before=d.gap.before, after=d.gap.after, noise=d.gap.noise))
    assert rows(bare.summary(), "RMS")["all runs"][4:] == ["–", "–"]


def test_undetermined_is_said() -> None:
    d = example.named()
    open_ = dict(d.parameters) | {"coulomb_friction.level": Estimate(value=0.3, unit="N")}
    assert "0.3 (undetermined)" in changed(d, parameters=open_).summary()


def test_each_verdict_says_its_answer() -> None:
    d = example.named()
    adequate = example.adequate().summary()
    assert "A linear model is adequate." in adequate
    assert "final model" not in adequate.split("parameter")[1]
    assert "nothing to say" in adequate
    ambiguous = example.ambiguous().summary()
    assert "- record with more mass\n   - Note: The fit did not converge." in ambiguous
    lost = changed(d, verdict="unexplained", effects=())
    assert "these data do not tell which effect is missing" in lost.summary()  # one leaves only noise
    far, near = (
        tuple(one.model_copy(update={"rms": 2 * d.gap.noise, "explained": share}) for one in d.ranking)
        for share in (0.84, 0.85)
    )
    assert "nothing in the catalogue explains why" in changed(lost, ranking=far).summary()
    assert "nothing in the catalogue explains all of what it leaves" in changed(lost, ranking=near).summary()
    strict, loose = stepid.Criteria(lead=0.9), stepid.Criteria(near=2.5)  # by its own criteria, whichever
    assert "nothing in the catalogue explains why" in changed(lost, ranking=near, criteria=strict).summary()
    assert "these data do not tell which effect is missing" in changed(lost, ranking=far, criteria=loose).summary()
    pair = changed(d, effects=("coulomb_friction", "input_delay"))
    level = d.parameters["coulomb_friction.level"]
    assert f"not adequate: Coulomb friction ({level}) and input delay are missing." in pair.summary()
    assert next_steps(changed(d, effects=("an_effect_of_mine",), advice={})) == ("Keep the effect in the model.",)
    both = next_steps(changed(d, next_experiment="record a step the other way"))
    assert both[0] == "record a step the other way"
    assert both[1].startswith("Coulomb friction: clean")


def test_parameters_and_promises_are_words_in_sentences() -> None:
    names = (
        "coulomb_friction.level",
        "stribeck_friction.static_level",
        "stiffness[1.5 mm]",
        "base_mass",
        "input_delay.delay",
    )
    assert [parameter_words(name) for name in names] == [
        "the level of Coulomb friction",
        "the static level of Stribeck friction",
        "stiffness (1.5 mm)",
        "base mass",
        "input delay",
    ]
    said = "the most promising may explain {} of the remaining misfit"
    assert [promised(share) for share in (0.004, 0.4, 1.0)] == ["", said.format("40 %"), said.format("nearly all")]


def test_repr_is_one_line() -> None:
    d = example.named()
    gap = f"RMS {length(d.gap.before)} → {length(d.gap.after)}, noise {length(d.gap.noise)}"
    assert repr(d) == f"Diagnosis('cases 4 to 7', named: coulomb_friction, {gap})"
    assert "→" not in repr(example.adequate())
    assert repr(d.runs[0]).startswith("RunGap('case 4', RMS ")
    assert repr(d.where).count("\n") == 0
    assert str(d.where).splitlines() == list(d.where.sentences)


def test_html_holds_the_same() -> None:
    d = changed(example.named(), campaign="a <b> & c")
    page = d._repr_html_()
    assert "a &lt;b&gt; &amp; c" in page
    assert page.count("<table>") == 4
    assert all(question in page for question in QUESTIONS)
    assert "<td>N·s/m</td>" in page


def test_json_round_trip() -> None:
    d = example.named()
    again = Diagnosis.model_validate_json(d.model_dump_json())
    assert again == d
    assert isinstance(again.where, Where)


def test_hand_method_stands_beside_the_fit() -> None:
    d = example.named()
    found = stepid.identify(example.campaign())
    table = hand_method_table(d, found)
    row = rows(table, "parameter")
    assert list(row) == list(d.parameters)[:4]
    base, final = found.base_mass["cart"], d.parameters["base_mass"].value
    assert row["base_mass"][0] == f"{base:.3f} ± {found.uncertainty.base_mass['cart']:.3f}"
    assert row["base_mass"][3:] == [
        "kg",
        f"{100 * (base / final - 1):+.1f} %".replace("-", "−"),
        f"{100 * (d.linear_parameters['base_mass'].value / final - 1):+.1f} %",
    ]
    assert base / final - 1 < -0.1  # the lesson: friction pulls the base mass by tens of per cent
    gains = [found.static_gain[name] * found.run_stiffness(name) for name in example.RUNS]
    assert row["force_gain"][0].startswith(f"{sum(gains) / 4:.2f} ±")
    assert "How far Coulomb friction pulls each number" in table


def test_hand_method_beside_a_linear_fit() -> None:
    table = hand_method_table(example.adequate(), stepid.identify(example.campaign()))
    row = rows(table, "parameter")
    assert all(len(cells) == 4 for cells in row.values())
    assert "pulls" not in table


def test_what_the_hand_method_leaves_out_is_said() -> None:
    found = IdentifiedParameters(
        masses={"case 4": 1.0},
        stiffness={"medium": 200.0},
        damping={"case 4": 12.0},
        base_mass={"cart": 1.0},
        springs={"case 4": "medium"},
        uncertainty=ParameterUncertainty(),
        excluded={"case 5": "no overshoot"},
    )
    table = hand_method_table(example.named(), found)
    assert table.endswith("left out by the peak method: case 5: no overshoot")
    assert rows(table, "parameter")["damping[1/2 turn]"][0] == "–"


def test_report_says_why_the_hand_method_refused() -> None:
    error = stepid.errors.UndeterminedError("one mass only", "Add a run.")
    first, second = diagnosis_report(example.named(), error)
    assert first.body == example.named().summary()
    assert second.title == "The peak method beside it"
    assert second.body == "The peak method cannot use this campaign: one mass only."


def test_it_says_when_the_weights_rule_the_uncertainties() -> None:
    d = example.named().model_copy(update={"data": example.campaign()})
    # 5 g in a weight of 0.5 kg, as the root of the mass: Campaign.weight_uncertainty
    heaviest = max(run.added_mass for run in example.campaign())
    known = 0.005 * math.sqrt(heaviest / 0.5)
    said = f"{heaviest:.3g} kg, is taken as known to {known:.2g} kg, by the campaign's weight_uncertainty of 0.005 kg"
    assert said in d.summary()
    sure = d.model_copy(update={"data": None})
    assert "taken as known" not in sure.summary()
    parts = {name: e.model_copy(update={"parts": {"noise": e.uncertainty or 0.0}}) for name, e in d.parameters.items()}
    assert "taken as known" not in d.model_copy(update={"parameters": parts}).summary()
