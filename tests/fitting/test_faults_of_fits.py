"""One broken run: it is named with its mistake, in the fit's notes; clean campaigns raise no suspicion."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest

import stepid
from broken_campaigns import FRICTION, campaign, changed, scaled, shifted
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.run_fault import find_fault


def drifting(whole: stepid.Campaign) -> stepid.Campaign:
    run = whole.experiments[1]
    return changed(whole, 1, position=run.position + 2e-4 * run.time)


BROKEN: dict[str, tuple[Callable[[int], stepid.Campaign], str]] = {
    "mass": (
        lambda s: campaign(s, true_masses=(0, 0.5, 2.0, 2.0)),
        r"'case 3'.*With 2(\.00\d)? kg added instead of 1\.5",
    ),
    "small mass": (lambda s: campaign(s, true_masses=(0, 0.53, 1.5, 2.0)), r"'case 2'.*With 0\.5[23]\d* kg added"),
    "spring": (
        lambda s: campaign(s, true_springs=["medium"] * 3 + ["stiff"]),
        r"'case 4'.*With a stiffness of 390(\.\d)? N/m instead of the 216.*wrong spring label",
    ),
    "other spring": (
        lambda s: campaign(
            s,
            masses=(0, 0.5, 1.5, 2, 1),
            springs=["medium"] * 4 + ["stiff"],
            true_springs=["medium", "medium", "stiff", "medium", "stiff"],
        ),
        r"'case 3'.*that of spring 'stiff'",
    ),
    "sign": (lambda s: scaled(campaign(s), 1, -1.0), r"'case 2'.*With its sign turned it agrees"),
    "double": (lambda s: scaled(campaign(s), 0, 2.0), r"'case 1'.*readings are 2 times.*counts_per_meter"),
    "half": (lambda s: scaled(campaign(s), 3, 0.5), r"'case 4'.*readings are 0\.5 times"),
    "amplifier": (lambda s: scaled(campaign(s), 2, 1.3), r"'case 3'.*are 1\.3 times"),
    "leads": (lambda s: shifted(campaign(s), 1, 2), r"'case 2'.*come 2 samples before its input"),
    "lags": (lambda s: shifted(campaign(s), 2, -3), r"'case 3'.*come 3 samples after its input"),
    "drifts": (lambda s: drifting(campaign(s)), r"'case 2'.*zero drifting by (19\d|20\d) µm/s"),
}


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", BROKEN)
def test_the_fit_names_the_run_and_its_mistake(kind: str, seed: int) -> None:
    make, words = BROKEN[kind]
    found = stepid.fit(make(seed))
    assert found.rms > 1.2 * found.noise
    said = [note for note in found.notes if "disagrees with the others" in note]
    assert len(said) == 1
    assert re.search(words, said[0]), said


@pytest.mark.parametrize("effects", [{}, FRICTION, {"cubic_stiffness": {"coefficient": 6e4}}])
@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_no_suspicion_where_nothing_is_wrong(effects: dict[str, dict[str, float]], seed: int) -> None:
    whole = campaign(seed, effects)
    assert [note for note in stepid.fit(whole).notes if "More than noise is left" not in note] == []
    context = prepare(whole)
    fitted = fit_effects(context, resolve(tuple(effects)))
    assert fitted is not None
    assert find_fault(context.linear, context.floor) is None
    assert find_fault(fitted, context.floor) is None


@pytest.mark.slow
def test_a_wrong_mass_beside_friction() -> None:
    whole = campaign(5, FRICTION, true_masses=(0, 0.6, 1.5, 2.0))
    found = stepid.fit(whole, effects=("coulomb_friction",))
    assert any(
        re.search(r"'case 2'.*With 0\.(60|59[5-9])\d* kg added instead of 0\.5 kg", note) for note in found.notes
    )


def test_of_two_equal_runs_it_cannot_say_which_is_wrong() -> None:
    whole = campaign(6, masses=(1, 1, 2.5, 2.5), true_masses=(1, 1.5, 2.5, 2.5), volts=(0.5,) * 4)
    notes = " ".join(stepid.fit(whole).notes)
    assert re.search(r"'case [12]', 'case [12]' have the same labels and input but differ by 1\d %", notes)
    assert re.search(r"One run disagrees with the others, 'case [12]' or 'case [12]'", notes)


def test_of_two_equal_runs_without_a_weight_the_heavier_is_wrong() -> None:
    """The other one would have less than none."""
    whole = campaign(6, masses=(0, 0, 1.5, 1.5), true_masses=(0, 0.5, 1.5, 1.5), volts=(0.5,) * 4)
    notes = " ".join(stepid.fit(whole).notes)
    assert re.search(r"'case 2' disagrees with the others.*With 0\.5\d* kg added instead of 0 kg", notes)


def test_two_runs_accuse_nobody() -> None:
    whole = campaign(7, masses=(0.0, 1.5), true_masses=(0.0, 1.0))
    context = prepare(whole)
    assert find_fault(context.linear, context.floor) is None


def test_a_constant_offset_changes_nothing() -> None:
    whole = campaign(8)
    moved = whole
    for run, offset in enumerate((0.3, -0.1, 0.0, 2.0)):
        moved = changed(moved, run, position=whole.experiments[run].position + offset)
    one, two = stepid.fit(whole), stepid.fit(moved)
    assert two.notes == ()
    for name, estimate in one.parameters.items():
        assert two.parameters[name].value == pytest.approx(estimate.value, rel=1e-5)


@pytest.mark.parametrize(("length", "volts"), [(1e-4, 1.0), (50.0, 1.0), (1.0, 1e6), (1.0, 1e-6)])
def test_units_far_from_the_lab_fit_as_well(length: float, volts: float) -> None:
    whole = campaign(9)
    other = whole
    for run, e in enumerate(whole.experiments):
        other = changed(other, run, position=e.position * length, input=e.input * volts, counts_per_meter=None)
    one, two = stepid.fit(whole), stepid.fit(other)
    assert two.notes == ()
    assert two.rms == pytest.approx(length * one.rms, rel=1e-2)
    ratio = two.parameters["force_gain"].value / one.parameters["force_gain"].value
    assert ratio == pytest.approx(length / volts, rel=2e-2)
    assert np.isfinite(two.correlation).all()
