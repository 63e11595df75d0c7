"""What is explored: nothing that the records cannot hold, and no accusation that ends in no answer."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stepid
from made_up_evidence import candidate, context
from scattered_campaigns import scattered
from stepid import Criteria, Effort
from stepid.diagnosis import diagnose, explore
from stepid.diagnosis.selection.candidate import Candidate
from stepid.effects import CATALOGUE, resolve
from stepid.effects.drive import acts_on_input
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.record_fault import RecordFault
from stepid.fitting.run_fault import Accusation

OF_THE_DRIVE = {"actuator_lag", "input_delay", "actuator_dead_zone", "actuator_saturation", "actuator_rate_limit"}


def test_effects_of_the_drive_are_those_that_change_the_input() -> None:
    assert {e.name for e in CATALOGUE if acts_on_input(e)} == OF_THE_DRIVE


@pytest.mark.parametrize("driven", [False, True])
def test_where_nothing_is_driven_no_effect_of_the_drive_is_looked_for(
    driven: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[set[str]] = []

    def search(_: object, catalogue: Any, **__: object) -> Any:
        asked.append({e.name for e in catalogue})
        return SimpleNamespace(run=list)

    monkeypatch.setattr(explore, "Search", search)
    context: Any = SimpleNamespace(records=SimpleNamespace(driven=np.array([False, driven])))
    explore._search(context, CATALOGUE, Criteria(), Effort(), lambda _: None)
    assert asked == [{e.name for e in CATALOGUE} - (set() if driven else OF_THE_DRIVE)]


@pytest.mark.parametrize(
    ("beside", "without", "left_out"),
    [
        ("effects", "adequate", True),
        ("effects", "named", True),
        ("effects", "unexplained", False),
        ("the_plant", "unexplained", True),
    ],
)
def test_an_accusation_beside_effects_that_ends_in_no_answer_is_taken_back(
    beside: str, without: str, left_out: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a run was accused beside explains nothing then: a linear plant is diagnosed with all its runs."""
    fault = RecordFault(run="case 2", kind="gain", size=1.1, unit="", words="Run 'case 2' disagrees.")
    rest = SimpleNamespace(verdict=without)
    monkeypatch.setattr(diagnose, f"fault_beside_{beside}", lambda *_: fault)
    monkeypatch.setattr(diagnose, "_anew", lambda *_: rest)
    found: Any = stepid.diagnose(scattered(1))
    assert (found is rest) is left_out
    assert left_out or ((found.verdict, found.faults) == ("adequate", ()) and len(found.runs) == 6)


def test_the_single_effect_that_leaves_least_with_all_runs_alike() -> None:
    alone = candidate(["end_stop"], times=3.0)
    freer = replace(candidate(["end_stop"], times=1.5), deviations=frozenset({"gain"}))
    every = (candidate(times=9.0), candidate(["cogging"], times=4.0), alone, freer, candidate(["cogging", "end_stop"]))
    context: Any = None
    assert explore.Found(context, every).single == [alone]
    assert explore.Found(context, every[:1]).single == []


def test_a_fault_is_held_against_fewer_effects_and_conditions() -> None:
    def fewer(names: list[str], *kinds: str) -> list[tuple[str, ...]]:
        return explore._fewer(replace(candidate(names), deviations=frozenset(kinds)))

    both = ["cogging", "end_stop"]
    assert fewer([]) == fewer([], "gain") == fewer(["stribeck_friction"]) == []
    assert fewer(["stribeck_friction"], "gain") == [("stribeck_friction",), ("coulomb_friction",)]
    assert fewer(both) == [("cogging",), ("end_stop",)]
    assert fewer(both, "gain")[0] == ("cogging", "end_stop")
    assert len(fewer([*both, "free_play"])) == 6
    assert fewer(["cogging", "stribeck_friction"])[-1] == ("coulomb_friction",)  # the simpler law inside one of them


@pytest.mark.parametrize(
    ("costs", "told"), [((3.0, 1.0), "end_stop"), ((1.0, 3.0), "cogging"), ((3.0, None), "cogging")]
)
def test_of_a_fault_beside_several_sets_that_of_most_evidence_is_told(
    monkeypatch: pytest.MonkeyPatch, costs: tuple[float | None, ...], told: str
) -> None:
    """Not that of the first set beside which there is one."""
    both, *single = (candidate(names, times=9.0) for names in (["cogging", "end_stop"], ["cogging"], ["end_stop"]))
    left = dict(zip((id(one.optimum) for one in single), costs, strict=True))
    names = {id(one.optimum): one.names[0] for one in single}

    def accuse(plain: Optimum, *_: object, **__: object) -> Accusation | None:
        cost = left[id(plain)]
        fault = RecordFault(run=names[id(plain)], kind="gain", size=0.5, unit="", words="half")
        return None if cost is None else Accusation(fault, cost * both.optimum.cost / 100)

    monkeypatch.setattr(explore, "accuse", accuse)
    monkeypatch.setattr(explore, "_alike", lambda found, some: next(c.optimum for c in single if c.names == some))
    monkeypatch.setattr(explore.Found, "likeliest", both)
    found = explore.fault_beside(explore.Found(context(), (both, *single)), Criteria())
    assert found is not None
    assert found.run == told


def test_another_look_at_the_readings_that_leaves_the_effects_is_the_last() -> None:
    def found(name: str, times: float, *kinds: str) -> explore.Found:
        return explore.Found(context(), (replace(candidate([name], times=times), deviations=frozenset(kinds)),))

    def stands(before: explore.Found, after: explore.Found) -> bool:
        return explore._stands(before, after, Criteria())

    noise, rest = found("cogging", 1.0), found("cogging", 3.0)
    assert stands(noise, found("cogging", 1.0, "gain"))  # which conditions differ names nothing
    assert not stands(noise, found("end_stop", 1.0))
    assert stands(rest, noise)
    assert stands(rest, rest)
    assert not stands(noise, rest)  # a rest has come to light


@pytest.mark.parametrize(
    ("names", "plain", "left", "outweighed"),
    [
        ([], 9.0, 1.0, True),  # the likeliest is the linear plant, and the fault explains what it leaves
        ([], 9.0, 9.0, False),
        (["quadratic_damping"], 9.0, 0.9, True),  # better than one effect by more than a tie
        (["quadratic_damping"], 9.0, 1.0, False),  # as good: one effect in the whole plant is the likelier
        (["cogging", "end_stop"], 9.0, 1.0, True),  # two are needed for one fault
    ],
)
def test_a_fault_outweighs_by_what_it_leaves(names: list[str], plain: float, left: float, outweighed: bool) -> None:
    """Times the floor that the linear plant leaves, and one fault beside it."""
    linear = candidate(times=plain)
    best = candidate(names) if names else linear
    found = explore.Found(context(), (linear, best) if names else (linear,))
    cost = linear.optimum.cost * (left / plain) ** 2
    assert explore.outweighs(cost, linear.optimum, found, Criteria()) is outweighed


def test_runs_that_the_search_left_at_rest_stay_so_when_the_readings_are_looked_at_again() -> None:
    """With friction a cart may begin off its rest: that freedom costs as much as a further effect does."""
    seen = prepare(scattered(1, level=0.4))
    fitted = fit_effects(seen, resolve(["coulomb_friction"]))
    assert fitted is not None
    held = replace(fitted.problem, active=np.zeros_like(fitted.problem.active))
    rested = minimize(held, fitted.shared, np.zeros_like(fitted.local))
    assert rested is not None
    weight = seen.records.weight.copy()
    weight[100] = 0.0
    again: Any = SimpleNamespace(
        records=seen.records.reweighted(weight),
        workers=1,
        tolerance=seen.tolerance,
        floor=seen.floor,
        period=seen.period,
    )
    (found,) = explore._fitted_again(again, (Candidate(resolve(["coulomb_friction"]), frozenset(), rested, 0.0),))
    assert not found.optimum.problem.active[:2].any()


def test_the_readings_are_looked_at_again_where_that_left_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """What one look finds, as colored noise, can hide what the next one does, as two wrong readings."""
    looks = [context() for _ in range(4)]
    found = candidate(["cogging"])
    searches: list[Any] = []

    def refined(seen: Any, *_: object) -> Any:
        at = looks.index(seen)
        return looks[at + 1] if at < 2 else None

    monkeypatch.setattr(explore, "linear_candidate", lambda _: candidate(times=9.0))
    monkeypatch.setattr(explore, "_search", lambda seen, *_: searches.append(seen) or [found])
    monkeypatch.setattr(explore, "refined", refined)
    monkeypatch.setattr(explore, "_fitted_again", lambda _, candidates: candidates)
    done = explore.explored(looks[0], (), Criteria(), Effort(), lambda _: None)
    assert done.context is looks[2]
    assert searches == [looks[0]]
