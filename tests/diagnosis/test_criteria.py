"""Every number of `Criteria` decides something: each is varied here, and what it decides turns over."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from broken_campaigns import campaign
from made_up_evidence import FLOOR, RUNS, SAMPLES, Kept, Told, candidate, context, evidence, losing, white
from stepid.core.estimate import Estimate
from stepid.diagnosis import gather, refutation, vetoes
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.free_law import FreeLaw
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.verdict import leads, linear_is_enough
from stepid.effects import resolve
from stepid.fitting.fit import prepare
from stepid.fitting.run_fault import find_fault


class Case(NamedTuple):
    """Two values of a number and what they decide."""

    one: float
    says: object
    other: float
    then: object
    decide: Callable[[Criteria], object]


def rivals(loss: float, names: tuple[str, ...], *, best: tuple[str, ...] = ("coulomb_friction",)) -> Any:
    """Whether a candidate of a QBIC larger by `loss` is a rival of the best."""

    def decide(criteria: Criteria) -> bool:
        first = candidate(best)
        e = evidence(first, losing(first, loss, names), criteria=criteria)
        return [c.names for c in e.rivals] == [names]

    return decide


def further(criteria: Criteria) -> int:
    """How many effects the best has where a second one decreases QBIC by 14."""
    two = candidate(["coulomb_friction", "cubic_stiffness"])
    return len(evidence(two, losing(two, 14.0, ["coulomb_friction"]), criteria=criteria).best.effects)


def rival(criteria: Criteria) -> bool:
    """Whether a more general law is a rival whose freedom gains 5.5 of χ²."""
    simple = candidate(["quadratic_damping"], times=1.0)
    cost = simple.optimum.cost - 5.5 * FLOOR**2
    general = candidate(["power_damping"], times=float(np.sqrt(cost / (RUNS * SAMPLES))) / FLOOR)
    return bool(evidence(simple, general, criteria=criteria).rivals)


def faint(criteria: Criteria) -> str:
    """The verdict on a linear plant at 1.02 floors beside an effect that is better."""
    e: Any = Told(white=True, best=candidate(["cubic_stiffness"]), linear=candidate(times=1.02), criteria=criteria)
    answer = linear_is_enough(e)
    return answer.verdict if answer else ""


def lead(*, share: float = 0.9, steady: float = 0.6, weight: float = 0.97) -> Callable[[Criteria], bool]:
    """Whether an effect leads that takes such a share on runs left out, as steadily, with such a weight."""

    def decide(criteria: Criteria) -> bool:
        found = candidate(["quadratic_damping"], times=3.0)
        e: Any = Told(lead=found, criteria=criteria, held=weight, share_taken=(share, steady))
        return leads(e) is not None

    return decide


def rough(criteria: Criteria) -> str:
    """The state whose law refutes a lead that leaves 2 % of the misfit to a law of another shape."""
    told: Any = context()
    told.coarse_linear, told.noise_cost = SimpleNamespace(cost=101.0), 1.0
    law = FreeLaw("velocity", share=0.8, power=2.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(refutation, "free_laws", lambda *_: (law,))
        patch.setattr(gather, "states_of_all", lambda *_: (frozenset({"velocity"}),))
        return EvidenceRecord(told, criteria, (candidate(),)).refuted(candidate(["quadratic_damping"], times=3.0))


def shape(criteria: Criteria) -> str:
    """The state that what is as small as the noise follows where a law of it takes four deviates beyond chance."""
    law = FreeLaw("velocity", share=0.1, power=1e-12, beyond=4.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stepid.diagnosis.free_law.free_laws", lambda *_: (FreeLaw("position", 0.9, 1.0), law))
        return evidence(candidate(["coulomb_friction"]), criteria=criteria).followed(candidate(["coulomb_friction"]))


def open_parameters(criteria: Criteria) -> tuple[str, ...]:
    """Parameters that are not determined where one is known to a third."""
    return vetoes.undetermined(context(), criteria, candidate(["coulomb_friction"]))


@cache
def small() -> Any:
    """A linear campaign of 3.7 s runs at 9 to 15 rad/s, that moves by about 4 cm."""
    return prepare(campaign(1, masses=(0.0, 0.5, 1.0)))


def imitates(name: str, *values: float) -> Callable[[Criteria], bool]:
    """Whether an effect at such values cannot be told from a linear parameter; lengths and rates as for `small`."""

    def decide(criteria: Criteria) -> bool:
        linear, effects = small().linear, resolve([name])
        layout = replace(linear.problem.layout, effects=effects)
        optimum: Any = Kept(
            problem=SimpleNamespace(layout=layout, records=None),
            shared=np.concatenate([linear.shared, values]),
            cost=2.0 * small().noise_limit,
        )
        return bool(vetoes.imitators(small(), criteria, Candidate(effects, frozenset(), optimum, 0.0)))

    return decide


def first(criteria: Criteria) -> float:
    """Share of the runs left out that judges where a condition is free in them."""
    linear = linear_candidate(small())
    free = replace(linear, deviations=frozenset({"gain"}))
    _, after = EvidenceRecord(small(), criteria, (linear, free)).left_out.residuals(free)
    run = small().records.runs[next(iter(after))]
    return round(next(iter(after.values())).size / run.time.size, 2)


@cache
def heavier() -> Any:
    return prepare(campaign(1, true_masses=(0, 0.5, 1.6, 2.0)))


def size(criteria: Criteria) -> bool:
    """Whether a run is accused whose mass is 0.1 kg more than it should be."""
    return find_fault(heavier().linear, heavier().floor, sure=criteria.size) is not None


CASES: Mapping[str, Case] = {
    "tie": Case(10.0, True, 4.0, False, rivals(7.0, ("free_play",))),
    "further": Case(16.0, 1, 11.0, 2, further),
    "rival": Case(5.0, True, 20.0, False, rival),
    "white": Case(5.0, True, 3.0, False, lambda c: at_floor(context(), c, candidate(structure=4.0))),
    "floor": Case(1.12, True, 1.01, False, lambda c: at_floor(context(), c, slow(1.12))),
    "near": Case(1.15, True, 1.05, False, lambda c: at_floor(context(), c, candidate(times=1.2))),
    "faint": Case(1.05, "adequate", 1.01, "", faint),
    "open": Case(0.5, (), 0.2, ("coulomb_friction.level",), open_parameters),
    "lead": Case(0.85, True, 0.95, False, lead()),
    "sure": Case(0.95, True, 0.99, False, lead()),
    "rough": Case(0.01, "velocity", 0.05, "", rough),
    "steady": Case(0.4, True, 0.8, False, lead()),
    "first": Case(0.4, 0.6, 0.7, 0.3, first),
    "resolution": Case(0.8, True, 0.05, False, imitates("periodic_disturbance", 0.1, 4.0)),
    "pitch": Case(0.5, True, 20.0, False, imitates("cogging", 0.1, 0.1, 0.0)),
    "slow": Case(20.0, True, 1000.0, False, imitates("viscoelastic_spring", 10.0, 100.0)),
    "fast": Case(0.05, True, 0.001, False, imitates("viscoelastic_spring", 1000.0, 1.0)),
    "swings": Case(1.0, True, 0.1, False, imitates("periodic_disturbance", 0.1, 0.2)),
    "shape": Case(3.5, "velocity", 4.5, "", shape),
    "size": Case(5.0, True, 1e4, False, size),
}


def slow(times: float) -> Candidate:
    """A residual that is not white, of so many times the floor."""
    return candidate(times=times, residual=white() + FLOOR * np.sin(0.2 * np.arange(RUNS * SAMPLES)))


@pytest.fixture(autouse=True)
def _known_to_a_third(monkeypatch: pytest.MonkeyPatch) -> None:
    known = {"coulomb_friction.level": Estimate(value=1.0, uncertainty=0.3, unit="N")}
    monkeypatch.setattr(vetoes, "estimates", lambda *_: (known, None))
    monkeypatch.setattr(gather, "imitators", lambda *_: {})


@pytest.mark.parametrize("name", Criteria.model_fields)
def test_a_number_decides(name: str) -> None:
    assert name in CASES, f"{name}: add a `Case` to `CASES`: two values of it between which an answer turns over"
    case = CASES[name]
    assert case.decide(Criteria(**{name: case.one})) == case.says
    assert case.decide(Criteria(**{name: case.other})) == case.then


def test_no_case_is_left_of_a_number_that_is_gone() -> None:
    assert set(CASES) - set(Criteria.model_fields) == set()


def test_numbers_out_of_bounds_are_refused() -> None:
    for wrong in ({"tie": 0.0}, {"floor": 0.9}, {"sure": 1.1}, {"unheard_of": 1.0}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            Criteria(**wrong)
