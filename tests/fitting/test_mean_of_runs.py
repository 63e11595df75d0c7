"""The plant is the mean of its runs: values do not hang on which run comes first, and intervals hold the scatter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import stepid
from broken_campaigns import campaign
from scattered_campaigns import scattered
from stepid.core.estimate import Estimate
from stepid.core.experiment import Campaign
from stepid.effects import resolve
from stepid.fitting.covariance import estimates
from stepid.fitting.deviations import with_deviations
from stepid.fitting.fit import prepare, unpack
from stepid.fitting.fit_effects import fit_effects
from stepid.fitting.levenberg_marquardt import Optimum, minimize
from stepid.fitting.mean_of_runs import centered, starts_late

GAINS = (0.02, -0.015, 0.03, 0.0, -0.025, 0.01)


def refit(inner: Optimum, *kinds: str) -> Optimum:
    found = minimize(with_deviations(inner.problem, kinds), inner.shared, inner.local)
    assert found is not None
    return found


def free_in_all(whole: Campaign, kind: str) -> tuple[Optimum, dict[str, Estimate]]:
    context = prepare(whole)
    found = refit(context.linear, kind)
    return found, estimates(found, (), context.floor)[0]


@pytest.mark.slow
def test_the_gain_is_the_mean_of_the_runs() -> None:
    alike = prepare(scattered(1))
    true = estimates(alike.linear, (), alike.floor)[0]["force_gain"].value
    _, found = free_in_all(scattered(1, gain=GAINS), "gain")
    gain = found["force_gain"]
    assert gain.value == pytest.approx(true * (1 + np.mean(GAINS)), rel=1e-3)
    assert gain.parts["runs"] == pytest.approx(gain.value * np.std(GAINS, ddof=1) / np.sqrt(6), rel=0.05)
    assert gain.uncertainty == pytest.approx(np.sqrt(sum(p**2 for p in gain.parts.values())))
    assert gain.interval is not None
    half = (gain.interval[1] - gain.interval[0]) / 2
    rest = np.hypot(gain.parts["noise"], gain.parts.get("weights", 0.0))
    assert half == pytest.approx(np.hypot(1.96 * rest, stats.t.ppf(0.975, 5) * gain.parts["runs"]), rel=1e-3)
    assert "runs" not in found["base_mass"].parts
    assert found["base_mass"].limits is None


@pytest.mark.parametrize("kind", ["gain", "damping"])
def test_the_order_of_runs_does_not_matter(kind: str) -> None:
    whole = scattered(2, gain=GAINS if kind == "gain" else None, damping=GAINS if kind == "damping" else None)
    turned = whole.model_copy(update={"experiments": whole.experiments[::-1]})
    (_, one), (_, other) = free_in_all(whole, kind), free_in_all(turned, kind)
    for name, value in one.items():
        assert value.value == pytest.approx(other[name].value, rel=1e-5), name
        assert value.uncertainty == pytest.approx(other[name].uncertainty, rel=0.01), (
            name
        )  # the first is held by no bound


def test_centering_changes_no_reading() -> None:
    found, _ = free_in_all(scattered(2, gain=GAINS), "gain")
    about = centered(found)
    solved = about.problem.solve(about.shared, about.local)
    assert solved is not None
    np.testing.assert_allclose(solved.reading, found.solved.reading, atol=1e-9)
    row = about.problem.layout.deviation("gain")
    assert about.local[row].mean() == pytest.approx(0, abs=1e-12)
    assert found.local[row, 0] == 0 != about.local[row, 0]


def test_the_model_and_the_table_hold_the_same_numbers() -> None:
    found, values = free_in_all(scattered(2, gain=GAINS), "gain")
    model = unpack(found, ())
    assert model.force_gain == values["force_gain"].value
    assert sum(state.deviations["gain"] for state in model.runs.values()) == pytest.approx(0, abs=1e-9)


def test_friction_is_the_mean_of_the_runs() -> None:
    whole = campaign(1, {"coulomb_friction": {"level": 0.4}})
    context = prepare(whole)
    effects = tuple(resolve(["coulomb_friction"]))
    inner = fit_effects(context, effects)
    assert inner is not None
    found = refit(inner, "friction")
    value = estimates(found, effects, context.floor)[0]["coulomb_friction.level"]
    row = found.problem.layout.deviation("friction")
    levels = found.shared[found.problem.layout.values[0]] * (1 + found.local[row])
    assert value.value == pytest.approx(levels.mean())
    assert value.parts["runs"] == pytest.approx(levels.std(ddof=1) / np.sqrt(levels.size))


def test_a_diagnosis_names_the_parts() -> None:
    whole = scattered(3, gain=tuple(3 * g for g in GAINS))
    done = stepid.diagnose(whole)
    assert "gain" in done.scatter
    assert done.parameters["force_gain"].parts["runs"] > done.parameters["force_gain"].parts["noise"]


@pytest.mark.parametrize(
    ("late", "delay"),
    [
        ((8.0, 8.1, 7.9, 8.0), True),
        ((-3.0, -3.2, -2.8, -3.1), True),
        ((1.0, -1.0, 0.4, 0.2), False),
        ((3.0, 0.1, 1.4, 2.2), False),  # half of it is scatter
        ((2.5, 4.5, 3.2, 4.4), False),  # four standard deviations: chance does that to four
    ],
)
def test_start_times_that_all_runs_share_are_a_delay(late: tuple[float, ...], delay: bool) -> None:
    linear = prepare(campaign(1)).linear
    assert not starts_late(linear)
    free = replace(linear, problem=with_deviations(linear.problem, ("start_time",)), local=linear.local.copy())
    free.local[free.problem.layout.deviation("start_time")] = 1e-3 * np.array(late)
    assert starts_late(free) is delay
