"""Each rule of the verdict on made-up evidence: when it answers, what it names, what it says."""

from __future__ import annotations

import inspect
import re
from types import SimpleNamespace
from typing import Any

import pytest

from made_up_evidence import FRICTION, LINEAR, Told, ask, candidate, context, evidence
from stepid.diagnosis import verdict, vetoes
from stepid.diagnosis.calibration import PROBABILITY
from stepid.diagnosis.constancy import CONDITIONS
from stepid.diagnosis.exchangeable import Condition
from stepid.diagnosis.gather import EvidenceRecord
from stepid.diagnosis.selection.candidate import Candidate
from stepid.diagnosis.verdict import RULES, Answer, judge

PLAY = candidate(["free_play"])


@pytest.fixture(autouse=True)
def _all_is_determined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))


def test_the_rules_stand_in_this_order() -> None:
    """The order decides answers: a rule of your own gets its place here as well."""
    names = [rule.__name__ for rule in RULES]
    assert names == [
        "input_is_wrong",
        "linear_is_enough",
        "weights_are_enough",
        "scatter_is_a_law",
        "runs_differ",
        "freedom_is_untested",
        "shape_is_patched",
        "rest_follows_the_motion",
        "complete_but_open",
        "complete",
        "leads",
        "rest_follows_nothing",
        "unexplained",
    ], "the first rule that answers decides: if the new order is meant, write it here"


def test_errors_of_the_weights_dispute_a_name_and_stand_for_none() -> None:
    known: Any = SimpleNamespace(**vars(context()) | {"by_weights": LINEAR.optimum})
    evidence: Any = Told(context=known)
    found = verdict.judge(evidence, (verdict.complete,))
    assert (found.verdict, found.alternatives, found.shown) == ("ambiguous", (), FRICTION)
    assert "added masses" in found.reasons[-1]
    assert ask("weights_are_enough") is None
    assert ask("weights_are_enough", context=known) is None  # one effect is as good
    enough = ask("weights_are_enough", context=known, undetermined=("coulomb_friction.level",))
    assert enough is not None
    assert (enough.verdict, enough.shown) == ("adequate", LINEAR)
    refuted = ask("weights_are_enough", context=known, still_followed="velocity")
    assert refuted is not None  # an effect that cannot be named does not stand before them
    late = candidate(["coulomb_friction"], deviations=["start_time"])
    assert ask("weights_are_enough", context=known, best=late) is not None  # nor one with a condition


def test_a_wrong_input_explains_nothing() -> None:
    assert ask("input_is_wrong") is None
    fault: Any = SimpleNamespace(words="The input is in another unit.")
    found = ask("input_is_wrong", input_fault=fault)
    assert found is not None
    assert (found.verdict, found.shown, found.reasons) == ("unexplained", LINEAR, ("The input is in another unit.",))


def test_a_linear_plant_that_leaves_white_noise_is_enough() -> None:
    assert ask("linear_is_enough") is None
    assert ask("linear_is_enough", white=True) is None  # ten floors are left, an effect is better
    found = ask("linear_is_enough", white=True, linear=candidate(times=1.01))
    assert found is not None
    assert found.verdict == "adequate"
    assert ask("linear_is_enough", white=True, best=LINEAR) is not None


def test_runs_that_differ_leave_a_linear_plant() -> None:
    late = candidate(deviations=["start_time", "gain"])
    assert ask("runs_differ") is None
    assert ask("runs_differ", best=LINEAR) is None
    found = ask("runs_differ", best=late)
    assert found is not None
    assert (found.verdict, found.shown) == ("adequate", late)
    assert "gain and start time" in found.reasons[0]
    assert found.reasons[1:] == ()
    beside = ask("runs_differ", best=late, rivals=(candidate(["actuator_dead_zone"], deviations=["gain"]),))
    assert beside is not None
    assert beside.reasons[1:] == ("These data do not tell that from actuator dead zone and runs that differ by less.",)


def test_what_goes_with_a_condition_is_no_scatter() -> None:
    weaker = Condition("gain", "the direction of the input", 7.0)
    unlike = candidate(deviations=["gain"])
    found = ask("scatter_is_a_law", best=unlike, lead=LINEAR, goes_with=weaker)
    assert found is not None
    assert (found.verdict, found.shown) == ("unexplained", unlike)
    assert found.reasons[-1].startswith("A linear model leaves only noise where the gain differs from run to run, but")
    leading = ask("scatter_is_a_law", goes_with=weaker)
    assert leading is not None
    assert (leading.verdict, leading.rule) == ("named", "leads")
    assert "goes with the direction of the input" in leading.reasons[-1]
    assert ask("scatter_is_a_law") is None
    assert ask("scatter_is_a_law", goes_with=weaker, floored=()) is None


def test_an_open_parameter_is_not_named() -> None:
    open_ = ("coulomb_friction.level",)
    assert ask("complete_but_open") is None
    assert ask("complete_but_open", undetermined=open_, floored=()) is None
    found = ask("complete_but_open", undetermined=open_)
    assert found is not None
    assert found.verdict == "unexplained"
    assert "the level of Coulomb friction" in found.reasons[0]
    rivaled = ask("complete_but_open", undetermined=open_, rivals=(PLAY,))
    assert rivaled is not None
    assert (rivaled.verdict, rivaled.shown, rivaled.alternatives) == ("ambiguous", PLAY, (FRICTION,))
    both = ask("complete_but_open", undetermined=open_, rivals=(PLAY,), not_nameable=(PLAY.names,), lead=LINEAR)
    assert both is not None
    assert both.verdict == "unexplained"  # a rival that is open itself is no name


def test_what_something_else_stands_in_for_is_not_named_however_little_it_leaves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bends = {"cogging": "the spring"}
    best = candidate(["cogging"])
    found = ask("complete_but_open", best=best, imitated=bends, floored=best.names, lead=LINEAR)
    assert found is not None
    assert (found.verdict, found.alternatives) == ("unexplained", ())
    assert "cogging cannot be told from the spring here" in found.reasons[0]
    beside = {"undetermined": ("cogging.pitch",), "rivals": (PLAY,), "floored": ("cogging", "free_play")}
    monkeypatch.setattr(Told, "barred", lambda self, other: other is best)
    rivaled = ask("complete_but_open", best=best, imitated=bends, **beside)
    assert rivaled is not None
    assert (rivaled.verdict, rivaled.shown, rivaled.alternatives) == ("ambiguous", PLAY, (best,))
    short = ask("complete_but_open", best=best, too_short=bends, **beside)
    assert short is not None
    assert (short.verdict, short.shown, short.alternatives) == ("named", PLAY, ())  # nothing shows the best


def test_the_only_one_at_the_floor_is_named() -> None:
    assert ask("complete", floored=()) is None
    found = ask("complete")
    assert found is not None
    assert (found.verdict, found.shown, found.alternatives) == ("named", FRICTION, ())
    assert "Coulomb friction" in found.reasons[0]


def test_rivals_are_told() -> None:
    cogging = candidate(["cogging"])
    found = ask("complete", rivals=(PLAY, cogging))
    assert found is not None
    assert (found.verdict, found.alternatives) == ("ambiguous", (PLAY, cogging))
    assert "free play or cogging" in found.reasons[1]


def test_a_freedom_in_every_run_has_to_predict() -> None:
    free = candidate(["periodic_disturbance"])
    assert ask("freedom_is_untested") is None  # nothing is free in every run
    assert ask("freedom_is_untested", best=free, share_taken=(0.5, 0.9)) is None  # a rest remains
    assert ask("freedom_is_untested", best=free, floored=free.names) is None  # it does predict
    found = ask("freedom_is_untested", best=free, floored=free.names, share_taken=(0.5, 0.9))
    assert found is not None
    assert (found.verdict, found.shown) == ("unexplained", free)
    assert "takes 50 % of the misfit's power" in found.reasons[0]


def test_what_cannot_be_named_beside_a_lead_does_not_hide_it() -> None:
    lead, both = candidate(["quadratic_damping"], times=1.4), candidate(["quadratic_damping", "flexible_coupling"])
    found = ask("complete_but_open", best=both, lead=lead, undetermined=("flexible_coupling.mass",), floored=both.names)
    assert found is not None
    assert (found.verdict, found.shown, found.rule) == ("named", lead, "leads")
    assert "do not determine the mass of flexible coupling" in found.reasons[-1]
    other = candidate(["cogging"], times=1.4)  # a lead that the best does not hold
    found = ask(
        "complete_but_open", best=both, lead=other, undetermined=("flexible_coupling.mass",), floored=both.names
    )
    assert found is not None
    assert found.verdict == "unexplained"


def test_open_freedom_does_not_dispute_a_name_nor_earn_one() -> None:
    found = ask("complete", rivals=(PLAY,), stood_for=(("free_play",),))
    assert found is not None
    assert (found.verdict, found.alternatives) == ("named", (PLAY,))
    found = ask("complete_but_open", best=PLAY, undetermined=("free_play.gap",), simpler=(FRICTION,))
    assert found is not None
    assert (found.verdict, found.shown, found.alternatives) == ("ambiguous", FRICTION, (PLAY,))
    assert found.reasons[-1].startswith("Coulomb friction leaves 10.0 µm, 1 times the noise floor")
    told: dict[str, Any] = {"best": PLAY, "undetermined": ("free_play.gap",), "simpler": (FRICTION,), "lead": LINEAR}
    beyond = ask("complete_but_open", **told, floored=PLAY.names, still_followed="velocity")
    assert beyond is not None  # what a simpler law leaves beyond the noise is what the open one has beyond it
    assert (beyond.verdict, beyond.shown) == ("ambiguous", FRICTION)
    noise = ask("complete_but_open", **told, floored=(*PLAY.names, *FRICTION.names), still_followed="velocity")
    assert noise is not None
    assert noise.verdict == "unexplained"


def test_three_laws_of_one_state_name_none() -> None:
    three = candidate(["cubic_stiffness", "end_stop", "quadratic_stiffness"])
    found = ask("shape_is_patched", best=three, floored=three.names, other_shape="position")
    assert found is not None
    assert found.verdict == "unexplained"
    assert "a law of any shape" in found.reasons[-2]
    assert ask("shape_is_patched", best=three, floored=three.names) is None


def test_what_is_left_has_to_be_noise_and_not_only_small() -> None:
    found = ask("rest_follows_the_motion", still_followed="velocity", lead=LINEAR)
    assert found is not None
    assert (found.verdict, found.shown, found.alternatives) == ("unexplained", FRICTION, ())
    assert found.reasons[-1].endswith("what is left follows velocity: its law is another, or more is missing.")
    leading = ask("rest_follows_the_motion", still_followed="velocity")
    assert leading is not None
    assert (leading.verdict, leading.rule) == ("named", "leads")
    assert leading.reasons[-1] == found.reasons[-1]
    changing = ask("rest_follows_the_motion", still_followed=CONDITIONS, lead=LINEAR)
    assert changing is not None
    assert "what is left changes with added mass, labels and input: its law is another" in changing.reasons[-1]
    assert ask("rest_follows_the_motion") is None
    assert ask("rest_follows_the_motion", still_followed="velocity", floored=()) is None


def test_the_first_rule_that_answers_decides() -> None:
    told = Told()
    found = judge(told)  # type: ignore[arg-type]
    assert (found.verdict, found.rule) == ("named", "complete")
    assert "10 times the noise floor" in found.reasons[0]
    assert judge(Told(floored=(), share_taken=(0.0, 0.0))).rule == "unexplained"  # type: ignore[arg-type]


def test_a_rule_of_ones_own_comes_in_its_place() -> None:
    def never(e: EvidenceRecord) -> Answer:
        return Answer("unexplained", e.linear, (), ("I do not believe it.",))

    found = judge(Told(), (never, *RULES))  # type: ignore[arg-type]
    assert (found.verdict, found.rule, found.reasons[1]) == ("unexplained", "never", "I do not believe it.")


def test_every_rule_that_names_has_its_probability() -> None:
    naming = {rule.__name__ for rule in RULES if re.search('"(named|ambiguous)"', inspect.getsource(rule))}
    assert set(PROBABILITY) == naming, "`PROBABILITY`: the share of a rule's answers that are right, from the benchmark"
    e = evidence(FRICTION)
    for rule in naming:
        assert 0.5 < PROBABILITY[rule] <= 1
        assert e.probability(Answer("named", FRICTION, (), (), rule)) == PROBABILITY[rule]
    assert e.probability(Answer("adequate", LINEAR, (), (), "linear_is_enough")) is None


def test_a_freedom_that_is_untested_hides_no_lead_inside_it() -> None:
    lead = candidate(["quadratic_damping"], times=1.4)
    both = candidate(["quadratic_damping", "periodic_disturbance"])

    class TestedApart(Told):
        def share(self, found: Candidate) -> tuple[float, float]:
            return (0.5, 0.9) if found is both else (0.95, 0.9)

    found = verdict.freedom_is_untested(TestedApart(best=both, lead=lead, floored=both.names))
    assert found is not None
    assert (found.verdict, found.shown, found.rule) == ("named", lead, "leads")
    alike = candidate(["quadratic_damping", "cogging"], times=1.4)  # as many effects: no smaller answer
    found = verdict.freedom_is_untested(TestedApart(best=both, lead=alike, floored=both.names))
    assert found is not None
    assert (found.verdict, found.shown) == ("unexplained", both)


def test_where_no_effect_earns_its_price_the_linear_plant_is_enough() -> None:
    plain = evidence(candidate(times=1.01))
    answer = verdict.runs_differ(plain)
    assert answer is not None
    assert (answer.verdict, answer.shown) == ("adequate", plain.linear)
    assert answer.reasons == ("No effect earns what its parameters cost.",)


def test_rules_that_leave_a_case_open_are_a_mistake() -> None:
    with pytest.raises(AssertionError, match="the last rule answers always"):
        judge(evidence(FRICTION), rules=(lambda _: None,))
