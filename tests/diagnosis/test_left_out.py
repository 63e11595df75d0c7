"""What candidates take on runs left out, beside the linear plant with the same conditions and starts free."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hidden.campaigns import Request, make_campaigns
from made_up_evidence import candidate
from stepid.diagnosis import left_out
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import block_means
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.left_out import LeftOut
from stepid.diagnosis.selection.candidate import Candidate
from stepid.effects import resolve
from stepid.fitting.deviations import starts_kept, with_deviations
from stepid.fitting.fit import prepare
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import minimize


def told(hidden: tuple[str, ...], *names: str) -> tuple[EvidenceRecord, Candidate]:
    """Evidence of a campaign with hidden effects, the linear plant and one candidate in it."""
    context = prepare(make_campaigns([Request(3, hidden, None, 8.0, "four")])[0][0])
    fitted = fit_effects(context, resolve(names))
    assert fitted is not None
    found = Candidate(resolve(names), frozenset(), fitted, block_means(context, fitted))
    return EvidenceRecord(context, Criteria(), (linear_candidate(context), found)), found


def test_a_shaker_takes_what_the_starts_that_it_frees_do_not() -> None:
    e, found = told(("periodic_disturbance",), "periodic_disturbance")
    assert starts_kept(found.optimum.problem, ()) == {"start_offset", "start_velocity"}
    plain = e.left_out._with((), found)
    assert plain.problem.active[:2].sum() == found.optimum.problem.active[:2].sum()
    assert plain.cost < e.linear.optimum.cost
    assert e.share(found)[0] > 0.9
    assert e.share_of_free(found) == pytest.approx(e.share(found)[0], abs=1e-9)  # no other effect stands beside it


def test_a_shaker_that_is_not_there_takes_nothing_for_itself() -> None:
    """Beside the friction that is: together they take most of the misfit."""
    e, found = told(("coulomb_friction",), "coulomb_friction", "periodic_disturbance")
    assert e.share(found)[0] > 0.9
    assert e.share_of_free(found) < 0.5
    alone = e.left_out._with(found.effects[:1], found)
    assert [effect.name for effect in alone.problem.simulator.effects] == ["coulomb_friction"]
    assert np.isfinite(alone.cost)
    assert alone.cost < 1.1 * found.optimum.cost


def test_what_is_known_is_not_fitted_again() -> None:
    e, found = told(("coulomb_friction",), "coulomb_friction")
    conditions = starts_kept(found.optimum.problem, ())
    known = Candidate((), conditions, found.optimum, 0.0)
    assert EvidenceRecord(e.context, e.criteria, (*e.candidates, known)).left_out._with((), found) is known.optimum


def test_what_conditions_explain_is_no_misfit_of_an_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gains that differ are a part of what the linear plant with runs alike leaves, and none of what a spring takes."""
    request = Request(3, ("cubic_stiffness",), None, 3.0, "four", ("gain",))
    context = prepare(make_campaigns([request])[0][0])
    alone = fit_effects(context, resolve(["cubic_stiffness"]))
    assert alone is not None
    plain, spring = (
        minimize(with_deviations(fit.problem, ("gain",)), fit.shared, fit.local) for fit in (context.linear, alone)
    )
    assert plain is not None
    assert spring is not None
    steady = Candidate(resolve(["cubic_stiffness"]), frozenset(), alone, 0.0)
    found = Candidate(steady.effects, frozenset({"gain"}), spring, 0.0)
    e = EvidenceRecord(context, Criteria(), (linear_candidate(context), steady, found))
    part = e.left_out.part_of_effects(found)
    noise = context.floor**2
    assert part == pytest.approx((plain.rms**2 - noise) / (context.linear.rms**2 - noise), rel=1e-3)
    assert 0.1 < part < 0.95
    assert e.left_out.part_of_effects(steady) == 1.0
    monkeypatch.setattr(left_out, "minimize", None)  # what was fitted once is known
    assert e.left_out.part_of_effects(found) == part


@pytest.mark.parametrize(("free", "alike", "held"), [(3.0, 2.0, 2.0), (2.0, 3.0, 2.0)])
def test_a_candidate_is_held_against_the_linear_plant_that_predicts_more(
    free: float, alike: float, held: float
) -> None:
    """Start times that lead the linear plant astray had counted for the friction: 73 per cent, of which 30 were its."""
    told, found = (
        SimpleNamespace(criteria=Criteria(), linear=SimpleNamespace(optimum="alike")),
        candidate(["free_play"]),
    )
    out = LeftOut(told)  # type: ignore[arg-type]
    out._plain = lambda _: "free"  # type: ignore[method-assign,assignment,return-value]
    left = {"free": free, "alike": alike}
    out.of_two = lambda one, *_: ({0: np.full(9, left[one])}, {0: np.ones(9)})  # type: ignore[method-assign,assignment,index,misc]
    before, after = out.residuals(found)
    assert before[0].tolist() == [held] * 9
    assert after[0].tolist() == [1.0] * 9


@pytest.mark.parametrize(("size", "shown"), [(1.02, False), (1.1, True)])
def test_where_the_linear_plant_is_as_free_and_leaves_noise_a_share_says_nothing(size: float, shown: bool) -> None:
    """A delay of all runs beside start times that scatter: the one that was left out had told "−200 %"."""
    out = LeftOut(SimpleNamespace())  # type: ignore[arg-type]
    before = {i: np.full(300, size) for i in range(3)}  # 4 % more power than noise; chance makes 9
    out.residuals = lambda _: (before, {i: np.full(300, 3.0) for i in before})  # type: ignore[method-assign]
    out._noise = lambda _: 1.0  # type: ignore[method-assign]
    assert out.shows(candidate(["input_delay"])) is shown
