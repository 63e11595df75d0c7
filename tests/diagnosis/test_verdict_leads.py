"""What leads where a rest remains, and what is said where nothing does, on made-up evidence."""

from __future__ import annotations

import pytest

from made_up_evidence import FRICTION, LINEAR, ask, candidate
from stepid.diagnosis import vetoes
from stepid.diagnosis.constancy import CONDITIONS

PLAY = candidate(["free_play"])


@pytest.fixture(autouse=True)
def _all_is_determined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))


@pytest.mark.parametrize(("times", "words"), [(3.0, "3 times the noise floor: more is missing."), (1.0, "floor.")])
def test_a_lead_takes_most_on_runs_left_out(times: float, words: str) -> None:
    lead = candidate(["quadratic_damping"], times=times)
    found = ask("leads", lead=lead, floored=lead.names if times == 1 else ())
    assert found is not None
    assert (found.verdict, found.shown.names) == ("named", ("quadratic_damping",))
    assert "95 % of the misfit's power" in found.reasons[0]
    assert found.reasons[1].endswith(words)


def test_a_law_of_another_shape_refutes_a_lead() -> None:
    found = ask("leads", lead=candidate(["cubic_stiffness"], times=3.0), other_shape="position")
    assert found is not None
    assert (found.verdict, found.alternatives) == ("unexplained", ())
    assert found.reasons[-1] == (
        "A force of position whose law is none of the catalogue's does as well or better: no effect is named."
    )


def test_parameters_that_change_with_the_conditions_refute_a_lead() -> None:
    found = ask("leads", lead=candidate(["flexible_coupling"], times=3.0), other_shape=CONDITIONS)
    assert found is not None
    assert found.verdict == "unexplained"
    assert found.reasons[-1] == (
        "Its parameters would have to change with the added mass, the labels or the input: no effect is named."
    )


def test_a_lead_that_another_oscillation_outdoes_is_not_named() -> None:
    found = ask("leads", lead=candidate(["presliding_hysteresis"], times=3.0), outdone_by=True)
    assert found is not None
    assert (found.verdict, found.shown.names) == ("unexplained", ("presliding_hysteresis",))
    assert found.reasons[-1].startswith("A second oscillation beside the plant's own halves what is left")


def test_a_lead_is_not_named_where_a_law_of_another_state_does_nearly_as_well() -> None:
    lead, rival = candidate(["presliding_hysteresis"], times=3.0), candidate(["sine_stiffness"], times=3.5)
    found = ask("leads", lead=lead, elsewhere=rival)
    assert found is not None
    assert (found.verdict, found.alternatives) == ("unexplained", ())
    assert found.reasons[-1].startswith("Sine stiffness leaves ")
    assert found.reasons[-1].endswith("what is missing in both is more than what sets them apart. No effect is named.")


def test_what_the_data_do_not_tell_from_a_lead_is_told() -> None:
    found = ask("leads", beside_lead=(PLAY,))
    assert found is not None
    assert (found.verdict, found.shown, found.alternatives) == ("ambiguous", FRICTION, (PLAY,))
    assert "free play" in found.reasons[-1]


@pytest.mark.parametrize(
    "told",
    [
        pytest.param({"lead": LINEAR}, id="nothing leads"),
        pytest.param({"held": 0.9}, id="others weigh as much"),
        pytest.param({"share_taken": (0.8, 0.9)}, id="too little"),
        pytest.param({"share_taken": (0.95, 0.2)}, id="not in every run"),
    ],
)
def test_no_lead(told: dict[str, object]) -> None:
    assert ask("leads", **told) is None


def test_a_lead_with_an_open_parameter_is_none() -> None:
    assert ask("leads") is not None
    assert ask("leads", open_beside=("coulomb_friction.level",)) is None


def test_unexplained_always_answers() -> None:
    found = ask("unexplained", best=candidate(["cogging"], times=4.0), imitated={"cogging": "the spring"})
    assert found is not None
    assert found.verdict == "unexplained"
    assert "4 times the noise floor" in found.reasons[0]
    assert "white" not in found.reasons[0]
    assert found.reasons[1] == "Cogging cannot be told from the spring here."
    small = ask("unexplained", best=candidate(["cogging"], times=1.04))
    assert small is not None
    assert "1.04 times the noise floor, but no white noise." in small.reasons[0]
    free = ask("unexplained", best=candidate(["cogging"], times=4.0, deviations=["gain"]))
    assert free is not None
    assert free.reasons[0].startswith("The best candidate, cogging, gains differ, leaves")
    barred = ask("unexplained", best=LINEAR, lead=LINEAR)
    assert barred is not None
    assert barred.shown is LINEAR
    assert barred.reasons[0].startswith("The likeliest candidate, Coulomb friction, leaves")
    empty = ask("unexplained", best=LINEAR, lead=LINEAR, likeliest=LINEAR)
    assert empty is not None
    assert empty.reasons == ("No candidate explains the misfit.",)


@pytest.mark.parametrize(
    ("names", "share", "named"),
    [
        (["quadratic_damping"], 0.85, True),
        (["quadratic_damping"], 0.849, False),
        (["quadratic_damping", "cogging"], 0.925, True),
        (["quadratic_damping", "cogging"], 0.924, False),
    ],
)
def test_a_second_effect_of_a_lead_has_to_halve_the_rest(names: list[str], share: float, named: bool) -> None:
    lead = candidate(names, times=3.0)
    assert (ask("leads", lead=lead, share_taken=(share, 0.9)) is not None) is named
    assert (ask("leads", lead=lead, share_taken=(0.99, 0.4)) is not None) is True
    assert ask("leads", lead=lead, share_taken=(0.99, 0.399)) is None


@pytest.mark.parametrize(
    ("names", "share", "open_", "told"),
    [
        (["coulomb_friction"], 0.7, (), "Coulomb friction takes 70 %"),
        (["coulomb_friction", "cogging"], 0.9, (), "Coulomb friction and cogging take 90 %"),
        (["coulomb_friction"], 0.8499, (), "Coulomb friction takes 84 %"),
        (["coulomb_friction"], 0.5, (), None),  # what takes no more than half is no news
        (["coulomb_friction"], 0.9, (), None),  # it was not too little
        (["coulomb_friction"], 0.7, ("coulomb_friction.level",), None),
    ],
)
def test_what_takes_most_but_too_little_for_a_name_is_told(
    names: list[str], share: float, open_: tuple[str, ...], told: str | None
) -> None:
    found = ask("unexplained", best=PLAY, lead=candidate(names), share_taken=(share, 0.9), open_beside=open_)
    assert found is not None
    words = [r for r in found.reasons if "that a name needs" in r]
    assert len(words) == (told is not None)
    assert all(w.startswith(told or "") for w in words)


def test_what_is_sure_of_the_best_leads_where_its_other_effect_is_open() -> None:
    both = candidate(["coulomb_friction", "viscoelastic_spring"])
    open_: dict[str, object] = {"best": both, "undetermined": ("viscoelastic_spring.damping",), "floored": both.names}
    nothing = ask("complete_but_open", **open_, lead=PLAY)
    assert nothing is not None
    assert nothing.verdict == "unexplained"  # what leads is no part of it
    found = ask("complete_but_open", **open_, lead=PLAY, sure_part=FRICTION)
    assert found is not None
    assert (found.verdict, found.shown, found.rule) == ("named", FRICTION, "leads")
    assert found.reasons[-1].startswith(
        "Coulomb friction and viscoelastic spring leave only noise, but the data do not"
    )
    weak = ask("complete_but_open", **open_, lead=PLAY, sure_part=FRICTION, share_taken=(0.8, 0.9))
    assert weak is not None
    assert weak.verdict == "unexplained"
