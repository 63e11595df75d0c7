"""`identify` says when more than noise is left of the runs, and says nothing where they are linear."""

from __future__ import annotations

import numpy as np
import pytest

import stepid
from closed_form import Plant, draw_plant, make_campaign
from stepid.identification.remainder import remainder, warning

PLANT = Plant(base_mass=0.95, stiffness=216.0, damping=12.0)


def warnings(found: stepid.IdentifiedParameters) -> list[str]:
    return [note for note in found.notes if "stepid.diagnose" in note]


@pytest.mark.parametrize("count", [6, pytest.param(150, marks=pytest.mark.slow)])
def test_linear_campaigns_are_not_warned_of(count: int) -> None:
    warned = []
    for number in range(count):
        rng = np.random.default_rng([41, number])
        noise = float(np.exp(rng.uniform(np.log(5e-6), np.log(2e-4))))
        campaign = make_campaign(draw_plant(rng), rng, noise=noise, weight_spread=0.005)
        warned += warnings(stepid.identify(campaign))
    assert not warned


@pytest.mark.parametrize("effect", [{"level": 0.1}, None])
def test_a_law_that_is_not_linear_is_warned_of(effect: dict[str, float] | None) -> None:
    rng = np.random.default_rng(42)
    campaign = make_campaign(PLANT, rng)
    name, size = ("coulomb_friction", effect) if effect else ("cubic_stiffness", {"coefficient": 4e4})
    model = stepid.fit(campaign).model
    bent = model.model_copy(update={"effects": (stepid.EffectModel(name=name, values=size),)})
    seen = stepid.simulate(bent, campaign)
    runs = [
        e.model_copy(update={"position": seen[e.name] + 2e-5 * rng.standard_normal(e.time.size)})
        for e in campaign.experiments
    ]
    found = stepid.identify(campaign.model_copy(update={"experiments": tuple(runs)}))
    (note,) = warnings(found)
    assert "a diagnosis (stepid.diagnose) looks for the cause" in note
    assert note in found.summary()
    assert "stepid.diagnose" in found._repr_html_()


def test_slow_noise_is_noise() -> None:
    rng = np.random.default_rng(43)
    campaign = make_campaign(PLANT, rng, window=8.0)
    runs = []
    for e in campaign.experiments:
        slow = np.convolve(rng.standard_normal(e.time.size + 3), np.full(4, 0.5), "valid")
        runs.append(e.model_copy(update={"position": e.position + 2e-5 * slow}))
    assert not warnings(stepid.identify(campaign.model_copy(update={"experiments": tuple(runs)})))


def test_a_release_is_fitted_with_its_start() -> None:
    rng = np.random.default_rng(45)
    decay, frequency = PLANT.rates(0.0)
    time = 0.004 * np.arange(800)
    swing = 0.02 * np.exp(-decay * time) * np.cos(frequency * time + 0.3) + 2e-5 * rng.standard_normal(800)
    bare = stepid.Experiment(
        name="r", time=time, position=swing, input=0 * time, added_mass=0.0, spring="s", damper="d", starts="motion"
    )
    found = remainder(bare, damped_frequency=1.05 * frequency, damping_ratio=0.3)
    assert found is not None
    assert warning([found]) is None
    assert found.square == pytest.approx(found.noise, rel=0.2)


def test_only_held_inputs_are_looked_at() -> None:
    run = make_campaign(PLANT, np.random.default_rng(44)).experiments[0]
    lines = run.model_copy(update={"input_between": "lines"})
    decay, frequency = PLANT.rates(0.0)
    how = {"damped_frequency": frequency, "damping_ratio": decay / float(np.hypot(decay, frequency))}
    assert remainder(lines, **how) is None
    assert warning([None]) is None
    exact = remainder(run, **how)
    assert exact is not None
    assert exact.square < 1e-18


def test_a_fine_record_is_fitted_by_means_of_neighbors_and_judged_by_all_samples(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    decay, frequency = PLANT.rates(0.0)
    time = 5e-5 * np.arange(60_000)  # 8,600 samples a period
    volts = np.where((time >= 0.02003) & (time < 1.7), 0.5, 0.0)
    since = [np.maximum(time - at, 0.0) for at in (time[volts > 0][0], time[volts > 0][-1] + 5e-5)]
    up, down = (
        1 - np.exp(-decay * t) * (np.cos(frequency * t) + decay / frequency * np.sin(frequency * t)) for t in since
    )
    noise = 2e-5 * np.random.default_rng(46).standard_normal(time.size)
    run = stepid.Experiment(
        name="r", time=time, position=0.018 * (up - down) + noise, input=volts, added_mass=0.0, spring="s", damper="d"
    )
    how = {"damped_frequency": 1.02 * frequency, "damping_ratio": 0.3}
    fine = remainder(run, **how)
    monkeypatch.setattr("stepid.identification.remainder._FINE", 1e9)
    every = remainder(run, **how)
    assert fine is not None
    assert every is not None
    assert fine.samples == every.samples == time.size - 4
    assert every.square <= fine.square < every.square * (1 + 1e-6)  # the least square, but for a part of chance: 2/n
    assert fine.means == pytest.approx(every.means, rel=1e-3)
    assert fine.square == pytest.approx(float(noise @ noise), rel=2e-4)


def test_many_changes_of_the_input_are_convolved_as_few_are_added_up(monkeypatch: pytest.MonkeyPatch) -> None:
    run = make_campaign(PLANT, np.random.default_rng(47), noise=2e-5).experiments[0]
    decay, frequency = PLANT.rates(0.0)
    how = {"damped_frequency": frequency, "damping_ratio": decay / float(np.hypot(decay, frequency))}
    few = remainder(run, **how)
    monkeypatch.setattr("stepid.identification.remainder._FEW", 0)
    many = remainder(run, **how)
    assert few is not None
    assert many is not None
    assert tuple(few) == pytest.approx(tuple(many), rel=1e-9)
