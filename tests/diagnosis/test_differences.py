"""What runs differ by: told with its size and what it explains; nothing is told of runs that are alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import stepid
from broken_campaigns import SAMPLE_TIME, changed
from made_up_releases import released
from scattered_campaigns import scattered
from stepid.diagnosis.differences import Scatter, scatter_of, scatter_words
from stepid.diagnosis.explore import linear_candidate
from stepid.diagnosis.selection.candidate import Candidate
from stepid.fitting.deviations import with_deviations
from stepid.fitting.fit import prepare
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.multistart import FitContext

LATE = (0.6, -0.5, 0.3, -0.7, 0.4, -0.1)  # samples
RELATIVE = (0.03, -0.03, 0.02, -0.02, 0.01, -0.01)
CASES: dict[str, tuple[Callable[[], stepid.Campaign], float, str]] = {
    "start_time": (lambda: scattered(1, late=LATE), SAMPLE_TIME * float(np.std(LATE, ddof=1)), "s"),
    "gain": (lambda: scattered(1, gain=RELATIVE), float(np.std(RELATIVE, ddof=1)), ""),
    "damping": (
        lambda: scattered(1, damping=tuple(5 * r for r in RELATIVE)),
        5 * float(np.std(RELATIVE, ddof=1)),
        "",
    ),
}


def freed(context: FitContext, *kinds: str) -> Candidate:
    """The linear plant with conditions that differ from run to run."""
    linear = context.linear
    optimum = minimize(with_deviations(linear.problem, kinds), linear.shared, linear.local)
    assert optimum is not None
    return Candidate((), frozenset(kinds), optimum, 0.0)


@pytest.mark.parametrize("kind", CASES)
def test_a_condition_is_told_with_its_size(kind: str) -> None:
    make, size, unit = CASES[kind]
    context = prepare(make())
    one = freed(context, kind)
    found = scatter_of(context, one, [linear_candidate(context)], one.optimum)
    assert set(found) - {"rest"} == {kind}  # these campaigns' rest positions differ, too
    assert found[kind].deviation == pytest.approx(size, rel=0.2)  # relative to the first run
    assert found[kind].unit == unit
    assert found[kind].explained > 0.5


def test_what_one_of_two_explains_is_found_without_the_other_candidate() -> None:
    context = prepare(scattered(1, late=LATE, gain=RELATIVE))
    both = freed(context, "start_time", "gain")
    found = scatter_of(context, both, [], both.optimum)
    assert set(found) - {"rest"} == {"gain", "start_time"}
    assert all(0.3 < s.explained <= 1 for s in found.values())
    given = scatter_of(context, both, [freed(context, "gain"), freed(context, "start_time")], both.optimum)
    for kind, s in given.items():
        assert s.explained == pytest.approx(found[kind].explained, abs=0.02)


def test_rest_positions_that_move_are_told() -> None:
    still = scattered(1)
    for run in range(6):  # those of the campaign are drawn within a millimeter
        y = still.experiments[run].position
        still = changed(still, run, position=y - y[:5].mean() + 2e-4 * run, counts_per_meter=None)
    context = prepare(still)
    found = scatter_of(context, linear_candidate(context), [], context.linear)
    assert list(found) == ["rest"]
    assert found["rest"].deviation == pytest.approx(2e-4 * np.std(range(6), ddof=1), rel=0.1)
    assert found["rest"].unit == "m"


def test_rest_positions_are_those_of_the_fit_that_is_shown() -> None:
    """A candidate that is not named may shift them at will."""
    context = prepare(scattered(1))
    shifts = linear_candidate(context)
    apart = shifts.optimum.solved.reading - 0.01 * context.records.run
    moved = replace(shifts.optimum.solved, reading=apart)
    astray = replace(shifts, optimum=replace(shifts.optimum, solved=moved))
    told = scatter_of(context, astray, [], context.linear)
    assert told == scatter_of(context, shifts, [], context.linear)
    assert scatter_of(context, shifts, [], astray.optimum)["rest"].deviation > 0.01


def test_conditions_at_their_limits_and_those_that_explain_nothing_are_not_told() -> None:
    """Runs that all differ as far as they may follow a law; what takes 0 % is none that differs."""
    context = prepare(scattered(1, gain=RELATIVE))
    one = freed(context, "gain", "damping")
    assert set(scatter_of(context, one, [], one.optimum)) - {"rest"} == {"gain"}
    most = one.optimum.problem.most
    assert most is not None
    row = one.optimum.problem.layout.deviation("gain")
    local = one.optimum.local.copy()
    local[row] = np.where(one.optimum.problem.active[row], most[row], 0.0)
    at_most = replace(one, optimum=replace(one.optimum, local=local))
    assert not set(scatter_of(context, at_most, [], one.optimum)) - {"rest"}
    local[row, -1] = 0.1
    assert "gain" in scatter_of(context, at_most, [linear_candidate(context)], one.optimum)


def test_alike_runs_differ_in_nothing() -> None:
    alike = scattered(1)
    for run in range(6):
        y = alike.experiments[run].position
        alike = changed(alike, run, position=y - y[:10].mean(), counts_per_meter=None)
    context = prepare(alike)
    assert scatter_of(context, linear_candidate(context), [], context.linear) == {}


def test_runs_that_are_held_at_rest_differ_in_no_start() -> None:
    driven = scattered(1).experiments
    release = released(0.5).model_copy(update={"spring": "medium", "damper": "half"})  # which begins off its rest
    context = prepare(stepid.Campaign(name="both", experiments=(*driven, release)))
    held = replace(linear_candidate(context), deviations=frozenset({"start_offset"}))
    assert held.optimum.problem.active[0].any()
    assert "start_offset" not in scatter_of(context, held, [freed(context, "gain")], context.linear)


def test_what_all_runs_share_is_no_difference() -> None:
    """Records that all begin as late take nothing by differing from one another."""
    context = prepare(scattered(1, late=tuple(1.5 + 0.02 * x for x in LATE)))
    one = freed(context, "start_time")
    found = scatter_of(context, one, [linear_candidate(context)], one.optimum)
    before, after = context.linear.cost, one.optimum.cost
    assert after < 0.5 * before
    assert "start_time" not in found or found["start_time"].explained < 0.1


def test_words_have_units() -> None:
    told = scatter_words(
        {
            "start_time": Scatter(deviation=1.5e-3, unit="s", explained=0.9),
            "gain": Scatter(deviation=0.02, unit="", explained=0.5),
            "rest": Scatter(deviation=2e-4, unit="m", explained=0.25),
        }
    )
    assert told == (
        "The runs start within ±1.5 ms of one another (standard deviation): 90 % of the misfit's power.",
        "The gain differs from run to run by 2 % (standard deviation): 50 % of the misfit's power.",
        "The rest position differs from run to run by 200 µm (standard deviation).",
    )


def test_beside_effects_the_share_is_one_of_what_they_leave() -> None:
    (told,) = scatter_words({"gain": Scatter(deviation=0.02, unit="", explained=0.5)}, "Coulomb friction")
    assert told.endswith("50 % of what Coulomb friction would leave.")


def test_beside_a_rest_what_differs_may_be_part_of_it() -> None:
    gain = {"gain": Scatter(deviation=0.03, unit="", explained=0.4)}
    rest = {"rest": Scatter(deviation=1e-3, unit="m", explained=0.4)}
    for scatter in (gain, rest):  # a wrong model's rest positions are wrong, too
        assert scatter_words(scatter, rest=True)[-1].startswith("What seems to differ between the runs may be part")
        assert len(scatter_words(scatter)) == 1
