"""The answer in a sentence: the most likely name and its size first, no more claimed than the evidence holds."""

from __future__ import annotations

import re

import numpy as np

import diagnosis_example as example
from diagnosis_example import changed
from stepid.core.estimate import Estimate
from stepid.diagnosis.experiment_design import next_experiment
from stepid.diagnosis.headline import advice_beside, answer, found_sizes
from stepid.effects import resolve
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.problem import build, fit_linear, start_local
from stepid.simulation.records import lay_out


def test_what_is_named_has_its_size() -> None:
    d = example.named()
    level = d.parameters["coulomb_friction.level"]
    assert answer(d) == f"A linear model is not adequate: Coulomb friction, {level}, is missing."
    assert d.summary().splitlines()[1] == answer(d)
    assert answer(d, sizes=False) == "A linear model is not adequate: Coulomb friction is missing."
    none = {name: value for name, value in d.parameters.items() if "." not in name}
    assert answer(changed(d, parameters=none)) == answer(d, sizes=False)
    force = Estimate(value=0.2, uncertainty=0.01, unit="N")
    several = changed(d, parameters={**d.parameters, "coulomb_friction.rate": force})
    assert answer(several).endswith(f"Coulomb friction (level {level}, rate 0.200 ± 0.010 N) is missing.")


def test_an_open_choice_begins_with_what_is_most_likely_and_its_size() -> None:
    d = example.ambiguous()
    level = d.parameters["coulomb_friction.level"]
    said = f"Most likely Coulomb friction, {level}; these data do not tell it from load proportional friction."
    assert " ± " in str(level)
    assert answer(d) == said
    assert d.summary().splitlines()[1:3] == [said, "Record with more mass."]
    assert f"{said}<br>Record with more mass.</p>" in d._repr_html_()
    three = changed(d, alternatives=(("load_proportional_friction",), ("cogging",), ("free_play", "input_delay")))
    assert answer(three).endswith("tell it from load proportional friction, cogging or free play and input delay.")


def test_an_open_choice_does_not_claim_more_than_the_evidence() -> None:
    d = example.ambiguous()
    better = d.ranking[0].model_copy(update={"effects": ("load_proportional_friction",), "evidence": -3.0})
    assert answer(changed(d, ranking=(better, *d.ranking))).startswith("Possibly Coulomb friction, ")
    assert answer(changed(d, ranking=())).startswith("Possibly Coulomb friction, ")
    open_ = {**d.parameters, "coulomb_friction.level": Estimate(value=0.3, unit="N")}
    assert answer(changed(d, parameters=open_)).startswith("Most likely Coulomb friction, 0.3 N (undetermined); ")


def test_sets_of_effects_are_told_with_the_size_of_each_while_they_are_few() -> None:
    d = example.ambiguous()
    delay = Estimate(value=0.005, uncertainty=0.0001, unit="s")
    two = changed(
        d, effects=("coulomb_friction", "input_delay"), parameters={**d.parameters, "input_delay.delay": delay}
    )
    level = d.parameters["coulomb_friction.level"]
    assert f"Coulomb friction ({level}) and input delay (5.00 ± 0.10 ms); these data do not tell them" in answer(two)
    force = Estimate(value=0.2, uncertainty=0.01, unit="N")
    several = changed(d, parameters={**d.parameters, "coulomb_friction.rate": force})
    assert f"Coulomb friction (level {level}, rate 0.200 ± 0.010 N); " in answer(several)
    many = changed(d, parameters={**d.parameters, **{f"coulomb_friction.part_{i}": force for i in range(4)}})
    assert "Coulomb friction; these data" in answer(many)
    assert len(found_sizes(many)) == 5


def test_errors_of_the_weights_stand_beside_the_size_of_what_they_imitate() -> None:
    d = changed(example.ambiguous(), alternatives=(), next_experiment=None)
    level = d.parameters["coulomb_friction.level"]
    rest = "errors of the added masses within their uncertainty would, too."
    assert answer(d) == f"Coulomb friction, {level}, explains the misfit; {rest}"
    assert advice_beside(d) == ""
    assert d.summary().splitlines()[2] == ""
    pair = changed(d, effects=("coulomb_friction", "input_delay"))
    assert answer(pair) == f"Coulomb friction ({level}) and input delay explain the misfit; {rest}"


def test_advice_stands_beside_open_choices_only() -> None:
    d = changed(example.named(), next_experiment="record a step the other way")
    assert advice_beside(d) == ""
    assert advice_beside(changed(d, verdict="ambiguous")) == "Record a step the other way."


def test_the_run_that_would_tell_is_named_in_whole_sentences() -> None:
    measured = example.campaign()
    records = lay_out(measured)
    linear = fit_linear(records)
    assert linear is not None
    problem = build(records, resolve(["coulomb_friction"]))
    friction = minimize(problem, np.append(linear.shared, example.LEVEL), start_local(problem, linear))
    assert friction is not None
    names = {id(linear): "a linear plant", id(friction): "Coulomb friction"}

    def told(floor: float) -> str:
        return next_experiment(friction, [linear], floor=floor, tell=lambda one: names[id(one)])

    assert re.fullmatch(
        r"To tell Coulomb friction from a linear plant, record a step of .*\. "
        r"There the models differ by [\d.]+ [µm]m RMS, [\d.]+ times the noise\.",
        told(friction.rms),
    )
    assert told(1e-6).endswith(" times what they leave so far.")
    assert told(1.0) == (
        "None of the usual extra runs would tell Coulomb friction from a linear plant: in all of them the models "
        "differ by less than half the noise. Lower the noise, or sample faster."
    )
