"""Rules for wrong readings and wrong runs, each at its edge, on samples that are written down."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stepid
from made_up_evidence import Kept
from stepid.core.base import Array
from stepid.core.outliers import outliers, stand_out
from stepid.diagnosis.notes import _is_clipped
from stepid.fitting import run_fault
from stepid.fitting.eccentricity import _cause, find_eccentricity
from stepid.fitting.reading_faults import _fault, _stuck, mend, outliers_of, trust
from stepid.fitting.run_fault_words import _explanation, _factor, fault_words
from stepid.simulation.records import lay_out


def record(position: Array, **more: Any) -> stepid.Experiment:
    time = 0.01 * np.arange(position.size)
    return stepid.Experiment(
        name="r", time=time, position=position, input=np.where(time < 0.05, 0.0, 1.0), added_mass=0.0, spring="s",
        damper="d", **more,
    )  # fmt: skip


def test_a_block_stands_out_by_the_misfit_of_a_cubic_through_its_neighbors() -> None:
    y = 1e-4 * np.random.default_rng(1).standard_normal(30)
    places = np.r_[8:12, 14:18]
    fit = np.polynomial.Polynomial.fit(places, y[places], 3)
    basis = np.vander(places, 4)
    spread = math.sqrt(np.sum((fit(places) - y[places]) ** 2) / (8 - 4))
    score, off = stand_out(y, 2, np.array([12]), 0.0)
    assert off[0] == pytest.approx(y[12:14] - fit(np.array([12, 13])), rel=1e-6)
    for i, at in enumerate((12.0, 13.0)):
        row = np.vander([at], 4) @ np.linalg.pinv(basis)
        assert score[0, i] == pytest.approx(abs(off[0, i]) / spread / math.sqrt(1 + float(np.sum(row**2))), rel=1e-6)
    loud, _ = stand_out(y, 2, np.array([12]), 10 * spread)
    assert loud[0] == pytest.approx(score[0] / 10)


@pytest.mark.parametrize(("times", "length", "found"), [(10.0, 1, True), (8.0, 1, False), (10.0, 3, True)])
def test_nine_standard_deviations_make_an_outlier(times: float, length: int, found: bool) -> None:
    unit = stand_out(np.eye(1, 21, 10)[0], 1, np.array([10]), 1.0)[0][0, 0]  # of one sample off by one
    y = np.zeros(40)
    y[20 : 20 + length] = 1.3 * times / unit if length > 1 else times / unit
    assert ((20, length) in [(begin, size) for _, begin, size in outliers(y, 1.0, 0.0)]) is found
    assert not outliers(y, 1.0, 2 * float(y.max()))


def stopped(length: int, share: float, after: float = 1.0) -> Array:
    """One unit a sample; the reading stays for `length` samples and then makes good a share of the way missed."""
    before, late = np.arange(20.0), after * np.arange(20.0)
    return np.concatenate([before, np.full(length, before[-1]), before[-1] + share * (length + 1) + late])


@pytest.mark.parametrize("per_radian", [4, 40])
@pytest.mark.parametrize("how", ["step", "release", "blow"])
def test_where_a_motion_begins_no_reading_is_wrong(how: str, per_radian: int) -> None:
    """It begins between any of the first samples, as it does from rest, let go or struck."""
    rng = np.random.default_rng(9)
    for begin in np.linspace(0.0, 5.0, 26):
        t = np.maximum(np.arange(120) - begin, 0.0) / per_radian
        swing, decay = (np.sin(t), 1.0) if how == "blow" else (np.cos(t), np.exp(-0.1 * t))
        y = (1.0 - decay * swing if how == "step" else decay * swing) + 1e-6 * rng.standard_normal(t.size)
        assert not [block for block in outliers(y, 1e-6, 0.0) if block[1] < 9]


def test_where_a_blow_begins_and_fades_at_once_no_reading_is_wrong() -> None:
    """Its neighbors differ: one among the first samples stands out as a wrong one does."""
    rng = np.random.default_rng(10)
    for _ in range(300):
        t, fade, slow = np.maximum(np.arange(120) - rng.uniform(0, 4), 0.0), rng.uniform(1, 2), rng.uniform(20, 80)
        y = t / fade * np.exp(-t / fade) + 0.1 * (1 - np.exp(-t / slow)) + 1e-5 * rng.standard_normal(t.size)
        assert not [block for block in outliers(y, 1e-5, 0.0) if block[1] < 4]


@pytest.mark.parametrize(
    ("length", "share", "after", "found"),
    [
        (3, 1.0, 1.0, True),
        (3, 0.75, 1.0, True),
        (3, 0.65, 1.0, False),  # the cart itself was held for a while
        (3, 0.25, 1.0, False),  # it stood, and went on
        (3, 1.0, 0.6, True),
        (3, 1.0, 0.4, False),  # it does not move on as before
        (3, 1.0, -1.0, False),
        (9, 1.0, 1.0, False),
    ],
)
def test_a_reading_sticks_where_the_cart_moved_on_meanwhile(
    length: int, share: float, after: float, found: bool
) -> None:
    y = stopped(length, share, after)
    assert [(begin, size) for _, begin, size in _stuck(y, 1e-3, 0.0)] == ([(20, length)] if found else [])
    small = _stuck(1e-4 * y, 1e-7, 0.0)
    assert [(begin, size) for _, begin, size in small] == ([(20, length)] if found else [])


@pytest.mark.parametrize(("count", "found"), [(15, False), (19, False), (20, True), (21, True)])
def test_one_of_twenty_samples_may_be_wrong(count: int, found: bool) -> None:
    y = 1e-4 * np.arange(count) ** 2 / count
    y[7] += 5e-3
    mended = mend(record(y))
    assert bool(mended.wrong.any()) is found
    if found:
        assert mended.run.position[7] == pytest.approx(1e-4 * 49 / count, abs=1e-5)


def test_what_is_wrong_too_often_is_left_alone() -> None:
    rng, clean = np.random.default_rng(2), 2e-6 * np.random.default_rng(3).standard_normal(400)
    for count, found in ((12, 12), (28, 0)):  # 3 and 7 per cent
        y = clean.copy()
        y[8 + 13 * np.arange(count)] += 1e-3 * rng.choice([-1, 1], count)
        assert int(mend(record(y)).wrong.sum()) == found


def test_ten_counts_are_no_rounding() -> None:
    count = 1e-4
    y = np.round(np.cumsum(np.full(100, 0.37))) * count
    y[50] += 10 * count
    assert np.flatnonzero(mend(record(y, counts_per_meter=1 / count)).wrong).tolist() == [50]


def test_what_is_interpolated_keeps_to_the_step_that_readings_tell() -> None:
    count, at = 4e-3, np.arange(400)
    clean = count * np.round(12 * np.exp(-0.004 * at) * np.cos(0.05 * at)) + 0.7e-3
    y = clean.copy()
    y[[50, 200, 201]] += 40 * count
    assert record(clean).resolution == pytest.approx(count)
    mended = mend(record(y))
    assert np.flatnonzero(mended.wrong).tolist() == [50, 200, 201]
    assert mended.run.resolution == pytest.approx(count, rel=0.02)
    assert mended.run.position[[50, 200, 201]] == pytest.approx(clean[[50, 200, 201]], abs=1.01 * count)
    assert not _is_clipped(mended.run.position, mended.run.resolution or 0.0)


def test_words_of_a_fault_say_what_its_kind_does() -> None:
    mask, off = np.arange(40) == 7, np.full(40, 2e-3)
    assert _fault("r", "outliers", mask, off).words.startswith("Run 'r': 1 reading (sample 7) stands out by 2.00 mm;")
    stuck = _fault("r", "stuck readings", mask | (np.arange(40) == 9), off)
    assert stuck.words.startswith("Run 'r': 2 readings (samples 7, 9) repeat the one before;")


def test_good_readings_count_in_full() -> None:
    records = lay_out(stepid.Campaign(name="c", experiments=(record(np.linspace(0, 1e-2, 50)),)))
    wrong = np.arange(50) == 20
    assert trust(records, {}).tolist() == [1.0] * 50
    assert np.flatnonzero(trust(records, {"r": wrong}) < 1e-3).tolist() == [20]


@pytest.mark.parametrize("rest", [0.0, 0.3])
def test_outliers_of_a_residual_stand_alone(rest: float) -> None:
    residual = 1e-5 * np.random.default_rng(4).standard_normal(300)
    residual[[50, 119, 120]] += 1e-3
    assert np.flatnonzero(outliers_of(rest + residual, 1e-6)).tolist() == [50, 119, 120]
    for beside in (117, 118, 121, 122):  # half of what an outlier takes, beside it: no calm
        ring = residual.copy()
        ring[beside] += 7e-5
        assert np.flatnonzero(outliers_of(rest + ring, 1e-6)).tolist() == [50]
    assert not outliers_of(rest + residual, 2e-4).any()


@pytest.mark.parametrize("factor", [2.0, 0.5, -2.0, -0.5, 4.0, 0.25, 10.0, 0.1, 100.0, 0.01, 1e3, 1e-3, 2.54])
def test_a_round_factor_is_told_as_such(factor: float) -> None:
    for off in (0.98, 1.0, 1.02):
        assert f"Its readings are {factor:.4g} times" in _factor(off * factor)
    assert "Its readings, or its input, are" in _factor(1.04 * factor)
    assert "sign turned" in _factor(-1.01)


def test_each_kind_of_fault_has_its_words() -> None:
    layout = SimpleNamespace(stiffness=slice(0, 2), damping=slice(2, 3))
    labels = {"springs": ("soft", "hard"), "spring": [0], "dampers": ("d",), "damper": [0]}
    run = SimpleNamespace(name="a")
    records = SimpleNamespace(runs=[run], added_mass=[0.5], sample_time=[0.01], **labels)
    problem = SimpleNamespace(layout=layout, records=records)
    optimum: Any = SimpleNamespace(problem=problem, shared=np.array([200.0, 300.0, 10.0]))
    assert "With 0.75 kg added instead of 0.5 kg it agrees" in _explanation(optimum, 0, "added_mass", 0.25)
    assert "Its readings are 2 times" in _explanation(optimum, 0, "gain", 1.0)
    assert "come 2 samples after its input" in _explanation(optimum, 0, "start_time", 0.02)
    assert "zero drifting by 3.00 µm/s" in _explanation(optimum, 0, "sensor_drift", 3e-6)
    near = _explanation(optimum, 0, "stiffness", 0.45)
    assert "With a stiffness of 290 N/m, that of spring 'hard' instead of the 200 N/m of spring 'soft'" in near
    assert "'hard'" not in _explanation(optimum, 0, "stiffness", 1.0)
    assert "With a damping of 15 N·s/m instead of the 10 N·s/m of damper 'd'" in _explanation(
        optimum, 0, "damping", 0.5
    )
    assert "'a' or 'b'; without it the others agree" in fault_words(optimum, 0, "gain", 1.0, ("b",))
    assert fault_words(optimum, 0, "gain", 1.0, ()).startswith("Run 'a' disagrees with the others, which agree")
    among = fault_words(optimum, 0, "gain", 1.0, (), agree=False)
    assert among.startswith("Run 'a' disagrees with the others, and far more than these do among themselves. Its")


def off_axis(sizes: tuple[float, ...], noise: float, decay: float = 1.0) -> Any:
    """A fit that leaves an encoder's line of these amplitudes in each run, and noise."""
    t, rng = 0.01 * np.arange(400), np.random.default_rng(5)
    path = 5e-3 * (1 - np.exp(-decay * t) * np.cos(4.0 * t))
    told: dict[str, Any] = {"input": np.where(t < 0.05, 0.0, 1.0), "added_mass": 0.0, "spring": "s", "damper": "d"}
    off = [s * np.sin(2 * np.pi * path / 1.5e-3 + 0.4) + noise * rng.standard_normal(t.size) for s in sizes]
    runs = [stepid.Experiment(name=f"{i}", time=t, position=path + line, **told) for i, line in enumerate(off)]
    records, line = lay_out(stepid.Campaign(name="c", experiments=tuple(runs))), np.concatenate(off)
    problem = SimpleNamespace(
        records=records, residual=lambda _: records.weighted(line), jacobian=lambda _: np.ones((records.size, 1))
    )
    return SimpleNamespace(problem=problem, solved=None, residual=line)


def test_the_noise_of_the_readings_is_no_line_in_position() -> None:
    """In the readings' own position it stands as it does in the residual: a sine of a few times its size takes it."""
    for noise in (5e-6, 2e-5, 2e-4):
        assert find_eccentricity(off_axis((0.0,) * 3, noise, decay=3.0), 0.97 * noise) is None


def test_an_encoder_off_its_axis_takes_most_of_what_is_left() -> None:
    found = find_eccentricity(off_axis((2e-5,) * 3, 5e-6), 5e-6)
    assert found is not None
    assert found.amplitude == pytest.approx(2e-5, rel=0.05)
    assert found.pitch == pytest.approx(1.5e-3, rel=0.02)
    half = 2e-5 / math.sqrt(2)  # as much again is something else
    assert find_eccentricity(off_axis((2e-5,) * 3, half), 5e-6) is None
    assert find_eccentricity(off_axis((2e-5,) * 3, half), half) is not None


@pytest.mark.parametrize(("steps", "cause"), [(4.0, "every 4 steps"), (2.02, "every 2 steps"), (4.2, "off its axis")])
def test_a_line_that_comes_again_with_the_steps_of_a_counter_is_theirs(steps: float, cause: str) -> None:
    records: Any = SimpleNamespace(runs=[Kept(resolution=1e-5)] * 2)
    assert cause in _cause(steps * 1e-5, records)


@pytest.mark.parametrize(("turning", "found"), [(0.5, True), (1.3, False)])
def test_the_reading_of_an_encoder_off_its_axis_goes_on_with_the_cart(turning: float, found: bool) -> None:
    """At 2π·amplitude/pitch = 1 it stands still once a turn; coarse readings leave such lines."""
    size = turning * 1.5e-3 / (2 * math.pi)
    assert (find_eccentricity(off_axis((size,) * 3, 5e-6), 5e-6) is not None) is found


def test_an_encoder_off_its_axis_is_so_in_all_runs() -> None:
    assert find_eccentricity(off_axis((2e-5, 2e-5, 2e-5, 1.7e-5), 1e-6), 1e-6) is not None
    assert find_eccentricity(off_axis((2e-5, 2e-5, 2e-5, 1.0e-5), 1e-6), 1e-6) is None


@pytest.mark.parametrize(("apart", "accused"), [(0.9, True), (1.1, False)])
def test_a_worse_explanation_of_a_misfit_is_none(monkeypatch: pytest.MonkeyPatch, apart: float, accused: bool) -> None:
    """Worse by χ² = 10 at the level of the noise; the cost told is the least that was reached."""
    records = SimpleNamespace(runs=[SimpleNamespace(name=name) for name in "abc"], weighed_size=400.0)
    held = SimpleNamespace(layout=None, records=records)
    last: Any = SimpleNamespace(problem=held, shared=None, local=None)
    level, fields = 2e-5, {"kind": "gain", "error": 0.0, "scatter": 0.0, "optimum": last}
    costs = [400 * level**2, (400 + 10 * apart) * level**2]
    found = [SimpleNamespace(run=i, size=float(i), cost=cost, **fields) for i, cost in enumerate(costs)]
    optimum: Any = SimpleNamespace(problem=SimpleNamespace(records=records), cost=1.0)
    monkeypatch.setattr(run_fault, "_candidates", lambda *_: [])
    monkeypatch.setattr(run_fault, "_all_fitted", lambda *_: found)
    monkeypatch.setattr(run_fault, "_has_size", lambda one, _: one.size > 0.5)  # of the second alone
    monkeypatch.setattr(run_fault, "_explains", lambda *_: True)
    monkeypatch.setattr(run_fault, "fault_words", lambda *_, **__: "words")
    ends: list[Any] = [None, SimpleNamespace(cost=0.5 * costs[1]), SimpleNamespace(cost=2.0)]
    for done, cost in zip(ends, (costs[1], 0.5 * costs[1], costs[1]), strict=True):
        monkeypatch.setattr(run_fault, "minimize", lambda *_, end=done, **__: end)
        told = run_fault.accuse(optimum, 1e-6)
        assert (told is not None) is accused
        assert told is None or (told.fault.run, told.cost) == ("b", cost)


@pytest.mark.parametrize(("read", "factor"), [(2.07, 2.0), (-0.93, -1.0), (0.48, 0.5), (1.3, 1.3)])
def test_a_rough_factor_is_taken_for_the_round_one_that_fits_as_well(
    monkeypatch: pytest.MonkeyPatch, read: float, factor: float
) -> None:
    runs = tuple(record(np.linspace(0.0, size, 50)).model_copy(update={"name": f"{size}"}) for size in (1e-3, 2e-3))
    records = lay_out(stepid.Campaign(name="c", experiments=runs))
    layout = SimpleNamespace(deviation=lambda _: 0)
    problem = SimpleNamespace(layout=layout, records=records, simulator=SimpleNamespace(effects=("one",)))
    optimum: Any = SimpleNamespace(problem=problem, shared=None, local=None, cost=1.0)
    rough = SimpleNamespace(local=np.array([[0.0, read - 1]]), cost=0.5)
    tried: list[Any] = []

    def refit(_: Any, mended: Any, __: float) -> Any:
        tried.append(mended)
        return SimpleNamespace(cost=0.4)

    monkeypatch.setattr(run_fault, "with_fault", lambda *_: problem)
    monkeypatch.setattr(run_fault, "minimize", lambda *_, **__: rough)
    monkeypatch.setattr(run_fault, "_refit", refit)
    monkeypatch.setattr(run_fault, "standard_error", lambda *_: 0.0)
    monkeypatch.setattr(run_fault, "scatter_of_others", lambda *_: 0.0)
    found = run_fault._fitted(optimum, 1, "gain", 1e-6)
    assert found is not None
    assert found.size == pytest.approx(factor - 1)
    assert len(tried) == (factor != read)
    for mended in tried:
        np.testing.assert_allclose(mended.position, np.append(runs[0].position, runs[1].position / factor))
        np.testing.assert_allclose(mended.weight, np.repeat([1.0, abs(factor)], 50))
