"""Arguments of a wrong type: stepid's own error names argument and remedy."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import stepid
from broken_campaigns import campaign
from stepid import lab
from stepid.core.takes import caller, described, taken
from stepid.effects import CATALOGUE, resolve
from stepid.errors import InputError

WHOLE = campaign(1)
RUN = WHOLE.experiments[0]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: stepid.identify(WHOLE, solver=stepid.WeightedLeastSquares), r"is the class Weighted.*brackets"),
        (lambda: stepid.identify(WHOLE, peak=stepid.InterpolatedPeak), "peak is the class InterpolatedPeak.*brackets"),
        (lambda: stepid.fit(WHOLE, effects=5), r"effects is 5. Give names of effects, as \(\"coulomb_friction\",\)"),
        (lambda: stepid.fit(WHOLE, effects={"coulomb_friction": 1}), "effects is {'coulomb_friction': 1}"),
        (lambda: stepid.fit(WHOLE, effects="friction"), "no effect called 'friction'. The catalogue has: coul"),
        (lambda: stepid.fit(WHOLE, effects=("free_play",), catalogue="all"), "catalogue is 'all'. Give a tuple"),
        (lambda: stepid.diagnose(WHOLE, criteria={}), r"criteria is {}. Give stepid.Criteria\(…\)"),
        (lambda: stepid.diagnose(WHOLE, effort="quick"), r"effort is 'quick'. Give stepid.Effort\(\)"),
        (lambda: stepid.diagnose(WHOLE, progress=lambda: None), "progress is a function. Give a function that"),
        (lambda: stepid.diagnose_many(WHOLE.name), "campaigns is 'seed 1'. Give campaigns in a list"),
        (lambda: stepid.diagnose_many([WHOLE], executor=4), "executor is 4. Give an executor of concurrent.futures"),
        (lambda: stepid.simulate(WHOLE, WHOLE), "model is a Campaign. Give a PlantModel, as fit.model"),
        (lambda: stepid.verify(WHOLE, WHOLE), "parameters is a Campaign. Give what stepid.identify returns"),
        (lambda: stepid.solve(WHOLE), "system is a Campaign. Give a StackedSystem from stepid.assemble"),
        (lambda: stepid.assemble([RUN], WHOLE.mass_offsets), "characteristics is a list. Give characteristics"),
        (lambda: stepid.transfer_function("case 1", RUN), "source is 'case 1'. Give what stepid.identify returns"),
        (lambda: stepid.nonlinear_system(RUN, RUN), "model is an Experiment. Give a PlantModel"),
        (lambda: stepid.split_releases(WHOLE), "an Experiment is needed, not a Campaign"),
        (lambda: stepid.from_time_response(RUN, name="a", added_mass=0, spring="s", damper="d"), "is an Experiment"),
        (lambda: stepid.Effort().scaled("twice"), "times is 'twice'. Give a number above 0"),
        (lambda: stepid.Experiment.from_dataframe(3, name="a", added_mass=0, spring="s", damper="d"), "a data frame is "
         "needed, not 3"),
        (lambda: WHOLE[np.zeros(3)], "has no run a ndarray|has no run an? "),
        (lambda: WHOLE.experiments[0].slice(after="now"), "after is 'now'. Give a time in s"),
        (lambda: stepid.read_ecp("a.txt", counts_per_meter=None), "no such file"),
        (lambda: lab.make(seed=1, groups=("A",), rig=3), r"rig is 3. Give stepid.lab.Rig\(…\)"),
        (lambda: lab.make(seed=1, groups=("A",), effects=3), "effects is 3. Give a Draw"),
        (lambda: lab.check(3, 4), "answer is 3. Give an Answer"),
        (lambda: stepid.plot.gap_bars(3, axes=None), "d is 3. Give a Diagnosis"),
    ],
)  # fmt: skip
def test_the_error_names_argument_and_remedy(call: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        call()
    assert caught.value.remedy


def test_one_effect_needs_no_brackets() -> None:
    coulomb = next(e for e in CATALOGUE if e.name == "coulomb_friction")
    assert resolve("coulomb_friction") == resolve(coulomb) == resolve(("coulomb_friction",)) == (coulomb,)
    assert resolve(name for name in ["coulomb_friction"]) == (coulomb,)
    assert "coulomb_friction.level" in stepid.fit(campaign(1, masses=(0.0, 1.0)), effects="coulomb_friction").parameters


def test_masked_arrays_are_refused() -> None:
    masked = np.ma.masked_greater(RUN.position, 0.01)
    fields = {name: getattr(RUN, name) for name in type(RUN).model_fields}
    frame = {name: fields.pop(name) for name in ("time", "position", "input")}
    labels = {"name": "a", "added_mass": 0.0, "spring": "s", "damper": "d"}
    with pytest.raises(InputError, match="position: is a masked array; leave out what is masked"):
        stepid.Experiment(**fields | frame | {"position": masked})
    with pytest.raises(InputError, match="column 'position' for position is a masked array"):
        stepid.Experiment.from_dataframe(frame | {"position": masked}, **labels)
    with pytest.raises(InputError, match="a masked array"):
        stepid.to_time_response(RUN, position=masked)


def test_masked_inputs_of_files_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("".join(f"{i},{i % 3}\n" for i in range(20)))
    with pytest.raises(InputError, match="input is a masked array"):
        stepid.read_table(file, time=0, position=1, input=np.ma.masked_equal(np.arange(20.0), 3))


def test_what_a_value_is_in_few_words() -> None:
    assert described(10**5000) == "a number of thousands of digits"
    assert described("x" * 100) == "'" + "x" * 56 + "..."
    assert described([1, 2]) == "[1, 2]"
    assert described(list(range(100))) == "a list"
    assert described(np.zeros(2)) == "a ndarray"
    assert described(int) == "the class int"
    taken("f", "x", max, caller("a function"))  # written in C, says nothing of its arguments


@pytest.mark.slow
def test_wrong_values_at_every_public_function(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some of the 20,000 calls of benchmarks/wrong_types.py."""
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])
    monkeypatch.chdir(tmp_path)
    from wrong_types import attack

    ends, foreign = attack(tmp_path / "made", 1500, 5)
    assert foreign == []
    assert ends["stepid's error"] > 1200
