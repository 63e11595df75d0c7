"""Campaigns that a joint fit cannot use, or in part: a clear error, or what was left out by name."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import stepid
import stepid.fitting.candidate_fit as search
from broken_campaigns import FRICTION, NOISE, SAMPLE_TIME, campaign, changed, inputs, scaled
from closed_form import Plant
from stepid.effects import resolve
from stepid.errors import InputError, UndeterminedError
from stepid.fitting.levenberg_marquardt import minimize
from stepid.fitting.problem import build, start_local
from stepid.fitting.screening import screen
from stepid.simulation.records import lay_out

WHOLE = campaign(1)


def with_fields(**fields: Any) -> stepid.Campaign:
    """Every run changed; fields are functions of a run."""
    out = WHOLE
    for run, e in enumerate(WHOLE.experiments):
        out = changed(out, run, **{name: make(e) for name, make in fields.items()})
    return out


def test_a_value_that_is_no_number_is_refused_at_construction() -> None:
    position = WHOLE.experiments[1].position.copy()
    position[7] = np.nan
    with pytest.raises(InputError, match=r"'case 2'.*not finite, the first at index 7"):
        changed(WHOLE, 1, position=position)


@pytest.mark.parametrize("scale", [226600.0, 1e-8])
def test_positions_in_other_units_than_meters_are_refused(scale: float) -> None:
    whole = with_fields(position=lambda e: e.position * scale, counts_per_meter=lambda e: None)
    with pytest.raises(InputError, match=r"run 'case 1': its positions span .* m, .*counts_per_meter"):
        stepid.fit(whole)


@pytest.mark.parametrize("noise", [0.0, NOISE])
def test_a_run_at_rest_is_left_out(noise: float) -> None:
    rest = noise * np.random.default_rng(2).standard_normal(420)
    found = stepid.fit(changed(WHOLE, 2, position=rest))
    assert "case 3" not in found.run_rms
    assert found.notes[0].startswith("Run 'case 3' is left out: nothing moves in it although 0.5 V is commanded.")


def test_runs_at_rest_throughout_are_refused() -> None:
    still = with_fields(position=lambda e: 0.0 * e.position)
    with pytest.raises(
        InputError, match=r"no run can be used.*'case 1' is left out.*'case 4' is left out.*drive was on"
    ):
        stepid.fit(still)


def test_copies_are_no_repeats() -> None:
    first = WHOLE.experiments[0]
    copies = stepid.Campaign(
        name="copies", experiments=(*WHOLE.experiments, changed(WHOLE, 0, name="again").experiments[0])
    )
    found = stepid.fit(copies)
    assert found.run_rms.keys() == stepid.fit(WHOLE).run_rms.keys()
    assert found.notes == (
        "Runs 'case 1', 'again' hold the same record, sample for sample: copies, no repeats; one of them is used.",
    )
    twisted = changed(WHOLE, 1, position=first.position, input=first.input)
    found = stepid.fit(twisted)
    assert set(found.run_rms) == {"case 3", "case 4"}
    assert re.search(r"'case 1', 'case 2' hold the same record under different labels.*left out", found.notes[0])


def asleep(on: int, level: float = 0.5, noise: float = NOISE) -> stepid.Campaign:
    """A square wave of which the amplifier passes on nothing before sample `on`."""
    commanded = np.tile(np.repeat([level, 0.0], 400), 2)
    passed = np.where(np.arange(commanded.size) < on, 0.0, commanded)
    drives = [inputs(0.5), inputs(-0.5), passed]
    whole = campaign(4, masses=(0.0, 1.5, 0.5), drives=drives, noise=noise)
    return changed(whole, 2, input=commanded)


def test_a_weak_first_level_is_no_amplifier_that_was_off() -> None:
    """Changes as small meet a cart that moves already: they say nothing of what one at rest answers to."""
    stairs = np.repeat([0.004, 0.5, 0.503, 0.3, 0.302, 0.0], 80)
    whole = campaign(4, masses=(0.0, 1.5, 0.5), drives=[inputs(0.5), inputs(-0.5), stairs], noise=2e-4)
    screened = screen(whole)
    assert screened.campaign["case 3"].time.size == stairs.size
    assert not any("amplifier" in note for note in screened.notes)


@pytest.mark.parametrize(("on", "first"), [(800, 800), (60, 400), (500, 800), (900, 1200)])
def test_a_stretch_with_the_amplifier_off_is_left_out(on: int, first: int) -> None:
    screened = screen(asleep(on))
    kept = screened.campaign["case 3"]
    assert kept.time[0] == pytest.approx((first - 10) * SAMPLE_TIME)
    assert kept.input_before == (0.5 if first % 800 else 0.0)
    assert re.search(rf"'case 3': the first {first - 10} samples, .*nothing answers.*amplifier off", screened.notes[0])
    found = stepid.fit(asleep(on))
    assert found.rms < 1.05 * found.noise
    assert found.notes == screened.notes


def test_a_flicker_of_a_coarse_reading_is_no_answer() -> None:
    whole = asleep(60, noise=0.0)
    position = np.round(whole.experiments[2].position, 4)  # in steps that nobody has told, and still between swings
    position[4:] += 1e-4
    kept = screen(changed(whole, 2, position=position, counts_per_meter=None)).campaign["case 3"]
    assert kept.time[0] == pytest.approx(390 * SAMPLE_TIME)


def test_what_comes_before_a_jump_of_the_reading_is_left_out() -> None:
    whole = campaign(
        4, masses=(0.0, 1.5, 0.5), drives=[inputs(0.5), inputs(-0.5), np.tile(np.repeat([0.5, 0.0], 400), 2)]
    )
    position = whole.experiments[2].position.copy()
    position[0] -= 8e-3
    screened = screen(changed(whole, 2, position=position))
    assert re.search(r"'case 3': the first 3\d\d samples, up to a jump of \d", screened.notes[0])


def test_a_run_that_moves_before_its_first_step_starts_in_motion() -> None:
    run = WHOLE.experiments[1]
    late = changed(WHOLE, 1, **{n: getattr(run, n)[30:] for n in ("time", "position", "input")}, input_before=-0.5)
    assert screen(late)[:2] == (
        late,
        ("Run 'case 2' starts in motion: its initial position and velocity are fitted, too.",),
    )
    found = stepid.fit(late)
    assert found.rms < 1.05 * found.noise
    assert found.model.runs["case 2"].velocity != 0
    said = changed(late, 1, starts="motion")
    assert screen(said)[:2] == (said, ())


def test_a_run_that_moves_between_its_first_sample_and_its_first_step_is_left_out() -> None:
    run = WHOLE.experiments[1]
    level = np.where(run.time > 1.0, run.input, 0.0)  # the step is written down too late
    screened = screen(changed(WHOLE, 1, input=level))
    assert "in which the cart already moves" in screened.notes[0]
    assert "Run 'case 2'" in screened.notes[0]


def test_a_late_drive_is_not_asleep_where_steps_end_in_the_swing() -> None:
    """A cart that rings answers a step at once, whatever its drive does: only steps from rest tell how late it is."""
    plant, time = Plant(1.0, 400.0, 2.0), np.arange(3000) * 1e-3
    runs = []
    for i, added in enumerate((0.0, 0.5, 1.0, 1.5)):
        period = 2 * np.pi / plant.rates(added)[1]
        steps = ((0.2, 0.5), (0.2 + 3 * period, -0.5))
        level = sum(size * (time >= start) for start, size in steps)
        late = plant.response(time - 0.1 * period, added, steps)
        reading = late + 2e-6 * np.random.default_rng(i).standard_normal(time.size)
        runs.append(
            stepid.Experiment(
                name=f"run {i}", time=time, position=reading, input=level, added_mass=added, spring="s", damper="d"
            )
        )
    screened = screen(stepid.Campaign(name="late", experiments=runs))
    assert screened.notes == ()
    assert len(screened.campaign.experiments) == 4


def test_good_campaigns_are_not_touched() -> None:
    for whole in (WHOLE, campaign(2, FRICTION), campaign(3, {"free_play": {"gap": 1e-3}})):
        assert screen(whole) == (whole, (), (), {})
    lab = stepid.datasets.lab_campaign()
    assert screen(lab) == (lab, (), (), {})


def cut(samples: int, first: int = 0, **fields: Any) -> stepid.Campaign:
    part = slice(first, first + samples)
    return with_fields(**{n: lambda e, n=n: getattr(e, n)[part] for n in ("time", "position", "input")}, **fields)


def test_twenty_samples_give_wide_uncertainties() -> None:
    few, many = stepid.fit(cut(20)), stepid.fit(WHOLE)
    for name in ("base_mass", "stiffness[medium]"):
        wide, narrow = few.parameters[name].parts.get("noise"), many.parameters[name].parts["noise"]
        assert wide is None or wide > 10 * narrow


def test_too_few_samples_for_the_noise_are_refused() -> None:
    with pytest.raises(UndeterminedError, match=r"too few samples to tell the noise.*counts_per_meter"):
        stepid.fit(cut(12, 12, counts_per_meter=lambda e: None))


def test_a_fit_that_does_not_converge_says_so_with_the_best_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    def impatient(*args: Any, **options: Any) -> Any:
        return minimize(*args, **(options | {"iterations": 1}))

    whole = campaign(6, FRICTION)
    best = stepid.fit(whole, effects=("coulomb_friction",))
    assert best.converged
    monkeypatch.setattr(search, "minimize", impatient)
    found = stepid.fit(whole, effects=("coulomb_friction",))
    assert not found.converged
    assert "The fit did not converge; what is shown is the best so far." in found.notes
    assert 0.999 * best.rms < found.rms < 0.1 * stepid.fit(whole).rms
    assert found.parameters["coulomb_friction.level"].value > 0


def test_a_trial_step_that_overflows_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = campaign(7, {"cubic_stiffness": {"coefficient": 6e4}})
    records = lay_out(whole)
    problem = build(records, resolve(["cubic_stiffness"]))
    rejected = []
    solve = type(problem.simulator).solve

    def watched(self: Any, shared: Any, local: Any, **options: Any) -> Any:
        found = solve(self, shared, local, **options)
        rejected.append(found is None)
        return found

    monkeypatch.setattr(type(problem.simulator), "solve", watched)
    start = np.array([0.95, 800.0, 7.0, 7.8, -9e4])  # much too stiff and softening: on the way the cart runs away
    found = minimize(problem, start, start_local(problem))
    assert found is not None
    assert np.isfinite(found.cost)
    assert found.shared[-1] == pytest.approx(6e4, rel=0.02)
    assert not rejected[0]
    assert any(rejected)


def test_a_badly_scaled_run_is_named_whatever_effect_is_fitted() -> None:
    found = stepid.fit(scaled(campaign(9, FRICTION), 3, 0.5), effects=("viscoelastic_spring",))
    assert any("Run 'case 4' disagrees" in note and "readings are 0.5 times" in note for note in found.notes), (
        found.notes
    )
