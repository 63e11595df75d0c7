"""A submission against the answer: every verdict, every refusal."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lab_example import TRUTH, UNITS, answer, mass, submission
from stepid import Estimate, lab
from stepid.errors import InputError


def test_all_right():
    found = lab.check(answer(), submission())
    assert found.passed
    assert (found.naming, found.close, found.inside) == ("right", 5, 5)
    assert [p.words for p in found.parameters] == ["right"] * 5
    assert found.summary().startswith("Group A: passed\nRight: coulomb friction hidden.\n")
    assert "<table>" in found._repr_html_()
    assert "5 of 5 close" in repr(found)


@pytest.mark.parametrize(
    ("given", "inside", "close", "words"),
    [
        (mass(1.03, 0.02), True, True, "right"),
        (mass(1.20, 0.15), True, False, "interval holds the truth, but only because it is wide"),
        (mass(0.97, 0.01), False, True, "close, but 3 standard uncertainties away: uncertainty too small"),
        (mass(1.30, 0.10), False, False, "off, 3 standard uncertainties away"),
        (mass(-1.0, 1e-6), False, False, "off, more than 100 standard uncertainties away"),
        (mass(1.01, None), False, True, "stated as undetermined; the value is close"),
        (mass(2.00, None), False, False, "stated as undetermined; the value is far off"),
    ],
)
def test_each_verdict_on_a_parameter(given, inside, close, words):
    found = lab.check(answer(), submission(mass=given))
    one = found["base_mass"]
    assert (one.inside, one.close, one.words) == (inside, close, words)
    assert one.right is (inside and close)
    assert one.off == pytest.approx(abs(given.value - 1.0))
    assert words in found.summary()
    assert found.passed is close  # one interval of five may miss by chance, a value may not


def test_more_missed_intervals_than_chance_allows_do_not_pass():
    narrow = {n: Estimate(value=1.01 * v, uncertainty=0.001 * v, unit=UNITS[n]) for n, v in TRUTH.items()}
    found = lab.check(answer(), submission(**narrow))
    assert (found.close, found.inside, found.misses_allowed) == (5, 1, 2)
    assert not found.passed
    assert "1 of 5 intervals hold the truth (3 needed" in found.summary()


@pytest.mark.parametrize(("count", "allowed"), [(1, 1), (4, 2), (5, 2), (10, 3), (20, 4)])
def test_misses_allowed_are_the_binomials(count, allowed):
    binomial = [math.comb(count, k) * 0.05**k * 0.95 ** (count - k) for k in range(count + 1)]
    assert sum(binomial[allowed + 1 :]) < 0.01 <= sum(binomial[allowed:])
    one = lab.check(answer(), submission()).parameters[0]
    assert lab.Check(group="A", naming="right", words="", parameters=(one,) * count, tolerance=0.05).misses_allowed == (
        allowed
    )


@pytest.mark.parametrize(
    ("hidden", "named", "alternatives", "naming", "words"),
    [
        ((), (), (), "right", "Right: nothing is hidden, and nothing was named."),
        (("free_play",), (), (), "wrong", "Wrong: free play hidden, nothing named."),
        ((), ("coulomb_friction",), (), "wrong", "Wrong: nothing hidden, coulomb friction named."),
        (("free_play",), ("coulomb_friction",), (), "wrong", "Wrong: free play hidden, coulomb friction named."),
        (("free_play",), ("coulomb_friction",), (("free_play",),), "among", "Right, among 2 that"),
        (("coulomb_friction",), ("coulomb_friction",), (("free_play",),), "among", "Right, among 2 that"),
        (("coulomb_friction",), ("coulomb_friction",), (("coulomb_friction",),), "right", "Right: coulomb"),
        (
            ("coulomb_friction", "free_play"),
            ("coulomb_friction",),
            (),
            "partly",
            "Partly right: coulomb friction found, free play missed.",
        ),
        (
            ("coulomb_friction", "free_play"),
            ("coulomb_friction", "cogging"),
            (),
            "partly",
            "Partly right: coulomb friction found, free play missed, cogging not in the plant.",
        ),
    ],
)
def test_each_verdict_on_the_names(hidden, named, alternatives, naming, words):
    own = {"free_play": "free_play.gap", "coulomb_friction": "coulomb_friction.level"}
    truth = answer(hidden, {own[e]: 0.3 for e in hidden}, {own[e]: "m" if e == "free_play" else "N" for e in hidden})
    found = lab.check(truth, submission(named, alternatives))
    assert found.naming == naming
    assert found.words.startswith(words)
    assert found.passed is (naming in ("right", "among"))
    assert len(found.counted) == {"among": 4 + (hidden == named)}.get(naming, len(found.parameters))


def test_parameters_of_what_was_not_named_and_of_what_is_not_there():
    truth = answer(("free_play",), {"free_play.gap": 1e-4}, {"free_play.gap": "m"})
    found = lab.check(truth, submission())
    assert found["free_play.gap"].words == "not given: free play was not named"
    assert found["coulomb_friction.level"].words == "the plant has no coulomb friction"
    assert found["coulomb_friction.level"].truth is None
    assert not found["free_play.gap"].right
    assert not found["coulomb_friction.level"].right
    among = lab.check(truth, submission(alternatives=(("free_play",),)))
    assert among["free_play.gap"].words == "not given: free play was not fitted"
    with pytest.raises(InputError, match="no parameter 'x' was checked"):
        found["x"]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mass": None}, "group 'A' lacks 'base_mass'. Give it in kg"),
        ({"level": None}, "lacks 'coulomb_friction.level'. Give it in N"),
        ({"m": mass(1.0, 0.1)}, "gives 'm', which is no parameter"),
        ({"base_mas": mass(1.0, 0.1)}, "Did you mean 'base_mass'?"),
        ({"free_play.gap": mass(1.0, 0.1, "m")}, "gives 'free_play.gap', which is no parameter"),
        ({"mass": mass(950.0, 10.0, "g")}, "gives base_mass in g. Give it in kg"),
        ({"mass": mass(0.95, 0.01, "")}, "gives base_mass in no unit"),
        ({"mass": mass(0.95, 0.0)}, "gives base_mass an uncertainty of zero"),
        ({"group": "B"}, "group 'B' is not for the answer of group 'A'"),
        ({"effects": ("friction",)}, "group 'A': there is no effect called 'friction'"),
        ({"alternatives": (("x",),)}, "no effect called 'x'"),
        ({"effects": ("coulomb_friction", "coulomb_friction")}, "named twice"),
    ],
)
def test_check_refuses(changes, words):
    with pytest.raises(InputError) as caught:
        lab.check(answer(), submission(**changes))
    assert words in str(caught.value)


@pytest.mark.parametrize("tolerance", [0, -0.1, math.nan, math.inf, "5 %", None])
def test_the_tolerance_is_a_positive_share(tolerance):
    with pytest.raises(InputError, match="tolerance is"):
        lab.check(answer(), submission(), tolerance=tolerance)


def test_a_damper_that_is_missing_is_told_whatever_its_label():
    known = answer(own={"damping[0.5 turn]": 10.0}, effects=(), units={"damping[0.5 turn]": "N·s/m"})
    with pytest.raises(InputError, match=r"lacks 'damping\[0\.5 turn\]'\. Give it in N·s/m"):
        lab.check(known, submission(effects=()))


@pytest.mark.parametrize("unit", ["N·s/m", "N*s/m", "N s/m", "Ns/m", "N⋅s/m"])
def test_units_may_be_typed_plainly(unit):
    given = {"damping[1/2 turn]": Estimate(value=10.0, uncertainty=0.1, unit=unit)}
    assert lab.check(answer(), submission(**given)).passed


def test_no_more_is_asked_for_than_the_records_allow():
    off = submission(mass=mass(1.2, 0.1))
    for attainable, close in ((0.01, False), (0.066, False), (0.067, True), (None, True)):
        found = lab.check(answer(attainable={"base_mass": attainable}), off)["base_mass"]
        assert found.close is close


def test_an_angle_goes_the_short_way_round():
    own = {"cogging.amplitude": 0.1, "cogging.pitch": 0.004, "cogging.phase": 0.01}
    units = {"cogging.amplitude": "N", "cogging.pitch": "m", "cogging.phase": "rad"}
    given = {
        "cogging.amplitude": mass(0.1, 0.01, "N"),
        "cogging.pitch": mass(0.004, 0.0001, "m"),
        "cogging.phase": mass(2 * math.pi - 0.01, 0.02, "rad"),
    }
    found = lab.check(answer(("cogging",), own, units), submission(("cogging",), **given))
    assert found.passed
    assert found["cogging.phase"].off == pytest.approx(0.02)
    assert "0.02 rad" in found.summary()


@given(
    st.floats(0.01, 100.0),
    st.floats(-3.0, 3.0),
    st.floats(1e-4, 1.0),
    st.floats(1e-3, 1.0),
)
@settings(max_examples=200, deadline=None)
def test_inside_and_close_are_what_they_say(truth, away, spread, tolerance):
    own = {"coulomb_friction.level": truth}
    value, uncertainty = truth * (1 + away), truth * spread
    given = mass(value, uncertainty, "N")
    one = lab.check(answer(own=own), submission(level=given), tolerance=tolerance)["coulomb_friction.level"]
    low, high = given.interval
    if abs(abs(away) - 1.96 * spread) > 1e-9:
        assert one.inside is (low <= truth <= high)
    if abs(abs(away) - tolerance) > 1e-9:
        assert one.close is (abs(value - truth) <= tolerance * truth)
    wider = lab.check(answer(own=own), submission(level=mass(value, 2 * uncertainty, "N")), tolerance=2 * tolerance)[
        "coulomb_friction.level"
    ]
    assert (wider.inside, wider.close) >= (one.inside, False)
    assert wider.close >= one.close
