"""What a candidate earns: effective samples, the price of parameters, QBIC and its weights, and when all is told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from made_up_evidence import FLOOR, RUNS, SAMPLES, candidate, context, evidence, losing, white
from stepid.diagnosis.criteria import Criteria
from stepid.diagnosis.evidence import at_floor, effective_samples, is_white, least_share, part_left, price, weigh
from stepid.diagnosis.selection.candidate import Candidate


def test_white_noise_has_as_many_effective_samples_as_samples() -> None:
    counts = np.mean([effective_samples(context().records, white(seed)) for seed in range(20)], axis=0)
    assert counts.shape == (RUNS,)
    assert counts == pytest.approx(SAMPLES, rel=0.12)


@pytest.mark.parametrize("memory", [0.5, 0.8])
def test_correlated_noise_has_fewer(memory: float) -> None:
    """For AR(1) ρ_k = a^k, so that n/(1 + 2 Σρ²) = n (1 − a²)/(1 + a²)."""
    found = []
    for seed in range(40):
        residual = lfilter([1.0], [1.0, -memory], white(seed))
        found.append(effective_samples(context().records, residual).mean())
    assert np.mean(found) == pytest.approx(SAMPLES * (1 - memory**2) / (1 + memory**2), rel=0.25)


def test_a_sine_has_hardly_any_and_nothing_has_all() -> None:
    records = context().records
    assert effective_samples(records, np.sin(0.2 * np.arange(RUNS * SAMPLES))).max() < 0.1 * SAMPLES
    assert (effective_samples(records, np.zeros(RUNS * SAMPLES)) == SAMPLES).all()


def test_a_parameter_costs_the_logarithm_of_the_samples_it_is_fitted_to() -> None:
    counts = np.full(RUNS, 50.0)
    plain, one = candidate(), candidate(["coulomb_friction"])
    late = candidate(deviations=["start_time"])

    def cost(found: Candidate) -> float:
        return price(found.optimum, counts, FLOOR**2)

    assert cost(one) - cost(plain) == pytest.approx(math.log(RUNS * 50.0))
    assert cost(late) - cost(plain) == pytest.approx((RUNS - 1) * math.log(50.0))


def test_weights_sum_to_one_and_fall_by_the_loss() -> None:
    best = candidate(["coulomb_friction"])
    second, far = losing(best, 3.0, ["cubic_stiffness"]), candidate(times=30.0)
    found = weigh(context(), [far, second, best])
    assert [w.candidate for w in found] == [best, second, far]
    assert [w.loss for w in found[:2]] == pytest.approx([0.0, 3.0], abs=1e-6)
    assert sum(w.weight for w in found) == pytest.approx(1.0)
    assert found[1].weight / found[0].weight == pytest.approx(math.exp(-1.5))
    assert found[2].weight < 1e-100


def test_a_perfect_fit_is_weighed_too() -> None:
    zero = candidate(["coulomb_friction"], times=0.0)
    assert weigh(context(), [zero, candidate()])[0].candidate is zero


def test_a_further_effect_that_takes_nothing_loses_its_price() -> None:
    best = candidate(["coulomb_friction"])
    more = candidate(["coulomb_friction", "cubic_stiffness"])
    one, two = weigh(context(), [more, best])
    assert one.candidate is best
    assert two.loss == pytest.approx(math.log(effective_samples(context().records, white()).sum()))


def test_at_the_floor_is_white_noise_of_the_floors_size() -> None:
    criteria = Criteria()
    slow = np.sin(0.2 * np.arange(RUNS * SAMPLES))
    assert at_floor(context(), criteria, candidate())
    assert not at_floor(context(), criteria, candidate(structure=criteria.white))
    assert not at_floor(context(), criteria, candidate(times=1.5))
    assert not at_floor(context(), criteria, candidate(times=1.5 * criteria.near))
    assert is_white(context(), candidate(), 2.0)
    assert not is_white(context(), candidate(residual=slow), 5.0)


def test_the_linear_plant_is_found_among_the_candidates() -> None:
    e = evidence(candidate(["coulomb_friction"]))
    assert e.linear.names == ()
    assert e.times(e.linear) == pytest.approx(10.0)
    assert e.best.names == ("coulomb_friction",)
    assert e.context.floor == FLOOR


def test_scatter_has_its_price_and_readings_count_by_their_weight(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = np.full(4, 50.0)
    plain = price(candidate().optimum, counts, 1e-10)
    monkeypatch.setattr("stepid.diagnosis.evidence.price_of_scatter", lambda *_: 7.0)
    assert price(candidate().optimum, counts, 1e-10) == pytest.approx(plain + 7.0)
    made = context()
    made.records.weighed_size = 100.0  # of 400 readings
    monkeypatch.setattr("stepid.diagnosis.evidence.is_white", lambda *_: False)
    criteria = Criteria(near=1.5)
    most = criteria.floor + 2 / math.sqrt(100)
    assert most < criteria.near
    assert at_floor(made, criteria, candidate(times=0.999 * most))
    assert not at_floor(made, criteria, candidate(times=1.001 * most))


def test_readings_that_weigh_less_are_fewer_and_a_mean_is_one() -> None:
    """A cart that rests reads the same count over and over: an eighth of a reading each; means of ten weigh ten."""
    rests = np.arange(RUNS * SAMPLES) % SAMPLES >= SAMPLES // 2
    for weight, each in ((1 / 8, (SAMPLES + SAMPLES / 8) / 2), (10.0, SAMPLES)):
        records = context().records
        records.weight = np.sqrt(np.where(rests, weight, 1.0))
        counts = np.mean([effective_samples(records, records.weight * white(seed)) for seed in range(40)], axis=0)
        if weight < 1:
            assert counts == pytest.approx(each, rel=0.15)
        assert (effective_samples(records, np.zeros(RUNS * SAMPLES)) == each).all()


def test_a_rest_that_hardly_weighs_makes_no_more_of_what_follows_itself() -> None:
    """Nine tenths at rest: what is correlated while the cart moves tells as little as without that rest."""
    records, whole = context().records, []
    moving = np.arange(RUNS * SAMPLES) % SAMPLES < SAMPLES // 5
    for seed in range(40):
        noise = lfilter([1.0], [1.0, -0.8], white(seed))
        for weight in (np.where(moving, 1.0, 1e-3), moving.astype(float)):
            records.weight = weight
            whole.append(effective_samples(records, weight * noise).mean())
    with_rest, alone = np.mean(whole[::2]), np.mean(whole[1::2])
    assert with_rest == pytest.approx(alone, rel=0.05)
    assert with_rest < 0.6 * SAMPLES / 5


def test_what_is_free_in_every_run_has_to_reach_the_floor() -> None:
    """1.05 and 2/√400; what has no such freedom may leave more, within `near`."""
    for times, there in ((1.14, True), (1.16, False)):
        found = candidate(["periodic_disturbance"], times=times)
        assert at_floor(context(), Criteria(near=1.5), found) is there
        assert at_floor(context(), Criteria(near=1.5), candidate(["coulomb_friction"], times=times))


def test_a_rest_is_no_correlation_and_two_samples_are_the_least() -> None:
    residual = white(3)
    moved = residual + np.repeat([0.0, 1e-3, -2e-3, 5e-4], SAMPLES)
    assert effective_samples(context().records, moved) == pytest.approx(effective_samples(context().records, residual))
    few = np.array([1.0, 1.0, 50.0, 50.0])  # of a run that tells hardly anything a parameter costs ln 2
    late, plain = candidate(deviations=["start_time"]), candidate()
    cost = [price(one.optimum, few, FLOOR**2) for one in (late, plain)]
    assert cost[0] - cost[1] == pytest.approx(math.log(2) + 2 * math.log(50.0))


@pytest.mark.parametrize(("count", "share"), [(1, 0.8), (2, 0.9), (3, 0.95)])
def test_each_further_effect_halves_what_a_lead_may_leave(count: int, share: float) -> None:
    assert least_share(Criteria(lead=0.8), count) == pytest.approx(share)


def test_what_is_less_than_rounding_leaves_is_no_evidence() -> None:
    told = context()
    told.rounding_cost = RUNS * SAMPLES * FLOOR**2
    rounded, follows = candidate(["coulomb_friction"], times=0.9), candidate(["coulomb_friction", "cogging"], times=0.4)
    first, second = weigh(told, [rounded, follows])
    assert (first.candidate, second.candidate) == (rounded, follows)
    assert 0 < second.loss < 30  # what its parameters cost
    assert weigh(context(), [rounded, follows])[0].candidate is follows


def test_a_fit_below_rounding_is_at_the_floor_whatever_it_looks_like() -> None:
    slow = candidate(["coulomb_friction"], times=0.9, structure=50.0)
    told = context()
    assert not at_floor(told, Criteria(), slow)
    told.rounding = FLOOR
    assert at_floor(told, Criteria(), slow)


@pytest.mark.parametrize(
    ("before", "after", "part"),
    [(5.0, 3.0, 0.5), (5.0, 0.5, 0.0), (5.0, 9.0, 2.0), (1.0, 9.0, 1.0), (0.5, 0.5, 1.0)],  # the last two: no power
)
def test_the_part_of_a_power_above_the_noise_that_is_left(before: float, after: float, part: float) -> None:
    assert part_left(before, after, 1.0) == part
