"""`identify` says when `fit` would be tighter, and by as much as it is."""

from __future__ import annotations

import re

import numpy as np
import pytest

import stepid
from stepid.identification import tightness

PLANT = stepid.PlantModel(base_mass={"cart": 1.0}, stiffness={"medium": 216.0}, damping={"half": 10.0}, force_gain=7.8)


def campaign(noise: float, weights: float) -> stepid.Campaign:
    rng = np.random.default_rng(5)
    time = 0.0088542 * np.arange(400)
    runs = [
        stepid.Experiment(
            name=f"run {i}", time=time, position=0 * time, input=np.where(time < 0.05, 0.0, 0.5), added_mass=0.5 * i,
            spring="medium", damper="half",
        )
        for i in range(3)
    ]  # fmt: skip
    empty = stepid.Campaign(name="made up", experiments=runs, weight_uncertainty=weights)
    clean = stepid.simulate(PLANT, empty)
    noisy = [e.model_dump() | {"position": clean[e.name] + noise * rng.standard_normal(e.time.size)} for e in runs]
    return empty.model_copy(update={"experiments": tuple(stepid.Experiment(**fields) for fields in noisy)})


def test_the_promise_is_what_fit_gives() -> None:
    made = campaign(20e-6, 1e-7)
    found = stepid.identify(made)
    (note,) = found.notes
    assert note in found.summary()
    assert note in found._repr_html_()
    times, what, promised, here = re.search(
        r"would be ([\d.]+) times as tight: ([\w ]+) within ([\d.]+) .*, here ([\d.]+)", note
    ).groups()  # type: ignore[union-attr]
    assert float(times) > 5
    assert float(here) / float(promised) == pytest.approx(float(times), rel=0.1)
    name = {"base mass": "base_mass", "stiffness": "stiffness[medium]", "damping": "damping[half]"}[what]
    assert stepid.fit(made).parameters[name].uncertainty == pytest.approx(float(promised), rel=0.15)


def test_what_the_weights_leave_open_is_not_promised() -> None:
    made = campaign(100e-6, 5e-3)
    (note,) = stepid.identify(made).notes
    what, promised = re.search(r"tight: ([\w ]+) within ([\d.]+) ", note).groups()  # type: ignore[union-attr]
    name = {"base mass": "base_mass", "stiffness": "stiffness[medium]", "damping": "damping[half]"}[what]
    assert stepid.fit(made).parameters[name].uncertainty == pytest.approx(float(promised), rel=0.15)


def test_nothing_is_said_where_the_weights_decide() -> None:
    assert stepid.identify(campaign(1e-6, 0.02)).notes == ()


def test_the_papers_own_runs_are_not_promised_anything() -> None:
    data = stepid.datasets.burchett()
    assert stepid.solve(stepid.assemble(data.characteristics, data.mass_offsets)).notes == ()


def test_an_input_beyond_all_numbers_promises_nothing() -> None:
    made = campaign(20e-6, 1e-7)
    first, *others = made.experiments
    huge = stepid.Experiment(**first.model_dump() | {"input": -1e300 * first.input})
    notes = stepid.identify(made.model_copy(update={"experiments": (huge, *others)})).notes
    assert not any("as tight" in note for note in notes)


def test_some_samples_of_a_long_run_stand_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    made = campaign(20e-6, 1e-7)
    found = stepid.identify(made)
    shared = tightness._Shared(list(found.base_mass), list(found.stiffness), list(found.pooled_damping))
    every = tightness._joint(made.experiments, found, shared, 1e-7)
    monkeypatch.setattr(tightness, "_ENOUGH", 130)  # of 400: every fourth
    some = tightness._joint(made.experiments, found, shared, 1e-7)
    assert every is not None
    assert some == pytest.approx(every, rel=0.03)
    assert not np.array_equal(some, every)


def _found(made: stepid.Campaign, **changes: object) -> stepid.IdentifiedParameters:
    return stepid.identify(made).model_copy(update=changes)


def test_nothing_is_promised_that_one_cannot_tell() -> None:
    made = campaign(20e-6, 1e-7)
    runs = made.experiments
    told = tightness.tighter_by_fit(runs, _found(made), 1e-7)
    assert told is not None
    assert tightness.tighter_by_fit(runs, _found(made, misfit=2.1), 1e-7) is None  # runs that contradict each other
    assert tightness.tighter_by_fit(runs, _found(made, misfit=1.9), 1e-7) == told
    assert tightness.tighter_by_fit(runs, _found(made, static_gain={}), 1e-7) is None
    lines = [run.model_copy(update={"input_between": "lines"}) for run in runs]
    assert tightness.tighter_by_fit(lines, _found(made), 1e-7) is None
    still = [run.model_copy(update={"position": 0 * run.position}) for run in runs]
    assert tightness.tighter_by_fit(still, _found(made), 1e-7) is None  # no noise is seen


def test_an_input_that_changes_all_the_time_is_not_looked_at() -> None:
    made = campaign(20e-6, 1e-7)
    waves = np.where(np.arange(400) % 9 < 4, 0.5, 0.0)
    busy = [run.model_copy(update={"input": waves}) for run in made.experiments]
    assert tightness.tighter_by_fit(busy, _found(made), 1e-7) is None


def test_a_gain_of_less_than_two_is_not_worth_a_word() -> None:
    made = campaign(20e-6, 1e-7)
    found = _found(made)
    u = found.uncertainty
    shared = tightness._Shared(list(found.base_mass), list(found.stiffness), list(found.pooled_damping))
    mass, k, c = tightness._joint(made.experiments, found, shared, 1e-7)[:3]
    for times, said in ((1.9, False), (2.1, True)):
        fewer = u.model_copy(
            update={
                "base_mass": {"cart": times * mass}, "stiffness": {"medium": k}, "pooled_damping": {"half": c}
            }
        )  # fmt: skip
        other = found.model_copy(update={"uncertainty": fewer})
        assert (tightness.tighter_by_fit(made.experiments, other, 1e-7) is not None) is said
