"""Time stamps that are not even: which clock is taken, and what a fit makes of them."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from stepid.core.samples import off_even_clock
from stepid.simulation.clock import clock, clock_notes

STEP = 0.01


def released(taken: np.ndarray, stamps: np.ndarray) -> stepid.Experiment:
    swing = 0.02 * np.exp(-0.8 * taken) * np.cos(14.7 * taken)
    noise = 1e-6 * np.random.default_rng(1).standard_normal(taken.size)
    return stepid.Experiment(
        name="a", time=stamps, position=swing + noise, input=np.zeros(taken.size), added_mass=0.0, spring="s",
        damper="d",
    )  # fmt: skip


EVEN = STEP * np.arange(300)
LATE = EVEN + STEP * np.random.default_rng(2).uniform(-0.3, 0.3, 300)
GAP = np.delete(EVEN, slice(100, 120))


def test_even_stamps_are_taken_without_a_word() -> None:
    run = released(EVEN, EVEN)
    assert clock(run) is run.time
    assert clock_notes([run]) == []


def test_stamps_that_are_late_give_way_to_an_even_clock() -> None:
    run = released(EVEN, LATE)
    np.testing.assert_allclose(np.diff(clock(run)), STEP, rtol=1e-2)
    (told,) = clock_notes([run])
    assert "an even clock is taken for them" in told


def test_the_first_stamp_and_the_last_are_as_late_as_any() -> None:
    """Held to these two, a clock had all others up to 0.6 of a sample beside it: they were taken as uneven samples."""
    stamps = LATE.copy()
    stamps[[0, -1]] = EVEN[[0, -1]] + 0.3 * STEP * np.array([-1.0, 1.0])
    stamps[150] = EVEN[150] - 0.3 * STEP
    run = released(EVEN, stamps)
    assert 0.3 <= off_even_clock(stamps).max() < 0.4
    np.testing.assert_allclose(np.diff(clock(run)), STEP, rtol=1e-3)
    assert "an even clock is taken for them" in clock_notes([run])[0]


def test_samples_that_are_uneven_keep_their_stamps() -> None:
    run = released(LATE, LATE)
    assert clock(run) is run.time
    (told,) = clock_notes([run])
    assert "of a sample off an even clock; they are taken as they are" in told


@pytest.mark.parametrize("right", ["stamps", "even"])
def test_a_cart_that_mostly_rests_tells_its_clock_where_it_moves(right: str) -> None:
    """It is still for four fifths of the record, within noise that covers every difference there."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        stamps = EVEN + STEP * rng.uniform(-0.2, 0.2, EVEN.size)
        taken = stamps if right == "stamps" else EVEN
        swing = 0.02 * np.exp(-12.0 * taken) * np.cos(14.7 * taken) + 2e-5 * rng.standard_normal(taken.size)
        run = released(taken, stamps).model_copy(update={"position": swing})
        assert (clock(run) is run.time) == (right == "stamps")


@pytest.mark.parametrize(("taken", "stamps"), [(EVEN, LATE), (LATE, LATE), (GAP, GAP)])
def test_the_fit_takes_uneven_stamps_and_says_so(taken: np.ndarray, stamps: np.ndarray) -> None:
    found = stepid.fit(stepid.Campaign(name="c", experiments=(released(taken, stamps),)))
    assert found.parameters["stiffness[s]"].value == pytest.approx(14.7**2 + 0.8**2, rel=2e-3)
    assert any("time stamps" in note for note in found.notes)


def test_runs_whose_stamps_are_taken_alike_are_told_together() -> None:
    late, again = released(EVEN, LATE), released(EVEN, LATE).model_copy(update={"name": "again"})
    uneven, whole = released(GAP, GAP).model_copy(update={"name": "gap"}), released(EVEN, EVEN)
    first, second = clock_notes([late, uneven, again, whole])
    assert first.startswith(f"Runs {late.name!r} and 'again': their time stamps are up to ")
    assert second == "Run 'gap': its time stamps are uneven, at most 0.21 s apart, and are taken as they are."
