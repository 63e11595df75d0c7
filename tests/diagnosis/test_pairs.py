"""Two effects at once: campaigns on which the search was stuck, stopped too early or never ended."""

from __future__ import annotations

from dataclasses import replace

import pytest

import stepid
from hidden.sets import one
from stepid.diagnosis import verdict
from stepid.diagnosis.selection import backward
from stepid.diagnosis.selection.candidate import Candidate
from stepid.effects import resolve


@pytest.mark.slow
@pytest.mark.parametrize(
    "number",
    [
        pytest.param(41, id="a pair is at the floor, a better one not yet raced"),
        pytest.param(61, id="a pair is at the floor of a sketch, not of all samples"),
        pytest.param(63, id="a heavy second mass"),
        pytest.param(205, id="a disturbance above the plant, found by its line, its phases by trying"),
        pytest.param(361, id="a general friction law leads, two simple ones are it"),
        pytest.param(396, id="a lag far shorter than a sample beside a curved spring"),
        pytest.param(450, id="a sine in position in the place of a simple spring law"),
        pytest.param(90, id="Newton does not settle on the way to the other pattern of sticking"),
    ],
)
def test_both_effects_are_named(number: int) -> None:
    campaign, truth = one("pairs", number)
    found = stepid.diagnose(campaign)
    assert found.verdict in ("named", "ambiguous")
    assert set(truth["effects"]) in [set(found.effects), *map(set, found.alternatives)]


def test_simplification_ends_where_nothing_simpler_is_better(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = Candidate(resolve(("coulomb_friction", "input_delay")), None, 0.0, 0.0)  # type: ignore[arg-type]
    worse = replace(pair, effects=pair.effects[:1], evidence=1.0)
    monkeypatch.setattr(backward, "simplify", lambda context, found: [worse])
    assert backward.simplified(None, [pair]) == [pair, worse]  # type: ignore[arg-type]


def test_simplification_goes_on_while_it_betters(monkeypatch: pytest.MonkeyPatch) -> None:
    three = Candidate(resolve(("coulomb_friction", "input_delay", "cogging")), None, 0.0, 0.0)  # type: ignore[arg-type]

    def one_less(context: object, found: Candidate) -> list[Candidate]:
        return [replace(found, effects=found.effects[1:], evidence=found.evidence - 1.0)]

    monkeypatch.setattr(backward, "simplify", one_less)
    assert backward.simplified(None, [three])[0].names == ("cogging",)  # type: ignore[arg-type]


def test_two_effects_in_the_other_order_are_no_rival() -> None:
    pair = Candidate(resolve(("coulomb_friction", "input_delay")), None, 0.0, 0.0)  # type: ignore[arg-type]
    turned = replace(pair, effects=pair.effects[::-1], evidence=0.1)
    assert verdict._accept([pair], [turned]) == [pair]
    assert backward.replaced([pair], [turned]) == [turned]
