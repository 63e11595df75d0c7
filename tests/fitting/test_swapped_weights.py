"""Added masses that are noted for each other: found by what all runs agree on with these exchanged."""

from __future__ import annotations

import pytest

import stepid
from broken_campaigns import FRICTION, campaign
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.swapped_weights import Swap, find_swap

NOTED = (0.0, 0.5, 1.5, 0.0, 1.0)
TRUE = (0.0, 1.5, 0.5, 0.0, 1.0)


def found(whole: stepid.Campaign, *names: str) -> Swap | None:
    context = prepare(whole)
    beside = fit_effects(context, resolve(names)) if names else None
    return find_swap(context.linear, beside, context.floor)


@pytest.mark.parametrize(("effects", "names"), [({}, ()), (FRICTION, ("coulomb_friction",))], ids=["plain", "friction"])
def test_masses_that_are_noted_for_each_other_are_found(
    effects: dict[str, dict[str, float]], names: tuple[str, ...]
) -> None:
    swap = found(campaign(3, effects, masses=NOTED, true_masses=TRUE), *names)
    assert swap is not None
    assert swap.runs == (1, 2)
    assert not swap.doubtful
    assert swap.optimum.problem.layout.mass(swap.optimum.shared)[0] == pytest.approx(0.95, rel=0.01)


@pytest.mark.parametrize(
    "true",
    [
        NOTED,
        (0.0, 1.2, 1.5, 0.0, 1.0),  # one is wrong, and no other's
        (0.5, 1.5, 0.0, 0.0, 1.0),  # three are mixed up
    ],
)
def test_masses_that_no_exchange_mends_are_left(true: tuple[float, ...]) -> None:
    assert found(campaign(4, masses=NOTED, true_masses=true)) is None


def test_masses_that_differ_by_less_than_they_are_known_are_not_exchanged() -> None:
    noted, true = (0.0, 0.5, 0.53, 0.0, 1.0), (0.0, 0.53, 0.5, 0.0, 1.0)
    whole = campaign(3, masses=noted, true_masses=true)
    assert found(whole.model_copy(update={"weight_uncertainty": 0.005})) is None
    swap = found(whole.model_copy(update={"weight_uncertainty": 0.001}))
    assert swap is not None
    assert swap.runs == (1, 2)


NO_TELLING = (0.0, 0.0, 1.0, 2.0), (0.0, 0.0, 1.0, 0.5)  # twice the plant, and 1 and 2 kg exchanged, is the same


def test_one_wrong_mass_that_does_as_well_leaves_an_exchange_in_doubt() -> None:
    noted, true = NO_TELLING
    swap = found(campaign(1, masses=noted, true_masses=true))
    assert swap is not None
    assert swap.runs == (2, 3)
    assert swap.doubtful


def test_the_diagnosis_tells_of_an_exchange_in_doubt() -> None:
    noted, true = NO_TELLING
    told = stepid.diagnose(campaign(1, masses=noted, true_masses=true), effort=stepid.Effort.quick())
    assert [fault.kind for fault in told.faults] == ["added_mass"]
    assert "on another plant" in told.notes[-1]
    assert "'case 3' and 'case 4'" in told.notes[-1]


def test_two_of_three_runs_agree_with_any_plant() -> None:
    assert found(campaign(5, masses=NOTED[:3], true_masses=TRUE[:3])) is None


def test_runs_of_one_mass_have_none_to_exchange() -> None:
    assert found(campaign(6, FRICTION, masses=(0.5,) * 4)) is None


def test_the_diagnosis_exchanges_them_and_says_so() -> None:
    told = stepid.diagnose(campaign(7, masses=NOTED, true_masses=TRUE), effort=stepid.Effort.quick())
    assert told.verdict == "adequate"
    assert told.parameters["base_mass"].value == pytest.approx(0.95, rel=0.01)
    sizes = {fault.run: (fault.kind, fault.size, fault.unit) for fault in told.faults}
    assert sizes == {"case 2": ("added_mass", 1.0, "kg"), "case 3": ("added_mass", -1.0, "kg")}
    assert told.data is not None
    assert [run.added_mass for run in told.data] == list(TRUE)  # the tables and the peak method take these
    said = [note for note in told.notes if "noted for each other" in note]
    assert len(said) == 1
    assert "runs 'case 2' and 'case 3'" in said[0]
