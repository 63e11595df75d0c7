"""One run that hides the law of the others: found by what they leave without it, and told by their model."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from broken_campaigns import FRICTION, campaign, changed, inputs, scaled
from stepid.diagnosis import odd_run
from stepid.diagnosis.odd_run import fault_of, outlying_runs
from stepid.diagnosis.selection.candidate import Candidate
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.record_fault import RecordFault

MASSES = (0.0, 0.0, 0.5, 0.5, 1.5, 1.5)
VOLTS = (0.5, -0.5, 0.5, -0.5, 0.5, -0.5)
BENT = {"cubic_stiffness": {"coefficient": 4e5}}


def carts(seed: int, effects: dict[str, dict[str, float]], **told: object) -> stepid.Campaign:
    return campaign(seed, effects, masses=MASSES, volts=VOLTS, **told)  # type: ignore[arg-type]


def fault(whole: stepid.Campaign, run: int, *names: str) -> RecordFault | None:
    """What is wrong with a run by a model that is fitted to the others."""
    rest = whole.model_copy(update={"experiments": tuple(e for i, e in enumerate(whole.experiments) if i != run)})
    context = prepare(rest)
    fitted = fit_effects(context, resolve(names))
    assert fitted is not None
    return fault_of(prepare(whole), run, Candidate(resolve(names), frozenset(), fitted, 0.0), context.floor, sure=5.0)


@pytest.mark.parametrize("effects", [{}, FRICTION, BENT], ids=["none", "friction", "bent"])
def test_a_law_makes_no_run_outlying(effects: dict[str, dict[str, float]]) -> None:
    assert outlying_runs(prepare(carts(1, effects))) == []


def test_the_run_that_takes_the_misfit_with_it_is_outlying() -> None:
    assert outlying_runs(prepare(scaled(carts(2, FRICTION), 3, -1.0)))[0] == 3


def test_an_error_that_a_weight_may_have_is_no_fault() -> None:
    """0.5 kg of six runs, or 0.12 kg a weight."""
    whole = carts(2, FRICTION, true_masses=(0, 0, 0.5, 1.0, 1.5, 1.5))
    told = fault(whole, 3, "coulomb_friction")
    assert told is not None
    assert told.kind == "added_mass"
    assert fault(whole.model_copy(update={"weight_uncertainty": 0.12}), 3, "coulomb_friction") is None


def test_beside_a_strong_law_a_run_is_outlying_that_the_linear_plant_hides() -> None:
    context = prepare(carts(3, BENT, true_masses=(0, 0, 0.5, 1.0, 1.5, 1.5)))
    law = fit_effects(context, resolve(("cubic_stiffness",)))
    assert law is not None
    assert outlying_runs(context) == []
    assert outlying_runs(context, [law]) == [3]


def test_a_run_whose_label_no_other_has_is_not_outlying() -> None:
    wrong = scaled(carts(2, FRICTION), 3, -1.0)
    assert outlying_runs(prepare(changed(wrong, 3, damper="another"))) == []


def test_a_wrong_mass_is_told_beside_a_bent_spring() -> None:
    found = fault(carts(3, BENT, true_masses=(0, 0, 0.5, 1.0, 1.5, 1.5)), 3, "cubic_stiffness")
    assert found is not None
    assert (found.run, found.kind, found.unit) == ("case 4", "added_mass", "kg")
    assert found.size == pytest.approx(0.5, abs=0.01)
    assert "kg added instead of 0.5 kg it agrees: a wrong added mass" in found.words


@pytest.mark.parametrize("seed", range(1, 6))
def test_a_weight_that_was_not_mounted_is_told_as_none(seed: int) -> None:
    """Noise puts it to either side of zero."""
    found = fault(carts(seed, BENT, true_masses=(0, 0, 0.5, 0, 1.5, 1.5)), 3, "cubic_stiffness")
    assert found is not None
    assert (found.kind, found.size) == ("added_mass", pytest.approx(-0.5, abs=0.01))
    assert "kg added instead of 0.5 kg it agrees" in found.words
    assert "With -" not in found.words


@pytest.mark.parametrize("run", [0, 3])
def test_the_place_of_a_run_among_others_does_not_matter(run: int) -> None:
    """Springs are numbered as they come: without the first run in another order."""
    springs = ["stiff", "medium"] * 3
    true = [0.5, 0.0, 0.5, 0.5, 1.5, 1.5] if run == 0 else [0.0, 0.0, 0.5, 1.0, 1.5, 1.5]
    found = fault(
        campaign(7, BENT, masses=MASSES, true_masses=true, springs=springs, volts=VOLTS), run, "cubic_stiffness"
    )
    assert found is not None
    assert (found.run, found.kind) == (f"case {run + 1}", "added_mass")
    assert found.size == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("share", [0.0, 0.03, 0.3, 1.0])
def test_only_what_another_label_says_is_a_mistake_in_a_label(share: float) -> None:
    """What no label says is none; the run's own label is no other one."""
    linear = prepare(campaign(1, masses=MASSES[:4], springs=["medium", "medium", "stiff", "stiff"])).linear
    shared = linear.shared.copy()
    shared[linear.problem.layout.stiffness] = [400.0, 800.0]
    assert odd_run._is_label(("stiffness", share, 0.0, linear), shared) == (share == 1.0)


@pytest.mark.parametrize("factor", [-1.0, 0.5, 10.0])
def test_a_wrong_scale_is_told_beside_friction(factor: float) -> None:
    found = fault(scaled(carts(4, FRICTION), 3, factor), 3, "coulomb_friction")
    assert found is not None
    assert (found.kind, found.size) == ("gain", factor)


def touched(seed: int, volts: tuple[float, ...], effects: dict[str, dict[str, float]] = FRICTION) -> stepid.Campaign:
    """A push in the third run that its input does not tell."""
    pushed = inputs(volts[2])
    pushed[120:128] -= 0.8
    drives = [inputs(v) for v in volts]
    hand = campaign(
        seed, effects, masses=MASSES, springs=["medium"] * 6, drives=[*drives[:2], pushed, *drives[3:]], volts=volts
    )
    return changed(hand, 2, input=drives[2])


@pytest.mark.parametrize("share", [0.4, 0.6, 0.8])
def test_a_run_with_clipped_readings_has_no_wrong_scale(share: float) -> None:
    """Of a fraction of the model little is left that a flat record misses, but it does not agree with that either.

    What is clipped before its noise does not repeat: else it would be left out, see `test_flat_readings`.
    """
    whole = carts(4, {})
    run = whole.experiments[2]
    steady = 7.8 / 216.0 * 0.5
    noise = 2e-5 * np.random.default_rng(0).standard_normal(run.time.size)
    clipped = changed(whole, 2, position=np.minimum(run.position, run.position[0] + share * steady) + noise)
    told = fault(clipped, 2)
    assert told is not None
    assert told.kind == "disagreement"


def test_a_run_that_was_touched_disagrees() -> None:
    found = fault(touched(5, VOLTS), 2, "coulomb_friction")
    assert found is not None
    assert (found.run, found.kind, found.unit) == ("case 3", "disagreement", "m")
    assert "Was the cart touched" in found.words


DRAGGED = {**BENT, "quadratic_damping": {"coefficient": 20.0}}  # the fitted model has no drag


def test_a_mistake_is_told_where_more_than_noise_is_left_in_all_runs() -> None:
    found = fault(carts(3, DRAGGED, true_masses=(0, 0, 0.5, 1.0, 1.5, 1.5)), 3, "cubic_stiffness")
    assert found is not None
    assert (found.kind, found.size) == ("added_mass", pytest.approx(0.5, abs=0.03))
    assert "far more than these do among themselves" in found.words


def test_a_run_does_not_disagree_with_a_model_that_leaves_more_than_noise() -> None:
    assert fault(touched(5, VOLTS, DRAGGED), 2, "cubic_stiffness") is None
    assert fault(touched(5, VOLTS, DRAGGED), 2, "cubic_stiffness", "quadratic_damping") is not None


def test_a_run_that_others_are_nearly_as_far_from_the_model_as_is_not_odd() -> None:
    assert fault(carts(3, BENT, true_masses=(0, 0, 0.5, 0.6, 1.5, 1.5)), 3) is None
    assert fault(carts(3, BENT, true_masses=(0, 0, 0.5, 0.6, 1.5, 1.5)), 3, "cubic_stiffness") is not None


@pytest.mark.parametrize("volts", [(0.5, 0.5, -0.5, 0.5, 0.5, 0.5), (0.5, -0.5, 0.9, -0.5, 0.5, -0.5)])
def test_a_run_that_no_other_is_like_is_not_accused_of_that(volts: tuple[float, ...]) -> None:
    assert fault(touched(5, volts), 2, "coulomb_friction") is None


FOUR = (0.0, 0.5, 1.5, 2.0)


def test_three_others_tell_a_mistake_that_takes_nearly_all_of_the_misfit() -> None:
    drag = {"quadratic_damping": {"coefficient": 30.0}}
    whole = campaign(3, drag, masses=FOUR, true_masses=(0.0, 1.0, 1.5, 2.0))
    assert outlying_runs(prepare(whole))[0] == 1
    found = fault(whole, 1, "quadratic_damping")
    assert found is not None
    assert (found.kind, found.size) == ("added_mass", pytest.approx(0.5, abs=0.01))


def test_three_others_accuse_no_run_of_what_is_no_mistake() -> None:
    alike = dict.fromkeys((0, 1), 0.5) | dict.fromkeys((2, 3), -0.5)
    pushed = inputs(alike[1])
    pushed[120:128] -= 0.8
    drives = [inputs(volts) for volts in alike.values()]
    hand = campaign(5, FRICTION, masses=FOUR, drives=[drives[0], pushed, *drives[2:]])
    whole = changed(hand, 1, input=drives[1])
    assert outlying_runs(prepare(whole))[0] == 1
    assert fault(whole, 1, "coulomb_friction") is None


@pytest.mark.slow
def test_the_law_is_named_without_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = touched(6, VOLTS)
    d = stepid.diagnose(whole)
    assert d.effects == ("coulomb_friction",)
    assert [(f.run, f.kind) for f in d.faults] == [("case 3", "disagreement")]
    assert d.data == whole
    assert len(d.runs) == 5
    assert any("It is left out of this diagnosis." in note for note in d.notes)
    monkeypatch.setattr(odd_run, "_STANDS_OUT", 0.0)
    assert stepid.diagnose(whole).verdict == "unexplained"  # without it all is lost
