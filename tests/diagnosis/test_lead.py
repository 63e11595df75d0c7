"""What may lead: a part of the best, and what another oscillation outdoes, on made-up evidence."""

from __future__ import annotations

from dataclasses import replace

import pytest

from made_up_evidence import LINEAR, candidate, evidence, losing
from stepid.diagnosis import gather, vetoes
from stepid.effects.swing import OWN


@pytest.fixture(autouse=True)
def _all_is_determined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vetoes, "estimates", lambda *_: ({}, None))


@pytest.mark.parametrize(
    ("names", "free", "lead", "times", "words", "outdone"),
    [
        (["flexible_coupling"], (), 5.0, 2.0, OWN, True),
        (["flexible_coupling"], (), 1.2, 1.08, OWN, False),  # less than real laws are rough
        (["flexible_coupling"], (), 5.0, 3.9, OWN, False),  # it takes less than half of the power above the floor
        (["flexible_coupling"], (), 1.02, 1.001, OWN, False),  # what is left is noise
        (["flexible_coupling"], ("gain",), 5.0, 2.0, OWN, False),  # as all runs may differ
        (["flexible_coupling", "cogging"], (), 5.0, 2.0, OWN, False),  # more effects take more
        (["flexible_coupling"], (), 5.0, 2.0, "a slow shift of the rest position", False),
    ],
)
def test_another_oscillation_outdoes_a_lead(
    names: list[str],
    free: tuple[str, ...],
    lead: float,
    times: float,
    words: str,
    outdone: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    other = replace(candidate(names, times=times), deviations=frozenset(free))
    monkeypatch.setattr(gather, "imitators", lambda *asked: {names[0]: words} if asked[-1] is other else {})
    e = evidence(LINEAR, candidate(["coulomb_friction"], times=lead), other)
    assert e.lead.names == ("coulomb_friction",)
    assert e.outdone(e.lead) is outdone


@pytest.mark.parametrize(
    ("beside", "times", "outdone"),
    [
        (["coulomb_friction", "quadratic_damping"], 2.5, False),
        (["coulomb_friction", "quadratic_damping"], 4.9, True),  # it leaves hardly less than the lead
        (["cubic_stiffness", "quadratic_damping"], 2.5, True),  # another law
    ],
)
def test_a_law_beside_a_lead_stands_up_to_another_oscillation(
    beside: list[str], times: float, outdone: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = candidate(["flexible_coupling"], times=2.0)
    monkeypatch.setattr(gather, "imitators", lambda *asked: {"flexible_coupling": OWN} if asked[-1] is other else {})
    lead = candidate(["coulomb_friction"], times=5.0)
    assert evidence(LINEAR, lead, other, candidate(beside, times=times)).outdone(lead) is outdone


STATES = {"sine_stiffness": "position", "cubic_stiffness": "position", "quadratic_damping": "velocity"}


@pytest.mark.parametrize(
    ("names", "free", "times", "found"),
    [
        (["quadratic_damping"], (), 4.0, True),  # power above the floor: 15 floors², the lead's 8
        (["quadratic_damping"], (), 4.2, False),  # more than twice as much
        (["quadratic_damping"], (), 2.9, True),  # another price let the lead win
        (["cubic_stiffness"], (), 3.1, False),  # a law of the lead's state: see `beside`
        (["quadratic_damping"], ("gain",), 3.1, False),  # as runs may differ
        (["quadratic_damping", "coulomb_friction"], (), 3.1, False),  # more effects
    ],
)
def test_what_is_missing_may_have_put_a_law_of_another_state_behind(
    names: list[str], free: tuple[str, ...], times: float, found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, other = candidate(["sine_stiffness"], times=3.0), candidate(names, times=times, deviations=free)
    for some in (own, other):
        some.optimum.names = some.names  # type: ignore[attr-defined]
    of = {name: frozenset({state}) for name, state in STATES.items()}
    monkeypatch.setattr(gather, "states_of_all", lambda _, o: tuple(of.get(n, frozenset()) for n in o.names))
    assert (evidence(LINEAR, own, other).rival_elsewhere(own) is other) is found


def test_a_law_inside_a_lead_what_may_not_be_named_and_noise_put_no_lead_in_doubt(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(gather, "imitators", lambda *_: {})
    monkeypatch.setattr(gather, "barred", lambda *_: False)
    own, simple = candidate(["presliding_hysteresis"], times=3.0), candidate(["coulomb_friction"], times=3.5)
    of = {own.optimum: (frozenset(),), simple.optimum: (frozenset({"velocity"}),)}
    monkeypatch.setattr(gather, "states_of_all", lambda _, o: of.get(o, (frozenset({"position"}),)))
    assert evidence(LINEAR, own, simple).rival_elsewhere(own) is None
    play = candidate(["free_play"], times=3.5)
    e = evidence(LINEAR, own, play)
    assert e.rival_elsewhere(own) is play
    with_more = evidence(LINEAR, own, play, candidate(["presliding_hysteresis", "cogging"]))  # what is missing is known
    assert with_more.rival_elsewhere(own) is None
    monkeypatch.setattr(gather, "barred", lambda *asked: asked[-1] is play)
    assert e.rival_elsewhere(own) is None
    lead = candidate(["presliding_hysteresis"], times=1.02)
    of[lead.optimum] = (frozenset(),)
    assert evidence(LINEAR, lead, candidate(["free_play"], times=1.025)).rival_elsewhere(lead) is None


@pytest.mark.parametrize(
    ("names", "part"),
    [
        (["coulomb_friction", "cogging"], ("coulomb_friction",)),
        (["coulomb_friction"], None),  # nothing is taken away
        (["cogging", "periodic_disturbance"], None),  # nothing is left
        (["free_play", "cogging"], None),  # it was not fitted alone
        (["quadratic_damping", "cogging"], None),  # others weigh as much
    ],
)
def test_what_may_be_named_of_the_best(
    names: list[str], part: tuple[str, ...] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    stands_in = {"cogging": "the spring", "periodic_disturbance": "the spring"}
    monkeypatch.setattr(
        gather, "imitators", lambda *asked: {n: stands_in[n] for n in asked[-1].names if n in stands_in}
    )
    best = candidate(names)
    alone = [candidate([name], times=3.0) for name in ("coulomb_friction", "quadratic_damping")]
    e = evidence(best, losing(best, 1.0, ["coulomb_friction", "cogging"]), *alone)
    found = e.sure_part
    assert (found and found.names) == part


def test_a_trifle_is_no_sure_part_of_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        gather, "imitators", lambda *asked: {n: "the spring" for n in asked[-1].names if n == "cogging"}
    )
    monkeypatch.setattr(gather.EvidenceRecord, "share", lambda *_: (0.99, 0.99))
    best = candidate(["coulomb_friction", "cubic_stiffness", "cogging"])
    for alone, kept in ((2.05, ("cubic_stiffness",)), (5.0, ("coulomb_friction", "cubic_stiffness"))):
        pair = candidate(["coulomb_friction", "cubic_stiffness"], times=2.0)
        part = evidence(best, pair, candidate(["cubic_stiffness"], times=alone)).sure_part
        assert part is not None
        assert part.names == kept


def test_beside_a_part_of_the_best_stand_the_laws_that_are_as_good(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        gather, "imitators", lambda *asked: {n: "the spring" for n in asked[-1].names if n == "cogging"}
    )
    sine, cubic = (candidate([name], times=3.0) for name in ("sine_stiffness", "cubic_stiffness"))
    e = evidence(candidate(["sine_stiffness", "cogging"]), sine, cubic)
    assert e.sure_part is sine
    assert e.beside(sine) == (cubic,)
