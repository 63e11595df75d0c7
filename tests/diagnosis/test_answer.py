"""Diagnoses of small campaigns: what an answer carries, that it is the same again; moves and effects of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import stepid
from broken_campaigns import FRICTION, SAMPLE_TIME, campaign
from scattered_campaigns import scattered
from stepid.diagnosis import answer
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.diagnose import diagnose
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.progress import Progress
from stepid.diagnosis.selection.effort import Effort
from stepid.diagnosis.selection.moves import Moves
from stepid.diagnosis.selection.proposal import Node, Proposal, SearchContext, standing
from stepid.diagnosis.selection.search import Search
from stepid.effects import CATALOGUE, Effect, Moment, Parameter, Scales, resolve
from stepid.effects.base import Values
from stepid.fitting.fit import prepare

SMALL = (0.0, 0.5, 1.5)  # kg
FEW = resolve(["coulomb_friction", "quadratic_damping", "cubic_stiffness", "free_play"])


@cache
def friction() -> stepid.Campaign:
    return campaign(1, FRICTION, masses=SMALL)


@cache
def named() -> stepid.Diagnosis:
    return stepid.diagnose(friction())


@cache
def plain() -> stepid.Diagnosis:
    return stepid.diagnose(campaign(1, masses=SMALL))


# ---- what an answer carries ---------------------------------------------------------------------------------------


def test_a_named_effect_explains_most_and_leaves_little() -> None:
    d = named()
    assert (d.verdict, d.effects) == ("named", ("coulomb_friction",))
    assert d.explained is not None
    assert d.gap.held_out is not None
    before, after = d.gap.held_out
    assert d.explained == pytest.approx(1 - (after / before) ** 2)
    assert 0.9 < d.explained <= 1
    motion = np.concatenate([r.measured - np.median(r.measured[:10]) for r in d.runs])
    assert d.left == pytest.approx(100 * d.gap.after / np.sqrt(np.mean(motion**2)), rel=0.3)
    assert d.probability is not None
    assert 0.5 < d.probability <= 1
    assert d.faults == ()
    assert set(d.scatter) <= {"rest"}


def test_an_adequate_answer_explains_nothing_and_has_no_probability() -> None:
    d = plain()
    assert (d.verdict, d.effects, d.probability) == ("adequate", (), None)
    assert d.explained == pytest.approx(0.0, abs=1e-9)
    assert 0 < d.left < 1


def test_the_ranking_is_by_evidence_and_holds_the_linear_plant() -> None:
    ranking = named().ranking
    assert ranking[0].evidence == 0
    assert [r.evidence for r in ranking] == sorted(r.evidence for r in ranking)
    assert sum(r.probability for r in ranking) == pytest.approx(1.0)
    assert () in [r.effects for r in ranking if not r.deviations]
    first = next(r for r in ranking if r.effects == ("coulomb_friction",))
    assert first.explained > 0.9
    assert first.parameters["coulomb_friction.level"] == pytest.approx(0.2, rel=0.05)


def test_runs_that_differ_are_told() -> None:
    late = (0.6, -0.5, 0.3, -0.7, 0.4, -0.1)
    d = stepid.diagnose(scattered(1, late=late))
    assert (d.verdict, d.effects) == ("adequate", ())
    told = d.scatter["start_time"]
    assert told.unit == "s"
    assert told.deviation == pytest.approx(SAMPLE_TIME * np.std(late, ddof=1), rel=0.2)
    assert told.explained > 0.5
    assert any("The runs start within" in note for note in d.notes)
    assert stepid.Diagnosis.model_validate_json(d.model_dump_json()) == d


def test_what_runs_differ_by_is_no_part_of_what_effects_explain() -> None:
    """On runs left out the linear plant may differ likewise: it would leave as much as the answer does."""
    d = stepid.diagnose(scattered(1, gain=(0.05, -0.04, 0.03, -0.05, 0.02, -0.01)))
    assert (d.verdict, d.effects) == ("adequate", ())
    assert d.gap.after < 0.5 * d.gap.before
    assert d.explained == pytest.approx(0.0, abs=1e-9)


def test_the_copy_of_a_run_at_fault_does_not_take_its_place() -> None:
    whole = campaign(2, true_masses=(0, 0.5, 2.0, 2.0))
    copy = whole.experiments[2].model_copy(update={"name": "copy"})
    d = stepid.diagnose(whole.model_copy(update={"experiments": (*whole.experiments, copy)}))
    assert [(fault.run, fault.kind) for fault in d.faults] == [("case 3", "added_mass")]
    assert [r.name for r in d.runs] == ["case 1", "case 2", "case 4"]


def test_a_fault_is_told_with_its_size_and_the_run_left_out() -> None:
    whole = campaign(2, true_masses=(0, 0.5, 2.0, 2.0))
    d = stepid.diagnose(whole)
    (fault,) = d.faults
    assert (fault.run, fault.kind, fault.unit) == ("case 3", "added_mass", "kg")
    assert fault.size == pytest.approx(0.5, abs=0.02)
    assert fault.words in d.notes
    assert [r.name for r in d.runs] == ["case 1", "case 2", "case 4"]
    assert d.data == whole


# ---- the same again, and cancelled --------------------------------------------------------------------------------


def test_the_same_input_has_the_same_answer() -> None:
    again, first = stepid.diagnose(friction()), named()
    assert (again.verdict, again.effects, again.reasons) == (first.verdict, first.effects, first.reasons)
    assert [r.effects for r in again.ranking] == [r.effects for r in first.ranking]
    for name, value in first.parameters.items():
        assert again.parameters[name].value == pytest.approx(value.value, rel=1e-9)
    for one, two in zip(again.ranking, first.ranking, strict=True):  # what is nearly open may round otherwise
        assert one.evidence == pytest.approx(two.evidence, rel=1e-6, abs=1e-3)


def test_the_order_of_the_catalogue_is_no_difference() -> None:
    one, two = (diagnose(friction(), catalogue=some) for some in (FEW, FEW[::-1]))
    assert (one.verdict, one.effects, one.alternatives) == (two.verdict, two.effects, two.alternatives)
    assert one.gap.after == pytest.approx(two.gap.after, rel=1e-4)


def test_progress_is_told_in_words_and_numbers() -> None:
    told: list[Progress] = []
    diagnose(friction(), catalogue=FEW, progress=told.append)
    assert [str(p) for p in told][-1] == "runs held out"
    assert "linear fit" in told
    assert "coulomb_friction" in told
    assert told[-1].best == ("coulomb_friction",)
    assert told[0].best == ()
    searching = [p for p in told if p.left]
    assert searching
    assert all(isinstance(p, str) and p.left >= 0 and 0 <= p.promise <= 1 for p in told)
    assert max(p.promise for p in searching) > 0.3


def test_progress_of_ones_own() -> None:
    p = Progress("free play", best=("cogging",), left=3, promise=0.5)
    assert (str(p), p.best, p.left, p.promise) == ("free play", ("cogging",), 3, 0.5)
    assert (Progress("x").best, Progress("x").left, Progress("x").promise) == ((), 0, 0.0)


class CancelledError(Exception):
    """What a user's progress raises."""


@pytest.mark.parametrize("when", ["linear fit", "coulomb_friction", "runs held out"])
def test_an_exception_in_progress_cancels(when: str) -> None:
    def progress(p: Progress) -> None:
        if p == when:
            raise CancelledError

    with pytest.raises(CancelledError):
        diagnose(friction(), catalogue=FEW, progress=progress)
    assert diagnose(friction(), catalogue=FEW).effects == ("coulomb_friction",)


@pytest.mark.parametrize("effort", [Effort.quick(), Effort().scaled(2), Effort.thorough()])
def test_the_effort_changes_no_plain_answer(effort: Effort) -> None:
    d = diagnose(friction(), catalogue=FEW, effort=effort)
    assert (d.verdict, d.effects) == ("named", ("coulomb_friction",))


def test_criteria_change_an_answer() -> None:
    d = diagnose(friction(), catalogue=FEW, criteria=Criteria(open=1e-4))
    assert d.verdict == "unexplained"
    assert any("do not determine" in reason for reason in d.reasons)


# ---- from outside -------------------------------------------------------------------------------------------------


class HeldByTape(Effect):
    """Friction by another name, from outside the package."""

    name = "held_by_tape"
    parameters = (Parameter("force", "N"),)
    law = "+F sign(v)"
    advice = "take the tape off"
    dry = True
    reverses = True

    def starts(self, scales: Scales) -> Sequence[tuple[float, ...]]:
        """Shares of the largest spring force."""
        return [(share * scales.force,) for share in (0.02, 0.05, 0.1)]

    @staticmethod
    def friction(p: Values, m: Moment) -> float:
        """Of the same size whatever the velocity."""
        return p[0]


def test_an_effect_from_outside_is_named() -> None:
    others = tuple(e for e in CATALOGUE if not e.dry)
    d = diagnose(friction(), catalogue=(*others, HeldByTape()))
    assert (d.verdict, d.effects) == ("named", ("held_by_tape",))
    assert d.parameters["held_by_tape.force"].value == pytest.approx(0.2, rel=0.05)
    assert d.advice == {"held_by_tape": "take the tape off"}


class AskAFriend:
    """A move from outside: proposes one effect that the others were not allowed to."""

    name = "ask a friend"

    def __init__(self, effect: Effect) -> None:
        self.effect = effect

    def propose(self, node: Node, context: SearchContext) -> list[Proposal]:
        """Propose it on the linear plant."""
        if node.effects:
            return []
        here = standing(node)
        start = here._replace(values=(*here.values, (0.1,)))
        return [
            Proposal((self.effect,), node.deviations, (start,), node.key, node.best, 0.1 * node.cost, move=self.name)
        ]


def test_a_move_from_outside_is_made() -> None:
    (coulomb,) = resolve(["coulomb_friction"])
    context, moves = prepare(friction()), Moves(exploring=(*Moves().exploring, AskAFriend(coulomb)))
    found = Search(context, resolve(["quadratic_damping"]), criteria=Criteria(), effort=Effort(), moves=moves).run()
    assert found[0].names == ("coulomb_friction",)
    assert found[0].optimum.rms < 1.05 * context.floor


def test_a_search_of_nothing_is_the_linear_plant() -> None:
    context = prepare(friction())
    found = Search(context, (), criteria=Criteria(), effort=Effort()).run()
    assert all(c.effects == () for c in found)
    assert linear_candidate(context).optimum is context.linear


def test_the_search_counts_what_is_left() -> None:
    context = prepare(friction())
    seen: list[tuple[int, float, int]] = []
    one = Search(
        context,
        FEW,
        criteria=Criteria(),
        effort=Effort(fits=3, rounds=2),
        tell=lambda s, p: seen.append((s.queue.left, s.queue.promise, s.fits.count)),
    )
    one.run()
    assert all(left >= 0 and 0 <= promise <= 1 for left, promise, _ in seen)
    assert [fits for *_, fits in seen] == list(range(1, len(seen) + 1))
    assert one.standings.best.names == ("coulomb_friction",)


def test_what_was_left_out_of_a_record_is_told_once() -> None:
    clean = campaign(1, masses=SMALL)
    first, *others = clean.experiments
    wrong = first.position.copy()
    wrong[[200, 201]] += 5e-3
    spoiled = clean.model_copy(update={"experiments": (first.model_copy(update={"position": wrong}), *others)})
    notes = stepid.diagnose(spoiled).notes
    assert sum("stand out" in note for note in notes) == 1
    assert len(set(notes)) == len(notes)


@pytest.mark.parametrize(("masses", "asked"), [((0.0, 0.0, 0.5), False), ((0.0, 0.5, 1.5), True)])
def test_repeats_are_asked_for_where_there_are_none(masses: tuple[float, ...], asked: bool) -> None:
    plain = prepare(campaign(1, masses=masses, volts=(0.5,) * 3))
    evidence, unexplained = SimpleNamespace(context=plain, input_fault=None), SimpleNamespace(verdict="unexplained")
    unexplained.alternatives = ()
    told = answer._next(evidence, unexplained)  # type: ignore[arg-type]
    assert told is not None
    assert told.startswith("Repeat one run") is asked
    assert told.endswith("Record a free release and a step the other way.")
