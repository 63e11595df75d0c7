"""Where a hand lets a cart go, and records of several releases."""

from __future__ import annotations

import control
import numpy as np
import pytest

import stepid
from stepid.core.base import Array
from stepid.core.hand import hand, release_index
from stepid.core.noise import reading_step
from stepid.core.releases import _Lobe, _moved
from stepid.fitting.screening import screen

STEP = 0.01  # s


def swing(size: float, *, samples: float, ratio: float, periods: float = 8.0) -> Array:
    """A damped swing let go at rest, in closed form."""
    number = np.arange(round(samples * periods))
    turn = 2 * np.pi * number / samples
    decay = ratio / np.sqrt(1 - ratio**2)
    out: Array = size * np.exp(-decay * turn) * (np.cos(turn) + decay * np.sin(turn))
    return out


def record(position: Array, *, noise: float = 1e-5, starts: str = "auto") -> stepid.Experiment:
    rng = np.random.default_rng(position.size)
    return stepid.Experiment(
        name="a",
        time=STEP * np.arange(position.size),
        position=position + noise * rng.standard_normal(position.size),
        input=np.zeros(position.size),
        added_mass=0.0,
        spring="s",
        damper="d",
        starts=starts,  # type: ignore[arg-type]
    )


@pytest.mark.parametrize("samples", [8, 20, 60, 300])
@pytest.mark.parametrize("ratio", [0.01, 0.1, 0.4])
@pytest.mark.parametrize("drift", [0.0, 0.1, -0.1])
def test_a_long_hold_is_cut_whether_the_hand_is_still_or_creeps(samples: int, ratio: float, drift: float) -> None:
    for hold in (samples, 3 * samples, 4000):
        held = 0.01 * (1 + drift * np.linspace(1, 0, hold))
        first = release_index(record(np.concatenate([held, swing(0.01, samples=samples, ratio=ratio)])))
        assert hold <= first <= hold + max(samples / 7, 3)


@pytest.mark.parametrize("periods", np.arange(4.0, 9.0, 0.25))
def test_a_free_swing_of_any_length_shows_no_hand(periods: float) -> None:
    """More samples lie on one side of rest where the record ends within a period."""
    y = swing(0.02, samples=80, ratio=0.003, periods=periods)
    ringing = 8e-5 * (np.cos(18 * np.pi * np.arange(y.size) / 80) - 1)
    first, seen = hand(record(y + ringing, noise=2e-5))
    assert not seen
    assert first <= 2


@pytest.mark.parametrize("hold", [3, 4, 5, 6, 7, 8])
@pytest.mark.parametrize("samples", [10, 20, 40])
def test_a_short_hold_is_cut(hold: int, samples: int) -> None:
    y = np.concatenate([np.full(hold, 0.01), swing(0.01, samples=samples, ratio=0.05)])
    assert hold <= release_index(record(y)) <= hold + max(samples / 7, 3)


@pytest.mark.parametrize("hold", [0, 1, 2])
@pytest.mark.parametrize("samples", [10, 20, 40, 300])
def test_what_a_hand_may_have_held_unseen_is_left_out(hold: int, samples: int) -> None:
    y = np.concatenate([np.full(hold, 0.01), swing(0.01, samples=samples, ratio=0.05)])
    run = record(y, noise=3e-5)
    begin = hand(run)
    assert not (begin.seen and hold == 0)
    assert release_index(run) == (begin.first if begin.seen else 0)
    assert hold <= begin.first <= hold + max(samples / 7, 3)


@pytest.mark.parametrize("hold", [0, 2])
def test_what_a_hand_may_have_held_is_cut_where_records_are_screened(hold: int) -> None:
    y = np.concatenate([np.full(hold, 0.01), swing(0.01, samples=100, ratio=0.05)])
    held, moving = record(y), record(y[hold + 10 :]).model_copy(update={"name": "b"})
    found = screen(stepid.Campaign(name="c", experiments=(held, moving)))
    kept = [run.position.size for run in found.campaign.experiments]
    assert hold < y.size - kept[0] <= hold + 4
    assert kept[1] == moving.position.size
    (note,) = [note for note in found.notes if "hand" in note]
    assert note.startswith("Release 'a': the first ")
    again = screen(found.campaign)
    assert [run.position.size for run in again.campaign.experiments] == kept  # what is cut once moves


@pytest.mark.parametrize("phase", [-0.05, 0.1])
@pytest.mark.parametrize("samples", [20, 40, 300])
def test_nothing_is_left_out_of_a_cart_that_moves_at_the_first_sample(phase: float, samples: int) -> None:
    away = swing(0.01, samples=samples, ratio=0.05)
    assert release_index(record(away[round((1 + phase) * samples) :])) == 0


@pytest.mark.parametrize("hold", [3, 8, 60])
@pytest.mark.parametrize("ratio", [0.8, 1.0, 1.5])
def test_a_hold_before_a_cart_creeps_to_its_rest_is_left_out(hold: int, ratio: float) -> None:
    turn = 2 * np.pi / 80 * np.arange(500)
    apart = np.sqrt(complex(ratio**2 - 1)) or 1e-6
    decay = np.exp(-ratio * turn) * (np.cosh(apart * turn) + ratio / apart * np.sinh(apart * turn))
    begin = release_index(record(np.concatenate([np.full(hold, 0.01), 0.01 * decay.real])))
    assert hold <= begin <= hold + 12


def test_what_is_said_about_the_start_wins() -> None:
    y = np.concatenate([np.full(100, 0.01), swing(0.01, samples=40, ratio=0.05)])
    assert release_index(record(y, starts="motion")) == 0


def several(sizes: tuple[float, ...], *, ratio: float = 0.05) -> tuple[Array, list[tuple[int, int]]]:
    """Pulled out, held and let go again and again; from where to where the cart is free."""
    parts, free = [np.zeros(60)], []
    for size in sizes:
        parts += [0.5 * size * (1 - np.cos(np.linspace(0, np.pi, 90))), np.full(50, size)]
        begin = sum(part.size for part in parts)
        parts.append(swing(size, samples=40, ratio=ratio, periods=10))
        free.append((begin, begin + parts[-1].size))
    return np.concatenate(parts), free


@pytest.mark.parametrize("ratio", [0.05, 0.2])
@pytest.mark.parametrize("sizes", [(0.01, 0.008), (0.01, -0.006, 0.012), (0.005, 0.01, 0.01, -0.01)])
def test_each_release_becomes_a_record(sizes: tuple[float, ...], ratio: float) -> None:
    y, free = several(sizes, ratio=ratio)
    parts = stepid.split_releases(record(y))
    assert [part.name for part in parts] == [f"a ({i})" for i in range(1, len(sizes) + 1)]
    for part, (begin, end) in zip(parts, free, strict=True):
        at = round(float(part.time[0]) / STEP)
        assert begin <= at + release_index(part) <= begin + 8
        assert end - 40 <= at + part.time.size <= end + 20  # none of the next hand


def test_one_release_and_a_driven_record_stay_whole() -> None:
    y, _ = several((0.01,))
    run = record(y)
    assert stepid.split_releases(run) == (run,)
    driven = run.model_copy(update={"input": np.where(run.time > 2.0, 0.5, 0.0)})
    assert stepid.split_releases(driven) == (driven,)


def test_a_fit_and_a_diagnosis_take_several_releases_and_say_so() -> None:
    y, _ = several((0.01, -0.008, 0.012))
    campaign = stepid.Campaign(name="c", experiments=(record(y),))
    said = "Run 'a' holds 3 releases. They are taken as runs 'a (1)', 'a (2)', 'a (3)'."
    fitted = stepid.fit(campaign)
    assert said in fitted.notes
    assert any("a hand held or moved the cart" in note for note in fitted.notes)
    assert set(fitted.run_rms) == {"a (1)", "a (2)", "a (3)"}
    assert fitted.rms < 1.2e-5
    found = stepid.diagnose(campaign)
    assert found.verdict == "adequate"
    assert said in found.notes
    assert found.data is not None
    assert [run.name for run in found.data.experiments] == ["a (1)", "a (2)", "a (3)"]


def test_a_name_that_is_taken_leaves_a_record_whole() -> None:
    y, _ = several((0.01, -0.008))
    run = record(y)
    other = record(swing(0.01, samples=40, ratio=0.05)).model_copy(update={"name": "a (2)"})
    fitted = stepid.fit(stepid.Campaign(name="c", experiments=(run, other)))
    assert set(fitted.run_rms) == {"a", "a (2)"}


def test_releases_after_the_first_begin_with_the_hand_whatever_is_said_of_the_record() -> None:
    y, free = several((0.01, 0.008, 0.012))
    first = free[0][0]
    parts = stepid.split_releases(record(y[first:], starts="motion"))
    assert [part.starts for part in parts] == ["motion", "auto", "auto"]
    assert release_index(parts[0]) == 0
    assert all(release_index(part) > 0 for part in parts[1:])


@pytest.mark.parametrize(
    ("at", "length"), [(30, 1), (30, 2), (30, 3), (150, 1), (150, 3), (310, 1), (310, 3), (397, 1)]
)
def test_wrong_readings_are_no_release_and_no_hand(at: int, length: int) -> None:
    clean = record(swing(0.01, samples=40, ratio=0.1, periods=10))
    y = np.array(clean.position)
    y[at : at + length] -= 0.012
    dirty = clean.model_copy(update={"position": y})
    assert stepid.split_releases(dirty) == (dirty,)
    assert hand(dirty) == hand(clean)


def test_releases_are_told_behind_wrong_readings() -> None:
    y, free = several((0.01, -0.008, 0.012))
    whole = stepid.split_releases(record(y))
    dirty = y.copy()
    dirty[[begin + 133 for begin, _ in free]] += 0.009
    parts = stepid.split_releases(record(dirty))
    assert [part.time.tolist() for part in parts] == [part.time.tolist() for part in whole]
    assert [release_index(part) for part in parts] == [release_index(part) for part in whole]


@pytest.mark.parametrize("slip", [-1, 1])
def test_a_cart_at_rest_that_slips_by_a_count_is_not_let_go_again(slip: int) -> None:
    counts = np.round(swing(3.4, samples=40, ratio=0.05, periods=20))
    counts[600:] += slip
    degrees = np.round(0.085 * (70 + counts), 2)  # as a logger prints them: steps of 8 and 9 hundredths
    run = record(np.deg2rad(degrees), noise=0.0)
    assert run.resolution is None
    assert stepid.split_releases(run) == (run,)


@pytest.mark.parametrize("seed", range(1, 7))
@pytest.mark.parametrize("noise", [1.4e-3, 2e-3, 2.6e-3])
def test_an_even_swing_with_ragged_peaks_is_one_release(noise: float, seed: int) -> None:
    white = np.random.default_rng(seed).standard_normal(360)
    run = record(swing(0.017, samples=18, ratio=0.002, periods=20) + noise * white, starts="motion")
    assert stepid.split_releases(run) == (run,)


@pytest.mark.parametrize("cut", [7, 12, 19, 22])
def test_a_swing_that_a_record_cuts_is_no_hand(cut: int) -> None:
    run = record(swing(0.02, samples=30, ratio=0.004, periods=20)[cut:], starts="motion")
    assert stepid.split_releases(run) == (run,)


@pytest.mark.parametrize("seed", [1, 5, 7, 8])
def test_two_ragged_releases_are_two(seed: int) -> None:
    white = np.random.default_rng(seed).standard_normal(720)
    both = [swing(size, samples=40, ratio=0.03, periods=9) for size in (0.02, -0.014)]
    y = np.concatenate(both) + 1.4e-3 * np.convolve(white, [0.6, 0.6, 0.5], "same")
    parts = stepid.split_releases(record(y, starts="motion"))
    assert len(parts) == 2
    assert parts[1].time[0] == pytest.approx(360 * STEP, abs=40 * STEP)


def test_a_rest_of_two_readings_has_a_last_still_sample() -> None:
    away = np.array([5.0, 5.0, 0.9, -0.9, 0.9, -0.9, 5.0])
    assert _moved(away, _Lobe(0, 2, 5.0, 1.0), _Lobe(6, 7, 5.0, 1.0), 1.0) == 5


def test_readings_step_by_what_is_stated_or_by_the_least_they_differ() -> None:
    run = record(np.repeat([0.0, 3e-3, 5e-3, 5e-3 + 1e-14], 5), noise=0.0)
    assert reading_step(run) == pytest.approx(2e-3)
    assert reading_step(run.model_copy(update={"counts_per_meter": 1e4})) == pytest.approx(1e-4)
    assert reading_step(record(np.zeros(20), noise=0.0)) == 0.0


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("noise", [0.0, 2e-5, 1e-4])
def test_two_modes_that_beat_are_no_hands(share: float, noise: float) -> None:
    time = STEP * np.arange(1600)
    both = np.cos(2 * np.pi * 2.5 * time) + share * np.cos(2 * np.pi * 2.9 * time)
    run = record(0.01 * np.exp(-0.1 * time) * both, noise=noise, starts="motion")
    assert stepid.split_releases(run) == (run,)


@pytest.mark.parametrize("periods", [2.0, 4.0])
def test_a_slow_push_breaks_what_swings(periods: float) -> None:
    """A linear prediction of two modes nearly follows it: the force of the hand is as smooth as the swing."""
    time, rate, decay = STEP * np.arange(1200), 2 * np.pi, 0.3
    hand_ = np.clip((time - 4.0) / periods, 0.0, 1.0)
    force = 0.02 * rate**2 * np.sin(np.pi * hand_) ** 2
    free = control.ss([[0, 1], [-(rate**2), -2 * decay]], [[0], [1]], [[1, 0]], [[0]])
    pushed = control.forced_response(free, time, force, [0.01, 0.0]).outputs
    assert len(stepid.split_releases(record(pushed, noise=3e-5, starts="motion"))) == 2


@pytest.mark.parametrize("samples", [40, 300])
def test_a_last_reading_that_is_off_is_no_hand(samples: int) -> None:
    position = np.append(np.zeros(samples - 1), 0.01)
    made = stepid.Experiment(
        name="end", time=0.01 * np.arange(samples), position=position, input=np.zeros(samples),
        added_mass=0.0, spring="s", damper="d",
    )  # fmt: skip
    found = hand(made)
    assert found is not None
    assert (found.first, found.seen) == (0, False)
    parts = stepid.Campaign(name="one", experiments=(made,)).in_parts(2)
    assert [run.name for run in parts.experiments] == ["end, part 1", "end, part 2"]
